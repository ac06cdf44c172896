//! Curves through points: `cargo xtask bench curves`. Construction with and without the figures
//! of stability, evaluation of a million places, closest points, arc length.

use divan::{Bencher, black_box, counter::ItemsCount};
use flankfit_engine::geometry::curve::{
    Closest, Curve, CurveShape, Ends, KnotChoice, Method, Parametrization, Points, Tangents, arc_length,
    construct::shape_through, measure::DEFAULT_TOLERANCE, through,
};
use flankfit_engine::geometry::space::{Dimension, Vector};

const METHODS: [&str; 6] = ["lagrange", "newton", "akima", "monotone", "cubic_spline", "b_spline"];
const PLACES: usize = 1_000_000;

fn method(name: &str) -> Method {
    match name {
        "lagrange" => Method::Lagrange,
        "newton" => Method::Newton,
        "akima" => Method::CubicHermite(Tangents::Akima),
        "monotone" => Method::CubicHermite(Tangents::Monotone),
        "cubic_spline" => Method::CubicSpline(Ends::not_a_knot()),
        _ => Method::BSpline { degree: 3, knots: KnotChoice::Averaging },
    }
}

/// A profile over `count` places.
fn graph(count: usize) -> Points {
    let x: Vec<f64> = (0..count).map(|i| i as f64 / count as f64).collect();
    let y = x.iter().map(|x| 3.0 * x * x + 0.1 * (25.0 * x).sin()).collect();
    Points::Graph { x, y }
}

/// Two turns of a helix.
fn helix(count: usize) -> CurveShape {
    let angle = |i: usize| 12.6 * i as f64 / count as f64;
    let points = (0..count).map(angle).map(|a| Vector::new(a.cos(), a.sin(), 0.1 * a)).collect();
    let points = Points::Space { points, dimension: Dimension::Space, parametrization: Parametrization::ChordLength };
    shape_through(&points, &method("b_spline")).expect("the points ascend").0
}

#[divan::bench(args = METHODS)]
fn through_20_points_with_stability(bencher: Bencher, name: &str) {
    let (points, method) = (graph(20), method(name));
    bencher.bench_local(|| through(black_box(&points), &method).expect("the points ascend"));
}

#[divan::bench(args = ["cubic_spline", "b_spline"], consts = [1_000, 100_000])]
fn curve_alone<const COUNT: usize>(bencher: Bencher, name: &str) {
    let (points, method) = (graph(COUNT), method(name));
    bencher.bench_local(|| shape_through(black_box(&points), &method).expect("the points ascend"));
}

#[divan::bench(args = METHODS, max_time = 3)]
fn a_million_values(bencher: Bencher, name: &str) {
    let shape = shape_through(&graph(20), &method(name)).expect("the points ascend").0;
    let [low, high] = shape.domain();
    bencher.counter(ItemsCount::new(PLACES)).bench_local(|| {
        let place = |i: usize| low + (high - low) * i as f64 / PLACES as f64;
        (0..PLACES).map(|i| shape.value(place(i)).x).sum::<f64>()
    });
}

#[divan::bench(args = METHODS, max_time = 3)]
fn a_million_jets(bencher: Bencher, name: &str) {
    let shape = shape_through(&graph(20), &method(name)).expect("the points ascend").0;
    let [low, high] = shape.domain();
    bencher.counter(ItemsCount::new(PLACES)).bench_local(|| {
        let place = |i: usize| low + (high - low) * i as f64 / PLACES as f64;
        (0..PLACES).map(|i| shape.jet(place(i))[2].x).sum::<f64>()
    });
}

#[divan::bench(args = [20, 1_000])]
fn a_thousand_closest_points(bencher: Bencher, count: usize) {
    let shape = helix(count);
    bencher.counter(ItemsCount::new(1_000usize)).bench_local(|| {
        let closest = Closest::on(&shape);
        let to = |i: usize| Vector::new((i as f64).sin(), (1.3 * i as f64).cos(), (0.7 * i as f64).sin());
        (0..1_000).map(|i| closest.to(to(i)).distance).sum::<f64>()
    });
}

#[divan::bench(args = [20, 1_000])]
fn length(bencher: Bencher, count: usize) {
    let shape = helix(count);
    let [low, high] = shape.domain();
    bencher.bench_local(|| arc_length(black_box(&shape), low, high, DEFAULT_TOLERANCE).expect("within the domain"));
}
