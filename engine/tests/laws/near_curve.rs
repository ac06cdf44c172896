//! Curves near points: every coordinate is a fit of the service; circles; knots by data and by
//! residuals.

use flankfit_engine::estimation::FitError;
use flankfit_engine::estimation::near::{
    Adaptive, CurveFit, CurvePoints, CurveSettings, KnotPlacement, Parameters, Stop, curve,
};
use flankfit_engine::estimation::spec::{Degree, Estimator, FitSpec, Include, Knots, Model, Regularization};
use flankfit_engine::estimation::{Nodes, fit};
use flankfit_engine::geometry::curve::{Curve, parametrization::Parametrization};
use proptest::prelude::*;

use crate::near::plain;
use crate::oracle::random::Random;

fn asked(degree: usize, knots: KnotPlacement, weights: Option<Vec<f64>>) -> CurveSettings {
    CurveSettings { degree, knots, weights, spec: plain(Model::Linear) }
}

fn helix(count: usize) -> Vec<Vec<f64>> {
    let t = (0..count).map(|i| 6.0 * i as f64 / (count - 1) as f64);
    let points: Vec<[f64; 3]> = t.map(|t| [t.cos(), t.sin(), 0.2 * t]).collect();
    (0..3).map(|c| points.iter().map(|p| p[c]).collect()).collect()
}

fn fitted(coordinates: &[Vec<f64>], parameters: Parameters, asked: &CurveSettings) -> CurveFit {
    curve(&CurvePoints { coordinates, parameters, weight: None }, asked).unwrap()
}

#[test]
fn every_coordinate_is_a_fit_of_the_service() {
    let coordinates = helix(80);
    for spec in [
        plain(Model::Linear),
        FitSpec::new(Model::Linear),
        FitSpec {
            regularization: Regularization::None,
            estimator: Estimator::LeastAbsolute,
            ..FitSpec::new(Model::Linear)
        },
    ] {
        let asked = CurveSettings { spec: spec.clone(), ..asked(3, KnotPlacement::Spans(6), None) };
        let found = fitted(&coordinates, Parameters::By(Parametrization::ChordLength), &asked);
        let knots = Knots::Curve(found.curve.basis().knots().to_vec());
        for (y, result) in coordinates.iter().zip(&found.results) {
            let model = Model::BSpline { degree: Degree::Both(3), knots: knots.clone(), weights: None };
            let nodes = Nodes::curve(found.parameters.clone(), y.clone(), None).unwrap();
            let include = Include { residuals: true, ..spec.include };
            let alone = fit(&nodes, &FitSpec { model, include, ..spec.clone() }).unwrap();
            let values = |r: &flankfit_engine::estimation::FitResult| r.coefficients.clone();
            assert_eq!(values(&alone), values(result));
            assert_eq!(alone.spectrum, result.spectrum);
            assert_eq!(alone.residuals.rss.to_bits(), result.residuals.rss.to_bits());
        }
        let worst = (0..80)
            .map(|k| {
                let at = found.curve.value(found.parameters[k]);
                (0..3).map(|c| (at[c] - coordinates[c][k]).powi(2)).sum::<f64>().sqrt()
            })
            .fold(0.0, f64::max);
        assert!((worst - found.max_error).abs() < 1e-13, "{worst} {}", found.max_error);
    }
}

