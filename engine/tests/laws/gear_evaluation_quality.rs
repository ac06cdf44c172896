//! Quality of traces in an evaluation: standard errors that hold, sampling that does not matter,
//! holes, dust, a range that begins at the base circle.

use crate::gear_evaluation::{data, gear, near, one, range, settings, trace};
use crate::oracle::random::Random;
use flankfit_engine::gear::{
    Gear, GearData, Kind, ProfileAxis, Side, Trace,
    evaluation::{
        Evaluation, Posted, Twist, Values, WithoutSuspects, evaluate,
        settings::{
            HelixReference, HelixSettings, MeanCurve, Outliers, PlusMaterial, ProfileReference, ProfileSettings,
            Settings,
        },
    },
};
use proptest::prelude::*;

fn all(gear: &Gear, traces: &[Trace], settings: &Settings) -> Evaluation {
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    evaluate(gear, &posted, settings).expect("the traces are sound")
}

fn codes(answer: &Evaluation) -> Vec<&'static str> {
    answer.warnings.iter().map(|warning| warning.code()).collect()
}

/// Slopes over the evaluation range, so that they are those of the functions put in.
fn plain() -> Settings {
    Settings {
        helix: Some(HelixSettings { reference: HelixReference::EvaluationRange, ..HelixSettings::on([1.0, 19.0]) }),
        ..settings()
    }
}

/// Shares of 1,000 figures that lie within one standard error of the truth, for slope, crowning and
/// twist.
fn coverage(count: usize, noise: f64, mean: MeanCurve, shape: impl Fn(f64) -> f64) -> [f64; 3] {
    const RUNS: usize = 1000;
    let (gear, mut random) = (gear(), Random::new(71 + count as u64));
    let mut asked = plain();
    asked.helix = asked.helix.map(|helix| HelixSettings { mean, ..helix });
    let clean = |tooth: &str| Trace { tooth: tooth.into(), ..trace(&gear, Kind::Helix, Side::Left, count, &shape) };
    let truth: Values = one(&gear, &clean("1"), &asked);
    let mut hits = [0usize; 3];
    for _ in 0..RUNS {
        let traces = ["1f", "1k"].map(|tooth| {
            let mut noisy = clean(tooth);
            noisy.deviation.iter_mut().for_each(|d| *d += noise * random.normal());
            noisy
        });
        let answer = all(&gear, &traces, &asked);
        let found = answer.traces[0].values.expect("figures");
        let within = |error: f64, bound: Option<f64>| usize::from(error.abs() <= bound.expect("a standard error"));
        hits[0] += within(found.slope_um - truth.slope_um, found.slope_std_error_um);
        hits[1] += within(found.crowning_um - truth.crowning_um, found.crowning_std_error_um);
        let Twist { twist_um, std_error_um, .. } = answer.twists[0].clone();
        hits[2] += within(twist_um, std_error_um);
    }
    hits.map(|hits| hits as f64 / RUNS as f64)
}

/// 0.683 of normal errors lie within one standard deviation; the share of 1,000 has a standard
/// deviation of 0.015.
#[test]
fn standard_errors_of_traces_hold_with_and_without_crowning() {
    for (count, noise, crowning, waves) in
        [(60, 0.5, 0.0, 0.0), (200, 1.0, 0.0, 0.0), (200, 0.1, 20.0, 0.0), (480, 0.1, 20.0, 0.0), (480, 0.3, 20.0, 2.0)]
    {
        for mean in [MeanCurve::Line, MeanCurve::Parabola] {
            let shape = |u: f64| 7.0 * u - crowning * u * u + waves * (9.0 * u).sin();
            let found = coverage(count, noise, mean, shape);
            let holds = found.iter().all(|share| (0.60..=0.76).contains(share));
            assert!(holds, "{count} samples, noise {noise}, crowning {crowning}, waves {waves}: {found:?}");
        }
    }
}

