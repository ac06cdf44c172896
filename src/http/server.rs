//! Connections: accepted, served, and at the end finished within a grace.
//!
//! Beside what `axum::serve` does, a client that opens a connection and sends its request's head drop by drop (or
//! nothing more) is let go after a while, and a shutdown has a bound.

use std::{convert::Infallible, io, time::Duration};

use axum::{Router, body::Body, extract::Request, response::Response};
use hyper::{body::Incoming, server::conn::http1};
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    service::TowerToHyperService,
};
use tokio::{
    net::{TcpListener, TcpStream},
    sync::watch,
};
use tower::{Service, ServiceExt};

/// How long a connection may wait for the (rest of the) head of its next request.
const HEAD_TIMEOUT: Duration = Duration::from_secs(75);

/// Pause after an error of accepting that lasts, such as too many open files.
const ACCEPT_PAUSE: Duration = Duration::from_millis(250);

/// Serves until `stop` is ready, then closes idle connections, lets requests under way be answered, and returns
/// when all are done or `grace` is over.
pub async fn serve(listener: TcpListener, router: Router, stop: impl Future<Output = ()>, grace: Duration) {
    let (stopping, stopped) = watch::channel(());
    let (done, open) = watch::channel(());
    let mut stop = std::pin::pin!(stop);
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = &mut stop => break,
        };
        match accepted {
            Ok((stream, _)) => {
                tokio::spawn(connection(stream, router.clone(), stopped.clone(), open.clone()));
            }
            Err(error) if is_of_one_connection(&error) => {}
            Err(error) => {
                tracing::error!(%error, "cannot accept connections");
                tokio::time::sleep(ACCEPT_PAUSE).await;
            }
        }
    }
    drop(listener);
    drop((router, open));
    drop(stopping);
    tracing::info!(connections = done.receiver_count(), "stopping: finishing what was accepted");
    if tokio::time::timeout(grace, done.closed()).await.is_err() {
        tracing::warn!(
            connections = done.receiver_count(),
            ?grace,
            "the shutdown grace is over; requests were cut off"
        );
    }
}

fn is_of_one_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

/// `_open` is dropped when the connection has ended, which the server waits for.
async fn connection(stream: TcpStream, router: Router, mut stopped: watch::Receiver<()>, _open: watch::Receiver<()>) {
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!(%error, "TCP_NODELAY refused");
    }
    let service = TowerToHyperService::new(service(router));
    let mut builder = http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(HEAD_TIMEOUT);
    let mut connection = std::pin::pin!(builder.serve_connection(TokioIo::new(stream), service).with_upgrades());
    let outcome = tokio::select! {
        outcome = connection.as_mut() => outcome,
        // The sender is only ever dropped.
        _ = stopped.changed() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = outcome {
        tracing::debug!(%error, "a connection ended early");
    }
}

type Answer<S> = <S as Service<Request>>::Future;

/// The router for requests as hyper gives them.
fn service(
    router: Router,
) -> impl Service<hyper::Request<Incoming>, Response = Response, Error = Infallible, Future = Answer<Router>>
+ Clone
+ Send
+ 'static {
    router.map_request(|request: hyper::Request<Incoming>| request.map(Body::new))
}
