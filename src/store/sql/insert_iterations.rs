//! New iterations, many at once.
//!
//! Each grid of a measuring machine takes this path. The jobs of a group are looked up together,
//! its iterations numbered in memory and inserted by one statement for each table, so that the
//! database is asked a few times a group instead of a few times a request. The jobs are locked, so
//! a number that was read stays free.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::{
    audit, fits,
    incoming::Incoming,
    jobs,
    keys::{FitPlace, Keys, OwnedKey, StoredFit},
    prelude::*,
    records,
    session::Session,
};

pub async fn insert_iteration(tx: &mut Tx<'_>, write: &InsertIteration) -> Outcome<Stored> {
    let Tx { session, request } = tx;
    one(session, Incoming::of(request, &write.iteration, write.receipt.as_ref())).await
}

pub async fn insert_runs(tx: &mut Tx<'_>, write: &InsertRuns) -> Outcome<Stored> {
    tx.refuse_taken()?;
    let request = tx.request;
    for NewRun { job, iterations } in &write.runs {
        jobs::create(tx, job).await.map_err(StoreError::too_late)?;
        let incoming: Vec<_> = iterations.iter().map(|iteration| Incoming::of(request, iteration, None)).collect();
        // none is refused of a job that is there and without a key; otherwise all would be
        // undone
        for stored in insert(&mut *tx.session, &incoming).await.map_err(StoreError::too_late)? {
            stored.map_err(|error| StoreError::from(error).too_late())?;
        }
    }
    Ok(tx.keep(&write.receipt, Stored { number: 0, version: 1 }, None, write.now))
}

/// An iteration with its number.
struct Numbered<'a> {
    new: Incoming<'a>,
    number: u32,
}

impl<'a> Numbered<'a> {
    fn iteration(&self) -> &'a NewIteration {
        self.new.iteration
    }

    fn draft(&self) -> Outcome<Draft> {
        let (action, subject) = self.new.deed(self.number);
        Draft::new(self.new.by, self.new.tenant(), Some(self.iteration().job_id), action, subject)
    }

    fn first_fit(&self) -> FitPlace {
        FitPlace { job: self.new.iteration.job_id, number: self.number, position: 1 }
    }

    /// A row of the iteration: job and number, then the rest.
    fn row(&self, rest: impl IntoIterator<Item = Value<'a>>) -> Vec<Value<'a>> {
        [self.new.iteration.job_id.into(), self.number.into()].into_iter().chain(rest).collect()
    }
}

row! {
    /// A job with the last number given in it.
    struct JobRow {
        @purge: JobPurge,
        id: Uuid,
        tenant: String,
        gear: Option<String>,
        last_number: u32,
    }
}

/// Inserts one iteration.
pub async fn one(session: &mut Session, incoming: Incoming<'_>) -> Outcome<Stored> {
    let stored = insert(session, &[incoming]).await?.pop();
    Ok(stored.unwrap_or(Err(RepositoryError::NotFound(Resource::Job)))?)
}

/// Stores the iterations that can be stored and refuses the others, in the order given. They are
/// refused as a whole only before anything was changed.
pub async fn insert(session: &mut Session, incoming: &[Incoming<'_>]) -> Outcome<Vec<Result<Stored, RepositoryError>>> {
    let sql =
        "SELECT j.id, j.tenant, j.gear, j.purged_at, (SELECT reason FROM purges WHERE job = j.id) AS purge_reason,
                      coalesce((SELECT max(number) FROM iterations WHERE job = j.id), 0) AS last_number
               FROM jobs j WHERE j.id IN ({ids})";
    let jobs: Vec<JobRow> = session.db.of_ids(sql, incoming.iter().map(|new| new.iteration.job_id)).await?;
    let mut jobs: HashMap<Uuid, JobRow> = jobs.into_iter().map(|job| (job.id, job)).collect();
    let (mut used, mut accepted) = (HashSet::new(), Vec::with_capacity(incoming.len()));
    let mut replies = Vec::with_capacity(incoming.len());
    for new in incoming.iter().copied() {
        replies.push(number(&mut jobs, &session.keys, &mut used, new).map(|number| {
            accepted.push(Numbered { new, number });
            Stored { number, version: 1 }
        }));
    }
    if !accepted.is_empty() {
        let mut entries = accepted.iter().map(Numbered::draft).collect::<Outcome<Vec<_>>>()?;
        change(session, &accepted, &mut entries).await.map_err(StoreError::too_late)?;
        session.entries.extend(entries);
    }
    Ok(replies)
}

/// Returns the number of an iteration, or why it is not stored.
fn number<'a>(
    jobs: &mut HashMap<Uuid, JobRow>,
    keys: &Keys,
    used: &mut HashSet<&'a OwnedKey>,
    new: Incoming<'a>,
) -> Result<u32, RepositoryError> {
    let job = jobs.get_mut(&new.iteration.job_id).filter(|job| job.tenant == new.tenant().as_str());
    let job = job.ok_or(RepositoryError::NotFound(Resource::Job))?;
    keys.refuse_taken(new.key)?;
    if new.key.is_some_and(|key| used.contains(key)) {
        return Err(RepositoryError::KeyTaken);
    }
    job.purge.refuse()?;
    new.iteration.check_gear(job.gear.as_deref())?;
    used.extend(new.key);
    job.last_number += 1;
    Ok(job.last_number)
}

