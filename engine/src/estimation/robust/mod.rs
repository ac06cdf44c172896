//! Estimators that gross errors cannot pull away, and how they join the way of a fit.
//!
//! Every estimator ends as a least-squares problem whose solution is the estimate, so that
//! spectrum, λ*, bias bounds and collinearity go on from there as for any fit:
//! * M-estimators and least trimmed squares end in weights ω: the problem is that of `√(wω) X`, and
//!   all diagnostics refer to this weighted matrix;
//! * least absolute deviations, quantiles, Lp and rank dispersion end in coefficients Â: the matrix
//!   stays `√w X`, the heights become `√w X Â`, and the filter acts on `aᵢ = Vᵢᵀ Â` (Eq. 29).
//!
//! Standard errors are asymptotic: covariance `τ² (XᵀX)⁻¹` of the unregularised estimate, each
//! estimator saying its τ, and carried through the filter for the regularised one. The same τ is
//! the σ of the criteria for λ* (times the mean of ω where the matrix is weighted), unless the
//! caller gives one.
//!
//! Everything is a fixed sequence of operations: random subsets come from a seed, and every
//! iteration has an end.

mod approach;
mod estimate;
mod exact;
mod least_absolute;
mod lp;
mod lts;
mod m_estimator;
mod normal;
mod outcome;
mod quantile;
mod random;
mod rank;
pub(super) mod reason;
mod rows;
mod scale;
mod spread;
mod vertex;

pub(crate) use estimate::{RobustEstimate, RobustSolution, estimate};
pub(crate) use outcome::Measured;
pub(crate) use spread::Spread;
