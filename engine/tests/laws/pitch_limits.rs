//! Limits of pitch deviations and run-out, by hand.

use flankfit_engine::{
    estimation::inference::ConformityVerdict,
    gear::{
        Gear, GearData, Side,
        evaluation::{
            pitch::{Pitch, PitchMeasured, PitchSettings, pitch},
            pitch_limits::{Held, PitchLimits},
            runout::from_readings,
        },
        tolerance::{Rounding, Tolerances},
    },
};

fn gear() -> Gear {
    Gear::new(GearData { face_width: Some(20.0), ..GearData::spur(50, 2.0) }).unwrap()
}

fn measured(single: Vec<f64>) -> Pitch {
    let settings = PitchSettings { side: Side::Left, diameter: None, sector: None, rounding: Rounding::Unrounded };
    pitch(&gear(), &PitchMeasured::Single(single), &settings).unwrap()
}

/// +7 and −7 elsewhere than at the end, else 0.
fn pair() -> Vec<f64> {
    let mut single = vec![0.0; 50];
    (single[10], single[20]) = (7.0, -7.0);
    single
}

fn single(limits: PitchLimits, of: &Pitch, uncertainty: Option<f64>) -> Held {
    let tolerances = Tolerances::new(&gear()).ok();
    limits.single_pitches(of, tolerances.as_ref(), Rounding::Unrounded, uncertainty).unwrap()
}

/// Class 5 of z 50, m 2, b 20: f_pT 5.9, F_pT 19.1, F_rT 17.19 (ISO 1328-1, computed by hand).
#[test]
fn classes_apply_where_no_limits_are_given() {
    let class = |class| PitchLimits { class: Some(class), ..PitchLimits::default() };
    let found = single(class(5), &measured(pair()), None);
    assert!((found.limits_um[1] - 5.9).abs() < 1e-12 && found.limits_um[0] == -found.limits_um[1], "{found:?}");
    assert_eq!((found.within, found.conformity), (Some(false), None));
    assert_eq!(single(class(6), &measured(pair()), None).within, Some(true), "5.9 √2 = 8.3");
    let tolerances = Tolerances::new(&gear()).ok();
    let cumulative = |class: PitchLimits| {
        class.cumulative_pitch(&measured(pair()), tolerances.as_ref(), Rounding::Unrounded, None).unwrap()
    };
    let found = cumulative(class(5));
    assert!(found.limits_um[0] == 0.0 && (found.limits_um[1] - 19.1).abs() < 1e-12 && found.within == Some(true));
    let own = cumulative(PitchLimits { cumulative_pitch_um: Some([0.0, 6.5]), ..class(5) });
    assert_eq!((own.limits_um, own.within), ([0.0, 6.5], Some(false)), "F_p is 7");
    let mut readings = vec![0.0; 50];
    readings[3] = 17.2;
    let runout = from_readings(&gear(), &readings, Rounding::Unrounded).unwrap();
    let found = class(5).runout(&runout, tolerances.as_ref(), Rounding::Unrounded, None).unwrap();
    assert!((found.limits_um[1] - 17.19).abs() < 1e-12 && found.within == Some(false), "{found:?}");
    assert_eq!(class(5).runout(&runout, None, Rounding::Unrounded, None), None, "outside the standard");
}

/// With unequal limits on both sides the pitch counts that is closest to its limit, not the
/// greatest.
#[test]
fn every_single_pitch_must_lie_within() {
    let mut given = pair();
    given[10] = 9.0;
    given[30] = -2.0;
    let limits = |low: f64, high: f64| PitchLimits { single_pitch_um: Some([low, high]), ..PitchLimits::default() };
    assert_eq!(measured(given.clone()).single_pitch.map(|found| found.value_um), Some(9.0));
    assert_eq!(single(limits(-3.0, 10.0), &measured(given.clone()), None).within, Some(false));
    assert_eq!(single(limits(-8.0, 10.0), &measured(given), None).within, Some(true));
}

/// Φ(1) = 0.841 where the limit is one standard uncertainty away, Φ(2) = 0.977 at two.
#[test]
fn decisions_use_the_given_uncertainty() {
    let limits = |high: f64| PitchLimits { single_pitch_um: Some([-100.0, high]), ..PitchLimits::default() };
    let decided = |high: f64| single(limits(high), &measured(pair()), Some(1.0)).conformity.unwrap();
    assert!((decided(8.0).probability[0] - 0.841_344_746).abs() < 1e-8);
    assert_eq!(decided(8.0).verdict, ConformityVerdict::Undecidable);
    assert_eq!(decided(9.0).verdict, ConformityVerdict::Conforms);
    assert_eq!(decided(5.0).verdict, ConformityVerdict::DoesNotConform);
    // a range near 0 is not thought to lie below it
    let tiny = PitchLimits { cumulative_pitch_um: Some([0.0, 20.0]), ..PitchLimits::default() };
    let found = tiny.cumulative_pitch(&measured(vec![0.0; 50]), None, Rounding::Unrounded, Some(2.0)).unwrap();
    let conformity = found.conformity.unwrap();
    assert_eq!((conformity.verdict, conformity.limits), (ConformityVerdict::Conforms, [0.0, 20.0]));
    assert!(conformity.probability[0] > 0.999_999);
}

#[test]
fn with_teeth_missing_nothing_conforms() {
    let mut given = pair();
    given[40] = f64::NAN;
    let limits = |high: f64| PitchLimits { single_pitch_um: Some([-10.0, high]), ..PitchLimits::default() };
    let found = single(limits(10.0), &measured(given.clone()), Some(1.0));
    assert_eq!((found.within, found.conformity), (None, None));
    assert_eq!(single(limits(6.0), &measured(given), None).within, Some(false));
}

#[test]
fn a_class_that_there_is_not_is_refused() {
    let none = PitchLimits { class: Some(12), ..PitchLimits::default() };
    assert_eq!(none.class_refused(&Tolerances::new(&gear())).as_deref(), Some("12 is not one of 1 to 11"));
    let small = Gear::new(GearData::spur(50, 0.2)).unwrap();
    let class = PitchLimits { class: Some(5), ..PitchLimits::default() };
    let refused = class.class_refused(&Tolerances::new(&small)).unwrap();
    assert!(refused.starts_with("the class gives no limits: "), "{refused}");
    assert_eq!(PitchLimits::default().class_refused(&Tolerances::new(&small)), None);
}
