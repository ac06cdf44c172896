//! Fitted polynomials as B-splines: they have the heights that the fit predicts, which come of
//! rows of the measurement matrix and not of Bernstein's basis.

use crate::problems::fit;
use flankfit_engine::{
    estimation::{
        Nodes,
        near::{Shape, shape_of},
        spec::{
            Count, Criterion, Degree, Domain, FitSpec, Include, Kinds, Model, Parameter, Places, PolynomialBasis,
            Predict, Regularization, Scheme, Terms,
        },
    },
    geometry::{curve::Curve, surface::Surface},
};

const BASES: [PolynomialBasis; 3] = [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre];

fn spec(model: Model, at: Places, regularization: Regularization, domain: Option<Domain>) -> FitSpec {
    let include = Include { shape: true, ..Include::default() };
    let predict = Some(Predict { at, level: None, kinds: Kinds::default(), slopes: false });
    FitSpec { regularization, include, predict, domain, ..FitSpec::new(model) }
}

fn places([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    (0..=count).map(|k| if k == count { high } else { low + (high - low) * k as f64 / count as f64 }).collect()
}

fn filters() -> [Regularization; 3] {
    [
        Regularization::None,
        Regularization::Ridge { parameter: Parameter::Fixed(1e-6) },
        Regularization::Spectral {
            scheme: Scheme::FirstOrder,
            count: Count::Auto,
            condition_limit: 30.0,
            lambda_star: Parameter::Criterion(Criterion::MinMse),
        },
    ]
}

/// Rough heights, so that every coefficient is of size.
fn height(k: usize) -> f64 {
    ((k * 7919 + 13) % 1009) as f64 / 100.0 - 5.0
}

#[test]
fn curves_have_the_fitted_heights() {
    let x = places([30.0, 34.0], 60);
    let nodes = Nodes::curve(x.clone(), (0..x.len()).map(height).collect(), None).unwrap();
    for degree in [0, 1, 3, 6, 12, 20, 25] {
        for basis in BASES {
            // above degree 12 raw powers of 32 ± 2 exceed the range that a spectrum distinguishes
            if basis == PolynomialBasis::Monomial && degree > 12 {
                continue;
            }
            for (range, regularization) in
                [[30.0, 34.0], [29.5, 34.25]].into_iter().flat_map(|r| filters().map(|filter| (r, filter)))
            {
                let at = places(range, 333);
                let model = Model::Polynomial { degree: Degree::Both(degree), basis, terms: Terms::Tensor };
                let domain = Some(Domain { u: Some(range), v: None });
                let spec = spec(model, Places::Curve(at.clone()), regularization, domain);
                let found = fit(&nodes, &spec);
                let Some(Shape::Curve(curve)) = shape_of(&spec, &found) else { panic!("{degree} {basis:?}") };
                assert_eq!(curve.domain(), range);
                let expected = found.predictions.unwrap().value;
                let size = expected.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
                for (x, y) in at.iter().zip(&expected) {
                    let error = (curve.value(*x).x - y).abs();
                    assert!(error < 1e-13 * size, "{degree} {basis:?} at {x}: {error:e} of {size}");
                }
            }
        }
    }
}

#[test]
fn surfaces_have_the_fitted_heights() {
    let (u, v) = (places([30.0, 34.0], 24), places([-5.0, 5.0], 17));
    let z = (0..u.len() * v.len()).map(height).collect();
    let nodes = Nodes::grid(u, v, z, None, None).unwrap();
    let cases = [
        (Degree::Each(3, 2), Terms::Tensor),
        (Degree::Each(0, 4), Terms::Tensor),
        (Degree::Both(5), Terms::Total),
        (Degree::Each(12, 9), Terms::Tensor),
    ];
    for (degree, terms) in cases {
        for basis in BASES {
            for regularization in filters() {
                let (us, vs) = (places([30.0, 34.0], 23), places([-5.0, 5.0], 19));
                let at = Places::Grid { u: us.clone(), v: vs.clone() };
                let spec = spec(Model::Polynomial { degree, basis, terms: terms.clone() }, at, regularization, None);
                let found = fit(&nodes, &spec);
                let Some(Shape::Surface(surface)) = shape_of(&spec, &found) else { panic!("{degree:?} {basis:?}") };
                let Some(predictions) = found.predictions else {
                    assert!(basis == PolynomialBasis::Monomial, "only raw powers lose their rank");
                    continue;
                };
                let size = predictions.value.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
                let places = us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v)));
                for ((u, v), z) in places.zip(&predictions.value) {
                    let error = (surface.value(u, v).x - z).abs();
                    assert!(error < 1e-13 * size, "{degree:?} {basis:?} at {u}, {v}: {error:e} of {size}");
                }
            }
        }
    }
}

#[test]
fn shapes_are_included_on_request_where_they_exist() {
    let x = places([0.0, 1.0], 60);
    let nodes = Nodes::curve(x.clone(), (0..x.len()).map(height).collect(), None).unwrap();
    let model = |degree| Model::Polynomial {
        degree: Degree::Both(degree),
        basis: PolynomialBasis::Legendre,
        terms: Terms::Tensor,
    };
    let plain = FitSpec::new(model(3));
    assert_eq!(shape_of(&plain, &fit(&nodes, &plain)), None);
    let codes = |spec: &FitSpec, nodes: &Nodes| {
        let found = fit(nodes, spec);
        assert_eq!(shape_of(spec, &found), None);
        found.warnings.iter().filter(|w| w.code() == "no_shape").count()
    };
    let include = Include { shape: true, ..Include::default() };
    assert_eq!(codes(&FitSpec { include, ..FitSpec::new(model(26)) }, &nodes), 1);
    let matrix = Nodes::matrix(vec![1.0, 2.0, 4.0], 1, vec![1.0, 2.0, 5.0], None, None).unwrap();
    assert_eq!(codes(&FitSpec { include, ..FitSpec::new(Model::Linear) }, &matrix), 1);
}
