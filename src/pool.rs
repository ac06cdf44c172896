//! A bounded pool for processor work, apart from the threads that serve connections.
//!
//! Fits take from microseconds to seconds. They run on dedicated threads so that a long one never holds up
//! another connection, and wait in a queue of bounded length so that overload is answered at once (503)
//! instead of being hidden in memory and latency. A worker is woken only when one sleeps: under load a job
//! changes threads without a system call. Work that is known to be short may be done by the thread that has it, in the
//! [`Place`] of an idle worker.

use std::{
    collections::VecDeque,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
};

use tokio::sync::oneshot;

use crate::telemetry;

/// Work with somebody who waits for it.
trait Job: Send {
    fn run(self: Box<Self>);
    /// Whether nobody waits any more.
    fn is_abandoned(&self) -> bool;
}

struct Task<T, F> {
    work: F,
    answer: oneshot::Sender<T>,
}

impl<T: Send, F: FnOnce() -> T + Send> Job for Task<T, F> {
    fn run(self: Box<Self>) {
        if !self.is_abandoned() {
            let _gone = self.answer.send((self.work)());
        }
    }

    fn is_abandoned(&self) -> bool {
        self.answer.is_closed()
    }
}

/// Why work was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PoolError {
    /// The queue is at its limit.
    #[error("{limit} requests are already waiting for a worker")]
    Full {
        /// The queue's length.
        limit: usize,
    },
    /// The work panicked or the pool was closed.
    #[error("the work ended without an answer")]
    Lost,
}

/// See the module's documentation. Dropping the pool finishes what was accepted.
#[derive(Debug)]
pub struct WorkPool {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
    limit: usize,
}

struct Shared {
    state: Mutex<State>,
    wake: Condvar,
    depth: metrics::Gauge,
}

#[derive(Default)]
struct State {
    queue: VecDeque<Box<dyn Job>>,
    idle: usize,
    /// Places of idle workers that are taken by other threads.
    taken: usize,
    closed: bool,
}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").field("waiting", &self.lock().queue.len()).finish()
    }
}

impl Shared {
    /// Jobs run outside the lock, so a poisoned one still guards a consistent state.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self) {
        let mut state = self.lock();
        loop {
            if let Some(job) = state.queue.pop_front() {
                self.depth.set(state.queue.len() as f64);
                drop(state);
                // The panic hook has said what happened; the waiting side sees its channel closed.
                let _panicked = catch_unwind(AssertUnwindSafe(|| job.run()));
                state = self.lock();
            } else if state.closed {
                return;
            } else {
                state.idle += 1;
                state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
                state.idle -= 1;
            }
        }
    }
}

/// The place of a worker, for work that the calling thread does itself. Dropping it gives it back.
#[derive(Debug)]
pub struct Place<'a>(&'a Shared);

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.0.lock().taken -= 1;
    }
}

impl WorkPool {
    /// Starts `workers` threads (at least one) with a queue of `limit` places (at least one).
    pub fn new(workers: usize, limit: usize) -> std::io::Result<Self> {
        telemetry::metrics();
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            wake: Condvar::new(),
            depth: metrics::gauge!(telemetry::QUEUE_DEPTH),
        });
        let workers = (0..workers.max(1))
            .map(|i| {
                let shared = Arc::clone(&shared);
                std::thread::Builder::new().name(format!("fit-{i}")).spawn(move || shared.work())
            })
            .collect::<Result<_, _>>()?;
        Ok(WorkPool { shared, workers, limit: limit.max(1) })
    }

    /// Runs `work` on a worker. When the returned future is dropped before the work has begun, it is skipped.
    pub async fn run<T, F>(&self, work: F) -> Result<T, PoolError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let (answer, receiver) = oneshot::channel();
        let job = Box::new(Task { work, answer });
        {
            let mut state = self.shared.lock();
            if state.closed {
                return Err(PoolError::Lost);
            }
            if state.queue.len() >= self.limit {
                // Requests that were given up (timeouts, lost connections) do not hold places.
                state.queue.retain(|job| !job.is_abandoned());
            }
            if state.queue.len() >= self.limit {
                return Err(PoolError::Full { limit: self.limit });
            }
            state.queue.push_back(job);
            self.shared.depth.set(state.queue.len() as f64);
            if state.idle > 0 {
                self.shared.wake.notify_one();
            }
        }
        receiver.await.map_err(|_| PoolError::Lost)
    }

    /// The place of an idle worker, if nobody waits for one: for work that is so short that handing it to another thread and
    /// back would take as long. Work that comes meanwhile is not held up by a place that is taken.
    pub fn place(&self) -> Option<Place<'_>> {
        let mut state = self.shared.lock();
        let free = state.queue.is_empty() && state.taken < state.idle && !state.closed;
        state.taken += usize::from(free);
        // Lazily: a place that is made is also given back.
        free.then(|| Place(&self.shared))
    }

    /// Jobs waiting for a worker.
    pub fn waiting(&self) -> usize {
        self.shared.lock().queue.len()
    }
}

impl Drop for WorkPool {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.wake.notify_all();
        let here = std::thread::current().id();
        // Work may own the last handle of the pool; a worker does not wait for itself.
        for worker in self.workers.drain(..).filter(|worker| worker.thread().id() != here) {
            let _panicked = worker.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use tokio::task::JoinHandle;

    use super::*;

    /// A worker at work until the sender is dropped.
    async fn occupied(pool: &Arc<WorkPool>) -> (mpsc::Sender<()>, JoinHandle<Result<bool, PoolError>>) {
        let (open, gate) = mpsc::channel::<()>();
        let (started, begun) = oneshot::channel();
        let pool = Arc::clone(pool);
        let busy = tokio::spawn(async move {
            pool.run(move || {
                let _ = started.send(());
                gate.recv().is_err()
            })
            .await
        });
        begun.await.unwrap();
        (open, busy)
    }

    #[tokio::test]
    async fn work_is_done_and_a_panic_costs_only_its_own_request() {
        let pool = WorkPool::new(1, 4).unwrap();
        assert_eq!(pool.run(|| 6 * 7).await, Ok(42));
        assert_eq!(pool.run(|| -> u8 { panic!("on purpose") }).await, Err(PoolError::Lost));
        assert_eq!(pool.run(|| 1).await, Ok(1));
    }

    #[tokio::test]
    async fn a_place_is_that_of_an_idle_worker() {
        let pool = Arc::new(WorkPool::new(1, 4).unwrap());
        while pool.shared.lock().idle == 0 {
            std::thread::yield_now();
        }
        let place = pool.place().expect("the worker has nothing to do");
        assert!(pool.place().is_none(), "there is one worker");
        assert_eq!(pool.run(|| 1).await, Ok(1), "nobody waits for a place");
        drop(place);
        let (open, busy) = occupied(&pool).await;
        assert!(pool.place().is_none(), "the worker is busy");
        drop(open);
        assert_eq!(busy.await.unwrap(), Ok(true));
    }

    #[tokio::test]
    async fn a_full_queue_refuses_at_once() {
        let pool = Arc::new(WorkPool::new(1, 1).unwrap());
        let (open, busy) = occupied(&pool).await;
        let mut waiting = Box::pin(pool.run(|| true));
        assert!(std::future::poll_fn(|cx| std::task::Poll::Ready(waiting.as_mut().poll(cx).is_pending())).await);
        assert_eq!(pool.waiting(), 1);
        assert_eq!(pool.run(|| true).await, Err(PoolError::Full { limit: 1 }));
        drop(open);
        assert_eq!(busy.await.unwrap(), Ok(true));
        assert_eq!(waiting.await, Ok(true));
    }
}
