//! Burrs at the ends of traces: how often they are found, and how often clean flanks are suspected.

use crate::gear_evaluation::{gear, settings};
use crate::oracle::random::Random;
use flankfit_engine::gear::{
    Kind, Side, Trace,
    evaluation::{Evaluated, Posted, evaluate},
};

/// Sections z of the samples: the evaluation range from 1 to 19 mm, or a tenth more.
fn places(count: usize, run_in: f64) -> Vec<f64> {
    (0..count).map(|k| 1.0 - run_in + (18.0 + 2.0 * run_in) * k as f64 / (count - 1) as f64).collect()
}

fn evaluated(at: &[f64], flank: &[Vec<f64>]) -> Vec<Evaluated> {
    let trace = |(tooth, deviation): (usize, &Vec<f64>)| Trace {
        tooth: (tooth + 1).to_string(),
        side: Side::Left,
        kind: Kind::Helix,
        at: at.to_vec(),
        section: None,
        deviation: deviation.clone(),
    };
    let traces: Vec<Trace> = flank.iter().enumerate().map(trace).collect();
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    evaluate(&gear(), &posted, &settings()).expect("sound").traces
}

/// Returns for each trace whether there is a burr at its lower and at its upper end.
fn burrs(at: &[f64], flank: &[Vec<f64>]) -> Vec<[bool; 2]> {
    let middle = |place: &flankfit_engine::gear::evaluation::Suspect| 0.5 * (place.from_mm + place.to_mm);
    evaluated(at, flank)
        .iter()
        .map(|trace| {
            let places = trace.suspects.iter().flat_map(|suspects| &suspects.places).filter(|place| place.burr);
            let upper: Vec<bool> = places.map(|place| middle(place) > 10.0).collect();
            [upper.contains(&false), upper.contains(&true)]
        })
        .collect()
}

/// Crowned and wavy traces with noise, half of them rounded to 0.1 µm. All teeth have the same
/// reliefs, within a fifth, and the same break of the lower edge.
fn clean(random: &mut Random, at: &[f64], teeth: usize, wave: f64) -> Vec<Vec<f64>> {
    let count = at.len();
    let (begin, steep) = (random.between(0.6, 0.95), random.between(0.0, 200.0));
    let (broken, depth) = (random.between(1.0, 8.0) as usize, random.between(5.0, 40.0));
    let [kind, ends, rounded] = [4.0, 3.0, 2.0].map(|below| random.between(0.0, below) as usize);
    (0..teeth)
        .map(|_| {
            let (slope, crowning) = (random.between(-10.0, 10.0), random.between(-20.0, 20.0));
            let noise = random.between(0.05, 0.5);
            let [turns, phase, height] =
                [random.between(4.0, 20.0), random.between(0.0, 6.3), random.between(0.0, wave)];
            let (knee, relief) = (begin + random.between(-0.03, 0.03), steep * random.between(0.8, 1.2));
            let deviation = |k: usize| {
                let u = -1.0 + 2.0 * k as f64 / (count - 1) as f64;
                let form = slope * u - crowning * u * u + height * (turns * u + phase).sin();
                let side = [-u, u, u.abs()][ends];
                let relief = if kind % 2 == 1 { relief * (side - knee).max(0.0) } else { 0.0 };
                let edge = if kind > 1 { depth * (1.0 - k as f64 / broken as f64).max(0.0) } else { 0.0 };
                form - relief - edge
            };
            let value = |k: usize| deviation(k) + noise * random.normal();
            let round = |x: f64| if rounded == 1 { (x * 10.0).round() / 10.0 } else { x };
            (0..count).map(value).map(round).collect()
        })
        .collect()
}

/// A burr of half a normal curve at an end of the evaluation range, `foot` mm wide.
fn burr(at: &[f64], upper: bool, height: f64, foot: f64) -> Vec<f64> {
    let inwards = |z: f64| if upper { 19.0 - z } else { z - 1.0 };
    at.iter().map(|z| height * (-0.5 * (inwards(*z).max(0.0) / foot).powi(2)).exp()).collect()
}

/// At most one of a thousand: reliefs and breaks that all teeth have are no burrs.
#[test]
fn clean_flanks_have_no_burrs() {
    let (mut random, mut traces, mut alarms) = (Random::new(31), 0, 0);
    for run in 0..750 {
        let at = places([60, 100, 214, 480][run % 4], [0.0, 0.9][run / 4 % 2]);
        let flank = clean(&mut random, &at, 3 + run % 3, 3.0);
        traces += flank.len();
        alarms += burrs(&at, &flank).iter().filter(|found| found.contains(&true)).count();
    }
    assert!(traces >= 2_900 && alarms * 1_000 <= traces, "{alarms} of {traces}");
}

