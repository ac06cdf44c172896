//! Lists of which the last entries are read.

use sqlx::FromRow;

use crate::store::shared::Integer;

/// An entry of a list of which the last are read, with the length of the whole list.
#[derive(FromRow)]
pub struct Counted<T> {
    pub total: Integer<u64>,
    #[sqlx(flatten)]
    pub row: T,
}

/// Entries that were read newest first, in their order, and how many stand before them.
pub fn in_order<T, U: From<T>>(rows: Vec<Counted<T>>) -> (Vec<U>, u64) {
    let total = rows.first().map_or(0, |row| row.total.0);
    let earlier = total.saturating_sub(rows.len() as u64);
    (rows.into_iter().rev().map(|row| row.row.into()).collect(), earlier)
}
