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
    #[error("the file would have {lines} lines; this format numbers at most {most}")]
    TooLong { lines: usize, most: usize },
}
