//! The dashboard as it is served: its pages, its files and what they may weigh. What it does in a
//! browser is tested by `web/check`.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use flankfit::http::dashboard::PAGES;
use regex_lite::Regex;

use crate::harness::{Answer, TestApp, send};

/// Bytes as gzip and requests of a first view, and bytes of the 3-D library and of everything.
const FIRST_VIEW: (usize, usize) = (150_000, 60);
const THREE: usize = 160_000;
const EVERYTHING: usize = 2_000_000;
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
    worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; \
    require-trusted-types-for 'script'; trusted-types assets";

fn web() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("web")
}

/// Every file below a folder of `web/` that is embedded, by its name there.
fn embedded() -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![web().join("app"), web().join("vendor")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(web()).unwrap().to_str().unwrap().replace('\\', "/");
            if path.is_dir() {
                folders.push(path);
            } else if !name.ends_with(".d.ts") {
                files.insert(name, fs::read(path).unwrap());
            }
        }
    }
    files
}

async fn digest(app: &TestApp) -> String {
    let page = send(app.get("/")).await.text;
    page.split("/assets/").nth(1).unwrap().split('/').next().unwrap().to_owned()
}

#[tokio::test]
async fn every_page_is_the_one_document() {
    let app = TestApp::start().await;
    let root = send(app.get("/")).await;
    assert!(root.text.contains("<div id=\"app\">") && !root.text.contains("{digest}"), "{}", root.text);
    for path in PAGES {
        let path = path.replace("{job_id}", "0190b0de-0000-7000-8000-000000000000").replace("{number}", "1");
        let path = path.replace("{stream_id}", "0190b0de-0000-7000-8000-000000000000");
        assert!(!path.contains('{'), "{path}");
        let page = send(app.get(&path)).await;
        assert_eq!((page.status.as_u16(), &page.text), (200, &root.text), "{path}");
        for (name, value) in [
            ("content-type", "text/html; charset=utf-8"),
            ("content-security-policy", POLICY),
            ("cache-control", "no-cache"),
            ("cross-origin-opener-policy", "same-origin"),
            ("x-content-type-options", "nosniff"),
            ("referrer-policy", "no-referrer"),
        ] {
            assert_eq!(page.header(name), value, "{path}");
        }
        let again = send(app.get(&path).header("if-none-match", page.header("etag"))).await;
        assert_eq!((again.status.as_u16(), again.text.as_str()), (304, ""), "{path}");
        let head = send(app.client.head(app.url(&path))).await;
        assert_eq!((head.status.as_u16(), head.text.as_str(), head.header("etag")), (200, "", page.header("etag")));
    }
    for path in ["/nothing", "/jobs/", "/jobs/new/", "/index.html", "/app/main.js", "/assets", "/assets/"] {
        send(app.get(path)).await.problem(404, "not_found");
        // a browser gets the page that says so, with a way back
        let page = send(app.get(path).header("accept", "text/html,application/xhtml+xml,*/*;q=0.8")).await;
        assert_eq!((page.status.as_u16(), &page.text), (404, &root.text), "{path}");
    }
    let interface = app.get("/v1/nothing").header("accept", "text/html");
    send(interface).await.problem(404, "not_found");
    send(app.post("/jobs", "{}")).await.problem(405, "method_not_allowed");
}

#[tokio::test]
async fn files_are_kept_for_good_under_their_digest() {
    let app = TestApp::start().await;
    let digest = digest(&app).await;
    assert!(digest.len() == 64 && digest.bytes().all(|byte| byte.is_ascii_hexdigit()), "{digest}");
    let files = embedded();
    assert!(files.len() > 30, "{}", files.len());
    for (name, bytes) in &files {
        let path = format!("/assets/{digest}/{name}");
        let answer = send(app.get(&path)).await;
        assert_eq!((answer.status.as_u16(), answer.text.as_bytes()), (200, &bytes[..]), "{name}");
        assert_eq!(answer.header("cache-control"), "public, max-age=31536000, immutable", "{name}");
        assert_eq!(answer.header("content-security-policy"), POLICY, "{name}");
        let media = match name.rsplit('.').next().unwrap() {
            "js" => "text/javascript; charset=utf-8",
            "css" => "text/css; charset=utf-8",
            "svg" => "image/svg+xml",
            "txt" => "text/plain; charset=utf-8",
            other => panic!("{name}: is {other} meant to be embedded?"),
        };
        assert_eq!(answer.header("content-type"), media, "{name}");
        let again = send(app.get(&path).header("if-none-match", answer.header("etag"))).await;
        assert_eq!(again.status, 304, "{name}");
    }
    let packed = app.get(&format!("/assets/{digest}/vendor/ui.js")).header("accept-encoding", "gzip, zstd");
    let packed = packed.send().await.unwrap();
    assert_eq!(packed.headers()["content-encoding"], "gzip");
    assert!(packed.headers().get_all("vary").iter().any(|named| named == "accept-encoding"));
    assert!(packed.bytes().await.unwrap().len() < files["vendor/ui.js"].len() / 2);
    let other = "0".repeat(64);
    let away = send(app.get(&format!("/assets/{other}/app/main.js"))).await;
    assert!(away.problem(404, "not_found")["detail"].as_str().unwrap().contains("load the page again"));
    assert_eq!(away.header("cache-control"), "no-store");
    for name in ["app/nothing.js", "index.html", "app/../index.html", "app/api/schema.d.ts", "test/x.js"] {
        send(app.get(&format!("/assets/{digest}/{name}"))).await.problem(404, "not_found");
    }
}

