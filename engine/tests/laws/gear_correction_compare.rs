//! Prediction and measurement: whether the machine responded as predicted.

use flankfit_engine::estimation::FitError;
use flankfit_engine::gear::correction::{
    Answer, Comparison, Correction, CorrectionSpec, Noise, Scatter, Verdict, compare,
};
use flankfit_engine::gear::simulation::{Simulation, Strategy, case, run};

fn names(count: usize) -> Vec<String> {
    (0..count).map(|j| format!("s{j}")).collect()
}

/// A machine of the ill-conditioned case whose response is `factor` times the one that it was drawn
/// with.
fn answer(seed: u64, factor: f64, extra: impl Fn(usize) -> f64) -> Answer {
    let mut machine = Simulation::new(case::ill_conditioned(seed)).unwrap();
    let asked = machine.spec().clone();
    let before = machine.measure();
    let correction = Correction::new(CorrectionSpec {
        noise_sigma: Some(asked.probe_noise),
        response_uncertainty: asked.response_noise,
        ..CorrectionSpec::new(before, asked.sensitivity, asked.settings)
    })
    .unwrap();
    let solution = correction.solve().unwrap();
    let change: Vec<f64> = solution.settings.iter().map(|s| s.change).collect();
    machine.apply(&change.iter().map(|x| factor * x).collect::<Vec<_>>()).unwrap();
    let measured = machine.measure().iter().enumerate().map(|(k, d)| d + extra(k)).collect();
    compare(&correction.comparison(&change, solution.leverage, solution.noise.unwrap(), measured)).unwrap()
}

fn count(verdict: Verdict, factor: f64, extra: impl Fn(usize) -> f64 + Copy) -> usize {
    (0..200).filter(|&seed| answer(seed, factor, extra).verdict == verdict).count()
}

#[test]
fn weak_and_strong_responses_are_detected() {
    assert!(count(Verdict::Weaker, 0.6, |_| 0.0) >= 196);
    assert!(count(Verdict::NoResponse, 0.0, |_| 0.0) >= 196);
    assert!(count(Verdict::Stronger, 1.5, |_| 0.0) >= 196);
}

/// A bump that no multiple of the prediction explains, and a machine that went the other way.
#[test]
fn other_responses_are_different() {
    assert!(count(Verdict::Different, 1.0, |k| if k % 9 < 3 { 4.0 } else { -2.0 }) >= 190);
    assert!(count(Verdict::Different, -1.0, |_| 0.0) >= 196);
}

/// Settings that run away may do anything to the flank: that they did is no answer as predicted,
/// and how much came is not known.
#[test]
fn a_correction_that_may_do_anything_is_never_answered_as_predicted() {
    let (mut undecided, mut worse) = (0, 0);
    for seed in 0..60 {
        let run = run(&case::ill_conditioned(seed), &Strategy::least_squares(), 0.02, 2).unwrap();
        for answer in run.rounds.iter().filter_map(|round| round.answer.as_ref()) {
            if answer.rms_measured_um > answer.rms_before_um {
                worse += 1;
                assert_ne!(answer.verdict, Verdict::AsPredicted, "{seed}: {}", answer.sentence);
            }
            if answer.verdict == Verdict::Undecided {
                undecided += 1;
                assert_eq!((answer.response_ratio, answer.response_ratio_std_error), (None, None));
                assert!(
                    answer.sentence.contains("cannot show") && !answer.sentence.contains('%'),
                    "{}",
                    answer.sentence
                );
            }
        }
    }
    assert!(undecided > 50 && worse > 50, "{undecided} {worse}");
}

/// A change of 5 µm over forty nodes that one setting makes, of which the share `came` arrives.
fn one_setting(sigma: f64, response_uncertainty: f64, came: f64) -> Answer {
    let before: Vec<f64> = (0..40).map(|k| if k % 2 == 0 { 5.0 } else { -5.0 }).collect();
    let measured = before.iter().enumerate().map(|(k, d)| d * (1.0 - came) + 0.1 * f64::from(k as i32 % 3 - 1));
    compare(&Comparison {
        measured: measured.collect(),
        weight: None,
        settings: names(1),
        contributions: before.iter().map(|d| -d).collect(),
        leverage: None,
        before,
        noise: Noise { sigma, freedom: None },
        response_uncertainty,
        absolute: true,
        traces: None,
        scatter: Scatter::default(),
    })
    .unwrap()
}

