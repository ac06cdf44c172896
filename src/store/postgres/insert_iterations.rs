//! New iterations, many at once.
//!
//! This is the path that a measuring machine's every grid takes. The jobs of a group are looked up
//! together, its iterations numbered in memory and inserted by one statement for each table, so
//! that the way to the database and back is made a few times a group instead of a few times a
//! request. The jobs are locked, so a number read is a number free.

use std::collections::{BTreeMap, HashMap, HashSet};

use jiff::Timestamp;
use sqlx::PgConnection;
use uuid::Uuid;

use super::{
    fits::{self, Placed},
    keys::{FitPlace, Keys, StoredFit},
    locate::signed,
    records,
    session::Session,
    time::stamp,
};
use crate::{
    jobs::{NewIteration, RepositoryError, Resource, Stored},
    store::shared::{
        Asked, Incoming, InsertIteration, InsertTogether, Integer, JobPurge, Key, Outcome, Pending, Queued, StoreError,
        Write,
    },
};

impl Write<Session> for InsertIteration {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let stored = session.insert(&[Incoming::of(asked)]).await?.pop();
        Ok(stored.unwrap_or(Err(RepositoryError::NotFound(Resource::Job)))?)
    }

    fn queued(pending: Pending<Asked<Self>>) -> Queued<Session> {
        Queued::Iteration(Box::new(pending))
    }
}

impl InsertTogether for Session {
    async fn insert(&mut self, incoming: &[Incoming<'_>]) -> Outcome<Vec<Result<Stored, RepositoryError>>> {
        let mut last = last_numbers(&mut self.db, incoming).await?;
        let mut used = HashSet::new();
        let mut replies = Vec::with_capacity(incoming.len());
        let mut accepted = Vec::with_capacity(incoming.len());
        for new in incoming.iter().copied() {
            replies.push(number(&mut last, &self.keys, &mut used, new).map(|number| {
                accepted.push(Numbered { new, number });
                Stored { number, version: 1 }
            }));
        }
        for Numbered { new, number } in &accepted {
            let (action, target) = new.deed(*number);
            let chain = self.chain(new.by, new.iteration.job_id).await?;
            chain.add(new.by, new.prepared.clone(), action, target);
        }
        if !accepted.is_empty() {
            change(self, &accepted).await.map_err(StoreError::too_late)?;
        }
        Ok(replies)
    }
}

/// An iteration with its number.
struct Numbered<'a> {
    new: Incoming<'a>,
    number: u32,
}

impl Numbered<'_> {
    fn iteration(&self) -> &NewIteration {
        self.new.iteration
    }

    fn first_fit(&self) -> FitPlace {
        FitPlace { job: self.new.iteration.job_id, number: i64::from(self.number), position: 1 }
    }
}

row! {
    /// A job with the last number given in it.
    struct JobRow {
        @purge: JobPurge,
        id: Uuid,
        tenant: String,
        gear: Option<String>,
        last_number: Integer<u32>,
    }
}

async fn last_numbers(db: &mut PgConnection, incoming: &[Incoming<'_>]) -> Outcome<HashMap<Uuid, JobRow>> {
    let mut ids: Vec<Uuid> = incoming.iter().map(|new| new.iteration.job_id).collect();
    ids.sort_unstable();
    ids.dedup();
    let jobs: Vec<JobRow> = sqlx::query_as(
        "SELECT j.id, j.tenant, j.gear, j.purged_at, (SELECT reason FROM purges WHERE job = j.id) AS purge_reason,
                coalesce((SELECT max(number) FROM iterations WHERE job = j.id), 0) AS last_number
         FROM jobs j WHERE j.id = ANY($1)",
    )
    .bind(ids)
    .fetch_all(db)
    .await?;
    Ok(jobs.into_iter().map(|job| (job.id, job)).collect())
}

/// Gives an iteration its number, or says why it is not stored.
fn number<'a>(
    last: &mut HashMap<Uuid, JobRow>,
    keys: &Keys,
    used: &mut HashSet<Key<'a>>,
    new: Incoming<'a>,
) -> Result<u32, RepositoryError> {
    let job = last.get_mut(&new.iteration.job_id).filter(|job| job.tenant == new.tenant().as_str());
    let job = job.ok_or(RepositoryError::NotFound(Resource::Job))?;
    keys.refuse_lost(new.lease())?;
    if new.key().is_some_and(|key| !keys.is_free(key) || used.contains(&key)) {
        return Err(RepositoryError::KeyTaken);
    }
    job.purge.refuse()?;
    new.iteration.check_gear(job.gear.as_deref())?;
    used.extend(new.key());
    job.last_number.0 += 1;
    Ok(job.last_number.0)
}

