//! Why something cannot be written.

/// Why a shape or mesh has no place in a file. `shape` counts from 0 within what was to be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportFault {
    #[error("there is nothing to write")]
    Nothing,
    #[error("shape {shape} has degree 0; curves and surfaces of CAD have at least 1")]
    DegreeZero { shape: usize },
    #[error("weight {index} of shape {shape} is {value:e}; weights in CAD files are above 0")]
    Weight { shape: usize, index: usize, value: f64 },
    #[error("shape {shape} leaves the range of doubles on its way to the file")]
    NotFinite { shape: usize },
    #[error("{given} parameters along one direction make no faces; at least 2 are needed")]
    FewParameters { given: usize },
    #[error("parameter {index} ({value}) does not lie above the one before it ({before})")]
    Descending { index: usize, value: f64, before: f64 },
    #[error("{wanted} nodes are more than {most}")]
    TooManyNodes { wanted: usize, most: usize },
    #[error("the place at the parameters {at:?} leaves the range of doubles")]
    NoPlace { at: [f64; 2] },
    #[error("the tolerance {tolerance} is not a length that nodes can be compared by")]
    Tolerance { tolerance: f64 },
    #[error(
        "chords come no nearer than {reached:e} to the curve within a million of them and the rounding of its places, \
         not {tolerance:e}"
    )]
    Chords { tolerance: f64, reached: f64 },
    #[error("the field {name} has {given} values for {wanted} nodes")]
    FieldLength { name: String, given: usize, wanted: usize },
    #[error("value {index} of the field {name} is not finite")]
    FieldValue { name: String, index: usize },
    #[error("node {index} leaves the range of the file's numbers")]
    NodeRange { index: usize },
    #[error("no B-spline comes nearer than {deviation:e} to a patch, more than {tolerance:e}")]
    Deviation { deviation: f64, tolerance: f64 },
    #[error("the file would have {lines} lines; this format numbers at most {most}")]
    TooLong { lines: usize, most: usize },
}
