//! One row for each kind of work: a digest of every digit of the results and, where it may take
//! seconds, the median of its time. `cargo xtask portability` compares the digests of a build with
//! the workspace's flags and of one without; docs/reference/performance.md has a table of both
//! times.
//!
//! Run: `cargo run --release -p engine-benches --example portable [SECONDS]`

use std::{
    fmt::Debug,
    hint::black_box,
    time::{Duration, Instant},
};

use flankfit_engine::{
    estimation::{
        FitSpec, Nodes, Recursive, fit,
        near::{SurfaceInclude, SurfacePoints, surface},
        smoothing::{
            Smoothing, smoothing_spline,
            spline::{Points, SmoothingSpec},
        },
        spec::{
            Criterion, Degree, Domain, Estimator, Knots, Loss, MEstimator, Model, Parameter, PolynomialBasis,
            Regularization, Terms, Tikhonov,
        },
    },
    gear::{
        Gear, GearData, Side,
        correction::{
            Correction, CorrectionSpec,
            machine::{FlankNode, Machine, Ranges},
        },
    },
};

fn height(u: f64, v: f64) -> f64 {
    let (s, t) = ((u - 8.745) / 2.775, (v - 7.5) / 6.75);
    4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.75 * s * t + 0.3 * (37.0 * u + 19.0 * v).sin()
}

fn axes((nu, nv): (usize, usize)) -> (Vec<f64>, Vec<f64>) {
    let axis = |from: f64, to: f64, n: usize| (0..n).map(|i| from + (to - from) * i as f64 / (n - 1) as f64).collect();
    (axis(5.97, 11.52, nu), axis(0.75, 14.25, nv))
}

fn grid(shape: (usize, usize)) -> Nodes {
    let (u, v) = axes(shape);
    let z = u.iter().flat_map(|&u| v.iter().map(move |&v| height(u, v))).collect();
    Nodes::grid(u, v, z, None, None).expect("a full grid")
}

/// Positions off every common line, with heights.
fn positions(count: usize) -> [Vec<f64>; 3] {
    let step = |from: f64, to: f64, by: f64| -> Vec<f64> {
        (0..count).map(|i| from + (to - from) * (by * i as f64).fract()).collect()
    };
    let (u, v) = (step(5.97, 11.52, 0.754_877_666), step(0.75, 14.25, 0.569_840_291));
    let z = u.iter().zip(&v).map(|(u, v)| height(*u, *v)).collect();
    [u, v, z]
}

fn scattered(count: usize) -> Nodes {
    let [u, v, z] = positions(count);
    Nodes::scattered(u, v, z, None).expect("finite nodes")
}

fn cubic() -> FitSpec {
    let (basis, terms) = (PolynomialBasis::Monomial, Terms::Tensor);
    FitSpec::new(Model::Polynomial { degree: Degree::Both(3), basis, terms })
}

fn splines(spans: usize, parameter: Parameter) -> FitSpec {
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(spans), weights: None };
    let regularization = Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter });
    FitSpec { regularization, ..FitSpec::new(model) }
}

/// An estimate that has seen so many nodes.
fn stream(seen: usize) -> Recursive {
    let mut spec = cubic();
    spec.domain = Some(Domain { u: Some([5.97, 11.52]), v: Some([0.75, 14.25]) });
    let mut estimate = Recursive::new(&spec, 1.0).expect("a spec for streams");
    estimate.push(&scattered(seen)).expect("nodes");
    estimate
}

