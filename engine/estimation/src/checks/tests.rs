//! The checks against dense matrices that are formed as they are defined.

use nalgebra::{DMatrix, DVector};

use super::{lack::lack, sites::Sites, variance::uneven};
use crate::{
    data::{Heights, Nodes, Sample},
    design::Design,
    factor::Factor,
    problem::{Evidence, LinearProblem},
    result::{LargerErrors, MissingShape},
    spec::{Along, Degree, FitSpec, Model, PolynomialBasis, Terms},
};
use flankfit_numerics::distribution::{fisher, normal, pearson};

/// Rows and columns of a grid without three nodes, and its places on [-1, 1]².
const SHAPE: [usize; 2] = [8, 6];
const MISSING: [usize; 3] = [0, 13, 40];

fn places() -> Vec<[f64; 2]> {
    let at = |i: usize, count: usize| 2.0 * i as f64 / (count - 1) as f64 - 1.0;
    (0..SHAPE[0] * SHAPE[1])
        .filter(|k| !MISSING.contains(k))
        .map(|k| [at(k / SHAPE[1], SHAPE[0]), at(k % SHAPE[1], SHAPE[1])])
        .collect()
}

/// A fixed sequence without any pattern.
fn noise(k: usize) -> f64 {
    let x = libm::sin(12.9898 * (k as f64 + 1.0)) * 43_758.547;
    x - x.floor() - 0.5
}

fn with_sites(height: impl Fn([f64; 2], f64) -> f64, test: impl FnOnce(&Sites, &[f64])) {
    let axis = |count: usize| (0..count).map(|i| 10.0 + 3.0 * i as f64).collect::<Vec<f64>>();
    let mut heights = places().into_iter().enumerate().map(|(k, place)| height(place, noise(k)));
    let z = (0..SHAPE[0] * SHAPE[1]).map(|k| if MISSING.contains(&k) { f64::NAN } else { heights.next().unwrap() });
    let nodes = Nodes::grid(axis(SHAPE[0]), axis(SHAPE[1]), z.collect(), None, None).unwrap();
    let (degree, basis) = (Degree::Each(2, 1), PolynomialBasis::Monomial);
    let spec = FitSpec::new(Model::Polynomial { degree, basis, terms: Terms::Tensor });
    let sample = Sample::new(&nodes);
    let design = Design::new(&nodes, &sample, &spec).unwrap();
    let factor = Factor::new(&design, &sample).unwrap();
    let evidence = Evidence::Posted { sample: &sample, nodes: &nodes };
    let heights = Heights::new(&sample).about_zero;
    let problem = LinearProblem { design: &design, factor: &factor, heights, evidence };
    let residuals = problem.of_image(&factor.qty, true).values.unwrap();
    test(&Sites::new(&problem, &sample, &nodes).unwrap(), &residuals);
}

fn powers(terms: &[(i32, i32)]) -> DMatrix<f64> {
    let places = places();
    DMatrix::from_fn(places.len(), terms.len(), |k, j| places[k][0].powi(terms[j].0) * places[k][1].powi(terms[j].1))
}

fn model() -> Vec<(i32, i32)> {
    (0..3).flat_map(|i| (0..2).map(move |j| (i, j))).collect()
}

/// I − X(XᵀX)⁻¹Xᵀ.
fn annihilator(x: &DMatrix<f64>) -> DMatrix<f64> {
    let inverse = (x.transpose() * x).try_inverse().unwrap();
    DMatrix::identity(x.nrows(), x.nrows()) - x * inverse * x.transpose()
}

#[test]
fn the_next_order_is_f_of_two_fits() {
    let bent = |[u, v]: [f64; 2], noise: f64| 3.0 + u * v + 0.8 * u.powi(3) + 0.9 * noise;
    with_sites(bent, |sites, residuals| {
        let terms = [model(), vec![(3, 0), (3, 1), (0, 2), (1, 2), (2, 2), (4, 0), (0, 3)]].concat();
        let z = DVector::from_vec(residuals.to_vec());
        let (small, large) = (z.norm_squared(), (annihilator(&powers(&terms)) * &z).norm_squared());
        let (more, freedom) = (7.0, (z.len() - terms.len()) as f64);
        let f = (small - large) / more / (large / freedom);
        let found = lack(sites, &sites.seen(residuals)).unwrap();
        assert_eq!(found.shape, MissingShape::NextOrder);
        assert!((found.p / fisher::upper_tail(f, more, freedom) - 1.0).abs() < 1e-9, "{}", found.p);
        let shape = small - large - more * large / freedom;
        assert!((found.rms - (shape / z.len() as f64).sqrt()).abs() < 1e-12);
    });
}

