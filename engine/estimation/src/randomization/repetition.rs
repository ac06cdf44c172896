//! One repetition: heights, every level of randomisation, and what the regularised estimates need
//! of the heights.

use nalgebra::{DMatrix, DVector};

use super::{
    normal::Normals,
    outcome::{LevelOutcome, Outcome},
    references::Base,
    setup::Study,
};
use crate::error::{FitError, Unconverged};
use flankfit_numerics::{Dd, cancel::Asking, jacobi, lanes::Laned, qr, svd_dd, triangular};

/// Relative error that double precision may leave in a singular value or in D before twice the
/// precision takes over.
const TOLERANCE: f64 = 1e-9;
const NOT_CONVERGED: FitError = FitError::NotConverged(Unconverged::SingularValues);

pub(super) fn run(study: &Study, base: &Base, stream: u64) -> Result<Outcome, FitError> {
    let mut normals = Normals::new(study.seed, stream);
    let noise: Vec<f64> = normals.take(study.rows).into_iter().map(|x| study.noise_sigma * x).collect();
    let change = normals.take(study.rows * study.columns);
    let levels =
        study.levels.iter().asking(usize::MAX).map(|&k| level(study, &noise, &change, k)).collect::<Result<_, _>>()?;
    let along = base.project(&noise);
    let rss = noise.iter().map(|e| e * e).sum::<f64>() - along.iter().map(|p| p * p).sum::<f64>();
    Ok(Outcome { levels, rss: rss.max(0.0), along })
}

fn level(study: &Study, noise: &[f64], change: &[f64], k: f64) -> Result<LevelOutcome, FitError> {
    let n = study.columns;
    let randomised: Vec<f64> =
        study.x.iter().zip(change).enumerate().map(|(at, (x, g))| x + k * study.deviation[at % n] * g).collect();
    let (solved, error) = solve::<f64>(study, &randomised, noise)?;
    if error <= TOLERANCE {
        return Ok(solved);
    }
    solve::<Dd>(study, &randomised, noise).map(|(solved, _)| solved)
}

/// Numbers in which a level is computed.
trait Arithmetic: Laned {
    fn difference(a: f64, b: f64) -> Self;
    fn singular_values(r: &DMatrix<Self>) -> Option<Vec<Self>>;
}

impl Arithmetic for f64 {
    fn difference(a: f64, b: f64) -> f64 {
        a - b
    }

    fn singular_values(r: &DMatrix<f64>) -> Option<Vec<f64>> {
        jacobi::svd(r.clone()).map(|svd| svd.sigma)
    }
}

impl Arithmetic for Dd {
    fn difference(a: f64, b: f64) -> Dd {
        Dd::diff(a, b)
    }

    fn singular_values(r: &DMatrix<Dd>) -> Option<Vec<Dd>> {
        svd_dd(r).map(|svd| svd.sigma)
    }
}

/// Results of X̃, and a bound on the relative error that the arithmetic leaves.
fn solve<T: Arithmetic>(study: &Study, randomised: &[f64], noise: &[f64]) -> Result<(LevelOutcome, f64), FitError> {
    let (m, n) = (study.rows, study.columns);
    // (X̃ − X) A − e
    let b = DVector::from_fn(m, |i, _| {
        (0..n).fold(T::of(-noise[i]), |sum, j| {
            T::difference(randomised[i * n + j], study.x[i * n + j]).fma(T::of(study.coefficients[j]), sum)
        })
    });
    let factor = qr::qr_with_rhs(DMatrix::from_fn(m, n, |i, j| T::of(randomised[i * n + j])), b);
    let lengths: Vec<f64> =
        factor.r.column_iter().map(|c| c.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt()).collect();
    let regular = (0..n).all(|j| factor.r[(j, j)].to_f64().abs() > T::EPSILON * lengths[j]);
    let nothing = f64::INFINITY;
    let lost = LevelOutcome {
        condition: nothing,
        log10_determinant: nothing,
        error: nothing,
        rss: nothing,
        fitted_rss: factor.rss.to_f64(),
    };
    if !regular {
        return Ok((lost, f64::INFINITY));
    }
    // how far from dependence the columns of unit length are
    let inverse = triangular::inverse_upper(&factor.r);
    let condition = (n as f64).sqrt()
        * (0..n)
            .flat_map(|i| (i..n).map(move |j| (i, j)))
            .map(|(i, j)| (inverse[(i, j)].to_f64() * lengths[i]).powi(2))
            .sum::<f64>()
            .sqrt();
    let error = T::EPSILON * (m as f64).sqrt() * n as f64 * condition;
    if !(error < 0.5) {
        return Ok((lost, f64::INFINITY));
    }
    let mut d: Vec<T> = factor.qty.iter().copied().collect();
    triangular::solve_upper(&factor.r, &mut d);
    let sigma = T::singular_values(&factor.r).ok_or(NOT_CONVERGED)?;
    let square = |x: T| x.to_f64() * x.to_f64();
    // y − X Â_R = e + X D
    let rss = (0..m)
        .map(|i| square((0..n).fold(T::of(noise[i]), |sum, j| T::of(study.x[i * n + j]).fma(d[j], sum))))
        .sum::<f64>();
    let drawn = LevelOutcome {
        condition: square(sigma[n - 1] / sigma[0]),
        log10_determinant: sigma.iter().map(|s| 2.0 * libm::log10(s.to_f64())).sum(),
        error: d.iter().map(|x| square(*x)).sum(),
        rss,
        fitted_rss: factor.rss.to_f64(),
    };
    Ok((drawn, error))
}
