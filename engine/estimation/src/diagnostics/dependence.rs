//! Columns that depend on each other: named in a warning, or refused.

use super::collinearity;
use crate::{
    design::Design,
    error::FitError,
    factor::Factor,
    result::Warning,
    spec::{FitSpec, Regularization, Scaling},
    spectrum::{Directions, ScaledColumns, caller_columns},
};

/// Decides if the columns can add up to 1 at every node. If the model leaves that open, the
/// constant is projected on them: `‖P1‖² = Σ (Vᵢᵀ X̃ᵀΩ1)²/λᵢ` against `Σw`.
pub(crate) fn constant_in_span(
    design: &Design,
    factor: &Factor,
    columns: &ScaledColumns,
    spectrum: &Directions,
    weight: f64,
) -> bool {
    if let Some(known) = design.constant_in_span {
        return known;
    }
    let Some(ones) = &factor.ones else { return false };
    // posted columns: T is diagonal
    let sums: Vec<f64> = columns
        .kept
        .iter()
        .zip(&columns.scale)
        .map(|(&j, s)| (factor.change[(j, j)] * ones[j] / *s).to_f64())
        .collect();
    let seen: f64 = (0..spectrum.lambda.len())
        .filter(|&i| spectrum.lambda[i] > 0.0)
        .map(|i| spectrum.v.column(i).iter().zip(&sums).map(|(v, s)| v * s).sum::<f64>().powi(2) / spectrum.lambda[i])
        .sum();
    (weight - seen).abs() <= 1e-9 * weight
}

/// Dependent columns: named in a warning, or refused where Eq. 39 would divide by 0.
pub(crate) fn refuse_dependence(
    design: &Design,
    columns: &ScaledColumns,
    spectrum: &Directions,
    spec: &FitSpec,
    warnings: &mut Vec<Warning>,
) -> Result<(), FitError> {
    let terms = dependent_terms(design, columns, spectrum);
    let rank = spectrum.rank + usize::from(columns.constant.is_some());
    if matches!(spec.regularization, Regularization::Spectral { .. }) {
        return Err(FitError::RankDeficient { rank, columns: design.size(), terms });
    }
    warnings.push(Warning::RankDeficient { terms, rank, columns: design.size() });
    Ok(())
}

/// The refusal of dependent columns by an estimator that needs independent ones.
pub(crate) fn dependence(design: &Design, factor: &Factor, weight: f64) -> FitError {
    let caller = caller_columns(factor);
    let analysed = ScaledColumns::new(design, &caller, Scaling::UnitLength, weight)
        .and_then(|columns| Directions::new(factor, &columns, Scaling::UnitLength, None).map(|d| (columns, d)));
    match analysed {
        // the factor may have found dependent what columns of unit length just separate
        Ok((columns, spectrum)) => FitError::RankDeficient {
            rank: spectrum.rank.min(design.size().saturating_sub(1)),
            columns: design.size(),
            terms: dependent_terms(design, &columns, &spectrum),
        },
        Err(error) => error,
    }
}

/// The terms that take part in the numerically zero directions; where there is none, in that of the
/// smallest eigenvalue.
fn dependent_terms(design: &Design, columns: &ScaledColumns, spectrum: &Directions) -> Vec<String> {
    let mut terms: Vec<usize> = Vec::new();
    let zero: Vec<usize> = (0..spectrum.lambda.len()).filter(|&i| spectrum.lambda[i] <= 0.0).collect();
    let smallest = (0..spectrum.lambda.len()).min_by(|&i, &j| spectrum.lambda[i].total_cmp(&spectrum.lambda[j]));
    let directions = if zero.is_empty() { smallest.into_iter().collect() } else { zero };
    for i in directions {
        let weights: Vec<f64> = spectrum.v.column(i).iter().copied().collect();
        terms.extend(collinearity::dependent_terms(&weights).into_iter().map(|s| columns.kept[s]));
    }
    terms.sort_unstable();
    terms.dedup();
    terms.into_iter().map(|j| design.labels[j].clone()).collect()
}
