//! New iterations, many at once.
//!
//! This is the path that a measuring machine's every grid takes. The requests of a group are looked
//! up together, numbered in memory and inserted by one prepared statement for each table, so that
//! the way to the database and back is made a few times a group instead of a few times a request.
//! Nobody else writes meanwhile, so a number read is a number free.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    fmt::Write as _,
};

use jiff::Timestamp;
use sqlx::{AssertSqlSafe, SqliteConnection};
use uuid::Uuid;

use super::{
    answers::{self, StoredFit},
    audit, fits,
    locate::signed,
    records, tasks, time,
};
use crate::{
    jobs::{
        Lease, RepositoryError, Resource, Stored,
        audit::{Chain, Head},
    },
    store::shared::{
        Asked, Digest, Growing, Incoming, InsertIteration, InsertTogether, Integer, JobPurge, Key, NewEntry, Outcome,
        Pending, Queued, StoreError, Write, figure_columns,
    },
};

/// Rows of one statement: 52 variables each, far below SQLite's 32,766.
const MOST_ROWS: usize = 64;

impl Write<SqliteConnection> for InsertIteration {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let stored = insert(db, &[Incoming::of(asked)]).await?.pop();
        Ok(stored.unwrap_or(Err(RepositoryError::NotFound(Resource::Job)))?)
    }

    fn queued(pending: Pending<Asked<Self>>) -> Queued<SqliteConnection> {
        Queued::Iteration(Box::new(pending))
    }
}

