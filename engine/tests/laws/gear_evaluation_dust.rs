//! Dust at the ends of traces and dust that is long, and how often clean traces are suspected.

use crate::gear_evaluation::{gear, settings};
use crate::oracle::random::Random;
use flankfit_engine::gear::{
    Kind, Side, Trace,
    evaluation::{Posted, Suspect, evaluate},
};

/// The evaluation range alone: ends of the trace are its own.
fn suspected(deviation: Vec<f64>) -> Vec<Suspect> {
    let last = (deviation.len() - 1) as f64;
    let at = (0..deviation.len()).map(|k| 1.0 + 18.0 * k as f64 / last).collect();
    let trace = Trace { tooth: "1".into(), side: Side::Left, kind: Kind::Helix, at, section: None, deviation };
    let answer = evaluate(&gear(), &[Posted { trace: &trace, design: None }], &settings()).expect("sound");
    answer.traces[0].suspects.as_ref().map(|suspects| suspects.places.clone()).unwrap_or_default()
}

/// A crowned trace with noise and waves.
fn clean(random: &mut Random, count: usize) -> Vec<f64> {
    let (slope, crowning, noise) =
        (random.between(-10.0, 10.0), random.between(-20.0, 20.0), random.between(0.05, 0.5));
    let [wave, phase, height] = [random.between(4.0, 20.0), random.between(0.0, 6.3), random.between(0.0, 3.0)];
    let at = |k: usize| -1.0 + 2.0 * k as f64 / (count - 1) as f64;
    (0..count)
        .map(|k| {
            let u = at(k);
            slope * u - crowning * u * u + height * (wave * u + phase).sin() + noise * random.normal()
        })
        .collect()
}

#[test]
fn dust_at_the_ends_is_suspected() {
    let (mut random, mut missed) = (Random::new(21), 0);
    for run in 0..60 {
        let count = [100, 214, 480][run % 3];
        let wide = [2, 3, 5][run % 3];
        let mut dusty = clean(&mut random, count);
        let from = if run % 2 == 0 { 0 } else { count - wide };
        dusty[from..from + wide].iter_mut().for_each(|d| *d += 40.0);
        let places = suspected(dusty);
        let z = |k: usize| 1.0 + 18.0 * k as f64 / (count - 1) as f64;
        missed += usize::from(
            !places.iter().any(|place| place.from_mm <= z(from) + 1e-9 && place.to_mm >= z(from + wide - 1) - 1e-9),
        );
    }
    assert!(missed <= 1, "{missed} of 60 missed");
}

#[test]
fn long_dust_is_suspected() {
    let (mut random, mut missed) = (Random::new(22), 0);
    for run in 0..60 {
        let count = [100, 214, 480][run % 3];
        let wide = count * [8, 10, 12][run / 3 % 3] / 100;
        let from = random.between(0.2, 0.7) * count as f64;
        let mut dusty = clean(&mut random, count);
        dusty[from as usize..from as usize + wide].iter_mut().for_each(|d| *d += 40.0);
        let places = suspected(dusty);
        missed += usize::from(!places.iter().any(|place| place.samples + 4 >= wide && place.samples <= wide + 4));
    }
    assert!(missed <= 2, "{missed} of 60 missed");
}

/// A relief, and a break of the edge, fall off to the end.
#[test]
fn relief_at_an_end_is_not_dust() {
    let mut random = Random::new(23);
    for wide in [2, 4, 9] {
        let mut broken = clean(&mut random, 214);
        broken[214 - wide..].iter_mut().for_each(|d| *d -= 40.0);
        assert_eq!(suspected(broken), [], "{wide}");
    }
}

/// Reliefs whose knee is next to a hole, or in it: at most three of a thousand.
#[test]
fn clean_reliefs_with_holes_are_not_suspected() {
    const RUNS: usize = 2400;
    let mut random = Random::new(25);
    let mut alarms = 0;
    for run in 0..RUNS {
        let count = [100, 214, 480][run % 3];
        let height = [15.0, 40.0, random.between(2.0, 60.0)][run / 3 % 3];
        let knee = random.between(0.3, 0.85);
        let width = random.between(0.04, 0.45);
        let from = random.between(-0.95, 0.95 - width);
        let noise = random.between(0.05, 0.5);
        let relief = |k: usize| {
            let u = -1.0 + 2.0 * k as f64 / (count - 1) as f64;
            let hole = u > from && u < from + width;
            if hole { f64::NAN } else { -height * ((u - knee) / (1.0 - knee)).max(0.0) }
        };
        let trace = (0..count).map(|k| relief(k) + noise * random.normal()).collect();
        alarms += usize::from(!suspected(trace).is_empty());
    }
    assert!(alarms * 1000 <= 3 * RUNS, "{alarms} of {RUNS}");
}

/// Dust is found next to holes as at ends: with a step, or a single sample.
#[test]
fn dust_next_to_holes_is_suspected() {
    let (mut random, mut missed) = (Random::new(26), 0);
    for run in 0..60 {
        let count = [214, 480][run % 2];
        let wide = [1, 2, 4][run % 3];
        let mut dusty = clean(&mut random, count);
        let hole = [count / 2, count / 2 + count / 8];
        dusty[hole[0]..hole[1]].fill(f64::NAN);
        let away = [0, 0, 12][run / 6 % 3];
        let from = if run % 4 < 2 { hole[1] + away } else { hole[0] - away - wide };
        dusty[from..from + wide].iter_mut().for_each(|d| *d += 40.0);
        let z = |k: usize| 1.0 + 18.0 * k as f64 / (count - 1) as f64;
        let last = z(from + wide - 1) - 1e-9;
        missed += usize::from(!suspected(dusty).iter().any(|p| p.from_mm <= z(from) + 1e-9 && p.to_mm >= last));
    }
    assert!(missed <= 2, "{missed} of 60 missed");
}

/// At most three of a thousand.
#[test]
fn clean_traces_are_not_suspected() {
    const RUNS: usize = 3000;
    let mut random = Random::new(24);
    let mut alarms = 0;
    for run in 0..RUNS {
        let count = [60, 100, 214, 480][run % 4];
        let mut trace = clean(&mut random, count);
        let at = |k: usize| -1.0 + 2.0 * k as f64 / (count - 1) as f64;
        let (begin, steep) = (random.between(0.6, 0.9), random.between(0.0, 60.0));
        for (k, d) in trace.iter_mut().enumerate() {
            match run / 4 % 3 {
                0 => {}
                1 => *d -= steep * (at(k).abs() - begin).max(0.0),
                _ => *d = (*d * 10.0).round() / 10.0,
            }
        }
        alarms += usize::from(!suspected(trace).is_empty());
    }
    assert!(alarms * 1000 <= 3 * RUNS, "{alarms} of {RUNS}");
}
