//! Jobs that are stored with all their iterations.

use sqlx::SqliteConnection;

use super::{answers, insert_iterations, jobs};
use crate::{
    jobs::Stored,
    store::shared::{InsertIteration, InsertRuns, Outcome, Run, StoreError},
};

impl Run<SqliteConnection> for InsertRuns {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<Stored> {
        answers::refuse_taken(db, self.receipt.as_ref()).await?;
        for (job, iterations) in &self.runs {
            jobs::insert(db, job, None).await?;
            let iterations: Vec<&InsertIteration> = iterations.iter().collect();
            // of a job that is there and without a key none is refused; were one, all would be
            // undone
            for stored in insert_iterations::insert(db, &iterations).await.map_err(StoreError::too_late)? {
                stored.map_err(|error| StoreError::from(error).too_late())?;
            }
        }
        let stored = Stored { number: 0, version: 1 };
        answers::keep(db, self.receipt.as_ref(), stored, self.now).await?;
        Ok(stored)
    }
}
