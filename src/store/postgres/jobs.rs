//! Jobs.

use sqlx::{PgConnection, PgPool};
use uuid::Uuid;

use super::{gone, locate::signed, session::Session, streams, time::stamp};
use crate::{
    jobs::{
        Caller, Job, JobGear, RepositoryError, Resource, Stored, Tenant,
        audit::{Action, Prepared},
    },
    store::shared::{
        Asked, DeleteJob, GetJob, InsertJob, Integer, JobRow, MeasuredTooth, Outcome, PatchJob, Read, Tags, Write,
        job_columns, of_job, target,
    },
};

/// A job.
pub async fn located(db: &mut PgConnection, tenant: &Tenant, id: Uuid) -> Outcome<Job> {
    let row: Option<JobRow> =
        sqlx::query_as(concat!("SELECT ", job_columns!(), " FROM jobs WHERE id = $1 AND tenant = $2"))
            .bind(id)
            .bind(tenant.as_str())
            .fetch_optional(db)
            .await?;
    Ok(row.ok_or(RepositoryError::NotFound(Resource::Job))?.into())
}

/// A purged job stays as it is.
async fn refuse_purged(db: &mut PgConnection, job: &Job) -> Outcome<()> {
    match job.purged_at {
        None => Ok(()),
        Some(_) => Err(gone::told(db, job.id).await),
    }
}

impl Read<PgPool> for GetJob {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Job> {
        let mut db = from.acquire().await?;
        located(&mut db, &caller.tenant, self.id).await
    }
}

/// Stores a job of a tenant.
pub async fn insert(db: &mut PgConnection, tenant: &Tenant, job: &Job) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO jobs
             (tenant, id, name, part_number, serial_number, machine, gear, tags, version, created_at, updated_at,
              folded, requirements)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
    )
    .bind(tenant.as_str())
    .bind(job.id)
    .bind(job.name.as_str())
    .bind(job.part_number.as_deref())
    .bind(job.serial_number.as_deref())
    .bind(job.machine.as_deref())
    .bind(job.gear.as_deref())
    .bind(Tags::write(&job.tags))
    .bind(signed(job.version))
    .bind(stamp(job.created_at))
    .bind(stamp(job.updated_at))
    .bind(job.searched())
    .bind(job.requirements.as_deref())
    .execute(db)
    .await?;
    Ok(())
}

impl Write<Session> for InsertJob {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertJob { job, receipt }, tenant) = (&asked.write, asked.tenant());
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        asked.enter(session.new_chain(tenant, job.id), Action::CreateJob, target::job(job.id));
        insert(&mut session.db, tenant, job).await?;
        let stored = Stored { number: 0, version: job.version };
        session.keys.keep(tenant, receipt.as_ref(), stored, job.created_at, None);
        Ok(stored)
    }
}

impl Write<Session> for PatchJob {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Job> {
        let PatchJob { id, patch, precondition, now } = &asked.write;
        let before = located(&mut session.db, asked.tenant(), *id).await?;
        refuse_purged(&mut session.db, &before).await?;
        precondition.check(before.version)?;
        let after = before.patched(patch.clone(), *now);
        if after.gear != before.gear {
            refuse_fewer_teeth(&mut session.db, *id, after.gear.as_ref()).await?;
        }
        if after.version != before.version {
            let prepared = Prepared { contents: of_job(&after), ..asked.prepared() };
            session.chain(asked.by(), *id).await?.add(asked.by(), prepared, Action::ChangeJob, target::job(*id));
            sqlx::query(
                "UPDATE jobs SET name = $1, part_number = $2, serial_number = $3, machine = $4, gear = $5, tags = $6,
                 version = $7, updated_at = $8, folded = $9, requirements = $10 WHERE id = $11",
            )
            .bind(after.name.as_str())
            .bind(after.part_number.as_deref())
            .bind(after.serial_number.as_deref())
            .bind(after.machine.as_deref())
            .bind(after.gear.as_deref())
            .bind(Tags::write(&after.tags))
            .bind(signed(after.version))
            .bind(stamp(after.updated_at))
            .bind(after.searched())
            .bind(after.requirements.as_deref())
            .bind(*id)
            .execute(&mut session.db)
            .await?;
        }
        Ok(after)
    }
}

/// Refuses a gear without a tooth that the job's iterations, or streams that may become some, are
/// of.
async fn refuse_fewer_teeth(db: &mut PgConnection, job: Uuid, gear: Option<&JobGear>) -> Outcome<()> {
    let Some(teeth) = gear.and_then(JobGear::teeth) else { return Ok(()) };
    let measured: Vec<MeasuredTooth> = sqlx::query_as(
        "SELECT tooth, min(number) AS iteration FROM measured WHERE job = $1 AND tooth IS NOT NULL GROUP BY tooth
         UNION ALL
         SELECT DISTINCT tooth, NULL::bigint FROM streams WHERE job = $1 AND tooth IS NOT NULL AND iteration IS NULL",
    )
    .bind(job)
    .fetch_all(db)
    .await?;
    Ok(MeasuredTooth::check(measured, teeth)?)
}

impl Write<Session> for DeleteJob {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<()> {
        let DeleteJob { id, precondition } = &asked.write;
        let db = &mut session.db;
        let job = located(db, asked.tenant(), *id).await?;
        refuse_purged(db, &job).await?;
        precondition.check(job.version)?;
        let iterations: Integer<u64> =
            sqlx::query_scalar("SELECT count(*) FROM iterations WHERE job = $1").bind(*id).fetch_one(&mut *db).await?;
        if iterations.0 > 0 {
            return Err(RepositoryError::HasIterations(iterations.0).into());
        }
        streams::release_job(db, *id).await?;
        session.enter(asked, *id, Action::DeleteJob, target::job(*id)).await?;
        sqlx::query("DELETE FROM jobs WHERE id = $1").bind(*id).execute(&mut session.db).await?;
        sqlx::query("INSERT INTO told (tenant, job, state, created_at) VALUES ($1, $2, 'deleted', $3)")
            .bind(asked.tenant().as_str())
            .bind(*id)
            .bind(stamp(asked.at))
            .execute(&mut session.db)
            .await?;
        Ok(())
    }
}
