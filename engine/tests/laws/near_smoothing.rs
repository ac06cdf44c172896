//! The smoothing spline: what it becomes at the ends of λ, and the dense penalised solution of an
//! oracle.

use flankfit_engine::estimation::smoothing::spline::{Points, SmoothingSpec};
use flankfit_engine::estimation::smoothing::{Smoothing, SmoothingSpline, smoothing_spline};
use flankfit_engine::estimation::spec::{Criterion, Parameter};
use flankfit_engine::geometry::curve::Curve;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::oracle::random::Random;

fn asked(smoothing: Smoothing) -> SmoothingSpec {
    SmoothingSpec { smoothing, noise_sigma: Some(0.1), pointwise: true }
}

fn fixed(lambda: f64) -> SmoothingSpec {
    asked(Smoothing::Parameter(Parameter::Fixed(lambda)))
}

fn by(criterion: Criterion) -> SmoothingSpec {
    asked(Smoothing::Parameter(Parameter::Criterion(criterion)))
}

fn smooth(x: &[f64], y: &[f64], weight: Option<&[f64]>, asked: &SmoothingSpec) -> SmoothingSpline {
    smoothing_spline(&Points { x, coordinates: &[y.to_vec()], weight }, asked).unwrap()
}

/// Values at distinct abscissae: `(Ω + λ K) g = Ω y`, K = Q R⁻¹ Qᵀ, dense; and the smoother's
/// matrix.
fn dense(x: &[f64], y: &[f64], w: &[f64], lambda: f64) -> (DVector<f64>, DMatrix<f64>, f64, f64) {
    let m = x.len();
    let h: Vec<f64> = x.windows(2).map(|p| p[1] - p[0]).collect();
    let mut q = DMatrix::zeros(m, m - 2);
    let mut r = DMatrix::zeros(m - 2, m - 2);
    for j in 0..m - 2 {
        q[(j, j)] = 1.0 / h[j];
        q[(j + 1, j)] = -1.0 / h[j] - 1.0 / h[j + 1];
        q[(j + 2, j)] = 1.0 / h[j + 1];
        r[(j, j)] = (h[j] + h[j + 1]) / 3.0;
        if j + 3 < m {
            r[(j, j + 1)] = h[j + 1] / 6.0;
            r[(j + 1, j)] = h[j + 1] / 6.0;
        }
    }
    let k = &q * r.clone().try_inverse().unwrap() * q.transpose();
    let omega = DMatrix::from_diagonal(&DVector::from_column_slice(w));
    let smoother = (&omega + lambda * &k).try_inverse().unwrap() * &omega;
    let g = &smoother * DVector::from_column_slice(y);
    let roughness = (g.transpose() * &k * &g)[(0, 0)];
    // what elimination in doubles leaves
    let slack = 1e-14 * (1.0 + lambda * k.norm());
    (g, smoother, roughness, slack)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn it_is_the_dense_penalised_solution(seed: u64, m in 3usize..40, power in -7i32..1, weighted: bool) {
        let mut random = Random::new(seed);
        let mut x = vec![random.between(-2.0, 2.0)];
        for i in 1..m {
            x.push(x[i - 1] + random.between(0.05, 0.3));
        }
        let y: Vec<f64> = x.iter().map(|x| (2.0 * x).sin() + 0.1 * random.normal()).collect();
        let w: Vec<f64> = (0..m).map(|_| if weighted { random.between(0.5, 2.0) } else { 1.0 }).collect();
        let lambda = 10f64.powi(power);
        let (g, smoother, roughness, slack) = dense(&x, &y, &w, lambda);
        let spline = smooth(&x, &y, weighted.then_some(&w[..]), &fixed(lambda));
        let pointwise = spline.pointwise.as_ref().unwrap();
        for i in 0..m {
            prop_assert!((pointwise.fitted[0][i] - g[i]).abs() < slack, "{} {}", pointwise.fitted[0][i], g[i]);
            prop_assert!((spline.curve.value(x[i]).x - pointwise.fitted[0][i]).abs() < 1e-13);
        }
        prop_assert!((spline.effective_degrees_of_freedom - smoother.trace()).abs() < m as f64 * slack);
        prop_assert!((spline.roughness - roughness).abs() < 100.0 * slack * roughness.max(1.0) / lambda.min(1.0));
        let rss: f64 = (0..m).map(|i| w[i] * (y[i] - g[i]).powi(2)).sum();
        prop_assert!((spline.rss[0] - rss).abs() < 100.0 * slack);
        if let (Some(sigma), Some(errors)) = (spline.sigma[0], &pointwise.standard_errors[0]) {
            for i in 0..m {
                let truth = sigma * (smoother[(i, i)] / w[i]).sqrt();
                prop_assert!((errors[i].powi(2) - truth * truth).abs() < 10.0 * slack * sigma * sigma);
            }
        }
        // natural: no curvature at the ends
        prop_assert!(spline.curve.jet(x[0])[2].x.abs() < 1e-8 && spline.curve.jet(x[m - 1])[2].x.abs() < 1e-8);
    }

    #[test]
    fn from_the_interpolant_to_the_line(seed: u64) {
        let mut random = Random::new(seed);
        let x: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.2 + 0.1 * random.unit()).collect();
        let y: Vec<f64> = x.iter().map(|x| x.sin() + 0.2 * random.normal()).collect();
        let through = smooth(&x, &y, None, &fixed(0.0));
        prop_assert!((through.effective_degrees_of_freedom - 50.0).abs() < 1e-12 && through.rss[0] == 0.0);
        for (x, y) in x.iter().zip(&y) {
            prop_assert!((through.curve.value(*x).x - y).abs() < 1e-14);
        }
        let near = smooth(&x, &y, None, &fixed(1e-14));
        prop_assert!(near.max_abs[0] < 1e-8);
        let (mx, my) = (x.iter().sum::<f64>() / 50.0, y.iter().sum::<f64>() / 50.0);
        let slope = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>()
            / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>();
        let straight = smooth(&x, &y, None, &fixed(1e20));
        prop_assert!((straight.effective_degrees_of_freedom - 2.0).abs() < 1e-9);
        // a λ whose square exceeds all doubles
        for lambda in [1e150, 1e300] {
            let stiff = smooth(&x, &y, None, &fixed(lambda));
            prop_assert!((stiff.rss[0] / straight.rss[0] - 1.0).abs() < 1e-9, "{} {}", stiff.rss[0], straight.rss[0]);
            let rss: f64 = x.iter().zip(&y).map(|(x, y)| (stiff.curve.value(*x).x - y).powi(2)).sum();
            prop_assert!((stiff.rss[0] / rss - 1.0).abs() < 1e-9 && stiff.max_abs[0] < rss.sqrt() * (1.0 + 1e-12));
            prop_assert!((stiff.effective_degrees_of_freedom - 2.0).abs() < 1e-9);
        }
        for x in &x {
            prop_assert!((straight.curve.value(*x).x - (my + slope * (x - mx))).abs() < 1e-12);
        }
    }

    /// Repeated measurements: the same as their means with the sums of their weights, but for RSS
    /// and m.
    #[test]
    fn repeated_abscissae_are_repeated_measurements(seed: u64) {
        let mut random = Random::new(seed);
        let x: Vec<f64> = (0..60).map(|i| f64::from(i / 3)).collect();
        let y: Vec<f64> = x.iter().map(|x| (0.5 * x).sin() + 0.1 * random.normal()).collect();
        let means: Vec<f64> = y.chunks(3).map(|y| y.iter().sum::<f64>() / 3.0).collect();
        let distinct: Vec<f64> = (0..20).map(f64::from).collect();
        let all = smooth(&x, &y, None, &fixed(0.3));
        let merged = smooth(&distinct, &means, Some(&[3.0; 20]), &fixed(0.3));
        for x in &distinct {
            prop_assert!((all.curve.value(*x).x - merged.curve.value(*x).x).abs() < 1e-13);
        }
        prop_assert_eq!((all.count, all.abscissae), (60, 20));
        let rss: f64 = x.iter().zip(&y).map(|(x, y)| (y - all.curve.value(*x).x).powi(2)).sum();
        prop_assert!((all.rss[0] - rss).abs() < 1e-11);
    }
}

