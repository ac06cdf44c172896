//! Writes that wait for a transaction which they share.
//!
//! Everybody may put a write in; one task takes out what waits, up to a limit of count and of
//! bytes, runs it inside one transaction and ends each write after the commit: while one group is
//! being synced the next one gathers, so the more writes come, the more share a sync.

use std::{pin::Pin, time::Instant};

use sqlx::Error;
use tokio::sync::{mpsc, oneshot};

use super::{
    error::{Outcome, StoreError},
    operation::{Asked, InsertIteration, Key, Operation},
    subject::Subject,
};
use crate::jobs::{Lease, RepositoryError};

/// Writes in one transaction.
const MOST_WRITES: usize = 128;
/// Bytes of nodes and answers in one transaction, roughly: big node sets do not pile up in one.
const MOST_BYTES: usize = 32 << 20;

/// How an operation is done on a connection of some database, inside a transaction.
pub trait Run<C: Send>: Operation {
    fn run(&self, db: &mut C) -> impl Future<Output = Outcome<Self::Reply>> + Send;

    /// How it waits.
    fn queued(pending: Pending<Self>) -> Queued<C>
    where
        Self: Sized,
    {
        Queued::Single(Box::new(pending))
    }
}

/// An operation with what came of it and the place of its reply.
pub struct Pending<O: Operation> {
    pub operation: O,
    outcome: Option<Result<O::Reply, RepositoryError>>,
    reply: oneshot::Sender<Result<O::Reply, RepositoryError>>,
}

impl<O: Operation> Pending<O> {
    /// What came of it, if the transaction is committed.
    pub fn note(&mut self, outcome: Result<O::Reply, RepositoryError>) {
        self.outcome = Some(outcome);
    }

    fn end(self, failure: Option<RepositoryError>) {
        let Pending { operation, outcome, reply } = self;
        let lost = || Err(RepositoryError::Failed("a write ended without an outcome".into()));
        let outcome = failure.map_or_else(|| outcome.unwrap_or_else(lost), Err);
        // First of all the idempotency key is given back: whoever hears the outcome may ask again
        // at once.
        drop(operation);
        // Whoever asked may be gone; what was asked is done.
        let _gone = reply.send(outcome);
    }
}

type Running<'a> = Pin<Box<dyn Future<Output = Result<(), Error>> + Send + 'a>>;

/// A pending operation, whichever it is.
pub trait AnyPending<C>: Send {
    fn bytes(&self) -> usize;
    fn subject(&self) -> Subject;
    fn key(&self) -> Option<Key<'_>>;
    fn lease(&self) -> Option<Lease>;
    fn erases(&self) -> bool;
    fn run<'a>(&'a mut self, db: &'a mut C) -> Running<'a>;
    fn end(self: Box<Self>, failure: Option<RepositoryError>);
}

impl<C: Send, O: Run<C>> AnyPending<C> for Pending<O> {
    fn bytes(&self) -> usize {
        self.operation.bytes()
    }

    fn subject(&self) -> Subject {
        self.operation.subject()
    }

    fn key(&self) -> Option<Key<'_>> {
        self.operation.key()
    }

    fn lease(&self) -> Option<Lease> {
        self.operation.lease()
    }

    fn erases(&self) -> bool {
        self.operation.erases()
    }

    fn run<'a>(&'a mut self, db: &'a mut C) -> Running<'a> {
        Box::pin(async move {
            let outcome = match self.operation.run(db).await {
                Ok(reply) => Ok(reply),
                Err(StoreError::Refused(error)) => Err(error),
                Err(StoreError::Broken(error)) => return Err(error),
            };
            self.note(outcome);
            Ok(())
        })
    }

    fn end(self: Box<Self>, failure: Option<RepositoryError>) {
        Pending::end(*self, failure);
    }
}

/// A write that waits, on its way through a transaction.
pub enum Queued<C> {
    /// Done together with the others of its group.
    Iteration(Box<Pending<Asked<InsertIteration>>>),
    Single(Box<dyn AnyPending<C>>),
}

impl<C> Queued<C> {
    fn bytes(&self) -> usize {
        match self {
            Queued::Iteration(pending) => pending.operation.bytes(),
            Queued::Single(pending) => pending.bytes(),
        }
    }

    /// What it changes.
    pub fn subject(&self) -> Subject {
        match self {
            Queued::Iteration(pending) => pending.operation.subject(),
            Queued::Single(pending) => pending.subject(),
        }
    }

    /// The idempotency key that it uses.
    pub fn key(&self) -> Option<Key<'_>> {
        match self {
            Queued::Iteration(pending) => pending.operation.key(),
            Queued::Single(pending) => pending.key(),
        }
    }

    /// The lease under which a task asks for it.
    pub fn lease(&self) -> Option<Lease> {
        match self {
            Queued::Iteration(pending) => pending.operation.lease(),
            Queued::Single(pending) => pending.lease(),
        }
    }

    /// Whether what it takes away shall be nowhere afterwards.
    pub fn erases(&self) -> bool {
        match self {
            Queued::Iteration(_) => false,
            Queued::Single(pending) => pending.erases(),
        }
    }

    /// Answers, after the transaction: with what came of it, or with why all of it came to
    /// nothing.
    pub fn end(self, failure: Option<RepositoryError>) {
        match self {
            Queued::Iteration(pending) => Pending::end(*pending, failure),
            Queued::Single(pending) => pending.end(failure),
        }
    }
}

