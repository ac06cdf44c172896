//! Comparison of the decomposition in double precision with twice the precision.

use std::cell::Cell;

use crate::{
    FitSpec, Nodes, fit,
    result::FitResult,
    spec::{
        ChosenBy, Criterion, Degree, Include, Knots, Model, Parameter, PolynomialBasis, Regularization, Scaling, Terms,
        Tikhonov,
    },
};

thread_local! {
    /// True if the decomposition in double precision is left out.
    pub(super) static WITHOUT: Cell<bool> = const { Cell::new(false) };
}

fn noise(k: usize) -> f64 {
    let mut x = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (x >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

fn height(u: f64, v: f64, k: usize) -> f64 {
    2.0 * (1.3 * u).sin() * (0.9 * v).cos() + 0.3 * u * v + 0.2 * noise(k)
}

fn axis(count: usize, even: bool) -> Vec<f64> {
    let step = |i: usize| i as f64 / (count - 1) as f64;
    (0..count).map(|i| 5.0 + 3.0 * if even { step(i) } else { step(i).powf(1.2) }).collect()
}

fn surface(even: [bool; 2], scattered: bool) -> Nodes {
    let (u, v) = (axis(21, even[0]), axis(20, even[1]));
    let places: Vec<(f64, f64)> = u.iter().flat_map(|&u| v.iter().map(move |&v| (u, v))).collect();
    let z: Vec<f64> = places.iter().enumerate().map(|(k, (u, v))| height(*u, *v, k)).collect();
    match scattered {
        true => {
            let (u, v) = places.into_iter().unzip();
            Nodes::scattered(u, v, z, None).unwrap()
        }
        false => Nodes::grid(u, v, z, None, None).unwrap(),
    }
}

fn close(what: &str, a: &[f64], b: &[f64], relative: f64, absolute: f64) {
    assert_eq!(a.len(), b.len(), "{what}");
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= absolute + relative * b.abs(), "{what} {k}: {a} {b}");
    }
}

fn compare(double: &FitResult, exact: &FitResult) {
    let of = |f: &dyn Fn(&FitResult) -> Vec<f64>| [f(double), f(exact)];
    let [a, b] = of(&|r| r.coefficients.iter().map(|c| c.value).collect());
    let size = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let same = double.regularization.criterion == Some(ChosenBy::Fixed);
    close("coefficients", &a, &b, 0.0, size * if same { 1e-15 } else { 1e-7 });
    let figure = if same { 1e-10 } else { 1e-6 };
    let [a, b] = of(&|r| r.coefficients.iter().filter_map(|c| c.std_error).collect());
    close("std errors", &a, &b, figure, 0.0);
    let [a, b] = of(&|r| r.coefficients.iter().map(|c| c.bias_bound).collect());
    close("bias bounds", &a, &b, figure, 0.0);
    let [a, b] = of(&|r| r.regularization.filter_factors.clone());
    close("factors", &a, &b, 0.0, figure);
    let [a, b] = of(&|r| r.spectrum.regularized.eigenvalues.clone());
    close("eigenvalues", &a, &b, figure, 0.0);
    let [a, b] = of(&|r| vec![r.bias.norm, r.bias.sharp_bound, r.residuals.rss, r.residuals.max_abs.unwrap()]);
    close("bias and residuals", &a, &b, figure, 0.0);
    assert_eq!(double.regularization.choices.len(), exact.regularization.choices.len());
    for (a, b) in double.regularization.choices.iter().zip(&exact.regularization.choices) {
        assert_eq!(a.criterion, b.criterion);
        let name = b.criterion.name();
        let figures = |c: &crate::result::Choice| {
            vec![c.lambda_star.unwrap_or(1.0), c.condition.unwrap(), c.predicted_mse.unwrap(), c.rms]
        };
        // the place of a greatest curvature has half the digits
        let relative = if b.criterion == ChosenBy::Criterion(Criterion::LCurve) { 1e-4 } else { 2e-6 };
        close(name, &figures(a), &figures(b), relative, 0.0);
        close(name, &[a.bias_norm], &[b.bias_norm], relative, 1e-9);
    }
    let kinds = |found: &FitResult| found.warnings.iter().map(std::mem::discriminant).collect::<Vec<_>>();
    assert_eq!(kinds(double), kinds(exact));
}