/// A trace crowned by 20 µm with a noise of 0.1 µm: 2√3 σ/√n, times what a line over [-1, 1] makes
/// of it.
#[test]
fn crowning_and_reliefs_are_no_noise() {
    let (gear, mut random) = (gear(), Random::new(5));
    let noise: Vec<f64> = (0..214).map(|_| 0.1 * random.normal()).collect();
    let error = |shape: &dyn Fn(f64) -> f64| {
        let mut helix = trace(&gear, Kind::Helix, Side::Left, 214, shape);
        helix.deviation.iter_mut().zip(&noise).for_each(|(d, noise)| *d += noise);
        one(&gear, &helix, &plain()).slope_std_error_um.expect("a standard error")
    };
    let flat = error(&|_| 0.0);
    near(flat, 0.1 * 2.0 * 3f64.sqrt() / 200f64.sqrt(), 0.25 * flat);
    near(error(&|u| -20.0 * u * u), flat, 1e-3 * flat);
    // reliefs of both ends, and a step, are corners: a few contrasts of two hundred
    near(error(&|u| -60.0 * (u.abs() - 0.8).max(0.0)), flat, 0.3 * flat);
    near(error(&|u| if u > 0.3 { 8.0 } else { 0.0 }), flat, 0.3 * flat);
}

/// Noise that goes together, as filters leave it, is not taken for little.
#[test]
fn noise_of_neighbours_that_go_together_counts() {
    let (gear, mut random, count) = (gear(), Random::new(6), 1000);
    let runs = 200;
    let (mut hits, mut sum) = (0, 0.0);
    for _ in 0..runs {
        // means of three: a tenth of their variance is in single differences
        let white: Vec<f64> = (0..count + 2).map(|_| random.normal()).collect();
        let mut helix = trace(&gear, Kind::Helix, Side::Left, count, |_| 0.0);
        helix.deviation = white.windows(3).map(|three| three.iter().sum::<f64>() / 3.0).collect();
        let values = one(&gear, &helix, &plain());
        let error = values.slope_std_error_um.expect("a standard error");
        hits += usize::from(values.slope_um.abs() <= error);
        sum += error / f64::from(runs);
    }
    let share = hits as f64 / f64::from(runs);
    assert!((0.56..=0.80).contains(&share), "{share}, mean error {sum}");
}

/// ∫ u δ over ∫ u² by the trapezoidal rule on very fine steps.
fn integral_slope(deviation: impl Fn(f64) -> f64) -> f64 {
    let steps = 200_000;
    let (mut top, mut bottom) = (0.0, 0.0);
    for k in 0..=steps {
        let u = -1.0 + 2.0 * f64::from(k) / f64::from(steps);
        let weight = if k == 0 || k == steps { 0.5 } else { 1.0 };
        top += weight * u * deviation(u);
        bottom += weight * u * u;
    }
    // over the range, to which u = −1 to 1 corresponds
    2.0 * top / bottom
}

