//! A bounded pool for processor work, apart from the threads that serve connections.
//!
//! Fits take from microseconds to seconds. They run on dedicated threads so that a long one never
//! holds up another connection, and wait in a queue of bounded length so that overload is refused
//! at once (503) and not hidden in memory and latency. A worker is woken only when one sleeps:
//! under load a job changes threads without a system call. Work that is known to be short may be
//! done by the thread that has it, in the [`WorkerSlot`] of an idle worker; one at a time even
//! where all are busy, so that some microseconds do not wait for seconds of others' work.
//!
//! Work is done for somebody: what is awaited [`on_behalf_of`] a party is that party's. Each party
//! has a queue of its own, and no more workers than another that waits (`turns`).
//!
//! Work runs under a [`Handle`], which its loops ask. That of [`WorkPool::run`] is cancelled when
//! the future is dropped, which is what happens when a client leaves or a request's time is over.
//! All of them are cancelled when the pool stops. What is awaited [`under`] a handle has all its
//! work done under that one.

mod turns;

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use tokio::sync::oneshot;
use tracing::Span;

use crate::telemetry;
use turns::Turns;

pub use flankfit_engine::numerics::cancel::{Handle, checkpoint};
pub use turns::Party;

/// Work with the handle under which it runs.
trait Job: Send {
    /// True if the work came to its end and somebody heard of it.
    fn run(self: Box<Self>) -> bool;
    fn handle(&self) -> &Handle;
}

struct Task<T, F> {
    handle: Handle,
    /// Span of the request, which includes the wait.
    span: Span,
    wait: Span,
    work: F,
    answer: oneshot::Sender<Result<T, PoolError>>,
}

impl<T: Send, F: FnOnce() -> T + Send> Job for Task<T, F> {
    fn run(self: Box<Self>) -> bool {
        let Task { handle, span, wait, work, answer } = *self;
        drop(wait);
        let computing = telemetry::compute_span(&span);
        drop(span);
        let done = computing.in_scope(|| handle.run(work));
        // before the answer: a request's span goes out when all below it have ended
        drop(computing);
        match done {
            Ok(result) => answer.send(Ok(result)).is_ok(),
            Err(_cancelled) => {
                let _gone = answer.send(Err(PoolError::Cancelled));
                false
            }
        }
    }

    fn handle(&self) -> &Handle {
        &self.handle
    }
}

/// Reason why work was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PoolError {
    /// The party's queue is at its limit.
    #[error("too many requests are already waiting for a worker")]
    Full,
    /// Its handle was cancelled.
    #[error("the work was cancelled")]
    Cancelled,
    /// The pool takes no more work.
    #[error("the server is stopping")]
    Stopped,
    /// The work panicked.
    #[error("the work ended without an answer")]
    Lost,
}

/// See the module's documentation. Dropping the pool stops it.
#[derive(Debug)]
pub struct WorkPool {
    shared: Arc<Shared>,
}

struct Shared {
    state: Mutex<State>,
    wake: Condvar,
    depth: metrics::Gauge,
    busy: metrics::Gauge,
}

struct State {
    queue: Turns<Box<dyn Job>>,
    idle: usize,
    /// Places of idle workers that are taken by other threads.
    taken: usize,
    /// True while the one slot for short work in addition to the workers is taken.
    beside: bool,
    /// Handle of the work in progress, by worker.
    running: Vec<Option<Handle>>,
    stopped: bool,
}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").field("waiting", &self.lock().queue.len()).finish()
    }
}

impl Shared {
    fn new(workers: usize, queue: Turns<Box<dyn Job>>, depth: metrics::Gauge, busy: metrics::Gauge) -> Arc<Self> {
        let state = State { queue, idle: 0, taken: 0, beside: false, running: vec![None; workers], stopped: false };
        Arc::new(Shared { state: Mutex::new(state), wake: Condvar::new(), depth, busy })
    }

    /// Jobs run outside the lock, so a poisoned one still guards a consistent state.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self, worker: usize) {
        let mut state = self.lock();
        loop {
            if let Some((party, job)) = state.queue.take() {
                self.depth.set(state.queue.len() as f64);
                let handle = job.handle().clone();
                state.running[worker] = Some(handle.clone());
                drop(state);
                self.busy.increment(1.0);
                let begun = Instant::now();
                let begins = !handle.is_cancelled();
                // The panic hook has said what happened; the waiting side sees its channel closed.
                let answered = catch_unwind(AssertUnwindSafe(|| job.run()));
                state = self.lock();
                state.running[worker] = None;
                state.queue.finished(&party);
                if matches!(answered, Ok(false)) {
                    telemetry::record_cancelled(
                        reason(state.stopped),
                        if begins { begun.elapsed() } else { Duration::ZERO },
                    );
                }
                self.busy.decrement(1.0);
            } else if state.stopped {
                return;
            } else {
                state.idle += 1;
                state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
                state.idle -= 1;
            }
        }
    }

    /// Takes no more work, forgets what waits and cancels what runs.
    fn stop(&self) {
        let mut state = self.lock();
        state.stopped = true;
        let waiting = state.queue.drain();
        for handle in state.running.iter().flatten() {
            handle.cancel();
        }
        self.wake.notify_all();
        drop(state);
        // Outside the lock: what a job owns may be anything.
        for job in waiting {
            telemetry::record_cancelled(reason(true), Duration::ZERO);
            drop(job);
        }
        self.depth.set(0.0);
    }
}