async fn change(session: &mut Session, accepted: &[Numbered<'_>]) -> Outcome<()> {
    let db = &mut session.db;
    note_in_jobs(db, accepted).await?;
    insert_rows(db, accepted).await?;
    insert_nodes(db, accepted).await?;
    let fits: Vec<Placed<'_>> =
        accepted.iter().map(|row| Placed { place: row.first_fit(), fit: &row.iteration().fit }).collect();
    fits::insert_rows(db, &fits).await?;
    choose_first_fits(db, accepted).await?;
    for row in accepted {
        let job = row.iteration().job_id;
        records::insert_rows(db, job, i64::from(row.number), 0, &row.iteration().records).await?;
    }
    for row in accepted {
        let Incoming { iteration, receipt, .. } = row.new;
        let stored = Stored { number: row.number, version: 1 };
        let fit = StoredFit { place: row.first_fit(), result: &iteration.fit.computed.result };
        session.keys.keep(row.new.tenant(), receipt, stored, iteration.created_at, Some(fit));
    }
    Ok(())
}

/// Notes in each job how many iterations it will have, and since when: else a trigger would do so
/// for each of them.
async fn note_in_jobs(db: &mut PgConnection, rows: &[Numbered<'_>]) -> Outcome<()> {
    let mut jobs: BTreeMap<Uuid, (u32, Timestamp)> = BTreeMap::new();
    for row in rows {
        let NewIteration { job_id, created_at, .. } = row.iteration();
        let (number, at) = jobs.entry(*job_id).or_insert((row.number, *created_at));
        (*number, *at) = (row.number.max(*number), (*at).max(*created_at));
    }
    sqlx::query(
        "UPDATE jobs j SET iteration_count = n.number, changed_at = greatest(j.changed_at, n.at)
         FROM unnest($1::uuid[], $2::bigint[], $3::timestamptz[]) AS n (job, number, at) WHERE j.id = n.job",
    )
    .bind(jobs.keys().copied().collect::<Vec<_>>())
    .bind(jobs.values().map(|(number, _)| i64::from(*number)).collect::<Vec<_>>())
    .bind(jobs.values().map(|(_, at)| stamp(*at)).collect::<Vec<_>>())
    .execute(db)
    .await?;
    Ok(())
}

/// Keys of the rows.
fn places(rows: &[Numbered<'_>]) -> (Vec<Uuid>, Vec<i64>) {
    rows.iter().map(|row| (row.new.iteration.job_id, i64::from(row.number))).unzip()
}

async fn insert_rows(db: &mut PgConnection, rows: &[Numbered<'_>]) -> Outcome<()> {
    let (jobs, numbers) = places(rows);
    let text = |of: fn(&NewIteration) -> Option<&str>| rows.iter().map(|row| of(row.new.iteration)).collect::<Vec<_>>();
    sqlx::query(
        "INSERT INTO iterations
             (job, number, id, measured_at, instrument, operator, note, flank, tooth, axes, created_at)
         SELECT * FROM unnest($1::uuid[], $2::bigint[], $3::uuid[], $4::timestamptz[], $5::text[], $6::text[],
                              $7::text[], $8::text[], $9::text[], $10::text[], $11::timestamptz[])",
    )
    .bind(jobs)
    .bind(numbers)
    .bind(rows.iter().map(|row| row.iteration().id).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| row.iteration().details.measured_at.map(stamp)).collect::<Vec<_>>())
    .bind(text(|new| new.details.instrument.as_deref()))
    .bind(text(|new| new.details.operator.as_deref()))
    .bind(text(|new| new.details.note.as_deref()))
    .bind(text(|new| new.measurand.flank_name()))
    .bind(text(|new| new.measurand.tooth.as_deref()))
    .bind(text(|new| new.measurand.axes.as_deref()))
    .bind(rows.iter().map(|row| stamp(row.iteration().created_at)).collect::<Vec<_>>())
    .execute(db)
    .await?;
    Ok(())
}

async fn insert_nodes(db: &mut PgConnection, rows: &[Numbered<'_>]) -> Outcome<()> {
    let (jobs, numbers) = places(rows);
    sqlx::query(
        "INSERT INTO nodes (job, number, count, data)
         SELECT * FROM unnest($1::uuid[], $2::bigint[], $3::bigint[], $4::bytea[])",
    )
    .bind(jobs)
    .bind(numbers)
    .bind(rows.iter().map(|row| signed(row.iteration().nodes.posted() as u64)).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| row.new.iteration.nodes.bytes()).collect::<Vec<_>>())
    .execute(db)
    .await?;
    Ok(())
}

async fn choose_first_fits(db: &mut PgConnection, rows: &[Numbered<'_>]) -> Outcome<()> {
    let (jobs, numbers) = places(rows);
    sqlx::query(
        "INSERT INTO fit_choices (job, number, position, fit, actor, created_at)
         SELECT job, number, 1, 1, actor, created_at
         FROM unnest($1::uuid[], $2::bigint[], $3::text[], $4::timestamptz[]) AS n (job, number, actor, created_at)",
    )
    .bind(jobs)
    .bind(numbers)
    .bind(rows.iter().map(|row| row.iteration().fit.event.by.as_deref()).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| stamp(row.iteration().fit.event.created_at)).collect::<Vec<_>>())
    .execute(db)
    .await?;
    Ok(())
}
