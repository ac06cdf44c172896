//! `flankfit healthcheck`: which listener it asks, and how.

use std::net::SocketAddr;

use flankfit::config::{ClientAuthentication, ServeSettings};

use super::tls::Authority;
use crate::{harness::TestApp, program::program};

/// Nobody listens there.
const NOBODY: &str = "127.0.0.1:1";

fn with_operations_listener(settings: &mut ServeSettings) {
    settings.ops_bind = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
}

/// The exit code and what is said, within this environment. A busy machine has its time.
fn check(environment: &[(&str, &str)]) -> (Option<i32>, String) {
    let (code, out, said) = program(&["healthcheck", "--timeout", "60"], environment);
    assert_eq!(out, "");
    (code, said)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_operations_listener_is_checked_if_there_is_one() {
    let app = TestApp::start_with(with_operations_listener).await;
    let (here, operation) = (app.address.to_string(), app.operation.unwrap().to_string());
    let healthy = (Some(0), String::new());
    assert_eq!(check(&[("FLANKFIT_BIND", &*here)]), healthy);
    assert_eq!(check(&[("FLANKFIT_BIND", &*here), ("FLANKFIT_OPS_BIND", &*operation)]), healthy);
    // it, and not the other one
    assert_eq!(check(&[("FLANKFIT_BIND", NOBODY), ("FLANKFIT_OPS_BIND", &*operation)]), healthy);
    let (code, said) = check(&[("FLANKFIT_BIND", &*here), ("FLANKFIT_OPS_BIND", NOBODY)]);
    assert!(code == Some(1) && said.contains(&format!("no server answers at {NOBODY}")), "{code:?} {said}");
    // by flags as well
    let (code, _, said) = program(&["healthcheck", "--bind", &here, "--ops-bind", NOBODY], &[]);
    assert!(code == Some(1) && said.contains(NOBODY), "{code:?} {said}");
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_tls_server_is_checked_over_tls() {
    let authority = Authority::new();
    let certificate = authority.file("cert.pem").display().to_string();
    let app = TestApp::start_with(|settings| authority.serve(settings)).await;
    let here = app.address.to_string();
    let by_tls = |address: &str| check(&[("FLANKFIT_BIND", address), ("FLANKFIT_TLS_CERT", &*certificate)]);
    assert_eq!(by_tls(&here), (Some(0), String::new()));
    let (code, said) = check(&[("FLANKFIT_BIND", &*here)]);
    assert!(code == Some(1) && said.contains(&format!("no server answers at {here}")), "{code:?} {said}");
    app.stop().await;
    let plain = TestApp::start().await;
    let (code, said) = by_tls(&plain.address.to_string());
    assert!(code == Some(1) && said.contains("by TLS"), "{code:?} {said}");
    plain.stop().await;
}

/// Who has no certificate to show asks the other listener, which speaks plain HTTP.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn with_client_certificates_the_operations_listener_is_checked() {
    let authority = Authority::new();
    let certificate = authority.file("cert.pem").display().to_string();
    let app = TestApp::start_with(|settings| {
        authority.serve(settings);
        settings.tls.client_authorities = Some(authority.file("ca.pem"));
        settings.tls.client_authentication = ClientAuthentication::Required;
        with_operations_listener(settings);
    })
    .await;
    let (here, operation) = (app.address.to_string(), app.operation.unwrap().to_string());
    let main = [("FLANKFIT_BIND", &*here), ("FLANKFIT_TLS_CERT", &*certificate)];
    let (code, said) = check(&main);
    assert!(code == Some(1) && said.contains("--ops-bind"), "{code:?} {said}");
    let both = [main[0], main[1], ("FLANKFIT_OPS_BIND", &*operation)];
    assert_eq!(check(&both), (Some(0), String::new()));
    app.stop().await;
}
