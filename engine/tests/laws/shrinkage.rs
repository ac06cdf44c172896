//! Estimates drawn to a target by one factor, and truncated singular value decomposition.

use crate::oracle::matrix::{column, dot, doubles, vector};
use crate::oracle::random::Random;
use crate::problems::{
    Problem, assert_all_close, assert_close, by, columns, config, fit, least_squares_values, linear, matrix, values,
    warned,
};
use flankfit_engine::estimation::spec::{
    Attraction, ChosenBy, Criterion, FitSpec, JamesStein, Parameter, Regularization, Scaling, ShrinkageFactor,
};
use flankfit_engine::estimation::{FitError, FitResult, fit as try_fit};
use proptest::prelude::*;

fn attraction(target: &[f64], parameter: Parameter) -> Regularization {
    Regularization::Attraction(Attraction { target: target.to_vec(), parameter })
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The figures that every estimate `T + c(Â − T)` must have, from the definition and nothing else.
fn check(problem: &Problem, result: &FitResult, target: &[f64], scaling: Scaling, sigma: f64) {
    let c = result.regularization.shrinkage_factor.expect("a factor");
    let spectrum = problem.spectrum(columns(scaling));
    let scales = doubles(&spectrum.scales);
    let least = least_squares_values(result);
    let norm = distance(&least, &vec![0.0; least.len()]) + distance(target, &vec![0.0; least.len()]);
    for ((value, whole), target) in values(result).iter().zip(&least).zip(target) {
        assert_close("T + c(Â − T)", *value, target + c * (whole - target), 1e-12, 1e-13 * norm);
    }
    let scaled: Vec<f64> = least.iter().zip(target).zip(&scales).map(|((a, t), s)| (a - t) * s).collect();
    let length = scaled.iter().map(|d| d * d).sum::<f64>().sqrt();
    assert_close("bias", result.bias.norm, (1.0 - c).abs() * length, 1e-7, 1e-12 * length);
    let aim = target.iter().zip(&scales).map(|(t, s)| (t * s).powi(2)).sum::<f64>().sqrt();
    let sharp = (1.0 - c).abs() * (result.bias.coefficient_norm_limit + aim);
    assert_close("sharp bound", result.bias.sharp_bound, sharp, 1e-9, 0.0);
    assert!(result.bias.norm <= sharp * (1.0 + 1e-9));
    for coefficient in &result.coefficients {
        let change = (coefficient.least_squares - coefficient.value).abs();
        assert!(change <= coefficient.bias_bound * (1.0 + 1e-7) + 1e-13 * norm);
        let (own, whole) = (coefficient.error_given_lambda().unwrap(), coefficient.least_squares_std_error.unwrap());
        assert_close("standard error", own, c.abs() * whole, 1e-9, 0.0);
    }
    let residuals: f64 = problem
        .x
        .iter()
        .zip(&problem.y)
        .map(|(row, y)| (y - row.iter().zip(values(result)).map(|(x, a)| x * a).sum::<f64>()).powi(2))
        .sum();
    let heights: f64 = problem.y.iter().map(|y| y * y).sum();
    assert_close("rss", result.residuals.rss, residuals, 1e-7, 1e-13 * (heights + norm * norm));
    assert_all_close("eigenvalues stay", &result.spectrum.regularized.eigenvalues, &result.spectrum.eigenvalues, 1e-15);
    // the predicted error of a factor, direction by direction
    let sums = spectrum.sums();
    let t: Vec<f64> = (0..sums.n())
        .map(|i| spectrum.vectors[i].iter().zip(target).zip(&scales).map(|((v, t), s)| v.to_f64() * t * s).sum())
        .collect();
    for choice in &result.regularization.choices {
        let c = match choice.criterion {
            ChosenBy::LeastSquares => 1.0,
            _ => choice.lambda_star.map_or(0.0, |k| 1.0 / (1.0 + k)),
        };
        let expected: f64 = (0..sums.n())
            .map(|i| {
                let noise = sigma * sigma / sums.lambda[i];
                (1.0 - c).powi(2) * ((sums.a[i] - t[i]).powi(2) - noise).max(0.0) + c * c * noise
            })
            .sum();
        assert_close("predicted mse", choice.predicted_mse.unwrap(), expected, 1e-6, 0.0);
    }
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn attraction_agrees_with_its_definition(
        seed: u64, n in 1usize..8, extra in 2usize..15, log_condition in 1.0f64..8.0, unit: bool, k in 0.0f64..3.0,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let sigma = problem.spectrum(columns(scaling)).sums().sigma();
        let target: Vec<f64> = Random::new(seed ^ 7).normals(n);
        let spec = |parameter| FitSpec { scaling, regularization: attraction(&target, parameter), ..linear() };
        let fixed = fit(&problem.nodes(), &spec(Parameter::Fixed(k + 1e-6)));
        assert_close("c", fixed.regularization.shrinkage_factor.unwrap(), 1.0 / (1.0 + k + 1e-6), 1e-14, 0.0);
        check(&problem, &fixed, &target, scaling, sigma);

        // the explicit optimum, and nothing near it is better
        let optimal = fit(&problem.nodes(), &spec(by(Criterion::Optimal)));
        check(&problem, &optimal, &target, scaling, sigma);
        let wanted = ChosenBy::Criterion(Criterion::Optimal);
        let best = optimal.regularization.choices.iter().find(|c| c.criterion == wanted).unwrap();
        let least = best.predicted_mse.unwrap();
        for choice in &optimal.regularization.choices {
            prop_assert!(choice.predicted_mse.unwrap() >= least * (1.0 - 1e-12));
        }
        if let Some(k) = best.lambda_star {
            for factor in [0.5, 0.9, 1.1, 2.0] {
                let other = fit(&problem.nodes(), &spec(Parameter::Fixed(k * factor + 1e-300)));
                let curve = other.regularization.choices.len();
                prop_assert!(curve > 1);
            }
        } else {
            prop_assert!(warned(&optimal, "attracted_entirely"));
            assert_all_close("the target", &values(&optimal), &target, 1e-12);
        }
    }

    #[test]
    fn james_stein_agrees_with_its_definition(
        seed: u64, n in 3usize..9, extra in 1usize..15, log_condition in 1.0f64..8.0, unit: bool, aimed: bool,
        which in 0usize..3,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let sums = problem.spectrum(columns(scaling)).sums();
        let target = if aimed { Random::new(seed ^ 7).normals(n) } else { vec![0.0; n] };
        let factor = [ShrinkageFactor::JamesStein, ShrinkageFactor::HoerlKennard, ShrinkageFactor::EfronMorris][which];
        let asked = JamesStein { factor, positive_part: which == 0, target: Some(target.clone()) };
        let spec = FitSpec { scaling, regularization: Regularization::JamesStein(asked), ..linear() };
        let result = fit(&problem.nodes(), &spec);
        check(&problem, &result, &target, scaling, sums.sigma());
        let x = crate::oracle::matrix::rows(&problem.x);
        let away: Vec<f64> = least_squares_values(&result).iter().zip(&target).map(|(a, t)| a - t).collect();
        let moved: Vec<f64> = doubles(&crate::oracle::matrix::times(&x, &vector(&away)));
        let reach: f64 = moved.iter().map(|x| x * x).sum();
        let df = extra as f64;
        let variance = if which == 1 { sums.rss / df } else { sums.rss / (df + 2.0) };
        let raw = 1.0 - (n as f64 - 2.0) * variance / reach;
        let expected = if which == 0 { raw.max(0.0) } else { raw };
        assert_close("factor", result.regularization.shrinkage_factor.unwrap(), expected, 1e-7, 1e-9);
        prop_assert!(result.regularization.lambda_star.is_none() && result.spectrum.regularized.condition.is_some());
    }

    #[test]
    fn truncation_keeps_the_largest_directions(
        seed: u64, n in 1usize..9, extra in 1usize..12, log_condition in 1.0f64..10.0, unit: bool, rank in 1usize..9,
    ) {
        let rank = 1 + (rank - 1) % n;
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let spectrum = problem.spectrum(columns(scaling));
        let factors: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i >= n - rank))).collect();
        let spec = FitSpec { scaling, regularization: Regularization::TruncatedSvd { rank }, ..linear() };
        let result = fit(&problem.nodes(), &spec);
        prop_assert_eq!(&result.regularization.filter_factors, &factors);
        prop_assert_eq!(result.regularization.rank, Some(rank));
        let exact = doubles(&spectrum.coefficients(&factors));
        let size = distance(&exact, &vec![0.0; n]);
        for (value, exact) in values(&result).iter().zip(&exact) {
            assert_close("coefficient", *value, *exact, 1e-7, 1e-9 * size);
        }
        let sums = spectrum.sums();
        let dropped: f64 = (0..n - rank).map(|i| sums.lambda[i] * sums.a[i].powi(2)).sum();
        assert_close("rss", result.residuals.rss, sums.rss + dropped, 1e-7, 0.0);
        let norm = (0..n - rank).map(|i| sums.a[i].powi(2)).sum::<f64>().sqrt();
        assert_close("bias", result.bias.norm, norm, 1e-7, 0.0);
        let reach = if rank < n { result.bias.coefficient_norm_limit } else { 0.0 };
        prop_assert_eq!(result.bias.sharp_bound, reach);
        let condition = sums.lambda[n - 1] / sums.lambda[n - rank];
        assert_close("condition", result.spectrum.regularized.condition.unwrap(), condition, 1e-8, 0.0);
    }
}

