//! A server that requires no key, before and after the first one is created.

use flankfit::config::{Authentication, ServeSettings};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{
    database::{self, is_postgres},
    harness::{Answer, CURVE, TestApp, ready, send},
    heard::Heard,
    program::program,
};

async fn start_in(folder: TempDir) -> TestApp {
    let url = database::in_file(&folder.path().join("test.db"));
    let auto = |settings: &mut ServeSettings| {
        settings.auth = Authentication::Auto;
        settings.database_url = url;
    };
    TestApp::start_in(folder, auto).await
}

async fn post(app: &TestApp, path: &str, body: &Value) -> Answer {
    send(app.post(path, body.to_string())).await
}

/// PostgreSQL is shared by several servers, which require keys from the start.
#[tokio::test]
async fn a_shared_store_asks_for_keys_at_once() {
    if !is_postgres() {
        return;
    }
    let app = TestApp::start_with(|settings| settings.auth = Authentication::Auto).await;
    send(app.get("/v1/whoami")).await.problem(401, "unauthorized");
    post(&app, "/v1/keys", &json!({"name": "first", "role": "admin"})).await.problem(401, "unauthorized");
    app.stop().await;
}

/// The examples that /docs offers to send lock nobody out of a new server.
#[tokio::test]
async fn the_first_key_over_http_is_an_administrators_and_shuts_nobody_out() {
    let folder = tempfile::tempdir().unwrap();
    let app = start_in(folder).await;
    let document = send(app.get("/openapi.json")).await.json();
    let example = |schema: &str| document["components"]["schemas"][schema]["example"].clone();
    let not_first = |answer: &Answer| {
        let detail = answer.problem(409, "first_key_must_be_admin")["detail"].clone();
        assert!(detail.as_str().unwrap().contains("POST /v1/keys"), "{detail}");
    };
    assert_eq!(example("NewKey")["role"], "operator");
    not_first(&post(&app, "/v1/keys", &example("NewKey")).await);
    not_first(&post(&app, "/v1/tenants", &example("NewTenant")).await);
    not_first(&post(&app, "/v1/keys", &json!({"name": "n", "scopes": ["read", "audit", "admin"]})).await);
    let certificate = json!({"name": "n", "role": "admin", "kind": "certificate", "san": "press7.plant.example"});
    not_first(&post(&app, "/v1/keys", &certificate).await);
    assert_eq!(send(app.get("/v1/keys")).await.json()["items"], json!([]), "nothing was stored");

    let (heard, while_heard) = Heard::here();
    let first = post(&app, "/v1/keys", &json!({"name": "first", "role": "admin"})).await;
    let said = heard.take();
    drop(while_heard);
    assert_eq!(first.status, 201, "{}", first.text);
    let key = first.json()["key"].as_str().unwrap().to_owned();
    assert_eq!(first.json()["warnings"][0]["code"], "first_key");
    assert!(first.json()["warnings"][0]["message"].as_str().unwrap().contains("after a restart"), "{}", first.text);
    assert!(said.contains("WARN") && said.contains("after a restart") && !said.contains(&key[21..85]), "{said}");
    // requests without a key are still accepted, and further keys and tenants may be of any kind
    for (path, body) in [("/v1/keys", example("NewKey")), ("/v1/tenants", example("NewTenant"))] {
        let made = post(&app, path, &body).await;
        assert_eq!((made.status.as_u16(), made.json().get("warnings")), (201, None), "{}", made.text);
    }
    assert_eq!(send(app.get("/v1/whoami")).await.json()["actor"], "anonymous");
    assert_eq!(app.fit(CURVE).await.status, 200);
    assert_eq!(send(app.get("/healthz")).await.json()["key_required"], false);

    let app = start_in(app.stop().await).await;
    assert_eq!(send(app.get("/healthz")).await.json()["key_required"], true);
    app.fit(CURVE).await.problem(401, "unauthorized");
    let who = send(app.get("/v1/whoami").bearer_auth(&key)).await.json();
    assert_eq!((&who["role"], &who["key_name"]), (&"admin".into(), &"first".into()));
    let more = app.post("/v1/keys", r#"{"name":"second","role":"engineer"}"#).bearer_auth(&key);
    assert_eq!(send(more).await.status, 201);
    ready(&app.get("/readyz")).await;
    for path in ["/openapi.json", "/docs/"] {
        assert_eq!(send(app.get(path)).await.status, 200, "{path}");
    }
    app.stop().await;
}

/// The recovery described in docs/how-to/security.md, and the effect of the command line on a
/// running server.
#[tokio::test]
async fn the_command_line_makes_a_key_after_a_lockout() {
    let folder = tempfile::tempdir().unwrap();
    let url = database::in_file(&folder.path().join("test.db"));
    let create = |role: &'static str| {
        let arguments = ["keys", "create", "--database-url", &url, "--tenant", "default", "--role", role];
        program(&arguments, &[])
    };
    // a running server has exclusive use of the file, and still requires no key
    let app = start_in(folder).await;
    let (code, key, said) = create("reader");
    assert!(code != Some(0) && key.is_empty() && said.contains("in use"), "{said}");
    assert_eq!(app.fit(CURVE).await.status, 200);
    let folder = app.stop().await;

    let (code, _lost, said) = create("reader");
    assert_eq!(code, Some(0), "{said}");
    let app = start_in(folder).await;
    app.fit(CURVE).await.problem(401, "unauthorized");
    let folder = app.stop().await;
    let (code, key, said) = create("admin");
    assert_eq!(code, Some(0), "{said}");
    let app = start_in(folder).await;
    let who = send(app.get("/v1/whoami").bearer_auth(key.trim())).await.json();
    assert_eq!((&who["role"], &who["tenant"]), (&"admin".into(), &"default".into()));
    app.stop().await;
}
