//! Many nodes: the blocked, separated and threaded paths give what the plain definition gives.

use crate::oracle::big::Big;
use crate::oracle::design::{Basis, crossings, curve, surface};
use crate::oracle::matrix::{Rows, column, dot, doubles, eigen, gram, inverse, least_squares, times, vector};
use crate::oracle::random::Random;
use crate::problems::{assert_all_close, assert_close, assert_same_fit, fit, polynomial};
use flankfit_engine::estimation::spec::{Degree, FitSpec, Include, PolynomialBasis, Regularization, Scaling};
use flankfit_engine::estimation::{FitResult, Nodes};

fn height(u: f64, v: f64) -> f64 {
    0.02 * ((u - 32.0) / 2.0).powi(2) - 0.005 * v / 20.0 + 0.003 * ((u - 30.0) * v / 20.0).sin()
}

fn plain(degree: usize) -> FitSpec {
    let spec = polynomial(Degree::Both(degree), PolynomialBasis::Monomial);
    FitSpec { regularization: Regularization::None, scaling: Scaling::None, ..spec }
}

fn check(result: &FitResult, exact: &[f64], eigenvalues: &[f64], rss: f64) {
    for (c, exact) in result.coefficients.iter().zip(exact) {
        let noise = 1e-7 * c.least_squares_std_error.unwrap();
        assert_close(&c.term, c.least_squares, *exact, 1e-11, noise);
    }
    let condition = eigenvalues[eigenvalues.len() - 1] / eigenvalues[0];
    if condition <= 1e20 {
        assert_all_close("eigenvalues", &result.spectrum.eigenvalues, eigenvalues, 1e-9);
    }
    assert_close("rss", result.residuals.least_squares_rss, rss, 1e-10, 0.0);
}

#[test]
fn scattered_nodes_sixteen_times_over() {
    // The oracle solves 600 nodes; posted are 9,600 in random order, which is the same fit.
    let mut random = Random::new(3);
    let nodes: Vec<[f64; 2]> = (0..600).map(|_| [random.between(30.0, 34.0), random.between(0.0, 20.0)]).collect();
    let z: Vec<f64> = nodes.iter().map(|[u, v]| height(*u, *v) + 5e-4 * random.normal()).collect();
    let mut order: Vec<usize> = (0..9600).map(|k| k % 600).collect();
    random.shuffle(&mut order);
    let pick = |f: &dyn Fn(usize) -> f64| order.iter().map(|k| f(*k)).collect::<Vec<f64>>();
    let posted = Nodes::scattered(pick(&|k| nodes[k][0]), pick(&|k| nodes[k][1]), pick(&|k| z[k]), None);
    let posted = posted.expect("checked nodes");
    for degree in [2, 3, 5] {
        let x = surface([Basis::Monomial, Basis::Monomial], [degree, degree], &nodes, |_, _| true);
        let exact = least_squares(&x, &vector(&z));
        let lambda: Vec<f64> = doubles(&eigen(&gram(&x)).0).iter().map(|l| 16.0 * l).collect();
        let result = fit(&posted, &plain(degree));
        assert_eq!(result.residuals.count, 9600);
        check(&result, &doubles(&exact.coefficients), &lambda, 16.0 * exact.rss.to_f64());
    }
}

