//! Every figure of a penalised fit by its definition, in the oracle's numbers: normal equations,
//! and directions of matrix and penalty from two eigen analyses.

use crate::oracle::big::Big;
use crate::oracle::matrix::{Rows, column, dot, doubles, eigen, gram, inverse, times, vector};
use crate::problems::{assert_all_close, assert_close, values};
use flankfit_engine::estimation::FitResult;
use flankfit_engine::estimation::spec::{ChosenBy, Criterion};

/// `∫ (uᵃ)⁽ᵏ⁾ (uᵇ)⁽ᵏ⁾ du` by the power rule.
fn powers(a: usize, b: usize, order: usize, [low, high]: [f64; 2]) -> Big {
    if a < order || b < order {
        return Big::zero();
    }
    let falling = |n: usize| (n + 1 - order..=n).fold(Big::one(), |product, k| &product * &Big::from(k));
    let exponent = a + b - 2 * order + 1;
    let power = |x: f64| (0..exponent).fold(Big::one(), |product, _| &product * &Big::from(x));
    let integral = &(&power(high) - &power(low)) / &Big::from(exponent);
    &(&falling(a) * &falling(b)) * &integral
}

/// P of a surface in raw monomials.
pub fn roughness(terms: &[[usize; 2]], order: usize, weights: [f64; 2], u: [f64; 2], v: [f64; 2]) -> Rows {
    let entry = |p: &[usize; 2], q: &[usize; 2]| {
        let along_u = &powers(p[0], q[0], order, u) * &powers(p[1], q[1], 0, v);
        let along_v = &powers(p[0], q[0], 0, u) * &powers(p[1], q[1], order, v);
        &(&along_u * &Big::from(weights[0])) + &(&along_v * &Big::from(weights[1]))
    };
    terms.iter().map(|p| terms.iter().map(|q| entry(p, q)).collect()).collect()
}

pub fn plus(a: &Rows, b: &Rows, factor: f64) -> Rows {
    let factor = Big::from(factor);
    a.iter().zip(b).map(|(p, q)| p.iter().zip(q).map(|(x, y)| x + &(y * &factor)).collect()).collect()
}

fn product(a: &Rows, b: &Rows) -> Rows {
    let columns: Vec<Vec<Big>> = (0..b[0].len()).map(|j| column(b, j)).collect();
    a.iter().map(|row| columns.iter().map(|c| dot(row, c)).collect()).collect()
}

fn scaled(matrix: &Rows, scales: &[Big]) -> Rows {
    matrix.iter().zip(scales).map(|(row, s)| row.iter().zip(scales).map(|(x, t)| &(x / s) / t).collect()).collect()
}

