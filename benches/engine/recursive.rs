//! Nodes one by one: `cargo xtask bench recursive`. What is timed is one node added to an
//! estimate that has seen 100 or 10,000 (the cost must not grow with them), and one look at its
//! result.

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, Recursive,
    spec::{Degree, Domain, Model, PolynomialBasis, Terms},
};

const DEGREES: [usize; 4] = [2, 3, 5, 9];

fn node(i: usize) -> Nodes {
    // irrational steps: no place comes twice
    let t = i as f64;
    let (u, v) = (30.0 + 4.0 * (0.754_877_666 * t).fract(), 20.0 * (0.569_840_291 * t).fract());
    let z = 0.01 * u - 0.002 * v + 1e-3 * (3.0 * u + v).sin();
    Nodes::scattered(vec![u], vec![v], vec![z], None).expect("a node")
}

fn estimate(degree: usize, seen: usize) -> Recursive {
    let (basis, terms) = (PolynomialBasis::Monomial, Terms::Tensor);
    let mut spec = FitSpec::new(Model::Polynomial { degree: Degree::Both(degree), basis, terms });
    spec.domain = Some(Domain { u: Some([30.0, 34.0]), v: Some([0.0, 20.0]) });
    let mut estimate = Recursive::new(&spec, 1.0).expect("a spec for streams");
    (0..seen).for_each(|i| estimate.push(&node(i)).expect("a node"));
    estimate
}

#[divan::bench(args = DEGREES, consts = [100, 10_000])]
fn one_node<const SEEN: usize>(bencher: Bencher, degree: usize) {
    let estimate = estimate(degree, SEEN);
    let next = node(SEEN);
    bencher.with_inputs(|| estimate.clone()).bench_values(|mut estimate| {
        estimate.push(&next).expect("a node");
        estimate
    });
}

#[divan::bench(args = [2, 3, 5])]
fn one_result(bencher: Bencher, degree: usize) {
    let estimate = estimate(degree, 200);
    bencher.bench(|| estimate.result().expect("a fit"));
}
