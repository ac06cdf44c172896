//! Laws of second-order surfaces through traces, which a measuring machine zeroes one by one.

use crate::gear_evaluation::{gear, near, range, settings, trace};
use crate::oracle::random::Random;
use flankfit_engine::gear::{
    Gear, Kind, Side, Trace,
    evaluation::{
        Evaluation, Posted, TraceSurface, evaluate,
        settings::{HelixReference, HelixSettings, Settings, SlopeSign},
        warning::{SurfaceFigure, Warning},
    },
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// Second-order material over u and v: constant, u, v, u², uv, v².
type Terms = [f64; 6];

fn of(terms: Terms, u: f64, v: f64) -> f64 {
    [1.0, u, v, u * u, u * v, v * v].iter().zip(terms).map(|(x, c)| x * c).sum()
}

/// Place of a trace: profiles at v, helices at u.
fn line(gear: &Gear, kind: Kind, at: f64, count: usize, material: impl Fn(f64, f64) -> f64) -> Trace {
    let of = |kind| range(gear, kind);
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high) + 0.5 * (high - low) * at;
    match kind {
        Kind::Profile => Trace {
            section: Some(middle(of(Kind::Helix))),
            ..trace(gear, kind, Side::Left, count, |u| material(u, at))
        },
        Kind::Helix => Trace {
            section: Some(gear.diameter(middle(of(Kind::Profile)))),
            ..trace(gear, kind, Side::Left, count, |v| material(at, v))
        },
    }
}

fn lines(gear: &Gear, profiles: &[f64], helices: &[f64], count: usize, terms: Terms) -> Vec<Trace> {
    let of = |kind, at: &f64| line(gear, kind, *at, count, |u, v| of(terms, u, v));
    let profiles = profiles.iter().map(|v| of(Kind::Profile, v));
    profiles.chain(helices.iter().map(|u| of(Kind::Helix, u))).collect()
}

/// Slopes are over the evaluation ranges, as the terms of a surface are.
fn plain() -> Settings {
    let helix = settings().helix.map(|helix| HelixSettings { reference: HelixReference::EvaluationRange, ..helix });
    Settings { sign: SlopeSign::Vdi, helix, ..settings() }
}

fn answer(gear: &Gear, traces: &[Trace], settings: &Settings) -> Evaluation {
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    evaluate(gear, &posted, settings).expect("the traces are sound")
}

fn surface(gear: &Gear, traces: &[Trace], settings: &Settings) -> TraceSurface {
    answer(gear, traces, settings).surfaces.remove(0)
}

fn codes(answer: &Evaluation) -> Vec<&'static str> {
    answer.warnings.iter().map(|warning| warning.code()).collect()
}

/// Figures as the terms of the material: constant, u, v, u², uv, v².
fn values(surface: &TraceSurface) -> [Option<f64>; 6] {
    let of = &surface.figures;
    [
        (of.mean, 1.0),
        (of.profile_slope, 0.5),
        (of.helix_slope, 0.5),
        (of.profile_crowning, -1.0),
        (of.twist, 0.25),
        (of.helix_crowning, -1.0),
    ]
    .map(|(figure, factor)| figure.map(|figure| factor * figure.value))
}

fn errors(surface: &TraceSurface) -> [Option<f64>; 6] {
    let of = &surface.figures;
    [
        (of.mean, 1.0),
        (of.profile_slope, 0.5),
        (of.helix_slope, 0.5),
        (of.profile_crowning, 1.0),
        (of.twist, 0.25),
        (of.helix_crowning, 1.0),
    ]
    .map(|(figure, factor)| figure.and_then(|figure| figure.std_error).map(|error| factor * error))
}

fn offset(traces: &[Trace], random: &mut Random, size: f64) -> Vec<Trace> {
    let moved = |trace: &Trace| {
        let zero = size * random.normal();
        Trace { deviation: trace.deviation.iter().map(|d| d + zero).collect(), ..trace.clone() }
    };
    traces.iter().map(moved).collect()
}

