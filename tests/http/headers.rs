//! Headers of every response, conditional reads, and requests with inadmissible headers.

use crate::harness::{CURVE, TestApp, raw, send};

#[tokio::test]
async fn every_response_has_its_cache_and_security_headers() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", r#"{"name":"z52"}"#)).await;
    let place = job.header("location").to_owned();
    for (request, status, kept) in [
        (app.get("/healthz"), 200, "no-store"),
        (app.get("/metrics"), 200, "no-store"),
        (app.get("/nothing"), 404, "no-store"),
        (app.post("/v1/fits", CURVE), 200, "no-store"),
        (app.post("/v1/fits", "{"), 400, "no-store"),
        (app.post("/v1/jobs", r#"{"name":"z53"}"#), 201, "no-store"),
        (app.get(&place), 200, "private, no-cache"),
        (app.get("/openapi.json"), 200, "private, no-cache"),
        (app.get("/docs/"), 200, "private, no-cache"),
        (app.get("/docs/swagger-ui.css"), 200, "public, max-age=604800"),
    ] {
        let answer = Answered::of(request).await;
        assert_eq!(answer.status, status, "{}", answer.url);
        assert_eq!(answer.header("cache-control"), kept, "{}", answer.url);
        assert_eq!(answer.header("x-content-type-options"), "nosniff", "{}", answer.url);
        assert_eq!(answer.header("referrer-policy"), "no-referrer", "{}", answer.url);
        let page = answer.header("content-type").starts_with("text/html");
        let policy = answer.header("content-security-policy");
        assert!(
            policy.starts_with("default-src 'none'") && policy.contains("frame-ancestors 'none'"),
            "{}",
            answer.url
        );
        assert_eq!(policy.contains("script-src"), page, "{}", answer.url);
    }
}

/// An answer whose body may be of any kind.
struct Answered {
    url: String,
    status: u16,
    headers: reqwest::header::HeaderMap,
}

impl Answered {
    async fn of(request: reqwest::RequestBuilder) -> Self {
        let response = request.send().await.unwrap();
        Answered {
            url: response.url().to_string(),
            status: response.status().as_u16(),
            headers: response.headers().clone(),
        }
    }

    fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }
}

/// The page of the documentation needs no more than its policy allows: scripts are files of the
/// server, none is inline.
#[tokio::test]
async fn the_documentation_lives_within_its_policy() {
    let app = TestApp::start().await;
    let page = send(app.get("/docs/")).await;
    let policy = page.header("content-security-policy");
    assert!(policy.contains("default-src 'none'") && policy.contains("script-src 'self'"), "{policy}");
    assert!(policy.contains("frame-ancestors 'none'"), "{policy}");
    let scripts: Vec<_> =
        page.text.split("<script").skip(1).map(|rest| rest.split("</script>").next().unwrap()).collect();
    assert!(!scripts.is_empty());
    for script in scripts {
        let (tag, inside) = script.split_once('>').unwrap();
        assert!(tag.contains("src=\"./") && inside.trim().is_empty(), "{script}");
    }
    assert!(!page.text.contains("http://") && !page.text.contains("https://"), "{}", page.text);
}

#[tokio::test]
async fn a_read_whose_tag_is_known_is_304() {
    let app = TestApp::start().await;
    let place = send(app.post("/v1/jobs", r#"{"name":"z52"}"#)).await.header("location").to_owned();
    let iteration = send(app.post(&format!("{place}/iterations"), CURVE)).await.header("location").to_owned();
    for path in
        [place.clone(), iteration.clone(), format!("{iteration}/nodes"), "/openapi.json".into(), "/docs/".into()]
    {
        let whole = send(app.get(&path)).await;
        let tag = whole.header("etag").to_owned();
        assert!(!tag.is_empty(), "{path}");
        for seen in [tag.clone(), format!("W/{tag}"), format!("\"other\", {tag}"), "*".into()] {
            let answer = send(app.get(&path).header("if-none-match", &seen)).await;
            assert_eq!(answer.status, 304, "{path} {seen}");
            assert_eq!((answer.header("etag"), answer.text.as_str()), (tag.as_str(), ""), "{path}");
            assert_eq!(answer.header("content-type"), "", "{path}");
            assert_eq!(answer.header("cache-control"), "private, no-cache", "{path}");
            assert!(answer.headers.get_all("vary").iter().any(|named| named == "accept-encoding"), "{path}");
        }
        let answer = send(app.get(&path).header("if-none-match", "\"other\"")).await;
        assert_eq!((answer.status.as_u16(), &answer.text), (200, &whole.text), "{path}");
    }
    // a changed resource is returned in full, under its new tag
    let before = send(app.get(&place)).await.header("etag").to_owned();
    let patch = app.client.patch(app.url(&place)).header("content-type", "application/json").body(r#"{"name":"z53"}"#);
    assert_eq!(send(patch.header("if-none-match", &before)).await.status, 200, "only reads are left out");
    let answer = send(app.get(&place).header("if-none-match", &before)).await;
    assert_eq!(answer.status, 200);
    assert_ne!(answer.header("etag"), before);
    // a refusal stays one
    send(app.get("/v1/nothing").header("if-none-match", "*")).await.problem(404, "not_found");
}

#[tokio::test]
async fn a_request_names_its_host() {
    let app = TestApp::start().await;
    for (head, status) in [
        ("GET /healthz HTTP/1.1\r\nHost: localhost\r\n", "200"),
        ("GET /healthz HTTP/1.0\r\n", "200"),
        ("GET /healthz HTTP/1.1\r\n", "400"),
        ("GET /healthz HTTP/1.1\r\nHost: here\r\nHost: there\r\n", "400"),
    ] {
        let answer = raw(app.address, &format!("{head}Connection: close\r\n\r\n")).await;
        assert_eq!(answer.split(' ').nth(1), Some(status), "{head}\n{answer}");
        assert!(status == "200" || answer.contains("malformed_request"), "{answer}");
    }
}

#[tokio::test]
async fn other_character_sets_are_refused() {
    let app = TestApp::start().await;
    let post = |media: &str| send(app.client.post(app.url("/v1/fits")).header("content-type", media).body(CURVE));
    for media in ["application/json; charset=utf-8", "application/json;charset=\"UTF-8\"", "application/json; q=1"] {
        assert_eq!(post(media).await.status, 200, "{media}");
    }
    for media in ["application/json; charset=utf-16", "application/json;charset=ISO-8859-1"] {
        let answer = post(media).await;
        let body = answer.problem(415, "unsupported_media_type");
        assert!(body["detail"].as_str().unwrap().contains("charset"), "{body}");
    }
}
