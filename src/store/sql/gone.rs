//! Purges of jobs.

use super::prelude::*;

row! {
    /// The purge of a job, where a write looks the job up.
    pub struct JobPurge {
        purged_at: Option<Timestamp>,
        purge_reason: Option<String>,
    }
}

impl JobPurge {
    /// A purged job takes nothing more.
    pub fn refuse(&self) -> Result<(), RepositoryError> {
        match self.purged_at {
            None => Ok(()),
            Some(at) => Err(RepositoryError::Purged { at, reason: self.purge_reason.clone().unwrap_or_default() }),
        }
    }

    /// Returns the refusal of something that was removed. Where there is no purge, it was lost
    /// otherwise.
    pub fn refusal(purge: Option<Self>) -> RepositoryError {
        purge
            .and_then(|purge| purge.refuse().err())
            .unwrap_or_else(|| RepositoryError::Failed(damaged("a row of a job", "empty, but the job was not purged")))
    }
}

/// Returns the refusal of something of a job that was taken away.
pub async fn refusal(db: &mut Db, job: Uuid) -> StoreError {
    let sql = "SELECT at AS purged_at, reason AS purge_reason FROM purges WHERE job = $1";
    match db.maybe(sql, args![job]).await {
        Ok(purge) => JobPurge::refusal(purge).into(),
        Err(error) => error.into(),
    }
}

/// Refuses a purged job. A job that does not exist is not refused.
pub async fn refuse(db: &mut Db, tenant: &Tenant, job: Uuid) -> Outcome<()> {
    let sql = "SELECT p.at AS purged_at, p.reason AS purge_reason FROM jobs j JOIN purges p ON p.job = j.id
               WHERE j.id = $1 AND j.tenant = $2";
    let purge: Option<JobPurge> = db.maybe(sql, args![job, tenant]).await?;
    Ok(purge.map_or(Ok(()), |purge| purge.refuse())?)
}
