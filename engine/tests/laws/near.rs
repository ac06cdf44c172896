//! Curves and surfaces near points: the shape is the fit; NURBS with given weights; what they
//! reproduce.

use flankfit_engine::estimation::near::{Shape, shape_of};
use flankfit_engine::estimation::spec::{
    Count, Degree, Estimator, FitSpec, Include, Knots, Model, NodeUncertainty, Parameter, Regularization, Scaling,
    Tikhonov,
};
use flankfit_engine::estimation::{FitResult, Nodes, fit};
use flankfit_engine::geometry::curve::Curve;
use flankfit_engine::geometry::surface::Surface;
use proptest::prelude::*;

use crate::oracle::random::Random;

pub fn plain(model: Model) -> FitSpec {
    let include = Include { residuals: true, ..Include::default() };
    FitSpec { regularization: Regularization::None, include, ..FitSpec::new(model) }
}

fn weights(random: &mut Random, count: usize) -> Vec<f64> {
    (0..count).map(|_| 0.5 + 2.0 * random.unit()).collect()
}

fn values(result: &FitResult) -> Vec<f64> {
    result.coefficients.iter().map(|c| c.value).collect()
}

/// Rows of X of a NURBS surface from its definition, by the recursion over all knots.
fn basis(knots: &[f64], degree: usize, x: f64) -> Vec<f64> {
    let last = knots[knots.len() - 1];
    let mut n: Vec<f64> = knots
        .windows(2)
        .map(|k| f64::from(u8::from(k[0] < k[1] && ((k[0] <= x && x < k[1]) || (x == last && k[1] == last)))))
        .collect();
    for p in 1..=degree {
        n = (0..n.len() - 1)
            .map(|i| {
                let part = |low: f64, high: f64, value: f64, above: f64| {
                    if high > low { above / (high - low) * value } else { 0.0 }
                };
                part(knots[i], knots[i + p], n[i], x - knots[i])
                    + part(knots[i + 1], knots[i + p + 1], n[i + 1], knots[i + p + 1] - x)
            })
            .collect();
    }
    n
}

