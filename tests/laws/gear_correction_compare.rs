//! Predicted beside measured: whether the machine answered as predicted.

use flankfit::gear::correction::{Answer, Asked, Comparison, Correction, Verdict, compare};
use flankfit::gear::simulation::{Simulation, case};

/// A machine of the ill-conditioned case whose response is `factor` times the one that it was drawn with.
fn answer(seed: u64, factor: f64, extra: impl Fn(usize) -> f64) -> Answer {
    let mut machine = Simulation::new(case::ill_conditioned(seed)).unwrap();
    let asked = machine.asked().clone();
    let before = machine.measure();
    let correction = Asked {
        noise_sigma: Some(asked.probe_noise),
        response_uncertainty: asked.response_noise,
        ..Asked::new(before.clone(), asked.sensitivity, asked.settings)
    };
    let solution = Correction::new(correction).unwrap().solve().unwrap();
    let change: Vec<f64> = solution.settings.iter().map(|s| factor * s.change).collect();
    machine.apply(&change).unwrap();
    let measured = machine.measure().iter().enumerate().map(|(k, d)| d + extra(k)).collect();
    compare(&Comparison {
        before,
        predicted: solution.predicted.deviation,
        measured,
        noise_sigma: asked.probe_noise,
        uncertainty: Some(solution.predicted.uncertainty),
        response_uncertainty: asked.response_noise,
    })
    .unwrap()
}

fn count(verdict: Verdict, factor: f64, extra: impl Fn(usize) -> f64 + Copy) -> usize {
    (0..200).filter(|&seed| answer(seed, factor, extra).verdict == verdict).count()
}

/// A machine that is what J says within its uncertainty is called something else about once in a thousand corrections.
#[test]
fn a_true_machine_answers_as_predicted() {
    let told = (0..2000).filter(|&seed| answer(seed, 1.0, |_| 0.0).verdict != Verdict::AsPredicted).count();
    assert!(told <= 8, "{told} of 2000 false alarms");
}

#[test]
fn weak_and_strong_answers_are_told() {
    assert!(count(Verdict::Weaker, 0.6, |_| 0.0) >= 196);
    assert!(count(Verdict::Weaker, 0.0, |_| 0.0) >= 196);
    assert!(count(Verdict::Stronger, 1.5, |_| 0.0) >= 196);
}

/// A bump that no multiple of the prediction explains, and a machine that went the other way.
#[test]
fn other_answers_are_different() {
    assert!(count(Verdict::Different, 1.0, |k| if k % 9 < 3 { 4.0 } else { -2.0 }) >= 190);
    assert!(count(Verdict::Different, -1.0, |_| 0.0) >= 196);
}

#[test]
fn the_ratio_is_how_much_of_the_change_came() {
    for seed in 0..50 {
        let told = answer(seed, 0.7, |_| 0.0);
        let (ratio, error) = (told.response_ratio.unwrap(), told.response_ratio_std_error.unwrap());
        assert!((ratio - 0.7).abs() < 5.0 * error.hypot(0.01), "{ratio} ± {error}");
        assert!(told.measured_rms > told.predicted_rms && told.nodes >= 36);
    }
}

#[test]
fn numbers_are_those_of_their_definitions() {
    let told = compare(&Comparison {
        before: vec![4.0, -4.0, 2.0, f64::NAN],
        predicted: vec![1.0, -1.0, 0.0, 3.0],
        measured: vec![1.0, -2.0, 1.0, 3.0],
        noise_sigma: 1.0,
        uncertainty: None,
        response_uncertainty: 0.0,
    })
    .unwrap();
    let close = |got: f64, want: f64| assert!((got - want).abs() < 1e-9, "{got} is not {want}");
    assert_eq!((told.nodes, told.verdict), (3, Verdict::AsPredicted));
    close(told.before_rms, 12f64.sqrt());
    close(told.predicted_rms, (2.0f64 / 3.0).sqrt());
    close(told.measured_rms, 2f64.sqrt());
    close(told.difference_rms, (2.0f64 / 3.0).sqrt());
    close(told.expected_difference_rms, 2f64.sqrt());
    close(told.chi_squared, 1.0);
    // c = (−3, 3, −2), came (−3, 2, −1)
    close(told.response_ratio.unwrap(), 17.0 / 22.0);
    close(told.response_ratio_std_error.unwrap(), (2.0f64 / 22.0).sqrt());
    // tables: 16.266
    assert!((told.chi_squared_limit - 16.266).abs() < 0.3);
}

#[test]
fn nothing_predicted_has_no_ratio_and_faults_have_their_places() {
    let still = Comparison {
        before: vec![0.1; 5],
        predicted: vec![0.1; 5],
        measured: vec![9.0; 5],
        noise_sigma: 0.1,
        uncertainty: None,
        response_uncertainty: 0.02,
    };
    let told = compare(&still).unwrap();
    assert_eq!((told.verdict, told.response_ratio), (Verdict::Different, None));
    let pointer = |wrong: Comparison| match compare(&wrong) {
        Err(flankfit::estimation::FitError::Invalid(faults)) => faults.list()[0].pointer.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(pointer(Comparison { measured: vec![0.0; 4], ..still.clone() }), "/measured");
    assert_eq!(pointer(Comparison { noise_sigma: -1.0, ..still.clone() }), "/noise_sigma_um");
    assert_eq!(pointer(Comparison { measured: vec![f64::NAN; 5], ..still.clone() }), "/measured");
    assert_eq!(pointer(Comparison { uncertainty: Some(vec![-1.0; 5]), ..still }), "/uncertainty/0");
}
