//! Estimators that gross errors cannot pull away, and how they join the way of a fit.
//!
//! Every estimator ends as a least-squares problem whose solution is the estimate, so that
//! spectrum, λ*, bias bounds and collinearity go on from there as for any fit:
//! * M-estimators, least trimmed squares and the trimmed L-estimator end in weights ω: the problem
//!   is that of `√(wω) X`, and all diagnostics refer to this weighted matrix;
//! * the others (quantiles and what is combined of them, Lp, rank dispersion, maximum likelihood)
//!   end in coefficients Â: the matrix stays `√w X`, the heights become `√w X Â`, and the filter
//!   acts on `aᵢ = Vᵢᵀ Â` (Eq. 29).
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
mod exchange;
mod few_nodes;
mod l_estimator;
mod least_absolute;
mod likelihood;
mod lp;
mod lts;
mod m_estimator;
mod minimax;
mod normal;
mod normal_scores;
mod outcome;
mod quantile;
mod random;
mod rank;
mod rows;
mod scale;
mod spacing;
mod spread;
mod vertex;

pub(crate) use estimate::{RobustEstimate, RobustSolution, estimate};
pub(crate) use outcome::Measured;
pub(crate) use spread::Spread;
