//! Rows into domain values. A row that does not read is a damaged or foreign database: an error,
//! never a guess.

use std::{collections::BTreeMap, sync::Arc};

use jiff::Timestamp;
use sqlx::{Row, sqlite::SqliteRow};

use super::{error::failure, time};
use crate::jobs::{Decision, Event, Figures, FitRecord, FitSummary, Job, Measurand, RepositoryError};

/// The columns that [`job`] reads.
macro_rules! job_columns {
    () => {
        "id, name, part_number, serial_number, machine, gear, tags, version, created_at, updated_at"
    };
}
pub(super) use job_columns;

pub fn job(row: &SqliteRow) -> Result<Job, RepositoryError> {
    Ok(Job {
        id: get(row, 0)?,
        name: get(row, 1)?,
        part_number: get(row, 2)?,
        serial_number: get(row, 3)?,
        machine: get(row, 4)?,
        gear: get(row, 5)?,
        tags: read_tags(&get::<String>(row, 6)?)?,
        version: unsigned(row, 7)?,
        created_at: moment(row, 8)?,
        updated_at: moment(row, 9)?,
    })
}

/// The columns that [`figures`] reads, from `lambda_star` on.
macro_rules! figure_columns {
    () => {
        "lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms, \
         max_abs"
    };
}
pub(super) use figure_columns;

/// Figures whose first column is `at`.
pub fn figures(row: &SqliteRow, at: usize) -> Result<Figures, RepositoryError> {
    let name = |index: usize, known: fn(&str) -> Option<&'static str>| match get::<Option<String>>(row, index)? {
        None => Ok(None),
        Some(name) => known(&name).map(Some).ok_or_else(|| damaged("a figure's name", &name)),
    };
    Ok(Figures {
        lambda_star: get(row, at)?,
        criterion: name(at + 1, Figures::criterion_named)?,
        scheme: name(at + 2, Figures::scheme_named)?,
        count: get(row, at + 3)?,
        condition: get(row, at + 4)?,
        regularized_condition: get(row, at + 5)?,
        bias_norm: get(row, at + 6)?,
        bias_sharp_bound: get(row, at + 7)?,
        rms: get(row, at + 8)?,
        max_abs: get(row, at + 9)?,
    })
}

/// The row of the fit that stands, of the iteration that is the statement's first variable.
macro_rules! chosen_fit {
    () => {
        "(SELECT fit FROM fit_choices WHERE iteration = ?1 ORDER BY position DESC LIMIT 1)"
    };
}
pub(super) use chosen_fit;

/// `id, reason, created_at`, whether it stands, `spec, result`.
pub fn fit(row: &SqliteRow) -> Result<FitRecord, RepositoryError> {
    Ok(FitRecord {
        id: get(row, 0)?,
        reason: get(row, 1)?,
        created_at: moment(row, 2)?,
        chosen: get(row, 3)?,
        spec: Arc::from(get::<String>(row, 4)?),
        result: Arc::from(get::<String>(row, 5)?),
    })
}

/// `id, reason, created_at`, whether it stands, and the figures from column `figures_at` on.
pub fn fit_summary(row: &SqliteRow, figures_at: usize) -> Result<FitSummary, RepositoryError> {
    Ok(FitSummary { id: get(row, 0)?, event: event(row, 1)?, chosen: get(row, 3)?, figures: figures(row, figures_at)? })
}

/// `flank, tooth, axes` from column `at` on.
pub fn measurand(row: &SqliteRow, at: usize) -> Result<Measurand, RepositoryError> {
    let flank: Option<&str> = get(row, at)?;
    let axes = get::<Option<String>>(row, at + 2)?.map(Arc::from);
    Measurand::named(flank, get(row, at + 1)?, axes).ok_or_else(|| damaged("a flank", flank.unwrap_or_default()))
}

/// `reason, created_at` from column `at` on.
pub fn event(row: &SqliteRow, at: usize) -> Result<Event, RepositoryError> {
    Ok(Event { reason: get(row, at)?, created_at: moment(row, at + 1)? })
}

pub fn decision(row: &SqliteRow, at: usize) -> Result<Decision, RepositoryError> {
    let name: String = get(row, at)?;
    Decision::named(&name).ok_or_else(|| damaged("a decision", &name))
}

pub fn moment(row: &SqliteRow, at: usize) -> Result<Timestamp, RepositoryError> {
    read_time(&get::<String>(row, at)?)
}

pub fn optional_moment(row: &SqliteRow, at: usize) -> Result<Option<Timestamp>, RepositoryError> {
    get::<Option<String>>(row, at)?.map(|text| read_time(&text)).transpose()
}

/// A count, number or version.
pub fn unsigned<T: TryFrom<i64>>(row: &SqliteRow, at: usize) -> Result<T, RepositoryError> {
    let value: i64 = get(row, at)?;
    T::try_from(value).map_err(|_| damaged("a count", &value.to_string()))
}

pub fn get<'r, T>(row: &'r SqliteRow, at: usize) -> Result<T, RepositoryError>
where
    T: sqlx::Decode<'r, sqlx::Sqlite> + sqlx::Type<sqlx::Sqlite>,
{
    row.try_get(at).map_err(|error| failure(&error))
}

pub fn write_tags(tags: &BTreeMap<String, String>) -> String {
    if tags.is_empty() { "{}".to_owned() } else { serde_json::json!(tags).to_string() }
}

fn read_tags(text: &str) -> Result<BTreeMap<String, String>, RepositoryError> {
    serde_json::from_str(text).map_err(|_| damaged("a job's tags", text))
}

fn read_time(text: &str) -> Result<Timestamp, RepositoryError> {
    time::from_text(text).map_err(|_| damaged("a time", text))
}

pub fn damaged(what: &str, value: &str) -> RepositoryError {
    let value: String = value.chars().take(80).collect();
    RepositoryError::Failed(format!("the database holds {what} that cannot be read: {value}"))
}
