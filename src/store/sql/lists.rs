//! Lists of which the last entries are read, or a page.

use std::collections::VecDeque;

use futures_util::{TryStream, TryStreamExt as _};

use super::row::TracedFitRow;
use crate::jobs::{Cursor, Page, TracedFit};

row! {
    /// An entry of a list that is read page by page, with its place in it.
    pub struct Listed<T> {
        @row: T,
        place: u64,
    }
}

/// Returns a page of so many entries. One row more than that shows that there is a next page.
pub fn page<T>(rows: Vec<Listed<T>>, limit: u32) -> Page<T> {
    Page::of(rows, limit, |row| Cursor::after_number(row.place)).map(|row| row.row)
}

row! {
    /// An entry of a list of which the last are read, with the length of the whole list.
    pub struct Counted<T> {
        @pub row: T,
        pub total: u64,
    }
}

/// Returns entries that were read newest first, in their order, and how many come before them.
pub fn in_order<T>(rows: Vec<Counted<T>>) -> (Vec<T>, u64) {
    let total = rows.first().map_or(0, |row| row.total);
    let earlier = total.saturating_sub(rows.len() as u64);
    (rows.into_iter().rev().map(|row| row.row).collect(), earlier)
}

/// Returns, from the fits of an iteration, newest first, as many as `text` holds the coefficients
/// of and at least one, in their order, and how many come before them.
pub async fn within(
    mut rows: impl TryStream<Ok = Counted<TracedFitRow>, Error = sqlx::Error> + Unpin,
    text: usize,
) -> Result<(Vec<TracedFit>, u64), sqlx::Error> {
    let (mut fits, mut length, mut total) = (VecDeque::<TracedFit>::new(), 0, 0);
    while let Some(row) = rows.try_next().await? {
        let fit = TracedFit::from(row.row);
        length += fit.coefficients.len();
        if length > text && !fits.is_empty() {
            break;
        }
        total = row.total;
        fits.push_front(fit);
    }
    let earlier = total.saturating_sub(fits.len() as u64);
    Ok((fits.into(), earlier))
}
