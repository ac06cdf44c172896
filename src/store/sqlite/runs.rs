//! Jobs that are stored with all their iterations.

use sqlx::SqliteConnection;

use super::{answers, audit, insert_iterations, jobs};
use crate::{
    jobs::{
        NewRun, Stored,
        audit::{Action, Chain},
    },
    store::shared::{Asked, Growing, InsertRuns, Outcome, StoreError, Write, target},
};

impl Write<SqliteConnection> for InsertRuns {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertRuns { receipt, now, .. }, tenant) = (&asked.write, asked.tenant());
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        for (NewRun { job, .. }, of_job, iterations) in asked.by_runs() {
            jobs::insert(db, tenant, job).await?;
            let mut chain = Growing::from(tenant, Chain::Job(job.id), None);
            chain.add(asked.by(), of_job.clone(), Action::CreateJob, target::job(job.id));
            audit::store(db, chain).await?;
            // of a job that is there and without a key none is refused; were one, all would be
            // undone
            for stored in insert_iterations::insert(db, &iterations).await.map_err(StoreError::too_late)? {
                stored.map_err(|error| StoreError::from(error).too_late())?;
            }
        }
        let stored = Stored { number: 0, version: 1 };
        answers::keep(db, tenant, receipt.as_ref(), stored, *now, None).await?;
        Ok(stored)
    }
}