fn both(nodes: &Nodes, spec: &FitSpec) -> [FitResult; 2] {
    let double = fit(nodes, spec).unwrap();
    WITHOUT.set(true);
    let exact = fit(nodes, spec).unwrap();
    WITHOUT.set(false);
    [double, exact]
}

fn spec(scaling: Scaling, order: usize, parameter: Parameter) -> FitSpec {
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(3), weights: None };
    let regularization = Regularization::Tikhonov(Tikhonov { order, weights: None, parameter });
    let include = Include { residuals: true, predicted_mse: true, influence: true, ..Include::default() };
    FitSpec { regularization, scaling, include, ..FitSpec::new(model) }
}

#[test]
fn figures_are_those_of_twice_the_precision() {
    let parameters = [Parameter::Fixed(1e-3), Parameter::Fixed(10.0), Parameter::Criterion(Criterion::Gcv)];
    let places = [([true, true], false), ([true, false], false), ([false, false], false), ([true, true], true)];
    for (even, scattered) in places {
        let nodes = surface(even, scattered);
        for parameter in parameters {
            for (scaling, order) in [(Scaling::UnitLength, 2), (Scaling::None, 1), (Scaling::UnitLength, 0)] {
                let [double, exact] = both(&nodes, &spec(scaling, order, parameter));
                // the two take different ways: not every bit is the same
                assert_ne!(double, exact);
                compare(&double, &exact);
                let [a, b] = [double.influence, exact.influence].map(|found| found.unwrap().leverage);
                close("leverage", &a, &b, 0.0, 1e-6);
            }
        }
    }
}

#[test]
fn curves_and_polynomials_too() {
    let x: Vec<f64> = (0..200).map(|i| 0.1 * i as f64).collect();
    let y: Vec<f64> = x.iter().enumerate().map(|(k, x)| (0.7 * x).sin() + 0.1 * noise(k)).collect();
    let nodes = Nodes::curve(x, y, None).unwrap();
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(30), weights: None };
    let regularization =
        Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter: Parameter::Fixed(1e-2) });
    let curve = FitSpec { regularization, ..FitSpec::new(model) };
    let [double, exact] = both(&nodes, &curve);
    compare(&double, &exact);
    let (degree, terms) = (Degree::Both(5), Terms::Tensor);
    let model = Model::Polynomial { degree, terms, basis: PolynomialBasis::Chebyshev };
    let polynomial = FitSpec { model, ..curve };
    let [double, exact] = both(&surface([true, true], false), &polynomial);
    compare(&double, &exact);
}

#[test]
fn heights_without_noise_are_taken_in_twice_the_precision() {
    let (u, v) = (axis(21, true), axis(20, true));
    let z = u.iter().flat_map(|u| v.iter().map(move |v| 1.0 + u * v)).collect();
    let nodes = Nodes::grid(u, v, z, None, None).unwrap();
    let [double, exact] = both(&nodes, &spec(Scaling::UnitLength, 2, Parameter::Fixed(1e-3)));
    assert_eq!(double, exact);
}

#[test]
fn min_condition_is_searched_in_large_models_only_on_request() {
    let nodes = surface([true, true], false);
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(6), weights: None };
    let by = |parameter, lambda_curve| {
        let regularization = Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter });
        let include = Include { lambda_curve, ..Include::default() };
        let found = fit(&nodes, &FitSpec { regularization, include, ..FitSpec::new(model.clone()) }).unwrap();
        let is_least = |c: &&crate::result::Choice| c.criterion == ChosenBy::Criterion(Criterion::MinCondition);
        found.regularization.choices.iter().find(is_least).map(|c| (c.lambda_star.unwrap(), c.condition.unwrap()))
    };
    assert_eq!(by(Parameter::Fixed(1e-3), false), None);
    let asked = by(Parameter::Criterion(Criterion::MinCondition), false).unwrap();
    assert_eq!(by(Parameter::Fixed(1e-3), true), Some(asked));
    // and it is one
    let (lambda, least) = asked;
    for factor in [0.9, 1.1] {
        let spec = FitSpec {
            regularization: Regularization::Tikhonov(Tikhonov {
                order: 2,
                weights: None,
                parameter: Parameter::Fixed(factor * lambda),
            }),
            ..FitSpec::new(model.clone())
        };
        assert!(fit(&nodes, &spec).unwrap().spectrum.regularized.condition.unwrap() > least);
    }
}
