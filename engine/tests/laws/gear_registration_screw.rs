//! Rotation and axial shift together: a rotation remains a rotation, and a modification that
//! changes along z reveals a real axial shift.

use crate::gear_registration::helical;
use crate::gear_registration_motion::{moved, places, plain};
use crate::oracle::random::Random;
use flankfit_engine::estimation::spec::{FitSpec, Model, Scaling};
use flankfit_engine::gear::deviation::{MeasuredPoint, Measurement, Reference, measure};
use flankfit_engine::gear::registration::{Motion, Pose, Registering, Registration, register_from, start};
use flankfit_engine::gear::{Gear, Hand, Side};
use flankfit_engine::geometry::space::Vector;

const BOTH: [Side; 2] = [Side::Left, Side::Right];
const SCREW: [Motion; 2] = [Motion::AxialShift, Motion::Rotation];

/// Helix crowning by `amount` µm at the ends of the points, z = 10 to 34 mm.
fn crowning(amount: f64) -> impl Fn(Side, f64, f64) -> f64 + Sync {
    move |_, _, z| amount * ((z - 22.0) / 12.0).powi(2)
}

fn part(gear: &Gear, amount: f64, pose: &Pose) -> Vec<MeasuredPoint> {
    let relief = crowning(amount);
    moved(&places(gear, 4, &BOTH, |side, l, z| -relief(side, l, z), 0.0), pose)
}

fn laid(gear: &Gear, amount: f64, touches: &[MeasuredPoint], motions: &[Motion], spec: &FitSpec) -> Registration {
    let relief = crowning(amount);
    let reference = Reference { relief: (amount != 0.0).then_some(&relief), ..Reference::new(gear) };
    let asked = Registering { motions, pivot: Some(22.0), weight: None, spec };
    let begun = start(gear, touches, 0.0, &asked).expect("motions that points tell");
    let deviations = measure(&reference, &begun.touches, &Measurement::default()).expect("sound points");
    register_from(&reference, &deviations, &asked, &begun).expect("a registration")
}

fn screwed(axial: f64, rotation: f64) -> Pose {
    Pose { values: [0.0, 0.0, axial, 0.0, 0.0, rotation], pivot: 22.0 }
}

fn has(answer: &Registration, code: &str) -> bool {
    answer.warnings.iter().any(|warning| warning.code() == code)
}

#[test]
fn a_part_that_was_only_turned_is_not_shifted() {
    for (hand, amount) in [(Hand::Right, 0.0), (Hand::Left, 0.0), (Hand::Right, 10.0), (Hand::Left, -6.0)] {
        let gear = helical(22.0, hand);
        for (k, turn) in [-3.0e6, -0.9e6, -2e3, 0.0, 0.1e6, 0.3e6, 1.7e6, 3.1e6].into_iter().enumerate() {
            let touches = part(&gear, amount, &screwed(0.0, turn));
            let scaling = if k % 2 == 0 { Scaling::UnitLength } else { Scaling::None };
            let spec = FitSpec { scaling, ..FitSpec::new(Model::Linear) };
            for motions in [&SCREW[..], &Motion::ALL] {
                let answer = laid(&gear, amount, &touches, motions, &spec);
                let [axial, rotation] = SCREW.map(|motion| answer.pose.get(motion));
                assert!(axial.abs() < 0.1, "{axial} µm at {turn} with {amount}");
                assert!((rotation - turn).abs() < 1e-2, "{rotation} instead of {turn}");
                assert!(answer.rms_after_um < 1e-3, "{} µm at {turn} with {amount}", answer.rms_after_um);
                assert!(answer.deviations.nodes.iter().all(|node| (9.99..34.01).contains(&node.z)));
                let message = answer.warnings.iter().find(|warning| warning.code() == "motions_indistinguishable");
                assert!(
                    message.is_some_and(|warning| warning.to_string().contains("Positions along z")),
                    "{:?}",
                    answer.warnings
                );
                let undetermined = answer.motions.iter().filter(|moved| SCREW.contains(&moved.motion));
                undetermined.for_each(|moved| assert_eq!((moved.determined, moved.std_error), (false, None)));
            }
        }
    }
}

#[test]
fn crowning_determines_the_axial_shift() {
    for (helix, hand) in [(22.0, Hand::Right), (22.0, Hand::Left), (0.0, Hand::Right)] {
        let gear = helical(helix, hand);
        for (axial, turn) in [(300.0, 0.0), (-40.0, 0.0), (300.0, 0.3e6), (-1500.0, -2.0e6)] {
            let touches = part(&gear, 10.0, &screwed(axial, turn));
            for motions in [&SCREW[..], &Motion::ALL] {
                let answer = laid(&gear, 10.0, &touches, motions, &plain());
                let found = SCREW.map(|motion| answer.pose.get(motion));
                assert!((found[0] - axial).abs() < 1e-2 && (found[1] - turn).abs() < 1e-2, "{found:?} {axial} {turn}");
                assert!(answer.rms_after_um < 1e-4 && answer.converged, "{}", answer.rms_after_um);
                assert!(has(&answer, "axial_shift_by_modification") && !has(&answer, "motions_indistinguishable"));
                assert!(answer.motions.iter().all(|moved| moved.determined && moved.std_error.is_some()));
            }
        }
    }
}

#[test]
fn without_a_slope_along_z_a_screw_is_rotation() {
    let gear = helical(22.0, Hand::Right);
    let answer = laid(&gear, 0.0, &part(&gear, 0.0, &screwed(300.0, 0.0)), &Motion::ALL, &plain());
    let [axial, rotation] = SCREW.map(|motion| answer.pose.get(motion));
    assert_eq!(axial, 0.0);
    assert!((rotation + 1e3 * gear.turn_per_length() * 300.0).abs() < 1e-3 && answer.rms_after_um < 1e-6);
}

/// Noise of 0.5 µm: a turned part stays unshifted, and the errors of a shifted one are those of the
/// noise.
#[test]
fn noise_makes_no_axial_shift_and_errors_are_true() {
    let gear = helical(22.0, Hand::Left);
    let mut random = Random::new(51);
    let (runs, mut shifted, mut square) = (40, 0, [0.0; 2]);
    for _ in 0..runs {
        let mut noisy = |pose: &Pose| -> Vec<MeasuredPoint> {
            let noise = |touch: &MeasuredPoint, e: Vector| MeasuredPoint { point: touch.point + 5e-4 * e, ..*touch };
            let each = part(&gear, 10.0, pose);
            each.iter().map(|touch| noise(touch, Vector::from_fn(|_, _| random.normal()))).collect()
        };
        let turned = laid(&gear, 10.0, &noisy(&screwed(0.0, 0.1e6)), &SCREW, &plain());
        shifted += usize::from(turned.pose.get(Motion::AxialShift) != 0.0);
        let pose = screwed(800.0, 0.1e6);
        let answer = laid(&gear, 10.0, &noisy(&pose), &SCREW, &plain());
        for (square, moved) in square.iter_mut().zip(&answer.motions) {
            let error = moved.value - pose.get(moved.motion);
            *square += (error / moved.std_error.expect("determined by the crowning")).powi(2) / f64::from(runs);
        }
    }
    assert_eq!(shifted, 0);
    // a mean of 40 squares has standard deviation 0.22
    assert!(square.iter().all(|s| (0.3..1.9).contains(s)), "{square:?}");
}
