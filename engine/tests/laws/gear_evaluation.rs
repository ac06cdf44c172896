//! Laws of the evaluation of traces: what was put in comes back, invariances, plus material, what
//! is missing.

use flankfit_engine::gear::{
    Gear, GearData, Hand, Kind, Side, Trace,
    evaluation::{
        Evaluation, Posted, Values, evaluate,
        settings::{
            DeviationSign, HelixReference, HelixSettings, MeanCurve, PlusMaterial, ProfileSettings, Settings, SlopeSign,
        },
    },
    trace::Direction,
};
use proptest::prelude::*;

pub fn data() -> GearData {
    GearData {
        teeth: 50,
        normal_module: 2.0,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 15f64.to_radians(),
        hand: Hand::Right,
        profile_shift: 0.1,
        face_width: Some(20.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: None,
    }
}

pub fn gear() -> Gear {
    Gear::new(data()).expect("the gear exists")
}

/// From 101 to 107 mm, from 1 to 19 mm.
pub fn settings() -> Settings {
    Settings {
        profile: Some(ProfileSettings::on([101.0, 107.0])),
        helix: Some(HelixSettings::on([1.0, 19.0])),
        given: DeviationSign::Material,
        ..Settings::default()
    }
}

pub fn range(gear: &Gear, kind: Kind) -> [f64; 2] {
    match kind {
        Kind::Profile => [101.0, 107.0].map(|d| gear.roll_length(d).expect("above the base circle")),
        Kind::Helix => [1.0, 19.0],
    }
}

/// `count` samples that reach a little over the range, with the deviation as a function of u in
/// [-1, 1] over the range.
pub fn trace(gear: &Gear, kind: Kind, side: Side, count: usize, deviation: impl Fn(f64) -> f64) -> Trace {
    let [low, high] = range(gear, kind);
    let u = |i: usize| -1.05 + 2.13 * i as f64 / (count - 1) as f64;
    Trace {
        tooth: "1".into(),
        side,
        kind,
        at: (0..count).map(|i| 0.5 * (low + high) + 0.5 * (high - low) * u(i)).collect(),
        section: None,
        deviation: (0..count).map(|i| deviation(u(i))).collect(),
    }
}

fn all(gear: &Gear, traces: &[Trace], settings: &Settings) -> Evaluation {
    let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    evaluate(gear, &posted, settings).expect("the traces are sound")
}

pub fn one(gear: &Gear, trace: &Trace, settings: &Settings) -> Values {
    all(gear, std::slice::from_ref(trace), settings).traces[0].values.expect("there are figures")
}

pub fn near(value: f64, want: f64, within: f64) {
    assert!((value - want).abs() <= within, "{value} is not {want}");
}

pub const KINDS: [Kind; 2] = [Kind::Profile, Kind::Helix];
pub const SIDES: [Side; 2] = [Side::Left, Side::Right];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Line and parabola are drawn over the trace as it was given, whatever its signs mean and
    /// along whatever its deviations are: a parabola lies on itself, and the line crosses it at
    /// ±1/√3 of half the range.
    #[test]
    fn mean_curves_lie_over_the_trace(
        (a, b, c) in (-50.0..50.0f64, -30.0..30.0f64, -30.0..30.0f64), count in 200usize..400,
        kind in prop::sample::select(KINDS.to_vec()), side in prop::sample::select(SIDES.to_vec()),
        given in prop::sample::select(vec![DeviationSign::Material, DeviationSign::Din, DeviationSign::Clockwise]),
        direction in prop::sample::select(vec![Direction::Transverse, Direction::Normal]),
        tilt in -5.0..5.0f64,
    ) {
        let (gear, settings) = (gear(), Settings { given, direction, ..settings() });
        let curve = |u: f64| a + b * u + c * u * u;
        let measured = trace(&gear, kind, side, count, |u| curve(u) + tilt * u);
        // what is meant is taken away
        let design: Vec<f64> = (0..count).map(|i| tilt * (-1.05 + 2.13 * i as f64 / (count - 1) as f64)).collect();
        let found = evaluate(&gear, &[Posted { trace: &measured, design: Some(&design) }], &settings).unwrap();
        let found = &found.traces[0];
        let [low, high] = range(&gear, kind);
        prop_assert_eq!(found.range_mm, [low, high]);
        let values = found.values.unwrap();
        for (height, u) in values.mean_parabola_um.into_iter().zip([-1.0, 0.0, 1.0]) {
            near(height, curve(u), 1e-6);
        }
        for (height, u) in values.mean_line_um.into_iter().zip([-1.0, 1.0]) {
            near(height, a + b * u + c / 3.0, 0.02 * c.abs() + 1e-6);
        }
    }

    /// A slope of so many µm over the range, a crowning and a height come back, on every flank.
    #[test]
    fn slope_crowning_and_height_are_recovered(
        slope in -30.0..30.0f64, crowning in -30.0..30.0f64, height in -200.0..200.0f64, count in 20usize..300,
        kind in prop::sample::select(KINDS.to_vec()), side in prop::sample::select(SIDES.to_vec()),
    ) {
        let gear = gear();
        let mut settings = settings();
        settings.sign = SlopeSign::AsGiven;
        settings.helix = Some(HelixSettings { reference: HelixReference::EvaluationRange,
            ..HelixSettings::on([1.0, 19.0]) });
        let straight = trace(&gear, kind, side, count, |u| height + 0.5 * slope * u);
        let values = one(&gear, &straight, &settings);
        near(values.slope_um, slope, 1e-6);
        near(values.crowning_um, 0.0, 1e-6);
        near(values.form_um, 0.0, 1e-6);
        prop_assert!(values.total_um <= slope.abs() + 1e-6);

        // about the mean parabola slope and crowning are separated wherever samples lie
        for (mean, profile) in [(MeanCurve::Parabola, settings.profile), (MeanCurve::Line, settings.profile)] {
            let profile = profile.map(|p| ProfileSettings { mean, ..p });
            let helix = settings.helix.map(|h| HelixSettings { mean, ..h });
            let both = Settings { profile, helix, ..settings.clone() };
            let crowned = trace(&gear, kind, side, count, |u| height + 0.5 * slope * u - crowning * u * u);
            let values = one(&gear, &crowned, &both);
            near(values.crowning_um, crowning, 1e-6);
            if mean == MeanCurve::Parabola {
                near(values.slope_um, slope, 1e-6);
                near(values.form_um, 0.0, 1e-6);
            } else {
                prop_assert!(values.form_um <= crowning.abs() * 1.2 + 1e-6);
            }
        }
    }

    /// A constant changes nothing, a factor (the unit) scales everything, reversed samples are the
    /// same trace.
    #[test]
    fn heights_units_and_order_do_not_matter(
        seed in prop::collection::vec(-20.0..20.0f64, 40), constant in -1e3..1e3f64, factor in 1e-3..1e3f64,
        kind in prop::sample::select(KINDS.to_vec()), side in prop::sample::select(SIDES.to_vec()),
    ) {
        let (gear, settings) = (gear(), settings());
        let mut given = trace(&gear, kind, side, 40, |_| 0.0);
        given.deviation = seed;
        let before = one(&gear, &given, &settings);
        let mut raised = given.clone();
        raised.deviation.iter_mut().for_each(|d| *d += constant);
        let after = one(&gear, &raised, &settings);
        for (a, b) in figures(&before).into_iter().zip(figures(&after)) {
            near(b, a, 1e-9);
        }
        let mut scaled = given.clone();
        scaled.deviation.iter_mut().for_each(|d| *d *= factor);
        let after = one(&gear, &scaled, &settings);
        for (a, b) in figures(&before).into_iter().zip(figures(&after)) {
            near(b, factor * a, 1e-9 * factor);
        }
        let mut turned = given.clone();
        turned.deviation.reverse();
        turned.at.reverse();
        let after = one(&gear, &turned, &settings);
        for (a, b) in figures(&before).into_iter().zip(figures(&after)) {
            near(b, a, 1e-9);
        }
        // total and form deviation differ by no more than the line rises over the range
        prop_assert!((before.total_um - before.form_um).abs() <= before.slope_um.abs() + 1e-9);
        prop_assert!(before.total_um > 0.0 && before.form_um > 0.0);
        let design: Vec<f64> = given.deviation.clone();
        let itself = evaluate(&gear, &[Posted { trace: &given, design: Some(&design) }], &settings).expect("sound");
        let itself = itself.traces[0].values.expect("figures");
        prop_assert!(figures(&itself).iter().all(|f| *f == 0.0), "{:?}", itself);
    }

    /// The order of the teeth changes nothing but the order of the results.
    #[test]
    fn teeth_may_come_in_any_order(slopes in prop::collection::vec(-20.0..20.0f64, 2..12), turn in 0usize..12) {
        let (gear, settings) = (gear(), settings());
        let traces: Vec<Trace> = slopes.iter().enumerate().map(|(i, slope)| Trace {
            tooth: (i + 1).to_string(),
            ..trace(&gear, Kind::Helix, Side::Left, 30, |u| slope * u + (7.0 * u).sin())
        }).collect();
        let mut turned = traces.clone();
        turned.rotate_left(turn % traces.len());
        let (a, b) = (all(&gear, &traces, &settings), all(&gear, &turned, &settings));
        prop_assert_eq!(&a.summaries, &b.summaries);
        prop_assert_eq!((a.class, a.coarser_than_11), (b.class, b.coarser_than_11));
        let slope = &a.summaries[0].slope_um;
        let found: Vec<f64> = a.traces.iter().map(|t| t.values.expect("figures").slope_um).collect();
        near(slope.mean, found.iter().sum::<f64>() / found.len() as f64, 1e-9);
        prop_assert!(slope.variation >= 0.0 && found.iter().all(|f| f.abs() <= slope.worst.abs()));
    }
}