#[test]
fn criteria_against_a_fine_scan() {
    let mut random = Random::new(8);
    let x: Vec<f64> = (0..120).map(|i| f64::from(i) / 119.0).collect();
    let y: Vec<f64> = x.iter().map(|x| (9.0 * x).sin() + 0.1 * random.normal()).collect();
    let scan: Vec<SmoothingSpline> =
        (-200..40).map(|i| smooth(&x, &y, None, &fixed(10f64.powf(f64::from(i) * 0.05)))).collect();
    let least = |score: &dyn Fn(&SmoothingSpline) -> f64| {
        scan.iter().min_by(|a, b| score(a).total_cmp(&score(b))).map(|s| s.lambda).unwrap()
    };
    let gcv = least(&|s| s.rss[0] / (1.0 - s.effective_degrees_of_freedom / 120.0).powi(2));
    let mse = least(&|s| s.rss[0] + 0.02 * s.effective_degrees_of_freedom);
    for (criterion, wanted) in [(Criterion::Gcv, gcv), (Criterion::MinMse, mse)] {
        let got = smooth(&x, &y, None, &by(criterion)).lambda;
        assert!((got / wanted).log10().abs() <= 0.051, "{criterion:?} {got} {wanted}");
    }
    let discrepancy = smooth(&x, &y, None, &by(Criterion::Discrepancy));
    assert!((discrepancy.rss[0] - 1.2).abs() < 1e-9);
    let degrees = smooth(&x, &y, None, &asked(Smoothing::EffectiveDegrees(9.0)));
    assert!((degrees.effective_degrees_of_freedom - 9.0).abs() < 1e-9);
    let corner = smooth(&x, &y, None, &by(Criterion::LCurve));
    assert!(corner.effective_degrees_of_freedom > 3.0 && corner.effective_degrees_of_freedom < 80.0);
    // the true curve is found within the noise
    let fit = smooth(&x, &y, None, &by(Criterion::Gcv));
    let error = x.iter().map(|x| (fit.curve.value(*x).x - (9.0 * x).sin()).powi(2)).sum::<f64>() / 120.0;
    assert!(error.sqrt() < 0.05, "{}", error.sqrt());
}