/// Checks all results at the chosen λ from normal equations in the oracle's numbers.
pub fn check(result: &FitResult, x: &Rows, y: &[f64], penalty: &Rows, unit: bool, digits: f64) {
    let lambda = result.regularization.lambda_star.expect("a λ");
    let (n, m) = (x[0].len(), y.len());
    let y = vector(y);
    let fisher = gram(x);
    let moments: Vec<Big> = (0..n).map(|j| dot(&column(x, j), &y)).collect();
    let covariance = inverse(&plus(&fisher, penalty, lambda));
    let exact = times(&covariance, &moments);
    let scales: Vec<Big> = (0..n).map(|j| if unit { fisher[j][j].sqrt() } else { Big::one() }).collect();
    let size = exact.iter().zip(&scales).map(|(a, s)| (a * s).to_f64().powi(2)).sum::<f64>().sqrt();
    for ((value, exact), s) in values(result).iter().zip(&exact).zip(&scales) {
        let (value, exact) = ((&Big::from(*value) * s).to_f64(), (exact * s).to_f64());
        assert_close("coefficient", value, exact, digits, digits * size);
    }
    // residuals and the trace of the hat matrix
    let misfit: Vec<Big> = times(x, &exact).iter().zip(&y).map(|(f, y)| y - f).collect();
    let heights = dot(&y, &y).to_f64();
    assert_close("rss", result.residuals.rss, dot(&misfit, &misfit).to_f64(), 1e-7, 1e-13 * heights);
    let hat = product(&covariance, &fisher);
    let trace: f64 = (0..n).map(|i| hat[i][i].to_f64()).sum();
    let factors = &result.regularization.filter_factors;
    assert_close("trace", factors.iter().sum(), trace, 1e-8, 0.0);
    assert!(factors.is_sorted() && factors.iter().all(|f| (0.0..=1.0).contains(f)), "{factors:?}");
    // standard errors: (XᵀX + λP)⁻¹ XᵀX (XᵀX + λP)⁻¹
    let spread = product(&hat, &covariance);
    let least = times(&inverse(&fisher), &moments);
    let rest: Vec<Big> = times(x, &least).iter().zip(&y).map(|(f, y)| y - f).collect();
    let rss = dot(&rest, &rest).to_f64();
    let variance = rss / (m - n) as f64;
    for (j, c) in result.coefficients.iter().enumerate() {
        assert_close(
            "standard error",
            c.error_given_lambda().unwrap(),
            (variance * spread[j][j].to_f64()).sqrt(),
            1e-6,
            0.0,
        );
    }
    // the penalised matrix and the bias in the scaled columns
    let (eigenvalues, _) = eigen(&scaled(&plus(&fisher, penalty, lambda), &scales));
    assert_all_close("eigenvalues", &result.spectrum.regularized.eigenvalues, &doubles(&eigenvalues), 1e-8);
    let bias: Vec<f64> = least.iter().zip(&exact).zip(&scales).map(|((a, b), s)| (&(a - b) * s).to_f64()).collect();
    let norm = bias.iter().map(|x| x * x).sum::<f64>().sqrt();
    let whole = least.iter().zip(&scales).map(|(a, s)| (a * s).to_f64().powi(2)).sum::<f64>().sqrt();
    assert_close("bias", result.bias.norm, norm, 1e-6, 1e-9 * whole);
    // M = I − hat, in the scaled columns; ‖M‖² is the largest eigenvalue of MᵀM
    let removal: Rows = (0..n)
        .map(|i| {
            (0..n)
                .map(|j| {
                    let one = if i == j { Big::one() } else { Big::zero() };
                    &(&(&one - &hat[i][j]) * &scales[i]) / &scales[j]
                })
                .collect()
        })
        .collect();
    let r = result.bias.coefficient_norm_limit;
    assert_close("r", r, whole, 1e-6, 0.0);
    let (squares, _) = eigen(&gram(&removal));
    assert_close("sharp bound", result.bias.sharp_bound, r * squares[n - 1].sqrt().to_f64(), 1e-6, 0.0);
    assert!(result.bias.norm <= result.bias.sharp_bound * (1.0 + 1e-7));
    for (j, c) in result.coefficients.iter().enumerate() {
        let bound = r * (&dot(&removal[j], &removal[j]).sqrt() / &scales[j]).to_f64();
        assert_close("bias bound", c.bias_bound, bound, 1e-6, 0.0);
    }
    let best = |criterion: Criterion| {
        result.regularization.choices.iter().find(|c| c.criterion == ChosenBy::Criterion(criterion))
    };
    // variance part of the predicted error cannot be undercut, and no listed choice beats the
    // criterion's own
    let own = best(Criterion::MinMse).expect("min_mse").predicted_mse.unwrap();
    for choice in &result.regularization.choices {
        assert!(choice.predicted_mse.unwrap() >= own * (1.0 - 1e-9), "{choice:?} beats {own}");
        assert!(
            choice.condition.unwrap()
                >= best(Criterion::MinCondition).map_or(1.0, |c| c.condition.unwrap()) * (1.0 - 1e-6)
        );
    }
    assert!(result.regularization.scheme.is_none() && result.bias.paper_bound.is_none() && result.bias.e.is_none());
}

