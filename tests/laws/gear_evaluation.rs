//! Laws of the evaluation of traces: what was put in comes back, signs, invariances, classes.

use flankfit::gear::{
    Gear, GearData, Hand, Kind, Side, Trace,
    evaluation::{
        Evaluation, Posted, Values, evaluate,
        settings::{
            DeviationSign, HelixReference, HelixSettings, MeanCurve, PlusMaterial, ProfileReference, ProfileSettings,
            Settings, SlopeSign,
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
fn settings() -> Settings {
    Settings {
        profile: Some(ProfileSettings::on([101.0, 107.0])),
        helix: Some(HelixSettings::on([1.0, 19.0])),
        given: DeviationSign::Material,
        ..Settings::default()
    }
}

fn range(gear: &Gear, kind: Kind) -> [f64; 2] {
    match kind {
        Kind::Profile => [101.0, 107.0].map(|d| gear.roll_length(d).expect("above the base circle")),
        Kind::Helix => [1.0, 19.0],
    }
}

/// `count` samples a little beyond the range, with the deviation as a function of u in [-1, 1] over the range.
fn trace(gear: &Gear, kind: Kind, side: Side, count: usize, deviation: impl Fn(f64) -> f64) -> Trace {
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

fn one(gear: &Gear, trace: &Trace, settings: &Settings) -> Values {
    all(gear, std::slice::from_ref(trace), settings).traces[0].values.expect("there are figures")
}

fn near(value: f64, want: f64, within: f64) {
    assert!((value - want).abs() <= within, "{value} is not {want}");
}

const KINDS: [Kind; 2] = [Kind::Profile, Kind::Helix];
const SIDES: [Side; 2] = [Side::Left, Side::Right];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A slope of so many µm over the range, a crowning and a height come back, on every flank.
    #[test]
    fn what_is_put_in_comes_back(
        slope in -30.0..30.0f64, crowning in -30.0..30.0f64, height in -200.0..200.0f64, count in 20usize..300,
        kind in prop::sample::select(KINDS.to_vec()), side in prop::sample::select(SIDES.to_vec()),
    ) {
        let gear = gear();
        let mut settings = settings();
        settings.sign = SlopeSign::AsGiven;
        settings.helix = Some(HelixSettings { reference: HelixReference::EvaluationRange, ..HelixSettings::on([1.0, 19.0]) });
        let straight = trace(&gear, kind, side, count, |u| height + 0.5 * slope * u);
        let values = one(&gear, &straight, &settings);
        near(values.slope, slope, 1e-6);
        near(values.crowning, 0.0, 1e-6);
        near(values.form, 0.0, 1e-6);
        prop_assert!(values.total <= slope.abs() + 1e-6);

        // about the mean parabola slope and crowning are told apart wherever samples lie
        for (mean, profile) in [(MeanCurve::Parabola, settings.profile), (MeanCurve::Line, settings.profile)] {
            let profile = profile.map(|p| ProfileSettings { mean, ..p });
            let helix = settings.helix.map(|h| HelixSettings { mean, ..h });
            let both = Settings { profile, helix, ..settings.clone() };
            let crowned = trace(&gear, kind, side, count, |u| height + 0.5 * slope * u - crowning * u * u);
            let values = one(&gear, &crowned, &both);
            near(values.crowning, crowning, 1e-6);
            if mean == MeanCurve::Parabola {
                near(values.slope, slope, 1e-6);
                near(values.form, 0.0, 1e-6);
            } else {
                prop_assert!(values.form <= crowning.abs() * 1.2 + 1e-6);
            }
        }
    }

    /// A constant changes nothing, a factor (the unit) scales everything, reversed samples are the same trace.
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
        // the least-squares line leaves residuals of both signs, so neither form nor total is 0, and F ≥ half of f_f
        prop_assert!(before.total > 0.0 && before.form > 0.0);
        let design: Vec<f64> = given.deviation.clone();
        let itself = evaluate(&gear, &[Posted { trace: &given, design: Some(&design) }], &settings).expect("sound");
        let itself = itself.traces[0].values.expect("figures");
        prop_assert!(figures(&itself).iter().all(|f| *f == 0.0), "{:?}", itself);
    }

    /// The order of the teeth changes nothing but the order of the answers.
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
        prop_assert_eq!(a.overall, b.overall);
        let slope = &a.summaries[0].slope;
        let found: Vec<f64> = a.traces.iter().map(|t| t.values.expect("figures").slope).collect();
        near(slope.mean, found.iter().sum::<f64>() / found.len() as f64, 1e-9);
        prop_assert!(slope.variation >= 0.0 && found.iter().all(|f| f.abs() <= slope.worst.abs()));
    }
}

fn figures(values: &Values) -> [f64; 4] {
    [values.slope, values.form, values.total, values.crowning]
}

#[test]
fn signs_are_those_documented() {
    let gear = gear();
    for given in [DeviationSign::Material, DeviationSign::Din, DeviationSign::Clockwise] {
        for kind in KINDS {
            for side in SIDES {
                let rising = trace(&gear, kind, side, 50, |u| u - 3.0 * u * u);
                let slope = |sign| one(&gear, &rising, &Settings { given, sign, ..settings() }).slope.signum();
                let side_sign = side.sign();
                // what the flank does, as seen by material
                let material = match given {
                    DeviationSign::Material => 1.0,
                    DeviationSign::Din if kind == Kind::Profile => 1.0,
                    DeviationSign::Din => side_sign,
                    DeviationSign::Clockwise => -side_sign,
                };
                assert_eq!(slope(SlopeSign::AsGiven), 1.0);
                assert_eq!(slope(SlopeSign::Vdi), material);
                let din = if kind == Kind::Profile { material } else { side_sign * material };
                assert_eq!(slope(SlopeSign::Din), din);
                let crowning = one(&gear, &rising, &Settings { given, ..settings() }).crowning;
                near(crowning, 3.0 * material, 1e-9);
            }
        }
    }
}

/// A flank turned towards the right hand is positive by DIN: points of the helicoid of a gear with a little more helix angle.
#[test]
fn a_right_hand_deviation_is_positive_on_both_flanks() {
    use flankfit::gear::involute::Flank;
    for hand in [Hand::Right, Hand::Left] {
        let nominal = Gear::new(GearData { hand, ..data() }).expect("the gear exists");
        let steeper = GearData { hand, helix_angle: data().helix_angle + 1e-5, ..data() };
        let steeper = Gear::new(steeper).expect("the gear exists");
        for side in SIDES {
            let (flank, real) = (Flank::new(&nominal, side), Flank::new(&steeper, side));
            let roll = nominal.roll_length(104.0).expect("above the base circle");
            let mut helix = trace(&nominal, Kind::Helix, side, 40, |_| 0.0);
            for (z, deviation) in helix.at.iter().zip(&mut helix.deviation) {
                let place = flank.at(roll, *z);
                let step = real.at(roll, *z).point - place.point;
                *deviation = 1e3 * step.dot(&place.normal);
            }
            let direction = Direction::Normal;
            let values = one(&nominal, &helix, &Settings { direction, ..settings() });
            let right = if hand == Hand::Right { 1.0 } else { -1.0 };
            // Δβ seen over the face width on this cylinder
            assert!(right * values.slope > 0.05 && right * values.slope < 0.5, "{hand:?} {side:?} {values:?}");
        }
    }
}

#[test]
fn reversed_face_width_turns_the_helix_slope() {
    let gear = gear();
    for side in SIDES {
        let helix = trace(&gear, Kind::Helix, side, 60, |u| 4.0 * u + (5.0 * u).cos());
        let mut turned = helix.clone();
        turned.at.iter_mut().for_each(|z| *z = 20.0 - *z);
        let (a, b) = (one(&gear, &helix, &settings()), one(&gear, &turned, &settings()));
        near(b.slope, -a.slope, 1e-9);
        near(b.form, a.form, 1e-9);
        near(b.crowning, a.crowning, 1e-9);
    }
}

#[test]
fn reference_lengths_extend_the_slope() {
    let gear = gear();
    let helix = trace(&gear, Kind::Helix, Side::Left, 50, |u| 9.0 * u);
    let slope = |reference| {
        let helix_settings = Some(HelixSettings { reference, ..HelixSettings::on([1.0, 19.0]) });
        one(&gear, &helix, &Settings { helix: helix_settings, ..settings() }).slope
    };
    near(slope(HelixReference::EvaluationRange), 18.0, 1e-9);
    near(slope(HelixReference::FaceWidth), 20.0, 1e-9);
    near(slope(HelixReference::Given(36.0)), 36.0, 1e-9);

    let [low, high] = range(&gear, Kind::Profile);
    let profile = trace(&gear, Kind::Profile, Side::Right, 50, |u| 9.0 * u);
    let slope = |reference| {
        let asked = ProfileSettings { reference, ..ProfileSettings::on([101.0, 107.0]) };
        one(&gear, &profile, &Settings { profile: Some(asked), ..settings() }).slope
    };
    near(slope(ProfileReference::EvaluationRange), 18.0, 1e-9);
    let tip = gear.roll_length(2.0 * gear.tip_radius()).expect("above the base circle");
    near(slope(ProfileReference::ToTip), 18.0 * (tip - low) / (high - low), 1e-9);
    near(slope(ProfileReference::Given(1.0)), 18.0 / (high - low), 1e-9);
    // along the normal everything is cos β_b smaller
    let normal = Settings { direction: Direction::Normal, ..settings() };
    near(
        one(&gear, &profile, &normal).total * gear.base_helix_angle().cos(),
        one(&gear, &profile, &settings()).total,
        1e-9,
    );
}

/// On an internal gear the tip lies at smaller roll lengths.
#[test]
fn an_internal_profile_rises_towards_its_tip() {
    let data = GearData { internal: true, profile_shift: 0.0, ..data() };
    let gear = Gear::new(data).expect("the gear exists");
    let asked = Some(ProfileSettings::on([101.0, 106.0]));
    let low = gear.roll_length(101.0).expect("above the base circle");
    let mut profile = trace(&gear, Kind::Profile, Side::Left, 50, |_| 0.0);
    profile.deviation = profile.at.iter().map(|l| low - l).collect();
    let values = one(&gear, &profile, &Settings { profile: asked, ..settings() });
    assert!(values.slope > 0.0, "{values:?}");
}

#[test]
fn plus_material_counts_as_asked() {
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
    assert!(form.form > form.total && form.form > ignored.form + 9.0, "{form:?}");
    assert_eq!(form.total, ignored.total);
    assert_eq!((both.form, both.total), (form.form, total.total));
    assert_eq!(total.form, ignored.form);
    near(total.total, ignored.total + total.total_plus_material, 1e-12);
    assert!([form, both, total].iter().all(|v| v.slope == ignored.slope && v.crowning == ignored.crowning));
    assert_eq!(ignored.form_plus_material, 0.0);
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
    near(evaluated.values.expect("figures").slope, 6.0 * 20.0 / 18.0, 1e-9);
    assert_eq!(answer.notices.len(), 1);
    assert_eq!(answer.notices[0].code, "undefined_samples");
    assert_eq!(answer.notices[0].pointer.as_deref(), Some("/traces/0/deviation_um"));
}

#[test]
fn what_cannot_be_evaluated_is_said() {
    let gear = gear();
    let short = trace(&gear, Kind::Helix, Side::Left, 100, |u| if u < 0.5 { u } else { f64::NAN });
    let empty = trace(&gear, Kind::Profile, Side::Left, 100, |_| f64::NAN);
    let mut still = trace(&gear, Kind::Helix, Side::Left, 9, |u| u);
    still.at.fill(5.0);
    let answer = all(&gear, &[short, empty, still], &settings());
    let codes: Vec<_> = answer.notices.iter().map(|n| (n.code, n.pointer.as_deref().unwrap_or(""))).collect();
    assert!(codes.contains(&("range_not_covered", "/traces/0/deviation_um")), "{codes:?}");
    assert!(codes.contains(&("too_few_samples", "/traces/1/deviation_um")), "{codes:?}");
    assert!(codes.contains(&("no_mean_curve", "/traces/2/deviation_um")), "{codes:?}");
    assert!(answer.traces[0].values.is_some() && answer.traces[0].classes.is_none());
    assert!(answer.traces[1].values.is_none() && answer.traces[2].values.is_none());
    assert_eq!(answer.overall, None);
}

#[test]
fn impossible_requests_name_their_place() {
    let gear = gear();
    let helix = trace(&gear, Kind::Helix, Side::Left, 30, |u| u);
    let profile = trace(&gear, Kind::Profile, Side::Left, 30, |u| u);
    let faults = |traces: &[Trace], settings: &Settings| -> Vec<String> {
        let posted: Vec<Posted> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
        let faults = evaluate(&gear, &posted, settings).expect_err("impossible");
        faults.list().iter().map(|fault| fault.pointer.clone()).collect()
    };
    assert_eq!(faults(&[], &settings()), ["/traces"]);
    let none = Settings { profile: None, helix: None, ..settings() };
    assert_eq!(
        faults(&[helix.clone(), profile.clone()], &none),
        ["/evaluation/profile_diameter_range_mm", "/evaluation/helix_range_mm"]
    );
    let below = Settings { profile: Some(ProfileSettings::on([10.0, f64::NAN])), ..settings() };
    assert_eq!(
        faults(std::slice::from_ref(&profile), &below),
        ["/evaluation/profile_diameter_range_mm/0", "/evaluation/profile_diameter_range_mm/1"]
    );
    let turned = Settings { helix: Some(HelixSettings::on([19.0, 1.0])), ..settings() };
    assert_eq!(faults(std::slice::from_ref(&helix), &turned), ["/evaluation/helix_range_mm"]);
    let mut uneven = helix.clone();
    uneven.deviation.pop();
    uneven.at[3] = f64::INFINITY;
    assert_eq!(faults(&[profile, uneven], &settings()), ["/traces/1/deviation_um", "/traces/1/z_mm/3"]);
}
