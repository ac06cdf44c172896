//! The engine alone: `cargo xtask bench fit`. Nodes are made once; what is timed is one call of
//! `fit` with the defaults of the contract, hence with the spectrum, every criterion's λ*, bounds
//! and collinearity.

use divan::Bencher;
use flankfit_engine::estimation::{
    FitSpec, Nodes, fit,
    spec::{Degree, Model, PolynomialBasis, Terms},
};

/// Nodes along u and v: 45, 1,000, 10,000 and 1,000,000 of them.
const SHAPES: [(usize, usize); 4] = [(5, 9), (25, 40), (100, 100), (1000, 1000)];
const DEGREES: [usize; 3] = [2, 3, 5];

/// All of them but 45 nodes at (5,5): five rows do not determine degree 5.
static CASES: [((usize, usize), usize); 11] = {
    let mut cases = [((0, 0), 0); 11];
    let (mut i, mut filled) = (0, 0);
    while i < SHAPES.len() * DEGREES.len() {
        let (shape, degree) = (SHAPES[i / DEGREES.len()], DEGREES[i % DEGREES.len()]);
        if shape.0 > degree {
            cases[filled] = (shape, degree);
            filled += 1;
        }
        i += 1;
    }
    cases
};

/// A case that prints itself.
#[derive(Clone, Copy)]
struct Case(&'static ((usize, usize), usize));

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ((nu, nv), degree) = self.0;
        write!(f, "{} nodes, degree ({degree},{degree})", nu * nv)
    }
}

/// A flank in mm: roll length and face width, heights of a few micrometres with a ripple that no
/// polynomial follows.
fn axes((nu, nv): (usize, usize)) -> (Vec<f64>, Vec<f64>) {
    let axis = |from: f64, to: f64, n: usize| (0..n).map(|i| from + (to - from) * i as f64 / (n - 1) as f64).collect();
    (axis(5.97, 11.52, nu), axis(0.75, 14.25, nv))
}

fn height(u: f64, v: f64) -> f64 {
    let (s, t) = ((u - 8.745) / 2.775, (v - 7.5) / 6.75);
    4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.75 * s * t + 0.3 * (37.0 * u + 19.0 * v).sin()
}

pub(super) fn grid(shape: (usize, usize)) -> Nodes {
    let (u, v) = axes(shape);
    let z = u.iter().flat_map(|&u| v.iter().map(move |&v| height(u, v))).collect();
    Nodes::grid(u, v, z, None, None).expect("a full grid is valid")
}

/// The same number of nodes, none of them on a common line.
pub(super) fn scattered(shape: (usize, usize)) -> Nodes {
    let (u, v) = axes(shape);
    let (du, dv) = (u[1] - u[0], v[1] - v[0]);
    let mut nodes = (Vec::new(), Vec::new(), Vec::new());
    for (i, &u) in u.iter().enumerate() {
        for (j, &v) in v.iter().enumerate() {
            let u = u + 0.4 * du * (13.0 * i as f64 + 7.0 * j as f64).sin();
            let v = v + 0.4 * dv * (5.0 * i as f64 - 11.0 * j as f64).cos();
            nodes.0.push(u);
            nodes.1.push(v);
            nodes.2.push(height(u, v));
        }
    }
    Nodes::scattered(nodes.0, nodes.1, nodes.2, None).expect("finite nodes are valid")
}

pub(super) fn spec(degree: usize, basis: PolynomialBasis) -> FitSpec {
    FitSpec::new(Model::Polynomial { degree: Degree::Both(degree), basis, terms: Terms::Tensor })
}

fn run(bencher: Bencher, nodes: Nodes, degree: usize, basis: PolynomialBasis) {
    let spec = spec(degree, basis);
    fit(&nodes, &spec).expect("the case is well posed");
    bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
}

/// Raw powers of the caller's u and v: the default, and the hard case.
#[divan::bench_group(max_time = 5)]
mod monomial {
    use super::*;

    #[divan::bench(args = CASES.iter().map(Case))]
    fn on_a_grid(bencher: Bencher, case: Case) {
        let (shape, degree) = *case.0;
        run(bencher, grid(shape), degree, PolynomialBasis::Monomial);
    }

    #[divan::bench(args = CASES.iter().map(Case))]
    fn scattered_nodes(bencher: Bencher, case: Case) {
        let (shape, degree) = *case.0;
        run(bencher, scattered(shape), degree, PolynomialBasis::Monomial);
    }
}

/// Orthogonal polynomials on the mapped domain: the easy case.
#[divan::bench_group(max_time = 5)]
mod chebyshev {
    use super::*;

    #[divan::bench(args = CASES.iter().map(Case))]
    fn on_a_grid(bencher: Bencher, case: Case) {
        let (shape, degree) = *case.0;
        run(bencher, grid(shape), degree, PolynomialBasis::Chebyshev);
    }

    #[divan::bench(args = CASES.iter().map(Case))]
    fn scattered_nodes(bencher: Bencher, case: Case) {
        let (shape, degree) = *case.0;
        run(bencher, scattered(shape), degree, PolynomialBasis::Chebyshev);
    }
}

/// Fit with the influence of each node.
#[divan::bench_group(max_time = 5)]
mod influence {
    use super::*;
    use flankfit_engine::estimation::spec::Include;

    #[divan::bench(args = CASES.iter().filter(|((shape, _), _)| *shape <= 100).map(Case))]
    fn on_a_grid(bencher: Bencher, case: Case) {
        let (shape, degree) = *case.0;
        let (nodes, spec) = (grid(shape), spec(degree, PolynomialBasis::Monomial));
        let spec = FitSpec { include: Include { influence: true, ..Include::default() }, ..spec };
        fit(&nodes, &spec).expect("the case is well posed");
        bencher.bench_local(|| fit(divan::black_box(&nodes), divan::black_box(&spec)));
    }
}