/// Points of a circle at the parameters of its quadratic NURBS with the weights of a circle:
/// control points, and the circle everywhere.
#[test]
fn a_circle_stays_a_circle() {
    let s = 0.5f64.sqrt();
    let weights = vec![1.0, s, 1.0, s, 1.0, s, 1.0, s, 1.0];
    let knots = vec![0., 0., 0., 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1., 1., 1.];
    let corners = [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]];
    let t: Vec<f64> = (0..101).map(|i| f64::from(i) / 100.0).collect();
    let place = |t: f64| {
        // a quarter: weights 1, s, 1 on Bernstein polynomials
        let quarter = ((4.0 * t).floor() as usize).min(3);
        let x = 4.0 * t - quarter as f64;
        let b = [(1.0 - x) * (1.0 - x), 2.0 * x * (1.0 - x) * s, x * x];
        let sum: f64 = b.iter().sum();
        [0, 1].map(|c| (0..3).map(|i| b[i] * corners[2 * quarter + i][c]).sum::<f64>() / sum)
    };
    let coordinates: Vec<Vec<f64>> = (0..2).map(|c| t.iter().map(|t| place(*t)[c]).collect()).collect();
    let found = fitted(&coordinates, Parameters::Given(&t), &asked(2, KnotPlacement::Given(knots), Some(weights)));
    for (p, corner) in found.curve.control_points().iter().zip(corners) {
        assert!((p.x - corner[0]).abs() < 1e-13 && (p.y - corner[1]).abs() < 1e-13, "{p:?}");
    }
    for i in 0..=1000 {
        assert!((found.curve.value(f64::from(i) / 1000.0).norm() - 1.0).abs() < 1e-13);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// Knots by residuals meet the tolerance on smooth points, and say so. No two neighbours lie
    /// more than twice their mean distance apart, so that knots can be placed where the curve is
    /// steep.
    #[test]
    fn adaptive_knots_meet_the_tolerance(seed: u64, degree in 2usize..5, power in 2i32..4, steep in 5.0f64..20.0) {
        let mut random = Random::new(seed);
        let mut x: Vec<f64> = (0..800).map(|i| (f64::from(i) + random.between(0.0, 1.0)) * 3.0 / 800.0).collect();
        x.extend([0.0, 3.0]);
        let y: Vec<f64> = x.iter().map(|x| (steep * (x - 1.3)).tanh() + 0.3 * x).collect();
        let tolerance = 10f64.powi(-power);
        let adaptive = Adaptive { spans: 2, tolerance, most_controls: 150 };
        let found = fitted(&[y], Parameters::Given(&x), &asked(degree, KnotPlacement::Adaptive(adaptive), None));
        let met = found.stop == Some(Stop::Tolerance) && found.max_error <= tolerance;
        prop_assert!(met, "{:?} {:?}", found.stop, found.steps.last());
        let last = found.steps.last().unwrap();
        prop_assert_eq!(&last.knots[..], found.curve.basis().knots());
        prop_assert!(last.max_error == found.max_error && last.rms_error == found.rms_error);
        // each round keeps the knots before it
        for pair in found.steps.windows(2) {
            prop_assert!(pair[0].knots.iter().all(|k| pair[1].knots.contains(k)));
            prop_assert!(pair[1].knots.len() > pair[0].knots.len());
        }
        // the steep place has the shorter spans
        let breaks = found.curve.breaks();
        let width = |at: f64| {
            let i = breaks.partition_point(|b| *b <= at);
            breaks[i] - breaks[i - 1]
        };
        prop_assert!(width(1.3) < width(2.7) || breaks.len() < 6);
    }
}

#[test]
fn adaptive_knots_end_where_they_must() {
    let mut random = Random::new(2);
    let x: Vec<f64> = (0..60).map(|i| f64::from(i) / 59.0).collect();
    let y: Vec<f64> = x.iter().map(|_| random.normal()).collect();
    let stop = |most_controls: usize| {
        let adaptive = Adaptive { spans: 1, tolerance: 1e-9, most_controls };
        fitted(std::slice::from_ref(&y), Parameters::Given(&x), &asked(3, KnotPlacement::Adaptive(adaptive), None))
    };
    let few = stop(20);
    assert_eq!((few.stop, few.curve.basis().size()), (Some(Stop::MostControls), 20));
    let all = stop(200);
    assert!(matches!(all.stop, Some(Stop::TooFewPoints | Stop::Tolerance)), "{:?}", all.stop);
    assert!(all.curve.basis().size() <= 60);
}

