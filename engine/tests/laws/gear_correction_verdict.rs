//! Error rates of the verdict on a machine, and rates of detection, by simulation.
//!
//! The quantiles of the verdict leave 0.001 for χ² and 0.003 for β̂ on both sides; the standard
//! error of β̂ is that of the worst errors of J, and c takes a part of the noise away. Seeds are
//! fixed.

use crate::machines::{Plant, each, times};
use flankfit_engine::estimation::spec::Regularization;
use flankfit_engine::gear::correction::{Answer, Correction, Damping, Noise, Verdict, compare};

const PAIRS: u64 = 2000;

/// A way to correct, and its expected results.
#[derive(Clone, Copy)]
struct Way {
    plain: bool,
    /// Least and greatest change of every other setting.
    limit: Option<f64>,
    sigma_known: bool,
    /// Factor of the machine's response.
    factor: f64,
}

const DEFAULT: Way = Way { plain: false, limit: None, sigma_known: true, factor: 1.0 };
const PLAIN: Way = Way { plain: true, ..DEFAULT };

fn verdict(plant: &Plant, way: Way, seed: u64) -> Verdict {
    answer(plant, way, seed, |change| change.iter().map(|x| way.factor * x).collect()).verdict
}

/// Answer of a machine on which `entered` was set.
fn answer(plant: &Plant, way: Way, seed: u64, entered: impl Fn(&[f64]) -> Vec<f64>) -> Answer {
    let mut machine = plant.machine(seed);
    let before = machine.measure();
    let mut asked = plant.asked(&machine, before);
    if way.plain {
        asked.damping = Damping::Given(Regularization::None);
    }
    if !way.sigma_known {
        asked.noise_sigma = None;
    }
    for setting in asked.settings.iter_mut().step_by(2) {
        (setting.min, setting.max) = (way.limit.map(|x| -x), way.limit);
    }
    let correction = Correction::new(asked).unwrap();
    let solution = correction.solve().unwrap();
    let change: Vec<f64> = solution.settings.iter().map(|s| s.change).collect();
    machine.change(entered(&change));
    let noise: Noise = solution.noise.unwrap();
    assert_eq!(noise.freedom.is_none(), way.sigma_known);
    compare(&correction.comparison(&change, solution.leverage, noise, machine.measure())).unwrap()
}

fn count(plant: &Plant, way: Way, pairs: u64, what: impl Fn(Verdict) -> bool) -> usize {
    each(pairs, |seed| verdict(plant, way, seed)).into_iter().filter(|verdict| what(*verdict)).count()
}

fn alarm(verdict: Verdict) -> bool {
    !matches!(verdict, Verdict::AsPredicted | Verdict::Undecided)
}

const SIX: Plant = Plant { grid: [5, 9], settings: 6, apart: 1.0, off: 10.0, sigma: 0.3, eta: 0.02, whole: false };

fn set_ups() -> Vec<(&'static str, Plant, Way)> {
    let at = |off: f64| Plant { off, eta: 0.0, ..SIX };
    vec![
        ("clear", SIX, DEFAULT),
        ("clear, least squares", SIX, PLAIN),
        ("as large as noise", at(0.3), PLAIN),
        ("between", at(0.6), PLAIN),
        ("between, damped", at(0.6), DEFAULT),
        ("just detectable", at(1.0), DEFAULT),
        ("few nodes", Plant { grid: [3, 3], off: 1.0, ..SIX }, PLAIN),
        ("few nodes, unknown noise", Plant { grid: [4, 4], ..SIX }, Way { sigma_known: false, ..PLAIN }),
        ("unknown noise, small", at(0.6), Way { sigma_known: false, ..DEFAULT }),
        ("many settings, all noise", Plant { grid: [6, 8], settings: 28, off: 0.05, eta: 0.0, ..SIX }, PLAIN),
        ("near mixture", Plant { apart: 1e-3, ..SIX }, DEFAULT),
        ("limited", Plant { off: 1.0, ..SIX }, Way { limit: Some(0.5), ..DEFAULT }),
        ("columns off", Plant { eta: 0.1, whole: true, off: 3.0, ..SIX }, PLAIN),
        ("entries off", Plant { eta: 0.1, grid: [9, 15], ..SIX }, PLAIN),
    ]
}

/// A machine that is what J says within its uncertainty: at most 3 in 1,000 are called anything
/// else.
#[test]
fn true_machines_are_hardly_ever_called_anything_else() {
    let mut all = 0;
    let mut counts = Vec::new();
    for (name, plant, way) in set_ups() {
        let alarms = count(&plant, way, PAIRS, alarm);
        counts.push(format!("{name}: {alarms}"));
        assert!(alarms <= 12, "{counts:?}");
        all += alarms;
    }
    assert!(all as u64 <= 3 * 14 * PAIRS / 1000, "{counts:?}");
    println!("{counts:?}");
}

