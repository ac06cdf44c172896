//! Tikhonov's estimate with a roughness penalty: `min ‖Y − XA‖² + λ P(A)`.
//!
//! P is a property of the fitted function (of the sequence of coefficients, for a linear model), so
//! the estimate does not depend on the scaling of columns; norms, bounds and the predicted error
//! are in the scaled columns all the same. It is computed in the working basis ([`super::penalty`],
//! [`super::pair`]) and turned into the caller's in double-double.
//!
//! What is different from a filter on eigenvectors, and how the answer says so:
//! * `filter_factors` belong to the directions of the pair (X, P), in ascending order of 1/δ, not
//!   to `spectrum.eigenvalues`;
//! * `spectrum.regularized.eigenvalues` are those of `X̃ᵀX̃ + λP` in ascending order: their
//!   directions are others;
//! * the L-curve is `(log ‖Y − XÂ‖, log √P(Â))`, as is usual where the penalty has a null space;
//! * there is no B, hence no scheme, count, γ, e, Ineqs. 48 and 51, and no perturbation bound of `X
//!   + B`.

use nalgebra::DMatrix;

use super::{
    context::{Applied, Context},
    corrected,
    double_pair::DoublePair,
    linear_map::LinearMap,
    normal_system::NormalSystem,
    oblique::{Oblique, Spread},
    oblique_choice::{self, Lambda, SelectedPenalty},
    pair::{Pair, PairFault, product},
    penalty::{self, Penalty},
    removal::Removal,
    report::report,
};
use crate::{
    error::{FitError, Unconverged},
    estimate::{Estimate, directions},
    factor::multiply_upper_vector,
    problem::Residuals,
    result::{Choice, RegularizationKind, RegularizationReport, Warning},
    selection::{Filtered, selector::Selection},
    spec::Tikhonov,
};
use flankfit_numerics::{Dd, Real, check::Faults, triangular};

const NOT_CONVERGED: FitError = FitError::NotConverged(Unconverged::PenaltyPair);

/// Applies the requested penalty: in double precision, or if that leaves too few digits in twice of
/// it.
pub(super) fn apply(context: &Context, asked: &Tikhonov, warnings: &mut Vec<Warning>) -> Result<Applied, FitError> {
    let penalty = penalty::factor(context, asked)?;
    if let Some(pair) = DoublePair::new(context, &penalty) {
        let mut own = Vec::new();
        if let Some(applied) = in_double(context, asked, &penalty, pair, &mut own)? {
            warnings.append(&mut own);
            return Ok(applied);
        }
    }
    let Context { linear, columns, spectrum, least_squares, .. } = *context;
    let factor = linear.factor;
    let n = factor.size();
    let rank = spectrum.rank + context.unpenalised();
    let mut pair = Pair::new(&factor.r, &penalty.stacked(&linear.design.terms), rank).map_err(|fault| match fault {
        PairFault::NotConverged => NOT_CONVERGED,
        PairFault::Undetermined => Faults::one(
            "regularization.order",
            "nodes and penalty together do not determine every coefficient: use a lower order or more nodes",
        )
        .into(),
    })?;
    if let Some(constant) = &columns.constant {
        let mut working = vec![Dd::ZERO; n];
        working[constant.index] = Dd::ONE;
        multiply_upper_vector(&factor.change, &mut working);
        if !pair.turn_last_to(&working) {
            return Err(Faults::one("scaling", "`standardized` needs a constant that the penalty leaves free").into());
        }
    }
    // coefficients along the directions; of those that the nodes do not see, what the minimum norm
    // gives them
    let a: Vec<Dd> = (0..n)
        .map(|i| match i < pair.silent {
            true => pair.inverse.row(i).iter().zip(&least_squares.working).fold(Dd::ZERO, |sum, (&x, &c)| sum + x * c),
            false => pair.u.column(i).iter().zip(&factor.qty).fold(Dd::ZERO, |sum, (&u, &b)| sum + u * b),
        })
        .collect();
    let oblique = scaled(context, &pair, &a);
    let images = pair.u.columns(0, oblique.delta.len()).map(|x| x.to_f64());
    let SelectedPenalty { selection, figures } = selected(context, asked, &oblique, &images, warnings)?;
    let chosen = selection.answer.map(|lambda| lambda.value);
    let working = match chosen {
        Some(lambda) => summed(&pair, &oblique, &a, lambda),
        None => least_squares.working.clone(),
    };
    let residuals = linear.of_working(&working, context.spec.include.residuals);
    let eigenvalues = match chosen {
        Some(lambda) if !oblique.within_range(lambda) => {
            let message = "λ times this penalty exceeds the range of double precision";
            return Err(FitError::ExceedsDouble(Faults::one("regularization.parameter", message)));
        }
        Some(lambda) => oblique.eigenvalues(lambda).ok_or(NOT_CONVERGED)?,
        None => spectrum.lambda.clone(),
    };
    let found = Solved { oblique, images, selection, figures, working, residuals, eigenvalues };
    Ok(found.concluded(context, warnings))
}

