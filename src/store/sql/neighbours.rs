//! Iterations measured before and after another. Names of teeth are compared here and not by the
//! database; the rows are short.

use futures_util::{TryStream, TryStreamExt as _};

use super::row::SuccessorRow;
use crate::jobs::{Measurand, Predecessor, Predecessors, Successors};

/// Returns, from an iteration and those after it in order, the first after it and the first of the
/// same flank and tooth.
pub async fn successors(
    mut rows: impl TryStream<Ok = SuccessorRow, Error = sqlx::Error> + Unpin,
    number: u32,
) -> Result<Successors, sqlx::Error> {
    let mut found = Successors::default();
    let mut own: Option<Measurand> = None;
    while let Some(SuccessorRow { number: at, measurand }) = rows.try_next().await? {
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

/// Returns, from iterations with the greatest number first, those of the flank and tooth wanted, in
/// the order of their numbers.
pub async fn predecessors(
    mut rows: impl TryStream<Ok = Predecessor, Error = sqlx::Error> + Unpin,
    wanted: &Predecessors,
) -> Result<Vec<Predecessor>, sqlx::Error> {
    let mut found = Vec::new();
    while let Some(predecessor) = rows.try_next().await? {
        if predecessor.measurand.is_alike(&wanted.of) {
            found.push(predecessor);
            if found.len() == wanted.most {
                break;
            }
        }
    }
    found.reverse();
    Ok(found)
}