fn rational_row(knots: [&[f64]; 2], degrees: [usize; 2], weights: &[f64], u: f64, v: f64) -> Vec<f64> {
    let (a, b) = (basis(knots[0], degrees[0], u), basis(knots[1], degrees[1], v));
    let row: Vec<f64> = a.iter().flat_map(|a| b.iter().map(move |b| a * b)).zip(weights).map(|(n, w)| n * w).collect();
    let sum: f64 = row.iter().sum();
    row.iter().map(|x| x / sum).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The shape evaluates to X·A at every node, whatever scaling and regularisation.
    #[test]
    fn the_shape_is_the_fit(seed: u64, p in 1usize..4, spans in 1usize..5, rational: bool, ridge: bool) {
        let mut random = Random::new(seed);
        let x: Vec<f64> = (0..60).map(|i| f64::from(i) / 59.0 * 4.0 + 30.0).collect();
        let y: Vec<f64> = x.iter().map(|x| (1.3 * x).sin() + 0.1 * random.unit()).collect();
        let weights = rational.then(|| weights(&mut random, p + spans));
        let model = Model::BSpline { degree: Degree::Both(p), knots: Knots::Spans(spans), weights };
        let regularization =
            if ridge { Regularization::Ridge { parameter: Parameter::Fixed(1e-3) } } else { Regularization::None };
        let spec = FitSpec { regularization, ..plain(model) };
        let result = fit(&Nodes::curve(x.clone(), y.clone(), None).unwrap(), &spec).unwrap();
        let Some(Shape::Curve(curve)) = shape_of(&spec, &result) else { panic!("a curve") };
        for ((x, y), r) in x.iter().zip(&y).zip(result.residuals.values.as_ref().unwrap()) {
            prop_assert!((curve.value(*x).x - (y - r)).abs() < 1e-13, "{x} {} {}", curve.value(*x).x, y - r);
        }
    }

    /// Coefficients, residuals and digits of a NURBS surface with a net of weights against a dense
    /// oracle.
    #[test]
    fn nurbs_with_given_weights_are_least_squares(seed: u64, p in 1usize..4, q in 1usize..3) {
        let mut random = Random::new(seed);
        let knots = |degree: usize, inner: &[f64]| -> Vec<f64> {
            let ends = |x: f64| std::iter::repeat_n(x, degree + 1);
            ends(0.0).chain(inner.iter().copied()).chain(ends(2.0)).collect()
        };
        let (ku, kv) = (knots(p, &[0.7, 1.1]), knots(q, &[1.0]));
        let (nu, nv) = (p + 3, q + 2);
        let net = weights(&mut random, nu * nv);
        let m = 12 * nu * nv;
        let u: Vec<f64> = (0..m).map(|_| 2.0 * random.unit()).collect();
        let v: Vec<f64> = (0..m).map(|_| 2.0 * random.unit()).collect();
        let truth: Vec<f64> = (0..nu * nv).map(|_| random.unit()).collect();
        let rows: Vec<Vec<f64>> = (0..m).map(|k| rational_row([&ku, &kv], [p, q], &net, u[k], v[k])).collect();
        let z: Vec<f64> = rows.iter().map(|row| row.iter().zip(&truth).map(|(x, a)| x * a).sum::<f64>()).collect();
        let model = Model::BSpline {
            degree: Degree::Each(p, q),
            knots: Knots::Surface(ku.clone(), kv.clone()),
            weights: Some(net.clone()),
        };
        // a surface of the space is reproduced
        let exact = fit(&Nodes::scattered(u.clone(), v.clone(), z.clone(), None).unwrap(),
            &plain(model.clone())).unwrap();
        for (got, truth) in values(&exact).iter().zip(&truth) {
            prop_assert!((got - truth).abs() < 1e-9, "{got} {truth}");
        }
        let noisy: Vec<f64> = z.iter().map(|z| z + 0.1 * (random.unit() - 0.5)).collect();
        let spec = FitSpec {
            // a height of 0 takes positions as exact
            node_uncertainty: Some(NodeUncertainty { position: 1e-6, height: 0.0, kind: None }),
            ..plain(model.clone())
        };
        let scattered = Nodes::scattered(u.clone(), v.clone(), noisy.clone(), None).unwrap();
        let result = fit(&scattered, &spec).unwrap();
        // the residual is at right angles to every column
        let residuals = result.residuals.values.clone().unwrap();
        for j in 0..nu * nv {
            let dot: f64 = rows.iter().zip(&residuals).map(|(row, r)| row[j] * r).sum();
            prop_assert!(dot.abs() < 1e-12 * m as f64, "{dot:e}");
        }
        let Some(Shape::Surface(surface)) = shape_of(&spec, &result) else { panic!("a surface") };
        for k in 0..m {
            prop_assert!((surface.value(u[k], v[k]).x - (noisy[k] - residuals[k])).abs() < 1e-13);
        }
        // the same matrix posted as columns gives the same spectrum, estimates and bounds
        let matrix = Nodes::matrix(rows.concat(), nu * nv, noisy.clone(), None, None).unwrap();
        let posted = fit(&matrix, &FitSpec { model: Model::Linear, node_uncertainty: None, ..spec.clone() }).unwrap();
        let (a, b) = (&result.spectrum.eigenvalues, &posted.spectrum.eigenvalues);
        prop_assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-10 * b), "{a:?} {b:?}");
        for (a, b) in result.coefficients.iter().zip(&posted.coefficients) {
            prop_assert!((a.value - b.value).abs() < 1e-10
                && (a.error_given_lambda().unwrap() - b.error_given_lambda().unwrap()).abs() < 1e-10);
        }
        // slopes of the columns move the bounds on perturbation: against differences
        let h = 1e-6;
        let slopes: f64 = (0..m)
            .map(|k| {
                let at = |du: f64, dv: f64| rational_row([&ku, &kv], [p, q], &net, u[k] + du, v[k] + dv);
                let (u1, u0, v1, v0) = (at(h, 0.0), at(-h, 0.0), at(0.0, h), at(0.0, -h));
                (0..nu * nv)
                    .map(|j| {
                        let length: f64 = rows.iter().map(|row| row[j] * row[j]).sum();
                        (((u1[j] - u0[j]) / (2.0 * h)).powi(2) + ((v1[j] - v0[j]) / (2.0 * h)).powi(2)) / length
                    })
                    .sum::<f64>()
            })
            .sum();
        let bound = result.perturbation.as_ref().unwrap().least_squares.square_bound;
        if let (Some(bound), Some(condition)) = (bound, result.spectrum.condition) {
            let (kappa, norm) = (condition.sqrt(), result.spectrum.eigenvalues[nu * nv - 1].sqrt());
            let dx = 1e-6 * slopes.sqrt() / norm;
            let truth = kappa * dx / (1.0 - kappa * dx);
            // differences across a knot are no derivatives
            prop_assert!((bound - truth).abs() < 0.02 * truth, "{bound} {truth}");
        }
    }
}

