//! Jobs.

use sqlx::{SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::{
    answers, audit, gone,
    locate::{WithSeq, signed},
    streams, time,
};
use crate::{
    jobs::{
        Caller, Job, JobGear, RepositoryError, Resource, Stored, Tenant,
        audit::{Action, Chain, Prepared},
    },
    store::shared::{
        Asked, DeleteJob, GetJob, Growing, InsertJob, Integer, JobRow, MeasuredTooth, Outcome, PatchJob, Read, Tags,
        Write, job_columns, of_job, target,
    },
};

/// A job with its row.
pub async fn located(db: &mut SqliteConnection, tenant: &Tenant, id: Uuid) -> Outcome<(i64, Job)> {
    let found: Option<WithSeq<JobRow>> =
        sqlx::query_as(concat!("SELECT seq, ", job_columns!(), " FROM jobs WHERE id = ? AND tenant = ?"))
            .bind(id)
            .bind(tenant.as_str())
            .fetch_optional(db)
            .await?;
    let WithSeq { seq, row } = found.ok_or(RepositoryError::NotFound(Resource::Job))?;
    Ok((seq, row.into()))
}

/// A purged job stays as it is.
async fn refuse_purged(db: &mut SqliteConnection, job: &Job) -> Outcome<()> {
    match job.purged_at {
        None => Ok(()),
        Some(_) => Err(gone::told(db, job.id).await),
    }
}

impl Read<SqlitePool> for GetJob {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Job> {
        let mut db = from.acquire().await?;
        Ok(located(&mut db, &caller.tenant, self.id).await?.1)
    }
}

/// Stores a job of a tenant.
pub async fn insert(db: &mut SqliteConnection, tenant: &Tenant, job: &Job) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO jobs
             (tenant, id, name, part_number, serial_number, machine, gear, tags, version, created_at, updated_at,
              folded, requirements)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
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
    .bind(time::to_text(job.created_at))
    .bind(time::to_text(job.updated_at))
    .bind(job.searched())
    .bind(job.requirements.as_deref())
    .execute(db)
    .await?;
    Ok(())
}

impl Write<SqliteConnection> for InsertJob {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertJob { job, receipt }, tenant) = (&asked.write, asked.tenant());
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        insert(db, tenant, job).await?;
        let mut chain = Growing::from(tenant, Chain::Job(job.id), None);
        asked.enter(&mut chain, Action::CreateJob, target::job(job.id));
        audit::store(db, chain).await?;
        let stored = Stored { number: 0, version: job.version };
        answers::keep(db, tenant, receipt.as_ref(), stored, job.created_at, None).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for PatchJob {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Job> {
        let PatchJob { id, patch, precondition, now } = &asked.write;
        let (seq, before) = located(db, asked.tenant(), *id).await?;
        refuse_purged(db, &before).await?;
        precondition.check(before.version)?;
        let after = before.patched(patch.clone(), *now);
        if after.gear != before.gear {
            refuse_fewer_teeth(db, seq, after.gear.as_ref()).await?;
        }
        if after.version != before.version {
            let mut chain = audit::of_job(db, asked.by(), *id).await?;
            sqlx::query(
                "UPDATE jobs SET name = ?, part_number = ?, serial_number = ?, machine = ?, gear = ?, tags = ?,
                 version = ?, updated_at = ?, folded = ?, requirements = ? WHERE seq = ?",
            )
            .bind(after.name.as_str())
            .bind(after.part_number.as_deref())
            .bind(after.serial_number.as_deref())
            .bind(after.machine.as_deref())
            .bind(after.gear.as_deref())
            .bind(Tags::write(&after.tags))
            .bind(signed(after.version))
            .bind(time::to_text(after.updated_at))
            .bind(after.searched())
            .bind(after.requirements.as_deref())
            .bind(seq)
            .execute(&mut *db)
            .await?;
            let prepared = Prepared { contents: of_job(&after), ..asked.prepared() };
            chain.add(asked.by(), prepared, Action::ChangeJob, target::job(*id));
            audit::store(db, chain).await?;
        }
        Ok(after)
    }
}

/// Refuses a gear without a tooth that the job's iterations, or streams that may become some, are
/// of.
async fn refuse_fewer_teeth(db: &mut SqliteConnection, job: i64, gear: Option<&JobGear>) -> Outcome<()> {
    let Some(teeth) = gear.and_then(JobGear::teeth) else { return Ok(()) };
    let measured: Vec<MeasuredTooth> = sqlx::query_as(
        "SELECT tooth, min(number) AS iteration FROM measured WHERE job = ?1 AND tooth IS NOT NULL GROUP BY tooth
         UNION ALL
         SELECT DISTINCT tooth, NULL FROM streams WHERE job = ?1 AND tooth IS NOT NULL AND iteration IS NULL",
    )
    .bind(job)
    .fetch_all(db)
    .await?;
    Ok(MeasuredTooth::check(measured, teeth)?)
}

impl Write<SqliteConnection> for DeleteJob {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<()> {
        let DeleteJob { id, precondition } = &asked.write;
        let (seq, job) = located(db, asked.tenant(), *id).await?;
        refuse_purged(db, &job).await?;
        precondition.check(job.version)?;
        let iterations: Integer<u64> =
            sqlx::query_scalar("SELECT count(*) FROM iterations WHERE job = ?").bind(seq).fetch_one(&mut *db).await?;
        if iterations.0 > 0 {
            return Err(RepositoryError::HasIterations(iterations.0).into());
        }
        let mut chain = audit::of_job(db, asked.by(), *id).await?;
        streams::release_job(db, seq).await?;
        sqlx::query("DELETE FROM jobs WHERE seq = ?").bind(seq).execute(&mut *db).await?;
        sqlx::query("INSERT INTO told (tenant, job, state, created_at) VALUES (?, ?, 'deleted', ?)")
            .bind(asked.tenant().as_str())
            .bind(*id)
            .bind(time::to_text(asked.at))
            .execute(&mut *db)
            .await?;
        asked.enter(&mut chain, Action::DeleteJob, target::job(*id));
        audit::store(db, chain).await?;
        Ok(())
    }
}