/// Each trace less its middle sample, as instruments zero them.
fn zeroed(traces: &[Trace]) -> Vec<Trace> {
    let zeroed = |trace: &Trace| {
        let zero = trace.deviation[trace.deviation.len() / 2];
        Trace { deviation: trace.deviation.iter().map(|d| d - zero).collect(), ..trace.clone() }
    };
    traces.iter().map(zeroed).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Given terms come back, whatever the zeros of the traces are; the mean is not determined.
    #[test]
    fn zeros_of_traces_change_nothing(terms in prop::array::uniform6(-20.0..20.0f64), seed in 0u64..1000) {
        let (gear, mut random) = (gear(), Random::new(seed));
        let traces = lines(&gear, &[-0.7, 0.2], &[-0.6, 0.1, 0.8], 60, terms);
        let wavy: Vec<Trace> = traces.iter().map(|trace| Trace {
            deviation: trace.deviation.iter().map(|d| d + 0.5 * random.normal()).collect(), ..trace.clone()
        }).collect();
        let before = surface(&gear, &wavy, &plain());
        for moved in [offset(&wavy, &mut random, 100.0), zeroed(&wavy)] {
            let after = surface(&gear, &moved, &plain());
            for (a, b) in values(&before).into_iter().zip(values(&after)).skip(1) {
                near(b.unwrap(), a.unwrap(), 1e-9);
            }
            for (a, b) in errors(&before).into_iter().zip(errors(&after)).skip(1) {
                near(b.unwrap(), a.unwrap(), 1e-9);
            }
            near(after.rms_um, before.rms_um, 1e-9);
            prop_assert_eq!(after.figures.mean, None);
        }
        let exact = values(&surface(&gear, &zeroed(&traces), &plain()));
        for (found, want) in exact.into_iter().zip(terms).skip(1) {
            near(found.unwrap(), want, 1e-8);
        }
        // one zero for all: the mean is determined, and separate zeros would be taken for a flank
        let shared = Settings { traces_share_zero: true, ..plain() };
        for (found, want) in values(&surface(&gear, &traces, &shared)).into_iter().zip(terms) {
            near(found.unwrap(), want, 1e-8);
        }
    }
}

/// The same estimates as by a column for the zero of each trace, samples of sparse traces counting
/// for more.
#[test]
fn centring_is_a_column_for_each_zero() {
    let (gear, mut random) = (gear(), Random::new(5));
    let terms = [3.0, 4.0, -2.0, 6.0, 5.0, -7.0];
    let material = |u: f64, v: f64| of(terms, u, v) + 2.0 * (5.0 * u).sin() - 3.0 * (4.0 * v * u).cos();
    let mut traces = vec![
        line(&gear, Kind::Profile, -0.5, 40, material),
        line(&gear, Kind::Profile, 0.6, 90, material),
        line(&gear, Kind::Helix, -0.3, 200, material),
        line(&gear, Kind::Helix, 0.7, 55, material),
    ];
    traces.iter_mut().flat_map(|trace| &mut trace.deviation).for_each(|d| *d += random.normal());
    let found = surface(&gear, &traces, &plain());
    let (mut rows, mut heights) = (Vec::new(), Vec::new());
    for (t, (trace, at)) in traces.iter().zip([-0.5, 0.6, -0.3, 0.7]).enumerate() {
        let [low, high] = range(&gear, trace.kind);
        let places: Vec<f64> = trace.at.iter().map(|x| (2.0 * x - low - high) / (high - low)).collect();
        let root = (places[1] - places[0]).sqrt();
        for (place, d) in places.iter().zip(&trace.deviation).filter(|(place, _)| place.abs() <= 1.0) {
            let (u, v) = if trace.kind == Kind::Profile { (*place, at) } else { (at, *place) };
            let zero = |k: usize| if k == t { 1.0 } else { 0.0 };
            rows.extend([u, v, u * u, u * v, v * v, zero(0), zero(1), zero(2), zero(3)].map(|x| root * x));
            heights.push(root * d);
        }
    }
    let x = DMatrix::from_row_slice(heights.len(), 9, &rows);
    let c = x.svd(true, true).solve(&DVector::from_vec(heights), 1e-14).expect("of full rank");
    for (k, found) in values(&found).into_iter().skip(1).enumerate() {
        near(found.unwrap(), c[k], 1e-9);
    }
}

