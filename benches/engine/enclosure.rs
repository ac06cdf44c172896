//! Fits with and without proved intervals: `cargo xtask bench enclosure`.

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Include, Model, PolynomialBasis},
};

use super::fit::{grid, scattered, spec};

const CASES: [&str; 7] = [
    "grid of 45, (2,2)",
    "grid of 1,000, (3,3)",
    "grid of 10,000, (3,3)",
    "scattered 45, (2,2)",
    "scattered 1,000, (3,3)",
    "scattered 10,000, (3,3)",
    "matrix of 45 rows, 9 columns, condition 1e9",
];

/// Raw powers of u and v as posted columns.
fn matrix() -> Nodes {
    let Nodes::Grid(grid) = grid((5, 9)) else { unreachable!("a grid") };
    let places = grid.u().iter().flat_map(|&u| grid.v().iter().map(move |&v| [u, v]));
    let x = places.flat_map(|[u, v]| (0..9).map(move |k| u.powi(k / 3) * v.powi(k % 3))).collect();
    Nodes::matrix(x, 9, grid.z().to_vec(), None, None).expect("rows of nine columns")
}

fn run(bencher: Bencher, case: &str, enclosure: bool) {
    let polynomial = |degree: usize| spec(degree, PolynomialBasis::Monomial);
    let (nodes, plain) = match case {
        "grid of 45, (2,2)" => (grid((5, 9)), polynomial(2)),
        "grid of 1,000, (3,3)" => (grid((25, 40)), polynomial(3)),
        "grid of 10,000, (3,3)" => (grid((100, 100)), polynomial(3)),
        "scattered 45, (2,2)" => (scattered((5, 9)), polynomial(2)),
        "scattered 1,000, (3,3)" => (scattered((25, 40)), polynomial(3)),
        "scattered 10,000, (3,3)" => (scattered((100, 100)), polynomial(3)),
        _ => (matrix(), FitSpec::new(Model::Linear)),
    };
    let spec = FitSpec { include: Include { enclosure, ..Include::default() }, ..plain };
    let found = fit(&nodes, &spec).expect("the case is well posed");
    assert_eq!(found.numerics.enclosure.is_some(), enclosure);
    bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
}

#[divan::bench(args = CASES)]
fn plain(bencher: Bencher, case: &str) {
    run(bencher, case, false);
}

#[divan::bench(args = CASES)]
fn enclosed(bencher: Bencher, case: &str) {
    run(bencher, case, true);
}