enum Message<C> {
    Write(Queued<C>),
    /// Finish what was sent before, close the database, answer.
    Close(oneshot::Sender<()>),
}

/// Where writes are put in.
pub struct Queue<C> {
    sender: mpsc::Sender<Message<C>>,
    seconds: metrics::Histogram,
}

/// Where they are taken out.
pub struct Waiting<C> {
    incoming: mpsc::Receiver<Message<C>>,
    closing: Option<oneshot::Sender<()>>,
}

/// A queue of so many places. `seconds` hears how long each write took.
pub fn queue<C>(places: usize, seconds: metrics::Histogram) -> (Queue<C>, Waiting<C>) {
    let (sender, incoming) = mpsc::channel(places.max(1));
    (Queue { sender, seconds }, Waiting { incoming, closing: None })
}

impl<C: Send> Queue<C> {
    /// The operation is in the queue before this returns its future: dropping the future changes
    /// nothing.
    pub fn write<O: Run<C>>(
        &self,
        operation: O,
    ) -> impl Future<Output = Result<O::Reply, RepositoryError>> + use<C, O> {
        let begun = Instant::now();
        let seconds = self.seconds.clone();
        let (reply, outcome) = oneshot::channel();
        let write = O::queued(Pending { operation, outcome: None, reply });
        let sent = self.sender.try_send(Message::Write(write)).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => RepositoryError::Overloaded,
            mpsc::error::TrySendError::Closed(_) => closed(),
        });
        async move {
            sent?;
            let outcome = outcome.await.unwrap_or_else(|_| Err(closed()));
            seconds.record(begun.elapsed());
            outcome
        }
    }

    /// Waits until what is in the queue is done and the database closed. Later writes are refused.
    pub async fn close(&self) {
        let (closed, done) = oneshot::channel();
        if self.sender.send(Message::Close(closed)).await.is_ok() {
            let _gone = done.await;
        }
    }
}

impl<C> Waiting<C> {
    /// Everything that waits, up to the limits, at least one; `None` when nothing more can come.
    pub async fn next_group(&mut self) -> Option<Vec<Queued<C>>> {
        let mut group = Vec::new();
        let mut bytes = 0;
        while group.is_empty() {
            let mut next = Some(self.incoming.recv().await?);
            while let Some(message) = next {
                match message {
                    Message::Write(write) => {
                        bytes += write.bytes();
                        group.push(write);
                    }
                    Message::Close(closed) => {
                        // What is in the channel is still received; what comes later is refused.
                        self.incoming.close();
                        self.closing = Some(closed);
                    }
                }
                let room = group.len() < MOST_WRITES && bytes < MOST_BYTES;
                next = if room { self.incoming.try_recv().ok() } else { None };
            }
        }
        Some(group)
    }

    /// Tells whoever closes that it is done.
    pub fn closed(self) {
        if let Some(closing) = self.closing {
            let _gone = closing.send(());
        }
    }
}

fn closed() -> RepositoryError {
    RepositoryError::Unavailable("the store is closed".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What takes so many bytes.
    struct Weighs(usize);

    impl Operation for Weighs {
        type Reply = ();

        fn bytes(&self) -> usize {
            self.0
        }
    }

    impl Run<()> for Weighs {
        async fn run(&self, (): &mut ()) -> Outcome<()> {
            Ok(())
        }
    }

    /// The sizes of the groups in which writes of so many bytes are taken out.
    async fn groups(writes: &[usize]) -> Vec<usize> {
        let (queue, mut waiting) = queue::<()>(writes.len(), metrics::Histogram::noop());
        let _all: Vec<_> = writes.iter().map(|bytes| queue.write(Weighs(*bytes))).collect();
        drop(queue);
        let mut sizes = Vec::new();
        while let Some(group) = waiting.next_group().await {
            sizes.push(group.len());
        }
        sizes
    }

    #[tokio::test]
    async fn a_group_has_bounds_of_count_and_of_bytes() {
        assert_eq!(groups(&[0; 300]).await, [128, 128, 44]);
        assert_eq!(groups(&[0; 128]).await, [128]);
        // the one that passes the bound is in it
        let megabytes = |each: &[usize]| each.iter().map(|count| count << 20).collect::<Vec<_>>();
        assert_eq!(groups(&megabytes(&[12; 7])).await, [3, 3, 1]);
        assert_eq!(groups(&megabytes(&[16, 16, 16, 1, 15])).await, [2, 3]);
        assert_eq!(groups(&megabytes(&[31, 0, 500, 1, 40, 40])).await, [3, 2, 1]);
        assert_eq!(groups(&[]).await, [0; 0]);
    }
}
