//! Registration with wrongly named teeth, and with motions that do not have all that the part was
//! moved by.

use crate::gear_registration::{gear, helical};
use crate::gear_registration_motion::{moved, places, plain};
use crate::oracle::random::Random;
use crate::problems::config;
use flankfit_engine::estimation::FitError;
use flankfit_engine::gear::deviation::{MeasuredPoint, Measurement, Reference, measure};
use flankfit_engine::gear::registration::{Motion, Pose, Registering, Registration, register_from, start};
use flankfit_engine::gear::{Gear, Hand, Side, warning::Warning};
use flankfit_engine::geometry::space::Vector;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Warnings by which a result is not to be trusted.
const DOUBTS: [&str; 5] =
    ["poor_fit", "points_misfit", "flanks_ambiguous", "registration_not_converged", "axial_shift_for_rotation"];
const FIVE: [Motion; 5] = [Motion::XShift, Motion::YShift, Motion::XTilt, Motion::YTilt, Motion::Rotation];

/// Registration like the service's; `None` if a point has no foot on the nominal flank.
fn tried(gear: &Gear, touches: &[MeasuredPoint], motions: &[Motion]) -> Option<Result<Registration, FitError>> {
    let (reference, spec) = (Reference::new(gear), plain());
    let asked = Registering { motions, pivot: Some(22.0), weight: None, spec: &spec };
    let begun = match start(gear, touches, 0.0, &asked) {
        Ok(begun) => begun,
        Err(faults) => return Some(Err(faults.into())),
    };
    let deviations = measure(&reference, &begun.touches, &Measurement::default()).ok()?;
    Some(register_from(&reference, &deviations, &asked, &begun))
}

fn laid(gear: &Gear, touches: &[MeasuredPoint], motions: &[Motion]) -> Result<Registration, FitError> {
    tried(gear, touches, motions).expect("every point has a foot")
}

/// Points of so many teeth with 0.5 µm of noise, moved.
fn part(gear: &Gear, teeth: u32, pose: &Pose, random: &mut Random) -> Vec<MeasuredPoint> {
    let clean = places(gear, teeth, &[Side::Left, Side::Right], |_, _, _| 0.0, 0.0);
    let mut noise = || 5e-4 * Vector::from_fn(|_, _| random.normal());
    moved(&clean, pose).iter().map(|touch| MeasuredPoint { point: touch.point + noise(), ..*touch }).collect()
}

/// Names the k-th of the measured teeth otherwise, `by` teeth on.
fn misname(gear: &Gear, touches: &mut [MeasuredPoint], k: usize, by: u32) {
    let each = touches.len() / touches.len().div_euclid(50);
    for touch in &mut touches[k * each..(k + 1) * each] {
        touch.tooth = touch.tooth.map(|tooth| (tooth - 1 + by) % gear.data().teeth + 1);
    }
}

fn codes(answer: &Registration) -> Vec<&'static str> {
    answer.warnings.iter().map(|warning| warning.code()).collect()
}

/// Shifts up to half a module, tilts up to 1 mrad, any rotation.
fn anywhere(gear: &Gear, random: &mut Random) -> Pose {
    let mut pose = Pose { pivot: 22.0, ..Pose::default() };
    let most = 500.0 * gear.data().normal_module;
    for (motion, most) in FIVE.into_iter().zip([0.7 * most, 0.7 * most, 1e3, 1e3, 1e6 * PI]) {
        pose.set(motion, random.between(-most, most));
    }
    pose
}

