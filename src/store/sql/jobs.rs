//! Jobs.

use uuid::Uuid;

use super::{
    columns::tags_text,
    db::Db,
    error::Outcome,
    gone,
    row::{MeasuredTooth, job_columns},
    streams, subject,
    write::{Intent, Tx, Write},
    writes::{DeleteJob, InsertJob, PatchJob},
};
use crate::jobs::{Caller, Job, JobGear, RepositoryError, Resource, Stored, Tenant, audit::Action};

/// Returns a job of a tenant.
pub async fn located(db: &mut Db, tenant: &Tenant, id: Uuid) -> Outcome<Job> {
    let sql = concat!("SELECT ", job_columns!(), " FROM jobs WHERE id = $1 AND tenant = $2");
    Ok(db.maybe(sql, args![id, tenant]).await?.ok_or(RepositoryError::NotFound(Resource::Job))?)
}

pub async fn job(db: &mut Db, caller: &Caller, id: &Uuid) -> Outcome<Job> {
    located(db, &caller.tenant, *id).await
}

/// A purged job stays as it is.
async fn refuse_purged(db: &mut Db, job: &Job) -> Outcome<()> {
    match job.purged_at {
        None => Ok(()),
        Some(_) => Err(gone::refusal(db, job.id).await),
    }
}

/// Stores a job of the caller's tenant, with its entry.
pub async fn create(tx: &mut Tx<'_>, job: &Job) -> Outcome<()> {
    let mut entry = tx.draft(job.id, Action::CreateJob, subject::job(job.id))?;
    let tenant = tx.tenant();
    insert(tx.db(), tenant, job).await?;
    entry.note_stored(tx.db(), "jobs", "id = $1", args![job.id]).await?;
    tx.enter(entry);
    Ok(())
}

/// Stores a job of a tenant.
async fn insert(db: &mut Db, tenant: &Tenant, job: &Job) -> Outcome<()> {
    db.run(
        "INSERT INTO jobs (tenant, id, name, part_number, serial_number, machine, gear, requirements, tags, version,
                           created_at, updated_at, folded)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
        args![
            tenant,
            job.id,
            &job.name,
            job.part_number.as_deref(),
            job.serial_number.as_deref(),
            job.machine.as_deref(),
            job.gear.as_deref(),
            job.requirements.as_deref(),
            tags_text(&job.tags),
            job.version,
            job.created_at,
            job.updated_at,
            job.searched(),
        ],
    )
    .await?;
    Ok(())
}

impl Write for InsertJob {
    type Reply = Stored;

    fn intent(&self) -> Intent<'_> {
        Intent::job(self.job.id).receipt(&self.receipt)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Stored> {
        let job = &self.job;
        tx.refuse_taken()?;
        create(tx, job).await?;
        let stored = Stored { number: 0, version: job.version };
        tx.keep(&self.receipt, stored, None, job.created_at);
        Ok(stored)
    }
}

impl Write for PatchJob {
    type Reply = Job;

    fn intent(&self) -> Intent<'_> {
        Intent::job(self.id)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Job> {
        let tenant = tx.tenant();
        let before = located(tx.db(), tenant, self.id).await?;
        refuse_purged(tx.db(), &before).await?;
        self.precondition.check(before.version)?;
        let after = before.patched(self.patch.clone(), self.now);
        if after.gear != before.gear {
            refuse_fewer_teeth(tx.db(), self.id, after.gear.as_ref()).await?;
        }
        if after.version != before.version {
            let mut entry = tx.draft(self.id, Action::ChangeJob, subject::job(self.id))?;
            let db = tx.db();
            db.run(
                "UPDATE jobs SET name = $1, part_number = $2, serial_number = $3, machine = $4, gear = $5,
                            requirements = $6, tags = $7, version = $8, updated_at = $9, folded = $10 WHERE id = $11",
                args![
                    &after.name,
                    after.part_number.as_deref(),
                    after.serial_number.as_deref(),
                    after.machine.as_deref(),
                    after.gear.as_deref(),
                    after.requirements.as_deref(),
                    tags_text(&after.tags),
                    after.version,
                    after.updated_at,
                    after.searched(),
                    self.id,
                ],
            )
            .await?;
            entry.note_stored(db, "jobs", "id = $1", args![self.id]).await?;
            entry.note_event(db, self.id).await?;
            tx.enter(entry);
        }
        Ok(after)
    }
}

/// Refuses a gear without a tooth that the job's iterations, or streams that may become some, are
/// of.
async fn refuse_fewer_teeth(db: &mut Db, job: Uuid, gear: Option<&JobGear>) -> Outcome<()> {
    let Some(teeth) = gear.and_then(JobGear::teeth) else { return Ok(()) };
    let sql = "SELECT tooth, min(number) AS iteration FROM measured WHERE job = $1 AND tooth IS NOT NULL GROUP BY tooth
               UNION ALL
               SELECT DISTINCT tooth, CAST(NULL AS bigint) FROM streams
               WHERE job = $1 AND tooth IS NOT NULL AND iteration IS NULL";
    let measured: Vec<MeasuredTooth> = db.all(sql, args![job]).await?;
    Ok(MeasuredTooth::check(measured, teeth)?)
}

impl Write for DeleteJob {
    type Reply = ();

    fn intent(&self) -> Intent<'_> {
        Intent::job(self.id)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        let tenant = tx.tenant();
        let job = located(tx.db(), tenant, self.id).await?;
        refuse_purged(tx.db(), &job).await?;
        self.precondition.check(job.version)?;
        let sql = "SELECT count(*) FROM iterations WHERE job = $1";
        let iterations: u64 = tx.db().one(sql, args![self.id]).await?;
        if iterations > 0 {
            return Err(RepositoryError::HasIterations(iterations).into());
        }
        let entry = tx.draft(self.id, Action::DeleteJob, subject::job(self.id))?;
        streams::release_job(tx.db(), self.id).await?;
        tx.enter(entry);
        tx.db().run("DELETE FROM jobs WHERE id = $1", args![self.id]).await?;
        let told = "INSERT INTO told (tenant, job, state, created_at) VALUES ($1, $2, 'deleted', $3)";
        tx.session.db.run(told, args![tenant, self.id, tx.asked.at]).await?;
        Ok(())
    }
}
