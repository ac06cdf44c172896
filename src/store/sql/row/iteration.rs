//! Iterations, and what they are of.

use sqlx::{ColumnIndex, Decode, FromRow, Row, Type};
use uuid::Uuid;

use super::fit::FitSummaryRow;
use crate::{
    jobs::{
        Decision, DecisionEvent, FitSummary, Iteration, ListedIteration, Measurand, MeasurementDetails,
        RepositoryError, TracedIteration, has_no_tooth,
    },
    store::sql::columns::{Flank, Integer, Moment, NodesColumn},
};
use flankfit_engine::estimation::Nodes;

row! {
    pub struct MeasurandRow {
        @units_accepted: UnitsAccepted,
        flank: Option<Flank>,
        tooth: Option<String>,
        axes: Option<String>,
    }
}

/// Whether the units were accepted; rows without the column are those of streams or need no answer.
pub struct UnitsAccepted(bool);

impl<'r, R: Row> FromRow<'r, R> for UnitsAccepted
where
    &'static str: ColumnIndex<R>,
    bool: Decode<'r, R::Database> + Type<R::Database>,
{
    fn from_row(row: &'r R) -> Result<Self, sqlx::Error> {
        match row.try_get("units_accepted") {
            Err(sqlx::Error::ColumnNotFound(_)) => Ok(UnitsAccepted(false)),
            found => found.map(UnitsAccepted),
        }
    }
}

impl From<MeasurandRow> for Measurand {
    fn from(row: MeasurandRow) -> Self {
        Measurand {
            flank: row.flank.map(|Flank(side)| side),
            tooth: row.tooth,
            axes: row.axes.map(Into::into),
            units_accepted: row.units_accepted.0,
        }
    }
}

row! {
    pub struct DetailsRow {
        measured_at: Option<Moment>,
        instrument: Option<String>,
        operator: Option<String>,
        note: Option<String>,
    }
}

impl From<DetailsRow> for MeasurementDetails {
    fn from(DetailsRow { measured_at, instrument, operator, note }: DetailsRow) -> Self {
        MeasurementDetails { measured_at: measured_at.map(|at| at.0), instrument, operator, note }
    }
}

row! {
    pub struct IterationRow {
        @measurand: MeasurandRow,
        @details: DetailsRow,
        id: Uuid,
        created_at: Moment,
        node_count: Integer<u64>,
        version: Integer<u64>,
        purged_at: Option<Moment>,
    }
}

impl IterationRow {
    /// The iteration of this number of a job, with its last fits and how many stand before them.
    pub fn with(
        self,
        (job_id, number): (Uuid, u32),
        (fits, earlier_fits): (Vec<FitSummary>, u64),
        decision: Option<DecisionEvent>,
    ) -> Iteration {
        Iteration {
            id: self.id,
            job_id,
            number,
            measurand: self.measurand.into(),
            details: self.details.into(),
            created_at: self.created_at.0,
            node_count: self.node_count.0,
            version: self.version.0,
            fits,
            earlier_fits,
            decision,
            purged_at: self.purged_at.map(|at| at.0),
        }
    }
}

row! {
    pub struct TracedIterationRow {
        @measurand: MeasurandRow,
        id: Uuid,
        number: Integer<u32>,
        measured_at: Option<Moment>,
        instrument: Option<String>,
        operator: Option<String>,
        created_at: Moment,
    }
}

impl From<TracedIterationRow> for TracedIteration {
    /// Without the lists.
    fn from(row: TracedIterationRow) -> Self {
        TracedIteration {
            id: row.id,
            number: row.number.0,
            measurand: row.measurand.into(),
            measured_at: row.measured_at.map(|at| at.0),
            instrument: row.instrument,
            operator: row.operator,
            created_at: row.created_at.0,
            fits: Vec::new(),
            choices: Vec::new(),
            decisions: Vec::new(),
            records: Vec::new(),
            earlier: Default::default(),
        }
    }
}

row! {
    /// Its columns have names of their own where those of the fit have the same.
    pub struct ListedIterationRow {
        @measurand: MeasurandRow,
        @fit: FitSummaryRow,
        iteration_id: Uuid,
        number: Integer<u32>,
        measured_at: Option<Moment>,
        instrument: Option<String>,
        operator: Option<String>,
        stored_at: Moment,
        decision: Option<Decision>,
        decided_by: Option<String>,
    }
}

impl From<ListedIterationRow> for ListedIteration {
    fn from(row: ListedIterationRow) -> Self {
        ListedIteration {
            id: row.iteration_id,
            number: row.number.0,
            measurand: row.measurand.into(),
            measured_at: row.measured_at.map(|at| at.0),
            instrument: row.instrument,
            operator: row.operator,
            created_at: row.stored_at.0,
            decision: row.decision,
            decided_by: row.decided_by.map(Into::into),
            fit: row.fit.into(),
        }
    }
}

row! {
    /// Nodes, unless they are longer than what was asked for, with their length.
    pub struct NodesRow {
        length: Integer<usize>,
        data: Option<NodesColumn>,
    }
}

impl NodesRow {
    /// Whether the nodes were purged: no encoding of any is empty.
    pub fn is_gone(&self) -> bool {
        self.length.0 == 0
    }
}

impl From<NodesRow> for Result<Nodes, usize> {
    fn from(NodesRow { length, data }: NodesRow) -> Self {
        data.map(|NodesColumn(nodes)| nodes).ok_or(length.0)
    }
}

row! {
    /// A tooth that was measured, by an iteration or by a stream that may become one.
    pub struct MeasuredTooth {
        tooth: String,
        iteration: Option<Integer<u32>>,
    }
}

impl MeasuredTooth {
    /// Refuses a gear with so many teeth, if it has not got one that was measured.
    pub fn check(measured: Vec<MeasuredTooth>, teeth: u32) -> Result<(), RepositoryError> {
        match measured.into_iter().find(|measured| has_no_tooth(&measured.tooth, teeth)) {
            None => Ok(()),
            Some(MeasuredTooth { tooth, iteration }) => {
                Err(RepositoryError::ToothMeasured { tooth, teeth, iteration: iteration.map(|number| number.0) })
            }
        }
    }
}
