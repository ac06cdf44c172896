//! Jobs that are stored with all their iterations.

use super::{jobs, session::Session};
use crate::{
    jobs::{Caller, NewRun, Stored},
    store::shared::{Incoming, InsertRuns, InsertTogether as _, Outcome, StoreError, Write},
};

impl Write<Session> for InsertRuns {
    async fn write(&self, Caller { tenant, .. }: &Caller, session: &mut Session) -> Outcome<Stored> {
        session.keys.refuse_taken(tenant, self.receipt.as_ref())?;
        for NewRun { job, iterations } in &self.runs {
            jobs::insert(&mut session.db, tenant, job).await?;
            let incoming = |iteration| Incoming { tenant, iteration, receipt: None };
            let iterations: Vec<Incoming<'_>> = iterations.iter().map(|iteration| incoming(iteration)).collect();
            // of a job that is there and without a key none is refused; were one, all would be
            // undone
            for stored in session.insert(&iterations).await.map_err(StoreError::too_late)? {
                stored.map_err(|error| StoreError::from(error).too_late())?;
            }
        }
        let stored = Stored { number: 0, version: 1 };
        session.keys.keep(tenant, self.receipt.as_ref(), stored, self.now, None);
        Ok(stored)
    }
}
