//! What must hold before a fit is answered: numbers whose squares are doubles, columns that do not
//! depend on each other.

use nalgebra::DMatrix;

use super::{
    collinearity,
    design::Design,
    error::{Faults, FitError},
    factor::Factor,
    residuals::Heights,
    result::Warning,
    scaled::{ScaledColumns, caller_columns},
    spec::{FitSpec, Regularization, Scaling},
    spectrum::Directions,
};
use crate::numerics::Dd;

/// Whether the columns can add up to 1 at every node. Where the model does not say, the constant is
/// projected on them: `‖P1‖² = Σ (Vᵢᵀ X̃ᵀΩ1)²/λᵢ` against `Σw`.
pub fn constant_in_span(
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

/// Lengths of columns are squared: they must neither overflow nor vanish.
pub fn columns_within_range(design: &Design, caller: &DMatrix<Dd>) -> Result<(), FitError> {
    const RANGE: std::ops::Range<f64> = 1e-145..1e145;
    let rows = caller.nrows();
    for (label, column) in design.labels.iter().zip(caller.as_slice().chunks_exact(rows)) {
        let largest = column.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
        if largest != 0.0 && !RANGE.contains(&largest) {
            return Err(Faults::one(
                "/nodes",
                format!(
                    "the column of {label} (weights included) is about {largest:.0e} long, whose square leaves the \
                     range of \
                     double precision: choose another unit or basis; weights are relative and may be divided by their \
                     largest"
                ),
            )
            .into());
        }
    }
    Ok(())
}

/// Squares of heights are summed: they must neither overflow nor vanish.
pub fn within_range(pointer: &str, heights: &Heights) -> Result<(), FitError> {
    if !(heights.about_zero.is_finite() && heights.weight.is_finite()) {
        return Err(Faults::one(
            pointer,
            "squares of these heights leave the range of double precision: choose a larger unit",
        )
        .into());
    }
    if heights.about_zero < 1e-280 && heights.largest_plain > 0.0 {
        return Err(
            Faults::one(pointer, "squares of these heights vanish in double precision: choose a smaller unit").into()
        );
    }
    Ok(())
}

/// Dependent columns: named in a warning, or refused where Eq. 39 would divide by 0.
pub fn refuse_dependence(
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
    warnings.push(Warning {
        code: "rank_deficient",
        message: format!(
            "the columns of {} depend on each other over these nodes (rank {rank} of {}): \
             the least-squares figures are those of the minimum-norm solution in the scaled columns",
            terms.join(", "),
            design.size()
        ),
    });
    Ok(())
}

/// The refusal of dependent columns by an estimator that needs independent ones.
pub fn dependence(design: &Design, factor: &Factor, weight: f64) -> FitError {
    let caller = caller_columns(factor);
    let analysed = ScaledColumns::new(design, &caller, Scaling::UnitLength, weight)
        .and_then(|columns| Directions::new(factor, &columns, Scaling::UnitLength, None).map(|d| (columns, d)));
    match analysed {
        Ok((columns, spectrum)) => FitError::RankDeficient {
            rank: spectrum.rank,
            columns: design.size(),
            terms: dependent_terms(design, &columns, &spectrum),
        },
        Err(error) => error,
    }
}

/// The terms that take part in the directions that cannot be told from 0.
fn dependent_terms(design: &Design, columns: &ScaledColumns, spectrum: &Directions) -> Vec<String> {
    let mut terms: Vec<usize> = Vec::new();
    for i in (0..spectrum.lambda.len()).filter(|&i| spectrum.lambda[i] <= 0.0) {
        let weights: Vec<f64> = spectrum.v.column(i).iter().copied().collect();
        terms.extend(collinearity::dependent_terms(&weights).into_iter().map(|s| columns.kept[s]));
    }
    terms.sort_unstable();
    terms.dedup();
    terms.into_iter().map(|j| design.labels[j].clone()).collect()
}
