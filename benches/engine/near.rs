//! Curves and surfaces near points: `cargo xtask bench near`.
//!
//! The big surface is the one that the limits were made for: 1,000,000 scattered nodes, 40 × 40
//! spans, bicubic (1,849 coefficients).

use divan::{Bencher, black_box};
use flankfit_engine::estimation::{
    near::{
        Adaptive, CurvePoints, CurveSettings, KnotPlacement, Parameters, SurfaceInclude, SurfacePoints, curve, surface,
    },
    smoothing::{
        Smoothing, smoothing_spline,
        spline::{Points, SmoothingSpec},
    },
    spec::{Criterion, Degree, FitSpec, Knots, Model, Parameter, Regularization, Tikhonov},
};

/// Numbers in [0, 1) that look random and are the same on every machine.
fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| next()).collect()
}

struct Flank {
    u: Vec<f64>,
    v: Vec<f64>,
    coordinates: Vec<Vec<f64>>,
}

fn flank(count: usize, coordinates: usize) -> Flank {
    let (u, v, e) = (noise(count, 1), noise(count, 2), noise(count, 3));
    let height =
        |c: usize, k: usize| ((5.0 + c as f64) * u[k]).sin() * (4.0 * v[k]).cos() + 0.01 * (e[(k + c) % count] - 0.5);
    let coordinates = (0..coordinates).map(|c| (0..count).map(|k| height(c, k)).collect()).collect();
    Flank { u, v, coordinates }
}

fn spec(spans: usize, regularization: Regularization) -> FitSpec {
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(spans), weights: None };
    FitSpec { regularization, ..FitSpec::new(model) }
}

fn run(bencher: Bencher, flank: &Flank, spec: &FitSpec, include: SurfaceInclude) {
    let points = SurfacePoints { u: &flank.u, v: &flank.v, coordinates: &flank.coordinates, weight: None };
    surface(&points, spec, include).expect("the case is well posed");
    bencher.bench_local(|| surface(black_box(&points), black_box(spec), include));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn million_nodes(bencher: Bencher) {
    run(bencher, &flank(1_000_000, 1), &spec(40, Regularization::None), SurfaceInclude::default());
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn million_nodes_with_standard_errors(bencher: Bencher) {
    let include = SurfaceInclude { standard_errors: true, residuals: false };
    run(bencher, &flank(1_000_000, 1), &spec(40, Regularization::None), include);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn million_nodes_in_space(bencher: Bencher) {
    run(bencher, &flank(1_000_000, 3), &spec(40, Regularization::None), SurfaceInclude::default());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn million_nodes_smoothed_by_gcv(bencher: Bencher) {
    let parameter = Parameter::Criterion(Criterion::Gcv);
    let smooth = Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter });
    run(bencher, &flank(1_000_000, 1), &spec(40, smooth), SurfaceInclude::default());
}

#[divan::bench(args = ["fixed", "gcv"], sample_count = 5, sample_size = 1)]
fn smoothing_spline_of_100_000_points(bencher: Bencher, kind: &str) {
    let e = noise(100_000, 4);
    let x: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 1e-5).collect();
    let y = [x.iter().zip(&e).map(|(x, e)| (9.0 * x).sin() + 0.1 * (e - 0.5)).collect::<Vec<f64>>()];
    let parameter = if kind == "gcv" { Parameter::Criterion(Criterion::Gcv) } else { Parameter::Fixed(1e-3) };
    let asked = SmoothingSpec { smoothing: Smoothing::Parameter(parameter), noise_sigma: None, pointwise: false };
    let points = Points { x: &x, coordinates: &y, weight: None };
    smoothing_spline(&points, &asked).expect("the case is well posed");
    bencher.bench_local(|| smoothing_spline(black_box(&points), black_box(&asked)));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn knots_placed_by_residuals(bencher: Bencher) {
    let x: Vec<f64> = (0..500).map(|i| f64::from(i) / 499.0).collect();
    let y = [x.iter().map(|x| (30.0 * (x - 0.4)).tanh()).collect::<Vec<f64>>()];
    let adaptive = Adaptive { spans: 2, tolerance: 1e-4, most_controls: 100 };
    let asked = CurveSettings {
        degree: 3,
        knots: KnotPlacement::Adaptive(adaptive),
        weights: None,
        spec: FitSpec { regularization: Regularization::None, ..FitSpec::new(Model::Linear) },
    };
    let points = CurvePoints { coordinates: &y, parameters: Parameters::Given(&x), weight: None };
    curve(&points, &asked).expect("the case is well posed");
    bencher.bench_local(|| curve(black_box(&points), black_box(&asked)));
}
