//! Connections: accepted, served, and at the end finished within a grace.
//!
//! Beside what `axum::serve` does, a client that sends no request, or takes no answer, is let go
//! after a while, idle connections give way to new clients, and a shutdown has a bound.

mod connections;
mod peer;
mod socket;
mod tls;
mod unread;

use std::{
    convert::Infallible,
    io,
    net::{IpAddr, SocketAddr},
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};

use axum::{
    Router,
    body::{Body, Bytes, HttpBody},
    http::{HeaderValue, StatusCode, header},
    response::Response,
};
use hyper::{
    body::{Frame, Incoming, SizeHint},
    server::conn::http1,
    service::service_fn,
};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::{
    io::{AsyncRead, AsyncWrite},
    net::{TcpListener, TcpStream},
    sync::watch,
};
use tower::ServiceExt;

use self::{
    connections::{ConnectionSlot, Connections, Phase},
    socket::Socket,
    unread::Unread,
};
use super::state::AppState;

pub use self::{
    peer::{Peer, PeerNames},
    tls::Tls,
};

/// How long a connection may be idle between two requests.
const IDLE: Duration = Duration::from_secs(75);

/// Pause after an error of accepting that lasts, such as too many open files.
const ACCEPT_PAUSE: Duration = Duration::from_millis(250);

/// Browsers that have been here once come by TLS alone, for a year.
const HSTS: HeaderValue = HeaderValue::from_static("max-age=31536000");

/// The connection has a slot reserved for checks: nothing else is answered there (a request
/// extension).
#[derive(Clone, Copy, Debug)]
pub struct ForChecks;

/// The service of a listener.
pub struct Service {
    pub router: Router,
    pub state: AppState,
    pub tls: Option<Arc<Tls>>,
}

/// Limits of the connections of a server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Connections at a time.
    pub connections: usize,
    /// How long a client may take nothing of its answer.
    pub write_timeout: Duration,
    /// How long a shutdown waits for what was accepted.
    pub grace: Duration,
}

/// Handles that are not for connections: files and locks of the store, logs, the listener.
pub const KEPT_HANDLES: u64 = 64;

/// So many connections, or fewer where the system gives fewer handles.
pub fn connections(wanted: usize) -> usize {
    #[cfg(unix)]
    if let Some(handles) = rustix::process::getrlimit(rustix::process::Resource::Nofile).current {
        let most = usize::try_from(handles.saturating_sub(KEPT_HANDLES)).unwrap_or(usize::MAX).max(1);
        if most < wanted {
            tracing::warn!(handles, wanted, most, "connection limit lowered: the limit on open files is too low");
        }
        return wanted.min(most);
    }
    wanted
}

/// Serves until `stop` is ready, then closes idle connections, lets requests under way be answered,
/// and returns when all are done or the grace is over.
pub async fn serve(listener: TcpListener, service: Service, stop: impl Future<Output = ()>, limits: Limits) {
    let (stopping, stopped) = watch::channel(());
    let (done, open) = watch::channel(());
    let connections = Connections::new(limits.connections);
    let service = Arc::new(service);
    let mut stop = std::pin::pin!(stop);
    loop {
        let accepted = tokio::select! {
            accepted = accept(&listener, &connections) => accepted,
            () = &mut stop => break,
        };
        match accepted {
            Ok((stream, address)) => {
                let client = Client {
                    service: Arc::clone(&service),
                    slot: Arc::new(connections.enter()),
                    address: address.ip(),
                    names: None,
                    write_timeout: limits.write_timeout,
                };
                tokio::spawn(client.connected(stream, stopped.clone(), open.clone()));
            }
            Err(error) if is_of_one_connection(&error) => {}
            Err(error) => {
                tracing::error!(%error, "cannot accept connections");
                // another one may have what is lacking
                connections.close_one();
                tokio::time::sleep(ACCEPT_PAUSE).await;
            }
        }
    }
    let address = listener.local_addr().map_or_else(|error| error.to_string(), |address| address.to_string());
    drop(listener);
    drop((service, open));
    drop(stopping);
    tracing::info!(%address, connections = done.receiver_count(), "shutting down: finishing accepted requests");
    if tokio::time::timeout(limits.grace, done.closed()).await.is_err() {
        tracing::warn!(
            connections = done.receiver_count(),
            grace = ?limits.grace,
            "shutdown grace period over; remaining requests were cut off"
        );
    }
}

