//! Residuals `Y − X Â_B` with the caller's X, formed in the well-conditioned working basis.

use super::{observations::Evidence, summary::SummaryStatistics};
use crate::{
    data::{Grid, Nodes},
    design::Design,
    factor::{Factor, Precision, Wanted, multiply_upper_vector, residual_pass},
};
use flankfit_numerics::{Dd, triangular};

/// A residual this small against the heights has lost digits in double precision.
const SMALL: f64 = 1e-7;

/// Residuals of one coefficient vector.
pub(crate) struct Residuals {
    pub rss: f64,
    /// `None` where the nodes are gone.
    pub max_abs: Option<f64>,
    /// Single residuals, if requested and the nodes are kept.
    pub values: Option<Vec<f64>>,
}

/// Coefficients in Q's coordinates and in the working basis.
pub(crate) struct LinearProblem<'a> {
    pub design: &'a Design,
    pub factor: &'a Factor,
    /// Σ w z².
    pub heights: f64,
    pub evidence: Evidence<'a>,
}

impl LinearProblem<'_> {
    fn grid(&self) -> Option<&Grid> {
        match self.evidence {
            Evidence::Posted { nodes: Nodes::Grid(grid), .. } => Some(grid),
            _ => None,
        }
    }

    /// Residuals of the coefficients whose image `R c` is `b`.
    pub(crate) fn of_image(&self, b: &[Dd], keep: bool) -> Residuals {
        if let (Some(separable), Some(grid)) = (&self.factor.separable, self.grid()) {
            let run = |precision| {
                let (rss, max_abs, values) = separable.residuals(grid, b, precision, keep);
                Residuals { rss, max_abs: Some(max_abs), values: keep.then_some(values) }
            };
            return self.sharpened(run);
        }
        if let Evidence::Summed(summary) = self.evidence {
            return self.of_sums(summary, b);
        }
        let mut working = b.to_vec();
        triangular::solve_upper(&self.factor.r, &mut working);
        self.of_working(&working, keep)
    }

    /// Residuals of working coefficients.
    pub(crate) fn of_working(&self, working: &[Dd], keep: bool) -> Residuals {
        match self.evidence {
            Evidence::Posted { sample, .. } => self.sharpened(|precision| {
                let wanted = if keep { Wanted::Values } else { Wanted::Sums };
                let pass = residual_pass(self.design, sample, working, precision, wanted);
                let values = keep.then_some(pass.values);
                Residuals { rss: pass.rss.to_f64(), max_abs: Some(pass.max_abs), values }
            }),
            Evidence::Summed(summary) => {
                let mut image = working.to_vec();
                multiply_upper_vector(&self.factor.r, &mut image);
                self.of_sums(summary, &image)
            }
        }
    }

    /// Residuals without the nodes: `‖√Ω(z − Wc)‖² = ‖Qᵀ√Ωz − Rc‖² + rss`.
    fn of_sums(&self, summary: &SummaryStatistics, image: &[Dd]) -> Residuals {
        let moved = self.factor.qty.iter().zip(image).fold(Dd::ZERO, |sum, (&b, &x)| sum + (b - x) * (b - x));
        Residuals { rss: (summary.rss + moved).to_f64(), max_abs: None, values: None }
    }

    /// In double precision first, and again in double-double where nothing but rounding would be
    /// left.
    fn sharpened(&self, run: impl Fn(Precision) -> Residuals) -> Residuals {
        let plain = run(Precision::Double);
        if plain.rss > SMALL * SMALL * self.heights { plain } else { run(Precision::DoubleDouble) }
    }
}
