//! The regularised estimators: `cargo xtask bench regularization`. One call of `fit` each, on the
//! same flank, so that what differs is the regularisation; the default (spectral, min_mse) is the
//! yardstick.

use std::sync::Arc;

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{
        Attraction, Candidates, Chain, Criterion, Degree, Earlier, JamesStein, Knots, Model, ModelCriterion, Moves,
        Parameter, PolynomialBasis, Prior, Regularization, Select, ShrinkageFactor, TermSearch, Terms, Tikhonov, Which,
    },
};

/// 40 × 25 nodes of a flank in mm, heights of a few micrometres with a ripple that no polynomial
/// follows.
fn nodes() -> Nodes {
    let axis = |from: f64, to: f64, n: usize| -> Vec<f64> {
        (0..n).map(|i| from + (to - from) * i as f64 / (n - 1) as f64).collect()
    };
    let (u, v) = (axis(5.97, 11.52, 40), axis(0.75, 14.25, 25));
    let height = |u: f64, v: f64| {
        let (s, t) = ((u - 8.745) / 2.775, (v - 7.5) / 6.75);
        4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.75 * s * t + 0.3 * (37.0 * u + 19.0 * v).sin()
    };
    let z = u.iter().flat_map(|&u| v.iter().map(move |&v| height(u, v))).collect();
    Nodes::grid(u, v, z, None, None).expect("a full grid is valid")
}

fn kinds(n: usize) -> [(&'static str, Regularization); 11] {
    let by = Parameter::Criterion;
    [
        ("spectral", Regularization::default()),
        ("ridge", Regularization::Ridge { parameter: by(Criterion::MinMse) }),
        ("ridge_reml", Regularization::Ridge { parameter: by(Criterion::Reml) }),
        ("ridge_sure", Regularization::Ridge { parameter: by(Criterion::Sure) }),
        ("ridge_press", Regularization::Ridge { parameter: by(Criterion::Press) }),
        ("ridge_blocked_cv", Regularization::Ridge { parameter: by(Criterion::BlockedCv) }),
        ("truncated_svd", Regularization::TruncatedSvd { rank: n - 2 }),
        ("truncated_svd_gcv", Regularization::TruncatedSvdBy { criterion: Criterion::Gcv }),
        (
            "james_stein",
            Regularization::JamesStein(JamesStein {
                factor: ShrinkageFactor::JamesStein,
                positive_part: true,
                target: None,
            }),
        ),
        (
            "attraction",
            Regularization::Attraction(Attraction { target: vec![0.0; n], parameter: by(Criterion::Optimal) }),
        ),
        ("tikhonov", Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter: by(Criterion::MinMse) })),
    ]
}

const NAMES: [&str; 11] = [
    "spectral",
    "ridge",
    "ridge_reml",
    "ridge_sure",
    "ridge_press",
    "ridge_blocked_cv",
    "truncated_svd",
    "truncated_svd_gcv",
    "james_stein",
    "attraction",
    "tikhonov",
];

fn run(bencher: Bencher, model: Model, n: usize, name: &str) {
    let (_, regularization) = kinds(n).into_iter().find(|(kind, _)| *kind == name).expect("a kind");
    let (nodes, spec) = (nodes(), FitSpec { regularization, ..FitSpec::new(model) });
    fit(&nodes, &spec).expect("the case is well posed");
    bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
}

/// 16 raw monomials.
#[divan::bench(args = NAMES, max_time = 3)]
fn cubic(bencher: Bencher, name: &str) {
    let (basis, terms) = (PolynomialBasis::Monomial, Terms::Tensor);
    run(bencher, Model::Polynomial { degree: Degree::Both(3), basis, terms }, 16, name);
}

/// 64 B-splines.
#[divan::bench(args = NAMES, max_time = 3)]
fn splines(bencher: Bencher, name: &str) {
    run(bencher, Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(5), weights: None }, 64, name);
}

/// 225 B-splines.
#[divan::bench(args = ["spectral", "tikhonov"], max_time = 6, sample_count = 3, sample_size = 1)]
fn many_splines(bencher: Bencher, name: &str) {
    run(bencher, Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(12), weights: None }, 225, name);
}

/// A model out of several: 16 by their degrees, 16 on the way of backward elimination, and those of
/// the path of the elastic net with its ten folds.
#[divan::bench(args = ["degrees", "backward", "elastic_net"], max_time = 3)]
fn select(bencher: Bencher, name: &str) {
    let (basis, terms) = (PolynomialBasis::Monomial, Terms::Tensor);
    let candidates = match name {
        "degrees" => Candidates::Degrees(Degree::Both(3)),
        "backward" => Candidates::Terms(TermSearch::Backward),
        _ => Candidates::Terms(TermSearch::ElasticNet { alpha: 0.5 }),
    };
    let spec = FitSpec {
        regularization: Regularization::None,
        select: Some(Select::new(candidates, ModelCriterion::Bic)),
        ..FitSpec::new(Model::Polynomial { degree: Degree::Both(3), basis, terms })
    };
    let nodes = nodes();
    fit(&nodes, &spec).expect("the case is well posed");
    bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
}

/// 9 coefficients with the prior of so many earlier iterations over the same nodes, their moves
/// estimated.
#[divan::bench(args = [1, 5, 20], max_time = 3)]
fn prior(bencher: Bencher, iterations: u32) {
    let (basis, terms) = (PolynomialBasis::Chebyshev, Terms::Tensor);
    let nodes = nodes();
    let of =
        |number| Earlier { number, fit_id: String::new(), nodes: Arc::new(nodes.clone()), corrections: Vec::new() };
    let earlier = Some((1..=iterations).map(of).collect());
    let chain = Chain { which: Which::Previous, moves: Moves::Estimated, correction: true, earlier };
    let spec = FitSpec {
        regularization: Regularization::None,
        prior: Some(Prior::Iterations(chain)),
        ..FitSpec::new(Model::Polynomial { degree: Degree::Both(2), basis, terms })
    };
    fit(&nodes, &spec).expect("the case is well posed");
    bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
}
