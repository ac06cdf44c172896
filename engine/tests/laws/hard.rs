//! Node sets that no basis makes easy: clumped abscissae, nearly empty spans, weights over many
//! decades, and the fast paths of larger sets, all against the exact solution.

use crate::oracle::big::{Big, digits};
use crate::oracle::design::{Basis, curve, surface};
use crate::oracle::matrix::{Rows, doubles, eigen, gram, least_squares, vector};
use crate::oracle::random::Random;
use crate::oracle::spectral::{Columns, Spectrum};
use crate::problems::{assert_all_close, assert_close, fit};
use flankfit_engine::estimation::spec::{
    Degree, Domain, FitSpec, Knots, Model, PolynomialBasis, Regularization, Scaling, Terms,
};
use flankfit_engine::estimation::{FitResult, Nodes};

fn plain(model: Model, scaling: Scaling) -> FitSpec {
    FitSpec { regularization: Regularization::None, scaling, ..FitSpec::new(model) }
}

fn polynomial(degree: Degree, basis: PolynomialBasis) -> Model {
    Model::Polynomial { degree, basis, terms: Terms::Tensor }
}

/// Coefficients to `wanted` digits of the worst or a ten-millionth of their standard error; the
/// spectrum to 1e-9; claimed digits at most those reached.
#[track_caller]
fn check(name: &str, result: &FitResult, x: &Rows, y: &[Big], wanted: f64) {
    let exact = least_squares(x, y);
    let mut reached = f64::INFINITY;
    for (c, exact) in result.coefficients.iter().zip(&exact.coefficients) {
        let error = (&Big::from(c.least_squares) - exact).to_f64().abs();
        let noise = 1e-7 * c.least_squares_std_error.unwrap_or(0.0);
        reached = reached.min(digits(c.least_squares, exact));
        assert!(
            digits(c.least_squares, exact) >= wanted || error <= noise,
            "{name}: {} is {:e}, off by {error:e}",
            c.term,
            exact.to_f64()
        );
    }
    let claimed = result.numerics.correct_digits;
    println!("{name}: {reached:.1} digits reached, {claimed:.1} claimed, {:?}", result.numerics.arithmetic);
    assert!(claimed <= reached.min(15.95) + 0.3, "{name}: claims {claimed} digits, has {reached}");
    assert_close("rss", result.residuals.least_squares_rss, exact.rss.to_f64(), 1e-8, 1e-28);
    let (lambda, _) = eigen(&gram(x));
    if lambda[lambda.len() - 1].log10() - lambda[0].log10() <= 20.0 {
        assert_all_close(name, &result.spectrum.eigenvalues, &doubles(&lambda), 1e-9);
    }
}

#[test]
fn clumped_abscissae() {
    let mut random = Random::new(21);
    for power in [2, 6, 12] {
        // Most nodes lie close to 30, few reach 34.
        let x: Vec<f64> = (0..300).map(|_| 30.0 + 4.0 * random.unit().powi(power)).chain([30.0, 34.0]).collect();
        let y: Vec<f64> = x.iter().map(|x| 0.01 * (x - 32.0).powi(2) + 1e-3 * random.normal()).collect();
        let nodes = Nodes::curve(x.clone(), y.clone(), None).expect("checked nodes");
        for degree in [2, 4, 7] {
            let name = format!("power {power}, degree {degree}");
            let model = polynomial(Degree::Both(degree), PolynomialBasis::Monomial);
            let columns = curve(Basis::Monomial, degree, &x);
            check(&name, &fit(&nodes, &plain(model, Scaling::None)), &columns, &vector(&y), 11.0);
            let model = polynomial(Degree::Both(degree), PolynomialBasis::Chebyshev);
            let columns = curve(Basis::Chebyshev([30.0, 34.0]), degree, &x);
            check(&name, &fit(&nodes, &plain(model, Scaling::None)), &columns, &vector(&y), 11.0);
        }
    }
}

#[test]
fn a_domain_far_wider_than_the_nodes() {
    // Mapped bases on a domain of which the nodes fill a thousandth are nearly as bad as raw
    // monomials.
    let mut random = Random::new(22);
    let x: Vec<f64> = (0..60).map(|i| 30.0 + 4.0 * f64::from(i) / 59.0).collect();
    let y: Vec<f64> = x.iter().map(|x| 0.01 * (x - 32.0).powi(2) + 1e-3 * random.normal()).collect();
    let nodes = Nodes::curve(x.clone(), y.clone(), None).expect("checked nodes");
    for width in [100.0, 4000.0] {
        for (basis, own) in [
            (PolynomialBasis::Chebyshev, Basis::Chebyshev([-width, width])),
            (PolynomialBasis::Legendre, Basis::Legendre([-width, width])),
        ] {
            for degree in [1, 3, 5] {
                let domain = Some(Domain { u: Some([-width, width]), v: None });
                let model = polynomial(Degree::Both(degree), basis);
                let result = fit(&nodes, &FitSpec { domain, ..plain(model, Scaling::None) });
                let name = format!("width {width}, degree {degree}");
                check(&name, &result, &curve(own, degree, &x), &vector(&y), 10.0);
            }
        }
    }
}