#[test]
fn what_undecidable_is_undecided_and_has_no_ratio() {
    for (noise, response) in [(0.1, 0.02), (0.5, 0.1), (3.5, 0.0)] {
        let answer = one_setting(noise, response, 1.0);
        assert_eq!(answer.verdict, Verdict::AsPredicted, "{}", answer.sentence);
        assert!(answer.response_ratio.is_some() && answer.response_ratio_std_error.unwrap() < 0.168);
        let none = one_setting(noise, response, 0.0);
        assert_eq!(none.verdict, Verdict::NoResponse, "{}", none.sentence);
    }
    // a half is not excluded, a ratio is shown all the same
    let half = one_setting(4.0, 0.0, 1.0);
    assert_eq!(half.verdict, Verdict::Undecided, "{}", half.sentence);
    assert!(half.response_ratio.is_some() && half.sentence.contains("% of the predicted change"));
    // whatever came, from nothing to half as much again
    for (noise, response) in [(8.0, 0.0), (0.1, 0.35)] {
        for came in [0.0, 0.5, 1.0, 1.4] {
            let answer = one_setting(noise, response, came);
            assert_eq!(answer.verdict, Verdict::Undecided, "{noise} {response}: {}", answer.sentence);
            assert_eq!(answer.response_ratio, None);
        }
    }
    // far above 1, though each node alone would allow it
    let far = one_setting(8.0, 0.0, 3.5);
    assert!(far.chi_squared < far.chi_squared_limit);
    assert_eq!(far.verdict, Verdict::Stronger, "{}", far.sentence);
    // no response at all, or a weak one
    let none = one_setting(5.0, 0.0, 0.0);
    assert!(none.chi_squared < none.chi_squared_limit);
    assert_eq!(none.verdict, Verdict::Weaker, "{}", none.sentence);
}

/// Measured twice without a correction of the machine: what the correction took from the noise of
/// the first measurement is no answer.
#[test]
fn the_noise_of_the_first_measurement_is_taken_out() {
    let at = |leverage: Option<Vec<f64>>| {
        compare(&Comparison {
            before: vec![4.0, -3.0, 1.0],
            measured: vec![1.0, -1.0, 0.5],
            weight: Some(vec![1.0, 4.0, 0.25]),
            settings: names(2),
            contributions: vec![-2.0, -1.5, 1.5, 1.0, 0.5, -1.0],
            leverage,
            noise: Noise { sigma: 0.2, freedom: None },
            response_uncertainty: 0.0,
            absolute: true,
            traces: None,
            scatter: Scatter::default(),
        })
        .unwrap()
    };
    // c = (−3.5, 2.5, −0.5), ⟨c, c⟩ = 12.25 + 25 + 0.0625, ⟨c, d' − d⟩ = 10.5 + 20 + 0.0625
    let (square, came, variance) = (37.3125, 30.5625, 0.04);
    let close = |got: Option<f64>, want: f64| assert!((got.unwrap() - want).abs() < 1e-12, "{got:?} is not {want}");
    let given = at(None);
    close(given.response_ratio, came / square);
    close(given.response_ratio_std_error, (2.0 * variance / square).sqrt());
    let computed = at(Some(vec![0.9, 0.7, 0.4]));
    close(computed.response_ratio, (came - 2.0 * variance) / square);
    close(computed.response_ratio_std_error, (2.0 * variance / square + 2.0 * (variance / square).powi(2)).sqrt());
}

/// Errors of whole columns that η allows are explained, whatever single entries would allow.
#[test]
fn a_column_that_is_off_within_the_uncertainty_is_no_other_machine() {
    let of = |off: f64| {
        let (one, two) = (|k: usize| f64::from(k as i32 % 2), |k: usize| 1.0 - f64::from(k as i32 % 2));
        compare(&Comparison {
            before: (0..200).map(|k| -10.0 * one(k) - 10.0 * two(k)).collect(),
            measured: (0..200).map(|k| 10.0 * off * (one(k) - two(k)) + 0.05 * f64::from(k as i32 % 5 - 2)).collect(),
            weight: None,
            settings: names(2),
            contributions: (0..200).flat_map(|k| [10.0 * one(k), 10.0 * two(k)]).collect(),
            leverage: None,
            noise: Noise { sigma: 0.1, freedom: None },
            response_uncertainty: 0.05,
            absolute: true,
            traces: None,
            scatter: Scatter::default(),
        })
        .unwrap()
    };
    assert_eq!(of(0.08).verdict, Verdict::AsPredicted, "{}", of(0.08).sentence);
    assert_eq!(of(0.6).verdict, Verdict::Different, "{}", of(0.6).sentence);
}

#[test]
fn the_ratio_is_how_much_of_the_change_came() {
    for seed in 0..50 {
        let comparison = answer(seed, 0.7, |_| 0.0);
        let (ratio, error) = (comparison.response_ratio.unwrap(), comparison.response_ratio_std_error.unwrap());
        assert!((ratio - 0.7).abs() < 5.0 * error.hypot(0.01), "{ratio} ± {error}");
        assert!(comparison.rms_measured_um > comparison.rms_predicted_um && comparison.nodes >= 36);
    }
}