/// The curve over λ against directions of (X, P) from two eigen analyses in the oracle's numbers.
pub fn check_curve(result: &FitResult, x: &Rows, y: &[f64], penalty: &Rows, unit: bool) {
    let (n, m) = (x[0].len(), y.len());
    let fisher = gram(x);
    let scales: Vec<Big> = (0..n).map(|j| if unit { fisher[j][j].sqrt() } else { Big::one() }).collect();
    let (lambda, v) = eigen(&scaled(&fisher, &scales));
    let half: Rows = (0..n).map(|j| (0..n).map(|i| &v[i][j] / &lambda[i].sqrt()).collect()).collect();
    let columns: Rows = (0..n).map(|i| column(&half, i)).collect();
    let (delta, q) = eigen(&product(&columns, &product(&scaled(penalty, &scales), &half)));
    let z: Rows = (0..n).map(|j| (0..n).map(|i| dot(&half[j], &q[i])).collect()).collect();
    let moments: Vec<Big> = (0..n).map(|j| &dot(&column(x, j), &vector(y)) / &scales[j]).collect();
    let a: Vec<f64> = (0..n).map(|i| dot(&column(&z, i), &moments).to_f64()).collect();
    let z: Vec<Vec<f64>> = z.iter().map(|row| doubles(row)).collect();
    let top = delta[n - 1].to_f64();
    let delta: Vec<f64> = delta.iter().map(|d| d.to_f64()).map(|d| if d < 1e-25 * top { 0.0 } else { d }).collect();
    let variance = result.residuals.least_squares_rss / (m - n) as f64;
    let norm = |parts: &dyn Fn(usize) -> f64| {
        z.iter().map(|row| row.iter().enumerate().map(|(i, z)| z * parts(i)).sum::<f64>().powi(2)).sum::<f64>()
    };
    let curve = result.lambda_curve.as_ref().expect("a curve");
    for point in curve.iter().step_by(9) {
        let f = |i: usize| 1.0 / (1.0 + point.lambda_star * delta[i]);
        let g = |i: usize| point.lambda_star * delta[i] * f(i);
        let real = |i: usize| (a[i] * a[i] - variance).max(0.0).sqrt().copysign(a[i]);
        let noise: f64 = (0..n).map(|i| f(i).powi(2) * z.iter().map(|row| row[i] * row[i]).sum::<f64>()).sum();
        let mse = norm(&|i| g(i) * real(i)) + variance * noise;
        assert_close("predicted mse", point.predicted_mse.unwrap(), mse, 1e-5, 0.0);
        assert_close("bias", point.bias_norm, norm(&|i| g(i) * a[i]).sqrt(), 1e-5, 1e-9 * point.coefficient_norm);
        assert_close("norm", point.coefficient_norm, norm(&|i| f(i) * a[i]).sqrt(), 1e-5, 0.0);
        let rss = result.residuals.least_squares_rss + (0..n).map(|i| (g(i) * a[i]).powi(2)).sum::<f64>();
        assert_close("rms", point.rms, (rss / m as f64).sqrt(), 1e-6, 0.0);
        let left = 1.0 - (0..n).map(f).sum::<f64>() / m as f64;
        assert_close("gcv", point.gcv.unwrap(), rss / (left * left), 1e-6, 0.0);
        let (eigenvalues, _) = eigen(&scaled(&plus(&fisher, penalty, point.lambda_star), &scales));
        let condition = (&eigenvalues[n - 1] / &eigenvalues[0]).to_f64();
        assert_close("condition", point.condition.unwrap(), condition, 1e-6, 0.0);
    }
    let own = |criterion| result.regularization.choices.iter().find(|c| c.criterion == ChosenBy::Criterion(criterion));
    for point in curve {
        let least = own(Criterion::MinMse).and_then(|c| c.predicted_mse).expect("a predicted error");
        assert!(point.predicted_mse.unwrap() >= least * (1.0 - 1e-9));
        if let Some(least) = own(Criterion::MinCondition).and_then(|c| c.condition) {
            assert!(point.condition.unwrap() >= least * (1.0 - 1e-6));
        }
    }
}
