//! Every open connection: how many there may be, what each is doing, and which of them gives way
//! when there are too many.
//!
//! A connection waits for its first request, is idle between two, or is at work. When all places
//! are taken, the one that has been without a request for longest is closed for the next client;
//! where all are at work, new clients wait in the system's queue.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use tokio::{sync::Notify, time::Instant};

use crate::telemetry;

/// What a connection is doing.
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
    doing: Mutex<Doing>,
    /// Rung when the connection is to give way.
    pub leave: Notify,
}

#[derive(Clone, Copy, Debug)]
struct Doing {
    phase: Phase,
    since: Instant,
    /// Whether bytes wait for a client that does not read.
    stuck: bool,
    /// Whether the request's body was not read to its end, so that what comes next is no request.
    unread: bool,
}

impl Connection {
    fn lock(&self) -> MutexGuard<'_, Doing> {
        self.doing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn phase(&self) -> Phase {
        self.lock().phase
    }

    pub fn set_phase(&self, phase: Phase) {
        let mut doing = self.lock();
        doing.phase = phase;
        doing.since = Instant::now();
    }

    pub fn set_stuck(&self, stuck: bool) {
        self.lock().stuck = stuck;
    }

    pub fn set_unread(&self) {
        self.lock().unread = true;
    }

    pub fn is_unread(&self) -> bool {
        self.lock().unread
    }

    /// Whether nobody would miss it: no request, and nothing left to be sent.
    pub fn may_leave(&self) -> bool {
        self.waiting_since().is_some()
    }

    fn waiting_since(&self) -> Option<Instant> {
        let doing = *self.lock();
        (matches!(doing.phase, Phase::Fresh | Phase::Idle) && !doing.stuck).then_some(doing.since)
    }
}

/// All of them.
#[derive(Debug)]
pub struct Connections {
    most: usize,
    open: Mutex<Open>,
    /// Rung when a place has become free, or a connection idle while one was asked for.
    change: Notify,
}

#[derive(Debug, Default)]
struct Open {
    next: u64,
    all: HashMap<u64, Arc<Connection>>,
    wanted: bool,
}

/// The place of a connection, free again when this is dropped.
#[derive(Debug)]
pub struct Place {
    all: Arc<Connections>,
    key: u64,
    connection: Arc<Connection>,
}

impl Connections {
    /// At least one at a time.
    pub fn new(most: usize) -> Arc<Self> {
        telemetry::metrics();
        Arc::new(Connections { most: most.max(1), open: Mutex::default(), change: Notify::new() })
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ready when there is a place, which the longest idle connection is asked for if all are
    /// taken.
    pub async fn room(&self) {
        loop {
            {
                let mut open = self.lock();
                open.wanted = open.all.len() >= self.most;
                if !open.wanted {
                    return;
                }
                ask_oldest(&open);
            }
            self.change.notified().await;
        }
    }

    /// Asks the longest idle connection to give way, for whatever it is that has run short.
    pub fn ask(&self) {
        ask_oldest(&self.lock());
    }

    /// A place for a connection that is there.
    pub fn enter(self: &Arc<Self>) -> Place {
        let doing = Doing { phase: Phase::Fresh, since: Instant::now(), stuck: false, unread: false };
        let connection = Arc::new(Connection { doing: Mutex::new(doing), leave: Notify::new() });
        let mut open = self.lock();
        open.next += 1;
        let key = open.next;
        open.all.insert(key, Arc::clone(&connection));
        metrics::gauge!(telemetry::CONNECTIONS).increment(1.0);
        Place { all: Arc::clone(self), key, connection }
    }
}

fn ask_oldest(open: &Open) {
    let waiting = open.all.values().filter_map(|connection| Some((connection.waiting_since()?, connection)));
    if let Some((_, oldest)) = waiting.min_by_key(|(since, _)| *since) {
        telemetry::record_shed("idle_connection");
        oldest.leave.notify_one();
    }
}

impl Place {
    pub fn connection(&self) -> &Arc<Connection> {
        &self.connection
    }

    /// The answer is out: the next request may come, or another client may have the place.
    pub fn rest(&self) {
        self.connection.set_phase(Phase::Idle);
        if self.all.lock().wanted {
            self.all.change.notify_one();
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.all.lock().all.remove(&self.key);
        metrics::gauge!(telemetry::CONNECTIONS).decrement(1.0);
        self.all.change.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn is_ready(future: impl Future<Output = ()>) -> bool {
        let mut future = std::pin::pin!(future);
        std::future::poll_fn(|cx| std::task::Poll::Ready(future.as_mut().poll(cx).is_ready())).await
    }

    #[tokio::test]
    async fn the_longest_idle_one_gives_way_and_no_other() {
        let all = Connections::new(3);
        let places = [all.enter(), all.enter(), all.enter()];
        places[0].connection().set_phase(Phase::Busy);
        places[2].rest();
        // the second has waited for its first request since the beginning
        assert!(!is_ready(all.room()).await);
        assert!(is_ready(places[1].connection().leave.notified()).await);
        assert!(!is_ready(places[2].connection().leave.notified()).await);
        let [busy, fresh, idle] = places;
        drop(fresh);
        assert!(is_ready(all.room()).await);
        let next = all.enter();
        next.connection().set_phase(Phase::Head);
        idle.connection().set_stuck(true);
        // nobody can go: the one that becomes idle is asked
        let mut room = Box::pin(all.room());
        assert!(!is_ready(room.as_mut()).await);
        assert!(!is_ready(idle.connection().leave.notified()).await);
        busy.rest();
        assert!(!is_ready(room.as_mut()).await);
        assert!(is_ready(busy.connection().leave.notified()).await);
        drop(busy);
        assert!(is_ready(room).await);
    }
}
