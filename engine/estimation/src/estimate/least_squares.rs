//! Plain least squares (Eq. 15).

use crate::{
    factor::multiply_upper_vector,
    problem::LinearProblem,
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::{Dd, triangular};

/// Plain least squares (Eq. 15).
pub(crate) struct LeastSquares {
    /// In the caller's terms.
    pub coefficients: Vec<f64>,
    pub working: Vec<Dd>,
    pub rss: f64,
    pub max_abs: Option<f64>,
}

impl LeastSquares {
    pub(crate) fn new(linear: &LinearProblem, columns: &ScaledColumns, spectrum: &Spectrum) -> Self {
        let factor = linear.factor;
        if let (Some(working), true) = (&factor.working, spectrum.full_rank()) {
            let mut coefficients = working.clone();
            triangular::solve_upper(&factor.change, &mut coefficients);
            return LeastSquares {
                coefficients: coefficients.iter().map(|x| x.to_f64()).collect(),
                working: working.clone(),
                rss: factor.rss,
                max_abs: factor.max_abs,
            };
        }
        let n = factor.size();
        let mut caller = vec![Dd::ZERO; n];
        for ((&j, &s), &x) in columns.kept.iter().zip(&columns.scale).zip(&spectrum.scaled) {
            caller[j] = x / s;
        }
        if let Some(constant) = &columns.constant {
            let shift =
                columns.kept.iter().zip(&constant.means).fold(Dd::ZERO, |sum, (&j, &mean)| sum + mean * caller[j]);
            caller[constant.index] = spectrum.level - shift;
        }
        let coefficients = caller.iter().map(|x| x.to_f64()).collect();
        multiply_upper_vector(&factor.change, &mut caller);
        let residuals = linear.of_working(&caller, false);
        LeastSquares { coefficients, working: caller, rss: residuals.rss, max_abs: residuals.max_abs }
    }
}
