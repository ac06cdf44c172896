//! Why a curve is refused, and where in the input the reason stands.

use crate::{
    fault::words::Shown,
    geometry::{KnotFault, space::ControlFault},
};

/// The part of the input that a fault speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The abscissae of a graph, or the parameters that points of plane or space were given: index
    /// i is that of point i.
    X,
    /// The ordinates of a graph.
    Y,
    /// The points of a parametric curve.
    Points,
    /// The given tangents of a cubic Hermite curve.
    Tangents,
    /// The given derivatives of a Hermite polynomial.
    Derivatives,
    /// What is given at the start of a cubic spline.
    Start,
    /// What is given at the end of a cubic spline.
    End,
    /// Knots.
    Knots,
    /// Control points and weights.
    Controls,
    /// The degree.
    Degree,
}

/// Why a curve is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurveFault {
    #[error("{given} are too few: at least {least} are needed")]
    TooFew { part: Part, given: usize, least: usize },
    #[error("{given} are too many: at most {most} are possible")]
    TooMany { part: Part, given: usize, most: usize },
    #[error("{given} are given where {wanted} are needed")]
    Count { part: Part, given: usize, wanted: usize },
    #[error("number {index} is not finite")]
    NotFinite { part: Part, index: usize },
    #[error("number {order} at node {node} is not finite")]
    DerivativeNotFinite { node: usize, order: usize },
    #[error("{given} derivatives are given at node {node}, more than {most}")]
    TooManyDerivatives { node: usize, given: usize, most: usize },
    #[error("number {index} ({}) repeats number {first}", Shown(*.value))]
    Repeated { part: Part, index: usize, first: usize, value: f64 },
    #[error("number {index} ({}) lies no more than {difference:e} above the one before it, which leaves a double no \
        digits", Shown(*.value))]
    TooClose { part: Part, index: usize, value: f64, difference: f64 },
    #[error("number {index} ({}) lies below the one before it ({}); the order of nodes is never changed",
        Shown(*.value), Shown(*.before))]
    Descending { part: Part, index: usize, value: f64, before: f64 },
    #[error("degree {degree} asks for at least {least} nodes, {nodes} are given")]
    DegreeAboveNodes { degree: usize, nodes: usize, least: usize },
    #[error("degree {degree} is not within {least} to {most}")]
    Degree { degree: usize, least: usize, most: usize },
    #[error("{0}")]
    Knots(#[from] KnotFault),
    #[error(
        "node {node} (at {}) does not lie inside the support of its basis function, knots {knot} to {until} \
         ({} to {}): the condition of Schoenberg and Whitney",
        Shown(*.value), Shown(*.low), Shown(*.high)
    )]
    SchoenbergWhitney { node: usize, value: f64, knot: usize, until: usize, low: f64, high: f64 },
    #[error("{0}")]
    Controls(#[from] ControlFault),
    #[error("a periodic curve ends where it starts, but node {index} differs from node 0 by {difference:e}")]
    NotPeriodic { part: Part, index: usize, difference: f64 },
    #[error("the equations of the curve are singular at unknown {index}")]
    Singular { index: usize },
    #[error("the place {} is not within the domain [{}, {}]", Shown(*.value), Shown(*.low), Shown(*.high))]
    OutOfDomain { value: f64, low: f64, high: f64 },
    #[error("node {node} (at {}) is not within the domain [{}, {}] of the knots", Shown(*.value), Shown(*.low),
        Shown(*.high))]
    NodeOutOfDomain { node: usize, value: f64, low: f64, high: f64 },
    #[error("coefficient {index} of the curve is beyond the range of a double")]
    NotRepresentable { index: usize },
    #[error("by rounding alone the curve misses node {index} by {miss:e}")]
    Misses { index: usize, miss: f64 },
    #[error(
        "in double-double precision the polynomial still misses node {index} by {miss:e}: too many nodes in this \
         order; \
         use the barycentric form or a spline"
    )]
    Unstable { index: usize, miss: f64 },
}

impl CurveFault {
    /// Which part of the input is at fault, where one is.
    pub fn part(&self) -> Option<Part> {
        use CurveFault::*;
        match self {
            TooFew { part, .. }
            | TooMany { part, .. }
            | Count { part, .. }
            | NotFinite { part, .. }
            | Repeated { part, .. }
            | TooClose { part, .. }
            | Descending { part, .. }
            | NotPeriodic { part, .. } => Some(*part),
            DerivativeNotFinite { .. } | TooManyDerivatives { .. } => Some(Part::Derivatives),
            DegreeAboveNodes { .. } | Degree { .. } => Some(Part::Degree),
            Knots(_) | SchoenbergWhitney { .. } => Some(Part::Knots),
            Controls(_) => Some(Part::Controls),
            OutOfDomain { .. } | NodeOutOfDomain { .. } => Some(Part::X),
            Unstable { .. } => Some(Part::Points),
            Singular { .. } | NotRepresentable { .. } | Misses { .. } => None,
        }
    }

    /// The place within that part, outermost first: one index, or node and order for a derivative;
    /// empty for the part as a whole.
    pub fn indices(&self) -> Vec<usize> {
        use CurveFault::*;
        match self {
            NotFinite { index, .. }
            | Repeated { index, .. }
            | TooClose { index, .. }
            | Descending { index, .. }
            | NotPeriodic { index, .. } => vec![*index],
            DerivativeNotFinite { node, order } => vec![*node, *order],
            TooManyDerivatives { node, .. } | NodeOutOfDomain { node, .. } => vec![*node],
            Knots(fault) => fault.index().into_iter().collect(),
            SchoenbergWhitney { knot, .. } => vec![*knot],
            Controls(fault) => fault.index().into_iter().collect(),
            _ => Vec::new(),
        }
    }
}

/// Refuses numbers that are not finite.
pub(crate) fn check_finite(part: Part, values: &[f64]) -> Result<(), CurveFault> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(CurveFault::NotFinite { part, index }),
        None => Ok(()),
    }
}

/// Differences below this have no room for the second half of a double-double, and their
/// reciprocals soon none for the first.
const LEAST_STEP: f64 = 1e-290;

/// Refuses numbers that are not finite, repeated, descending, or so close that their differences
/// lose digits.
pub(crate) fn check_ascending(part: Part, values: &[f64]) -> Result<(), CurveFault> {
    check_finite(part, values)?;
    for (i, pair) in values.windows(2).enumerate() {
        let (before, value, index) = (pair[0], pair[1], i + 1);
        if value == before {
            return Err(CurveFault::Repeated { part, index, first: i, value });
        }
        if value < before {
            return Err(CurveFault::Descending { part, index, value, before });
        }
        if value - before < LEAST_STEP {
            return Err(CurveFault::TooClose { part, index, value, difference: value - before });
        }
    }
    Ok(())
}

/// Refuses points with a coordinate that is not finite.
pub(crate) fn check_points(part: Part, points: &[crate::geometry::space::Vector]) -> Result<(), CurveFault> {
    match points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(index) => Err(CurveFault::NotFinite { part, index }),
        None => Ok(()),
    }
}
