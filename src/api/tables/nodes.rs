//! Nodes out of a table, with what the table says of their axes.

use super::mapping::{MappingBody, axis_unit};
use crate::api::{
    faults::{Faults, pointer_of},
    json::{
        error::ReadError,
        text::{SHORT, ShortText},
    },
    measurand::axes::{AxesBody, AxisBody, MeasurandBody, PositiveName, known_axis, trace_lengths},
};
use flankfit_engine::{
    estimation::Nodes,
    formats::{
        FileError, Table,
        table::{self, ColumnSpec, HelixSign, Layout, Mapping, Meaning, NodeSet, TableFault, Unit},
    },
    gear::{Side, evaluation::OwnZeros},
    words::{counted, listed},
};

/// Why nodes are not fitted as a table has them.
const TURNED: &str = "the helix traces have the opposite sign of the profiles that they cross: import the file into a \
    job, or send the nodes that `POST /v1/nodes/read?include=nodes` returns, which are corrected";

const OWN_ZEROS: &str = "each of its traces has its own zero: import the file into a job, or send its traces to `POST \
    /v1/gears/evaluate`; if they share one zero, map the column of traces as `ignore`";

/// Nodes of one flank out of a table.
pub struct TableNodes {
    pub nodes: Nodes,
    /// Rows without a height, and crossings of a grid without a row.
    pub missing: usize,
    /// Sign of its helix traces, if they cross profiles; turned ones have their heights changed.
    pub helix_sign: Option<HelixSign>,
    /// Its traces, where each has a zero of its own.
    pub own_zeros: Option<OwnZeros>,
    /// The flank and the tooth, where the table says it, and what the axes mean.
    pub measurand: MeasurandBody,
}

/// Reads a table; its errors are at `pointer`, those of the mapping at `/mapping`.
pub fn table(bytes: &[u8], mapping: Option<&MappingBody>, pointer: &str) -> Result<Table, ReadError> {
    let mapping = mapping.map_or_else(Mapping::default, Mapping::from);
    table::read(bytes, &mapping).map_err(|error| refusal(&error, pointer))
}

/// The nodes of the only flank of a table, which its helix traces count as its profiles do.
pub fn only(table: &Table, pointer: &str) -> Result<TableNodes, ReadError> {
    let sets = table.node_sets().map_err(|error| refusal(&error, pointer))?;
    let count = sets.len();
    match sets.into_iter().next() {
        Some(set) if count == 1 => {
            let of = of_set(table, set, pointer)?;
            let turned = of.helix_sign == Some(HelixSign::Turned);
            let refusal = turned.then_some(TURNED).or(of.own_zeros.is_some().then_some(OWN_ZEROS));
            refusal.map_or(Ok(of), |why| Err(Faults::one(pointer, why).into()))
        }
        _ => {
            let detail = format!(
                "the table has nodes of {}; send those of one, or import the file into a job and name `flank` and `tooth`",
                counted(count, "flank", "flanks")
            );
            Err(Faults::one(pointer, detail).into())
        }
    }
}

/// The nodes of the flank that is asked for, or of that with the most of them.
pub fn chosen(table: &Table, tooth: Option<&str>, side: Option<Side>, pointer: &str) -> Result<TableNodes, ReadError> {
    let sets = table.node_sets().map_err(|error| refusal(&error, pointer))?;
    let fits = |set: &NodeSet| {
        let of_tooth = set.tooth.as_deref().zip(tooth).is_none_or(|(own, asked)| own == asked);
        of_tooth && set.flank.zip(side).is_none_or(|(own, asked)| own == asked)
    };
    let known: Vec<String> = sets.iter().take(10).map(name_of).collect();
    let Some(set) = sets.into_iter().find(fits) else {
        let pointer = if tooth.is_some() { "/spec/tooth" } else { "/spec/flank" };
        return Err(Faults::one(pointer, format!("the table has nodes of {}", listed(known))).into());
    };
    let mut of = of_set(table, set, pointer)?;
    of.measurand.flank = of.measurand.flank.or(side);
    of.measurand.tooth = of.measurand.tooth.or(tooth.and_then(ShortText::new));
    Ok(of)
}

