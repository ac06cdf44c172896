//! Takes tasks and does them, as long as the server runs.
//!
//! One worker fewer than there are does them (at least one), so that who waits for an answer finds
//! one free. A server that stops gives its tasks back at once, as if they had not been begun.

use std::{sync::Arc, time::Duration};

use axum::Router;
use jiff::SignedDuration;
use tokio::{
    task::JoinSet,
    time::{Instant, sleep, sleep_until, timeout},
};
use tracing::Instrument as _;

use super::{
    super::{observe::catch_panic, router, state::AppState},
    answer::Answered,
    replay,
};
use crate::{
    api::problem::{Problem, ProblemCode},
    jobs::{ClaimedTask, EndedTask, LEASE, Lease, MOST_ATTEMPTS, RepositoryError, TaskAnswer, TaskState},
    pool::{self, Handle},
    telemetry,
};

/// How often leases are renewed: thrice while they last.
const RENEWAL: Duration = Duration::from_secs(3);
/// Between two looks for tasks of which nothing was told.
const LOOK: Duration = Duration::from_secs(1);
/// Between two looks because something was told.
const PAUSE: Duration = Duration::from_millis(50);
/// After how long a task is begun again for which there was no room.
const AGAIN: SignedDuration = SignedDuration::from_secs(1);

/// Does tasks until the server stops.
pub async fn run(state: AppState) {
    let handlers = router::handlers(state.clone());
    tokio::join!(take(&state, &handlers), renew(&state));
}

async fn take(state: &AppState, handlers: &Router) {
    let most = state.settings.worker_count().saturating_sub(1).max(1);
    let mut changes = state.jobs.listen_to_tasks();
    let mut stopping = std::pin::pin!(state.shutdown.begun());
    let mut doing = JoinSet::new();
    loop {
        while doing.len() < most
            && let Some(task) = claim(state).await
        {
            let party = Some(task.caller.tenant.name());
            let span = telemetry::operation_span(task.lease.task);
            let completing = complete(state.clone(), handlers.clone(), task).instrument(span);
            doing.spawn(pool::on_behalf_of(party, completing));
        }
        tokio::select! {
            () = &mut stopping => break,
            _ = doing.join_next(), if !doing.is_empty() => {}
            _ = changes.changed(), if doing.len() < most => sleep(PAUSE).await,
            () = sleep(LOOK) => {}
        }
    }
    // what is being stored is stored, or its lease is given back before
    let left = state.long.leases();
    doing.shutdown().await;
    for (lease, _) in left {
        give_back(state, lease, false).await;
    }
    state.jobs.announce_tasks();
}

async fn claim(state: &AppState) -> Option<ClaimedTask> {
    if state.shutdown.is_draining() {
        return None;
    }
    let now = state.jobs.now();
    match state.jobs.tasks().claim(state.jobs.fresh_id(now), now, LEASE).await {
        Ok(task) => task,
        Err(error) => {
            tracing::debug!(%error, "no operation could be taken");
            None
        }
    }
}

async fn give_back(state: &AppState, lease: Lease, later: bool) {
    let until = if later { state.jobs.now() + AGAIN } else { state.jobs.now() };
    if let Err(error) = state.jobs.tasks().give_back(lease, until, false).await {
        tracing::debug!(%error, operation = %lease.task, "an operation could not be given back");
    }
}

/// Renews the leases now and then, and whenever something was told: a task that was cancelled, or
/// that another has taken, ends here.
async fn renew(state: &AppState) {
    let mut changes = state.jobs.listen_to_tasks();
    let mut stopping = std::pin::pin!(state.shutdown.begun());
    let (mut next, mut renewed) = (Instant::now() + RENEWAL, Instant::now());
    let lasting = Duration::try_from(LEASE).unwrap_or_default();
    loop {
        tokio::select! {
            () = &mut stopping => return,
            _ = changes.changed() => sleep(PAUSE).await,
            () = sleep_until(next) => {}
        }
        next = Instant::now() + RENEWAL;
        let asked = state.long.leases();
        if asked.is_empty() {
            renewed = Instant::now();
            continue;
        }
        match state.jobs.tasks().renew(asked.clone(), state.jobs.now(), LEASE).await {
            Ok(held) => {
                renewed = Instant::now();
                state.long.cancel_lost(&asked, &held);
            }
            // by now others have taken them
            Err(error) if renewed.elapsed() > lasting => {
                tracing::warn!(%error, "the leases of operations were lost");
                state.long.cancel_lost(&asked, &[]);
            }
            Err(error) => tracing::debug!(%error, "the leases of operations could not be renewed"),
        }
    }
}