/// Two equal columns: the smaller rank is accepted, the full one is refused by name.
#[test]
fn truncation_of_dependent_columns() {
    let x: Vec<Vec<f64>> = (0..8)
        .map(|i| {
            let t = f64::from(i);
            vec![1.0, t, t, (t - 3.0).powi(2)]
        })
        .collect();
    let y: Vec<f64> = (0..8).map(|i| 1.0 + 0.5 * f64::from(i) + 0.1 * f64::from(i * i % 5)).collect();
    let nodes = matrix(&x, &y, None);
    let spec = |rank| FitSpec { regularization: Regularization::TruncatedSvd { rank }, ..linear() };
    let result = fit(&nodes, &spec(3));
    assert!(warned(&result, "rank_deficient"));
    // of minimum norm: both columns get the same, and the fit is that without one of them
    assert_close("equal columns", values(&result)[1], values(&result)[2], 1e-12, 0.0);
    let reduced: Vec<Vec<f64>> = x.iter().map(|row| vec![row[0], row[1], row[3]]).collect();
    let plain = fit(&matrix(&reduced, &y, None), &FitSpec { regularization: Regularization::None, ..linear() });
    assert_close("rss", result.residuals.rss, plain.residuals.rss, 1e-10, 0.0);
    assert_close("sum of slopes", values(&result)[1] + values(&result)[2], values(&plain)[1], 1e-10, 0.0);
    for rank in [0, 4, 5] {
        let Err(FitError::Invalid(faults)) = try_fit(&nodes, &spec(rank)) else { panic!("rank {rank}") };
        assert_eq!(faults.list()[0].path.clone(), "regularization.rank");
    }
}

