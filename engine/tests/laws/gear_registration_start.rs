//! Registration of parts that lie anywhere: turned by any angle, shifted by as much as the module,
//! tilted, with noise, on gears of every kind.

use crate::gear_registration::{gear, helical};
use crate::gear_registration_motion::{moved, places, plain};
use crate::oracle::random::Random;
use crate::problems::config;
use flankfit_engine::estimation::spec::{FitSpec, Model};
use flankfit_engine::gear::deviation::{FootlessPoints, MeasuredPoint, Measurement, Reference, measure};
use flankfit_engine::gear::registration::{Motion, Pose, Registering, Registration, register_from, start};
use flankfit_engine::gear::{Gear, Hand, Side};
use flankfit_engine::geometry::space::Vector;
use proptest::prelude::*;
use std::f64::consts::PI;

const FIVE: [Motion; 5] = [Motion::XShift, Motion::YShift, Motion::XTilt, Motion::YTilt, Motion::Rotation];
const BOTH: [Side; 2] = [Side::Left, Side::Right];
/// Warnings by which a result is not to be trusted.
const DOUBTS: [&str; 4] = ["poor_fit", "points_misfit", "flanks_ambiguous", "registration_not_converged"];

/// µm of noise in every coordinate.
const NOISE: f64 = 0.5;

fn laid(gear: &Gear, touches: &[MeasuredPoint], motions: &[Motion]) -> Registration {
    let (reference, spec) = (Reference::new(gear), plain());
    let asked = Registering { motions, pivot: Some(22.0), weight: None, spec: &spec };
    let begun = start(gear, touches, 0.0, &asked).expect("motions that points tell");
    let measurement = Measurement { strays: FootlessPoints::Undefined, ..Measurement::default() };
    let deviations = measure(&reference, &begun.touches, &measurement).expect("sound points");
    register_from(&reference, &deviations, &asked, &begun).expect("a registration")
}

/// Random points of random flanks all round, moved, with noise; teeth and flanks are given as
/// `known` says.
fn part(gear: &Gear, random: &mut Random, pose: &Pose, known: [bool; 2]) -> Vec<MeasuredPoint> {
    let clean = places(gear, 5, &BOTH, |_, _, _| 0.0, 0.0);
    let noisy = |touch: &MeasuredPoint| MeasuredPoint {
        point: touch.point + 1e-3 * NOISE * Vector::from_fn(|_, _| random.normal()),
        tooth: touch.tooth.filter(|_| known[0]),
        side: touch.side.filter(|_| known[1]),
        normal: None,
    };
    moved(&clean, pose).iter().map(noisy).collect()
}

/// Shifts up to a module, tilts up to 2 mrad, any rotation.
fn anywhere(gear: &Gear, random: &mut Random) -> Pose {
    let mut pose = Pose { pivot: 22.0, ..Pose::default() };
    let (size, angle) = (random.between(0.0, 1e3 * gear.data().normal_module), random.between(-PI, PI));
    pose.set(Motion::XShift, size * angle.cos());
    pose.set(Motion::YShift, size * angle.sin());
    pose.set(Motion::XTilt, random.between(-2e3, 2e3));
    pose.set(Motion::YTilt, random.between(-2e3, 2e3));
    pose.set(Motion::Rotation, 1e6 * random.between(-PI, PI));
    pose
}

/// Errors in standard errors; rotations that differ by whole periods (rad) are one.
fn errors(answer: &Registration, pose: &Pose, period: f64) -> Vec<f64> {
    let each = answer.motions.iter().map(|found| {
        let error = found.value - pose.get(found.motion);
        let period = 1e6 * if found.motion == Motion::Rotation { period } else { 0.0 };
        let error = if period > 0.0 { error - period * (error / period).round() } else { error };
        error.abs() / found.std_error.expect("points of all teeth tell it")
    });
    each.collect()
}

fn has(answer: &Registration, code: &str) -> bool {
    answer.warnings.iter().any(|warning| warning.code() == code)
}

proptest! {
    #![proptest_config(config(24))]

    /// Without teeth and flanks any position is found, up to whole pitches, or the answer is
    /// doubted.
    #[test]
    fn any_position_is_found_or_doubted(seed: u64) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 31);
        let pose = anywhere(&gear, &mut random);
        let known = [false, random.below(2) == 0];
        let touches = part(&gear, &mut random, &pose, known);
        let answer = laid(&gear, &touches, &FIVE);
        let pitch = gear.pitch_angle();
        let found = errors(&answer, &pose, pitch).iter().all(|error| *error < 5.0);
        prop_assert!(found || DOUBTS.iter().any(|code| has(&answer, code)), "{:?} for {:?}", answer.pose, pose);
        prop_assert!(has(&answer, "rotation_modulo_pitch"));
        prop_assert!(answer.pose.get(Motion::Rotation).abs() <= 0.51e6 * pitch);
    }

    /// With teeth and flanks given, the rotation is known over the full circle.
    #[test]
    fn known_teeth_and_flanks_make_the_rotation_unique(seed: u64, side: bool) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 32);
        let pose = anywhere(&gear, &mut random);
        let touches = part(&gear, &mut random, &pose, [true, side]);
        let answer = laid(&gear, &touches, &FIVE);
        let worst = errors(&answer, &pose, 2.0 * PI).into_iter().fold(0.0, f64::max);
        if side {
            prop_assert!(answer.converged && worst < 5.0, "{worst}: {:?} for {:?}", answer.pose, pose);
            prop_assert!(answer.warnings.is_empty(), "{:?}", answer.warnings);
        } else {
            prop_assert!(worst < 5.0 || DOUBTS.iter().any(|code| has(&answer, code)));
            prop_assert!(!has(&answer, "rotation_modulo_pitch"));
        }
    }
}

