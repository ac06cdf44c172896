//! What was measured before and after an iteration. Names of teeth may be older than the rule how
//! they are written, so they are compared here and not by the database; the rows are short.

use futures_util::{TryStream, TryStreamExt as _};
use sqlx::FromRow;
use uuid::Uuid;

use super::{columns::Integer, row::MeasurandRow};
use crate::jobs::{Measurand, Predecessor, Predecessors, Successors};

/// An iteration, without the axes.
#[derive(FromRow)]
pub struct SuccessorRow {
    number: Integer<u32>,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
}

/// Of an iteration and those after it, in order: the first after it, and the first that is of the
/// same flank and tooth.
pub async fn successors(
    mut rows: impl TryStream<Ok = SuccessorRow, Error = sqlx::Error> + Unpin,
    number: u32,
) -> Result<Successors, sqlx::Error> {
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

/// An iteration with the fit that stands.
#[derive(FromRow)]
pub struct PredecessorRow {
    number: Integer<u32>,
    #[sqlx(flatten)]
    measurand: MeasurandRow,
    fit_id: Uuid,
}

/// Of iterations with the greatest number first, those that are of the flank and tooth wanted, in
/// the order of their numbers.
pub async fn predecessors(
    mut rows: impl TryStream<Ok = PredecessorRow, Error = sqlx::Error> + Unpin,
    wanted: &Predecessors,
) -> Result<Vec<Predecessor>, sqlx::Error> {
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
