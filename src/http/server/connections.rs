//! Every open connection: how many there may be, what each is doing, and which of them gives way
//! when there are too many.
//!
//! A connection waits for its first request, is idle between two, or is busy. When all slots are
//! taken, the one that has been without a request for longest is closed for the next client. If all
//! are busy, a few slots are reserved for checks of the server's state (`/healthz`); other requests
//! there are answered with 503. If these are taken too, new clients wait in the system's queue.

use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use tokio::{
    sync::Notify,
    time::{Duration, Instant, timeout},
};

use crate::telemetry;

/// Slots reserved for checks, at most an eighth of all.
const KEPT: usize = 4;

/// Interval after which the idle connections are examined again.
const AGAIN: Duration = Duration::from_millis(100);

/// State of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Nothing has come yet.
    Fresh,
    /// The head of a request has begun to come.
    Head,
    /// A request is worked on or answered, or the connection is no longer one of requests.
    Busy,
    /// An answer is out, the next request has not begun.
    Idle,
}

/// One connection, as the others see it.
#[derive(Debug)]
pub struct Connection {
    state: Mutex<ConnectionState>,
    /// Notified when the connection is to close.
    pub close: Notify,
}

#[derive(Clone, Copy, Debug)]
struct ConnectionState {
    phase: Phase,
    since: Instant,
    /// Whether bytes wait for a client that does not read.
    unsent: bool,
    /// Whether the request's body was not read to its end, so that what comes next is no request.
    unread: bool,
}

impl Connection {
    fn lock(&self) -> MutexGuard<'_, ConnectionState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn phase(&self) -> Phase {
        self.lock().phase
    }

    pub fn set_phase(&self, phase: Phase) {
        let mut state = self.lock();
        state.phase = phase;
        state.since = Instant::now();
    }

    pub fn set_unsent(&self, unsent: bool) {
        self.lock().unsent = unsent;
    }

    pub fn set_unread(&self) {
        self.lock().unread = true;
    }

    pub fn is_unread(&self) -> bool {
        self.lock().unread
    }

    /// Returns true if it is idle: no request, and nothing left to be sent.
    pub fn may_close(&self) -> bool {
        self.waiting_since().is_some()
    }

    fn waiting_since(&self) -> Option<Instant> {
        let state = *self.lock();
        (matches!(state.phase, Phase::Fresh | Phase::Idle) && !state.unsent).then_some(state.since)
    }
}

/// All of them.
#[derive(Debug)]
pub struct Connections {
    most: usize,
    /// Slots of these that are reserved for checks.
    kept: usize,
    open: Mutex<Open>,
    /// Notified when a slot has become free, or a connection idle while one was wanted.
    change: Notify,
}

#[derive(Debug, Default)]
struct Open {
    next: u64,
    all: HashMap<u64, Arc<Connection>>,
    wanted: bool,
}

/// The slot of a connection, free again when this is dropped.
#[derive(Debug)]
pub struct ConnectionSlot {
    all: Arc<Connections>,
    key: u64,
    connection: Arc<Connection>,
    /// True if it has one of the slots reserved for checks.
    kept: AtomicBool,
}

impl Connections {
    /// At least one at a time.
    pub fn new(most: usize) -> Arc<Self> {
        telemetry::metrics();
        let most = most.max(1);
        Arc::new(Connections { most, kept: (most / 8).min(KEPT), open: Mutex::default(), change: Notify::new() })
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ready when a slot is free. If all but those reserved for checks are taken, the longest idle
    /// connection is asked to close.
    pub async fn free_slot(&self) {
        loop {
            {
                let mut open = self.lock();
                open.wanted = open.all.len() >= self.most - self.kept;
                if !open.wanted || (!close_longest_idle(&open) && open.all.len() < self.most) {
                    return;
                }
            }
            // a connection that was asked to close may have received a request meanwhile
            let _looks_again = timeout(AGAIN, self.change.notified()).await;
        }
    }

    /// Closes the longest idle connection, for whatever it is that has run short.
    pub fn close_one(&self) {
        close_longest_idle(&self.lock());
    }

    /// A slot for a connection that is there.
    pub fn enter(self: &Arc<Self>) -> ConnectionSlot {
        let state = ConnectionState { phase: Phase::Fresh, since: Instant::now(), unsent: false, unread: false };
        let connection = Arc::new(Connection { state: Mutex::new(state), close: Notify::new() });
        let mut open = self.lock();
        open.next += 1;
        let (key, kept) = (open.next, open.all.len() >= self.most - self.kept);
        open.all.insert(key, Arc::clone(&connection));
        metrics::gauge!(telemetry::CONNECTIONS).increment(1.0);
        ConnectionSlot { all: Arc::clone(self), key, connection, kept: AtomicBool::new(kept) }
    }
}

/// Returns whether there is one.
fn close_longest_idle(open: &Open) -> bool {
    let waiting = open.all.values().filter_map(|connection| Some((connection.waiting_since()?, connection)));
    let oldest = waiting.min_by_key(|(since, _)| *since);
    if let Some((_, oldest)) = oldest {
        telemetry::record_shed("idle_connection");
        oldest.close.notify_one();
    }
    oldest.is_some()
}

impl ConnectionSlot {
    pub fn connection(&self) -> &Arc<Connection> {
        &self.connection
    }

    /// Returns true if it has one of the slots reserved for checks and all others are still taken.
    pub fn is_for_checks(&self) -> bool {
        let kept = self.kept.load(Ordering::Relaxed) && self.all.lock().all.len() > self.all.most - self.all.kept;
        self.kept.store(kept, Ordering::Relaxed);
        kept
    }

    /// The answer is out: the next request may come, or another client may have the slot.
    pub fn set_idle(&self) {
        self.connection.set_phase(Phase::Idle);
        if self.all.lock().wanted {
            self.all.change.notify_one();
        }
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        self.all.lock().all.remove(&self.key);
        metrics::gauge!(telemetry::CONNECTIONS).decrement(1.0);
        self.all.change.notify_one();
    }
}
