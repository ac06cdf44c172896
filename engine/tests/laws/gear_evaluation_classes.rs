//! Tolerances and classes of ISO 1328-1:2013, pitch and run-out.

use std::f64::consts::{SQRT_2, TAU};

use flankfit_engine::gear::{
    Gear, GearData, Hand, Side,
    evaluation::{
        pitch::{Pitch, PitchMeasured, PitchSettings, pitch},
        runout::{Counting, from_pitches, from_readings},
    },
    tolerance::{Characteristic, Class, Quantity, Rounding, Tolerances, rounded},
};
use proptest::prelude::*;

/// d = 100 mm, m_n = 2 mm, b = 20 mm.
fn data() -> GearData {
    GearData {
        teeth: 50,
        normal_module: 2.0,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        hand: Hand::Right,
        profile_shift: 0.0,
        face_width: Some(20.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: None,
    }
}

fn gear(change: impl Fn(&mut GearData)) -> Gear {
    let mut data = data();
    change(&mut data);
    Gear::new(data).expect("the gear exists")
}

fn near(value: f64, want: f64, within: f64) {
    assert!((value - want).abs() <= within, "{value} is not {want}");
}

#[test]
fn tolerances_are_those_of_the_standard() {
    let tolerances = Tolerances::new(&gear(|_| ())).expect("within the scope");
    // unrounded and as the tables print them
    let fifth = [5.9, 19.1, 17.19, 4.9, 6.1, 7.824, 6.0652, 6.7125, 9.0467];
    let tables = [6.0, 19.0, 17.0, 4.9, 6.0, 8.0, 6.0, 6.5, 9.0];
    for ((characteristic, unrounded), printed) in Characteristic::ALL.into_iter().zip(fifth).zip(tables) {
        near(tolerances.unrounded(characteristic, 5).expect("class 5"), unrounded, 6e-4);
        assert_eq!(tolerances.rounded(characteristic, 5), Some(printed), "{}", characteristic.symbol());
        for class in 2..=11 {
            let of = |class| tolerances.unrounded(characteristic, class).expect("a class");
            near(of(class) / of(class - 1), SQRT_2, 1e-14);
        }
        assert_eq!(tolerances.unrounded(characteristic, 0), None);
        assert_eq!(tolerances.unrounded(characteristic, 12), None);
    }
    // totals are made of unrounded parts
    let of = |characteristic| tolerances.unrounded(characteristic, 8).expect("class 8");
    near(
        of(Characteristic::ProfileTotal),
        of(Characteristic::ProfileSlope).hypot(of(Characteristic::ProfileForm)),
        1e-12,
    );
    near(of(Characteristic::HelixTotal), of(Characteristic::HelixSlope).hypot(of(Characteristic::HelixForm)), 1e-12);
}

#[test]
fn outside_the_scope_there_is_nothing() {
    let excess = |change: fn(&mut GearData)| -> Vec<Quantity> {
        let out = Tolerances::new(&gear(change)).expect_err("outside");
        assert!(out.to_string().contains("does not cover"), "{out}");
        out.outside.iter().map(|e| e.quantity).collect()
    };
    assert_eq!(excess(|g| g.teeth = 4), [Quantity::Teeth]);
    assert_eq!(excess(|g| g.teeth = 1001), [Quantity::Teeth]);
    assert_eq!(excess(|g| g.normal_module = 0.49), [Quantity::NormalModule]);
    assert_eq!(excess(|g| g.normal_module = 71.0), [Quantity::NormalModule]);
    assert_eq!(excess(|g| g.face_width = Some(3.9)), [Quantity::FaceWidth]);
    assert_eq!(excess(|g| g.face_width = Some(1201.0)), [Quantity::FaceWidth]);
    assert_eq!(excess(|g| g.helix_angle = 45.1f64.to_radians()), [Quantity::HelixAngle]);
    assert_eq!(excess(|g| (g.teeth, g.normal_module) = (900, 20.0)), [Quantity::ReferenceDiameter]);
    assert_eq!(
        excess(|g| (g.teeth, g.normal_module) = (4, 0.2)),
        [Quantity::Teeth, Quantity::ReferenceDiameter, Quantity::NormalModule]
    );
    // both ends belong to it
    let edge = gear(|g| (g.teeth, g.helix_angle, g.face_width) = (5, 45f64.to_radians(), Some(4.0)));
    assert!(Tolerances::new(&edge).is_ok());
    // without a face width there is nothing to say about the helix
    let open = Tolerances::new(&gear(|g| g.face_width = None)).expect("within the scope");
    assert_eq!(open.class(Characteristic::HelixForm, 1.0, Rounding::Rounded), None);
    assert!(open.class(Characteristic::ProfileForm, 1.0, Rounding::Rounded).is_some());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The class is the finest one whose tolerance holds; greater values never reach a finer one,
    /// and signs do not matter.
    #[test]
    fn classes_grow_with_the_value(value in 0.0..400.0f64, more in 0.0..100.0f64, k in 0usize..9, unrounded: bool) {
        let tolerances = Tolerances::new(&gear(|_| ())).expect("within the scope");
        let rounding = if unrounded { Rounding::Unrounded } else { Rounding::Rounded };
        let characteristic = Characteristic::ALL[k];
        let class = |value| tolerances.class(characteristic, value, rounding).expect("a class");
        prop_assert!(class(value) <= class(value + more));
        prop_assert_eq!(class(value), class(-value));
        let limit = |class| {
            let limit = tolerances.unrounded(characteristic, class).expect("a class");
            if unrounded { limit } else { rounded(limit) }
        };
        match class(value) {
            Class::Within(1) => prop_assert!(value <= limit(1)),
            Class::Within(class) => prop_assert!(value <= limit(class) && value > limit(class - 1)),
            Class::Beyond => prop_assert!(value > limit(11)),
        }
        prop_assert_eq!(class(limit(7)), Class::Within(7));
    }

    /// Index deviations, angles and single pitches of the same gear answer the same; where teeth
    /// are counted from does not matter.
    #[test]
    fn pitches_agree_in_every_form(index in prop::collection::vec(-30.0..30.0f64, 50), start in 0usize..50,
        offset in -3.0..3.0f64) {
        let gear = gear(|_| ());
        let of = |measured: &PitchMeasured| answer(&gear, measured);
        let by_index = of(&PitchMeasured::Index(index.clone()));
        let angle = |(i, d): (usize, &f64)| offset + TAU * i as f64 / 50.0 + d * 1e-3 / 50.0;
        let by_angle = of(&PitchMeasured::Angles(index.iter().enumerate().map(angle).collect()));
        let single = (0..50).map(|i| index[i] - index[(i + 49) % 50]).collect();
        let by_single = of(&PitchMeasured::Single(single));
        let mut turned = index.clone();
        turned.rotate_left(start);
        let by_turned = of(&PitchMeasured::Index(turned));
        for other in [&by_angle, &by_single, &by_turned] {
            for (a, b) in values(&by_index).into_iter().zip(values(other)) {
                near(b, a, 1e-8);
            }
        }
        let [single, cumulative, sector, sum, adjacent] = values(&by_index);
        let around = |i: usize| index[i % 50];
        let within = |i: usize| (0..=6).flat_map(move |a| (0..=6).map(move |b| around(i + a) - around(i + b)));
        near(sector, (0..50).flat_map(within).fold(0.0, f64::max), 1e-9);
        near(sum, (0..50).map(|i| (around(i + 6) - around(i)).abs()).fold(0.0, f64::max), 1e-9);
        let whole = (0..8).map(|n| (index[6 * n + 6] - index[6 * n]).abs()).fold(0.0, f64::max);
        near(by_index.sector_sum_2013.expect("eight sectors").value_um.abs(), whole, 1e-9);
        prop_assert!(sum <= sector + 1e-12 && sector <= cumulative + 1e-12 && single <= cumulative + 1e-12);
        prop_assert!(adjacent <= 2.0 * single + 1e-12);
        prop_assert!(by_index.complete && by_index.warnings.is_empty());
        // each pitch is one of the sums
        let total: f64 = by_index.single_pitch_deviation_um.iter().map(|f| f.expect("complete")).sum();
        near(total, 0.0, 1e-9);
    }

    /// Readings of an eccentric gear: twice the amount, at its angle; readings from both flanks'
    /// index deviations see the same.
    #[test]
    fn eccentricity_is_found(amount in 0.1..80.0f64, angle in -3.0..3.0f64, level in -100.0..100.0f64,
        gap in 0usize..50) {
        let gear = gear(|g| g.teeth = 48);
        let phase = |i: usize| TAU * i as f64 / 48.0 - angle;
        let mut readings: Vec<f64> = (0..48).map(|i| level + amount * phase(i).cos()).collect();
        let answer = from_readings(&gear, &readings, Rounding::Rounded).expect("48 readings");
        prop_assert!(answer.runout_um <= 2.0 * amount + 1e-9 && answer.runout_um >= 1.99 * amount);
        prop_assert!(answer.class.is_some() != answer.coarser_than_11 && !answer.derived);
        let found = answer.eccentricity.expect("enough readings");
        near(found.amount_um, amount, 1e-9);
        near(found.angle_deg.to_radians(), angle, 1e-6);
        readings[gap % 48] = f64::NAN;
        let answer = from_readings(&gear, &readings, Rounding::Rounded).expect("47 readings");
        prop_assert!(answer.class.is_none() && answer.missing == 1);
        prop_assert_eq!(answer.warnings[0].code(), "missing_teeth");
        near(answer.eccentricity.expect("enough readings").amount_um, amount, 1e-9);
    }
}

fn answer(gear: &Gear, measured: &PitchMeasured) -> Pitch {
    let settings = PitchSettings { side: Side::Left, diameter: None, sector: Some(6), rounding: Rounding::Rounded };
    pitch(gear, measured, &settings).expect("sound")
}

fn values(pitch: &Pitch) -> [f64; 5] {
    let amount = |extreme: Option<flankfit_engine::gear::evaluation::pitch::Extreme>| {
        extreme.expect("there is one").value_um.abs()
    };
    [
        amount(pitch.single_pitch),
        pitch.cumulative_pitch_um.expect("there is one"),
        amount(pitch.sector_pitch_2013),
        amount(pitch.sector_pitch_1995),
        amount(pitch.adjacent_pitch_difference),
    ]
}

#[test]
fn pitch_of_few_teeth_by_hand() {
    let gear = gear(|g| (g.teeth, g.profile_shift) = (8, 0.6));
    let index = vec![0.0, 3.0, 1.0, -4.0, -2.0, 0.0, 5.0, 2.0];
    let settings = PitchSettings { side: Side::Right, diameter: None, sector: None, rounding: Rounding::Unrounded };
    let answer = pitch(&gear, &PitchMeasured::Index(index.clone()), &settings).expect("sound");
    let single: Vec<f64> = answer.single_pitch_deviation_um.iter().map(|f| f.expect("complete")).collect();
    assert_eq!(single, [-2.0, 3.0, -2.0, -5.0, 2.0, 2.0, 5.0, -3.0]);
    let extreme = |e: Option<flankfit_engine::gear::evaluation::pitch::Extreme>| e.map(|e| (e.value_um, e.tooth));
    assert_eq!(extreme(answer.single_pitch), Some((-5.0, 4)));
    assert_eq!(answer.cumulative_pitch_um, Some(9.0));
    assert_eq!(answer.k, Some(1));
    // for one pitch the editions agree
    assert_eq!(extreme(answer.sector_pitch_2013), Some((5.0, 4)));
    assert_eq!(extreme(answer.sector_pitch_1995), Some((-5.0, 4)));
    assert_eq!(extreme(answer.sector_sum_2013), Some((-5.0, 4)));
    let three = PitchSettings { sector: Some(3), ..settings };
    let answer_of = |index: &[f64]| pitch(&gear, &PitchMeasured::Index(index.to_vec()), &three).expect("sound");
    let found = answer_of(&[0.0, 3.0, -4.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(extreme(found.sector_pitch_2013), Some((7.0, 3)));
    assert_eq!(extreme(found.sector_sum_2013), Some((2.0, 4)));
    assert_eq!(extreme(found.sector_pitch_1995), Some((-4.0, 3)));
    // where k divides z, the last sector ends at the first tooth
    let two = PitchSettings { sector: Some(2), ..settings };
    let found = pitch(&gear, &PitchMeasured::Index(vec![0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 7.0, 0.0]), &two).expect("sound");
    assert_eq!(extreme(found.sector_sum_2013), Some((-7.0, 1)));
    let found = pitch(&gear, &PitchMeasured::Index(vec![0.0, 0.0, 0.0, 0.0, 3.0, 3.0, 4.0, 9.0]), &three);
    assert_eq!(extreme(found.expect("sound").sector_sum_2013), Some((4.0, 7)));
    // sectors with the missing tooth are skipped: 1–4 … 3–6 contain it
    let found = answer_of(&[0.0, 3.0, f64::NAN, 2.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(extreme(found.sector_pitch_2013), Some((3.0, 2)));
    assert_eq!(extreme(answer.adjacent_pitch_difference), Some((-8.0, 8)));
    assert_eq!(answer.class.single_pitch, Some(5));

    // a tooth that is missing takes two pitches with it, and the class
    let mut gap = index;
    gap[3] = f64::NAN;
    let answer = pitch(&gear, &PitchMeasured::Index(gap), &settings).expect("sound");
    assert_eq!(answer.single_pitch_deviation_um.iter().flatten().count(), 6);
    assert_eq!((answer.cumulative_pitch_um, answer.complete, answer.class.cumulative_pitch), (Some(7.0), false, None));
    assert_eq!(answer.warnings[0].code(), "missing_teeth");
    let answer = pitch(&gear, &PitchMeasured::Single(vec![1.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, -3.0]), &settings);
    let answer = answer.expect("sound");
    assert_eq!((answer.cumulative_pitch_um, answer.closure_um), (None, None));
    assert_eq!(extreme(answer.single_pitch), Some((-3.0, 8)));

    let off = pitch(&gear, &PitchMeasured::Single(vec![1.0; 8]), &settings).expect("sound");
    assert_eq!((off.closure_um, off.cumulative_pitch_um), (Some(8.0), Some(0.0)));
    assert_eq!(off.warnings[0].code(), "pitches_do_not_close");

    let wrong = PitchSettings { diameter: Some(-1.0), sector: Some(8), ..settings };
    let faults = pitch(&gear, &PitchMeasured::Index(vec![0.0; 7]), &wrong).expect_err("impossible");
    let places: Vec<_> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(places, ["index_deviation_um", "diameter_mm", "sector"]);
}

/// An eccentric gear moves both flanks of a space along with it; narrower spaces alone lift the
/// ball.
#[test]
fn runout_follows_from_both_flanks() {
    let gear = gear(|_| ());
    let tan = gear.transverse_pressure_angle().tan();
    let e = 10.0;
    for counting in [Counting::Counterclockwise, Counting::Clockwise] {
        // a flank is moved along its normal, ±cos α along the circle and sin α outwards; the space
        // after tooth i lies about the angle of i
        let of = |side: Side, offset: f64, first: f64, sign: f64| {
            let at = |i: i32| TAU * (f64::from(i) - first) / 50.0 + offset;
            let index = (0..50).map(|i| e * (-at(i).sin() + sign * tan * at(i).cos())).collect();
            let settings = PitchSettings { side, diameter: None, sector: None, rounding: Rounding::Rounded };
            pitch(&gear, &PitchMeasured::Index(index), &settings).expect("sound")
        };
        let (near_side, far_side) = match counting {
            Counting::Counterclockwise => (Side::Left, Side::Right),
            Counting::Clockwise => (Side::Right, Side::Left),
        };
        let half_space = TAU / 200.0;
        let (near_flank, far_flank) = (of(near_side, -half_space, 0.0, 1.0), of(far_side, half_space, 1.0, -1.0));
        let (left, right) = if near_side == Side::Left { (&near_flank, &far_flank) } else { (&far_flank, &near_flank) };
        let answer = from_pitches(&gear, left, right, counting, Rounding::Rounded).expect("sound");
        assert!(answer.derived);
        near(answer.runout_um, 2.0 * e, 0.05);
        near(answer.eccentricity.expect("50 readings").amount_um, e, 1e-9);
    }
}
