//! New iterations, many at once.
//!
//! This is the path that a measuring machine's every grid takes. The requests of a group are looked
//! up together, numbered in memory and inserted by one prepared statement for each table, so that
//! the way to the database and back is made a few times a group instead of a few times a request.
//! Nobody else writes meanwhile, so a number read is a number free.

use std::{
    collections::{HashMap, HashSet},
    fmt::Write as _,
    sync::Arc,
};

use sqlx::{AssertSqlSafe, Row, SqliteConnection};
use uuid::Uuid;

use super::{
    records, rows, time,
    write::{WriteError, keep_answer},
};
use crate::{
    api::gears::gear::stored_teeth,
    jobs::{GearSeen, NewIteration, Receipt, RepositoryError, Stored, What},
};

/// An iteration on its way in.
pub struct Incoming {
    pub iteration: Arc<NewIteration>,
    /// [`crate::api::nodes_codec::encode`] of its nodes.
    pub nodes: Vec<u8>,
    pub receipt: Option<Receipt>,
}

/// Rows of one statement: 35 variables each, far below SQLite's 32,766.
pub const MOST_ROWS: usize = 64;

/// Stores what can be stored and refuses the rest, in the order given.
pub async fn insert_iterations(
    db: &mut SqliteConnection,
    incoming: &[&Incoming],
) -> Result<Vec<Result<Stored, RepositoryError>>, WriteError> {
    let mut places = look_up(db, incoming).await?;
    let taken = taken_keys(db, incoming).await?;
    let mut answers = Vec::with_capacity(incoming.len());
    let mut accepted = Vec::with_capacity(incoming.len());
    for new in incoming.iter().copied() {
        let key = new.receipt.as_ref().map(|receipt| (receipt.key.as_str(), receipt.scope.as_str()));
        answers.push(match places.jobs.get_mut(&new.iteration.job_id) {
            None => Err(RepositoryError::NotFound(What::Job)),
            Some(_) if key.is_some_and(|(key, scope)| taken.contains(&(key.to_owned(), scope.to_owned()))) => {
                Err(RepositoryError::KeyTaken)
            }
            Some(job) => {
                if let Err(refused) = job.check(&new.iteration) {
                    answers.push(Err(refused));
                    continue;
                }
                job.last_number += 1;
                places.last_iteration += 1;
                places.last_fit += 1;
                accepted.push(Numbered {
                    new,
                    job: job.seq,
                    number: job.last_number,
                    seq: places.last_iteration,
                    fit: places.last_fit,
                });
                Ok(Stored { number: job.last_number, version: 1 })
            }
        });
    }
    for rows in accepted.chunks(MOST_ROWS) {
        insert(db, rows).await?;
    }
    for row in &accepted {
        for record in &row.new.iteration.records {
            records::insert_row(db, row.seq, record).await?;
        }
    }
    for row in accepted.iter().filter(|row| row.new.receipt.is_some()) {
        let stored = Stored { number: row.number, version: 1 };
        keep_answer(db, row.new.receipt.as_ref(), stored, row.new.iteration.created_at).await?;
    }
    Ok(answers)
}

/// An iteration with everything that the database must know of it.
struct Numbered<'a> {
    new: &'a Incoming,
    job: i64,
    number: u32,
    seq: i64,
    fit: i64,
}

struct Places {
    jobs: HashMap<Uuid, JobPlace>,
    last_iteration: i64,
    last_fit: i64,
}

struct JobPlace {
    seq: i64,
    last_number: u32,
    gear: Option<String>,
}

impl JobPlace {
    /// Refuses what the job's gear contradicts as it is now.
    fn check(&self, iteration: &NewIteration) -> Result<(), RepositoryError> {
        if iteration.made_by.as_ref().is_some_and(|GearSeen(gear)| *gear != self.gear) {
            return Err(RepositoryError::GearChanged);
        }
        if iteration.measurand.tooth.is_none() {
            return Ok(());
        }
        iteration.measurand.check_tooth(self.gear.as_deref().and_then(stored_teeth))
    }
}

