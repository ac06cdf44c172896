//! Three bases of one space: the same least-squares surface; and the order and meaning of the
//! terms.

use crate::oracle::design::{Basis, surface};
use crate::oracle::matrix::{doubles, least_squares, vector};
use crate::problems::{Surface, assert_close, config, fit, least_squares_values, polynomial};
use flankfit_engine::estimation::result::TermKey;
use flankfit_engine::estimation::spec::{
    Degree, Domain, FitSpec, Include, Knots, Model, PolynomialBasis, Regularization, Terms,
};
use flankfit_engine::estimation::{FitResult, Nodes};
use proptest::prelude::*;

const DOMAIN: Domain = Domain { u: Some([29.0, 35.0]), v: Some([-1.0, 22.0]) };

fn plain(spec: FitSpec) -> FitSpec {
    let include = Include { residuals: true, ..Include::default() };
    FitSpec { regularization: Regularization::None, include, ..spec }
}

fn keys(result: &FitResult) -> Vec<Vec<usize>> {
    let key = |key: &TermKey| match key {
        TermKey::Powers(k) | TermKey::Index(k) => k.clone(),
        TermKey::Column(j) => vec![*j],
    };
    result.coefficients.iter().map(|c| key(&c.key)).collect()
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn bases_describe_one_surface(seed: u64, p in 0usize..5, q in 0usize..4, total: bool) {
        let data = Surface::new(seed, [2, 3], 0.5, 1e-3);
        let (degree, terms) = if total { (Degree::Both(q), Terms::Total) } else { (Degree::Each(p, q), Terms::Tensor) };
        let each = [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre]
            .map(|basis| Model::Polynomial { degree, basis, terms: terms.clone() })
            .map(|model| fit(&data.scattered(), &plain(FitSpec::new(model))));
        for other in &each[1..] {
            prop_assert_eq!(keys(&each[0]), keys(other));
            assert_close("rss", each[0].residuals.rss, other.residuals.rss, 1e-10, 0.0);
            let (one, two) = (each[0].residuals.values.as_ref().unwrap(), other.residuals.values.as_ref().unwrap());
            for (a, b) in one.iter().zip(two) {
                assert_close("residual", *a, *b, 0.0, 1e-12);
            }
        }
    }

    #[test]
    fn coefficients_are_those_of_the_textbook_columns(seed: u64, p in 0usize..4, q in 0usize..4, total: bool,
        given: bool) {
        let data = Surface::new(seed, [2, 3], 0.5, 1e-3);
        let p = if total { q } else { p };
        let (degree, terms) = if total { (Degree::Both(q), Terms::Total) } else { (Degree::Each(p, q), Terms::Tensor) };
        let (u, v) = if given { ([29.0, 35.0], [-1.0, 22.0]) } else { ([30.0, 34.0], [0.0, data.v[6]]) };
        let keep = |i: usize, j: usize| !total || i + j <= q;
        let order: Vec<Vec<usize>> =
            (0..=p).flat_map(|i| (0..=q).map(move |j| vec![i, j])).filter(|k| keep(k[0], k[1])).collect();
        for (basis, columns) in [
            (PolynomialBasis::Monomial, [Basis::Monomial, Basis::Monomial]),
            (PolynomialBasis::Chebyshev, [Basis::Chebyshev(u), Basis::Chebyshev(v)]),
            (PolynomialBasis::Legendre, [Basis::Legendre(u), Basis::Legendre(v)]),
        ] {
            let model = Model::Polynomial { degree, basis, terms: terms.clone() };
            let domain = given.then_some(DOMAIN);
            let x = surface(columns, [p, q], &data.nodes, keep);
            let exact = least_squares(&x, &vector(&data.z));
            for nodes in [data.scattered(), data.grid()] {
                let result = fit(&nodes, &plain(FitSpec { domain, ..FitSpec::new(model.clone()) }));
                prop_assert_eq!(keys(&result), order.clone());
                let used = result.domain.unwrap();
                prop_assert_eq!((used.u, used.v), (Some(u), Some(v)));
                for (got, exact) in result.coefficients.iter().zip(doubles(&exact.coefficients)) {
                    let noise = 1e-9 * got.least_squares_std_error.unwrap();
                    assert_close(&got.term, got.least_squares, exact, 1e-11, noise);
                }
                assert_close("rss", result.residuals.rss, exact.rss.to_f64(), 1e-10, 0.0);
            }
        }
    }

    #[test]
    fn b_splines_are_those_of_their_definition(seed: u64, p in 0usize..4, q in 0usize..4, inner in 30.5f64..33.5) {
        let data = Surface::new(seed, [2, 3], 0.5, 1e-3);
        let full = |degree: usize, low: f64, high: f64, inner: &[f64]| -> Vec<f64> {
            [vec![low; degree + 1], inner.to_vec(), vec![high; degree + 1]].concat()
        };
        let (in_u, in_v) = (full(p, 30.0, 34.0, &[inner]), full(q, 0.0, data.v[6], &[data.v[3]]));
        let x = surface([Basis::BSpline(&in_u), Basis::BSpline(&in_v)], [p, q], &data.nodes, |_, _| true);
        let exact = least_squares(&x, &vector(&data.z));
        let knots = Knots::Surface(in_u.clone(), in_v.clone());
        let spec = plain(FitSpec::new(Model::BSpline { degree: Degree::Each(p, q), knots, weights: None }));
        for nodes in [data.scattered(), data.grid()] {
            let result = fit(&nodes, &spec);
            let indices: Vec<Vec<usize>> = (0..p + 2).flat_map(|i| (0..q + 2).map(move |j| vec![i, j])).collect();
            prop_assert_eq!(keys(&result), indices);
            for (got, exact) in least_squares_values(&result).iter().zip(doubles(&exact.coefficients)) {
                assert_close("B-spline coefficient", *got, exact, 1e-10, 1e-12);
            }
            // B-splines sum to 1, so the constant lies in their span and r² is about the mean.
            let mean = data.z.iter().sum::<f64>() / data.z.len() as f64;
            let about = data.z.iter().map(|z| (z - mean).powi(2)).sum::<f64>();
            assert_close("r²", result.residuals.r_squared.unwrap(), 1.0 - exact.rss.to_f64() / about, 1e-9, 1e-11);
        }
    }

    #[test]
    fn equal_spans_are_equal_knots(seed: u64, spans in 1usize..4, degree in 1usize..4) {
        let data = Surface::new(seed, [2, 3], 0.5, 1e-3);
        let (low, high) = (30.0, 34.0);
        let x: Vec<f64> = data.nodes.iter().map(|n| n[0]).collect();
        let inner: Vec<f64> = (1..spans).map(|i| low + (high - low) * i as f64 / spans as f64).collect();
        let knots = Knots::Curve([vec![low; degree + 1], inner, vec![high; degree + 1]].concat());
        let nodes = Nodes::curve(x, data.z, None).expect("checked nodes");
        let of = |knots| plain(FitSpec::new(Model::BSpline { degree: Degree::Both(degree), knots, weights: None }));
        let (one, two) = (fit(&nodes, &of(knots)), fit(&nodes, &of(Knots::Spans(spans))));
        for (a, b) in one.coefficients.iter().zip(&two.coefficients) {
            assert_close(&a.term, a.value, b.value, 1e-10, 1e-12);
        }
    }
}

#[test]
fn terms_have_readable_names() {
    let data = Surface::new(1, [1, 1], 0.5, 1e-3);
    let names = |basis| -> Vec<String> {
        let result = fit(&data.grid(), &plain(polynomial(Degree::Each(2, 1), basis)));
        result.coefficients.into_iter().map(|c| c.term).collect()
    };
    assert_eq!(names(PolynomialBasis::Monomial), ["1", "v", "u", "u*v", "u^2", "u^2*v"]);
    assert_eq!(names(PolynomialBasis::Chebyshev)[5], "T2(u)*T1(v)");
}
