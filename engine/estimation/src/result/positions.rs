//! Result of a fit with errors of positions.

use crate::spec::PositionKind;

/// Share of the information that is scatter of the positions, shift by the bend within it in
/// standard errors, and relative error of the weights, up to which intervals hold: in the cases of
/// docs/explanation/errors.md that are not warned of in 0.93 or more for the worst coefficient, in
/// those that are down to 0.81.
pub(crate) const HOLDING: [f64; 3] = [0.5, 0.6, 0.3];

/// Uncertain positions of the nodes. `residuals` are then vertical distances from the surface, to
/// first order, and `sigma` is the standard deviation of a height of weight 1 where the surface is
/// level.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = PositionsResult)
)]
pub struct PositionsReport {
    /// Kind of position errors.
    pub kind: PositionKind,
    /// Rounds of the iteration.
    pub rounds: usize,
    /// Mean share of positions in the variance of the residual heights, 0 to 1.
    pub variance_share: f64,
    /// Largest distance between the measured and the estimated position of a node, in the unit of
    /// the abscissae; 0 for `nominal`.
    pub largest_shift: f64,
    /// `sigma` divided by the given `height`: far from 1 where the uncertainties do not match the
    /// residuals. Intervals use `sigma`.
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
