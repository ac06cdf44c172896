//! Secrets in files that `…_FILE` names.

use std::{fs, path::Path};

use sha2::Digest as _;

use super::{collector::Collector, talkative::Talkative};
use crate::{database::in_file, program::program};

fn written(folder: &Path, name: &str, text: &str) -> String {
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_server_reads_its_secrets_from_files() {
    const HEADER: &str = "canary-3141592653";
    let folder = tempfile::tempdir().unwrap();
    let database = folder.path().join("test.db");
    let url = written(folder.path(), "url", &format!("{}\n", in_file(&database)));
    let make = ["keys", "create", "--tenant", "default", "--role", "admin"];
    let (code, made, said) = program(&make, &[("FLANKFIT_DATABASE_URL_FILE", &*url)]);
    assert!(code == Some(0) && database.exists(), "{said}");
    let digest: String = sha2::Sha256::digest(b"listed").iter().map(|byte| format!("{byte:02x}")).collect();
    let keys = written(folder.path(), "keys", &format!("{digest}\r\n"));
    let headers = written(folder.path(), "headers", &format!("x-collector-key={HEADER}\n"));
    let collector = Collector::start();
    let environment = [("FLANKFIT_API_KEYS_SHA256_FILE", &*keys), ("OTEL_EXPORTER_OTLP_HEADERS_FILE", &*headers)];
    let server = Talkative::within(&environment, &database, &["--otlp-endpoint", &collector.url, "--otlp-sample", "1"]);
    let client = reqwest::Client::new();
    for (key, role) in [("listed", "engineer"), (made.trim(), "admin")] {
        let answer = client.get(format!("{}/v1/whoami", server.base)).bearer_auth(key).send().await.unwrap();
        let (status, text) = (answer.status(), answer.text().await.unwrap());
        assert!(status == 200 && text.contains(role), "{text}");
    }
    collector.until(|spans| spans.iter().any(|span| span.name == "GET /v1/whoami")).await;
    let said = server.end();
    let heads = collector.heads();
    assert!(!heads.is_empty() && heads.iter().all(|head| head.contains(&format!("x-collector-key: {HEADER}\r\n"))));
    assert!(!said.contains(HEADER) && !said.contains(&digest), "{said}");
}

#[test]
fn a_secret_comes_from_one_place_and_its_file_is_readable() {
    let folder = tempfile::tempdir().unwrap();
    let canary = "sqlite:///nowhere/canary.db";
    let file = written(folder.path(), "url", canary);
    let missing = folder.path().join("missing");
    let missing = missing.to_str().unwrap();
    let binary = folder.path().join("binary");
    fs::write(&binary, b"canary\xff").unwrap();
    let binary = binary.to_str().unwrap();
    let to = folder.path().join("to");
    let to = to.to_str().unwrap();
    for arguments in [
        &["serve"][..],
        &[],
        &["backup", to],
        &["export", to],
        &["import", to],
        &["migrate"],
        &["audit", "verify"],
        &["keys", "create", "--role", "root"],
    ] {
        let refused = |environment: &[(&str, &str)]| {
            let (code, out, said) = program(arguments, environment);
            assert_eq!((code, out.as_str(), said.lines().count()), (Some(2), "", 1), "{arguments:?}: {said}");
            assert!(!said.contains("canary"), "{said}");
            said
        };
        let both = refused(&[("FLANKFIT_DATABASE_URL", canary), ("FLANKFIT_DATABASE_URL_FILE", &*file)]);
        assert!(both.contains("FLANKFIT_DATABASE_URL and FLANKFIT_DATABASE_URL_FILE are both set"), "{both}");
        for path in [missing, binary] {
            let unreadable = refused(&[("FLANKFIT_DATABASE_URL_FILE", path)]);
            assert!(unreadable.contains(path) && unreadable.contains("FLANKFIT_DATABASE_URL_FILE"), "{unreadable}");
        }
    }
    // what needs none of it is not held up
    assert_eq!(program(&["openapi"], &[("FLANKFIT_DATABASE_URL_FILE", missing)]).0, Some(0));
    let (code, help, _) = program(&["migrate", "--help"], &[("FLANKFIT_DATABASE_URL_FILE", missing)]);
    assert!(code == Some(0) && help.contains("FLANKFIT_DATABASE_URL_FILE"), "{help}");
}