#[test]
fn traces_of_the_smooth_process_are_those_of_its_matrix() {
    with_sites(
        |_, noise| noise,
        |sites, residuals| {
            let places = places();
            let order = |x: f64, k: i32| {
                let product: f64 = (1..=k).map(f64::from).product();
                (-2.0 * x * x).exp() * (2.0 * x).powi(k) / product.sqrt()
            };
            let m = places.len();
            let mut kernel = DMatrix::zeros(m, m);
            for (i, j) in (0..6).flat_map(|i| (0..6 - i).map(move |j| (i, j))) {
                let column = DVector::from_fn(m, |k, _| order(places[k][0], i) * order(places[k][1], j));
                kernel += &column * column.transpose();
            }
            let projected = annihilator(&powers(&model())) * &kernel;
            let (t1, t2) = (projected.trace(), (&projected * &projected).trace());
            let gram = &sites.gram;
            assert!((gram.trace() / t1 - 1.0).abs() < 1e-10 && (gram.norm_squared() / t2 - 1.0).abs() < 1e-10);
            assert_eq!(sites.freedom(), (m - 6) as f64);
            let z = DVector::from_vec(residuals.to_vec());
            let score = z.dot(&(&kernel * &z));
            let found: f64 = sites.smooth.iter().map(|column| flankfit_numerics::dot(column, residuals).powi(2)).sum();
            assert!((found / score - 1.0).abs() < 1e-10, "{found} {score}");
        },
    );
}

#[test]
fn the_variance_is_a_slope_of_studentised_squares() {
    let rough = |[u, _]: [f64; 2], noise: f64| 2.0 + if u.abs() > 0.9 { 9.0 } else { 1.0 } * noise;
    with_sites(rough, |sites, residuals| {
        let left = annihilator(&powers(&model()));
        let count = residuals.len() as f64;
        let squares: Vec<f64> = residuals.iter().enumerate().map(|(k, r)| r * r / left[(k, k)]).collect();
        let mean = |x: &dyn Fn(usize) -> f64| (0..residuals.len()).map(x).sum::<f64>() / count;
        let places = places();
        let (level, size) = (mean(&|k| places[k][0].powi(2)), mean(&|k| squares[k]));
        let both = mean(&|k| (places[k][0].powi(2) - level) * (squares[k] - size));
        let (x, y) = (mean(&|k| (places[k][0].powi(2) - level).powi(2)), mean(&|k| (squares[k] - size).powi(2)));
        let t = both / (x * y).sqrt() * (count - 1.0).sqrt();
        let found = uneven(sites, &sites.seen(residuals), false).unwrap();
        assert_eq!((found.along, found.larger), (Along::U, LargerErrors::Ends));
        // for normal errors: traces of the dense matrices
        let d = |k: usize| (places[k][0].powi(2) - level) / left[(k, k)];
        let matrix = DMatrix::from_fn(residuals.len(), residuals.len(), |i, k| left[(i, k)] * d(k));
        let square = &matrix * &matrix;
        let traces = [matrix.trace(), square.trace(), (&square * &matrix).trace(), (&square * &square).trace()];
        let moments = pearson::Moments::of_ratio(traces, count - 6.0).unwrap();
        let ratio = mean(&|k| d(k) * residuals[k].powi(2)) / mean(&|k| residuals[k].powi(2));
        let tail = normal::upper_tail(t).max(pearson::upper_tail(ratio, &moments));
        assert!((found.p / (2.0 * tail / 0.4) - 1.0).abs() < 1e-7, "{}", found.p);
        // of the worst place, by the dense sandwich of variances on the regressor
        let hat = DMatrix::identity(residuals.len(), residuals.len()) - &left;
        let sigma = residuals.iter().map(|r| r * r).sum::<f64>() / (count - 6.0);
        let ratio = |j: usize| {
            let variance = |k: usize| (size + both / x * (places[k][0].powi(2) - level)).max(0.05 * size);
            let sum = |k: usize| hat[(j, k)].powi(2) * variance(k);
            (0..residuals.len()).map(sum).sum::<f64>() / (sigma * hat[(j, j)])
        };
        let worst = (0..residuals.len()).map(ratio).fold(0.0, f64::max).sqrt();
        assert!((found.factor / worst - 1.0).abs() < 1e-9, "{} {worst}", found.factor);
    });
}
