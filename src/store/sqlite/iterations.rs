//! Iterations and their nodes, read.

use futures_util::TryStreamExt as _;
use sqlx::{FromRow, SqlitePool};
use uuid::Uuid;

use super::{
    decisions, fits,
    locate::{WithSeq, which_is_missing},
};
use crate::{
    jobs::{Iteration, Measurand, Predecessor, Predecessors, RepositoryError, Successors},
    store::shared::{Integer, IterationRow, MeasurandRow, NodesColumn, Outcome, damaged},
};
use flankfit_engine::estimation::Nodes;

pub async fn iteration(db: &SqlitePool, job: Uuid, number: u32) -> Outcome<Iteration> {
    let mut db = db.begin().await?;
    let row: Option<WithSeq<IterationRow>> = sqlx::query_as(
        "SELECT i.seq AS seq, i.id AS id, i.flank AS flank, i.tooth AS tooth, i.axes AS axes,
                i.measured_at AS measured_at, i.instrument AS instrument, i.operator AS operator, i.note AS note,
                i.created_at AS created_at,
                (SELECT count FROM nodes WHERE iteration = i.seq) AS node_count,
                (SELECT count(*) FROM fits WHERE iteration = i.seq)
                + (SELECT count(*) FROM fit_choices WHERE iteration = i.seq)
                + (SELECT count(*) FROM decisions WHERE iteration = i.seq) - 1 AS version
         FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number = ?",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(&mut *db)
    .await?;
    let Some(WithSeq { seq, row }) = row else { return Err(which_is_missing(&mut db, job).await) };
    let fits = fits::last(&mut db, seq).await?;
    let decision = decisions::latest(&mut db, seq).await?;
    Ok(row.with((job, number), fits, decision))
}

pub async fn nodes(db: &SqlitePool, job: Uuid, number: u32) -> Outcome<Nodes> {
    let all = nodes_up_to(db, job, number, usize::MAX).await?;
    all.map_err(|length| RepositoryError::Failed(damaged("nodes", &format!("{length} bytes are not read"))).into())
}

#[derive(FromRow)]
struct NodesRow {
    length: Integer<usize>,
    data: Option<NodesColumn>,
}

/// Longer ones are not read: SQLite knows their length without.
pub async fn nodes_up_to(db: &SqlitePool, job: Uuid, number: u32, most: usize) -> Outcome<Result<Nodes, usize>> {
    let mut db = db.acquire().await?;
    let row: Option<NodesRow> = sqlx::query_as(
        "SELECT length(n.data) AS length, CASE WHEN length(n.data) <= ?3 THEN n.data END AS data
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN nodes n ON n.iteration = i.seq
         WHERE j.id = ?1 AND i.number = ?2",
    )
    .bind(job)
    .bind(number)
    .bind(i64::try_from(most).unwrap_or(i64::MAX))
    .fetch_optional(&mut *db)
    .await?;
    match row {
        Some(NodesRow { data: Some(NodesColumn(nodes)), .. }) => Ok(Ok(nodes)),
        Some(NodesRow { length, data: None }) => Ok(Err(length.0)),
        None => Err(which_is_missing(&mut db, job).await),
    }
}

pub async fn measurand(db: &SqlitePool, job: Uuid, number: u32) -> Outcome<Measurand> {
    let mut db = db.acquire().await?;
    let row: Option<MeasurandRow> = sqlx::query_as(
        "SELECT i.flank AS flank, i.tooth AS tooth, i.axes AS axes
         FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number = ?",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(&mut *db)
    .await?;
    match row {
        Some(row) => Ok(row.into()),
        None => Err(which_is_missing(&mut db, job).await),
    }
}

#[derive(FromRow)]
struct SuccessorRow {
    number: Integer<u32>,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
}

/// The first iteration after one, and the first that is of the same flank and tooth.
pub async fn successors(db: &SqlitePool, job: Uuid, number: u32) -> Outcome<Successors> {
    let mut db = db.acquire().await?;
    let mut rows = sqlx::query_as::<_, SuccessorRow>(
        "SELECT i.number AS number, i.flank AS flank, i.tooth AS tooth, NULL AS axes
         FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number >= ? ORDER BY i.number",
    )
    .bind(job)
    .bind(number)
    .fetch(&mut *db);
    // names of teeth may be older than the rule how they are written, so they are compared here;
    // the rows are short
    let mut found = Successors::default();
    let mut own: Option<Measurand> = None;
    while let Some(SuccessorRow { number: Integer(at), measurand }) = rows.try_next().await? {
        let measurand = Measurand::from(measurand);
        match &own {
            None if at == number => own = Some(measurand),
            None => break,
            Some(own) => {
                found.any = found.any.or(Some(at));
                if measurand.is_alike(own) {
                    found.alike = Some(at);
                    break;
                }
            }
        }
    }
    Ok(found)
}

#[derive(FromRow)]
struct PredecessorRow {
    number: Integer<u32>,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
    fit_id: Uuid,
}

/// Earlier iterations of the same flank and tooth, oldest first.
pub async fn predecessors(db: &SqlitePool, job: Uuid, wanted: Predecessors) -> Outcome<Vec<Predecessor>> {
    let mut db = db.acquire().await?;
    let mut rows = sqlx::query_as::<_, PredecessorRow>(
        "SELECT i.number AS number, i.flank AS flank, i.tooth AS tooth, i.axes AS axes,
                (SELECT f.id FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = i.seq
                 ORDER BY c.position DESC LIMIT 1) AS fit_id
         FROM jobs j JOIN iterations i ON i.job = j.seq
         WHERE j.id = ? AND i.number >= ? AND i.number < ? ORDER BY i.number DESC",
    )
    .bind(job)
    .bind(wanted.from)
    .bind(wanted.before.map_or(i64::MAX, i64::from))
    .fetch(&mut *db);
    let mut found = Vec::new();
    while let Some(PredecessorRow { number: Integer(number), measurand, fit_id }) = rows.try_next().await? {
        let measurand = Measurand::from(measurand);
        if measurand.is_alike(&wanted.of) {
            found.push(Predecessor { number, measurand, fit_id });
            if found.len() == wanted.most {
                break;
            }
        }
    }
    found.reverse();
    Ok(found)
}
