//! A group of writes inside one transaction.

use std::panic::AssertUnwindSafe;

use futures_util::FutureExt as _;

use super::{
    error::StoreError,
    incoming::Incoming,
    insert_iterations::insert,
    queue::{Pending, Queued},
    session::Session,
    writes::InsertIteration,
};

/// Runs each write of a group, and all its iterations together; notes the outcome of each. A write
/// that panics is refused, and the others are tried without it.
pub async fn run_group(session: &mut Session, group: &mut [Box<dyn Queued>]) -> Result<(), sqlx::Error> {
    let panicked = |_| Err(sqlx::Error::InvalidArgument("a write panicked".into()));
    AssertUnwindSafe(run_each(session, group)).catch_unwind().await.unwrap_or_else(panicked)
}

async fn run_each(session: &mut Session, group: &mut [Box<dyn Queued>]) -> Result<(), sqlx::Error> {
    let mut iterations = Vec::new();
    for write in group {
        match write.iteration().is_some() {
            true => iterations.extend(write.iteration()),
            false => write.run(session).await?,
        }
    }
    match iterations.is_empty() {
        true => Ok(()),
        false => together(session, iterations).await,
    }
}

fn incoming(pending: &Pending<InsertIteration>) -> Incoming<'_> {
    let InsertIteration { iteration, receipt } = &pending.write;
    Incoming::of(&pending.request, iteration, receipt.as_ref())
}

/// Inserts iterations together. Where they are refused together, because the row of one job does
/// not read, each is tried alone.
async fn together(session: &mut Session, iterations: Vec<&mut Pending<InsertIteration>>) -> Result<(), sqlx::Error> {
    let all: Vec<Incoming<'_>> = iterations.iter().map(|pending| incoming(pending)).collect();
    match insert(session, &all).await {
        Ok(replies) => {
            iterations.into_iter().zip(replies).for_each(|(pending, reply)| pending.note(reply));
            Ok(())
        }
        Err(StoreError::Broken(error)) => Err(error),
        Err(StoreError::Refused(_)) => {
            for pending in iterations {
                match insert(session, &[incoming(pending)]).await {
                    Ok(replies) => replies.into_iter().for_each(|reply| pending.note(reply)),
                    Err(StoreError::Refused(error)) => pending.note(Err(error)),
                    Err(StoreError::Broken(error)) => return Err(error),
                }
            }
            Ok(())
        }
    }
}
