//! Operations that each role may request: every cell of the table, by the document.

use std::collections::BTreeMap;

use flankfit::{
    config::{Authentication, Digest, KeysRole},
    http::openapi::openapi_json,
    jobs::{Role, secret},
};
use reqwest::Method;
use serde_json::Value;

use super::keys::key_of;
use crate::harness::{TestApp, send};

const NOBODY: &str = "0190b0de-0000-7000-8000-000000000000";

/// The roles with their scopes, as they are promised.
const ROLES: [(&str, Role, &[&str]); 6] = [
    ("reader", Role::Reader, &["read", "compute"]),
    ("operator", Role::Operator, &["read", "compute", "measure"]),
    ("engineer", Role::Engineer, &["read", "compute", "measure", "decide"]),
    ("auditor", Role::Auditor, &["read", "audit"]),
    ("admin", Role::Admin, &["read", "audit", "admin"]),
    ("root", Role::Root, &["tenants"]),
];

/// Operations of the versioned interface: id, method, path and scope.
fn operations() -> Vec<(String, Method, String, String)> {
    let document: Value = serde_json::from_str(openapi_json()).unwrap();
    let mut all = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, declared) in item.as_object().unwrap() {
            let id = declared["operationId"].as_str().unwrap().to_owned();
            let scope = declared["x-required-scope"].as_str();
            assert_eq!(scope.is_some(), path.starts_with("/v1/"), "{id} declares one scope where it is versioned");
            if let Some(scope) = scope {
                all.push((id, method.to_uppercase().parse().unwrap(), path.clone(), scope.to_owned()));
            }
        }
    }
    assert!(all.len() > 50, "{}", all.len());
    all
}

/// The path of what is not there: who may ask hears so, and who may not hears that first.
fn of_nothing(path: &str) -> String {
    let ids = ["job_id", "stream_id", "fit_id", "record_id"];
    let path = ids.iter().fold(path.to_owned(), |path, id| path.replace(&format!("{{{id}}}"), NOBODY));
    let path = path.replace("{number}", "1").replace("{key_id}", "0123456789abcdef").replace("{tenant}", "nobody");
    assert!(!path.contains('{'), "{path}");
    // events of all jobs would come without end: after an id that is none there are none
    if path == "/v1/events" { format!("{path}?last_event_id=none") } else { path }
}

#[test]
fn operations_need_the_scope_of_their_effect() {
    let mut by_scope: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (id, method, _, scope) in operations() {
        assert!(scope != "read" || method == Method::GET, "{id} changes or computes something");
        assert!(method != Method::GET || scope != "compute", "{id}");
        assert!(scope != "compute" || method == Method::POST, "{id}");
        by_scope.entry(scope).or_default().push(id);
    }
    by_scope.values_mut().for_each(|ids| ids.sort_unstable());
    // what is not read and not computed is named once more, independently of the code
    let measure = [
        "add_stream_nodes",
        "connect_stream",
        "create_applied_changes",
        "create_gear_applied_changes",
        "create_iteration",
        "create_iteration_deviations",
        "create_iteration_evaluation",
        "create_iteration_pitch",
        "create_job",
        "create_stream",
        "delete_stream",
        "finish_stream",
        "import_iteration",
        "simulate_closed_loop",
    ];
    let judge = [
        "choose_fit",
        "create_gear_correction",
        "create_iteration_correction",
        "create_iteration_curve",
        "create_iteration_fit",
        "create_iteration_surface",
        "delete_job",
        "update_iteration",
        "update_job",
    ];
    let admin =
        ["archive_job", "create_key", "get_key", "list_keys", "purge_job", "revoke_key", "rotate_key", "update_key"];
    let tenants = ["create_tenant", "get_tenant", "list_tenants", "update_tenant"];
    assert_eq!(
        (&by_scope["admin"][..], &by_scope["tenants"][..]),
        (&admin.map(String::from)[..], &tenants.map(String::from)[..])
    );
    assert_eq!(by_scope["measure"], measure);
    assert_eq!(by_scope["decide"], judge);
    assert_eq!(by_scope["audit"], ["list_audit", "list_audit_seals", "verify_audit"]);
    assert!(by_scope["compute"].iter().all(|id| !id.starts_with("create_iteration") && !id.contains("stream")));
}

#[tokio::test]
async fn every_role_has_its_operations_and_no_other() {
    let operations = operations();
    let app = TestApp::start_with(|settings| settings.auth = Authentication::Required).await;
    let (mut granted, mut refused) = (0, 0);
    for (name, role, scopes) in ROLES {
        let key = key_of(&app, "default", role).await;
        for (id, method, path, scope) in &operations {
            let cell = format!("{name} × {id}");
            // neither a body nor a job is there: whether the caller may ask is said before
            let answer = send(app.client.request(method.clone(), app.url(&of_nothing(path))).bearer_auth(&key)).await;
            if scopes.contains(&scope.as_str()) {
                assert!(![401, 403].contains(&answer.status.as_u16()), "{cell}: {}", answer.text);
                granted += 1;
                continue;
            }
            let problem = answer.problem(403, "forbidden");
            let detail = problem["detail"].as_str().unwrap();
            assert!(detail.contains(&format!("the scope `{scope}`")), "{cell}: {detail}");
            assert_eq!(answer.header("www-authenticate"), "Bearer error=\"insufficient_scope\"", "{cell}");
            refused += 1;
        }
        // a GET without its body is a GET
        let head = send(app.client.head(app.url("/v1/jobs")).bearer_auth(&key)).await;
        assert_eq!(head.status, if scopes.contains(&"read") { 200 } else { 403 }, "{name}");
    }
    assert_eq!(granted + refused, ROLES.len() * operations.len());
    assert!(granted > 150 && refused > 150, "{granted} granted, {refused} refused");
    // a request for methods needs no key
    send(app.client.request(Method::OPTIONS, app.url("/v1/jobs"))).await.problem(405, "method_not_allowed");
    app.stop().await;
}

/// Keys of the settings have the role of `--api-keys-role`.
#[tokio::test]
async fn keys_of_the_settings_have_one_role() {
    for (role, name, may_store) in [(KeysRole::Reader, "reader", false), (KeysRole::default(), "engineer", true)] {
        let app = TestApp::start_with(|settings| {
            settings.api_keys_sha256 = vec![Digest(secret::digest(b"key"))];
            settings.api_keys_role = role;
        })
        .await;
        let stored = send(app.post("/v1/jobs", r#"{"name":"w"}"#).bearer_auth("key")).await;
        assert_eq!(stored.status, if may_store { 201 } else { 403 }, "{}", stored.text);
        let who = send(app.get("/v1/whoami").header("x-api-key", "key")).await.json();
        assert_eq!((&who["tenant"], &who["role"]), (&"default".into(), &name.into()));
        assert!(who["actor"].as_str().unwrap().starts_with("key-") && who.get("key_id").is_none(), "{who}");
        app.stop().await;
    }
}
