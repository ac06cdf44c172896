//! Readiness, the listener for operation, and how a server ends behind a load balancer.

use std::net::SocketAddr;

use crate::harness::{CURVE, TestApp, ready, send};

fn with_operations_listener(settings: &mut flankfit::config::ServeSettings) {
    settings.ops_bind = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
}

#[tokio::test]
async fn readiness_and_metrics_have_a_listener_of_their_own() {
    let app = TestApp::start_with(with_operations_listener).await;
    let operation = app.operation.expect("a second listener");
    ready(&app.client.get(format!("http://{operation}/readyz"))).await;
    assert_eq!(send(app.get("/readyz")).await.status, 404);
    for (path, here, there) in [("/healthz", 200, 200), ("/metrics", 404, 200), ("/openapi.json", 200, 404)] {
        assert_eq!(send(app.get(path)).await.status, here, "{path}");
        assert_eq!(send(app.client.get(format!("http://{operation}{path}"))).await.status, there, "{path}");
    }
    let fit = app.client.post(format!("http://{operation}/v1/fits")).body(CURVE);
    send(fit).await.problem(404, "not_found");
    assert_eq!(app.fit(CURVE).await.status, 200);
    app.stop().await;
    assert!(tokio::net::TcpStream::connect(operation).await.is_err(), "it ends with the other");
}

#[tokio::test]
async fn the_parameter_of_readiness_is_checked() {
    let app = TestApp::start().await;
    assert_eq!(send(app.get("/readyz?for=compute")).await.status, 200);
    for wrong in ["/readyz?for=store", "/readyz?for=", "/readyz?for=Compute"] {
        assert_eq!(send(app.get(wrong)).await.pointers(), ["/for"], "{wrong}");
    }
    assert_eq!(send(app.get("/readyz?of=compute")).await.pointers(), ["/of"]);
}

#[tokio::test]
async fn a_draining_server_responds_and_closes_connections() {
    let app = TestApp::start_with(|settings| {
        // as long as a busy machine may take for what is asked meanwhile
        settings.drain_delay = 10;
        with_operations_listener(settings);
    })
    .await;
    let operation = app.operation.expect("a second listener");
    assert_eq!(app.fit(CURVE).await.header("connection"), "");
    let asks = |path: &str| app.client.get(format!("http://{operation}/readyz{path}"));
    let (every, compute) = (asks(""), asks("?for=compute"));
    ready(&every).await;
    let stopping = app.begin_stop();
    // the store may be slow before that, too
    while !send(every.try_clone().unwrap()).await.text.contains("\"draining\"") {
        tokio::task::yield_now().await;
    }
    send(every).await.problem(503, "draining");
    send(compute).await.problem(503, "draining");
    // new connections are taken, and end with their answer
    for _ in 0..3 {
        let request = stopping.client.post(format!("http://{}/v1/fits", stopping.address)).body(CURVE);
        let answer = send(request.header("content-type", "application/json")).await;
        assert_eq!(answer.status, 200);
        assert_eq!(answer.header("connection"), "close");
    }
    assert_eq!(send(stopping.client.get(format!("http://{operation}/metrics"))).await.status, 200);
    stopping.server.await.unwrap();
    assert!(tokio::net::TcpStream::connect(stopping.address).await.is_err());
}