/// The jobs named, their last numbers, and the last row of each table.
async fn look_up(db: &mut SqliteConnection, incoming: &[&Incoming]) -> Result<Places, WriteError> {
    let mut ids: Vec<Uuid> = incoming.iter().map(|new| new.iteration.job_id).collect();
    ids.sort_unstable();
    ids.dedup();
    let mut places = Places { jobs: HashMap::with_capacity(ids.len()), last_iteration: 0, last_fit: 0 };
    for ids in ids.chunks(MOST_ROWS) {
        let sql = format!(
            "SELECT j.id, j.seq, coalesce((SELECT max(number) FROM iterations WHERE job = j.seq), 0),
                    coalesce((SELECT max(seq) FROM iterations), 0), coalesce((SELECT max(seq) FROM fits), 0), j.gear
             FROM jobs j WHERE j.id IN ({})",
            marks(ids.len())
        );
        let mut query = sqlx::query(AssertSqlSafe(sql));
        for id in ids {
            query = query.bind(*id);
        }
        for row in query.fetch_all(&mut *db).await? {
            let place = JobPlace { seq: row.try_get(1)?, last_number: rows::unsigned(&row, 2)?, gear: row.try_get(5)? };
            places.jobs.insert(row.try_get(0)?, place);
            places.last_iteration = row.try_get(3)?;
            places.last_fit = row.try_get(4)?;
        }
    }
    Ok(places)
}

/// Which of the keys named have an answer already, or are named by an earlier request of the group.
async fn taken_keys(
    db: &mut SqliteConnection,
    incoming: &[&Incoming],
) -> Result<HashSet<(String, String)>, WriteError> {
    let mut taken = HashSet::new();
    for receipt in incoming.iter().filter_map(|new| new.receipt.as_ref()) {
        let row = sqlx::query("SELECT 1 FROM idempotency_keys WHERE key = ? AND scope = ?")
            .bind(receipt.key.as_str())
            .bind(receipt.scope.as_str())
            .fetch_optional(&mut *db)
            .await?;
        if row.is_some() {
            taken.insert((receipt.key.clone(), receipt.scope.clone()));
        }
    }
    Ok(taken)
}

/// One statement for each of the four tables, sent together.
async fn insert(db: &mut SqliteConnection, rows: &[Numbered<'_>]) -> Result<(), WriteError> {
    let mut query = sqlx::query(AssertSqlSafe(insert_sql(rows.len())));
    for row in rows {
        let iteration = &row.new.iteration;
        query = query
            .bind(row.seq)
            .bind(iteration.id)
            .bind(row.job)
            .bind(row.number)
            .bind(iteration.measured_at.map(time::to_text))
            .bind(iteration.instrument.as_deref())
            .bind(iteration.operator.as_deref())
            .bind(iteration.note.as_deref())
            .bind(time::to_text(iteration.created_at))
            .bind(iteration.measurand.flank_name())
            .bind(iteration.measurand.tooth.as_deref())
            .bind(iteration.measurand.axes.clone());
    }
    for row in rows {
        let count = i64::try_from(row.new.iteration.nodes.posted()).unwrap_or(i64::MAX);
        query = query.bind(row.seq).bind(count).bind(row.new.nodes.as_slice());
    }
    for row in rows {
        let fit = &row.new.iteration.fit;
        let figures = &fit.computed.figures;
        query = query
            .bind(row.fit)
            .bind(fit.id)
            .bind(row.seq)
            .bind(fit.reason.as_deref())
            .bind(time::to_text(fit.created_at))
            .bind(figures.lambda_star)
            .bind(figures.criterion)
            .bind(figures.scheme)
            .bind(figures.count)
            .bind(figures.condition)
            .bind(figures.regularized_condition)
            .bind(figures.bias_norm)
            .bind(figures.bias_sharp_bound)
            .bind(figures.rms)
            .bind(figures.max_abs)
            .bind(fit.computed.spec.clone())
            .bind(fit.computed.result.clone());
    }
    for row in rows {
        query = query.bind(row.seq).bind(row.fit).bind(time::to_text(row.new.iteration.fit.created_at));
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
        (
            concat!("fits (seq, id, iteration, reason, created_at, ", rows::figure_columns!(), ", spec, result)"),
            marks(17),
        ),
        ("fit_choices (iteration, position, fit, created_at)", "?, 1, ?, ?".to_owned()),
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
        assert_eq!(variables, MOST_ROWS * (12 + 3 + 17 + 3));
        assert!(variables <= 32_766);
    }
}
