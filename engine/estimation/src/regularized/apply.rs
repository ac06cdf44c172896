//! Regularisation of a spec.

use super::{
    admissible::check_admissible,
    constrained,
    context::{Applied, Context},
    prior, representative, shrink, spectral, tikhonov, truncated,
};
use crate::{data::folds, error::FitError, result::Warning, spec::Regularization};
use flankfit_numerics::check::Faults;

/// Applies the regularisation of the spec.
pub(crate) fn apply(context: &Context, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    check_admissible(context.linear.design, context.spec)?;
    if context.spec.folds.is_some() && !context.spec.cross_validates() {
        return Err(Faults::one("folds", folds::UNUSED).into());
    }
    if let Some(known) = &context.spec.prior {
        return prior::apply(context, known, warnings);
    }
    if !context.spec.constraints.is_empty() {
        return constrained::apply(context, warnings);
    }
    match &context.spec.regularization {
        Regularization::TruncatedSvd { rank } => truncated::apply(context, *rank, warnings),
        Regularization::TruncatedSvdBy { criterion } => truncated::apply_by(context, *criterion, warnings),
        Regularization::JamesStein(asked) => shrink::james_stein(context, asked, warnings),
        Regularization::Attraction(asked) => shrink::attraction(context, asked, warnings),
        Regularization::Representative(asked) => representative::apply(context, asked, warnings),
        Regularization::Tikhonov(asked) => tikhonov::apply(context, asked, warnings),
        // a rule on the eigenvalues: `Rule::requested`
        _ => spectral::apply(context, warnings),
    }
}
