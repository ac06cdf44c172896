//! Filters and the fit behind them: `cargo xtask bench filters`. What is timed is one whole fit
//! with one filter, hence also the filtered columns whose collinearity is reported.

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Action, Degree, Filter, FilterAxis, Gaussian, Hampel, Model, Order, PolynomialBasis, Spline, Terms},
};

/// Places along u and v.
const SHAPES: [(usize, usize); 3] = [(9, 15), (40, 60), (200, 200)];
const NAMES: [&str; 5] = ["none", "hampel", "gaussian", "robust", "spline"];

fn filter(name: &str) -> Option<Filter> {
    let axis = Some(FilterAxis::V);
    match name {
        "hampel" => Some(Filter::Hampel(Hampel { window: 5, threshold: 3.0, action: Action::Replace, axis: None })),
        "gaussian" => Some(Filter::Gaussian(Gaussian { axis, cutoff: 3.0, robust: None })),
        "robust" => Some(Filter::Gaussian(Gaussian { axis, cutoff: 3.0, robust: Some(Order::Two) })),
        "spline" => Some(Filter::Spline(Spline { axis, cutoff: 3.0 })),
        _ => None,
    }
}

/// A flank in mm with a ripple and a peak at every 37th node.
fn grid((nu, nv): (usize, usize)) -> Nodes {
    let axis = |from: f64, to: f64, n: usize| (0..n).map(move |i| from + (to - from) * i as f64 / (n - 1) as f64);
    let (u, v): (Vec<f64>, Vec<f64>) = (axis(6.0, 11.5, nu).collect(), axis(0.75, 14.25, nv).collect());
    let z = (0..nu * nv)
        .map(|i| {
            let (s, t) = ((u[i / nv] - 8.75) / 2.75, (v[i % nv] - 7.5) / 6.75);
            let peak = if i % 37 == 0 { 12.0 } else { 0.0 };
            4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.3 * (11.0 * i as f64).sin() + peak
        })
        .collect();
    Nodes::grid(u, v, z, None, None).expect("a full grid is valid")
}

#[divan::bench(args = NAMES, consts = [0, 1, 2], max_time = 3)]
fn fit_of_a_grid<const SHAPE: usize>(bencher: Bencher, name: &str) {
    let nodes = grid(SHAPES[SHAPE]);
    let model = Model::Polynomial { degree: Degree::Both(3), basis: PolynomialBasis::Monomial, terms: Terms::Tensor };
    let spec = FitSpec { filters: filter(name).into_iter().collect(), ..FitSpec::new(model) };
    fit(&nodes, &spec).expect("the case is well posed");
    bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
}
