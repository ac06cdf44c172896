//! Wiring: settings in, a running server out.

use std::{io, net::SocketAddr, sync::Arc};

use tokio::net::TcpListener;

use crate::{
    config::ServeSettings,
    http::{self, AppState, state::AlwaysReady},
};

/// A server that listens but does not serve yet.
pub struct App {
    listener: TcpListener,
    state: AppState,
}

/// Why the server did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    #[error("{address} is taken by another program; choose another with --bind or FLANKFIT_BIND")]
    AddressTaken { address: SocketAddr },
    #[error("cannot listen on {address}: {source}")]
    Listen { address: SocketAddr, source: io::Error },
    #[error("cannot start the fit workers: {0}")]
    Workers(io::Error),
}

impl App {
    /// Binds the address and opens what the handlers need.
    pub async fn start(settings: ServeSettings) -> Result<Self, StartError> {
        let address = settings.bind;
        let listener = TcpListener::bind(address).await.map_err(|source| match source.kind() {
            io::ErrorKind::AddrInUse => StartError::AddressTaken { address },
            _ => StartError::Listen { address, source },
        })?;
        let state = AppState::new(settings, Arc::new(AlwaysReady)).map_err(StartError::Workers)?;
        Ok(App { listener, state })
    }

    /// The address that was bound (its port is known even when 0 was asked for).
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Serves until `stop` is ready, then finishes what was accepted within the shutdown grace.
    pub async fn serve(self, stop: impl Future<Output = ()> + Send + 'static) -> io::Result<()> {
        let grace = self.state.settings.shutdown_grace();
        let (stopping, stopped) = tokio::sync::oneshot::channel();
        let stop = async move {
            stop.await;
            tracing::info!("stopping: finishing what was accepted");
            let _gone = stopping.send(());
        };
        use axum::serve::ListenerExt;
        let listener = self.listener.tap_io(|stream| {
            if let Err(error) = stream.set_nodelay(true) {
                tracing::debug!(%error, "TCP_NODELAY refused");
            }
        });
        let server = axum::serve(listener, http::router(self.state)).with_graceful_shutdown(stop);
        let late = async {
            if stopped.await.is_ok() {
                tokio::time::sleep(grace).await;
            } else {
                std::future::pending::<()>().await;
            }
        };
        tokio::select! {
            result = server.into_future() => result,
            () = late => {
                tracing::warn!(grace_seconds = grace.as_secs(), "the shutdown grace is over; requests were cut off");
                Ok(())
            }
        }
    }
}
