//! Plain least squares for comparison with another estimate.

use super::{columns::Frame, filtered::Estimate, least_squares::LeastSquares};
use crate::{
    problem::LinearProblem,
    selection::{Filtered, Rule},
    spectrum::Spectrum,
};
use flankfit_numerics::Dd;

/// Plain least squares reported with another estimate, in the caller's terms.
pub(crate) struct PlainEstimate {
    pub coefficients: Vec<f64>,
    /// √((XᵀX)⁻¹)ⱼⱼ.
    pub leverage: Vec<f64>,
    pub rss: f64,
}

impl PlainEstimate {
    /// Estimate from the posted nodes, `linear` holding their factor and `frame` the analysis of
    /// its columns.
    pub(crate) fn new(linear: &LinearProblem, frame: &Frame) -> Self {
        let Frame { caller, columns, directions, .. } = frame;
        let qty = &linear.factor.qty;
        let level = columns.constant.as_ref().map_or(Dd::ZERO, |constant| constant.level(caller, qty));
        let spectrum = Spectrum::new(directions.clone(), qty, level);
        let least_squares = LeastSquares::new(linear, columns, &spectrum);
        let filtered: Vec<Filtered> = spectrum.lambda.iter().map(|&lambda| Rule::None.at(0, lambda, 0.0)).collect();
        let Estimate { leverage, .. } = Estimate::new(columns, &spectrum, &filtered, &least_squares);
        PlainEstimate { coefficients: least_squares.coefficients, leverage, rss: least_squares.rss }
    }
}
