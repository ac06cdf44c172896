//! Many gaps, each too short for a hole: what they leave of a trace, and what is no gap.

use crate::gear_evaluation::{gear, near, range, settings, trace};
use crate::oracle::random::Random;
use flankfit_engine::gear::{
    Kind, Side, Trace,
    evaluation::{Evaluation, Posted, evaluate},
};

const COUNT: usize = 1501;

/// Waves of 15 periods with noise, of which `kept` says by u in [-1, 1] over the range what is
/// defined.
fn waves(count: usize, mut kept: impl FnMut(f64) -> bool) -> Evaluation {
    let (gear, mut random) = (gear(), Random::new(31));
    let wave = |u: f64| 3.0 * (std::f64::consts::TAU * phase(u, 15.0)).cos();
    let mut waves = trace(&gear, Kind::Profile, Side::Left, count, wave);
    let [low, high] = range(&gear, Kind::Profile);
    for (at, d) in waves.at.iter().zip(&mut waves.deviation) {
        let u = (2.0 * at - low - high) / (high - low);
        *d = if kept(u) { *d + 0.1 * random.normal() } else { f64::NAN };
    }
    of(&waves)
}

fn of(trace: &Trace) -> Evaluation {
    evaluate(&gear(), &[Posted { trace, design: None }], &settings()).expect("the trace is sound")
}

/// Place within one of so many equal stretches of the range, in [0, 1).
fn phase(u: f64, stretches: f64) -> f64 {
    (0.5 * (u + 1.0) * stretches).rem_euclid(1.0)
}

fn codes(answer: &Evaluation) -> Vec<&str> {
    answer.warnings.iter().map(|warning| warning.code()).filter(|code| *code != "undefined_samples").collect()
}

/// The crests are left: 6 µm of form would be 2 µm, and nothing but the length that is missing
/// shows it.
#[test]
fn gaps_below_a_hole_count_together() {
    let whole = waves(COUNT, |_| true);
    assert_eq!(codes(&whole), [""; 0]);
    assert!(whole.traces[0].classes.is_some() && whole.traces[0].values.expect("figures").form_um > 6.0);
    for (count, share) in [(COUNT, 0.68), (COUNT, 0.4), (480, 0.68), (214, 0.65)] {
        let crests = waves(count, |u| u.abs() > 0.995 || (phase(u, 15.0) - 0.5).abs() > 0.5 * share);
        assert!(crests.traces[0].values.is_none() && crests.traces[0].classes.is_none(), "{share} of {count}");
        assert_eq!(codes(&crests), ["samples_missing"], "{share} of {count}");
        let warning = crests.warnings.iter().find(|warning| warning.code() == "samples_missing").expect("a warning");
        assert_eq!(warning.path().as_deref(), Some("traces[0].deviation_um"));
        assert!(warning.to_string().contains("is covered, less than 75 %"), "{}", warning);
    }
}

/// With less than a quarter of the range missing there are figures, and form may be greater.
#[test]
fn a_form_with_missing_stretches_is_a_lower_bound() {
    let whole = waves(COUNT, |_| true).traces[0].values.expect("figures");
    let some = waves(COUNT, |u| u.abs() > 0.995 || (phase(u, 5.0) - 0.5).abs() > 0.1);
    assert_eq!(codes(&some), ["samples_missing"]);
    let warning = some.warnings.iter().find(|warning| warning.code() == "samples_missing").expect("a warning");
    assert!(warning.to_string().contains("% of the evaluation range lie in 5 stretches"), "{}", warning);
    assert!(warning.to_string().contains("form and total deviation may be greater"), "{}", warning);
    let values = some.traces[0].values.expect("figures");
    near(values.slope_um, whole.slope_um, 1.0);
    assert!(some.traces[0].classes.is_some());
}

/// Thinned evenly, at random, or in one half only; two missing samples here and there.
#[test]
fn thin_traces_miss_nothing() {
    let mut random = Random::new(32);
    let mut sample = 0;
    let mut every = |nth: usize| {
        sample += 1;
        sample % nth == 0
    };
    let cases = [
        ("every tenth", waves(COUNT, |_| every(10))),
        ("every 25th", waves(COUNT, |_| every(25))),
        ("every 34th", waves(COUNT, |_| every(34))),
        ("the upper half", waves(COUNT, |u| u < 0.0 || every(15))),
        ("a half at random", waves(COUNT, |_| random.between(0.0, 1.0) < 0.5)),
        ("one short stretch", waves(214, |u| !(0.0..0.09).contains(&u))),
    ];
    for (name, answer) in &cases {
        assert!(!codes(answer).contains(&"samples_missing"), "{name}: {:?}", answer.warnings);
        assert!(answer.traces[0].classes.is_some(), "{name}: {:?}", answer.warnings);
    }
}
