//! End conditions of a cubic spline.

use crate::space::Vector;

/// Condition of a spline at one end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// This first derivative by the parameter.
    Slope(Vector),
    /// This second derivative by the parameter; zero is a free end.
    SecondDerivative(Vector),
    /// The third derivative is continuous at the node next to the end: the two pieces there are one
    /// cubic.
    NotAKnot,
}

/// Conditions of a spline at its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ends {
    /// One condition each.
    Each {
        /// Condition at the first node.
        start: End,
        /// Condition at the last node.
        end: End,
    },
    /// It ends as it starts: value, first and second derivative. The first and last value are
    /// equal.
    Periodic,
}

impl Ends {
    /// Given slopes.
    pub fn clamped(start: Vector, end: Vector) -> Self {
        Ends::Each { start: End::Slope(start), end: End::Slope(end) }
    }

    /// Given second derivatives.
    pub fn second_derivatives(start: Vector, end: Vector) -> Self {
        Ends::Each { start: End::SecondDerivative(start), end: End::SecondDerivative(end) }
    }

    /// Free ends: no second derivative.
    pub fn natural() -> Self {
        Self::second_derivatives(Vector::zeros(), Vector::zeros())
    }

    /// Continuous third derivatives next to both ends. Three nodes give the parabola, two the
    /// straight line.
    pub fn not_a_knot() -> Self {
        Ends::Each { start: End::NotAKnot, end: End::NotAKnot }
    }

    /// The same conditions with zeros for what is given.
    pub(super) fn homogeneous(&self) -> Self {
        let zero = |end: &End| match end {
            End::Slope(_) => End::Slope(Vector::zeros()),
            End::SecondDerivative(_) => End::SecondDerivative(Vector::zeros()),
            End::NotAKnot => End::NotAKnot,
        };
        match self {
            Ends::Each { start, end } => Ends::Each { start: zero(start), end: zero(end) },
            Ends::Periodic => Ends::Periodic,
        }
    }
}
