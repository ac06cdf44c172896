//! Parts of warning sentences.

use std::fmt;

use crate::spec::Criterion;
use flankfit_numerics::words::{Shown, Size, counted};

/// A regularisation that lacks what others have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regularized {
    /// Truncation of the singular values.
    TruncatedSvd,
    /// Shrinkage by the factor of James and Stein.
    JamesStein,
    /// Attraction to a target.
    Attraction,
    /// A roughness penalty.
    Tikhonov,
    /// The posterior of nodes and prior.
    Posterior,
    /// Constraints on the shape.
    Constrained,
    /// The matrix B of a representative piece.
    Representative,
}

impl fmt::Display for Regularized {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Regularized::TruncatedSvd => "a truncated singular value decomposition",
            Regularized::JamesStein => "James–Stein",
            Regularized::Attraction => "attraction",
            Regularized::Tikhonov => "Tikhonov",
            Regularized::Posterior => "a posterior",
            Regularized::Constrained => "a constrained fit",
            Regularized::Representative => "the B of a representative piece",
        })
    }
}

/// Quantity that cannot be computed without σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeedsSigma {
    /// A criterion.
    Criterion(Criterion),
    /// The shrinkage factor of James and Stein.
    JamesStein,
}

impl fmt::Display for NeedsSigma {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NeedsSigma::Criterion(criterion) => criterion.name(),
            NeedsSigma::JamesStein => "James–Stein",
        })
    }
}

/// A factor, in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times(pub f64);

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            factor if factor < 1e4 => write!(f, "{factor:.2} times"),
            factor if factor.is_finite() => write!(f, "{factor:.1e} times"),
            _ => f.write_str("infinitely many times"),
        }
    }
}

/// Residuals that are not as large as the uncertainties of positions and heights make them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    /// σ of the residuals over the given uncertainty of heights.
    pub ratio: f64,
    /// Degrees of freedom of σ.
    pub freedom: usize,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mend = match self.ratio < 1.0 {
            true => "tell smaller uncertainties",
            false => "tell larger uncertainties, or look for what the model lacks",
        };
        write!(
            f,
            "the residuals are {} times as large as the uncertainties of positions and heights make them, which with {} \
             is no chance: look whether both are in the units of the nodes, {mend}",
            Size(self.ratio),
            counted(self.freedom, "degree of freedom", "degrees of freedom")
        )
    }
}

/// Nodes without which the others are fitted exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct ExactWithout {
    /// The posted nodes, ten at most.
    pub nodes: Vec<usize>,
    /// Their number.
    pub count: usize,
    /// True if every height is fitted exactly as it is.
    pub all: bool,
}

impl fmt::Display for ExactWithout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.all {
            return f.write_str(
                "every height is fitted exactly: studentised residuals, Cook's distances and DFFITS divide by the \
                 noise, of which there is none",
            );
        }
        write!(
            f,
            "without {} (node {}{}) the others are fitted exactly: its externally studentised residual and DFFITS \
             divide by the noise of the others, of which there is none",
            counted(self.count, "node", "nodes in turn"),
            self.nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
            if self.nodes.len() < self.count { ", …" } else { "" }
        )
    }
}

/// The shape of a distribution at an end of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeBound {
    /// Degrees of freedom of Student's distribution.
    Freedom(f64),
    /// The exponent of the generalised normal distribution.
    Exponent(f64),
}

impl fmt::Display for ShapeBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ShapeBound::Freedom(nu) => write!(f, "ν is {}, the least that there is", Shown(*nu)),
            ShapeBound::Exponent(p) => write!(f, "exponent is {}, an end of its range", Shown(*p)),
        }
    }
}

/// A small probability; one that no double holds is not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Probability(pub f64);

impl fmt::Display for Probability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            p if p < 1e-300 => f.write_str("less than 1e-300"),
            p => write!(f, "{p:.1e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        result::{PriorConflict, Warning},
        spec::Along,
    };

    #[test]
    fn no_probability_is_said_to_be_0() {
        let none = "less than 1e-300";
        for (p, said) in [(0.0, none), (1e-310, none), (2.34e-9, "2.3e-9"), (0.01, "1.0e-2")] {
            assert_eq!(Probability(p).to_string(), said);
            let residuals = Warning::CorrelatedResiduals { along: Along::U, correlation: 0.9, p, factor: 4.0 };
            let prior = Warning::PriorConflict(PriorConflict { statistic: 9.5, p, let_go: true });
            for warning in [residuals, prior] {
                assert!(warning.to_string().contains(&format!("a probability of {said}")), "{warning}");
            }
        }
    }
}
