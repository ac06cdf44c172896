//! Connections that would stay open for ever hear here that the server stops, and the server waits
//! for them.

use std::sync::atomic::{AtomicBool, Ordering};

use tokio::sync::watch;

use crate::api::problem::{Problem, ProblemCode};

/// Whether the server stops, and the connections that stay open.
pub struct Shutdown {
    draining: AtomicBool,
    stopping: watch::Sender<bool>,
    open: watch::Sender<()>,
}

/// WithPermit by whoever must be waited for.
pub struct OpenConnection {
    _held: watch::Receiver<()>,
    gauge: metrics::Gauge,
}

impl Drop for OpenConnection {
    fn drop(&mut self) {
        self.gauge.decrement(1.0);
    }
}

impl Shutdown {
    /// Requests are better sent elsewhere from now on.
    pub fn drain(&self) {
        self.draining.store(true, Ordering::Relaxed);
        metrics::gauge!(crate::telemetry::DRAINING).set(1.0);
    }

    pub fn is_draining(&self) -> bool {
        self.draining.load(Ordering::Relaxed)
    }

    /// The server stops from now on.
    pub fn begin(&self) {
        self.stopping.send_replace(true);
    }

    /// Is ready once the server stops.
    pub fn begun(&self) -> impl Future<Output = ()> + Send + 'static {
        let mut stopping = self.stopping.subscribe();
        async move {
            // the sender lives as long as the state that is served
            let _gone = stopping.wait_for(|stopping| *stopping).await;
        }
    }

    /// Registers a long-lived connection of this kind. These may take at most three quarters of all
    /// connections.
    pub fn register(&self, kind: &'static str, connections: usize) -> Result<OpenConnection, Problem> {
        let most = (connections - connections / 4).max(1);
        if self.open.receiver_count() >= most {
            let detail = format!("{most} event streams and WebSockets are open, the greatest number allowed.");
            return Err(Problem::new(ProblemCode::Overloaded, detail).retry_after(10));
        }
        let gauge = metrics::gauge!(crate::telemetry::LISTENERS, "kind" => kind);
        gauge.increment(1.0);
        Ok(OpenConnection { _held: self.open.subscribe(), gauge })
    }

    /// Is ready when every such connection has ended.
    pub async fn drained(&self) {
        self.open.closed().await;
    }
}

impl Default for Shutdown {
    fn default() -> Self {
        metrics::gauge!(crate::telemetry::DRAINING).set(0.0);
        Shutdown { draining: AtomicBool::new(false), stopping: watch::channel(false).0, open: watch::channel(()).0 }
    }
}