#[test]
fn errors_name_the_point() {
    let of = |x: &[f64], y: &[f64], weight: Option<&[f64]>| {
        smoothing_spline(&Points { x, coordinates: &[y.to_vec()], weight }, &fixed(1.0)).unwrap_err().list()[0]
            .path
            .clone()
    };
    assert_eq!(of(&[0., 2., 1.], &[0.; 3], None), "points.x[2]");
    assert_eq!(of(&[0., 1., 2.], &[0.; 2], None), "points.y");
    assert_eq!(of(&[0., 1.], &[0., f64::NAN], None), "points.y[1]");
    assert_eq!(of(&[0., 1.], &[0.; 2], Some(&[1.0, -1.0])), "method.weight[1]");
    assert_eq!(of(&[1., 1.], &[0.; 2], None), "points");
    let two = smooth(&[0.0, 2.0], &[1.0, 5.0], None, &fixed(1.0));
    assert_eq!(two.curve.value(1.0).x, 3.0);
}

/// Ten thousand points, badly spaced, and a space curve with one λ.
#[test]
fn long_and_parametric() {
    let mut random = Random::new(5);
    let mut x = vec![0.0];
    for i in 1..10_000 {
        x.push(x[i - 1] + if i % 100 == 0 { 1e-3 } else { 1e-6 * (0.1 + random.unit()) });
    }
    let length = x[9_999];
    let at = |x: f64| [(6.0 * x / length).cos(), (6.0 * x / length).sin(), x / length];
    let coordinates: Vec<Vec<f64>> =
        (0..3).map(|c| x.iter().map(|x| at(*x)[c] + 0.01 * random.normal()).collect()).collect();
    let points = Points { x: &x, coordinates: &coordinates, weight: None };
    let spline = smoothing_spline(&points, &by(Criterion::Gcv)).unwrap();
    assert!(spline.effective_degrees_of_freedom > 5.0 && spline.effective_degrees_of_freedom < 60.0);
    for (k, sigma) in spline.sigma.iter().enumerate() {
        assert!((sigma.unwrap() - 0.01).abs() < 3e-4, "{k}");
    }
    let error = x.iter().map(|x| (spline.curve.value(*x) - nalgebra::Vector3::from(at(*x))).norm()).fold(0.0, f64::max);
    assert!(error < 0.01, "{error}");
}