/// Label for the reason why work was cancelled.
fn reason(stopped: bool) -> &'static str {
    if stopped { "stopped" } else { "abandoned" }
}

/// Slot of an idle worker, or the additional one, for work that the calling thread does itself.
/// Dropping it returns the slot.
#[derive(Debug)]
pub struct WorkerSlot<'a> {
    shared: &'a Shared,
    beside: bool,
}

impl Drop for WorkerSlot<'_> {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        if self.beside {
            state.beside = false;
        } else {
            state.taken -= 1;
        }
    }
}

tokio::task_local! {
    /// Under which the work of a future is done, wherever it puts it.
    static UNDER: Handle;
    /// For whom it is done.
    static PARTY: Party;
}

/// A future of which all work on pools is done for one party, whose turns it shares.
pub fn on_behalf_of<F: Future>(party: Party, future: F) -> impl Future<Output = F::Output> {
    PARTY.scope(party, future)
}

/// For whom work is done here, to go on with it elsewhere.
pub fn party() -> Party {
    PARTY.try_with(Party::clone).unwrap_or_default()
}

/// A future of which all work on pools is done under one handle: so it can be watched and
/// cancelled as one.
pub fn under<F: Future>(handle: Handle, future: F) -> impl Future<Output = F::Output> {
    UNDER.scope(handle, future)
}

/// Cancels when dropped before the end.
struct CancelOnDrop(Option<Handle>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.iter().for_each(Handle::cancel);
    }
}

impl WorkPool {
    /// Starts `workers` threads (at least one) with a queue of `limit` places (at least one) for
    /// each party.
    pub fn new(workers: usize, limit: usize) -> std::io::Result<Self> {
        telemetry::metrics();
        let (workers, limit) = (workers.max(1), limit.max(1));
        let (depth, busy) = (metrics::gauge!(telemetry::QUEUE_DEPTH), metrics::gauge!(telemetry::BUSY_WORKERS));
        let shared = Shared::new(workers, Turns::new(limit), depth, busy);
        // The threads are not joined: they end when the pool stops, and the process does not wait
        // for them.
        let pool = WorkPool { shared };
        for worker in 0..workers {
            let shared = Arc::clone(&pool.shared);
            std::thread::Builder::new().name(format!("fit-{worker}")).spawn(move || shared.work(worker))?;
        }
        Ok(pool)
    }

    /// Runs `work` on a worker. When the returned future is dropped, work that has not begun is
    /// skipped and work that runs ends at its next checkpoint.
    pub async fn run<T, F>(&self, work: F) -> Result<T, PoolError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let handle = UNDER.try_with(Handle::clone).unwrap_or_default();
        let mut cancel = CancelOnDrop(Some(handle.clone()));
        let outcome = self.run_with(handle, work).await;
        cancel.0 = None;
        outcome
    }

    /// Runs `work` on a worker until it is done or `handle` is cancelled, whether or not somebody
    /// still waits for it.
    async fn run_with<T, F>(&self, handle: Handle, work: F) -> Result<T, PoolError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let (answer, receiver) = oneshot::channel();
        let span = telemetry::here();
        let wait = telemetry::queue_span(&span);
        self.enqueue(Box::new(Task { handle, span, wait, work, answer }))?;
        receiver.await.unwrap_or(Err(if self.shared.lock().stopped { PoolError::Stopped } else { PoolError::Lost }))
    }

    fn enqueue(&self, job: Box<dyn Job>) -> Result<(), PoolError> {
        let party = party();
        // dropped after the lock is released, as the work that is refused: work may own anything
        let abandoned;
        let mut state = self.shared.lock();
        if state.stopped {
            return Err(PoolError::Stopped);
        }
        if state.queue.is_full(&party) {
            // Requests that were given up (timeouts, lost connections) do not hold places.
            abandoned = state.queue.remove(|job| job.handle().is_cancelled());
            for _job in &abandoned {
                telemetry::record_cancelled(reason(false), Duration::ZERO);
            }
            if state.queue.is_full(&party) {
                return Err(PoolError::Full);
            }
        }
        state.queue.push(party, job);
        self.shared.depth.set(state.queue.len() as f64);
        if state.idle > 0 {
            self.shared.wake.notify_one();
        }
        Ok(())
    }

    /// Returns the slot of an idle worker if nobody waits for one, else the additional one if it is
    /// free. It is for work so short that handing it to another thread would take as long. A taken
    /// slot does not delay later work.
    pub fn try_slot(&self) -> Option<WorkerSlot<'_>> {
        let mut state = self.shared.lock();
        let beside = !(state.queue.is_empty() && state.taken < state.idle);
        if state.stopped || (beside && state.beside) {
            return None;
        }
        if beside {
            state.beside = true;
        } else {
            state.taken += 1;
        }
        Some(WorkerSlot { shared: &self.shared, beside })
    }

    /// Jobs waiting for a worker.
    pub fn waiting(&self) -> usize {
        self.shared.lock().queue.len()
    }

    /// Workers at work.
    pub fn busy(&self) -> usize {
        self.shared.lock().running.iter().flatten().count()
    }

    /// Takes no more work and cancels what waits and what runs.
    pub fn stop(&self) {
        self.shared.stop();
    }
}

impl Drop for WorkPool {
    fn drop(&mut self) {
        self.stop();
    }
}

#[cfg(test)]
mod tests;
