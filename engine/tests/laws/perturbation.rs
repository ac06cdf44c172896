//! Ineqs. 16–23, corrected: nodes moved within their uncertainty never move the coefficients
//! outside the bounds.

use crate::oracle::random::Random;
use crate::oracle::spectral::Columns;
use crate::problems::{Problem, assert_close, config, filter, fit, linear, matrix, polynomial, spectral};
use flankfit_engine::estimation::spec::{
    Count, Degree, FitSpec, NodeUncertainty, Parameter, PolynomialBasis, Regularization, Scaling, Scheme,
};
use flankfit_engine::estimation::{FitResult, Nodes};
use proptest::prelude::*;

fn relative_change(own: &FitResult, moved: &FitResult, scales: &[f64]) -> f64 {
    let (mut change, mut size) = (0.0, 0.0);
    for ((a, b), scale) in own.coefficients.iter().zip(&moved.coefficients).zip(scales) {
        change += ((a.least_squares - b.least_squares) * scale).powi(2);
        size += (a.least_squares * scale).powi(2);
    }
    (change / size).sqrt()
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn moved_entries_stay_within_the_bounds(
        seed: u64, n in 2usize..6, extra in 0usize..10, log_condition in 0.0f64..6.0, unit: bool, share in 0.0f64..1.0,
    ) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let spectrum = problem.spectrum(if unit { Columns::UnitLength } else { Columns::AsTheyAre });
        let scales: Vec<f64> = spectrum.scales.iter().map(|s| s.to_f64()).collect();
        let size = problem.x.concat().iter().fold(0.0f64, |s, x| s.max(x.abs()));
        let heights = problem.y.iter().fold(0.0f64, |s, y| s.max(y.abs()));
        let (position, height) = (1e-7 * share * size, 1e-7 * (1.0 - share) * heights);
        let node_uncertainty = Some(NodeUncertainty { position, height, kind: None });
        let spec = FitSpec { scaling, node_uncertainty, regularization: Regularization::None, ..linear() };
        let own = fit(&problem.nodes(), &spec);
        let bounds = &own.perturbation.as_ref().unwrap().least_squares;
        let bound = bounds.first_order_bound.unwrap();
        let mut random = Random::new(seed);
        let mut worst = 0.0f64;
        for _ in 0..60 {
            let mut by = |value: &f64, most: f64| value + if random.below(2) == 0 { most } else { -most };
            let x: Vec<Vec<f64>> = problem.x.iter().map(|row| row.iter().map(|x| by(x, position)).collect()).collect();
            let y: Vec<f64> = problem.y.iter().map(|y| by(y, height)).collect();
            worst = worst.max(relative_change(&own, &fit(&matrix(&x, &y, None), &spec), &scales));
        }
        // First order in 1e-7.
        prop_assert!(worst <= bound * 1.01, "moved by {worst:e}, bound {bound:e}");
        if extra == 0 {
            let square = bounds.square_bound.unwrap();
            prop_assert!(worst <= square * (1.0 + 1e-9), "moved by {worst:e}, bound {square:e}");
        }
    }

    #[test]
    fn moved_abscissae_stay_within_the_bounds(seed: u64, degree in 1usize..4, extra in 1usize..20,
        share in 0.0f64..1.0) {
        let mut random = Random::new(seed);
        let m = degree + 1 + extra;
        let x: Vec<f64> = (0..m).map(|_| random.between(30.0, 34.0)).collect();
        let y: Vec<f64> = x.iter().map(|x| 0.01 * (x - 32.0).powi(2) + 1e-3 * random.normal()).collect();
        let (position, height) = (1e-8 * share, 1e-8 * (1.0 - share));
        let node_uncertainty = Some(NodeUncertainty { position, height, kind: None });
        let spec = FitSpec {
            node_uncertainty,
            regularization: Regularization::None,
            ..polynomial(Degree::Both(degree), PolynomialBasis::Chebyshev)
        };
        let spec = FitSpec {
            // Fixed, so that the moved nodes are fitted in the same basis.
            domain: Some(flankfit_engine::estimation::spec::Domain { u: Some([29.9, 34.1]), v: None }),
            ..spec
        };
        let nodes = |x: &[f64], y: &[f64]| Nodes::curve(x.to_vec(), y.to_vec(), None).expect("checked nodes");
        let own = fit(&nodes(&x, &y), &spec);
        let columns = crate::oracle::design::curve(crate::oracle::design::Basis::Chebyshev([29.9, 34.1]), degree, &x);
        let scales: Vec<f64> = (0..=degree)
            .map(|j| columns.iter().map(|row| row[j].to_f64().powi(2)).sum::<f64>().sqrt())
            .collect();
        let bound = own.perturbation.as_ref().unwrap().least_squares.first_order_bound.unwrap();
        let mut worst = 0.0f64;
        for _ in 0..60 {
            let mut by = |value: &f64, most: f64| value + if random.below(2) == 0 { most } else { -most };
            let moved_x: Vec<f64> = x.iter().map(|x| by(x, position)).collect();
            let moved_y: Vec<f64> = y.iter().map(|y| by(y, height)).collect();
            worst = worst.max(relative_change(&own, &fit(&nodes(&moved_x, &moved_y), &spec), &scales));
        }
        prop_assert!(worst <= bound * 1.01, "moved by {worst:e}, bound {bound:e}");
        prop_assert!(bound <= 1e4 * worst.max(1e-12), "the bound {bound:e} cannot show beside {worst:e}");
    }

    #[test]
    fn bounds_by_their_formulas(seed: u64, n in 2usize..6, extra in 1usize..10, log_condition in 1.0f64..6.0,
        unit: bool) {
        let problem = Problem::graded(seed, n, extra, log_condition);
        let scaling = if unit { Scaling::UnitLength } else { Scaling::None };
        let spectrum = problem.spectrum(if unit { Columns::UnitLength } else { Columns::AsTheyAre });
        let sums = spectrum.sums();
        let (position, height) = (1e-6, 2e-6);
        let node_uncertainty = Some(NodeUncertainty { position, height, kind: None });
        let t = (sums.lambda[0] * sums.lambda[n - 1]).sqrt();
        let regularization = spectral(Scheme::FirstOrder, Count::Given(1), Parameter::Fixed(t));
        let spec = FitSpec { scaling, node_uncertainty, regularization, ..linear() };
        let report = fit(&problem.nodes(), &spec).perturbation.unwrap();

        // ‖δX‖ in the scaled columns when every entry moves by `position`, ‖δY‖ when every height
        // moves by `height`.
        let m = problem.y.len() as f64;
        let moved_x = position * spectrum.scales.iter().map(|s| m / s.to_f64().powi(2)).sum::<f64>().sqrt();
        let moved_y = height * m.sqrt();
        let heights = problem.y.iter().map(|y| y * y).sum::<f64>().sqrt();
        let (own, after) = (filter(Scheme::FirstOrder, 0), filter(Scheme::FirstOrder, 1));
        for (bounds, filter) in [(&report.least_squares, own), (&report.regularized, after)] {
            let mu = sums.regularized(filter, t);
            let norm = mu.iter().copied().fold(0.0, f64::max).sqrt();
            let kappa = sums.condition(filter, t).sqrt();
            let factors = sums.factors(filter, t);
            let estimate = sums.a.iter().zip(&factors).map(|(a, f)| (a * f).powi(2)).sum::<f64>().sqrt();
            let (in_x, in_y) = (moved_x / norm, moved_y / heights);
            let first = kappa * (in_x + in_y * heights / (norm * estimate))
                + kappa * kappa * in_x * sums.rss.sqrt() / (norm * estimate);
            assert_close("first order", bounds.first_order_bound.unwrap(), first, 1e-6, 0.0);
            match bounds.square_bound {
                Some(bound) => {
                    assert_close("square", bound, kappa * (in_x + in_y) / (1.0 - kappa * in_x), 1e-5, 0.0);
                }
                None => prop_assert!(kappa * in_x > 1.0 - 1e-9),
            }
        }
    }

    #[test]
    fn regularisation_lowers_the_bound(seed: u64, n in 3usize..7, log_condition in 4.0f64..9.0) {
        let problem = Problem::graded(seed, n, 6, log_condition);
        let sums = problem.spectrum(Columns::UnitLength).sums();
        prop_assume!(sums.lambda[n - 1] / sums.lambda[0] > 1e3 && sums.lambda[1] > 4.0 * sums.lambda[0]);
        let node_uncertainty = Some(NodeUncertainty { position: 0.0, height: 1e-9, kind: None });
        let t = 2.0 * sums.lambda[0];
        let regularization = spectral(Scheme::Exact, Count::Given(1), Parameter::Fixed(t));
        let report = fit(&problem.nodes(),
            &FitSpec { node_uncertainty, regularization, ..linear() }).perturbation.unwrap();
        let (before, after) = (report.least_squares, report.regularized);
        // Only heights move: the bound is κ(X̄) ε ‖Y‖ / (‖X̄‖ ‖Â_B‖).
        let estimate = |f: &[f64]| sums.a.iter().zip(f).map(|(a, f)| (a * f).powi(2)).sum::<f64>().sqrt();
        let (one, factors) = (vec![1.0; n], sums.factors(filter(Scheme::Exact, 1), t));
        let expected = (sums.lambda[0] / t).sqrt() * estimate(&one) / estimate(&factors);
        let ratio = after.first_order_bound.unwrap() / before.first_order_bound.unwrap();
        assert_close("ratio of the bounds", ratio, expected, 1e-6, 0.0);
    }
}

#[test]
fn no_uncertainty_no_report() {
    assert_eq!(fit(&Problem::graded(1, 3, 4, 2.0).nodes(), &linear()).perturbation, None);
}
