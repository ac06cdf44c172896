//! Settings of a curve near points.

use crate::spec::FitSpec;

/// Messages for positions that are off, and for errors that are not white.
pub(crate) const POSITIONS_EXACT: &str = "streams and shapes near points take positions as exact";
pub(super) const WHITE_ONLY: &str = "shapes near points are fitted with independent errors of one variance";

/// Source of the knots.
#[derive(Clone, Debug, PartialEq)]
pub enum KnotPlacement {
    /// A full knot vector.
    Given(Vec<f64>),
    /// So many equal spans over the parameters.
    Spans(usize),
    /// So many control points, about as many parameters in every span.
    Averaged {
        /// Number of control points.
        controls: usize,
    },
    /// Knots where residuals ask for them.
    Adaptive(Adaptive),
}

/// Settings of a curve fit.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSettings {
    /// Degree of the B-splines.
    pub degree: usize,
    /// Source of the knots.
    pub knots: KnotPlacement,
    /// Weights of NURBS, one per control point; not with adaptive knots, whose number is not known.
    pub weights: Option<Vec<f64>>,
    /// Everything else; its model is not looked at.
    pub spec: FitSpec,
}

/// Settings of adaptive knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Equal spans to start with, at least 1.
    pub spans: usize,
    /// Largest distance of a counted point from the curve at its parameter, > 0.
    pub tolerance: f64,
    /// No more control points than these.
    pub most_controls: usize,
}