fn correction() -> CorrectionSpec {
    let helix_angle = 15_f64.to_radians();
    let gear = Gear::new(GearData { helix_angle, face_width: Some(20.0), ..GearData::spur(52, 1.0) }).expect("a gear");
    let nodes: Vec<FlankNode> = (0..9)
        .flat_map(|i| (0..11).map(move |j| (8.5 + 0.25 * f64::from(i), 2.0 * f64::from(j))))
        .map(|(roll_length, z)| FlankNode { side: Side::Left, roll_length, z })
        .collect();
    let deviation = nodes.iter().map(|node| 3.0 * (node.roll_length - 9.5) + 0.2 * (node.z - 10.0)).collect();
    let ranges = Ranges { profile: [8.5, 10.5], helix: [0.0, 20.0] };
    let known = Machine::GeneratingGrinding.sensitivity(&gear, &nodes, ranges).expect("nodes on the flank");
    CorrectionSpec { noise_sigma: Some(0.3), ..CorrectionSpec::new(deviation, known.matrix, known.settings) }
}

/// FNV-1a of all digits: Rust writes the shortest number that reads back as the same bits.
fn digest(answer: &impl Debug) -> u64 {
    let text = format!("{answer:?}");
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

fn row<T: Debug>(limit: Duration, name: &str, work: impl Fn() -> T) {
    let first = digest(&work());
    let mut times = Vec::new();
    let begun = Instant::now();
    while begun.elapsed() < limit && times.len() < 100_000 {
        let start = Instant::now();
        black_box(work());
        times.push(start.elapsed());
    }
    times.sort_unstable();
    print!("{name:32} {first:016x}");
    match times.get(times.len() / 2) {
        Some(median) => println!(" {:12.1} µs", 1e6 * median.as_secs_f64()),
        None => println!(),
    }
}

fn main() {
    let seconds = std::env::args().nth(1).map_or(0.0, |text| text.parse().expect("a number of seconds"));
    let row_of = |name: &str, nodes: Nodes, spec: FitSpec| {
        row(Duration::from_secs_f64(seconds), name, || fit(black_box(&nodes), &spec).expect("a fit"));
    };
    let robust = |estimator| FitSpec { estimator, ..cubic() };
    row_of("fit, grid of 45", grid((5, 9)), cubic());
    row_of("fit, 45 scattered", scattered(45), cubic());
    row_of("fit, grid of 10,000", grid((100, 100)), cubic());
    row_of("fit, 10,000 scattered", scattered(10_000), cubic());
    row_of("Tukey, 1,000 nodes", grid((25, 40)), robust(Estimator::M(MEstimator::new(Loss::TUKEY))));
    row_of("least absolute, 1,000 nodes", grid((25, 40)), robust(Estimator::LeastAbsolute));
    row_of("Tikhonov, 64 B-splines", scattered(2_000), splines(5, Parameter::Criterion(Criterion::Gcv)));

    let limit = Duration::from_secs_f64(seconds);
    let [u, v, z] = positions(20_000);
    let points = SurfacePoints { u: &u, v: &v, coordinates: &[z], weight: None };
    let spec = splines(12, Parameter::Criterion(Criterion::Gcv));
    row(limit, "surface near 20,000 nodes", || surface(&points, &spec, SurfaceInclude::default()).expect("a surface"));

    let x: Vec<f64> = (0..2_000).map(|i| f64::from(i) * 5e-4).collect();
    let y = [x.iter().map(|x| (9.0 * x).sin() + 0.1 * (7919.0 * x).sin()).collect::<Vec<f64>>()];
    let smoothing = Smoothing::Parameter(Parameter::Criterion(Criterion::Gcv));
    let spec = SmoothingSpec { smoothing, noise_sigma: None, pointwise: false };
    let points = Points { x: &x, coordinates: &y, weight: None };
    row(limit, "smoothing spline, 2,000 points", || smoothing_spline(&points, &spec).expect("a spline"));

    let spec = correction();
    row(limit, "correction, 99 nodes", || {
        Correction::new(spec.clone()).expect("a correction").solve().expect("settings")
    });

    let (seen, block) = (stream(200), scattered(100));
    row(limit, "stream, 100 nodes more", || {
        let mut estimate = seen.clone();
        estimate.push(&block).expect("nodes");
        black_box(estimate);
    });
    row(limit, "stream, its result", || seen.result().expect("a fit"));
}