fn figures(values: &Values) -> [f64; 4] {
    [values.slope_um, values.form_um, values.total_um, values.crowning_um]
}

#[test]
fn plus_material_counts_as_requested() {
    let gear = gear();
    // a burr of 10 µm at the upper end, outside the range, a hole at the other
    let helix = trace(&gear, Kind::Helix, Side::Left, 101, |u| {
        u.abs().min(1.0) + if u > 1.02 { 10.0 } else { 0.0 } - if u < -1.02 { 5.0 } else { 0.0 }
    });
    let values = |plus_material| {
        let helix_settings = Some(HelixSettings { plus_material, ..HelixSettings::on([1.0, 19.0]) });
        one(&gear, &helix, &Settings { helix: helix_settings, ..settings() })
    };
    let ignored = values(PlusMaterial::Ignored);
    let form = values(PlusMaterial::Form);
    let both = values(PlusMaterial::FormAndTotal);
    let total = values(PlusMaterial::Total);
    assert!(form.form_um > form.total_um && form.form_um > ignored.form_um + 9.0, "{form:?}");
    assert_eq!(form.total_um, ignored.total_um);
    assert_eq!((both.form_um, both.total_um), (form.form_um, total.total_um));
    assert_eq!(total.form_um, ignored.form_um);
    near(total.total_um, ignored.total_um + total.total_plus_material_um.expect("material"), 1e-12);
    assert!([form, both, total].iter().all(|v| v.slope_um == ignored.slope_um && v.crowning_um == ignored.crowning_um));
    assert_eq!(ignored.form_plus_material_um, None);
}