/// The same in double precision; `None` where that turns out to leave too few digits.
fn in_double(
    context: &Context,
    asked: &Tikhonov,
    penalty: &Penalty,
    pair: DoublePair,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Applied>, FitError> {
    let linear = context.linear;
    let SelectedPenalty { selection, figures } = selected(context, asked, &pair.oblique, &pair.images, warnings)?;
    let chosen = selection.answer.map(|lambda| lambda.value);
    let Some(lambda) = chosen.filter(|&lambda| pair.trusts(lambda) && pair.oblique.within_range(lambda)) else {
        return Ok(None);
    };
    let system = NormalSystem::new(context, penalty);
    let Some(working) = system.solve(lambda, |left| pair.inverse(lambda, left)) else { return Ok(None) };
    let Some(eigenvalues) = pair.oblique.eigenvalues(lambda) else { return Ok(None) };
    let mut image = working.clone();
    multiply_upper_vector(&linear.factor.r, &mut image);
    let residuals = linear.of_image(&image, context.spec.include.residuals);
    let DoublePair { oblique, images, .. } = pair;
    let found = Solved { oblique, images, selection, figures, working, residuals, eigenvalues };
    Ok(Some(found.concluded(context, warnings)))
}

fn selected(
    context: &Context,
    asked: &Tikhonov,
    oblique: &Oblique,
    images: &DMatrix<f64>,
    warnings: &mut Vec<Warning>,
) -> Result<SelectedPenalty, FitError> {
    context.warn_of_missing("tikhonov", true, warnings);
    oblique_choice::decide(context, oblique, images, asked.parameter, warnings)
}

/// A decomposition with what was chosen and found in it.
struct Solved {
    oblique: Oblique,
    /// Directions in Q's coordinates.
    images: DMatrix<f64>,
    selection: Selection<Lambda>,
    figures: Choice,
    /// The estimate in the working basis.
    working: Vec<Dd>,
    residuals: Residuals,
    /// Eigenvalues of `X̃ᵀX̃ + λP`.
    eigenvalues: Vec<f64>,
}

impl Solved {
    fn concluded(self, context: &Context, warnings: &mut Vec<Warning>) -> Applied {
        let Solved { oblique, images, selection, figures, working, residuals, eigenvalues } = self;
        let Context { spec, spectrum, least_squares, .. } = *context;
        let chosen = selection.answer.map(|lambda| lambda.value);
        let removed = |i: usize| chosen.map_or(0.0, |lambda| oblique.removed(i, lambda));
        let size = oblique.delta.len();
        let estimate = estimated(context, &oblique, &working, chosen);
        let removal = chosen.map(|lambda| oblique.removal(lambda));
        let r = context.norm_limit(context.norm_of(&estimate.coefficients), warnings);
        let (sharp, bounds) = bounds(context, removal.as_ref(), r);
        let map = match removal {
            Some(removal) => LinearMap::Oblique { images, removed: (0..size).map(removed).collect(), removal, working },
            None => LinearMap::Eigenvectors { removed: vec![0.0; spectrum.lambda.len()] },
        };
        context.judge(&selection.choices, &figures, warnings);
        let corrected = chosen.filter(|_| spec.include.predicted_mse).and_then(|lambda| {
            let how = (selection.criterion, selection.fixed);
            let again =
                |oblique: &Oblique, variance, rss, asked| oblique_choice::again(context, oblique, variance, rss, asked);
            corrected::of_penalty(context, &oblique, lambda, how, again)
        });
        Applied {
            rss: least_squares.rss + chosen.map_or(0.0, |lambda| oblique.risen(lambda)),
            residuals,
            spectrum: super::report::regularized_spectrum(eigenvalues),
            regularization: RegularizationReport {
                lambda_star: chosen,
                criterion: selection.chosen_by(),
                filter_factors: (0..size).map(|i| 1.0 - removed(i)).collect(),
                predicted_mse_corrected: corrected,
                choices: selection.choices,
                ..report(RegularizationKind::Tikhonov)
            },
            bias: context.bias(figures.bias_norm, sharp, r),
            bounds,
            curve: selection.curve,
            trace: None,
            matrix_b: None,
            matrix_b_factors: None,
            after: None,
            map,
            prior: None,
            constraints: None,
            representative: None,
            estimate,
        }
    }
}

/// The estimate in the working basis, summed up along the directions.
fn summed(pair: &Pair, oblique: &Oblique, a: &[Dd], lambda: f64) -> Vec<Dd> {
    let n = a.len();
    let mut working = vec![Dd::ZERO; n];
    for i in 0..n {
        let share = if i < oblique.delta.len() { a[i].mul_f64(oblique.factor(i, lambda)) } else { a[i] };
        working.iter_mut().zip(pair.z.column(i).iter()).for_each(|(to, &z)| *to += share * z);
    }
    working
}

/// The estimate in the caller's terms. Without a λ it is least squares, of minimum norm where that
/// is not the only one.
fn estimated(context: &Context, oblique: &Oblique, working: &[Dd], lambda: Option<f64>) -> Estimate {
    let Context { linear, columns, spectrum, least_squares, .. } = *context;
    let untouched: Vec<Filtered> =
        spectrum.lambda.iter().map(|&eigenvalue| Filtered { factor: 1.0, removed: 0.0, eigenvalue }).collect();
    let mut estimate = Estimate::new(columns, spectrum, &untouched, least_squares);
    let Some(lambda) = lambda else { return estimate };
    let mut caller = working.to_vec();
    triangular::solve_upper(&linear.factor.change, &mut caller);
    estimate.coefficients = caller.iter().map(|x| x.to_f64()).collect();
    for (j, spread) in spreads(context, oblique, lambda).into_iter().enumerate() {
        estimate.spread[j] = spread;
    }
    estimate
}

/// √(variance/σ²) of each coefficient of the caller.
fn spreads(context: &Context, oblique: &Oblique, lambda: f64) -> Vec<f64> {
    let columns = context.columns;
    let z = match oblique.spread(lambda) {
        Spread::Directions(z) => z,
        Spread::Squares(squares) => {
            let scale = columns.scale.iter().map(|s| s.to_f64());
            return squares.into_iter().zip(scale).map(|(square, scale)| square.sqrt() / scale).collect();
        }
    };
    let n = context.linear.design.size();
    let along = directions(columns, z, n);
    let variance = |j: usize| {
        let own = columns.constant.as_ref().filter(|c| c.index == j).map_or(0.0, |c| 1.0 / c.length_squared);
        let each = (oblique.silent..along.ncols()).map(|i| (oblique.factor(i, lambda) * along[(j, i)]).powi(2));
        own + each.sum::<f64>()
    };
    (0..n).map(|j| variance(j).sqrt()).collect()
}

/// The directions in the scaled columns, without the unpenalised constant.
fn scaled(context: &Context, pair: &Pair, a: &[Dd]) -> Oblique {
    let Context { linear, columns, .. } = *context;
    let change = &linear.factor.change;
    let n = linear.factor.size();
    let size = columns.kept.len();
    // caller = T⁻¹ working, scaled = scale · caller
    let mut caller = pair.z.clone();
    for column in caller.as_mut_slice().chunks_exact_mut(n) {
        triangular::solve_upper(change, column);
    }
    let z = DMatrix::from_fn(size, size, |s, i| caller[(columns.kept[s], i)] * columns.scale[s]);
    let back = product(&pair.inverse, change);
    let inverse = DMatrix::from_fn(size, size, |i, s| back[(i, columns.kept[s])] / columns.scale[s]);
    let a = a[..size].iter().map(|a| a.to_f64()).collect();
    Oblique::new(z, inverse, pair.delta[..size].to_vec(), pair.silent, a, context.variance)
}

/// Sharp bounds on the bias for `‖A‖ ≤ r`: of the vector, and of each caller's coefficient.
fn bounds(context: &Context, removal: Option<&Removal>, r: f64) -> (f64, Vec<f64>) {
    let n = context.linear.design.size();
    let each = match removal {
        None => return (0.0, vec![0.0; n]),
        Some(Removal::Whole(removal)) => {
            directions(context.columns, removal, n).row_iter().map(|row| r * row.norm()).collect()
        }
        Some(Removal::Blocks(removal)) => {
            let scale = context.columns.scale.iter().map(|s| s.to_f64());
            removal.row_lengths().into_iter().zip(scale).map(|(length, scale)| r * length / scale).collect()
        }
    };
    (r * removal.map_or(0.0, Removal::norm), each)
}
