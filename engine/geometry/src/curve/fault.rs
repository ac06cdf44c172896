//! Reasons for refusing a curve, with the place in the input.

use crate::{KnotFault, space::ControlFault};
use flankfit_numerics::fault::words::{Shown, are};

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
    /// Fewer entries than the method needs.
    #[error("{given} {} too few: at least {least} {} needed", are(*.given), are(*.least))]
    TooFew {
        /// The list that the fault is in.
        part: Part,
        /// Entries given.
        given: usize,
        /// Entries at least needed.
        least: usize,
    },
    /// More entries than the method can take.
    #[error("{given} {} too many: at most {most} {} possible", are(*.given), are(*.most))]
    TooMany {
        /// The list that the fault is in.
        part: Part,
        /// Entries given.
        given: usize,
        /// Entries at most possible.
        most: usize,
    },
    /// A list whose length does not fit the others.
    #[error("{given} {} given where {wanted} {} needed", are(*.given), are(*.wanted))]
    Count {
        /// The list that the fault is in.
        part: Part,
        /// Entries given.
        given: usize,
        /// Entries needed.
        wanted: usize,
    },
    /// An entry is NaN or infinite.
    #[error("number {index} is not finite")]
    NotFinite {
        /// The list that the fault is in.
        part: Part,
        /// Its index, from 0.
        index: usize,
    },
    /// A derivative at a node is NaN or infinite.
    #[error("number {order} at node {node} is not finite")]
    DerivativeNotFinite {
        /// Index of the node, from 0.
        node: usize,
        /// Its index among the derivatives of the node: 0 is the first derivative.
        order: usize,
    },
    /// More derivatives at a node than are allowed.
    #[error("{given} derivatives are given at node {node}, more than {most}")]
    TooManyDerivatives {
        /// Index of the node, from 0.
        node: usize,
        /// Derivatives given there.
        given: usize,
        /// Derivatives at most allowed at a node.
        most: usize,
    },
    /// Two nodes with the same abscissa or parameter.
    #[error("number {index} ({}) repeats number {first}", Shown(*.value))]
    Repeated {
        /// The list that the fault is in.
        part: Part,
        /// Index of the later one, from 0.
        index: usize,
        /// Index of the earlier one, from 0.
        first: usize,
        /// The value that both have.
        value: f64,
    },
    /// Two neighbours so close that their difference has no correct digits in a double.
    #[error("number {index} ({}) lies no more than {difference} above the one before it, which leaves a double no \
        digits", Shown(*.value), difference = Shown(*.difference))]
    TooClose {
        /// The list that the fault is in.
        part: Part,
        /// Index of the later of the two, from 0.
        index: usize,
        /// Value of the later of the two.
        value: f64,
        /// Difference of the two.
        difference: f64,
    },
    /// A node lies below the one before it.
    #[error("number {index} ({}) lies below the one before it ({}); the order of nodes is never changed",
        Shown(*.value), Shown(*.before))]
    Descending {
        /// The list that the fault is in.
        part: Part,
        /// Index of the later of the two, from 0.
        index: usize,
        /// Value of the later of the two.
        value: f64,
        /// Value of the node before it.
        before: f64,
    },
    /// Fewer nodes than the degree asks for.
    #[error("degree {degree} asks for at least {least} nodes, {nodes} are given")]
    DegreeAboveNodes {
        /// Degree asked for.
        degree: usize,
        /// Nodes given.
        nodes: usize,
        /// Nodes at least needed.
        least: usize,
    },
    /// A degree that the method does not have.
    #[error("degree {degree} is not within {least} to {most}")]
    Degree {
        /// Degree asked for.
        degree: usize,
        /// Lowest degree of the method.
        least: usize,
        /// Highest degree of the method.
        most: usize,
    },
    /// The knot vector is refused.
    #[error("{0}")]
    Knots(#[from] KnotFault),
    /// A node outside of the support of its basis function, so that the equations are singular
    /// (condition of Schoenberg and Whitney).
    #[error(
        "node {node} (at {}) does not lie inside the support of its basis function, knots {knot} to {until} \
         ({} to {}): the condition of Schoenberg and Whitney",
        Shown(*.value), Shown(*.low), Shown(*.high)
    )]
    SchoenbergWhitney {
        /// Index of the node and of its basis function, from 0.
        node: usize,
        /// Abscissa or parameter of the node.
        value: f64,
        /// Index of the first knot of the support.
        knot: usize,
        /// Index of the last knot of the support.
        until: usize,
        /// Lower end of the support.
        low: f64,
        /// Upper end of the support.
        high: f64,
    },
    /// The control points or weights are refused.
    #[error("{0}")]
    Controls(#[from] ControlFault),
    /// A periodic curve whose nodes do not close.
    #[error(
        "a periodic curve ends where it starts, but node {index} differs from node 0 by {difference}",
        difference = Shown(*.difference)
    )]
    NotPeriodic {
        /// The list that the fault is in.
        part: Part,
        /// Index of the last node, from 0.
        index: usize,
        /// Largest difference of a coordinate between the last node and the first.
        difference: f64,
    },
    /// The equations of the curve are singular in double precision.
    #[error("the equations of the curve are singular at unknown {index}")]
    Singular {
        /// Index of the unknown without a pivot, from 0.
        index: usize,
    },
    /// A place outside of the curve's domain.
    #[error("the place {} is not within the domain [{}, {}]", Shown(*.value), Shown(*.low), Shown(*.high))]
    OutOfDomain {
        /// The place.
        value: f64,
        /// Lower end of the domain.
        low: f64,
        /// Upper end of the domain.
        high: f64,
    },
    /// A node outside of the domain of the knots.
    #[error("node {node} (at {}) is not within the domain [{}, {}] of the knots", Shown(*.value), Shown(*.low),
        Shown(*.high))]
    NodeOutOfDomain {
        /// Index of the node, from 0.
        node: usize,
        /// Abscissa or parameter of the node.
        value: f64,
        /// Lower end of the domain.
        low: f64,
        /// Upper end of the domain.
        high: f64,
    },
    /// A coefficient beyond the range of a double.
    #[error("coefficient {index} of the curve is beyond the range of a double")]
    NotRepresentable {
        /// Its index, from 0.
        index: usize,
    },
    /// The computed curve misses a node by more than rounding should.
    #[error("by rounding alone the curve misses node {index} by {miss}", miss = Shown(*.miss))]
    Misses {
        /// Index of the node, from 0.
        index: usize,
        /// Distance of the curve from it, in the unit of the coordinates.
        miss: f64,
    },
    /// An interpolating polynomial that double-double precision does not suffice for.
    #[error(
        "in double-double precision the polynomial still misses node {index} by {miss}: too many nodes in this \
         order; \
         use the barycentric form or a spline", miss = Shown(*.miss))]
    Unstable {
        /// Index of the node, from 0.
        index: usize,
        /// Distance of the curve from it, in the unit of the coordinates.
        miss: f64,
    },
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
pub(crate) fn check_points(part: Part, points: &[crate::space::Vector]) -> Result<(), CurveFault> {
    match points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(index) => Err(CurveFault::NotFinite { part, index }),
        None => Ok(()),
    }
}
