//! Models of the errors together with all other parts of a fit.

use crate::{oracle::random::Random, problems::fit};
use flankfit_engine::estimation::{
    FitError, FitResult, FitSpec, Nodes,
    result::IntervalKind,
    spec::{
        Along, Chain, Correlation, Criterion, Degree, Errors, Estimator, Include, Kinds, Model, Moves, NodeUncertainty,
        Parameter, Places, PolynomialBasis, Predict, Prior, PriorSpread, Regularization, Scaling, Terms, Variance,
        Which,
    },
};

const COUNT: usize = 40;
const RHO: f64 = 0.7;

/// Rows 1, t, t², t³ and t³ with a small addition, and heights that oscillate slowly.
fn problem(seed: u64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut random = Random::new(seed);
    let rows: Vec<Vec<f64>> = (0..COUNT)
        .map(|k| {
            let t = k as f64 / 20.0 - 1.0;
            vec![1.0, t, t * t, t.powi(3), t.powi(3) + 0.003 * random.normal()]
        })
        .collect();
    let mut error = 0.0;
    let heights = rows.iter().map(|row| {
        error = RHO * error + random.normal();
        2.0 - row[1] + 0.5 * row[3] + 0.2 * error
    });
    (rows.clone(), heights.collect())
}

fn matrix(rows: &[Vec<f64>], y: &[f64]) -> Nodes {
    Nodes::matrix(rows.concat(), rows[0].len(), y.to_vec(), None, None).unwrap()
}

/// Differences of neighbours that are white where errors are an autoregression.
fn whitened(x: &[f64]) -> Vec<f64> {
    let left = (1.0 - RHO * RHO).sqrt();
    (0..x.len()).map(|k| if k == 0 { x[0] } else { (x[k] - RHO * x[k - 1]) / left }).collect()
}

fn ar1(rho: Option<f64>) -> Option<Errors> {
    Some(Errors { correlation: Correlation::Ar1 { rho }, along: Along::Order, lines: None })
}

fn plain() -> FitSpec {
    let kinds = Kinds { confidence: true, prediction: true, simultaneous: true };
    let at = Places::Rows(vec![vec![1.0, 0.3, 0.1, 0.0, 0.1], vec![0.0, 1.0, 0.0, 2.0, 2.0]]);
    FitSpec {
        regularization: Regularization::None,
        predict: Some(Predict { at, level: Some(0.9), kinds, slopes: false }),
        include: Include { covariance: true, collinearity: true, ..Include::default() },
        ..FitSpec::new(Model::Linear)
    }
}

fn near(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() <= 1e-9 * (a.abs() + b.abs()) + 1e-13, "{what}: {a} {b}");
}

fn same(a: &FitResult, b: &FitResult) {
    for (a, b) in a.coefficients.iter().zip(&b.coefficients) {
        let (left, right) = (a.interval.unwrap(), b.interval.unwrap());
        assert_eq!(left.kind, right.kind);
        for (x, y) in left.ends.iter().zip(right.ends) {
            near(*x, y, "interval");
        }
        near(a.value, b.value, "value");
        near(a.std_error.unwrap(), b.std_error.unwrap(), "std_error");
        near(a.bias_bound, b.bias_bound, "bias_bound");
        near(left.about.std_error, right.about.std_error, "about");
    }
    let lists = |found: &FitResult| -> Vec<f64> {
        let (covariance, bands) = (found.covariance.clone().unwrap(), found.predictions.clone().unwrap());
        let mut all: Vec<f64> = covariance.coefficients.concat();
        all.extend(bands.prediction.unwrap().concat());
        all.extend(bands.confidence.unwrap().concat());
        all.extend(bands.simultaneous.unwrap().band.concat());
        all.extend(found.estimable.iter().flatten().flat_map(|sum| [sum.value, sum.interval.unwrap()[0]]));
        all.extend(found.regularization.lambda_star);
        all.extend(found.bias.upper_confidence);
        all
    };
    let (left, right) = (lists(a), lists(b));
    assert_eq!(left.len(), right.len());
    left.iter().zip(&right).for_each(|(x, y)| near(*x, *y, "lists"));
}

