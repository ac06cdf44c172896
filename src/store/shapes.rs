//! Curves and surfaces of an iteration.

use sqlx::{SqliteConnection, SqlitePool, sqlite::SqliteRow};
use uuid::Uuid;

use super::{
    read::{self, sql},
    rows::{self, damaged, get},
    time,
    write::{Written, iteration, keep_answer, refuse_taken_key},
};
use crate::jobs::{
    Cursor, Page, PageRequest, Receipt, RepositoryError, Shape, ShapeDraft, ShapeKind, ShapeSummary, Stored, What,
};

pub async fn insert(
    db: &mut SqliteConnection,
    job: Uuid,
    number: u32,
    shape: &Shape,
    receipt: Option<&Receipt>,
) -> Written<Stored> {
    let place = iteration(db, job, number).await?;
    refuse_taken_key(db, receipt).await?;
    let ShapeDraft { kind, method, request, result } = &shape.draft;
    sqlx::query(
        "INSERT INTO shapes (id, iteration, kind, method, created_at, request, result) VALUES (?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(shape.id)
    .bind(place.seq)
    .bind(kind.name())
    .bind(method.as_str())
    .bind(time::to_text(shape.created_at))
    .bind(request.clone())
    .bind(result.clone())
    .execute(&mut *db)
    .await?;
    // Shapes are beside the iteration: its version stays.
    let stored = Stored { number, version: place.version };
    keep_answer(db, receipt, stored, shape.created_at).await?;
    Ok(stored)
}

pub async fn shape(db: &SqlitePool, job: Uuid, number: u32, id: Uuid) -> Result<Shape, RepositoryError> {
    let mut db = db.begin().await.map_err(sql)?;
    let iteration = read::iteration_seq(&mut db, job, number).await?;
    let row =
        sqlx::query("SELECT id, kind, method, created_at, request, result FROM shapes WHERE iteration = ? AND id = ?")
            .bind(iteration)
            .bind(id)
            .fetch_optional(&mut *db)
            .await
            .map_err(sql)?
            .ok_or(RepositoryError::NotFound(What::Shape))?;
    let ShapeSummary { id, kind, method, created_at } = summary(&row)?;
    let text = |at| get::<&str>(&row, at).map(Into::into);
    Ok(Shape { id, created_at, draft: ShapeDraft { kind, method, request: text(4)?, result: text(5)? } })
}

/// Oldest first; one row more than asked for tells whether there is a next page.
pub async fn list(
    db: &SqlitePool,
    job: Uuid,
    number: u32,
    page: PageRequest,
) -> Result<Page<ShapeSummary>, RepositoryError> {
    let mut db = db.begin().await.map_err(sql)?;
    let iteration = read::iteration_seq(&mut db, job, number).await?;
    let after = page.after.map_or([0; 16].to_vec(), |Cursor(id)| id.as_bytes().to_vec());
    let rows = sqlx::query(
        "SELECT id, kind, method, created_at FROM shapes WHERE iteration = ? AND id > ? ORDER BY id LIMIT ?",
    )
    .bind(iteration)
    .bind(after)
    .bind(i64::from(page.limit) + 1)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    Ok(Page::of(rows.iter().map(summary).collect::<Result<Vec<_>, _>>()?, page.limit, |shape| shape.id))
}

fn summary(row: &SqliteRow) -> Result<ShapeSummary, RepositoryError> {
    let kind: &str = get(row, 1)?;
    Ok(ShapeSummary {
        id: get(row, 0)?,
        kind: ShapeKind::named(kind).ok_or_else(|| damaged("a kind of shape", kind))?,
        method: get(row, 2)?,
        created_at: rows::moment(row, 3)?,
    })
}