/// The slope is that of the curve, with samples equally far apart in roll length, in diameter or at
/// random.
#[test]
fn how_samples_are_spaced_makes_no_difference() {
    let data = GearData { teeth: 18, helix_angle: 0.0, profile_shift: 0.3, ..data() };
    let gear = Gear::new(data).expect("the gear exists");
    let base = 2.0 * gear.base_radius();
    let ends = [base + 0.3, 2.0 * gear.tip_radius() - 0.2];
    let [low, high] = ends.map(|d| gear.roll_length(d).expect("above the base circle"));
    let place = |roll: f64| (2.0 * roll - low - high) / (high - low);
    let asked = Settings { profile: Some(ProfileSettings::on(ends)), ..settings() };
    for shape in [|u: f64| -5.0 * (u - 0.2).powi(2), |u: f64| 5.0 * (2.5 * u).sin(), |u: f64| 3.0 * (1.3 * u).exp()] {
        let truth = integral_slope(shape);
        let mut random = Random::new(3);
        for count in [100, 400] {
            // what a sum over so many equidistant samples is from the integral, and 1 % of 5 µm
            let within = (0.05 + 0.015 * truth.abs()) * 100.0 / count as f64;
            let share = |k: usize| k as f64 / (count - 1) as f64;
            let by_diameter = |k: usize| {
                let diameter = ends[0] + (ends[1] - ends[0]) * share(k);
                ProfileAxis::Diameter.roll_length(&gear, diameter).expect("on the involute")
            };
            let mut jitter = || random.between(-0.4, 0.4) / (count - 1) as f64;
            let shaken: Vec<f64> = (0..count)
                .map(|k| low + (high - low) * (share(k) + if (1..count - 1).contains(&k) { jitter() } else { 0.0 }))
                .collect();
            let even: Vec<f64> = (0..count).map(|k| low + (high - low) * share(k)).collect();
            for at in [even, (0..count).map(by_diameter).collect(), shaken] {
                let profile = Trace {
                    deviation: at.iter().map(|roll| shape(place(*roll))).collect(),
                    at,
                    ..trace(&gear, Kind::Profile, Side::Left, 2, |_| 0.0)
                };
                near(one(&gear, &profile, &asked).slope_um, truth, within);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Samples at equal distances count alike: the line is that of every textbook.
    #[test]
    fn equidistant_samples_have_the_ordinary_line(deviation in prop::collection::vec(-20.0..20.0f64, 12..80)) {
        let (gear, count) = (gear(), deviation.len());
        let at: Vec<f64> = (0..count).map(|k| 1.0 + 18.0 * k as f64 / (count - 1) as f64).collect();
        let n = count as f64;
        let (mean_x, mean_y) = (at.iter().sum::<f64>() / n, deviation.iter().sum::<f64>() / n);
        let top: f64 = at.iter().zip(&deviation).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
        let bottom: f64 = at.iter().map(|x| (x - mean_x).powi(2)).sum();
        let helix = Trace { at, deviation, ..trace(&gear, Kind::Helix, Side::Left, 2, |_| 0.0) };
        near(one(&gear, &helix, &plain()).slope_um, 18.0 * top / bottom, 1e-9);
    }
}

/// Two hundred samples of a form that has class 7, of which a hole hides the greater part.
#[test]
fn over_a_hole_there_is_no_form() {
    let gear = gear();
    let whole = trace(&gear, Kind::Profile, Side::Left, 214, |u| 7.0 * (5.0 * u).sin());
    let holed = |from: usize, to: usize| {
        let mut trace = whole.clone();
        trace.deviation[from..to].fill(f64::NAN);
        all(&gear, &[trace], &settings())
    };
    let classes = |answer: &Evaluation| answer.traces[0].classes.clone();
    let untouched = all(&gear, std::slice::from_ref(&whole), &settings());
    assert!(classes(&untouched).is_some_and(|c| c.form.is_some() && c.total.is_some()));
    assert!(untouched.warnings.is_empty());
    // 119 of 200
    let gone = holed(45, 164);
    assert_eq!(codes(&gone), ["undefined_samples", "hole_in_trace"]);
    assert!(classes(&gone).is_none() && gone.class.is_none() && gone.traces[0].values.is_none());
    assert!(gone.warnings[1].to_string().contains("no figures and no class"), "{}", gone.warnings[1]);
    // 6 % of the range: the slope has its class, form and total have none
    let small = holed(100, 112);
    let found = classes(&small).expect("a class of the slope");
    assert!(found.form.is_none() && found.total.is_none());
    assert_eq!(codes(&small), ["undefined_samples", "hole_in_trace"]);
    // 2 %: less than the filter of the standard leaves
    assert!(classes(&holed(100, 104)).is_some_and(|c| c.form.is_some()));
    // positions that are not posted are a hole as well, and a hole does not bend the line
    let mut missing = trace(&gear, Kind::Profile, Side::Left, 214, |u| 4.0 * u);
    missing.at.drain(60..100);
    missing.deviation.drain(60..100);
    let answer = all(&gear, &[missing], &settings());
    assert_eq!(codes(&answer), ["hole_in_trace"]);
    near(answer.traces[0].values.expect("figures").slope_um, 8.0, 1e-9);
}

#[test]
fn sparse_samples_are_warned_of() {
    let gear = gear();
    let answer = all(&gear, &[trace(&gear, Kind::Helix, Side::Left, 16, |u| u)], &settings());
    assert_eq!(codes(&answer), ["sparse_samples"]);
    assert!(answer.traces[0].classes.is_some());
}

/// Dust of 40 µm on a trace of a good flank.
#[test]
fn suspected_dust_is_excluded_on_request() {
    let (gear, mut random) = (gear(), Random::new(4));
    let mut clean = trace(&gear, Kind::Helix, Side::Left, 214, |u| 3.0 * u - 6.0 * u * u);
    clean.deviation.iter_mut().for_each(|d| *d += 0.2 * random.normal());
    let without = all(&gear, std::slice::from_ref(&clean), &settings());
    assert!(without.warnings.is_empty() && without.traces[0].suspects.is_none());
    for wide in [1, 4, 11] {
        let mut dusty = clean.clone();
        for (k, d) in dusty.deviation[120..120 + wide].iter_mut().enumerate() {
            let across = (k as f64 + 0.5) / wide as f64 * 2.0 - 1.0;
            *d += 40.0 * (1.0 - across * across).max(0.3);
        }
        let kept = all(&gear, std::slice::from_ref(&dusty), &settings());
        assert_eq!(codes(&kept), ["outliers_suspected"], "{wide} samples wide");
        assert_eq!(kept.warnings[0].path().as_deref(), Some("traces[0].deviation_um"));
        let suspects = kept.traces[0].suspects.as_ref().expect("a suspect");
        let [place] = suspects.places[..] else { panic!("one place: {suspects:?}") };
        assert!(place.from_mm <= dusty.at[120] && place.to_mm >= dusty.at[119 + wide] && place.samples <= wide + 4);
        near(place.height_um, 40.0, 10.0);
        let (with, figures) = (kept.traces[0].values.expect("figures"), suspects.without.expect("figures"));
        let truth = without.traces[0].values.expect("figures");
        assert!(with.form_um > truth.form_um + 30.0);
        near(figures.form_um, truth.form_um, 0.5);
        near(figures.slope_um, truth.slope_um, 0.2);
        let asked = Settings { outliers: Outliers::Exclude, ..settings() };
        let left_out = all(&gear, &[dusty], &asked);
        assert_eq!(left_out.traces[0].values.map(WithoutSuspects::from), Some(figures));
        assert_eq!(left_out.traces[0].samples.excluded, place.samples);
        assert!(
            left_out.warnings.iter().any(|w| w.code() == "outliers_suspected" && w.to_string().contains("omitted"))
        );
        // what is left out is a hole: of 11 samples one over which there is no form
        assert_eq!(left_out.traces[0].classes.as_ref().is_some_and(|c| c.form.is_some()), wide < 8);
    }
}

/// Flanks and rounded numbers are not taken for dust.
#[test]
fn sound_traces_have_no_suspects() {
    let gear = gear();
    let mut random = Random::new(9);
    type Shape = fn(f64) -> f64;
    let shapes: [(&str, Shape); 8] = [
        ("crowned", |u| -20.0 * u * u),
        ("end reliefs", |u| -100.0 * (u.abs() - 0.8).max(0.0)),
        ("short tip relief", |u| -400.0 * (u - 0.9).max(0.0)),
        ("waves", |u| 3.0 * (15.0 * u).sin()),
        ("short waves", |u| 2.0 * (90.0 * u).sin()),
        ("twelfth order and a step", |u| 4.0 * (6.0 * u).sin() + if u > 0.1 { 5.0 } else { 0.0 }),
        ("exponential", |u| (3.0 * u).exp()),
        ("straight", |u| 30.0 * u),
    ];
    for (name, shape) in shapes {
        for (count, noise, step) in
            [(36, 0.3, 0.0), (214, 0.0, 0.0), (214, 0.3, 0.1), (480, 0.5, 0.0), (480, 0.01, 0.1)]
        {
            for _ in 0..20 {
                let mut helix = trace(&gear, Kind::Helix, Side::Left, count, shape);
                for d in &mut helix.deviation {
                    *d += noise * random.normal();
                    if step > 0.0 {
                        *d = (*d / step).round() * step;
                    }
                }
                let answer = all(&gear, &[helix], &settings());
                let suspects = answer.traces[0].suspects.as_ref();
                assert!(suspects.is_none(), "{name}, {count} samples, noise {noise}: {suspects:?}");
            }
        }
    }
}

/// On internal gears whose tip circle lies within the base circle, the flank ends at the base
/// circle.
#[test]
fn plus_material_of_internal_gears_counts_down_to_the_base_circle() {
    let internal =
        GearData { internal: true, profile_shift: 0.0, tip_diameter: Some(90.0), helix_angle: 0.0, ..data() };
    let gear = Gear::new(internal).expect("the gear exists");
    assert!(gear.roll_length(90.0).is_none());
    let range = [98.0, 104.0];
    let [low, high] = range.map(|d| gear.roll_length(d).expect("above the base circle"));
    let at: Vec<f64> = (0..200).map(|k| 0.4 * low + (high - 0.4 * low) * f64::from(k) / 199.0).collect();
    // a bump towards the tip, outside of the range
    let deviation = at.iter().map(|l| if *l < 0.6 * low { 12.0 } else { 1e-3 * l }).collect();
    let profile = Trace { at, deviation, ..trace(&gear, Kind::Profile, Side::Left, 2, |_| 0.0) };
    let values = |plus_material| {
        let asked = ProfileSettings { plus_material, ..ProfileSettings::on(range) };
        one(&gear, &profile, &Settings { profile: Some(asked), ..settings() })
    };
    let (ignored, counted) = (values(PlusMaterial::Ignored), values(PlusMaterial::FormAndTotal));
    assert!(ignored.total_um < 0.1 && counted.total_um > 11.9, "{ignored:?} {counted:?}");
    near(counted.total_um - ignored.total_um, counted.total_plus_material_um.expect("material"), 1e-12);
    // there is no tip that slopes could be extended to
    let to_tip = ProfileSettings { reference: ProfileReference::ToTip, ..ProfileSettings::on(range) };
    let asked = Settings { profile: Some(to_tip), ..settings() };
    let faults = evaluate(&gear, &[Posted { trace: &profile, design: None }], &asked).expect_err("refused");
    assert_eq!(faults.list()[0].path, "evaluation.profile_reference");
}

#[test]
fn a_range_that_begins_at_the_base_circle_is_warned_of() {
    let gear = gear();
    let base = 2.0 * gear.base_radius();
    let begins = |start: f64| {
        let asked = Settings { profile: Some(ProfileSettings::on([start, 107.0])), ..settings() };
        let [low, high] = [start, 107.0].map(|d| gear.roll_length(d).expect("above the base circle"));
        let mut profile = trace(&gear, Kind::Profile, Side::Left, 100, |_| 0.0);
        profile.at = (0..100).map(|k| low + (high - low) * f64::from(k) / 99.0).collect();
        codes(&all(&gear, &[profile], &asked))
    };
    assert_eq!(begins(base + 0.1), ["near_base_circle"]);
    assert!(begins(101.0).is_empty());
    assert!(range(&gear, Kind::Profile)[0] > 0.0);
}

/// The twist of the surface through three helices and two profiles with waves of 2 µm, and a noise
/// of 0.3 µm.
#[test]
fn standard_errors_of_surfaces_are_those_of_the_noise() {
    let (gear, mut random, runs) = (gear(), Random::new(17), 400);
    let rolls = range(&gear, Kind::Profile);
    let material =
        |u: f64, v: f64| 4.0 * u - 9.0 * v * v + 2.0 * u * v + 2.0 * (11.0 * v).sin() + 2.0 * (9.0 * u).cos();
    let at = |u: f64| gear.diameter(0.5 * (rolls[0] + rolls[1]) + 0.5 * u * (rolls[1] - rolls[0]));
    let clean = || {
        let helix = |u: f64, tooth: &str| Trace {
            tooth: tooth.into(),
            section: Some(at(u)),
            ..trace(&gear, Kind::Helix, Side::Left, 150, |v| material(u, v))
        };
        let profile = |v: f64| Trace {
            section: Some(10.0 + 9.0 * v),
            ..trace(&gear, Kind::Profile, Side::Left, 150, |u| material(u, v))
        };
        vec![helix(-0.8, "1f"), helix(0.0, "1"), helix(0.8, "1k"), profile(-0.5), profile(0.4)]
    };
    let figures = |traces: &[Trace]| {
        let shared = Settings { traces_share_zero: true, ..plain() };
        let surface = all(&gear, traces, &shared).surfaces.remove(0).figures;
        [surface.twist, surface.profile_slope, surface.helix_slope, surface.helix_crowning, surface.mean]
            .map(|figure| figure.expect("the traces tell it"))
    };
    let truth = figures(&clean());
    let mut hits = [0usize; 5];
    for _ in 0..runs {
        let mut traces = clean();
        traces.iter_mut().flat_map(|trace| &mut trace.deviation).for_each(|d| *d += 0.3 * random.normal());
        for (k, (found, truth)) in figures(&traces).iter().zip(&truth).enumerate() {
            hits[k] += usize::from((found.value - truth.value).abs() <= found.std_error.expect("a standard error"));
        }
    }
    // a share of 400 has a standard deviation of 0.023
    let shares = hits.map(|hits| hits as f64 / f64::from(runs));
    assert!(shares.iter().all(|share| (0.60..=0.78).contains(share)), "{shares:?}");
}