/// With a given correlation everything is that of a plain fit to differences of neighbours:
/// regularised, bias-aware, combined with a prior.
#[test]
fn known_correlations_equal_a_plain_fit_of_whitened_rows() {
    let (rows, y) = problem(71);
    let columns: Vec<Vec<f64>> =
        (0..5).map(|j| whitened(&rows.iter().map(|row| row[j]).collect::<Vec<f64>>())).collect();
    let white: Vec<Vec<f64>> = (0..COUNT).map(|k| columns.iter().map(|column| column[k]).collect()).collect();
    let (nodes, by_hand) = (matrix(&rows, &y), matrix(&white, &whitened(&y)));
    let ridge = |criterion| Regularization::Ridge { parameter: Parameter::Criterion(criterion) };
    let prior = Prior::Given { mean: vec![1.0; 5], spread: PriorSpread::StdError(vec![3.0; 5]) };
    for spec in [
        plain(),
        FitSpec { regularization: ridge(Criterion::Gcv), ..plain() },
        FitSpec { regularization: ridge(Criterion::Reml), coefficient_norm_limit: Some(8.0), ..plain() },
        FitSpec { regularization: Regularization::default(), noise_sigma: Some(0.3), ..plain() },
        FitSpec { prior: Some(prior), ..plain() },
    ] {
        let asked = FitSpec { errors: ar1(Some(RHO)), ..spec.clone() };
        same(&fit(&nodes, &asked), &fit(&by_hand, &spec));
    }
}

/// Sums, forms along the worst direction and requested rows have the errors of the covariance
/// matrix, not those of σ alone.
#[test]
fn every_standard_error_is_that_of_the_covariance() {
    let (rows, y) = problem(72);
    let nodes = matrix(&rows, &y);
    for (errors, variance) in [(ar1(None), Variance::Constant), (None, Variance::Hc3)] {
        let spec = FitSpec { errors, variance, scaling: Scaling::None, ..plain() };
        let found = fit(&nodes, &spec);
        let covariance = found.covariance.clone().unwrap().least_squares;
        let error = |w: &[f64]| {
            let entry = |j: usize, k: usize| if k <= j { covariance[j][k] } else { covariance[k][j] };
            let sum: f64 =
                (0..5).flat_map(|j| (0..5).map(move |k| (j, k))).map(|(j, k)| w[j] * w[k] * entry(j, k)).sum();
            sum.sqrt()
        };
        let close = |a: f64, b: f64, what: &str| assert!((a / b - 1.0).abs() < 1e-5, "{what}: {a} {b}");
        let sum = &found.estimable.as_ref().unwrap()[0];
        let mut weights = vec![0.0; 5];
        for (term, weight) in sum.terms.iter().zip(&sum.weights) {
            weights[found.coefficients.iter().position(|c| c.term == *term).unwrap()] = *weight;
        }
        close(sum.std_error.unwrap(), error(&weights), "sum");
        let asked = spec.predict.as_ref().unwrap();
        let Places::Rows(places) = &asked.at else { panic!() };
        let bands = found.predictions.as_ref().unwrap();
        close(bands.std_error.as_ref().unwrap()[1], error(&places[1]), "row");
        // the limit of the norm in the caller's columns
        let regularised = fit(&nodes, &FitSpec { regularization: Regularization::default(), ..spec.clone() });
        let values: Vec<f64> = regularised.coefficients.iter().map(|c| c.least_squares).collect();
        let norm = values.iter().map(|x| x * x).sum::<f64>().sqrt();
        // t(0.95; 35)
        close(regularised.bias.upper_confidence.unwrap(), norm + 1.689_572_457_780_265 * error(&values) / norm, "norm");
        // decisions rest on the tails of one side in twenty
        let ninety = fit(&nodes, &FitSpec { level: 0.9, ..spec });
        for c in &ninety.coefficients {
            let interval = c.interval.unwrap();
            assert_eq!(interval.kind, IntervalKind::Student);
            let about = interval.about.interval(0.9);
            let tolerance = 1e-9 * (about[1] - about[0]);
            assert!((about[0] - interval.ends[0]).abs() < tolerance && (about[1] - interval.ends[1]).abs() < tolerance);
        }
    }
}