/// At least 99 of 100 burrs of 30 to 80 µm on one tooth are found, and no other tooth is named.
#[test]
fn burrs_at_the_ends_are_found() {
    const RUNS: usize = 400;
    let (mut random, mut found, mut others) = (Random::new(32), 0, 0);
    for run in 0..RUNS {
        let at = places([100, 214, 480][run % 3], [0.0, 0.9][run / 3 % 2]);
        let mut flank = clean(&mut random, &at, 3 + run % 3, 1.5);
        let (tooth, upper) = (random.between(0.0, flank.len() as f64) as usize, run % 2 == 1);
        let burr = burr(&at, upper, random.between(30.0, 80.0), random.between(0.15, 0.36));
        flank[tooth].iter_mut().zip(burr).for_each(|(d, more)| *d += more);
        for (i, ends) in burrs(&at, &flank).into_iter().enumerate() {
            found += usize::from(i == tooth && ends[usize::from(upper)]);
            others += usize::from(i != tooth && ends.contains(&true));
        }
    }
    assert!(found * 100 >= 99 * RUNS && others == 0, "{found} of {RUNS}, {others} others");
}

/// Burrs of 80 and 40 µm on two of five teeth, with figures without them; where all have one there
/// is nothing to name.
#[test]
fn burrs_are_named_by_their_places_with_the_figures_without_them() {
    let (at, mut random) = (places(480, 0.0), Random::new(33));
    let line = |noise: &mut Random| at.iter().map(|z| 0.5 * (z - 10.0) + 0.2 * noise.normal()).collect::<Vec<f64>>();
    let straight: Vec<Vec<f64>> = (0..5).map(|_| line(&mut random)).collect();
    let with = |heights: [f64; 5]| -> Vec<Vec<f64>> {
        let each = straight.iter().zip(heights);
        each.map(|(d, h)| d.iter().zip(burr(&at, false, h, 0.3)).map(|(d, more)| d + more).collect()).collect()
    };
    let found = evaluated(&at, &with([80.0, 0.0, 0.0, 40.0, 0.0]));
    for (i, trace) in found.iter().enumerate() {
        let values = trace.values.expect("figures");
        let Some(height) = [Some(80.0), None, None, Some(40.0), None][i] else {
            assert!(trace.suspects.is_none() && (values.total_um - 9.0).abs() < 1.5, "{i}: {trace:?}");
            continue;
        };
        let suspects = trace.suspects.as_ref().expect("a burr");
        let [place] = suspects.places[..] else { panic!("one place: {suspects:?}") };
        assert!(place.burr && place.from_mm == 1.0 && (1.5..2.0).contains(&place.to_mm), "{place:?}");
        assert!((place.height_um - height).abs() < 2.0, "{place:?}");
        // over 18 of the 20 mm of the face the line rises by 9 µm
        let without = suspects.without.expect("the others tell the figures");
        assert!(values.total_um > 0.9 * height && (without.total_um - 9.0).abs() < 1.5, "{without:?}");
        assert!((without.slope_um.abs() - 10.0).abs() < 0.3, "{without:?}");
    }
    assert_eq!(burrs(&at, &with([80.0; 5])), [[false; 2]; 5]);
    // of two traces neither is known to be the clean one
    let two = with([80.0, 0.0, 0.0, 0.0, 0.0])[..2].to_vec();
    assert_eq!(burrs(&at, &two), [[false; 2]; 2]);
}

/// A burr of 4 µm on a crowning of 20 µm has its own height and width.
#[test]
fn a_burr_on_a_crowned_trace_has_its_own_height() {
    let (at, mut random) = (places(480, 0.0), Random::new(34));
    let crowned = |z: &f64| 20.0 * (1.0 - ((z - 10.0) / 9.0).powi(2));
    let mut flank: Vec<Vec<f64>> =
        (0..4).map(|_| at.iter().map(|z| crowned(z) + 0.02 * random.normal()).collect()).collect();
    for upper in [false, true] {
        flank[1].iter_mut().zip(burr(&at, upper, 4.0, 0.3)).for_each(|(d, more)| *d += more);
    }
    let found = evaluated(&at, &flank);
    let suspects = found[1].suspects.as_ref().expect("burrs");
    assert_eq!(suspects.places.len(), 2, "{suspects:?}");
    for place in &suspects.places {
        // half a normal curve of 0.3 mm falls to a fiftieth of its height within 0.84 mm
        assert!(place.burr && (place.height_um - 4.0).abs() < 0.3 && place.to_mm - place.from_mm < 1.2, "{place:?}");
    }
}
