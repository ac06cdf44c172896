//! Warnings of fits and of shapes.

use std::borrow::Cow;

use super::params::Params;
use flankfit_engine::{
    estimation::result::{Times, Warning},
    words::{Shown, Size},
};

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

/// A warning about the answer.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Warning)]
pub struct WarningBody {
    /// Stable name.
    #[schema(value_type = String)]
    pub code: Cow<'static, str>,
    /// In words, with the numbers that matter.
    pub message: String,
    /// What the message speaks of, by names that tell the units: with `code` enough to say it in
    /// another language. Left out where it speaks of nothing, or where the words are the caller's.
    #[schema(value_type = Option<Object>)]
    pub params: Option<Params>,
    /// The part of the answer that warns, as a JSON Pointer; absent where the warning is of the
    /// whole.
    pub at: Option<String>,
}

impl From<&Warning> for WarningBody {
    fn from(warning: &Warning) -> Self {
        let params = Params::from(warning).some();
        WarningBody { params, ..WarningBody::new(warning.code(), sentence(warning)) }
    }
}

impl WarningBody {
    /// Of a message that speaks of nothing but itself.
    pub fn new(code: &'static str, message: String) -> Self {
        WarningBody { code: code.into(), message, params: None, at: None }
    }
}

/// The engine's words, but where the contract has names for what they speak of.
fn sentence(warning: &Warning) -> String {
    match warning {
        Warning::FilterNotConverged { filter, rounds, lines } => format!(
            "filters/{filter}: the robust filter still moved after {rounds} rounds on {lines} line(s); its last round \
             stands"
        ),
        Warning::NormLimitBelowEstimate { limit, norm } => format!(
            "coefficient_norm_limit {} is below ‖Â‖ = {} of this fit: if the true norm is above the limit too, \
             bias-aware intervals and bands do not hold, and bias_bound and sharp_bound may be exceeded",
            Shown(*limit),
            Shown(*norm)
        ),
        Warning::NormLimitIsEstimate { norm, along, error } => format!(
            "r = ‖Â‖ = {norm:.3e} is an estimate, and along the direction that the nodes determine worst it is not \
             distinguishable from 0 ({along:.2e} with a standard error of {}): bias_bound and sharp_bound hold for \
             that r only; give coefficient_norm_limit",
            Size(*error)
        ),
        Warning::NormLimitUnused => "coefficient_norm_limit shortens intervals of least squares with independent \
                                     errors only: those of this fit do not use it, bias_bound and sharp_bound do"
            .to_owned(),
        Warning::NothingToCorrect => "there is no predicted_mse_corrected here: it is that of spectral schemes, ridge \
                                      or Tikhonov (up to 200 coefficients) whose parameter is given or chosen by \
                                      sums over the spectrum, with an estimate of the noise"
            .to_owned(),
        Warning::PriorWithoutNoise => "the heights lie on the model without any noise, against which the prior would \
                                       be weighed: it was left aside, and least squares of these nodes is answered; \
                                       tell noise_sigma"
            .to_owned(),
        Warning::SigmaMissing(what) => format!(
            "{what} needs σ: there are as many coefficients as nodes, so give noise_sigma; least squares is answered"
        ),
        Warning::WorseThanLeastSquares(factor) => format!(
            "this choice is predicted to have {} the mean squared coefficient error of plain least squares: the \
             surface has a real component along the regularised directions; see regularization.choices",
            Times(*factor)
        ),
        other => other.to_string(),
    }
}
