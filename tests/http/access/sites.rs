//! Requests that browsers make for pages of other sites, and names that lead here.

use flankfit::config::{Digest, ServeSettings, parse_hosts, parse_origins};
use sha2::Digest as _;

use crate::harness::{Answer, CURVE, TestApp, send};

async fn for_page(app: &TestApp, site: &str, origin: &str) -> Answer {
    send(app.post("/v1/fits", CURVE).header("sec-fetch-site", site).header("origin", origin)).await
}

#[tokio::test]
async fn pages_of_other_sites_change_nothing() {
    let app = TestApp::start_with(|settings| {
        settings.cors_origins = parse_origins("https://cell.example").unwrap();
    })
    .await;
    for site in ["cross-site", "same-site", "", "same-origin, cross-site"] {
        let answer = for_page(&app, site, "https://evil.example").await;
        answer.problem(403, "cross_site");
    }
    // a page that was named, this server's own, somebody who typed the address, and no browser
    assert_eq!(for_page(&app, "cross-site", "https://cell.example").await.status, 200);
    for site in ["same-origin", "none"] {
        assert_eq!(for_page(&app, site, "http://localhost").await.status, 200, "{site}");
    }
    assert_eq!(send(app.post("/v1/fits", CURVE)).await.status, 200);
    // a browser that sends only `Origin`: a form needs no preflight, JSON does
    let form = async |origin: String| {
        let form = "--x\r\nContent-Disposition: form-data; name=\"none\"\r\n\r\n\r\n--x--\r\n";
        let asked =
            app.client.post(app.url("/v1/fits")).body(form).header("content-type", "multipart/form-data; boundary=x");
        send(asked.header("origin", origin)).await
    };
    form("https://evil.example".to_owned()).await.problem(403, "cross_site");
    form("null".to_owned()).await.problem(403, "cross_site");
    for origin in ["https://cell.example".to_owned(), format!("http://{}", app.address)] {
        assert_ne!(form(origin.clone()).await.status, 403, "{origin}");
    }
    let json = app.post("/v1/fits", CURVE).header("origin", "https://evil.example");
    assert_eq!(send(json).await.status, 200);
    // who reads sees nothing without CORS, and a link from elsewhere leads somewhere
    for path in ["/v1/jobs", "/jobs"] {
        assert_eq!(send(app.get(path).header("sec-fetch-site", "cross-site")).await.status, 200, "{path}");
    }
    app.stop().await;
}

async fn asked_for(app: &TestApp, host: &str) -> u16 {
    send(app.get("/v1/jobs").header("host", host)).await.status.as_u16()
}

#[tokio::test]
async fn an_open_local_server_accepts_only_local_host_names() {
    let app = TestApp::start_with(|_| {}).await;
    for host in ["localhost", "localhost:1234", "127.0.0.1:8080", "[::1]"] {
        assert_eq!(asked_for(&app, host).await, 200, "{host}");
    }
    for host in ["evil.example", "localhost.evil.example:8080", "192.168.0.1"] {
        let answer = send(app.get("/healthz").header("host", host)).await;
        answer.problem(421, "unknown_host");
    }
    app.stop().await;
}

#[tokio::test]
async fn named_hosts_are_served_and_a_key_makes_every_name_good() {
    let named =
        |hosts: &'static str| move |settings: &mut ServeSettings| settings.allowed_hosts = parse_hosts(hosts).unwrap();
    let app = TestApp::start_with(named("cell.example")).await;
    assert_eq!((asked_for(&app, "cell.example:8080").await, asked_for(&app, "localhost").await), (200, 421));
    app.stop().await;
    let app = TestApp::start_with(named("*")).await;
    assert_eq!(asked_for(&app, "evil.example").await, 200);
    app.stop().await;
    let app = TestApp::start_with(|settings| {
        settings.api_keys_sha256 = vec![Digest(sha2::Sha256::digest(b"key").into())];
    })
    .await;
    assert_eq!(asked_for(&app, "plant.example").await, 401);
    app.stop().await;
}

#[tokio::test]
async fn health_reports_body_limit_and_key_requirement() {
    let app = TestApp::start_with(|settings| settings.body_limit = 1_000_000).await;
    let health = send(app.get("/healthz")).await.json();
    assert_eq!((&health["body_limit_bytes"], &health["key_required"]), (&1_000_000.into(), &false.into()));
    app.stop().await;
    let app = TestApp::start_with(|settings| {
        settings.api_keys_sha256 = vec![Digest(sha2::Sha256::digest(b"key").into())];
    })
    .await;
    assert_eq!(send(app.get("/healthz")).await.json()["key_required"], true);
    app.stop().await;
}