#[test]
fn a_grid_separates() {
    let u: Vec<f64> = (0..120).map(|i| 30.0 + 4.0 * f64::from(i) / 119.0).collect();
    let v: Vec<f64> = (0..80).map(|j| 20.0 * f64::from(j) / 79.0).collect();
    let mut random = Random::new(4);
    let z: Vec<f64> = crossings(&u, &v).iter().map(|[u, v]| height(*u, *v) + 5e-4 * random.normal()).collect();
    let grid = Nodes::grid(u.clone(), v.clone(), z.clone(), None, None).expect("checked nodes");
    for degree in [1, 3, 5] {
        let (in_u, in_v) = (curve(Basis::Monomial, degree, &u), curve(Basis::Monomial, degree, &v));
        // A = (UᵀU)⁻¹ Uᵀ Z V (VᵀV)⁻¹, eigenvalues the products of those of UᵀU and VᵀV.
        let heights: Rows = z.chunks(v.len()).map(vector).collect();
        let project = |x: &Rows, y: &[Big]| {
            let moments: Vec<Big> = (0..=degree).map(|j| dot(&column(x, j), y)).collect();
            times(&inverse(&gram(x)), &moments)
        };
        let across: Rows = heights.iter().map(|row| project(&in_v, row)).collect();
        let own: Rows = (0..=degree).map(|q| project(&in_u, &column(&across, q))).collect();
        let exact: Vec<Big> = (0..=degree).flat_map(|p| own.iter().map(move |of_q| of_q[p].clone())).collect();
        let fitted = (0..u.len()).flat_map(|i| {
            let in_q: Vec<Big> = own.iter().map(|of_q| dot(&in_u[i], of_q)).collect();
            in_v.iter().map(|row| dot(row, &in_q)).collect::<Vec<Big>>()
        });
        let rss = fitted.zip(&z).fold(Big::zero(), |s, (f, z)| {
            let residual = &Big::from(*z) - &f;
            &s + &(&residual * &residual)
        });
        let (of_u, of_v) = (eigen(&gram(&in_u)).0, eigen(&gram(&in_v)).0);
        let mut lambda: Vec<f64> = of_u.iter().flat_map(|p| of_v.iter().map(move |q| (p * q).to_f64())).collect();
        lambda.sort_by(f64::total_cmp);
        check(&fit(&grid, &plain(degree)), &doubles(&exact), &lambda, rss.to_f64());
    }
}

#[test]
fn a_few_missing_nodes_break_nothing() {
    let u: Vec<f64> = (0..120).map(|i| 30.0 + 4.0 * f64::from(i) / 119.0).collect();
    let v: Vec<f64> = (0..80).map(|j| 20.0 * f64::from(j) / 79.0).collect();
    let mut random = Random::new(5);
    let places = crossings(&u, &v);
    let z: Vec<f64> = places.iter().map(|[u, v]| height(*u, *v) + 5e-4 * random.normal()).collect();
    for missing in [1, 3, 40, 4000] {
        let mut keep = vec![true; z.len()];
        (0..missing).for_each(|_| keep[random.below(z.len())] = false);
        let masked = z.iter().zip(&keep).map(|(z, k)| if *k { *z } else { f64::NAN }).collect();
        let grid = Nodes::grid(u.clone(), v.clone(), masked, None, None).expect("checked nodes");
        let kept = |f: &dyn Fn(usize) -> f64| (0..z.len()).filter(|k| keep[*k]).map(f).collect::<Vec<f64>>();
        let scattered = Nodes::scattered(kept(&|k| places[k][0]), kept(&|k| places[k][1]), kept(&|k| z[k]), None);
        let scattered = scattered.expect("checked nodes");
        for degree in [2, 4] {
            for spec in [plain(degree), polynomial(Degree::Both(degree), PolynomialBasis::Chebyshev)] {
                assert_same_fit(&fit(&grid, &spec), &fit(&scattered, &spec), 1e-9);
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let mut random = Random::new(6);
    let count = 60_000;
    let u: Vec<f64> = (0..count).map(|_| random.between(30.0, 34.0)).collect();
    let v: Vec<f64> = (0..count).map(|_| random.between(0.0, 20.0)).collect();
    let z = u.iter().zip(&v).map(|(u, v)| height(*u, *v)).collect();
    let nodes = Nodes::scattered(u, v, z, None).expect("checked nodes");
    let include = Include { residuals: true, lambda_curve: true, collinearity: true, ..Include::default() };
    let spec = FitSpec { include, ..polynomial(Degree::Both(3), PolynomialBasis::Monomial) };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        format!("{:?}", pool.install(|| fit(&nodes, &spec)))
    };
    let one = on(1);
    assert!(one == on(2) && one == on(3) && one == on(7));
    assert!(one == format!("{:?}", fit(&nodes, &spec)));
}