/// Three profiles determine nothing across, a cross no twist, two pairs everything; a lone trace
/// has no surface.
#[test]
fn figures_are_given_where_the_traces_determine_them() {
    let gear = gear();
    let (mut random, terms) = (Random::new(11), [3.0, 4.0, -2.0, 6.0, 5.0, -7.0]);
    // which of u, v, u², uv, v² are determined
    for (profiles, helices, determined) in [
        (&[-0.8, 0.0, 0.8][..], &[][..], [true, false, true, true, false]),
        (&[-0.8, 0.8], &[], [true, false, true, true, false]),
        (&[], &[-0.7, 0.7], [false, true, false, true, true]),
        (&[-0.8, 0.8], &[0.0], [true; 5]),
        (&[-0.8], &[-0.5, 0.5], [true; 5]),
        (&[0.0], &[0.0], [true, true, true, false, true]),
        // the same place once more determines no twist
        (&[0.0], &[0.0, 1e-5], [true, true, true, false, true]),
        (&[0.4, 0.4], &[], [true, false, true, false, false]),
    ] {
        let traces = offset(&lines(&gear, profiles, helices, 80, terms), &mut random, 20.0);
        let found = answer(&gear, &traces, &plain());
        let surface = &found.surfaces[0];
        let each = values(surface);
        assert_eq!(surface.figures.mean, None);
        for (k, determined) in determined.into_iter().enumerate() {
            assert_eq!(each[k + 1].is_some(), determined, "{profiles:?} {helices:?}: {each:?}");
            // without a twist a slope is that in the section of its trace
            if let Some(value) = each[k + 1].filter(|_| each[4].is_some() || profiles.iter().all(|v| *v == 0.0)) {
                near(value, terms[k + 1], 1e-3);
            }
        }
        let warnings: Vec<_> =
            found.warnings.iter().filter(|warning| warning.code() == "figures_not_determined").collect();
        assert_eq!(warnings.len(), usize::from(determined.contains(&false)), "{profiles:?} {helices:?}");
        if let Some(warning) = warnings.first() {
            let Warning::FiguresUndetermined { figures, flanks, .. } = warning else { panic!("{warning}") };
            assert_eq!(figures.contains(&SurfaceFigure::Twist), !determined[3], "{warning}");
            assert_eq!(figures.contains(&SurfaceFigure::HelixSlope), !determined[1], "{warning}");
            assert!(!figures.contains(&SurfaceFigure::Mean) && warning.to_string().contains("(tooth 1 left)"));
            assert_eq!(flanks.len(), 1);
        }
    }
    let in_section = lines(&gear, &[0.5], &[0.0], 80, terms);
    near(values(&surface(&gear, &in_section, &plain()))[1].unwrap(), 4.0 + 5.0 * 0.5, 1e-8);
    let lone = answer(&gear, &lines(&gear, &[0.0], &[], 80, terms), &plain());
    assert!(lone.surfaces.is_empty() && codes(&lone).is_empty());
    // with one zero three profiles determine everything, two all but the square across and the mean
    let shared = Settings { traces_share_zero: true, ..plain() };
    let three = values(&surface(&gear, &lines(&gear, &[-0.8, 0.0, 0.8], &[], 80, terms), &shared));
    assert!(three.iter().all(Option::is_some), "{three:?}");
    let two = values(&surface(&gear, &lines(&gear, &[-0.8, 0.8], &[], 80, terms), &shared));
    assert_eq!(two.map(|figure| figure.is_some()), [false, true, true, true, true, false]);
}

/// Profiles alone, without a range of helices: over what was measured.
#[test]
fn without_a_range_figures_refer_to_the_measured_range() {
    let gear = gear();
    let traces = lines(&gear, &[-0.5, 0.5], &[], 80, [0.0, 1.0, 0.0, 0.0, 3.0, 0.0]);
    let found = surface(&gear, &traces, &Settings { helix: None, ..plain() });
    let [low, high] = range(&gear, Kind::Helix);
    assert!((found.z_range_mm[0] - (low + 0.25 * (high - low))).abs() < 1e-9);
    near(found.figures.twist.unwrap().value, 4.0 * 3.0 * 0.5, 1e-8);
}

/// Coverage of one standard error by 1,000 flanks of zeroed traces: 0.60 to 0.76 for each figure.
#[test]
fn one_standard_error_covers_the_truth_of_zeroed_traces() {
    const RUNS: u32 = 1000;
    let (gear, mut random) = (gear(), Random::new(29));
    let material = |u: f64, v: f64| of([1.0, 4.0, -2.0, 6.0, 3.0, -9.0], u, v) + (7.0 * v).sin() + (6.0 * u).cos();
    let clean: Vec<Trace> =
        [(Kind::Profile, -0.6, 60), (Kind::Profile, 0.5, 100), (Kind::Helix, -0.7, 90), (Kind::Helix, 0.6, 50)]
            .into_iter()
            .map(|(kind, at, count)| line(&gear, kind, at, count, material))
            .collect();
    let truth = values(&surface(&gear, &clean, &plain()));
    let mut hits = [0u32; 5];
    for _ in 0..RUNS {
        let mut traces = offset(&clean, &mut random, 10.0);
        traces.iter_mut().flat_map(|trace| &mut trace.deviation).for_each(|d| *d += 0.3 * random.normal());
        let found = surface(&gear, &zeroed(&traces), &plain());
        let (values, errors) = (values(&found), errors(&found));
        for (k, hits) in hits.iter_mut().enumerate() {
            let off = values[k + 1].unwrap() - truth[k + 1].unwrap();
            *hits += u32::from(off.abs() <= errors[k + 1].expect("a standard error"));
        }
    }
    let shares = hits.map(|hits| f64::from(hits) / f64::from(RUNS));
    assert!(shares.iter().all(|share| (0.60..=0.76).contains(share)), "{shares:?}");
}