impl InsertTogether for SqliteConnection {
    async fn insert(&mut self, incoming: &[Incoming<'_>]) -> Outcome<Vec<Result<Stored, RepositoryError>>> {
        insert(self, incoming).await
    }
}

/// See [`InsertTogether::insert`].
pub async fn insert(
    db: &mut SqliteConnection,
    incoming: &[Incoming<'_>],
) -> Outcome<Vec<Result<Stored, RepositoryError>>> {
    let mut last = last_numbers(db, incoming).await?;
    let refused = refused_keys(db, incoming).await?;
    last.begin_chains(db, incoming).await?;
    let mut replies = Vec::with_capacity(incoming.len());
    let mut accepted = Vec::with_capacity(incoming.len());
    for new in incoming.iter().copied() {
        replies.push(last.number(new, &refused).map(|numbered| {
            let stored = Stored { number: numbered.number, version: 1 };
            accepted.push(numbered);
            stored
        }));
    }
    let begun = last.begun(&accepted);
    change(db, &accepted, begun).await.map_err(StoreError::too_late)?;
    Ok(replies)
}

async fn change(db: &mut SqliteConnection, accepted: &[Numbered<'_>], begun: Vec<Growing>) -> Outcome<()> {
    for chain in begun {
        audit::store(db, chain).await?;
    }
    note_in_jobs(db, accepted).await?;
    for rows in accepted.chunks(MOST_ROWS) {
        insert_rows(db, rows).await?;
    }
    for row in accepted {
        for record in &row.new.iteration.records {
            records::insert_row(db, row.seq, record).await?;
        }
    }
    for row in accepted {
        let Incoming { iteration, receipt, .. } = row.new;
        let stored = Stored { number: row.number, version: 1 };
        let fit = StoredFit { seq: row.fit, result: &iteration.fit.computed.result };
        answers::keep(db, row.new.tenant(), receipt, stored, iteration.created_at, Some(fit)).await?;
    }
    Ok(())
}

/// An iteration with everything that the database must know of it.
struct Numbered<'a> {
    new: Incoming<'a>,
    job: i64,
    number: u32,
    seq: i64,
    fit: i64,
    entry: NewEntry,
}

/// The last numbers given, of each job and of each table.
struct LastNumbers {
    jobs: HashMap<Uuid, JobCounters>,
    /// Chains of the jobs.
    chains: HashMap<Uuid, Growing>,
    iteration: i64,
    fit: i64,
}

row! {
    struct JobCounters {
        @purge: JobPurge,
        tenant: String,
        seq: i64,
        last_number: Integer<u32>,
        gear: Option<String>,
        head_number: Option<Integer<u64>>,
        head_sha256: Option<Digest>,
    }
}

impl JobCounters {
    /// The last entry of the job's chain, unless it is older than the entries.
    fn head(&self) -> Option<Head> {
        let (number, sha256) = self.head_number.zip(self.head_sha256)?;
        Some(Head { number: number.0, sha256: sha256.0 })
    }
}

row! {
    struct CountersRow {
        @job: JobCounters,
        id: Uuid,
        last_iteration: i64,
        last_fit: i64,
    }
}

impl LastNumbers {
    /// Reads or begins the chains of the jobs named.
    async fn begin_chains(&mut self, db: &mut SqliteConnection, incoming: &[Incoming<'_>]) -> Outcome<()> {
        for new in incoming {
            let id = new.iteration.job_id;
            let job = self.jobs.get(&id).filter(|job| job.tenant == new.tenant().as_str());
            let Some(job) = job.filter(|_| !self.chains.contains_key(&id)) else { continue };
            let chain = match job.head() {
                Some(head) => Growing::from(new.tenant(), Chain::Job(id), Some(head)),
                None => Growing::begin(new.by, id, &audit::found(db, new.tenant(), id).await?),
            };
            self.chains.insert(id, chain);
        }
        Ok(())
    }

    /// Chains that begin with what is accepted.
    fn begun(self, accepted: &[Numbered<'_>]) -> Vec<Growing> {
        let changed: HashSet<Uuid> = accepted.iter().map(|row| row.new.iteration.job_id).collect();
        self.chains
            .into_iter()
            .filter(|(job, chain)| changed.contains(job) && !chain.new.is_empty())
            .map(|(_, chain)| chain)
            .collect()
    }

    /// Gives an iteration its numbers, or says why it is not stored.
    fn number<'a>(&mut self, new: Incoming<'a>, refused: &RefusedKeys<'_>) -> Result<Numbered<'a>, RepositoryError> {
        let job = self.jobs.get_mut(&new.iteration.job_id).filter(|job| job.tenant == new.tenant().as_str());
        let (job, chain) =
            job.zip(self.chains.get_mut(&new.iteration.job_id)).ok_or(RepositoryError::NotFound(Resource::Job))?;
        if new.lease().is_some_and(|lease| refused.lost.contains(&lease)) {
            return Err(RepositoryError::LeaseLost);
        }
        if new.key().is_some_and(|key| refused.taken.contains(&key)) {
            return Err(RepositoryError::KeyTaken);
        }
        job.purge.refuse()?;
        new.iteration.check_gear(job.gear.as_deref())?;
        job.last_number.0 += 1;
        self.iteration += 1;
        self.fit += 1;
        let (action, target) = new.deed(job.last_number.0);
        let entry = chain.enter(new.by, new.prepared.clone(), action, target);
        Ok(Numbered { new, job: job.seq, number: job.last_number.0, seq: self.iteration, fit: self.fit, entry })
    }
}

/// The jobs named, their last numbers, and the last row of each table.
async fn last_numbers(db: &mut SqliteConnection, incoming: &[Incoming<'_>]) -> Outcome<LastNumbers> {
    let mut ids: Vec<Uuid> = incoming.iter().map(|new| new.iteration.job_id).collect();
    ids.sort_unstable();
    ids.dedup();
    let mut last =
        LastNumbers { jobs: HashMap::with_capacity(ids.len()), chains: HashMap::new(), iteration: 0, fit: 0 };
    for ids in ids.chunks(MOST_ROWS) {
        let sql = format!(
            "SELECT j.id AS id, j.tenant AS tenant, j.seq AS seq, j.gear AS gear,
                    j.purged_at AS purged_at, (SELECT reason FROM purges WHERE job = j.seq) AS purge_reason,
                    coalesce((SELECT max(number) FROM iterations WHERE job = j.seq), 0) AS last_number,
                    coalesce((SELECT max(seq) FROM iterations), 0) AS last_iteration,
                    coalesce((SELECT max(seq) FROM fits), 0) AS last_fit,
                    a.number AS head_number, a.sha256 AS head_sha256
             FROM jobs j LEFT JOIN audit a
                  ON a.chain = j.id AND a.number = (SELECT max(number) FROM audit WHERE chain = j.id)
             WHERE j.id IN ({})",
            marks(ids.len())
        );
        let mut query = sqlx::query_as::<_, CountersRow>(AssertSqlSafe(sql));
        for id in ids {
            query = query.bind(*id);
        }
        for CountersRow { id, job, last_iteration, last_fit } in query.fetch_all(&mut *db).await? {
            last.jobs.insert(id, job);
            (last.iteration, last.fit) = (last_iteration, last_fit);
        }
    }
    Ok(last)
}

/// What is not stored for.
#[derive(Default)]
struct RefusedKeys<'a> {
    taken: HashSet<Key<'a>>,
    lost: HashSet<Lease>,
}

/// Which of the keys named have an answer already, and which tasks others do by now. (Two requests
/// of a group with one key break the index of keys; each is then tried alone.)
async fn refused_keys<'a>(db: &mut SqliteConnection, incoming: &[Incoming<'a>]) -> Outcome<RefusedKeys<'a>> {
    let mut refused = RefusedKeys::default();
    for new in incoming {
        let Some(receipt) = new.receipt else { continue };
        if !tasks::holds(db, receipt).await? {
            refused.lost.extend(new.lease());
        }
        if answers::is_taken(db, new.tenant(), receipt).await? {
            refused.taken.extend(new.key());
        }
    }
    Ok(refused)
}

/// Notes in each job how many iterations it will have, and since when: else a trigger would do so
/// for each of them.
async fn note_in_jobs(db: &mut SqliteConnection, rows: &[Numbered<'_>]) -> Outcome<()> {
    let mut jobs: BTreeMap<i64, (u32, Timestamp)> = BTreeMap::new();
    for row in rows {
        let created_at = row.new.iteration.created_at;
        let (number, at) = jobs.entry(row.job).or_insert((row.number, created_at));
        (*number, *at) = (row.number.max(*number), created_at.max(*at));
    }
    let jobs: Vec<_> = jobs.into_iter().collect();
    for jobs in jobs.chunks(MOST_ROWS) {
        let sql = format!(
            "UPDATE jobs SET iteration_count = n.column2, changed_at = max(changed_at, n.column3)
             FROM (VALUES (?, ?, ?){}) AS n WHERE seq = n.column1",
            ", (?, ?, ?)".repeat(jobs.len() - 1)
        );
        let mut query = sqlx::query(AssertSqlSafe(sql));
        for (job, (number, at)) in jobs {
            query = query.bind(job).bind(number).bind(time::to_text(*at));
        }
        query.execute(&mut *db).await?;
    }
    Ok(())
}

/// One statement for each of the five tables, sent together.
async fn insert_rows(db: &mut SqliteConnection, rows: &[Numbered<'_>]) -> Outcome<()> {
    let mut query = sqlx::query(AssertSqlSafe(insert_sql(rows.len())));
    for row in rows {
        let iteration = &row.new.iteration;
        query = query
            .bind(row.seq)
            .bind(iteration.id)
            .bind(row.job)
            .bind(row.number)
            .bind(iteration.details.measured_at.map(time::to_text))
            .bind(iteration.details.instrument.as_deref())
            .bind(iteration.details.operator.as_deref())
            .bind(iteration.details.note.as_deref())
            .bind(time::to_text(iteration.created_at))
            .bind(iteration.measurand.flank_name())
            .bind(iteration.measurand.tooth.as_deref())
            .bind(iteration.measurand.axes.clone());
    }
    for row in rows {
        let count = signed(row.new.iteration.nodes.posted() as u64);
        query = query.bind(row.seq).bind(count).bind(row.new.iteration.nodes.bytes());
    }
    for row in rows {
        query = fits::bind(query.bind(row.fit), row.seq, &row.new.iteration.fit);
    }
    for row in rows {
        let event = &row.new.iteration.fit.event;
        query = query.bind(row.seq).bind(row.fit).bind(event.by.as_deref()).bind(time::to_text(event.created_at));
    }
    for row in rows {
        query = audit::bind(query, &row.entry);
    }
    query.execute(&mut *db).await?;
    Ok(())
}

fn insert_sql(rows: usize) -> String {
    let mut sql = String::with_capacity(512 + rows * 150);
    let tables = [
        (
            "iterations (seq, id, job, number, measured_at, instrument, operator, note, created_at, flank, tooth, \
             axes)",
            marks(12),
        ),
        ("nodes (iteration, count, data)", marks(3)),
        (concat!("fits (seq, ", fits::fit_columns!(), ")"), marks(22)),
        ("fit_choices (iteration, position, fit, actor, created_at)", "?, 1, ?, ?, ?".to_owned()),
        (concat!("audit (", audit::columns!(), ")"), marks(14)),
    ];
    for (table, row) in tables {
        // Writing to a string cannot fail.
        let _ = write!(sql, "INSERT INTO {table} VALUES ({row})");
        for _ in 1..rows {
            let _ = write!(sql, ", ({row})");
        }
        sql.push_str("; ");
    }
    sql
}

/// `?, ?, ?`.
fn marks(count: usize) -> String {
    let mut marks = "?, ".repeat(count);
    marks.truncate(marks.len().saturating_sub(2));
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_statement_stays_within_the_limits() {
        let variables = insert_sql(MOST_ROWS).matches('?').count();
        assert_eq!(variables, MOST_ROWS * (12 + 3 + 22 + 4 + 14));
        assert!(variables <= 32_766);
    }
}