#[test]
fn numbers_are_those_of_their_definitions() {
    let comparison = compare(&Comparison {
        before: vec![4.0, -4.0, 2.0, f64::NAN],
        measured: vec![1.0, -2.0, 1.0, 3.0],
        weight: None,
        settings: names(1),
        contributions: vec![-3.0, 3.0, -2.0, 1.0],
        leverage: None,
        noise: Noise { sigma: 1.0, freedom: None },
        response_uncertainty: 0.0,
        absolute: true,
        traces: None,
        scatter: Scatter::default(),
    })
    .unwrap();
    let close = |got: f64, want: f64| assert!((got - want).abs() < 1e-9, "{got} is not {want}");
    assert_eq!((comparison.nodes, comparison.verdict), (3, Verdict::Undecided));
    close(comparison.rms_before_um, 12f64.sqrt());
    close(comparison.rms_predicted_um, (2.0f64 / 3.0).sqrt());
    close(comparison.rms_measured_um, 2f64.sqrt());
    close(comparison.rms_predicted_change_um, (22.0f64 / 3.0).sqrt());
    close(comparison.rms_difference_um, (2.0f64 / 3.0).sqrt());
    close(comparison.rms_expected_difference_um, 2f64.sqrt());
    close(comparison.chi_squared, 1.0);
    // c = (−3, 3, −2), came (−3, 2, −1)
    close(comparison.response_ratio.unwrap(), 17.0 / 22.0);
    close(comparison.response_ratio_std_error.unwrap(), (2.0f64 / 22.0).sqrt());
    // tables: 16.266
    assert!((comparison.chi_squared_limit - 16.266).abs() < 0.3);
}

/// The uncertainty of the machine counts in full, and as if all settings erred the same way at
/// every node: the interval of the ratio holds more often than it says.
#[test]
fn the_interval_of_the_ratio_is_wide() {
    for factor in [0.7, 1.0] {
        let hits = (0..600).filter(|&seed| {
            let comparison = answer(seed, factor, |_| 0.0);
            let [low, high] = comparison.response_ratio_interval.unwrap();
            (low..=high).contains(&factor)
        });
        let held = hits.count() as f64 / 600.0;
        println!("{factor}: {held}");
        assert!(held >= 0.97, "{factor}: {held}");
    }
}

#[test]
fn a_zero_prediction_has_no_ratio_and_errors_have_paths() {
    let still = Comparison {
        before: vec![0.1; 5],
        measured: vec![9.0; 5],
        weight: None,
        settings: names(1),
        contributions: vec![0.0; 5],
        leverage: None,
        noise: Noise { sigma: 0.1, freedom: None },
        response_uncertainty: 0.02,
        absolute: true,
        traces: None,
        scatter: Scatter::default(),
    };
    let comparison = compare(&still).unwrap();
    assert_eq!((comparison.verdict, comparison.response_ratio), (Verdict::Different, None));
    let path = |wrong: Comparison| match compare(&wrong) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(path(Comparison { measured: vec![0.0; 4], ..still.clone() }), "measured");
    assert_eq!(path(Comparison { noise: Noise { sigma: -1.0, freedom: None }, ..still.clone() }), "noise.sigma");
    assert_eq!(path(Comparison { measured: vec![f64::NAN; 5], ..still.clone() }), "measured");
    assert_eq!(path(Comparison { leverage: Some(vec![-1.0; 5]), ..still.clone() }), "leverage[0]");
    assert_eq!(path(Comparison { contributions: vec![f64::INFINITY; 5], ..still.clone() }), "contributions[0]");
    assert_eq!(path(Comparison { settings: names(2), ..still }), "contributions");
}

/// Without a datum both measurements may have any mean of their own.
#[test]
fn without_a_datum_means_do_not_matter() {
    let of = |before: f64, after: f64, factor: f64| {
        let c = |k: usize| 5.0 * ((k as f64) * 0.7).sin();
        compare(&Comparison {
            before: (0..40).map(|k| before - c(k)).collect(),
            measured: (0..40).map(|k| after - c(k) + factor * c(k) + 0.05 * f64::from(k as i32 % 3 - 1)).collect(),
            weight: None,
            settings: names(1),
            contributions: (0..40).map(c).collect(),
            leverage: None,
            noise: Noise { sigma: 0.1, freedom: None },
            response_uncertainty: 0.02,
            absolute: false,
            traces: None,
            scatter: Scatter::default(),
        })
        .unwrap()
    };
    for factor in [0.5, 1.0] {
        let (one, other) = (of(0.0, 0.0, factor), of(30.0, -70.0, factor));
        assert_eq!((one.verdict, other.verdict == Verdict::AsPredicted), (other.verdict, factor == 1.0));
        assert!((one.response_ratio.unwrap() - other.response_ratio.unwrap()).abs() < 1e-9);
        assert!((one.rms_difference_um - other.rms_difference_um).abs() < 1e-9);
    }
}