fn shuffled_flank(gear: &Gear, random: &mut Random, count: usize, wave: f64, noise: f64, shared: bool) -> Vec<Trace> {
    let terms: Terms = std::array::from_fn(|_| 10.0 * random.normal());
    let mut traces = lines(gear, &[-0.8, 0.0, 0.8], &[-0.7, 0.0, 0.7], count, terms);
    for trace in &mut traces {
        let [low, high] = range(gear, trace.kind);
        // waves of two to eight periods over the range, each trace with a phase of its own
        let (periods, phase) = (random.between(2.0, 8.0), random.between(0.0, std::f64::consts::TAU));
        let zero = if shared { 0.0 } else { 10.0 * random.normal() };
        for (at, d) in trace.at.iter().zip(&mut trace.deviation) {
            let turn = std::f64::consts::TAU * periods * (at - low) / (high - low);
            *d += zero + wave * (turn + phase).sin() + noise * random.normal();
        }
    }
    traces
}

/// Noise and waves are no contradiction: at most 3 of 1,000 sound flanks are warned of, however
/// many samples there are.
#[test]
fn sound_flanks_are_not_warned_of() {
    let (gear, mut random) = (gear(), Random::new(31));
    for shared in [false, true] {
        let asked = Settings { traces_share_zero: shared, ..plain() };
        let mut warned = 0;
        for run in 0..1000 {
            let (count, wave, noise) = [(9, 0.0, 0.3), (25, 0.0, 1.0), (50, 0.5, 0.3), (80, 2.0, 0.3)][run % 4];
            let traces = shuffled_flank(&gear, &mut random, count, wave, noise, shared);
            let codes = codes(&answer(&gear, &traces, &asked));
            warned += usize::from(codes.contains(&"surface_misfit"));
        }
        assert!(warned <= 3, "{warned} of 1,000, shared {shared}");
    }
}

/// Helices with the other sign contradict the profiles where there is a twist (or, with one zero,
/// any level). Traces of a flank that is not of second order contradict too, and no sign corrects
/// it.
#[test]
fn traces_that_contradict_each_other_are_warned_of() {
    let (gear, mut random) = (gear(), Random::new(37));
    for (shared, terms) in [(false, [5.0, 4.0, 3.0, -2.0, 3.0, -4.0]), (true, [6.0, 4.0, 5.0, -2.0, 0.0, -4.0])] {
        let asked = Settings { traces_share_zero: shared, ..plain() };
        let mut good = lines(&gear, &[-0.8, 0.0, 0.8], &[-0.7, 0.0, 0.7], 80, terms);
        good.iter_mut().flat_map(|trace| &mut trace.deviation).for_each(|d| *d += 0.3 * random.normal());
        assert!(codes(&answer(&gear, &good, &asked)).is_empty());
        for trace in good.iter_mut().filter(|trace| trace.kind == Kind::Helix) {
            trace.deviation.iter_mut().for_each(|d| *d = -*d);
        }
        let turned = answer(&gear, &good, &asked);
        assert_eq!(codes(&turned), ["surface_misfit", "helix_sign_doubtful"], "{:?}", turned.surfaces);
        assert_eq!(turned.warnings[1].path().as_deref(), Some("evaluation.deviation_sign"));
    }
    let third = |u: f64, v: f64| 20.0 * u * v * v * v;
    let mut odd: Vec<Trace> = [-0.9, 0.0, 0.9].map(|v| line(&gear, Kind::Profile, v, 80, third)).to_vec();
    odd.extend([-0.9, 0.5].map(|u| line(&gear, Kind::Helix, u, 80, |u, v| 20.0 * u * v * v * v * v)));
    odd.iter_mut().flat_map(|trace| &mut trace.deviation).for_each(|d| *d += 0.1 * random.normal());
    assert_eq!(codes(&answer(&gear, &odd, &plain())), ["surface_misfit"]);
}
