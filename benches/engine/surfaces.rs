//! Surfaces: `cargo xtask bench surfaces`. A million places of a bicubic surface, least squares
//! on 100 × 100 nodes, closest points, sections by planes.

use divan::{Bencher, counter::ItemsCount};
use flankfit_engine::geometry::{
    BSplineBasis,
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, ClosestPoint, Evaluator, NodeGrid, SurfaceShape,
        interpolate::interpolate,
        least_squares::{AxisKnots, least_squares},
        section::{Description, Plane, Sections},
    },
};

const PLACES: usize = 1_000_000;

fn height(u: f64, v: f64) -> f64 {
    (6.0 * u).sin() * (3.6 * v).cos() + 0.6 * u
}

/// A bicubic surface of `spans` × `spans` spans over the unit square.
fn surface(spans: usize, dimension: Dimension) -> SurfaceShape {
    let basis = BSplineBasis::uniform(3, spans, 0.0, 1.0).expect("a basis");
    let n = basis.size();
    let place = |k: usize| ((k / n) as f64 / (n - 1) as f64, (k % n) as f64 / (n - 1) as f64);
    let point = |(u, v): (f64, f64)| match dimension {
        Dimension::Graph => Vector::new(height(u, v), 0.0, 0.0),
        _ => Vector::new(u, v, height(u, v)),
    };
    let points = (0..n * n).map(|k| point(place(k))).collect();
    SurfaceShape::BSpline(BSplineSurface::new([basis.clone(), basis], dimension, points, None).expect("a surface"))
}

/// Places in no order, the same in every run.
fn places(n: usize) -> Vec<[f64; 2]> {
    let mut state = 88_172_645_463_325_252u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n).map(|_| [next(), next()]).collect()
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn a_million_heights(bencher: Bencher) {
    let (shape, at) = (surface(97, Dimension::Graph), places(PLACES));
    bencher.counter(ItemsCount::new(PLACES)).bench_local(|| Evaluator::new(&shape).heights(divan::black_box(&at)));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn a_million_points(bencher: Bencher) {
    let (shape, at) = (surface(40, Dimension::Space), places(PLACES));
    bencher.counter(ItemsCount::new(PLACES)).bench_local(|| Evaluator::new(&shape).values(divan::black_box(&at)));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn a_million_jets(bencher: Bencher) {
    let (shape, at) = (surface(40, Dimension::Space), places(PLACES));
    bencher.counter(ItemsCount::new(PLACES)).bench_local(|| Evaluator::new(&shape).jets(divan::black_box(&at)));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn heights_on_a_grid_of_a_thousand_squared(bencher: Bencher) {
    let shape = surface(97, Dimension::Graph);
    let axis: Vec<f64> = (0..1000).map(|k| f64::from(k) / 999.0).collect();
    bencher
        .counter(ItemsCount::new(PLACES))
        .bench_local(|| Evaluator::new(&shape).grid_heights(&axis, divan::black_box(&axis)));
}

/// 100 × 100 nodes.
fn nodes() -> NodeGrid {
    let axis: Vec<f64> = (0..100).map(|k| f64::from(k) / 99.0).collect();
    let z: Vec<f64> = axis.iter().flat_map(|u| axis.iter().map(|v| height(*u, *v))).collect();
    NodeGrid::heights(axis.clone(), axis, &z).expect("a grid")
}

#[divan::bench(args = [10, 20, 40], sample_count = 200)]
fn bicubic_least_squares(bencher: Bencher, spans: usize) {
    let grid = nodes();
    let knots = || [AxisKnots::Uniform(spans), AxisKnots::Uniform(spans)];
    bencher.bench_local(|| least_squares(divan::black_box(&grid), [3, 3], knots()));
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn bicubic_interpolation(bencher: Bencher) {
    let grid = nodes();
    bencher.bench_local(|| interpolate(divan::black_box(&grid), [3, 3], [None, None]));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn a_thousand_closest_points(bencher: Bencher) {
    let shape = surface(20, Dimension::Space);
    let closest = ClosestPoint::on(&shape);
    let nodes: Vec<Vector> = places(1000).iter().map(|[u, v]| Vector::new(*u, *v, height(*u, *v) + 0.1)).collect();
    bencher.counter(ItemsCount::new(nodes.len())).bench_local(|| closest.to_each(divan::black_box(&nodes)));
}

#[divan::bench(args = [1, 20], sample_count = 20)]
fn sections_by_fifty_planes(bencher: Bencher, spans: usize) {
    let shape = surface(spans, Dimension::Space);
    let how = Description { tolerance: 1e-9, chords: false, most: 1_000_000 };
    bencher.bench_local(|| {
        let sections = Sections::of(divan::black_box(&shape));
        let by = |k: u32| sections.by(&Plane { normal: Vector::x(), offset: (f64::from(k) + 0.5) / 50.0 }, how);
        (0..50).map(by).collect::<Result<Vec<_>, _>>()
    });
}
