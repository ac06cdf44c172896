//! Inference in addition to the default: `cargo xtask bench inference`. One call of `fit` on a
//! flank grid of 45 nodes and degree (2,2), or on a measurement matrix with the same columns;
//! `default` is there to compare with.

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{
        Along, Constraint, ConstraintKind, Correlation, Degree, Errors, FilterAxis, Include, Kinds, Knots, Model,
        NodeUncertainty, Places, PolynomialBasis, PositionKind, Predict, Regularization, Terms, Variance,
    },
};

fn axis(from: f64, to: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| from + (to - from) * i as f64 / (n - 1) as f64).collect()
}

fn height(u: f64, v: f64) -> f64 {
    let (s, t) = ((u - 8.745) / 2.775, (v - 7.5) / 6.75);
    4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.75 * s * t + 0.3 * (37.0 * u + 19.0 * v).sin()
}

/// Places of the flank, row by row.
fn places(nu: usize, nv: usize) -> Vec<[f64; 2]> {
    axis(5.97, 11.52, nu).iter().flat_map(|&u| axis(0.75, 14.25, nv).into_iter().map(move |v| [u, v])).collect()
}

fn run(bencher: Bencher, change: impl Fn(&mut FitSpec)) {
    let heights = places(5, 9).iter().map(|[u, v]| height(*u, *v)).collect();
    let nodes = Nodes::grid(axis(5.97, 11.52, 5), axis(0.75, 14.25, 9), heights, None, None).expect("a full grid");
    let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let mut spec = FitSpec::new(model);
    change(&mut spec);
    bencher.bench_local(|| fit(divan::black_box(&nodes), &spec));
}

fn predict(at: Places, kinds: Kinds) -> Option<Predict> {
    Some(Predict { at, level: None, kinds, slopes: false })
}

const SIMULTANEOUS: Kinds = Kinds { confidence: false, prediction: false, simultaneous: true };

#[divan::bench]
fn default(bencher: Bencher) {
    run(bencher, |_| {});
}

#[divan::bench]
fn norm_limit_told(bencher: Bencher) {
    run(bencher, |spec| spec.coefficient_norm_limit = Some(100.0));
}

#[divan::bench]
fn covariance(bencher: Bencher) {
    run(bencher, |spec| spec.include = Include { covariance: true, ..Include::default() });
}

#[divan::bench]
fn predicted_mse(bencher: Bencher) {
    run(bencher, |spec| spec.include = Include { predicted_mse: true, ..Include::default() });
}

#[divan::bench(args = [10, 100])]
fn confidence_on_a_grid(bencher: Bencher, each: usize) {
    let at = Places::Grid { u: axis(5.97, 11.52, each), v: axis(0.75, 14.25, each) };
    run(bencher, |spec| spec.predict = predict(at.clone(), Kinds::default()));
}

#[divan::bench]
fn simultaneous_band(bencher: Bencher) {
    let at = Places::Grid { u: axis(5.97, 11.52, 10), v: axis(0.75, 14.25, 10) };
    run(bencher, |spec| spec.predict = predict(at.clone(), SIMULTANEOUS));
}

/// The flank has to bend along both axes; the plain one does not quite.
#[divan::bench]
fn constrained(bencher: Bencher) {
    let bent = |along| Constraint { kind: ConstraintKind::Concave, along: Some(along), domain: None };
    run(bencher, |spec| {
        spec.model =
            Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
        spec.regularization = Regularization::None;
        spec.constraints = vec![bent(FilterAxis::U), bent(FilterAxis::V)];
    });
}

/// A surface of so many spans each way that has to rise, near 40 × 40 nodes.
#[divan::bench(args = [4, 16])]
fn constrained_spline(bencher: Bencher, spans: usize) {
    let (u, v) = (axis(5.97, 11.52, 40), axis(0.75, 14.25, 40));
    let heights = places(40, 40).iter().map(|[u, v]| height(*u, *v) + 2.0 * u).collect();
    let nodes = Nodes::grid(u, v, heights, None, None).expect("a full grid");
    let spec = FitSpec {
        regularization: Regularization::None,
        constraints: vec![Constraint { kind: ConstraintKind::Increasing, along: Some(FilterAxis::U), domain: None }],
        ..FitSpec::new(Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(spans), weights: None })
    };
    bencher.bench_local(|| fit(divan::black_box(&nodes), &spec));
}

