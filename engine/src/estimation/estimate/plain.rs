//! Plain least squares beside another estimate.

use super::{columns::Frame, filtered::Estimate, least_squares::LeastSquares};
use crate::{
    estimation::{
        problem::Place,
        selection::{Filtered, Rule},
        spectrum::Spectrum,
    },
    numerics::Dd,
};

/// Plain least squares beside another estimate, in the caller's terms.
pub struct Beside {
    pub coefficients: Vec<f64>,
    /// √((XᵀX)⁻¹)ⱼⱼ.
    pub leverage: Vec<f64>,
    pub rss: f64,
}

impl Beside {
    /// Of the posted nodes, `place` holding their factor and `frame` the analysis of its columns.
    pub fn new(place: &Place, frame: &Frame) -> Self {
        let Frame { caller, columns, directions, .. } = frame;
        let qty = &place.factor.qty;
        let level = columns.constant.as_ref().map_or(Dd::ZERO, |constant| constant.level(caller, qty));
        let spectrum = Spectrum::new(directions.clone(), qty, level);
        let least_squares = LeastSquares::new(place, columns, &spectrum);
        let filtered: Vec<Filtered> = spectrum.lambda.iter().map(|&lambda| Rule::None.at(0, lambda, 0.0)).collect();
        let Estimate { leverage, .. } = Estimate::new(columns, &spectrum, &filtered, &least_squares);
        Beside { coefficients: least_squares.coefficients, leverage, rss: least_squares.rss }
    }
}