/// With all weights equal a NURBS is the B-spline: grid, scattered, estimators and penalties.
#[test]
fn equal_weights_change_nothing() {
    let mut random = Random::new(3);
    let axis = |n: usize| (0..n).map(|i| i as f64 / (n - 1) as f64).collect::<Vec<f64>>();
    let (u, v) = (axis(14), axis(11));
    let z: Vec<f64> = u
        .iter()
        .flat_map(|u| v.iter().map(move |v| (3.0 * u).sin() * (2.0 * v).cos()))
        .map(|z| z + 0.01 * random.unit())
        .collect();
    let nodes = Nodes::grid(u, v, z, None, None).unwrap();
    let model = |weights| Model::BSpline { degree: Degree::Both(2), knots: Knots::SpansEach(3, 2), weights };
    let tikhonov = |order| {
        Regularization::Tikhonov(Tikhonov { order, weights: Some(vec![1.0, 0.5]), parameter: Parameter::Fixed(1e-2) })
    };
    for regularization in [
        Regularization::None,
        Regularization::default(),
        Regularization::Ridge { parameter: Parameter::Fixed(0.1) },
        Regularization::TruncatedSvd { rank: 15 },
        tikhonov(0),
        tikhonov(1),
        tikhonov(2),
    ] {
        let [one, two] = [None, Some(vec![2.0; 20])].map(|weights| {
            let spec = FitSpec { regularization: regularization.clone(), ..plain(model(weights)) };
            fit(&nodes, &spec).unwrap()
        });
        for (a, b) in one.coefficients.iter().zip(&two.coefficients) {
            assert!((a.value - b.value).abs() < 1e-11, "{regularization:?} {} {}", a.value, b.value);
            assert!((a.bias_bound - b.bias_bound).abs() < 1e-8 * (1.0 + a.bias_bound), "{regularization:?}");
        }
        assert!((one.residuals.rss - two.residuals.rss).abs() < 1e-11);
    }
    let spec = FitSpec { estimator: Estimator::LeastAbsolute, ..plain(model(Some(vec![0.5; 20]))) };
    let robust = fit(&nodes, &spec).unwrap();
    assert!(robust.robust.unwrap().converged);
}

