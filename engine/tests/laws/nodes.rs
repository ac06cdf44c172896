//! The same nodes said in another way: weights and repetition, order, grid and scattered, missing
//! nodes, the matrix itself.

use crate::oracle::random::Random;
use crate::problems::{
    Problem, Surface, assert_close, assert_same_fit, config, fit, linear, matrix, polynomial, spectral, values,
};
use flankfit_engine::estimation::spec::{
    Count, Degree, FitSpec, Include, Model, Parameter, PolynomialBasis, Regularization, Scaling, Scheme, Terms,
};
use flankfit_engine::estimation::{FitResult, Nodes};
use proptest::prelude::*;

fn regularizations() -> Vec<Regularization> {
    vec![
        Regularization::None,
        spectral(Scheme::FirstOrder, Count::Given(2), Parameter::Fixed(1e-4)),
        spectral(Scheme::Exact, Count::Auto, Parameter::Fixed(1e-3)),
        Regularization::Ridge { parameter: Parameter::Fixed(1e-5) },
    ]
}

fn residuals(result: &FitResult) -> &[f64] {
    result.residuals.values.as_ref().expect("residuals were asked for")
}

fn with_residuals(spec: FitSpec) -> FitSpec {
    FitSpec { include: Include { residuals: true, ..Include::default() }, ..spec }
}

/// Posted places and the heights at those in `keep`.
fn subset(surface: &Surface, keep: &[bool]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let kept = || surface.nodes.iter().zip(&surface.z).zip(keep).filter(|(_, k)| **k);
    (
        kept().map(|((n, _), _)| n[0]).collect(),
        kept().map(|((n, _), _)| n[1]).collect(),
        kept().map(|((_, z), _)| *z).collect(),
    )
}

