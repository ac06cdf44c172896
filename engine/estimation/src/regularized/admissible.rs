//! Requirements of a regularisation on the model: a number of coefficients, an axis for each
//! weight, an order that has derivatives.
//!
//! A fit of posted nodes asks once it is at its regularisation; a stream asks when it is opened,
//! since none of its nodes could change it. What depends on the nodes (numerically zero
//! directions, a constant among posted columns) stays with each kind.

use super::{penalty, representative, shrink, truncated};
use crate::{
    constrained,
    design::Design,
    prior,
    selection::{checked_count, selector::no_minimiser},
    spec::{Count, Criterion, FitSpec, Regularization, Scaling, ShrinkageFactor},
    spectrum::scaled_size,
};
use flankfit_numerics::{
    check::Faults,
    words::{counted, entries},
};

/// Refuses a scaling and regularisation of `spec` that `design` rules out.
pub(crate) fn check_admissible(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    prior::check(design, spec)?;
    constrained::check(design, spec)?;
    let size = scaled_size(design, spec.scaling)?;
    match &spec.regularization {
        Regularization::Spectral { count: Count::Auto, .. } => Ok(()),
        Regularization::Spectral { count: Count::Given(count), .. } => checked_count(*count, size).map(drop),
        Regularization::Tikhonov(asked) => penalty::check(asked, design, spec.scaling, size),
        Regularization::TruncatedSvd { rank } => truncated::check_rank(*rank, size, "directions"),
        Regularization::TruncatedSvdBy { criterion } => truncated::check_criterion(*criterion),
        Regularization::JamesStein(asked) => {
            if let Some(target) = &asked.target {
                check_target(target, design)?;
            }
            // standardised columns have the mean aside already
            let mean = asked.factor == ShrinkageFactor::EfronMorris && asked.target.is_none();
            let taken = usize::from(mean && spec.scaling != Scaling::Standardized);
            shrink::check_directions(size.saturating_sub(taken))
        }
        Regularization::Representative(asked) => representative::check(asked, design, spec),
        Regularization::Attraction(asked) => {
            check_target(&asked.target, design)?;
            has_least(spec)
        }
        _ => has_least(spec),
    }
}

/// One number for each coefficient.
fn check_target(target: &[f64], design: &Design) -> Result<(), Faults> {
    let n = design.size();
    if target.len() == n {
        return Ok(());
    }
    Err(Faults::one(
        "regularization.target",
        format_args!(
            "{}; the model has {}, in the order of the result",
            entries(target.len()),
            counted(n, "coefficient", "coefficients")
        ),
    ))
}

/// Refuses the criterion of least condition for regularisations that act on all directions alike.
fn has_least(spec: &FitSpec) -> Result<(), Faults> {
    match spec.regularization.criterion() {
        Some(Criterion::MinCondition) => Err(no_minimiser(Criterion::MinCondition)),
        _ => Ok(()),
    }
}