#[test]
fn undefined_samples_are_left_out_and_counted() {
    let gear = gear();
    let mut helix = trace(&gear, Kind::Helix, Side::Left, 100, |u| 3.0 * u);
    for k in [0, 10, 11, 50] {
        helix.deviation[k] = f64::NAN;
    }
    let answer = all(&gear, &[helix], &settings());
    let evaluated = &answer.traces[0];
    assert_eq!((evaluated.samples.posted, evaluated.samples.undefined), (100, 4));
    assert_eq!(evaluated.samples.undefined_in_range, 3);
    near(evaluated.values.expect("figures").slope_um, 6.0 * 20.0 / 18.0, 1e-9);
    assert_eq!(answer.warnings.len(), 1);
    assert_eq!(answer.warnings[0].code(), "undefined_samples");
    assert_eq!(answer.warnings[0].path().as_deref(), Some("traces[0].deviation_um"));
}

#[test]
fn traces_that_cannot_be_evaluated_are_warned_of() {
    let gear = gear();
    let short = trace(&gear, Kind::Helix, Side::Left, 100, |u| if u < 0.5 { u } else { f64::NAN });
    let empty = trace(&gear, Kind::Profile, Side::Left, 100, |_| f64::NAN);
    let mut still = trace(&gear, Kind::Helix, Side::Left, 9, |u| u);
    still.at.fill(5.0);
    let answer = all(&gear, &[short, empty, still], &settings());
    let codes: Vec<_> = answer.warnings.iter().map(|w| (w.code(), w.path().unwrap_or_default())).collect();
    assert!(codes.contains(&("range_not_covered", "traces[0].deviation_um".to_owned())), "{codes:?}");
    assert!(codes.contains(&("too_few_samples", "traces[1].deviation_um".to_owned())), "{codes:?}");
    assert!(codes.contains(&("no_mean_curve", "traces[2].deviation_um".to_owned())), "{codes:?}");
    assert!(answer.traces.iter().all(|trace| trace.values.is_none() && trace.classes.is_none()));
    assert!(answer.class.is_none() && !answer.coarser_than_11);
}

#[test]
fn impossible_requests_name_their_place() {
    let gear = gear();
    let helix = trace(&gear, Kind::Helix, Side::Left, 30, |u| u);
    let profile = trace(&gear, Kind::Profile, Side::Left, 30, |u| u);
    let faults = |traces: &[Trace], settings: &Settings| -> Vec<String> {
        let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
        let faults = evaluate(&gear, &posted, settings).expect_err("impossible");
        faults.list().iter().map(|fault| fault.path.clone()).collect()
    };
    assert_eq!(faults(&[], &settings()), ["traces"]);
    let none = Settings { profile: None, helix: None, ..settings() };
    assert_eq!(
        faults(&[helix.clone(), profile.clone()], &none),
        ["evaluation.profile_diameter_range_mm", "evaluation.helix_range_mm"]
    );
    let below = Settings { profile: Some(ProfileSettings::on([10.0, f64::NAN])), ..settings() };
    assert_eq!(
        faults(std::slice::from_ref(&profile), &below),
        ["evaluation.profile_diameter_range_mm[0]", "evaluation.profile_diameter_range_mm[1]"]
    );
    let turned = Settings { helix: Some(HelixSettings::on([19.0, 1.0])), ..settings() };
    assert_eq!(faults(std::slice::from_ref(&helix), &turned), ["evaluation.helix_range_mm"]);
    let mut uneven = helix.clone();
    uneven.deviation.pop();
    uneven.at[3] = f64::INFINITY;
    assert_eq!(faults(&[profile, uneven], &settings()), ["traces[1].deviation_um", "traces[1].z_mm[3]"]);
}