#[test]
fn nearly_empty_spans() {
    let mut random = Random::new(23);
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 5.0, 5.0, 5.0, 5.0];
    // A single node in (1, 2), and close to its end.
    let mut x: Vec<f64> =
        (0..40).map(|i| f64::from(i) / 40.0).chain((0..40).map(|i| 2.0 + 3.0 * f64::from(i) / 39.0)).collect();
    for place in [1.5, 1.001, 1.000_001] {
        x.push(place);
        let y: Vec<f64> = x.iter().map(|x| (1.3 * x).sin() + 1e-3 * random.normal()).collect();
        let nodes = Nodes::curve(x.clone(), y.clone(), None).expect("checked nodes");
        let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Curve(knots.to_vec()), weights: None };
        let columns = curve(Basis::BSpline(&knots), 3, &x);
        check(&format!("node at {place}"), &fit(&nodes, &plain(model, Scaling::None)), &columns, &vector(&y), 9.0);
        x.pop();
    }
}

#[test]
fn weights_over_many_decades() {
    let mut random = Random::new(24);
    let x: Vec<f64> = (0..80).map(|i| 30.0 + 4.0 * f64::from(i) / 79.0).collect();
    let y: Vec<f64> = x.iter().map(|x| 0.01 * (x - 32.0).powi(2) + 1e-3 * random.normal()).collect();
    for decades in [3.0, 8.0, 14.0] {
        let weight: Vec<f64> = x.iter().map(|_| 10f64.powf(decades * random.unit())).collect();
        let roots: Vec<Big> = weight.iter().map(|w| Big::from(*w).sqrt()).collect();
        let nodes = Nodes::curve(x.clone(), y.clone(), Some(weight.clone())).expect("checked nodes");
        for degree in [1, 4] {
            let model = polynomial(Degree::Both(degree), PolynomialBasis::Monomial);
            let columns: Rows = (curve(Basis::Monomial, degree, &x).iter().zip(&roots))
                .map(|(row, root)| row.iter().map(|v| v * root).collect())
                .collect();
            let heights: Vec<Big> = y.iter().zip(&roots).map(|(y, root)| &Big::from(*y) * root).collect();
            let name = format!("{decades} decades, degree {degree}");
            check(&name, &fit(&nodes, &plain(model, Scaling::None)), &columns, &heights, 10.0);
        }
    }
}

#[test]
fn fast_paths_of_larger_sets() {
    let mut random = Random::new(25);
    let nodes: Vec<[f64; 2]> = (0..1200).map(|_| [random.between(30.0, 34.0), random.between(0.0, 20.0)]).collect();
    let z: Vec<f64> = nodes
        .iter()
        .map(|[u, v]| 0.02 * (u - 32.0).powi(2) - 2e-4 * v + 1e-3 * (u * v / 20.0).sin() + 5e-4 * random.normal())
        .collect();
    let axis = |k: usize| nodes.iter().map(|n| n[k]).collect::<Vec<f64>>();
    let posted = Nodes::scattered(axis(0), axis(1), z.clone(), None).expect("checked nodes");
    let (low_u, high_u) = axis(0).iter().fold((34.0f64, 30.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
    let (low_v, high_v) = axis(1).iter().fold((20.0f64, 0.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
    for (basis, own) in [
        (PolynomialBasis::Chebyshev, [Basis::Chebyshev([low_u, high_u]), Basis::Chebyshev([low_v, high_v])]),
        (PolynomialBasis::Legendre, [Basis::Legendre([low_u, high_u]), Basis::Legendre([low_v, high_v])]),
        (PolynomialBasis::Monomial, [Basis::Monomial, Basis::Monomial]),
    ] {
        for degree in [1, 3] {
            let columns = surface(own, [degree, degree], &nodes, |_, _| true);
            let result = fit(&posted, &plain(polynomial(Degree::Both(degree), basis), Scaling::None));
            check(&format!("{basis:?} {degree}"), &result, &columns, &vector(&z), 10.0);
        }
    }
    // And the scaled spectrum of the same.
    let columns = surface([Basis::Monomial, Basis::Monomial], [2, 2], &nodes, |_, _| true);
    let result = fit(&posted, &plain(polynomial(Degree::Both(2), PolynomialBasis::Monomial), Scaling::UnitLength));
    let sums = Spectrum::new(&columns, &vector(&z), None, Columns::UnitLength).sums();
    assert_all_close("scaled", &result.spectrum.eigenvalues, &sums.lambda, 1e-9);
}