/// Found, not only doubted: all of a hundred.
#[test]
fn positions_are_found() {
    let mut lost = Vec::new();
    for seed in 0..100 {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 33);
        let pose = anywhere(&gear, &mut random);
        let answer = laid(&gear, &part(&gear, &mut random, &pose, [false; 2]), &FIVE);
        let worst = errors(&answer, &pose, gear.pitch_angle()).into_iter().fold(0.0, f64::max);
        if worst > 5.0 || DOUBTS.iter().any(|code| has(&answer, code)) {
            lost.push(seed);
        }
    }
    assert!(lost.is_empty(), "{lost:?}");
}

/// The report: z = 31, β = 22°, turned by 45,000 µrad; and a shift of 1 mm with a tilt of 2 mrad.
#[test]
fn large_motions_no_longer_end_on_wrong_flanks() {
    let gear = helical(22.0, Hand::Right);
    let motions = [
        ([0.0, 0.0, 0.0, 0.0, 0.0, 45_000.0], true),
        ([0.0, 0.0, 0.0, 0.0, 0.0, 70_000.0], true),
        ([1000.0, 0.0, 0.0, 2000.0, 0.0, 0.0], false),
        ([2500.0, 0.0, 0.0, 2000.0, 0.0, 0.0], true),
    ];
    for (values, reassigned) in motions {
        let pose = Pose { values, pivot: 22.0 };
        let mut random = Random::new(2);
        let answer = laid(&gear, &part(&gear, &mut random, &pose, [false; 2]), &FIVE);
        let worst = errors(&answer, &pose, gear.pitch_angle()).into_iter().fold(0.0, f64::max);
        assert!(worst < 4.0 && answer.converged, "{worst}");
        assert!(answer.rms_after_um < 1.0, "{}", answer.rms_after_um);
        let codes: Vec<_> = answer.warnings.iter().map(|warning| warning.code()).collect();
        assert_eq!(codes[0], "rotation_modulo_pitch");
        assert_eq!(codes[1..].contains(&"flanks_reassigned"), reassigned, "{values:?}: {codes:?}");
        assert!(codes.len() <= 2, "{codes:?}");
        // every point is on the flank that it was made on, but for whole pitches
        let made = places(&gear, 5, &BOTH, |_, _, _| 0.0, 0.0);
        assert!(answer.deviations.nodes.iter().zip(&made).all(|(node, touch)| Some(node.side) == touch.side));
    }
}

/// Rotation alone, with flanks given or not: any angle of a pitch, whatever the number of points.
#[test]
fn rotations_alone_are_found() {
    let gear = helical(22.0, Hand::Left);
    let pitch = 1e6 * gear.pitch_angle();
    for k in -9..=9 {
        let pose = Pose { values: [0.0, 0.0, 0.0, 0.0, 0.0, 0.05 * f64::from(k) * pitch], pivot: 22.0 };
        let mut random = Random::new(40);
        for known in [[false; 2], [false, true], [true, true]] {
            let answer = laid(&gear, &part(&gear, &mut random, &pose, known), &[Motion::Rotation]);
            assert!((answer.pose.get(Motion::Rotation) - pose.get(Motion::Rotation)).abs() < 5.0, "{k} {known:?}");
        }
    }
}