fn worst(answer: &Registration, pose: &Pose) -> f64 {
    let each = answer.motions.iter().map(|found| {
        let error = found.value - pose.get(found.motion);
        let error =
            if found.motion == Motion::Rotation { error - 2e6 * PI * (error / 2e6 / PI).round() } else { error };
        error.abs() / found.std_error.expect("points of all teeth tell it")
    });
    each.fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(config(16))]

    /// One tooth of four and two of six, with flanks given or not.
    #[test]
    fn a_minority_of_wrong_names_is_put_right(seed: u64, sides: bool, six: bool) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 61);
        let pose = anywhere(&gear, &mut random);
        let teeth = if six { 6 } else { 4 };
        let mut touches = part(&gear, teeth, &pose, &mut random);
        let right: Vec<Option<u32>> = touches.iter().map(|touch| touch.tooth).collect();
        let wrong: &[usize] = if six { &[1, 4] } else { &[2] };
        for &k in wrong {
            misname(&gear, &mut touches, k, 1 + random.below(3) as u32);
        }
        if !sides {
            touches.iter_mut().for_each(|touch| touch.side = None);
        }
        let answer = laid(&gear, &touches, &FIVE).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert!(codes(&answer).contains(&"teeth_contradict"), "{:?}", codes(&answer));
        if sides || !codes(&answer).contains(&"flanks_ambiguous") {
            prop_assert!(worst(&answer, &pose) < 5.0, "{:?} for {:?}", answer.pose, pose);
            prop_assert!(answer.deviations.nodes.iter().zip(&right).all(|(node, right)| Some(node.tooth) == *right));
        }
    }

    /// Whatever was moved and whatever is free: what the free motions can have is found, and no
    /// answer without a doubt is far from what was done.
    #[test]
    fn no_combination_of_motions_runs_away(seed: u64, free in 1usize..64, done in 0usize..64, known: bool, far: bool) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 62);
        let of = |bits: usize| Motion::ALL.into_iter().enumerate().filter(move |(k, _)| bits >> k & 1 == 1);
        let motions: Vec<Motion> = of(free).map(|(_, motion)| motion).collect();
        prop_assume!(gear.data().helix_angle > 0.0 || motions != [Motion::AxialShift]);
        let size = if far { 20.0 } else { 1.0 };
        let mut pose = Pose { pivot: 22.0, ..Pose::default() };
        for (_, motion) in of(done) {
            let most = if motion.is_angle() { 100.0 } else { 50.0 };
            pose.set(motion, size * random.between(-most, most));
        }
        let mut touches = part(&gear, 4, &pose, &mut random);
        if !known {
            touches.iter_mut().for_each(|touch| (touch.tooth, touch.side) = (None, None));
        }
        // a refusal is an answer that no one takes for a motion
        let Some(Ok(answer)) = tried(&gear, &touches, &motions) else { return Ok(()) };
        prop_assume!(!codes(&answer).iter().any(|code| DOUBTS.contains(code)));
        // no point was moved by more than this, mm
        let way = places(&gear, 4, &[Side::Left, Side::Right], |_, _, _| 0.0, 0.0);
        let way = way.iter().map(|touch| (pose.apply(&touch.point) - touch.point).norm()).fold(0.0, f64::max);
        for found in &answer.motions {
            let arm = if found.motion.is_angle() { 1e-3 * gear.root_radius().min(12.0) } else { 1.0 };
            let slack = 10.0 * found.std_error.unwrap_or(0.0) * arm + 1.0;
            let screw = matches!(found.motion, Motion::AxialShift) && gear.data().helix_angle > 0.0;
            // along the axis a screw goes farther than about it
            let lead = if screw { 1.0 / gear.base_helix_angle().tan().min(1.0) } else { 1.0 };
            let limit = 1e3 * way * 4.0 * lead + slack;
            let moved = found.value.abs() * arm;
            let pitches = !known && matches!(found.motion, Motion::AxialShift | Motion::Rotation);
            let name = found.motion.name();
            prop_assert!(moved <= limit || pitches, "{name}: {} with {motions:?}, {pose:?}", found.value);
        }
    }
}

#[test]
fn without_a_majority_of_names_there_is_no_place() {
    let gear = helical(22.0, Hand::Right);
    let mut random = Random::new(63);
    let pose = anywhere(&gear, &mut random);
    for sides in [true, false] {
        let mut touches = part(&gear, 4, &pose, &mut random);
        for k in 0..3 {
            misname(&gear, &mut touches, k, 1 + 3 * k as u32);
        }
        if !sides {
            touches.iter_mut().for_each(|touch| touch.side = None);
        }
        let Err(FitError::Invalid(faults)) = laid(&gear, &touches, &FIVE) else { panic!("refused") };
        let [fault] = faults.list() else { panic!("one fault: {faults:?}") };
        assert_eq!(fault.path, "teeth");
        assert!(fault.message.contains("at most 25 %"), "{}", fault.message);
    }
    // all of them one on: the part is turned, and where it may not be, that is said
    let mut touches = part(&gear, 4, &Pose { pivot: 22.0, ..Pose::default() }, &mut random);
    (0..4).for_each(|k| misname(&gear, &mut touches, k, 1));
    let turned = laid(&gear, &touches, &FIVE).expect("a rotation by a pitch");
    assert!((turned.pose.get(Motion::Rotation).abs() - 1e6 * gear.pitch_angle()).abs() < 5.0);
    assert_eq!(codes(&turned), Vec::<&str>::new());
    let Err(FitError::Invalid(faults)) = laid(&gear, &touches, &[Motion::XShift, Motion::YShift]) else {
        panic!("refused")
    };
    assert_eq!(faults.list()[0].path, "teeth");
    assert!(faults.list()[0].message.contains("1 pitch "), "{}", faults.list()[0].message);
}

/// A part that is turned, with only the axial shift free: the equivalent screw is returned, with a
/// warning.
#[test]
fn an_axial_shift_equivalent_to_a_rotation_is_warned_of() {
    let gear = helical(22.0, Hand::Right);
    let mut random = Random::new(64);
    let turn = 0.58e6;
    let pose = Pose { values: [0.0, 0.0, 0.0, 0.0, 0.0, turn], pivot: 22.0 };
    let touches = part(&gear, 4, &pose, &mut random);
    let answer = laid(&gear, &touches, &[Motion::AxialShift]).expect("a registration");
    assert!(answer.converged && answer.pose.get(Motion::AxialShift).abs() > 50_000.0, "{:?}", answer.pose);
    let named = answer.warnings.iter().find_map(|warning| match warning {
        Warning::AxialShiftForRotation { rotation_urad, .. } => Some(*rotation_urad),
        _ => None,
    });
    assert!((named.expect("a warning") - turn).abs() < 100.0, "{named:?}");
    // a part that was only shifted is not doubted
    let pose = Pose { values: [0.0, 0.0, 900.0, 0.0, 0.0, 0.0], pivot: 22.0 };
    for known in [true, false] {
        let mut touches = part(&gear, 4, &pose, &mut random);
        if !known {
            touches.iter_mut().for_each(|touch| (touch.tooth, touch.side) = (None, None));
        }
        let answer = laid(&gear, &touches, &[Motion::AxialShift]).expect("a registration");
        assert!((answer.pose.get(Motion::AxialShift) - 900.0).abs() < 2.0, "{:?}", answer.pose);
        assert!(!codes(&answer).contains(&"axial_shift_for_rotation"));
    }
}