proptest! {
    #![proptest_config(config(32))]

    #[test]
    fn a_whole_weight_is_that_many_nodes(seed: u64, n in 3usize..7, log_condition in 0.0f64..8.0) {
        let problem = Problem::graded(seed, n, 6, log_condition);
        let mut random = Random::new(seed);
        let weight: Vec<usize> = problem.y.iter().map(|_| random.below(4)).collect();
        prop_assume!(weight.iter().filter(|w| **w > 0).count() > n);
        let times = |k: usize| (0..weight[k]).map(move |_| k);
        let repeated: Vec<usize> = (0..weight.len()).flat_map(times).collect();
        let x: Vec<Vec<f64>> = repeated.iter().map(|k| problem.x[*k].clone()).collect();
        let y: Vec<f64> = repeated.iter().map(|k| problem.y[*k]).collect();
        let weighted = matrix(&problem.x, &problem.y, Some(weight.iter().map(|w| *w as f64).collect()));
        for regularization in regularizations() {
            for scaling in [Scaling::UnitLength, Scaling::None] {
                let spec = FitSpec { regularization: regularization.clone(), scaling, ..linear() };
                let (one, two) = (fit(&weighted, &spec), fit(&matrix(&x, &y, None), &spec));
                assert_same_fit(&one, &two, 1e-9);
                prop_assert_eq!(one.residuals.count, weight.iter().filter(|w| **w > 0).count());
                prop_assert_eq!(one.residuals.degrees_of_freedom, one.residuals.count - n);
                assert_close("rms", one.residuals.rms, two.residuals.rms, 1e-9, 0.0);
            }
        }
    }

    #[test]
    fn order_does_not_matter(seed: u64, decay in 0.1f64..0.8) {
        let mut surface = Surface::new(seed, [2, 2], decay, 5e-4);
        let own = surface.scattered();
        let mut order: Vec<usize> = (0..surface.z.len()).collect();
        Random::new(seed).shuffle(&mut order);
        surface.nodes = order.iter().map(|k| surface.nodes[*k]).collect();
        surface.z = order.iter().map(|k| surface.z[*k]).collect();
        for regularization in regularizations() {
            let spec = with_residuals(FitSpec { regularization,
                ..polynomial(Degree::Both(2), PolynomialBasis::Monomial) });
            let (one, two) = (fit(&own, &spec), fit(&surface.scattered(), &spec));
            assert_same_fit(&one, &two, 1e-9);
            for (place, k) in order.iter().enumerate() {
                assert_close("residual", residuals(&one)[*k], residuals(&two)[place], 0.0, 1e-12);
            }
        }
    }

    #[test]
    fn a_grid_is_its_nodes_scattered(seed: u64, decay in 0.1f64..0.8, basis in 0usize..3) {
        let surface = Surface::new(seed, [3, 2], decay, 5e-4);
        let basis = [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre][basis];
        for terms in [Terms::Tensor, Terms::Total] {
            for regularization in regularizations() {
                let degree = if terms == Terms::Total { Degree::Both(2) } else { Degree::Each(3, 2) };
                let model = Model::Polynomial { degree, basis, terms: terms.clone() };
                let spec = with_residuals(FitSpec { regularization, ..FitSpec::new(model) });
                let (one, two) = (fit(&surface.grid(), &spec), fit(&surface.scattered(), &spec));
                assert_same_fit(&one, &two, 1e-9);
                prop_assert_eq!(&one.domain, &two.domain);
                for (p, q) in residuals(&one).iter().zip(residuals(&two)) {
                    assert_close("residual", *p, *q, 0.0, 1e-12);
                }
            }
        }
    }

    #[test]
    fn missing_nodes_are_left_out(seed: u64, decay in 0.1f64..0.8, missing in 1usize..20, how in 0usize..3) {
        let surface = Surface::new(seed, [2, 2], decay, 5e-4);
        let mut keep = vec![true; surface.z.len()];
        let mut random = Random::new(seed);
        (0..missing).for_each(|_| keep[random.below(surface.z.len())] = false);
        let (u, v) = (surface.u.clone(), surface.v.clone());
        let masked = |bad: f64| keep.iter().zip(&surface.z).map(|(k, z)| if *k { *z } else { bad }).collect();
        let grid = match how {
            0 => Nodes::grid(u, v, masked(f64::NAN), None, None),
            1 => Nodes::grid(u, v, masked(1e6), Some(keep.clone()), None),
            _ => Nodes::grid(u, v, masked(-1e9), None, Some(keep.iter().map(|k| if *k { 1.0 } else { 0.0 }).collect())),
        }
        .expect("checked nodes");
        let (u, v, z) = subset(&surface, &keep);
        let scattered = Nodes::scattered(u, v, z, None).expect("checked nodes");
        for basis in [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev] {
            for regularization in regularizations() {
                let spec = with_residuals(FitSpec { regularization, ..polynomial(Degree::Both(2), basis) });
                let (one, two) = (fit(&grid, &spec), fit(&scattered, &spec));
                assert_same_fit(&one, &two, 1e-9);
                prop_assert_eq!(&one.domain, &two.domain);
                prop_assert_eq!(one.residuals.count, keep.iter().filter(|k| **k).count());
                let places: Vec<usize> = (0..keep.len()).filter(|k| keep[*k]).collect();
                prop_assert_eq!(one.residuals.node_indices.as_ref(), Some(&places));
                for (p, q) in residuals(&one).iter().zip(residuals(&two)) {
                    assert_close("residual", *p, *q, 0.0, 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_polynomial_is_the_matrix_of_its_monomials(seed: u64, decay in 0.1f64..0.8, degree in 1usize..4) {
        // Abscissae of few bits: their powers are exact doubles, so both ways pose the same
        // problem.
        let surface = Surface::new(seed, [2, 2], decay, 5e-4);
        let curve = surface.nodes.iter().map(|n| n[0]).collect::<Vec<f64>>();
        let powers = |t: f64| (0..=degree as i32).map(move |p| t.powi(p)).collect::<Vec<f64>>();
        let x: Vec<Vec<f64>> = curve.iter().map(|t| powers(*t)).collect();
        let nodes = Nodes::curve(curve, surface.z.clone(), None).expect("checked nodes");
        for regularization in regularizations() {
            let regularization = match regularization {
                Regularization::Spectral { scheme, lambda_star, .. } => spectral(scheme, Count::Given(1), lambda_star),
                other => other,
            };
            for scaling in [Scaling::UnitLength, Scaling::None] {
                let of = |model: FitSpec| FitSpec { regularization: regularization.clone(), scaling, ..model };
                let one = fit(&nodes, &of(polynomial(Degree::Both(degree), PolynomialBasis::Monomial)));
                let two = fit(&matrix(&x, &surface.z, None), &of(linear()));
                assert_same_fit(&one, &two, 1e-9);
            }
        }
    }
}

#[test]
fn nodes_of_weight_0_say_nothing() {
    let problem = Problem::graded(9, 3, 8, 5.0);
    let mut weight = vec![2.0; problem.y.len()];
    (weight[0], weight[5]) = (0.0, 0.0);
    let mut wild = problem.clone();
    (wild.y[0], wild.y[5]) = (1e9, -1e9);
    wild.x[0] = vec![1e8; 3];
    let one = fit(&matrix(&problem.x, &problem.y, Some(weight.clone())), &linear());
    let two = fit(&matrix(&wild.x, &wild.y, Some(weight)), &linear());
    assert_eq!(values(&one), values(&two));
    assert_eq!(one.residuals, two.residuals);
}
