//! Why something cannot be written.

use flankfit_numerics::fault::words::Shown;

/// Why a shape or mesh has no place in a file. `shape` counts from 0 within what was to be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportFault {
    /// No shape was given.
    #[error("there is nothing to write")]
    Nothing,
    /// A shape of degree 0.
    #[error("shape {shape} has degree 0; curves and surfaces of CAD have at least 1")]
    DegreeZero {
        /// The shape at fault.
        shape: usize,
    },
    /// A weight that is not above 0.
    #[error("weight {index} of shape {shape} is {value}; weights in CAD files are above 0", value = Shown(*.value))]
    Weight {
        /// The shape at fault.
        shape: usize,
        /// Index of the weight; in a net counted by rows.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A shape with numbers beyond the range of a double.
    #[error("shape {shape} leaves the range of doubles on its way to the file")]
    NotFinite {
        /// The shape at fault.
        shape: usize,
    },
    /// Fewer than two parameters along a direction.
    #[error("{given} parameters along one direction make no faces; at least 2 are needed")]
    FewParameters {
        /// Parameters given.
        given: usize,
    },
    /// A parameter not above the one before it.
    #[error(
        "parameter {index} ({value}) does not lie above the one before it ({before})",
        value = Shown(*.value), before = Shown(*.before)
    )]
    Descending {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
        /// The parameter before it.
        before: f64,
    },
    /// More nodes than a mesh may have.
    #[error("{wanted} nodes are more than {most}")]
    TooManyNodes {
        /// Nodes asked for.
        wanted: usize,
        /// The most that a mesh may have.
        most: usize,
    },
    /// A point beyond the range of a double.
    #[error("the place at the parameters {at:?} leaves the range of doubles")]
    NoPlace {
        /// Its parameters (u, v).
        at: [f64; 2],
    },
    /// A tolerance that is negative or not finite.
    #[error("the tolerance {tolerance} is not a length that nodes can be compared by", tolerance = Shown(*.tolerance))]
    Tolerance {
        /// The tolerance, mm.
        tolerance: f64,
    },
    /// A polyline that cannot come as near to its curve as asked.
    #[error(
        "chords come no nearer than {reached} to the curve within a million of them and the rounding of its places, \
         not {tolerance}", tolerance = Shown(*.tolerance), reached = Shown(*.reached))]
    Chords {
        /// Distance asked for, mm.
        tolerance: f64,
        /// Distance reached, mm.
        reached: f64,
    },
    /// A field that has not one value for each node.
    #[error("the field {name} has {given} values for {wanted} nodes")]
    FieldLength {
        /// Name of the field.
        name: String,
        /// Values given.
        given: usize,
        /// Nodes of the sample.
        wanted: usize,
    },
    /// A value of a field that is NaN or infinite.
    #[error("value {index} of the field {name} is not finite")]
    FieldValue {
        /// Name of the field.
        name: String,
        /// Index of the value.
        index: usize,
    },
    /// A node beyond the range of the file's numbers.
    #[error("node {index} leaves the range of the file's numbers")]
    NodeRange {
        /// Index of the node.
        index: usize,
    },
    /// A surface that no B-spline comes near enough to.
    #[error(
        "no B-spline comes nearer than {deviation} to a patch, more than {tolerance}",
        deviation = Shown(*.deviation), tolerance = Shown(*.tolerance)
    )]
    Deviation {
        /// Distance reached, mm.
        deviation: f64,
        /// Distance asked for, mm.
        tolerance: f64,
    },
    /// More lines than the format can number.
    #[error("the file would have {lines} lines; this format numbers at most {most}")]
    TooLong {
        /// Lines that the file would have.
        lines: usize,
        /// The most that the format can number.
        most: usize,
    },
}
