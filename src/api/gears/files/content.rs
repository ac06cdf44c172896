//! Contents of a file: traces and their evaluation, deviations, and nodes of an iteration.

use super::{pitch::FilePitch, spec::ImportSpecBody};
use crate::{
    api::{
        faults::Faults,
        gears::evaluation::{answer::EvaluationBody, request::EvaluateBody},
        json::text::{SHORT, ShortText},
        measurand::axes::{AxesBody, AxisBody, MeasurandBody, PositiveName, known_axis, trace_lengths},
        problem::Problem,
        tables::nodes,
        warning::WarningBody,
    },
    jobs::Measurand,
};
use flankfit_engine::{
    estimation::Nodes,
    formats::{FileError, Note, Notes},
    gear::{Gear, Side, deviation::Deviations, evaluation::OwnZeros},
};

/// A file, read.
pub struct FileRead {
    pub gear: Gear,
    /// Evaluation of the traces (signs of DIN), if there are any, with the warnings about the file.
    pub evaluation: Option<EvaluationBody>,
    /// All traces of the file, in the form in which they can be posted again; with `evaluation`.
    pub request: Option<EvaluateBody>,
    /// Tables of pitches, if there are any.
    pub pitch: Option<FilePitch>,
    /// Deviations of points and topographies.
    pub deviations: Option<Deviations>,
    /// Nodes with u = roll length and v = z (mm), heights in µm along the normal, positive where
    /// material protrudes.
    pub nodes: Vec<FlankNodes>,
    pub warnings: Vec<WarningBody>,
}

/// Nodes of one flank.
pub struct FlankNodes {
    pub tooth: String,
    pub side: Side,
    /// Number of traces, or 0 for points.
    pub traces: usize,
    /// (roll length, z, deviation); undefined ones are left out. Traces follow each other.
    pub places: Vec<[f64; 3]>,
    /// Zeros of the traces, if each has its own.
    pub own_zeros: Option<OwnZeros>,
}

/// Returns the problem for a file that cannot be read, with line and column.
pub fn unreadable(error: &FileError) -> Problem {
    nodes::refusal(error, "/file").into()
}

pub(in crate::api) fn nothing_measured(what: &str) -> Problem {
    Problem::invalid(Faults::one("/file", format!("no nodes in the file: {what}")))
}

/// Returns the warnings of a reader.
pub(in crate::api) fn notices(notes: &Notes) -> Vec<WarningBody> {
    let each = notes.list().iter();
    each.map(|Note { line, remark }| WarningBody::new(remark.code(), format!("line {line}: {remark}"))).collect()
}

impl FileRead {
    /// Returns the requested flank, or the one with the most nodes, the left one before the right.
    pub fn flank(&self, spec: &ImportSpecBody) -> Result<&FlankNodes, Problem> {
        let fits = |flank: &&FlankNodes| {
            spec.tooth.as_ref().is_none_or(|tooth| *tooth == flank.tooth)
                && spec.flank.is_none_or(|side| side == flank.side)
        };
        self.nodes.iter().find(fits).ok_or_else(|| {
            let known: Vec<String> = self
                .nodes
                .iter()
                .map(|flank| format!("the {} flank of tooth {}", word(flank.side), flank.tooth))
                .collect();
            let detail = if known.is_empty() {
                "the position of no trace on its flank is known".to_owned()
            } else {
                format!("the file has no traces of this flank; it has {}", known.join(", "))
            };
            let pointer = if spec.tooth.is_some() { "/spec/tooth" } else { "/spec/flank" };
            Problem::invalid(Faults::one(pointer, detail))
        })
    }
}

impl FlankNodes {
    /// Returns the nodes of a fit; along the one coordinate that varies if all lie on one line.
    pub fn nodes(&self) -> Result<Nodes, Problem> {
        let column = |c: usize| self.places.iter().map(|place| place[c]).collect::<Vec<f64>>();
        let nodes = match (self.varies(0), self.varies(1)) {
            (true, false) => Nodes::curve(column(0), column(2), None),
            (false, true) => Nodes::curve(column(1), column(2), None),
            _ => Nodes::scattered(column(0), column(1), column(2), None),
        };
        nodes.map_err(|faults| Problem::invalid(Faults::placed(&faults, |_| "/file".to_owned())))
    }

    fn varies(&self, c: usize) -> bool {
        self.places.iter().any(|place| place[c] != self.places[0][c])
    }

    /// Returns the measurand of these nodes, as the file gives it.
    pub fn measurand(&self, nodes: &Nodes) -> Result<Measurand, Faults> {
        let along_profile = known_axis("roll_length", "mm", None);
        let along_helix = known_axis("face_width", "mm", None);
        let trace_lengths = self.own_zeros.as_ref().map(trace_lengths);
        let height = known_axis("deviation", "um", Some(PositiveName::MaterialOut))
            .map(|axis| AxisBody { trace_lengths, ..axis });
        let axes = match (self.varies(0), self.varies(1)) {
            (true, false) => AxesBody { x: along_profile, y: height, ..AxesBody::default() },
            (false, true) => AxesBody { x: along_helix, y: height, ..AxesBody::default() },
            _ => AxesBody { u: along_profile, v: along_helix, z: height, ..AxesBody::default() },
        };
        let tooth: String = self.tooth.chars().filter(|c| !c.is_control()).take(SHORT).collect();
        MeasurandBody { flank: Some(self.side), tooth: ShortText::new(&tooth), axes: Some(axes) }.checked(Some(nodes))
    }
}

/// Returns the word for a flank in messages.
pub fn word(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}