#[tokio::test]
async fn without_a_dashboard_the_documentation_is_first() {
    let app = TestApp::start_with(|settings| settings.dashboard = false).await;
    let client = reqwest::Client::builder().no_proxy().redirect(reqwest::redirect::Policy::none()).build().unwrap();
    let answer = Answer::read(client.get(app.url("/")).send().await.unwrap()).await;
    assert_eq!((answer.status.as_u16(), answer.header("location")), (307, "/docs/"));
    send(app.get("/jobs")).await.problem(404, "not_found");
    let neither = TestApp::start_with(|settings| {
        settings.dashboard = false;
        settings.docs = false;
    });
    send(neither.await.get("/")).await.problem(404, "not_found");
}

#[tokio::test]
async fn a_folder_is_read_at_every_request() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    put("index.html", "<script src=\"/assets/{digest}/app/main.js\"></script>");
    put("app/main.js", "first");
    let app = TestApp::start_with(|settings| settings.dashboard_dir = Some(folder.path().into())).await;
    let page = send(app.get("/jobs")).await;
    let path = page.text.split('"').nth(1).unwrap().to_owned();
    let first = send(app.get(&path)).await;
    assert_eq!((first.text.as_str(), first.header("cache-control")), ("first", "no-cache"));
    put("app/main.js", "second");
    let second = send(app.get(&path).header("if-none-match", first.header("etag"))).await;
    assert_eq!((second.status.as_u16(), second.text.as_str()), (200, "second"));
}

/// The dashboard knows exactly the paths that the server serves.
#[test]
fn the_router_has_the_same_pages() {
    let router = fs::read_to_string(web().join("app/router.js")).unwrap();
    let entry = Regex::new(r#"\{ path: "([^"]+)", page: "([^"]+)" \}"#).unwrap();
    let there: BTreeSet<String> = entry.captures_iter(&router).map(|found| found[1].to_owned()).collect();
    // what leads to the list of jobs
    let all: BTreeSet<String> = there.into_iter().chain(["/".to_owned()]).collect();
    assert_eq!(all, PAGES.iter().map(|path| (*path).to_owned()).collect());
    for found in entry.captures_iter(&router) {
        let module = web().join("app/pages").join(format!("{}.js", &found[2]));
        assert!(module.is_file(), "{}", module.display());
    }
}

#[test]
fn scripts_are_plain() {
    let foreign = Regex::new(r"https?://[^\s]*").unwrap();
    for (name, bytes) in embedded().into_iter().filter(|(name, _)| name.starts_with("app/")) {
        let text = String::from_utf8(bytes).unwrap();
        for word in ["eval(", "innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "new Function"] {
            assert!(!text.contains(word), "{name}: {word}");
        }
        for address in foreign.find_iter(&text) {
            assert!(address.as_str().starts_with("http://www.w3.org/"), "{name}: {}", address.as_str());
        }
    }
}

#[test]
fn a_first_view_is_light() {
    let files = embedded();
    let mut seen: BTreeSet<String> = BTreeSet::new();
    let index = fs::read_to_string(web().join("index.html")).unwrap();
    let mut open: Vec<String> = index.split("/assets/{digest}/").skip(1).map(until_quote).collect();
    open.push("app/pages/jobs.js".into());
    let import = Regex::new(r#"(?:from|import) ?"(\.[^"]+)""#).unwrap();
    while let Some(name) = open.pop() {
        let bytes = files.get(&name).unwrap_or_else(|| panic!("{name} is not there"));
        if !seen.insert(name.clone()) || !name.ends_with(".js") || name.starts_with("vendor/") {
            continue;
        }
        let text = String::from_utf8_lossy(bytes);
        open.extend(import.captures_iter(&text).map(|found| resolved(&name, &found[1])));
    }
    let weight: usize = seen.iter().map(|name| gzip(&files[name])).sum();
    println!("first view: {} files, {weight} bytes as gzip", seen.len());
    assert!(seen.contains("vendor/ui.js") && seen.contains("app/api/client.js"), "{seen:?}");
    // and the page itself and its first response
    assert!(weight + gzip(index.as_bytes()) <= FIRST_VIEW.0 && seen.len() + 2 <= FIRST_VIEW.1, "{seen:?}");
    assert!(!seen.contains("vendor/three.js"));
    assert!(gzip(&files["vendor/three.js"]) <= THREE);
    assert!(files.values().map(Vec::len).sum::<usize>() <= EVERYTHING);
}

fn until_quote(text: &str) -> String {
    text.split('"').next().unwrap().to_owned()
}

/// Path that an import names, resolved from its file.
fn resolved(from: &str, import: &str) -> String {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in import.split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

fn gzip(bytes: &[u8]) -> usize {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap().len()
}
