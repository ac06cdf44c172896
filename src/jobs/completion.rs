//! Futures that come to their end even if the one who waits for them leaves.

use std::{
    pin::Pin,
    task::{Context, Poll, ready},
    thread,
};

use tokio::runtime::Handle;
use tracing::Instrument as _;

/// A future that runs where it is awaited. If it is dropped before its end, a task runs the rest;
/// it is polled until then or dropped, since nothing else makes it go on.
pub struct ToCompletion<F>(Option<Pin<Box<F>>>)
where
    F: Future<Output: Send> + Send + 'static;

/// Makes a future come to its end once it was polled, or dropped.
pub fn to_completion<F: Future<Output: Send> + Send + 'static>(future: F) -> ToCompletion<F> {
    ToCompletion(Some(Box::pin(future)))
}

impl<F: Future<Output: Send> + Send + 'static> Future for ToCompletion<F> {
    type Output = F::Output;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<F::Output> {
        let rest = self.0.as_mut().expect("a future is not polled after its end");
        let output = ready!(rest.as_mut().poll(context));
        self.0 = None;
        Poll::Ready(output)
    }
}

impl<F: Future<Output: Send> + Send + 'static> Drop for ToCompletion<F> {
    fn drop(&mut self) {
        if let Some(rest) = self.0.take()
            && !thread::panicking()
            && let Ok(runtime) = Handle::try_current()
        {
            runtime.spawn(rest.in_current_span());
        }
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt as _;
    use tokio::sync::oneshot;

    use super::*;

    #[tokio::test]
    async fn a_dropped_future_runs_to_completion() {
        let (go, going) = oneshot::channel();
        let (ended, end) = oneshot::channel();
        let mut future = to_completion(async move {
            let value: u32 = going.await.unwrap();
            ended.send(value + 1).unwrap();
            value
        });
        assert!((&mut future).now_or_never().is_none());
        drop(future);
        go.send(6).unwrap();
        assert_eq!(end.await, Ok(7));
        assert_eq!(to_completion(async { 8 }).await, 8);
    }
}
