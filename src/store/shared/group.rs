//! A group of writes inside one transaction.

use super::{
    error::{Outcome, StoreError},
    incoming::Incoming,
    operation::{Asked, InsertIteration},
    queue::{Pending, Queued},
};
use crate::jobs::{RepositoryError, Stored};

/// A connection on which many iterations are inserted at once.
pub trait InsertTogether: Send + Sized {
    /// Stores what can be stored and refuses the rest, in the order given. It is refused as a whole
    /// only before anything was changed.
    fn insert(
        &mut self,
        incoming: &[Incoming<'_>],
    ) -> impl Future<Output = Outcome<Vec<Result<Stored, RepositoryError>>>> + Send;
}

/// Does each write of a group, and all its iterations together; notes what came of each.
pub async fn run_group<C: InsertTogether>(db: &mut C, group: &mut [Queued<C>]) -> Result<(), sqlx::Error> {
    let mut iterations = Vec::new();
    for write in group {
        match write {
            Queued::Iteration(pending) => iterations.push(&mut **pending),
            Queued::Single(pending) => pending.run(&mut *db).await?,
        }
    }
    match iterations.is_empty() {
        true => Ok(()),
        false => insert(db, iterations).await,
    }
}

/// Inserts iterations together. Where they are refused together, because the row of one job does
/// not read, each is tried by itself.
async fn insert<C: InsertTogether>(
    db: &mut C,
    iterations: Vec<&mut Pending<Asked<InsertIteration>>>,
) -> Result<(), sqlx::Error> {
    let incoming: Vec<Incoming<'_>> = iterations.iter().map(|pending| Incoming::of(&pending.operation)).collect();
    match db.insert(&incoming).await {
        Ok(replies) => {
            iterations.into_iter().zip(replies).for_each(|(pending, reply)| pending.note(reply));
            Ok(())
        }
        Err(StoreError::Broken(error)) => Err(error),
        Err(StoreError::Refused(_)) => {
            for pending in iterations {
                match db.insert(&[Incoming::of(&pending.operation)]).await {
                    Ok(replies) => replies.into_iter().for_each(|reply| pending.note(reply)),
                    Err(StoreError::Refused(error)) => pending.note(Err(error)),
                    Err(StoreError::Broken(error)) => return Err(error),
                }
            }
            Ok(())
        }
    }
}