/// A flank grid of 225 nodes whose errors are as `change` says; `errors_independent` is there to
/// compare with.
fn run_errors(bencher: Bencher, change: impl Fn(&mut FitSpec)) {
    let heights = places(15, 15).iter().map(|[u, v]| height(*u, *v)).collect();
    let nodes = Nodes::grid(axis(5.97, 11.52, 15), axis(0.75, 14.25, 15), heights, None, None).expect("a full grid");
    let model = Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Legendre, terms: Terms::Tensor };
    let mut spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
    change(&mut spec);
    assert!(fit(&nodes, &spec).is_ok());
    bencher.bench_local(|| fit(divan::black_box(&nodes), &spec));
}

fn along_lines(correlation: Correlation) -> Option<Errors> {
    Some(Errors { correlation, along: Along::V, lines: None })
}

#[divan::bench]
fn errors_independent(bencher: Bencher) {
    run_errors(bencher, |_| {});
}

#[divan::bench]
fn errors_ar1(bencher: Bencher) {
    run_errors(bencher, |spec| spec.errors = along_lines(Correlation::Ar1 { rho: None }));
}

#[divan::bench]
fn errors_ar1_told(bencher: Bencher) {
    run_errors(bencher, |spec| spec.errors = along_lines(Correlation::Ar1 { rho: Some(0.6) }));
}

#[divan::bench]
fn errors_ar2(bencher: Bencher) {
    run_errors(bencher, |spec| spec.errors = along_lines(Correlation::Ar2 { phi: None }));
}

#[divan::bench]
fn errors_matern(bencher: Bencher) {
    run_errors(bencher, |spec| spec.errors = along_lines(Correlation::Matern { parameters: None }));
}

#[divan::bench]
fn variance_hc3(bencher: Bencher) {
    run_errors(bencher, |spec| spec.variance = Variance::Hc3);
}

#[divan::bench]
fn variance_groups(bencher: Bencher) {
    run_errors(bencher, |spec| spec.variance = Variance::Groups((0..225).map(|k| k / 75).collect()));
}

#[divan::bench]
fn variance_power(bencher: Bencher) {
    run_errors(bencher, |spec| spec.variance = Variance::Power { of: Along::U, exponent: None });
}

#[divan::bench(args = ["measured", "nominal"])]
fn positions(bencher: Bencher, kind: &str) {
    let kind = Some(if kind == "measured" { PositionKind::Measured } else { PositionKind::Nominal });
    let node_uncertainty = Some(NodeUncertainty { position: 0.05, height: 0.3, kind });
    run_errors(bencher, |spec| spec.node_uncertainty = node_uncertainty);
}

#[divan::bench(args = [10, 1000])]
fn rows_of_a_matrix(bencher: Bencher, rows: usize) {
    let row = |[u, v]: [f64; 2]| (0..9).map(|k| u.powi(k / 3) * v.powi(k % 3)).collect::<Vec<f64>>();
    let x: Vec<f64> = places(5, 9).into_iter().flat_map(row).collect();
    let heights = places(5, 9).iter().map(|[u, v]| height(*u, *v)).collect();
    let nodes = Nodes::matrix(x, 9, heights, None, None).expect("rows of nine columns");
    let at = Places::Rows(places(rows / 5, 5).into_iter().map(row).collect());
    let spec = FitSpec {
        predict: predict(at, Kinds { simultaneous: true, ..Kinds::default() }),
        ..FitSpec::new(Model::Linear)
    };
    bencher.bench_local(|| fit(divan::black_box(&nodes), &spec));
}
