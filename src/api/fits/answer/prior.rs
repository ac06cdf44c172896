//! What became of what was known before.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{PriorConflict, PriorReport, UsedCorrection},
    spec::Include,
};

answer! {
    /// What became of what was known before. `spectrum.eigenvalues` are those of the nodes alone,
    /// `spectrum.regularized` those of nodes and prior together.
    #[schema(as = PriorResult)]
    pub struct PriorResultBody from PriorReport {
        iterations, fit_ids, corrections, move_std_error, move_ratio, conflict, share, sigma, degrees_of_freedom,
    } {
        /// The earlier iterations, oldest first; absent with `mean`. Where there was none the nodes
        /// stand by themselves.
        iterations?: Vec<usize> =
            iterations.as_ref().map(|all| all.iter().map(|n| *n as usize).collect::<Vec<_>>()),
        /// The fit of each that stood when this one was made. What they measured is fitted by this
        /// fit's own spec.
        fit_ids?: Vec<String> = fit_ids,
        /// The kept corrections whose predicted changes were taken to have come, in their order.
        corrections: Vec<UsedCorrectionBody> = corrections,
        /// Standard deviation of the move of each coefficient from one iteration to the next.
        moves as "move"?: Vec<f64> = move_std_error,
        /// The same in standard errors of the coefficient by these nodes alone, where it was
        /// estimated.
        move_ratio?: f64 = move_ratio,
        /// Whether the nodes contradict what was known; absent before that can be told (of
        /// iterations with an estimated move from the third on; from the second where the move is
        /// beyond 1,000 standard errors, the largest step that is allowed for).
        conflict?: PriorConflictBody = conflict,
        /// Of each coefficient the share of the information that comes from the prior: 1 less its
        /// variance over that of least squares, both for `sigma`.
        share: Vec<f64> = share,
        /// Standard deviation of a height of weight 1, by the residuals of all iterations together,
        /// or as given. The errors of the coefficients rest on it, unless a prior with a `move` or
        /// `mean` that was told is let go.
        sigma?: f64 = sigma,
        /// Degrees of freedom of `sigma`; absent where it was given.
        degrees_of_freedom?: usize = degrees_of_freedom,
    }
}

answer! {
    /// A correction of the machine between two iterations.
    #[schema(as = UsedCorrection)]
    pub struct UsedCorrectionBody from UsedCorrection { iteration, record_id } {
        /// The iteration that it is kept with.
        iteration: usize = *iteration as usize,
        /// The record that it is.
        record_id: String = record_id,
    }
}

answer! {
    /// How far the nodes lie from what the prior predicts.
    #[schema(as = PriorConflict)]
    pub struct PriorConflictBody from PriorConflict { statistic, p, let_go } {
        /// `eᵀS⁻¹e/n`, e the distance from the prediction and S its covariance: about 1 where the
        /// prior holds.
        statistic: f64 = statistic,
        /// Probability of as much or more where the prior holds.
        p: f64 = p,
        /// Whether p is below 1e-4: the prior was let go and least squares of these nodes is
        /// answered (warning `prior_conflict`). Where moves are estimated the intervals are made as
        /// without a conflict: they hold whatever the flank did.
        let_go: bool = let_go,
    }
}
