//! The filtered estimate (Eq. 29), with its spread and residuals.

use nalgebra::DMatrix;

use super::least_squares::LeastSquares;
use crate::{
    factor::multiply_upper_vector,
    problem::{LinearProblem, Residuals},
    selection::Filtered,
    spec::FitSpec,
    spectrum::{ScaledColumns, Spectrum},
};
use flankfit_numerics::Dd;

/// The regularised estimate and the spread of both.
pub(crate) struct Estimate {
    pub coefficients: Vec<f64>,
    /// √(variance/σ²) of each regularised coefficient.
    pub spread: Vec<f64>,
    /// The same for least squares.
    pub leverage: Vec<f64>,
    pub sensitivity: Vec<f64>,
    /// `P V`: row j holds what each direction contributes to the caller's coefficient j.
    pub directions: DMatrix<f64>,
}

/// `P V` for directions V of the scaled columns: what each contributes to the n coefficients of the
/// caller.
pub(crate) fn directions(columns: &ScaledColumns, v: &DMatrix<f64>, n: usize) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(n, v.ncols());
    let scale: Vec<f64> = columns.scale.iter().map(|s| s.to_f64()).collect();
    let means: Option<(usize, Vec<f64>)> =
        columns.constant.as_ref().map(|c| (c.index, c.means.iter().map(|mean| mean.to_f64()).collect()));
    for (from, mut to) in v.column_iter().zip(out.column_iter_mut()) {
        let mut constant = 0.0;
        for (s, &j) in columns.kept.iter().enumerate() {
            to[j] = from[s] / scale[s];
            if let Some((_, means)) = &means {
                constant -= means[s] * to[j];
            }
        }
        if let Some((index, _)) = &means {
            to[*index] = constant;
        }
    }
    out
}

impl Estimate {
    pub(crate) fn new(
        columns: &ScaledColumns,
        spectrum: &Spectrum,
        filtered: &[Filtered],
        least_squares: &LeastSquares,
    ) -> Self {
        let n = least_squares.coefficients.len();
        let directions = directions(columns, &spectrum.v, n);
        let constant = columns.constant.as_ref();
        let (mut coefficients, mut spread) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let (mut leverage, mut sensitivity) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for j in 0..n {
            let level = constant.filter(|c| c.index == j);
            let own = level.map_or(0.0, |c| 1.0 / c.length_squared);
            let (mut kept, mut kept_size, mut removed, mut removed_size) = (0.0, 0.0f64, 0.0, 0.0f64);
            let (mut plain, mut shrunk, mut twice) = (own, own, 0.0);
            for (i, f) in filtered.iter().enumerate() {
                let along = directions[(j, i)];
                let term = spectrum.a[i] * along;
                kept += f.factor * term;
                kept_size += (f.factor * term).abs();
                removed += f.removed * term;
                removed_size += (f.removed * term).abs();
                let lambda = spectrum.lambda[i];
                if lambda > 0.0 {
                    let share = along * along / lambda;
                    plain += share;
                    shrunk += f.factor * f.factor * share;
                    twice += share / lambda;
                }
            }
            let level = level.map_or(0.0, |_| spectrum.level.to_f64());
            // two equal sums; take the one in which less cancels
            let whole = least_squares.coefficients[j];
            let from_kept = kept_size + level.abs() < removed_size + whole.abs();
            coefficients.push(if from_kept && removed_size > 0.0 { level + kept } else { whole - removed });
            leverage.push(plain.sqrt());
            spread.push(shrunk.sqrt());
            sensitivity.push(twice.sqrt());
        }
        Estimate { coefficients, spread, leverage, sensitivity, directions }
    }
}

/// Residuals of the regularised estimate; those of least squares where nothing was regularised.
pub(crate) fn residuals(
    linear: &LinearProblem,
    spectrum: &Spectrum,
    filtered: &[Filtered],
    estimate: &Estimate,
    least_squares: &LeastSquares,
    spec: &FitSpec,
) -> Residuals {
    let keep = spec.include.residuals;
    let untouched = filtered.iter().all(|f| f.removed == 0.0);
    if untouched {
        // the sums are those of least squares, also if single residuals are not requested
        let values = if keep { linear.of_working(&least_squares.working, true).values } else { None };
        return Residuals { rss: least_squares.rss, max_abs: least_squares.max_abs, values };
    }
    if linear.factor.working.is_none() {
        let mut working: Vec<Dd> = estimate.coefficients.iter().map(|&x| Dd::from(x)).collect();
        multiply_upper_vector(&linear.factor.change, &mut working);
        return linear.of_working(&working, keep);
    }
    let mut b = linear.factor.qty.clone();
    for (i, f) in filtered.iter().enumerate().filter(|(_, f)| f.removed != 0.0) {
        let moved = f.removed * spectrum.a[i];
        for (b, image) in b.iter_mut().zip(spectrum.image.column(i).iter()) {
            *b -= Dd::product(moved, *image);
        }
    }
    linear.of_image(&b, keep)
}
