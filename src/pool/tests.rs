use std::sync::mpsc;

use tokio::task::JoinHandle;

use super::*;
use flankfit_engine::numerics::cancel;

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
async fn a_slot_is_an_idle_worker_or_the_extra_one() {
    let pool = Arc::new(WorkPool::new(1, 4).unwrap());
    while pool.shared.lock().idle == 0 {
        std::thread::yield_now();
    }
    let place = pool.try_slot().expect("the worker has nothing to do");
    let beside = pool.try_slot().expect("one beside the worker");
    assert!(pool.try_slot().is_none(), "there is one worker, and one slot beside it");
    assert_eq!(pool.run(|| 1).await, Ok(1), "nobody waits for a slot");
    drop(beside);
    drop(place);
    let (open, busy) = occupied(&pool).await;
    let beside = pool.try_slot().expect("what is short does not wait for the worker");
    assert!(pool.try_slot().is_none(), "one at a time");
    drop(beside);
    assert!(pool.try_slot().is_some(), "it was given back");
    drop(open);
    assert_eq!(busy.await.unwrap(), Ok(true));
    pool.stop();
    assert!(pool.try_slot().is_none(), "a pool that stops has no slots");
}

/// Work that says that it runs and goes on until it is cancelled.
fn endless() -> (oneshot::Receiver<()>, impl FnOnce() + Send + 'static) {
    let (started, begun) = oneshot::channel();
    let work = move || {
        let _ = started.send(());
        loop {
            cancel::checkpoint();
            std::thread::yield_now();
        }
    };
    (begun, work)
}

async fn until_idle(pool: &WorkPool) {
    while pool.busy() > 0 {
        tokio::task::yield_now().await;
    }
}

#[tokio::test]
async fn work_with_a_callers_handle_outlives_its_waiter() {
    let pool = WorkPool::new(1, 4).unwrap();
    let (begun, work) = endless();
    let handle = Handle::new();
    {
        let mut running = Box::pin(pool.run_with(handle.clone(), work));
        let started = tokio::select! {
            started = begun => started,
            _ = &mut running => panic!("it has no end"),
        };
        started.unwrap();
    }
    // the next one has to wait: the work goes on
    let mut next = Box::pin(pool.run(|| 1));
    for _ in 0..100 {
        assert!(std::future::poll_fn(|cx| std::task::Poll::Ready(next.as_mut().poll(cx).is_pending())).await);
        std::thread::yield_now();
    }
    assert_eq!(pool.busy(), 1);
    handle.cancel();
    assert_eq!(next.await, Ok(1));
    assert_eq!(pool.run_with(handle, || 1).await, Err(PoolError::Cancelled));
}

#[tokio::test]
async fn a_stopped_pool_cancels_running_and_waiting_work() {
    let pool = Arc::new(WorkPool::new(1, 4).unwrap());
    let (begun, work) = endless();
    let running = tokio::spawn({
        let pool = Arc::clone(&pool);
        async move { pool.run(work).await }
    });
    begun.await.unwrap();
    let mut waiting = Box::pin(pool.run(|| true));
    assert!(std::future::poll_fn(|cx| std::task::Poll::Ready(waiting.as_mut().poll(cx).is_pending())).await);
    pool.stop();
    assert_eq!(waiting.await, Err(PoolError::Stopped));
    assert_eq!(running.await.unwrap(), Err(PoolError::Cancelled));
    assert_eq!(pool.run(|| true).await, Err(PoolError::Stopped));
    until_idle(&pool).await;
}

#[tokio::test]
async fn cancelled_work_is_counted_with_its_seconds() {
    let pool = WorkPool::new(1, 4).unwrap();
    let (begun, work) = endless();
    {
        let mut running = Box::pin(pool.run(work));
        tokio::select! {
            started = begun => started.unwrap(),
            _ = &mut running => panic!("it has no end"),
        }
    }
    until_idle(&pool).await;
    assert_eq!(pool.run(|| 1).await, Ok(1));
    let text = telemetry::metrics().render();
    let mut counts = text.lines().filter(|line| line.starts_with("flankfit_cancelled_work_seconds_count"));
    assert!(counts.any(|line| line.contains("abandoned") && !line.ends_with(" 0")), "{text}");
}