/// A flank as messages call it.
pub fn name_of(set: &NodeSet) -> String {
    let side = set.flank.map_or("flank", |side| if side == Side::Left { "left flank" } else { "right flank" });
    set.tooth.as_ref().map_or_else(|| format!("the {side}"), |tooth| format!("the {side} of tooth {tooth}"))
}

/// The nodes of one flank of a table.
pub fn of_set(table: &Table, set: NodeSet, pointer: &str) -> Result<TableNodes, ReadError> {
    let NodeSet { tooth, flank, missing, nodes, layout, crossings, own_zeros, count: _ } = set;
    let nodes = nodes.map_err(|faults| Faults::placed(&faults, |_| pointer.to_owned()))?;
    let tooth = tooth.and_then(|tooth| {
        let tooth: String = tooth.chars().filter(|c| !c.is_control()).take(SHORT).collect();
        ShortText::new(&tooth)
    });
    let measurand = MeasurandBody { flank, tooth, axes: axes(table, layout, own_zeros.as_ref()) };
    let helix_sign = crossings.map(|crossings| crossings.helix_sign());
    Ok(TableNodes { nodes, missing, helix_sign, own_zeros, measurand })
}

/// Returns the axes if the columns are those of a flank.
pub fn axes(table: &Table, layout: Layout, own_zeros: Option<&OwnZeros>) -> Option<AxesBody> {
    let find = |meanings: &[Meaning]| {
        meanings.iter().find_map(|meaning| table.columns.iter().find(|column| column.meaning == *meaning))
    };
    let axis = |column: Option<&ColumnSpec>| -> Option<AxisBody> {
        let ColumnSpec { meaning, unit, .. } = column?;
        let quantity = match meaning {
            Meaning::RollAngle => "roll_length",
            other => other.name(),
        };
        let positive = (*meaning == Meaning::Deviation).then_some(PositiveName::MaterialOut);
        known_axis(quantity, axis_unit((*unit)?), positive)
    };
    let along = axis(find(&[Meaning::RollLength, Meaning::Diameter, Meaning::RollAngle]));
    let across = axis(find(&[Meaning::FaceWidth]));
    let height = axis(find(&[Meaning::Deviation]));
    let height = height.map(|axis| AxisBody { trace_lengths: own_zeros.map(trace_lengths), ..axis });
    let axes = match layout {
        Layout::Curve => AxesBody { x: along.or(across), y: height, ..AxesBody::default() },
        _ => AxesBody { u: along, v: across, z: height, ..AxesBody::default() },
    };
    (axes != AxesBody::default()).then_some(axes)
}

/// Whether a table has deviations in µm over places in mm.
pub fn is_in_micrometres(table: &Table) -> bool {
    let in_unit = |meanings: &[Meaning], unit: Unit| {
        table.columns.iter().any(|column| meanings.contains(&column.meaning) && column.unit == Some(unit))
    };
    in_unit(&[Meaning::Deviation], Unit::Micrometre)
        && in_unit(&[Meaning::RollLength], Unit::Millimetre)
        && in_unit(&[Meaning::FaceWidth], Unit::Millimetre)
}

/// Returns the error for a table that cannot be read: one sentence, then the first places.
pub fn refusal(error: &FileError, pointer: &str) -> ReadError {
    let mut faults = Faults::default();
    match error {
        FileError::Table(fault) => {
            let TableFault { path, message, places, .. } = &**fault;
            if let Some(place) = places.iter().find(|place| is_no_number(&place.found)) {
                let detail = format!(
                    "Line {}, column {}: NaN and Infinity are not allowed in a table; leave the height of a missing \
                     node empty.",
                    place.line, place.column
                );
                return ReadError::Malformed { detail };
            }
            faults.push(path.as_deref().map_or_else(|| pointer.to_owned(), pointer_of), message);
            places.iter().for_each(|place| faults.push(pointer, place.to_string()));
        }
        other => faults.push(pointer, other.to_string()),
    }
    faults.into()
}

/// Whether a cell is one of the words for what is no number, which JSON has not either.
fn is_no_number(cell: &str) -> bool {
    let word = cell.trim_start_matches(['-', '+']);
    ["nan", "inf", "infinity"].iter().any(|known| word.eq_ignore_ascii_case(known))
}
