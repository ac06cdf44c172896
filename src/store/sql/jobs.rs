//! Jobs.

use super::{columns::tags_text, gone, prelude::*, streams, subject};

row! {
    /// A tooth that was measured, by an iteration or by a stream that may become one.
    struct MeasuredTooth {
        tooth: String,
        iteration: Option<u32>,
    }
}

impl MeasuredTooth {
    /// Refuses a gear with so many teeth, if it lacks one that was measured.
    fn check(measured: Vec<MeasuredTooth>, teeth: u32) -> Result<(), RepositoryError> {
        match measured.into_iter().find(|measured| has_no_tooth(&measured.tooth, teeth)) {
            None => Ok(()),
            Some(MeasuredTooth { tooth, iteration }) => Err(RepositoryError::ToothMeasured { tooth, teeth, iteration }),
        }
    }
}

/// The columns of a [`Job`].
macro_rules! job_columns {
    () => {
        "id, name, part_number, serial_number, machine, gear, requirements, tags, status, version, created_at, \
         updated_at, purged_at"
    };
}
pub(super) use job_columns;

from_row! {
    Job {
        id, name, part_number, serial_number, machine, gear, requirements, tags, status, version, created_at,
        updated_at, purged_at,
    }
}

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

pub async fn insert_job(tx: &mut Tx<'_>, write: &InsertJob) -> Outcome<Stored> {
    let job = &write.job;
    tx.refuse_taken()?;
    create(tx, job).await?;
    Ok(tx.keep(&write.receipt, Stored { number: 0, version: job.version }, None, job.created_at))
}

pub async fn patch_job(tx: &mut Tx<'_>, write: &PatchJob) -> Outcome<Job> {
    let tenant = tx.tenant();
    let before = located(tx.db(), tenant, write.id).await?;
    refuse_purged(tx.db(), &before).await?;
    write.precondition.check(before.version)?;
    let after = before.patched(write.patch.clone(), write.now);
    if after.gear != before.gear {
        refuse_fewer_teeth(tx.db(), write.id, after.gear.as_ref()).await?;
    }
    if after.version != before.version {
        let mut entry = tx.draft(write.id, Action::ChangeJob, subject::job(write.id))?;
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
                write.id,
            ],
        )
        .await?;
        entry.note_stored(db, "jobs", "id = $1", args![write.id]).await?;
        entry.note_event(db, write.id).await?;
        tx.enter(entry);
    }
    Ok(after)
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

pub async fn delete_job(tx: &mut Tx<'_>, write: &DeleteJob) -> Outcome<()> {
    let tenant = tx.tenant();
    let job = located(tx.db(), tenant, write.id).await?;
    refuse_purged(tx.db(), &job).await?;
    write.precondition.check(job.version)?;
    let sql = "SELECT count(*) FROM iterations WHERE job = $1";
    let iterations: u64 = tx.db().one(sql, args![write.id]).await?;
    if iterations > 0 {
        return Err(RepositoryError::HasIterations(iterations).into());
    }
    let entry = tx.draft(write.id, Action::DeleteJob, subject::job(write.id))?;
    streams::release_job(tx.db(), write.id).await?;
    tx.enter(entry);
    tx.db().run("DELETE FROM jobs WHERE id = $1", args![write.id]).await?;
    let told = "INSERT INTO told (tenant, job, state, created_at) VALUES ($1, $2, 'deleted', $3)";
    tx.session.db.run(told, args![tenant, write.id, tx.request.at]).await?;
    Ok(())
}
