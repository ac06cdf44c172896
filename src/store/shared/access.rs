//! Execution of operations by a database: the SQL of each operation is an implementation of one of
//! these.

use super::{
    error::Outcome,
    operation::{Asked, Operation},
    queue::{Pending, Queued, Run},
};
use crate::jobs::Caller;

/// A read from the readers of some database, in one consistent state.
pub trait Read<P>: Operation {
    fn read(&self, caller: &Caller, from: &P) -> impl Future<Output = Outcome<Self::Reply>> + Send;
}

/// A write on a connection of some database, inside a transaction.
///
/// It looks first and changes last: whatever it refuses, it refuses before its first change, so a
/// refusal leaves nothing to undo in the transaction that it shares with others. It may be done
/// more than once, because a transaction that failed may be repeated.
pub trait Write<C: Send>: Operation {
    ///
    /// Each change leaves its entry in the same transaction; what changes nothing leaves none.
    fn write(asked: &Asked<Self>, db: &mut C) -> impl Future<Output = Outcome<Self::Reply>> + Send
    where
        Self: Sized;

    /// How it waits: by itself, unless it is done together with others of its kind.
    fn queued(pending: Pending<Asked<Self>>) -> Queued<C>
    where
        Self: Sized,
    {
        Queued::Single(Box::new(pending))
    }
}

impl<C: Send, O: Write<C>> Run<C> for Asked<O> {
    async fn run(&self, db: &mut C) -> Outcome<O::Reply> {
        O::write(self, db).await
    }

    fn queued(pending: Pending<Self>) -> Queued<C> {
        O::queued(pending)
    }
}
