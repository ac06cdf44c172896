//! Connections that would stay open for ever hear here that the server stops, and the server waits
//! for them.

use tokio::sync::watch;

/// Whether the server stops, and who still listens.
pub struct Closing {
    stopping: watch::Sender<bool>,
    guests: watch::Sender<()>,
}

/// Held by whoever must be waited for.
pub struct Guest {
    _held: watch::Receiver<()>,
    gauge: metrics::Gauge,
}

impl Drop for Guest {
    fn drop(&mut self) {
        self.gauge.decrement(1.0);
    }
}

impl Closing {
    /// The server stops from now on.
    pub fn close(&self) {
        self.stopping.send_replace(true);
    }

    /// Is ready once the server stops.
    pub fn stopped(&self) -> impl Future<Output = ()> + Send + 'static {
        let mut stopping = self.stopping.subscribe();
        async move {
            // the sender lives as long as the state that is served
            let _gone = stopping.wait_for(|stopping| *stopping).await;
        }
    }

    /// Announces a connection that stays open, of this kind.
    pub fn guest(&self, kind: &'static str) -> Guest {
        let gauge = metrics::gauge!(crate::telemetry::LISTENERS, "kind" => kind);
        gauge.increment(1.0);
        Guest { _held: self.guests.subscribe(), gauge }
    }

    /// Is ready when every guest has gone.
    pub async fn empty(&self) {
        self.guests.closed().await;
    }
}

impl Default for Closing {
    fn default() -> Self {
        Closing { stopping: watch::channel(false).0, guests: watch::channel(()).0 }
    }
}
