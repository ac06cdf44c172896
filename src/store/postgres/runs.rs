//! Jobs that are stored with all their iterations.

use super::{jobs, session::Session};
use crate::{
    jobs::{NewRun, Stored, audit::Action},
    store::shared::{Asked, InsertRuns, InsertTogether as _, Outcome, StoreError, Write, target},
};

impl Write<Session> for InsertRuns {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertRuns { receipt, now, .. }, tenant) = (&asked.write, asked.tenant());
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        for (NewRun { job, .. }, of_job, iterations) in asked.by_runs() {
            let chain = session.new_chain(tenant, job.id);
            chain.add(asked.by(), of_job.clone(), Action::CreateJob, target::job(job.id));
            jobs::insert(&mut session.db, tenant, job).await?;
            // of a job that is there and without a key none is refused; were one, all would be
            // undone
            for stored in session.insert(&iterations).await.map_err(StoreError::too_late)? {
                stored.map_err(|error| StoreError::from(error).too_late())?;
            }
        }
        let stored = Stored { number: 0, version: 1 };
        session.keys.keep(tenant, receipt.as_ref(), stored, *now, None);
        Ok(stored)
    }
}
