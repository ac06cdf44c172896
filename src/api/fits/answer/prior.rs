//! Effect of the prior.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{PriorConflict, PriorReport, UsedCorrection},
    spec::Include,
};

answer! {
    /// Effect of the prior. `spectrum.eigenvalues` are those of the nodes alone,
    /// `spectrum.regularized` those of nodes and prior together.
    #[schema(as = PriorResult)]
    pub struct PriorResultBody from PriorReport {
        iterations, fit_ids, corrections, move_std_error, move_ratio, conflict, share, sigma, degrees_of_freedom,
    } {
        /// The earlier iterations, oldest first; absent with `mean`. If the list is empty, the
        /// nodes alone are used.
        iterations?: Vec<usize> =
            iterations.as_ref().map(|all| all.iter().map(|n| *n as usize).collect::<Vec<_>>()),
        /// The fit of each that stood when this one was made. What they measured is fitted by this
        /// fit's own spec.
        fit_ids?: Vec<String> = fit_ids,
        /// Corrections whose predicted changes were added to the prior, in their order.
        corrections: Vec<UsedCorrectionBody> = corrections,
        /// Standard deviation of the move of each coefficient from one iteration to the next.
        moves as "move"?: Vec<f64> = move_std_error,
        /// The same in standard errors of the coefficient by these nodes alone, where it was
        /// estimated.
        move_ratio?: f64 = move_ratio,
        /// Test of the nodes against the prior; absent where it is not available (with iterations
        /// and an estimated move, before the third iteration; available from the second if the move
        /// exceeds 1,000 standard errors, the largest step allowed).
        conflict?: PriorConflictBody = conflict,
        /// For each coefficient the share of the prior in the information: 1 minus the ratio of its
        /// variance to that of least squares, both for `sigma`.
        share: Vec<f64> = share,
        /// Standard deviation of a height of weight 1, from the residuals of all iterations
        /// together, or as given. Errors of the coefficients use it, unless a prior with a given
        /// `move` or `mean` is dropped.
        sigma?: f64 = sigma,
        /// Degrees of freedom of `sigma`; absent where it was given.
        degrees_of_freedom?: usize = degrees_of_freedom,
    }
}

answer! {
    /// A correction of the machine between two iterations.
    #[schema(as = UsedCorrection)]
    pub struct UsedCorrectionBody from UsedCorrection { iteration, record_id, entered } {
        /// The iteration that it is kept with.
        iteration: usize = *iteration as usize,
        /// The record that it is.
        record_id: String = record_id,
        /// The changes that were entered on the machine, in the order of the correction's settings;
        /// left out where the proposed changes were taken.
        entered?: Vec<f64> = entered,
    }
}

answer! {
    /// Distance between the nodes and the prediction of the prior.
    #[schema(as = PriorConflict)]
    pub struct PriorConflictBody from PriorConflict { statistic, p, let_go } {
        /// `eᵀS⁻¹e/n`, where e is the distance from the prediction and S its covariance: about 1 if
        /// the prior is correct.
        statistic: f64 = statistic,
        /// Probability of this value or a larger one if the prior is correct.
        p: f64 = p,
        /// True if p is below 1e-4: the prior is dropped, and least squares of these nodes is
        /// returned (warning `prior_conflict`). Where moves are estimated the intervals are the
        /// same as without a conflict: their coverage holds for any flank.
        let_go: bool = let_go,
    }
}
