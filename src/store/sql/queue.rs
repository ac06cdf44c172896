//! Writes that wait for a transaction which they share.
//!
//! Everybody may put a write in; one task takes out the writes that wait, up to a limit of count
//! and of bytes, runs them inside one transaction and ends each write after the commit. While one
//! group is being synced the next one gathers, so the more writes come, the more share a sync.

use std::{any::Any, pin::Pin, time::Instant};

use sqlx::Error;
use tokio::sync::{mpsc, oneshot};

use super::{prelude::*, session::Session, write::Request};

/// Writes in one transaction.
const MOST_WRITES: usize = 128;
/// Bytes of nodes and responses in one transaction, roughly: big node sets do not pile up in one.
const MOST_BYTES: usize = 32 << 20;

/// A write with its outcome and the place of its reply.
pub struct Pending<W: Write> {
    pub request: Request,
    pub write: W,
    outcome: Option<Result<W::Reply, RepositoryError>>,
    reply: oneshot::Sender<Result<W::Reply, RepositoryError>>,
}

impl<W: Write> Pending<W> {
    /// Notes the outcome, which counts if the transaction is committed.
    pub fn note(&mut self, outcome: Result<W::Reply, RepositoryError>) {
        self.outcome = Some(outcome);
    }
}

type Running<'a> = Pin<Box<dyn Future<Output = Result<(), Error>> + Send + 'a>>;

/// A write that waits, on its way through a transaction.
pub trait Queued: Send {
    /// Returns who requests it, and what it is about.
    fn request(&self) -> &Request;

    /// Returns a new iteration, which runs together with the others of its group.
    fn iteration(&mut self) -> Option<&mut Pending<InsertIteration>>;

    fn run<'a>(&'a mut self, session: &'a mut Session) -> Running<'a>;

    /// Replies, after the transaction: with the outcome, or with the reason why nothing of the
    /// transaction was stored.
    fn end(self: Box<Self>, failure: Option<RepositoryError>);
}

/// Writes that share a transaction.
pub type Group = Vec<Box<dyn Queued>>;

impl<W: Write> Queued for Pending<W> {
    fn request(&self) -> &Request {
        &self.request
    }

    fn iteration(&mut self) -> Option<&mut Pending<InsertIteration>> {
        (self as &mut dyn Any).downcast_mut()
    }

    fn run<'a>(&'a mut self, session: &'a mut Session) -> Running<'a> {
        Box::pin(async move {
            let outcome = match self.write.run(&mut Tx { session, request: &self.request }).await {
                Ok(reply) => Ok(reply),
                Err(StoreError::Refused(error)) => Err(error),
                Err(StoreError::Broken(error)) => return Err(error),
            };
            self.note(outcome);
            Ok(())
        })
    }

    fn end(self: Box<Self>, failure: Option<RepositoryError>) {
        let Pending { request: _, write, outcome, reply } = *self;
        let lost = || Err(RepositoryError::Failed("a write ended without an outcome".into()));
        let outcome = failure.map_or_else(|| outcome.unwrap_or_else(lost), Err);
        // First of all the idempotency key is given back: the caller may ask again as soon as the
        // outcome is known.
        drop(write);
        // Whoever asked may be gone; the write is done.
        let _gone = reply.send(outcome);
    }
}

enum Message {
    Write(Box<dyn Queued>),
    /// Finish what was sent before, close the database, answer.
    Close(oneshot::Sender<()>),
}

/// The end at which writes are put in.
pub struct Queue {
    sender: mpsc::Sender<Message>,
    seconds: metrics::Histogram,
}

/// The end at which they are taken out.
pub struct Waiting {
    incoming: mpsc::Receiver<Message>,
    closing: Option<oneshot::Sender<()>>,
}

/// Makes a queue of so many places. `seconds` records the duration of each write.
pub fn queue(places: usize, seconds: metrics::Histogram) -> (Queue, Waiting) {
    let (sender, incoming) = mpsc::channel(places.max(1));
    (Queue { sender, seconds }, Waiting { incoming, closing: None })
}

impl Queue {
    /// The write is in the queue before this returns its future: dropping the future changes
    /// nothing.
    pub fn write<W: Write>(
        &self,
        request: Request,
        write: W,
    ) -> impl Future<Output = Result<W::Reply, RepositoryError>> + use<W> {
        let begun = Instant::now();
        let seconds = self.seconds.clone();
        let (reply, outcome) = oneshot::channel();
        let write = Pending { request, write, outcome: None, reply };
        let sent = self.sender.try_send(Message::Write(Box::new(write))).map_err(|error| match error {
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

    /// Waits until the writes in the queue are done and the database closed. Later writes are
    /// refused.
    pub async fn close(&self) {
        let (closed, done) = oneshot::channel();
        if self.sender.send(Message::Close(closed)).await.is_ok() {
            let _gone = done.await;
        }
    }
}

impl Waiting {
    /// Returns all writes that wait, up to the limits, at least one; `None` when no more can come.
    pub async fn next_group(&mut self) -> Option<Group> {
        let mut group = Vec::new();
        let mut bytes = 0;
        while group.is_empty() {
            let mut next = Some(self.incoming.recv().await?);
            while let Some(message) = next {
                match message {
                    Message::Write(write) => {
                        bytes += write.request().bytes;
                        group.push(write);
                    }
                    Message::Close(closed) => {
                        // Writes in the channel are still received; later ones are refused.
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

    /// Answers the call of [`Queue::close`].
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
    use crate::store::sql::{error::Outcome, write::Subject};

    struct Nothing;

    impl Write for Nothing {
        type Reply = ();

        async fn run(&self, _: &mut Tx<'_>) -> Outcome<()> {
            Ok(())
        }
    }

    /// Returns the sizes of the groups in which writes of so many bytes are taken out.
    async fn groups(writes: &[usize]) -> Vec<usize> {
        let (queue, mut waiting) = queue(writes.len(), metrics::Histogram::noop());
        let of = |bytes: &usize| queue.write(Request::of_nobody(Subject::Nothing, *bytes), Nothing);
        let _all: Vec<_> = writes.iter().map(of).collect();
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
        // the write that passes the bound is in the group
        let megabytes = |each: &[usize]| each.iter().map(|count| count << 20).collect::<Vec<_>>();
        assert_eq!(groups(&megabytes(&[12; 7])).await, [3, 3, 1]);
        assert_eq!(groups(&megabytes(&[16, 16, 16, 1, 15])).await, [2, 3]);
        assert_eq!(groups(&megabytes(&[31, 0, 500, 1, 40, 40])).await, [3, 2, 1]);
        assert_eq!(groups(&[]).await, [0; 0]);
    }
}