/// Tolerances that the points do not resolve: the curve stays near them, also between residuals.
#[test]
fn adaptive_knots_leave_no_swings_between_the_points() {
    let x: Vec<f64> = (0..=40).map(|i| f64::from(i) / 4.0).collect();
    let clean: Vec<f64> = x.iter().map(|x| x.sin()).collect();
    for degree in 1..=5 {
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            let adaptive = Adaptive { spans: 1, tolerance, most_controls: 200 };
            let knots = asked(degree, KnotPlacement::Adaptive(adaptive), None);
            let found = fitted(std::slice::from_ref(&clean), Parameters::Given(&x), &knots);
            let points = CurvePoints {
                coordinates: std::slice::from_ref(&clean),
                parameters: Parameters::Given(&x),
                weight: None,
            };
            let swing = found.swing(&points);
            assert!(swing < 0.1 && found.max_error < 0.05, "{degree} {tolerance} {swing} {}", found.max_error);
            for k in 0..=400 {
                let t = f64::from(k) / 40.0;
                let off = (found.curve.value(t).x - t.sin()).abs();
                assert!(off < 0.05, "{degree} {tolerance} {t} {off}");
            }
            assert!(found.steps.iter().all(|step| step.max_error >= found.max_error));
            assert!(found.curve.basis().size() <= 31.max(degree + 1));
        }
    }
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut x: Vec<f64> = (0..200).map(|_| random.between(0.0, 10.0)).collect();
        x.extend([0.0, 10.0]);
        let noisy: Vec<f64> = x.iter().map(|x| x.sin() + 0.1 * random.normal()).collect();
        let adaptive = Adaptive { spans: 4, tolerance: 1e-6, most_controls: 500 };
        let knots = asked(3, KnotPlacement::Adaptive(adaptive), None);
        let found = fitted(&[noisy], Parameters::Given(&x), &knots);
        assert_eq!(found.stop, Some(Stop::TooFewPoints));
        for k in 0..=2000 {
            let value = found.curve.value(f64::from(k) / 200.0).x;
            assert!(value.abs() < 5.0, "{seed} {k} {value}");
        }
    }
}

#[test]
fn averaged_knots_fit_and_errors_have_paths() {
    let coordinates = helix(50);
    let by = Parameters::By(Parametrization::Centripetal);
    let found = fitted(&coordinates, by, &asked(3, KnotPlacement::Averaged { controls: 12 }, None));
    assert_eq!(found.curve.basis().size(), 12);
    assert!(found.max_error < 5e-3, "{}", found.max_error);
    let field = |coordinates: &[Vec<f64>], parameters: Parameters, asked: &CurveSettings| match curve(
        &CurvePoints { coordinates, parameters, weight: None },
        asked,
    ) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    };
    let spans = asked(3, KnotPlacement::Spans(4), None);
    let mut bad = coordinates.clone();
    bad[1][7] = f64::NAN;
    assert_eq!(field(&bad, by, &spans), "points.xyz[7][1]");
    assert_eq!(field(&coordinates[..1], by, &spans), "points.parametrization");
    let many = asked(3, KnotPlacement::Averaged { controls: 70 }, None);
    assert_eq!(field(&coordinates, by, &many), "method.control_count");
    let knots = asked(3, KnotPlacement::Given(vec![0., 0., 0., 0., 2., 1., 3., 3., 3., 3.]), None);
    assert_eq!(field(&coordinates, by, &knots), "model.knots[5]");
    let weights = asked(3, KnotPlacement::Spans(2), Some(vec![1.0, 1.0, -1.0, 1.0, 1.0]));
    assert_eq!(field(&coordinates, by, &weights), "model.weights[2]");
    let outside = asked(3, KnotPlacement::Given(vec![0., 0., 0., 0., 0.5, 0.5, 0.5, 0.5]), None);
    assert!(field(&coordinates, by, &outside).starts_with("points.xyz["));
}

/// Knots do not cover a point of weight 0 outside the others.
#[test]
fn points_of_weight_0_say_nothing() {
    let x: Vec<f64> = (0..40).map(|i| f64::from(i) * 0.1).collect();
    let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
    let (mut longer, mut higher) = (x.clone(), y.clone());
    longer.extend([4.5, 6.0]);
    higher.extend([1e3, -1e3]);
    let weight: Vec<f64> = (0..42).map(|k| if k < 40 { 1.0 } else { 0.0 }).collect();
    let adaptive = Adaptive { tolerance: 1e-6, spans: 2, most_controls: 20 };
    for knots in [KnotPlacement::Spans(5), KnotPlacement::Averaged { controls: 9 }, KnotPlacement::Adaptive(adaptive)] {
        let asked = asked(3, knots, None);
        let plain = fitted(std::slice::from_ref(&y), Parameters::Given(&x), &asked);
        let points = CurvePoints {
            coordinates: std::slice::from_ref(&higher),
            parameters: Parameters::Given(&longer),
            weight: Some(&weight),
        };
        let silent = curve(&points, &asked).unwrap();
        assert_eq!(plain.curve, silent.curve);
        assert_eq!(plain.max_error, silent.max_error);
    }
    let nothing = vec![0.0; 42];
    let points = CurvePoints { coordinates: &[higher], parameters: Parameters::Given(&longer), weight: Some(&nothing) };
    assert!(curve(&points, &asked(3, KnotPlacement::Spans(5), None)).is_err());
}