/// Does a task, and writes down what came of it.
async fn complete(state: AppState, handlers: Router, task: ClaimedTask) {
    let (lease, job, tenant) = (task.lease, task.job, task.caller.tenant.clone());
    if task.attempts > MOST_ATTEMPTS {
        let detail = format!("The operation was begun {MOST_ATTEMPTS} times, and each time its server was lost.");
        let interrupted = Answered::from(Problem::new(ProblemCode::Interrupted, detail));
        end(&state, lease, job, TaskState::Failed, interrupted.kept(u64::MAX)).await;
        return state.jobs.announce_task(&tenant, job);
    }
    let handle = Handle::new();
    let _renewed = state.long.begin(lease, handle.clone());
    let limit = Duration::from_secs(state.settings.operation_timeout);
    let doing = pool::under(handle.clone(), replay::answer(&state, &handlers, task));
    let answered = match timeout(limit, catch_panic(doing)).await {
        Ok(Ok(answered)) => answered,
        Ok(Err(_)) => Problem::internal("a handler panicked").into(),
        Err(_elapsed) => {
            let seconds = limit.as_secs();
            let detail = format!("The operation did not end within {seconds} s, which is all that one may have here.");
            Problem::new(ProblemCode::OperationTimeout, detail).into()
        }
    };
    match answered.problem.as_ref().filter(|problem| passes(problem)) {
        Some(_) if handle.is_cancelled() => {}
        Some(problem) => {
            tracing::debug!(operation = %lease.task, code = %problem.code, "an operation waits for room");
            give_back(&state, lease, !state.shutdown.is_draining()).await;
        }
        None => keep(&state, lease, job, answered).await,
    }
    state.jobs.announce_task(&tenant, job);
}

/// Whether the same request would do better in a while.
fn passes(problem: &Problem) -> bool {
    use ProblemCode::{Draining, IdempotencyKeyInUse, OutcomeUnknown, Overloaded, StoreUnavailable};
    [Draining, IdempotencyKeyInUse, OutcomeUnknown, Overloaded, StoreUnavailable]
        .into_iter()
        .any(|code| problem.is(code))
}

async fn keep(state: &AppState, lease: Lease, job: Option<uuid::Uuid>, answered: Answered) {
    if let Some(cause) = answered.problem.as_ref().and_then(|problem| problem.cause.as_ref()) {
        tracing::error!(operation = %lease.task, cause, "an operation failed");
    }
    let (ended, most) = (answered.state(), state.settings.operation_bytes);
    let kept = state.pool.run(move || answered.kept(most)).await;
    if let Ok(answer) = kept {
        let ended = if answer.status < 400 { ended } else { TaskState::Failed };
        end(state, lease, job, ended, answer).await;
    }
}

/// Writes down the end of a task, unless what was stored for it has ended it. Where the store is
/// away it is tried again, as long as the lease may hold.
async fn end(state: &AppState, lease: Lease, job: Option<uuid::Uuid>, ended: TaskState, answer: TaskAnswer) {
    let (now, most) = (state.jobs.now(), state.settings.operation_bytes);
    let mut ended = Arc::new(EndedTask { lease, job, state: ended, answer, most, now });
    for _ in 0..5 {
        match state.jobs.tasks().end(ended.clone()).await {
            Ok(_) => return,
            // what is said instead is short, and there is always room for it
            Err(error @ RepositoryError::TasksFull { .. }) => {
                let answer = Answered::from(Problem::from(error)).kept(u64::MAX);
                ended = Arc::new(EndedTask { lease, job, state: TaskState::Failed, answer, most: u64::MAX, now });
                continue;
            }
            Err(error) => tracing::warn!(%error, operation = %lease.task, "the end of an operation was not stored"),
        }
        sleep(Duration::from_secs(1)).await;
    }
}
