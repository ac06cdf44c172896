//! Jobs that are stored with all their iterations.

use sqlx::SqliteConnection;

use super::{answers, insert_iterations, jobs};
use crate::{
    jobs::{Caller, NewRun, Stored},
    store::shared::{Incoming, InsertRuns, Outcome, StoreError, Write},
};

impl Write<SqliteConnection> for InsertRuns {
    async fn write(&self, Caller { tenant, .. }: &Caller, db: &mut SqliteConnection) -> Outcome<Stored> {
        answers::refuse_taken(db, tenant, self.receipt.as_ref()).await?;
        for NewRun { job, iterations } in &self.runs {
            jobs::insert(db, tenant, job).await?;
            let incoming = |iteration| Incoming { tenant, iteration, receipt: None };
            let iterations: Vec<Incoming<'_>> = iterations.iter().map(|iteration| incoming(iteration)).collect();
            // of a job that is there and without a key none is refused; were one, all would be
            // undone
            for stored in insert_iterations::insert(db, &iterations).await.map_err(StoreError::too_late)? {
                stored.map_err(|error| StoreError::from(error).too_late())?;
            }
        }
        let stored = Stored { number: 0, version: 1 };
        answers::keep(db, tenant, self.receipt.as_ref(), stored, self.now, None).await?;
        Ok(stored)
    }
}