async fn change(session: &mut Session, accepted: &[Numbered<'_>], entries: &mut [Draft]) -> Outcome<()> {
    let db = &mut session.db;
    // once for each job; otherwise a trigger would do so for each iteration
    let mut jobs: BTreeMap<Uuid, (u32, Timestamp)> = BTreeMap::new();
    for row in accepted {
        let NewIteration { job_id, created_at, .. } = row.iteration();
        let (number, at) = jobs.entry(*job_id).or_insert((row.number, *created_at));
        (*number, *at) = (row.number.max(*number), (*at).max(*created_at));
    }
    let noted: Vec<Vec<Value<'_>>> =
        jobs.into_iter().map(|(job, (number, at))| vec![job.into(), number.into(), at.into()]).collect();
    let mut all = db.of_rows(
        "UPDATE jobs SET iteration_count = column2,
                         changed_at = CASE WHEN changed_at < column3 THEN column3 ELSE changed_at END
         FROM",
        noted,
        "WHERE id = column1",
    );
    let columns = "job, number, id, measured_at, instrument, operator, note, flank, tooth, axes, created_at";
    let rows: Vec<_> = accepted.iter().map(iteration_row).collect();
    all.extend(audit::insertion(db, "iterations", columns, rows, entries));
    let nodes: Vec<_> = accepted
        .iter()
        .map(|row| row.row([row.iteration().nodes.posted().into(), row.iteration().nodes.bytes().into()]))
        .collect();
    all.extend(audit::insertion(db, "nodes", "job, number, count, data", nodes, entries));
    let first: Vec<(FitPlace, &NewFit)> = accepted.iter().map(|row| (row.first_fit(), &row.iteration().fit)).collect();
    all.extend(fits::insertion(db, &first, entries));
    let choices: Vec<_> = accepted
        .iter()
        .map(|row| {
            let event = &row.iteration().fit.event;
            row.row([1_i64.into(), 1_i64.into(), event.by.as_deref().into(), event.created_at.into()])
        })
        .collect();
    all.extend(audit::insertion(db, "fit_choices", "job, number, position, fit, actor, created_at", choices, entries));
    db.run_together(all).await?;
    for (row, entry) in accepted.iter().zip(&mut *entries) {
        records::insert(db, row.iteration().job_id, row.number, 0, &row.iteration().records, entry).await?;
    }
    for row in accepted {
        let Incoming { iteration, receipt, .. } = row.new;
        let stored = Stored { number: row.number, version: 1 };
        let fit = StoredFit { place: row.first_fit(), result: &iteration.fit.computed.result };
        session.keys.keep(row.new.tenant(), receipt, Some(iteration.job_id), stored, Some(fit), iteration.created_at);
    }
    Ok(())
}

fn iteration_row<'a>(row: &Numbered<'a>) -> Vec<Value<'a>> {
    let NewIteration { id, measurand, details, created_at, .. } = row.iteration();
    row.row([
        id.into(),
        details.measured_at.into(),
        details.instrument.as_deref().into(),
        details.operator.as_deref().into(),
        details.note.as_deref().into(),
        measurand.flank_name().into(),
        measurand.tooth.as_deref().into(),
        measurand.axes.as_deref().into(),
        (*created_at).into(),
    ])
}