/// Half of the change, and half as much again, where signal, noise and the uncertainty of J allow a
/// decision: 0.5 is five standard errors.
#[test]
fn weak_and_strong_machines_are_found() {
    let pairs = 400;
    for (plant, way) in [
        (SIX, DEFAULT),
        (SIX, PLAIN),
        (Plant { eta: 0.0, off: 2.5, ..SIX }, DEFAULT),
        (Plant { grid: [9, 15], off: 2.0, eta: 0.0, ..SIX }, PLAIN),
        (Plant { grid: [6, 6], ..SIX }, Way { sigma_known: false, ..PLAIN }),
        (Plant { apart: 1e-3, ..SIX }, DEFAULT),
        (SIX, Way { limit: Some(6.0), ..DEFAULT }),
    ] {
        let weak = count(&plant, Way { factor: 0.5, ..way }, pairs, |v| v == Verdict::Weaker);
        let strong = count(&plant, Way { factor: 1.5, ..way }, pairs, |v| v == Verdict::Stronger);
        assert!(weak >= 390 && strong >= 390, "{weak} and {strong} of {pairs}: {plant:?}");
    }
}

/// Shares of the verdicts, in the order of `VERDICTS`.
fn shares(plant: &Plant, way: Way, factor: f64) -> [f64; 6] {
    const RUNS: u64 = 1000;
    let all = each(RUNS, |seed| verdict(plant, Way { factor, ..way }, 10_000 + seed));
    let shares = VERDICTS.map(|one| all.iter().filter(|verdict| **verdict == one).count() as f64 / RUNS as f64);
    println!("off {} factor {factor}: {shares:?}", plant.off);
    shares
}

const VERDICTS: [Verdict; 6] = [
    Verdict::AsPredicted,
    Verdict::Weaker,
    Verdict::NoResponse,
    Verdict::Stronger,
    Verdict::Different,
    Verdict::Undecided,
];

/// True ratios by verdict: where the noise is small each has its own; where it is large, a machine
/// that did nothing, or half, is not said to have responded as predicted.
#[test]
fn every_ratio_has_its_verdict() {
    let small = |factor| shares(&Plant { eta: 0.0, off: 3.0, ..SIX }, PLAIN, factor);
    assert!(small(0.0)[2] >= 0.99);
    assert!(small(0.5)[1] >= 0.99);
    assert!(small(0.8)[1] >= 0.99);
    assert!(small(1.0)[0] >= 0.99);
    assert!(small(1.3)[3] >= 0.99);
    for off in [0.12, 0.15, 0.2] {
        let large = |factor| shares(&Plant { eta: 0.0, off, ..SIX }, PLAIN, factor);
        for factor in [0.0, 0.5] {
            assert!(large(factor)[0] <= 0.005);
        }
        assert!(large(1.0)[..5].iter().skip(1).sum::<f64>() <= 0.006);
    }
}

/// One of several changes is not entered. Where it makes more than 2σ rms it is named, and no other
/// one is.
#[test]
fn a_forgotten_setting_is_named() {
    for (plant, way) in [
        (Plant { off: 2.5, ..SIX }, DEFAULT),
        (Plant { off: 2.5, ..SIX }, PLAIN),
        (Plant { off: 4.0, grid: [4, 5], settings: 3, ..SIX }, PLAIN),
        (Plant { off: 2.5, grid: [9, 15], eta: 0.0, ..SIX }, PLAIN),
        (Plant { off: 2.5, ..SIX }, Way { sigma_known: false, ..PLAIN }),
    ] {
        let runs = each(1000, |seed| {
            let forgotten = seed as usize % plant.settings;
            let drawn = plant.machine(seed);
            // those of the settings are nearly those of the changes
            let rms = |only: Option<usize>| {
                let off: Vec<f64> = drawn
                    .off
                    .iter()
                    .enumerate()
                    .map(|(j, x)| if only.is_none_or(|k| k == j) { *x } else { 0.0 })
                    .collect();
                let moved = times(&drawn.sensitivity, &off);
                (moved.iter().map(|x| x * x).sum::<f64>() / moved.len() as f64).sqrt()
            };
            if rms(Some(forgotten)) < 2.0 * plant.sigma {
                return None;
            }
            let answer = answer(&plant, way, seed, |change| {
                change.iter().enumerate().map(|(j, x)| if j == forgotten { 0.0 } else { *x }).collect()
            });
            let named: Vec<&str> = answer.not_entered.iter().map(|one| one.setting.as_str()).collect();
            Some((named == [format!("s{forgotten}")], answer.verdict == Verdict::AsPredicted))
        });
        let found: Vec<_> = runs.into_iter().flatten().collect();
        let share =
            |of: fn(&(bool, bool)) -> bool| found.iter().filter(|one| of(one)).count() as f64 / found.len() as f64;
        let [named, missed] = [share(|one| one.0), share(|one| one.1)];
        println!("{} of {:?}: {named} named, {missed} as predicted", found.len(), plant);
        assert!(found.len() > 300 && named >= 0.95 && missed <= 0.01, "{named} {missed} {plant:?}");
    }
}

/// With noise alone hardly anything is called weak or strong, and nothing that did not respond is
/// said to have responded as predicted.
#[test]
fn noise_alone_has_no_verdict() {
    let plant = Plant { off: 0.02, eta: 0.0, ..SIX };
    for factor in [0.0, 0.5, 1.0] {
        let of = |what: fn(Verdict) -> bool| count(&plant, Way { factor, ..PLAIN }, 400, what);
        let [right, other] = [of(|v| v == Verdict::AsPredicted), of(|v| alarm(v) && v != Verdict::Weaker)];
        println!("{factor}: {right} as predicted, {other} other");
        assert!(other <= 6 && (factor == 1.0 || right <= 1), "{factor}: {right} {other}");
    }
    assert!(count(&plant, PLAIN, 400, alarm) <= 6);
}
