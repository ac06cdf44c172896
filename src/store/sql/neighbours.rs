//! What was measured before and after an iteration. Names of teeth may be older than the rule how
//! they are written, so they are compared here and not by the database; the rows are short.

use futures_util::{TryStream, TryStreamExt as _};
use uuid::Uuid;

use super::{
    columns::{Integer, Moment},
    row::MeasurandRow,
};
use crate::jobs::{
    MadeCorrection, Measurand, MeasuredIteration, Predecessor, Predecessors, RecordKind, Rounds, Successors,
};

row! {
    /// An iteration, without the axes.
    pub struct SuccessorRow {
        @measurand: MeasurandRow,
        number: Integer<u32>,
    }
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

row! {
    /// An iteration with its chosen fit.
    pub struct PredecessorRow {
        @measurand: MeasurandRow,
        number: Integer<u32>,
        fit_id: Uuid,
    }
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

row! {
    /// An iteration with its time, without the axes.
    pub struct MeasuredRow {
        @measurand: MeasurandRow,
        number: Integer<u32>,
        created_at: Moment,
    }
}

row! {
    /// A correction without its texts.
    pub struct CorrectionRow {
        number: Integer<u32>,
        id: Uuid,
        kind: RecordKind,
        created_at: Moment,
    }
}

/// The rounds of a job, of its iterations by number and its corrections by time.
pub fn rounds(iterations: Vec<MeasuredRow>, corrections: Vec<CorrectionRow>) -> Rounds {
    let measured = |row: MeasuredRow| MeasuredIteration {
        number: row.number.0,
        measurand: row.measurand.into(),
        created_at: row.created_at.0,
    };
    let made = |row: CorrectionRow| MadeCorrection {
        number: row.number.0,
        id: row.id,
        kind: row.kind,
        created_at: row.created_at.0,
    };
    Rounds {
        iterations: iterations.into_iter().map(measured).collect(),
        corrections: corrections.into_iter().map(made).collect(),
    }
}
