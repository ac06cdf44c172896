//! Result of a fit with errors of positions.

use crate::spec::PositionKind;

/// Share of the information that is scatter of the positions, shift by the bend within it in
/// standard errors, and relative error of the weights, up to which intervals hold: in the cases of
/// docs/explanation/errors.md that are not warned of in 0.93 or more for the worst coefficient, in
/// those that are down to 0.81.
pub(crate) const HOLDING: [f64; 3] = [0.5, 0.6, 0.3];

/// Nodes whose positions are off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionsReport {
    /// Whether positions were read off wrongly, or missed.
    pub kind: PositionKind,
    /// Rounds of the iteration.
    pub rounds: usize,
    /// The share of positions in the variance of what is left of the heights, on average.
    pub variance_share: f64,
    /// How far from where it was read the likeliest position of a node lies at most; 0 for nominal
    /// positions.
    pub largest_shift: f64,
    /// σ of the residuals over the uncertainty of heights that was told: far from 1 where the
    /// uncertainties do not fit the residuals; none beyond the range of numbers.
    pub sigma_ratio: Option<f64>,
}

impl PositionsReport {
    pub(crate) fn is_finite(&self) -> bool {
        [Some(self.variance_share), Some(self.largest_shift), self.sigma_ratio]
            .into_iter()
            .flatten()
            .all(f64::is_finite)
    }
}