/// Toward the grand mean the mean of the fitted heights stays, and its variance with it.
#[test]
fn the_grand_mean_is_not_shrunk() {
    let problem = Problem::graded(5, 4, 9, 2.0);
    let x: Vec<Vec<f64>> = problem.x.iter().map(|row| [vec![1.0], row.clone()].concat()).collect();
    let nodes = matrix(&x, &problem.y, None);
    let asked = JamesStein { factor: ShrinkageFactor::EfronMorris, positive_part: false, target: None };
    for scaling in [Scaling::UnitLength, Scaling::None, Scaling::Standardized] {
        let spec = FitSpec { scaling, regularization: Regularization::JamesStein(asked.clone()), ..linear() };
        let result = fit(&nodes, &spec);
        let big = crate::oracle::matrix::rows(&x);
        let fitted = crate::oracle::matrix::times(&big, &vector(&values(&result)));
        let ones = column(&big, 0);
        assert_close("mean", dot(&fitted, &ones).to_f64(), problem.y.iter().sum(), 1e-9, 1e-12);
        // the same estimate whatever the columns: errors, residuals and the factor
        let plain = FitSpec { scaling: Scaling::Standardized, ..spec.clone() };
        let other = fit(&nodes, &plain);
        for (a, b) in result.coefficients.iter().zip(&other.coefficients) {
            assert_close("value", a.value, b.value, 1e-9, 1e-12);
            assert_close("standard error", a.error_given_lambda().unwrap(), b.error_given_lambda().unwrap(), 1e-8, 0.0);
        }
        assert_close("rss", result.residuals.rss, other.residuals.rss, 1e-9, 0.0);
        assert!(result.bias.norm <= result.bias.sharp_bound * (1.0 + 1e-9));
        for c in &result.coefficients {
            assert!((c.least_squares - c.value).abs() <= c.bias_bound * (1.0 + 1e-7) + 1e-12, "{scaling:?} {c:?}");
        }
    }
}

#[test]
fn invalid_shrinkage_is_refused() {
    let problem = Problem::graded(3, 4, 5, 2.0);
    let nodes = problem.nodes();
    let field = |regularization| match try_fit(&nodes, &FitSpec { regularization, ..linear() }) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(field(attraction(&[1.0, 2.0], by(Criterion::Optimal))), "regularization.target");
    assert_eq!(
        field(attraction(&[1.0, 2.0, 3.0, 4.0], by(Criterion::MinCondition))),
        "regularization.parameter.criterion"
    );
    let stein = |factor, target| Regularization::JamesStein(JamesStein { factor, positive_part: true, target });
    assert_eq!(field(stein(ShrinkageFactor::JamesStein, Some(vec![0.0; 3]))), "regularization.target");
    // random columns cannot make a constant
    assert_eq!(field(stein(ShrinkageFactor::EfronMorris, None)), "regularization.variant");
    let two = Problem::graded(3, 2, 5, 2.0);
    let spec = FitSpec { regularization: stein(ShrinkageFactor::JamesStein, None), ..linear() };
    let Err(FitError::Invalid(faults)) = try_fit(&two.nodes(), &spec) else { panic!("two directions") };
    assert_eq!(faults.list()[0].path.clone(), "regularization.type");
    // without σ least squares is used
    let square = Problem::graded(3, 4, 0, 2.0);
    let result = fit(&square.nodes(), &spec);
    assert!(warned(&result, "criterion_unavailable") && result.regularization.shrinkage_factor.is_none());
    assert_eq!(values(&result), least_squares_values(&result));
}