/// The penalty of a NURBS curve is the integral of its squared second derivative.
#[test]
fn the_penalty_of_a_nurbs_is_its_roughness() {
    let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 39.0).collect();
    let y: Vec<f64> = x.iter().map(|x| (5.0 * x).sin()).collect();
    let weights = vec![1.0, 3.0, 0.7, 1.5, 2.0, 1.0, 0.8];
    let model = Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(4), weights: Some(weights) };
    let nodes = Nodes::curve(x.clone(), y.clone(), None).unwrap();
    // F A + λ P A = Xᵀy, so λ AᵀPA = Aᵀ Xᵀ(y − XA)
    let lambda = 1e-3;
    let regularization =
        Regularization::Tikhonov(Tikhonov { order: 2, weights: None, parameter: Parameter::Fixed(lambda) });
    let spec = FitSpec { regularization, scaling: Scaling::None, ..plain(model) };
    let result = fit(&nodes, &spec).unwrap();
    let Some(Shape::Curve(curve)) = shape_of(&spec, &result) else { panic!("a curve") };
    let residuals = result.residuals.values.as_ref().unwrap();
    let left: f64 = x.iter().zip(residuals).map(|(x, r)| curve.value(*x).x * r).sum();
    // Simpson over each span
    let cells = 4000;
    let roughness: f64 = (0..4)
        .map(|span| {
            let h = 0.25 / f64::from(cells);
            (0..=cells)
                .map(|i| {
                    let t = 0.25 * f64::from(span) + h * f64::from(i);
                    // the last place belongs to this span, not to the next one
                    let t = if i == cells { t - 1e-12 } else { t };
                    let weight = if i == 0 || i == cells {
                        1.0
                    } else if i % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    };
                    weight * curve.jet(t)[2].x.powi(2) * h / 3.0
                })
                .sum::<f64>()
        })
        .sum();
    assert!((left - lambda * roughness).abs() < 1e-8 * left, "{left} {}", lambda * roughness);
}

/// A quarter circle as NURBS: with its weights given, least squares finds its control points.
#[test]
fn a_circle_is_found_again() {
    let weights = vec![1.0, 0.5f64.sqrt(), 1.0];
    let knots = vec![0., 0., 0., 1., 1., 1.];
    let row = |t: f64| rational_row([&knots, &[0.0, 1.0]], [2, 0], &weights, t, 0.5);
    let t: Vec<f64> = (0..50).map(|i| f64::from(i) / 49.0).collect();
    let truth = [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]];
    for truth in truth {
        let y: Vec<f64> = t.iter().map(|t| row(*t).iter().zip(truth).map(|(r, a)| r * a).sum()).collect();
        let model = Model::BSpline {
            degree: Degree::Both(2),
            knots: Knots::Curve(knots.clone()),
            weights: Some(weights.clone()),
        };
        let result = fit(&Nodes::curve(t.clone(), y, None).unwrap(), &plain(model)).unwrap();
        assert!(values(&result).iter().zip(truth).all(|(a, b)| (a - b).abs() < 1e-14), "{:?}", values(&result));
    }
}

#[test]
fn weights_are_checked() {
    let x: Vec<f64> = (0..20).map(f64::from).collect();
    let nodes = Nodes::curve(x.clone(), x, None).unwrap();
    let field = |weights: Vec<f64>| {
        let model = Model::BSpline { degree: Degree::Both(2), knots: Knots::Spans(2), weights: Some(weights) };
        match fit(&nodes, &plain(model)) {
            Err(flankfit_engine::estimation::FitError::Invalid(faults)) => faults.list()[0].path.clone(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(field(vec![1.0; 3]), "model.weights");
    assert_eq!(field(vec![1.0, 1.0, 0.0, 1.0]), "model.weights[2]");
    let auto = Regularization::Spectral {
        scheme: flankfit_engine::estimation::spec::Scheme::Exact,
        count: Count::Given(1),
        condition_limit: 900.0,
        lambda_star: Parameter::Fixed(0.3),
    };
    let model =
        Model::BSpline { degree: Degree::Both(2), knots: Knots::Spans(2), weights: Some(vec![1.0, 2.0, 1.0, 1.0]) };
    assert!(fit(&nodes, &FitSpec { regularization: auto, ..plain(model) }).is_ok());
}