#[test]
fn misfits_are_warned_of() {
    let gear = helical(22.0, Hand::Right);
    let mut random = Random::new(50);
    let still = Pose { pivot: 22.0, ..Pose::default() };
    // a tilt that is not free
    let tilted = Pose { values: [0.0, 0.0, 0.0, 12_000.0, 0.0, 0.0], pivot: 22.0 };
    let answer = laid(&gear, &part(&gear, &mut random, &tilted, [false; 2]), &[Motion::Rotation]);
    assert!(has(&answer, "poor_fit"), "{:?}", answer.warnings);
    // a few points with dust
    let mut dusty = part(&gear, &mut random, &still, [true; 2]);
    dusty[7].point.x += 0.3;
    let answer = laid(&gear, &dusty, &FIVE);
    assert!(has(&answer, "points_misfit"), "{:?}", answer.warnings);
    // one tooth is named wrongly by two
    let mut wrong = part(&gear, &mut random, &still, [true, false]);
    for touch in &mut wrong[50..100] {
        touch.tooth = touch.tooth.map(|tooth| tooth + 2);
    }
    let answer = laid(&gear, &wrong, &FIVE);
    assert!(has(&answer, "teeth_contradict"), "{:?}", answer.warnings);
    // points above the tip
    let above = |touch: &MeasuredPoint| MeasuredPoint { point: touch.point * 1.01, ..*touch };
    let high: Vec<MeasuredPoint> = part(&gear, &mut random, &still, [true; 2]).iter().map(above).collect();
    let answer = laid(&gear, &high, &[Motion::Rotation]);
    assert!(has(&answer, "points_outside_flank"), "{:?}", answer.warnings);
    // one circle of left flanks alone might as well be of right flanks
    let ring: Vec<MeasuredPoint> = (1..=31)
        .map(|tooth| {
            MeasuredPoint::anywhere(crate::gear_registration::above(&gear, tooth, Side::Left, 15.0, 20.0, 0.0))
        })
        .collect();
    let answer = laid(&gear, &ring, &[Motion::Rotation]);
    assert!(has(&answer, "flanks_ambiguous") && answer.pose.get(Motion::Rotation).abs() < 1.0, "{:?}", answer.pose);
    // a sound part is not doubted
    let answer = laid(&gear, &part(&gear, &mut random, &still, [true; 2]), &FIVE);
    assert!(answer.warnings.is_empty(), "{:?}", answer.warnings);
}

/// Points of one section of a spur gear say nothing of a tilt about a pivot in it.
#[test]
fn motions_that_the_points_do_not_determine_have_no_error() {
    let gear = helical(0.0, Hand::Right);
    let point = |k: usize| crate::gear_registration::above(&gear, 1, Side::Left, 12.0 + k as f64, 20.0, 0.0);
    let touches: Vec<MeasuredPoint> = (0..9)
        .map(|k| MeasuredPoint { tooth: Some(1), side: Some(Side::Left), ..MeasuredPoint::anywhere(point(k)) })
        .collect();
    let reference = Reference::new(&gear);
    let spec = plain();
    let motions = [Motion::XShift, Motion::YTilt, Motion::Rotation];
    let asked = Registering { motions: &motions, pivot: Some(20.0), weight: None, spec: &spec };
    let begun = start(&gear, &touches, 0.0, &asked).expect("motions");
    let deviations = measure(&reference, &begun.touches, &Measurement::default()).expect("sound points");
    let answer = register_from(&reference, &deviations, &asked, &begun).expect("a registration");
    let determined: Vec<bool> = answer.motions.iter().map(|moved| moved.determined).collect();
    assert_eq!(determined, [true, false, true]);
    assert!(answer.motions.iter().all(|moved| moved.std_error.is_some() == moved.determined));
    assert!(has(&answer, "motions_indistinguishable"));
}

/// A single flank that lies a third of a pitch off: what it does not determine stays damped,
/// towards its position.
#[test]
fn regularisation_counts_from_where_the_part_lies() {
    let gear = helical(20.0, Hand::Left);
    let reference = Reference::new(&gear);
    let mut random = Random::new(11);
    let clean = places(&gear, 1, &[Side::Left], |_, _, _| 0.0, 0.0);
    let spec = FitSpec::new(Model::Linear);
    let asked = Registering { motions: &Motion::ALL, pivot: Some(22.0), weight: None, spec: &spec };
    let turn = 0.3e6 * gear.pitch_angle();
    let mut after = Vec::new();
    for rotation in [0.0, turn] {
        let pose = Pose { values: [0.0, 0.0, 0.0, 0.0, 0.0, rotation], pivot: 22.0 };
        let mut noise = || 3e-4 * Vector::from_fn(|_, _| random.normal());
        let touches: Vec<MeasuredPoint> =
            moved(&clean, &pose).iter().map(|touch| MeasuredPoint { point: touch.point + noise(), ..*touch }).collect();
        let begun = start(&gear, &touches, 0.0, &asked).expect("motions");
        let deviations = measure(&reference, &begun.touches, &Measurement::default()).expect("sound points");
        let answer = register_from(&reference, &deviations, &asked, &begun).expect("a registration");
        // at home the fit counts from 0
        assert_eq!(answer.motions.iter().all(|moved| moved.start == 0.0), rotation == 0.0);
        assert!(answer.converged && answer.rms_after_um < 0.5, "{}", answer.rms_after_um);
        after.push(answer);
    }
    // noise of 0.3 µm does not become motions of millimetres
    let far = |answer: &Registration| answer.motions.iter().map(|m| (m.value - m.start).abs()).fold(0.0, f64::max);
    assert!(after.iter().all(|answer| far(answer) < 500.0), "{:?}", after.iter().map(far).collect::<Vec<_>>());
}
