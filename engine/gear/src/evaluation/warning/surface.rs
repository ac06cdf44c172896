//! Warnings about the nodes over a whole flank.

use super::{super::spacing::LEAST_COVERED, samples::percent};
use flankfit_numerics::{warnings, words::Shown};

warnings! {
/// Something that the reader of a flank's surface must know. Lengths are mm.
pub enum SurfaceWarning {
    /// Nodes that cover too little of the trimmed range along one axis.
    #[error(
        "the counted nodes span {} to {} mm, {} % of the range from {} to {} mm: less than {} %, so slope, crowning \
         and twist over it are extrapolated and not compared with limits; trim less, or measure more densely",
        Shown(.reached_mm[0]), Shown(.reached_mm[1]), percent(*.covered), Shown(.range_mm[0]),
        Shown(.range_mm[1]), percent(LEAST_COVERED)
    )]
    "range_not_covered" => RangeNotCovered {
        /// Path to what the range was asked for by.
        #[cfg_attr(feature = "contract", serde(skip))]
        path: &'static str,
        /// The least and the greatest roll length or z of a node.
        reached_mm: [f64; 2],
        /// The trimmed range.
        range_mm: [f64; 2],
        /// Share of the range that the nodes reach over.
        covered: f64,
    },
    /// Nodes over more than the face.
    #[error(
        "the nodes span {} mm in z, but the face is {} mm wide: check the unit",
        Shown(*.span_mm), Shown(*.face_width_mm)
    )]
    "outside_face_width" => OutsideFace { span_mm: f64, face_width_mm: f64 },
}
}

impl SurfaceWarning {
    /// Path to what it speaks of.
    pub fn path(&self) -> &'static str {
        match self {
            SurfaceWarning::RangeNotCovered { path, .. } => path,
            SurfaceWarning::OutsideFace { .. } => "z_mm",
        }
    }
}

/// The share of a range that nodes reach over.
pub fn share([first, last]: [f64; 2], [low, high]: [f64; 2]) -> f64 {
    (last - first) / (high - low)
}