/// One node so far off that the others are at one place for double precision: what is refused names
/// terms.
#[test]
fn dependent_columns_have_names() {
    let mut random = Random::new(72);
    let x: Vec<f64> = (0..COUNT).map(|k| if k == 0 { 1e30 } else { 0.5 * k as f64 }).collect();
    let nodes = Nodes::curve(x, random.normals(COUNT), None).unwrap();
    for basis in [PolynomialBasis::Legendre, PolynomialBasis::Chebyshev] {
        let model = Model::Polynomial { degree: Degree::Both(2), basis, terms: Terms::Total };
        let asked = FitSpec { errors: ar1(None), regularization: Regularization::None, ..FitSpec::new(model) };
        match flankfit_engine::estimation::fit(&nodes, &asked) {
            Err(FitError::RankDeficient { rank, columns, terms }) => {
                assert!(terms.len() >= 2 && rank < columns, "{rank} {columns} {terms:?}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn unavailable_results_are_omitted_with_a_warning() {
    let (rows, y) = problem(73);
    let nodes = matrix(&rows, &y);
    let include = Include { influence: true, predicted_mse: true, ..Include::default() };
    let spec = FitSpec { include, regularization: Regularization::default(), ..plain() };
    let halves: Vec<i64> = (0..COUNT as i64).map(|k| k / 20).collect();
    for (errors, variance, missing) in [
        (ar1(None), Variance::Constant, &["no_influence", "no_corrected_error"][..]),
        (ar1(Some(RHO)), Variance::Constant, &["no_influence"]),
        (None, Variance::Hc3, &["no_influence", "no_corrected_error", "no_prediction_intervals"]),
        (None, Variance::Groups(halves), &["no_prediction_intervals"]),
    ] {
        let found = fit(&nodes, &FitSpec { errors, variance, ..spec.clone() });
        let codes: Vec<&str> = found.warnings.iter().map(|w| w.code()).collect();
        assert!(missing.iter().all(|code| codes.contains(code)), "{codes:?}");
        assert_eq!(found.influence.is_none(), missing.contains(&"no_influence"));
        let corrected = found.regularization.predicted_mse_corrected;
        assert_eq!(corrected.is_none(), missing.contains(&"no_corrected_error"));
        let bands = found.predictions.unwrap();
        assert_eq!(bands.prediction.is_none(), missing.contains(&"no_prediction_intervals"));
        assert!(bands.confidence.is_some());
    }
}

#[test]
fn incompatible_options_are_refused() {
    let (rows, y) = problem(74);
    let nodes = matrix(&rows, &y);
    let refused = |spec: &FitSpec, message: &str| {
        let error = flankfit_engine::estimation::fit(&nodes, spec).unwrap_err();
        let FitError::Invalid(faults) = error else { panic!("{error}") };
        assert!(faults.to_string().starts_with(message), "{faults}");
    };
    let correlated = |rho| FitSpec { errors: ar1(rho), ..plain() };
    let sandwich = FitSpec { variance: Variance::Hc3, ..plain() };
    let press = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Press) };
    let message = "regularization.parameter.criterion: press and blocked_cv need independent nodes";
    refused(&FitSpec { regularization: press, ..correlated(Some(0.5)) }, message);
    let given = Some(Prior::Given { mean: vec![0.0; 5], spread: PriorSpread::StdError(vec![1.0; 5]) });
    refused(
        &FitSpec { prior: given.clone(), ..correlated(None) },
        "prior: a prior needs errors with given correlations",
    );
    refused(&FitSpec { prior: given, ..sandwich.clone() }, "prior: a prior needs errors with given correlations");
    let chain = Chain { which: Which::Previous, moves: Moves::Estimated, correction: true, earlier: None };
    let chain = Some(Prior::Iterations(chain));
    refused(&FitSpec { prior: chain, ..correlated(Some(0.5)) }, "prior: earlier iterations are weighted");
    let groups = FitSpec { variance: Variance::Groups(vec![1; COUNT]), noise_sigma: Some(1.0), ..plain() };
    refused(&groups, "noise_sigma: variances are estimated from the residuals");
    let rank = FitSpec { estimator: Estimator::Rank, ..sandwich.clone() };
    refused(&rank, "estimator.type: a model of the errors needs least squares");
    let uncertain =
        FitSpec { node_uncertainty: Some(NodeUncertainty { position: 0.0, height: 1.0, kind: None }), ..sandwich };
    refused(&uncertain, "node_uncertainty: perturbation bounds are those");
}