/// The next client for whom there is a slot.
async fn accept(listener: &TcpListener, connections: &Connections) -> io::Result<(TcpStream, SocketAddr)> {
    // Those that are there give way when somebody comes, not before.
    let accepted = listener.accept().await?;
    connections.free_slot().await;
    Ok(accepted)
}

fn is_of_one_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

/// One connection of a client.
#[derive(Clone)]
struct Client {
    service: Arc<Service>,
    slot: Arc<ConnectionSlot>,
    address: IpAddr,
    /// From its certificate.
    names: Option<PeerNames>,
    write_timeout: Duration,
}

impl Client {
    /// Serves it to its end. `_open` is dropped then, which the server waits for.
    async fn connected(mut self, stream: TcpStream, mut stopped: watch::Receiver<()>, _open: watch::Receiver<()>) {
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!(%error, "cannot set TCP_NODELAY");
        }
        let outcome = match self.service.tls.clone() {
            None => self.serve(stream, stopped).await,
            Some(tls) => {
                let close = Arc::clone(self.slot.connection());
                tokio::select! {
                    accepted = tls.accept(stream) => match accepted {
                        Ok(stream) => {
                            self.names = tls::names_of(&stream);
                            self.serve(stream, stopped).await
                        }
                        Err(error) => {
                            tracing::debug!(%error, peer = %self.address, "no TLS handshake");
                            return;
                        }
                    },
                    // nothing was asked yet
                    _ = stopped.changed() => return,
                    () = close.close.notified() => return,
                }
            }
        };
        if let Err(error) = outcome {
            tracing::debug!(%error, "a connection ended early");
        }
    }

    async fn serve(
        self,
        stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
        mut stopped: watch::Receiver<()>,
    ) -> hyper::Result<()> {
        let connection = Arc::clone(self.slot.connection());
        let socket = TokioIo::new(Socket::new(stream, Arc::clone(&self.slot), self.write_timeout));
        let service = service_fn(move |request| self.clone().answer(request));
        let mut builder = http1::Builder::new();
        builder.timer(TokioTimer::new()).header_read_timeout(IDLE);
        let mut served = std::pin::pin!(builder.serve_connection(socket, service).with_upgrades());
        loop {
            tokio::select! {
                outcome = served.as_mut() => break outcome,
                // The sender is only ever dropped.
                _ = stopped.changed() => {
                    served.as_mut().graceful_shutdown();
                    break served.await;
                }
                () = connection.close.notified() => {
                    // a request may have come meanwhile
                    if connection.may_close() {
                        served.as_mut().graceful_shutdown();
                    }
                }
            }
        }
    }

    /// Has a request answered, and sees to what comes after it on its connection.
    async fn answer(self, request: hyper::Request<Incoming>) -> Result<Response, Infallible> {
        let Client { service, slot, address, names, .. } = self;
        slot.connection().set_phase(Phase::Busy);
        let expects = request.headers().contains_key(header::EXPECT);
        let for_checks = slot.is_for_checks();
        let (mut head, body) = request.into_parts();
        if for_checks {
            head.extensions.insert(ForChecks);
        }
        head.extensions.insert(Peer::of(address, &head.headers, &service.state.settings.trusted_proxies));
        names.map(|names| head.extensions.insert(names));
        let (body, rest) = Unread::track(body);
        let mut response = service.router.clone().oneshot(hyper::Request::from_parts(head, body)).await?;
        if service.tls.is_some() {
            response.headers_mut().insert(header::STRICT_TRANSPORT_SECURITY, HSTS);
        }
        if response.status() == StatusCode::SWITCHING_PROTOCOLS {
            return Ok(response);
        }
        let goes_on = rest.can_go_on(expects).await;
        if !goes_on {
            slot.connection().set_unread();
        }
        if !goes_on || for_checks || service.state.shutdown.is_draining() {
            response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
        }
        Ok(response.map(|body| Body::new(Sent { body, slot })))
    }
}

/// A body that says when it has been handed over.
struct Sent {
    body: Body,
    slot: Arc<ConnectionSlot>,
}

impl HttpBody for Sent {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(cx)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

impl Drop for Sent {
    fn drop(&mut self) {
        self.slot.set_idle();
    }
}
