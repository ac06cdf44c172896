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
    jobs::{ClaimedTask, EndedTask, LEASE, Lease, MOST_ATTEMPTS, RepositoryError},
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
    let (lease, job, caller) = (task.lease, task.job, task.caller.clone());
    if task.attempts > MOST_ATTEMPTS {
        let detail = format!("The operation was begun {MOST_ATTEMPTS} times, and each time its server was lost.");
        end(&state, lease, job, Problem::new(ProblemCode::Interrupted, detail).into()).await;
        return state.jobs.announce_task(&caller.tenant, job);
    }
    let handle = Handle::new();
    let _renewed = state.long.begin(lease, handle.clone());
    let doing = pool::under(handle.clone(), replay::answer(&state, &handlers, task));
    let answered = match state.callers.still_lets_in(&caller).await {
        Ok(false) => let_out(),
        // the store that does not answer is told of by whoever asks it for something
        Ok(true) | Err(_) => tokio::select! {
            answered = in_time(&state, doing) => answered,
            () = state.callers.let_out(&caller) => let_out(),
        },
    };
    match answered.problem.as_ref().filter(|problem| passes(problem)) {
        Some(_) if handle.is_cancelled() => {}
        Some(problem) => {
            tracing::debug!(operation = %lease.task, code = %problem.code, "an operation waits for room");
            give_back(&state, lease, !state.shutdown.is_draining()).await;
        }
        None => end(&state, lease, job, answered).await,
    }
    state.jobs.announce_task(&caller.tenant, job);
}

async fn in_time(state: &AppState, doing: impl Future<Output = Answered>) -> Answered {
    let limit = Duration::from_secs(state.settings.operation_timeout);
    match timeout(limit, catch_panic(doing)).await {
        Ok(Ok(answered)) => answered,
        Ok(Err(_)) => Problem::internal("a handler panicked").into(),
        Err(_elapsed) => {
            let detail = format!("The operation did not end within {} s.", limit.as_secs());
            Problem::new(ProblemCode::OperationTimeout, detail).into()
        }
    }
}

/// What becomes of the request of somebody who is not let in any more.
fn let_out() -> Answered {
    let detail =
        "The key of this operation's request has ended, or its tenant is suspended; nothing was stored for it.";
    Problem::new(ProblemCode::Forbidden, detail).into()
}

/// Whether the same request would do better in a while.
fn passes(problem: &Problem) -> bool {
    use ProblemCode::{Draining, IdempotencyKeyInUse, OutcomeUnknown, Overloaded, StoreUnavailable};
    [Draining, IdempotencyKeyInUse, OutcomeUnknown, Overloaded, StoreUnavailable]
        .into_iter()
        .any(|code| problem.is(code))
}

/// Writes down the end of a task, unless what was stored for it has ended it. Where the store is
/// away it is tried again, as long as the lease may hold.
async fn end(state: &AppState, lease: Lease, job: Option<uuid::Uuid>, answered: Answered) {
    let cause = answered.problem.as_ref().and_then(|problem| problem.cause.clone());
    let (now, most) = (state.jobs.now(), state.settings.operation_bytes);
    let ending = |answered: Answered, most| {
        let state = answered.state();
        let Answered { answer, mut permit, .. } = answered;
        // stores copy it
        permit.iter_mut().for_each(|permit| permit.force(answer.body.len()));
        (Arc::new(EndedTask { lease, job, state, answer, most, now }), permit)
    };
    let (mut ended, mut _permit) = ending(answered, most);
    for _ in 0..5 {
        match state.jobs.tasks().end(ended.clone()).await {
            Ok(held) => {
                if held && let Some(cause) = &cause {
                    tracing::error!(operation = %lease.task, cause, "an operation failed");
                }
                return;
            }
            // what is said instead is short, and there is always room for it
            Err(error @ RepositoryError::TasksFull { .. }) => {
                (ended, _permit) = ending(Problem::from(error).into(), u64::MAX);
                continue;
            }
            Err(error) => tracing::warn!(%error, operation = %lease.task, "the end of an operation was not stored"),
        }
        sleep(Duration::from_secs(1)).await;
    }
}
