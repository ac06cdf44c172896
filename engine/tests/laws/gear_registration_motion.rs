//! Registration: given motions come back, indistinguishable ones are named, regularisation and
//! robustness are the service's.

use crate::gear_registration::{above, gear, helical, rolls, side};
use crate::oracle::random::Random;
use crate::problems::config;
use flankfit_engine::estimation::FitError;
use flankfit_engine::estimation::spec::{Estimator, FitSpec, Include, Model, Parameter, Regularization, Scaling};
use flankfit_engine::estimation::spec::{Loss, MEstimator};
use flankfit_engine::gear::deviation::{Deviations, MeasuredPoint, Measurement, Reference, measure};
use flankfit_engine::gear::registration::{Motion, Pose, Registering, Registration, columns::SCREW, register};
use flankfit_engine::gear::{Gear, Hand, Side};
use flankfit_engine::geometry::space::Vector;
use proptest::prelude::*;

const FIVE: [Motion; 5] = [Motion::XShift, Motion::YShift, Motion::XTilt, Motion::YTilt, Motion::Rotation];

pub fn plain() -> FitSpec {
    FitSpec { regularization: Regularization::None, ..FitSpec::new(Model::Linear) }
}

/// Places of the flanks: both sides of `teeth` teeth all round, `form` µm above the nominal flank.
pub fn places(
    gear: &Gear,
    teeth: u32,
    sides: &[Side],
    form: impl Fn(Side, f64, f64) -> f64,
    ball: f64,
) -> Vec<MeasuredPoint> {
    // where no motion carries a point into the base circle, 0.15 mm below
    let [low, high] = rolls(gear);
    let low = low.max((0.3 * gear.base_radius()).sqrt());
    let mut touches = Vec::new();
    for k in 0..teeth {
        let tooth = k * gear.data().teeth / teeth + 1;
        for &side in sides {
            for i in 0..5 {
                for j in 0..5 {
                    let roll = low.max(ball) + (high - low.max(ball)) * f64::from(i) / 4.0;
                    let z = 10.0 + 6.0 * f64::from(j);
                    let point = above(gear, tooth, side, roll, z, ball + 1e-3 * form(side, roll, z));
                    touches.push(MeasuredPoint {
                        tooth: Some(tooth),
                        side: Some(side),
                        ..MeasuredPoint::anywhere(point)
                    });
                }
            }
        }
    }
    touches
}

pub fn moved(touches: &[MeasuredPoint], pose: &Pose) -> Vec<MeasuredPoint> {
    touches.iter().map(|touch| MeasuredPoint { point: pose.apply(&touch.point), ..*touch }).collect()
}

fn measured(reference: &Reference, touches: &[MeasuredPoint], ball: f64) -> Deviations {
    let most = 0.5 * reference.gear.base_pitch() * reference.gear.base_helix_angle().cos();
    let measurement = Measurement { ball_radius: ball, reach: Some(most), ..Measurement::default() };
    measure(reference, touches, &measurement).expect("points of the flanks")
}

fn registered(reference: &Reference, deviations: &Deviations, motions: &[Motion], spec: &FitSpec) -> Registration {
    let asked = Registering { motions, pivot: Some(22.0), weight: None, spec };
    register(reference, deviations, &asked).expect("a registration")
}

fn random_pose(random: &mut Random, motions: &[Motion], size: f64) -> Pose {
    let mut pose = Pose { pivot: 22.0, ..Pose::default() };
    for motion in motions {
        // 50 µm and 0.5 mrad
        let most = if motion.is_angle() { 500.0 } else { 50.0 };
        pose.set(*motion, size * random.between(-most, most));
    }
    pose
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn a_motion_comes_back(seed: u64, regularized: bool, ball in prop::sample::select(vec![0.0, 0.5])) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 6);
        let reference = Reference::new(&gear);
        let spec = if regularized { FitSpec::new(Model::Linear) } else { plain() };
        let pose = random_pose(&mut random, &FIVE, 1.0);
        let touches = moved(&places(&gear, 4, &[Side::Left, Side::Right], |_, _, _| 0.0, ball), &pose);
        let deviations = measured(&reference, &touches, ball);
        let asked = Registering { motions: &FIVE, pivot: Some(22.0), weight: None, spec: &spec };
        let answer = register(&reference, &deviations, &asked).expect("a registration");
        prop_assert!(answer.converged && answer.iterations <= 8, "{} iterations", answer.iterations);
        let size = gear.tip_radius().max(1.0);
        for motion in FIVE {
            let (got, made) = (answer.pose.get(motion), pose.get(motion));
            prop_assert!((got - made).abs() < 2e-9, "{}: {got} instead of {made}", motion.name());
        }
        prop_assert!(answer.rms_after_um < 1e-9 * size && answer.rms_before_um > 0.1, "{}", answer.rms_after_um);
        prop_assert!(answer.motions.iter().all(|moved| moved.determined && moved.std_error.is_some()));
        prop_assert!(answer.deviations.nodes.iter().all(|node| node.deviation.abs() < 1e-7));
    }

    #[test]
    fn a_registered_part_needs_no_further_motion(seed: u64) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 8);
        let reference = Reference::new(&gear);
        let pose = random_pose(&mut random, &FIVE, 1.0);
        let form = |side: Side, l: f64, z: f64| 5.0 * (0.7 * l + 0.2 * side.sign() * z).sin();
        let touches = moved(&places(&gear, 4, &[Side::Left, Side::Right], form, 0.0), &pose);
        let first = registered(&reference, &measured(&reference, &touches, 0.0), &FIVE, &plain());
        let second = registered(&reference, &first.deviations, &FIVE, &plain());
        prop_assert!(first.converged && first.rms_after_um < 6.0 && first.rms_before_um > first.rms_after_um);
        prop_assert!(second.iterations <= 2, "{} iterations", second.iterations);
        prop_assert!(second.pose.values.iter().all(|value| value.abs() < 1e-6), "{:?}", second.pose.values);
        prop_assert!((second.rms_after_um - first.rms_after_um).abs() < 1e-9);
    }

    #[test]
    fn all_six_leave_the_screw(seed: u64, standard: bool) {
        let gear = gear(seed);
        prop_assume!(gear.data().helix_angle > 0.0);
        let mut random = Random::new(seed ^ 7);
        let reference = Reference::new(&gear);
        let pose = random_pose(&mut random, &Motion::ALL, 1.0);
        let touches = moved(&places(&gear, 3, &[Side::Left, Side::Right], |_, _, _| 0.0, 0.0), &pose);
        let deviations = measured(&reference, &touches, 0.0);
        let scaling = if standard { Scaling::UnitLength } else { Scaling::None };
        let spec = FitSpec { scaling, ..FitSpec::new(Model::Linear) };
        let mut motions = Motion::ALL;
        motions.reverse();
        let asked = Registering { motions: &motions, pivot: Some(22.0), weight: None, spec: &spec };
        let answer = register(&reference, &deviations, &asked).expect("a registration");
        for motion in [Motion::XShift, Motion::YShift, Motion::XTilt, Motion::YTilt] {
            prop_assert!((answer.pose.get(motion) - pose.get(motion)).abs() < 1e-7, "{}", motion.name());
        }
        let (sin_b, cos_b) = gear.base_helix_angle().sin_cos();
        let (a, b) = (1e-3 * gear.base_radius() * cos_b, -gear.hand() * sin_b);
        let joint = |pose: &Pose| a * pose.get(Motion::Rotation) + b * pose.get(Motion::AxialShift);
        prop_assert!((joint(&answer.pose) - joint(&pose)).abs() < 1e-7);
        // all of it is rotation, however the columns are scaled
        prop_assert_eq!(answer.pose.get(Motion::AxialShift), 0.0);
        prop_assert!(answer.rms_after_um < 1e-7 && answer.fit.coefficients.iter().any(|c| c.term == SCREW));
        for moved in &answer.motions {
            let joined = matches!(moved.motion, Motion::Rotation | Motion::AxialShift);
            prop_assert_eq!(moved.determined, !joined);
            prop_assert_eq!(moved.bias_bound.is_none(), joined);
            // what is shared between two motions says nothing of one of them
            prop_assert_eq!(moved.std_error.is_some(), moved.determined);
        }
        prop_assert!(answer.warnings.iter().any(|warning| warning.code() == "motions_indistinguishable"));
    }
}

#[test]
fn rotation_and_axial_shift_on_one_flank_are_indistinguishable() {
    for (hand, k) in [(Hand::Right, 0), (Hand::Left, 1)] {
        let gear = helical(28.0, hand);
        let reference = Reference::new(&gear);
        let pose = Pose { values: [0.0, 0.0, 10.0, 0.0, 0.0, 100.0], pivot: 0.0 };
        let touches = moved(&places(&gear, 1, &[side(k)], |_, _, _| 0.0, 0.0), &pose);
        let deviations = measured(&reference, &touches, 0.0);
        let both = [Motion::AxialShift, Motion::Rotation];
        let answer = registered(&reference, &deviations, &both, &FitSpec::new(Model::Linear));
        assert_eq!(answer.indistinguishable.len(), 1);
        let group = &answer.indistinguishable[0];
        assert_eq!(group.motions.len(), 2);
        let named = ["axial_shift", "rotation", "are nearly"].iter().all(|word| group.sentence.contains(word));
        assert!(named, "{}", group.sentence);
        let spectrum = &answer.every_motion.as_ref().expect("the fit of both").spectrum;
        assert_eq!((spectrum.rank, spectrum.eigenvalues[0]), (1, 0.0));
        assert!(answer.rms_after_um < 1e-8);
        // one of them alone takes all of it
        let alone = registered(&reference, &deviations, &[Motion::Rotation], &plain());
        assert!(alone.rms_after_um < 1e-8 && alone.every_motion.is_none() && alone.indistinguishable.is_empty());
        let lead = gear.turn_per_length();
        assert!((alone.pose.get(Motion::Rotation) - (100.0 - 1e3 * lead * 10.0)).abs() < 1e-6);
    }
}

#[test]
fn a_spur_gear_does_not_determine_the_axial_shift() {
    let gear = helical(0.0, Hand::Right);
    let reference = Reference::new(&gear);
    let pose = Pose { values: [0.0, 0.0, 0.0, 0.0, 0.0, 200.0], pivot: 0.0 };
    let touches = moved(&places(&gear, 2, &[Side::Left, Side::Right], |_, _, _| 0.0, 0.0), &pose);
    let deviations = measured(&reference, &touches, 0.0);
    let answer = registered(&reference, &deviations, &Motion::ALL, &FitSpec::new(Model::Linear));
    let [axial, rotation] = [2, 5].map(|i| &answer.motions[i]);
    assert_eq!((axial.motion, axial.value, axial.determined, axial.std_error), (Motion::AxialShift, 0.0, false, None));
    assert!(rotation.determined && (rotation.value - 200.0).abs() < 1e-7);
    assert!(answer.indistinguishable.iter().any(|near| near.motions == [Motion::AxialShift]));
    let spec = plain();
    let asked = Registering { motions: &[Motion::AxialShift], pivot: None, weight: None, spec: &spec };
    let Err(FitError::Invalid(faults)) = register(&reference, &deviations, &asked) else { panic!("faults") };
    assert_eq!(faults.list()[0].path, "registration.motions[0]");
}

#[test]
fn a_single_flank_has_a_regularised_answer() {
    // one flank determines three of the six well; noise of 0.3 µm must not become motions of
    // millimetres
    let gear = helical(20.0, Hand::Left);
    let reference = Reference::new(&gear);
    let mut random = Random::new(11);
    let noisy: Vec<MeasuredPoint> = places(&gear, 1, &[Side::Left], |_, _, _| 0.0, 0.0)
        .iter()
        .map(|touch| MeasuredPoint { point: touch.point + 3e-4 * Vector::from_fn(|_, _| random.normal()), ..*touch })
        .collect();
    let deviations = measured(&reference, &noisy, 0.0);
    let answer = registered(&reference, &deviations, &Motion::ALL, &FitSpec::new(Model::Linear));
    let free = registered(&reference, &deviations, &Motion::ALL, &plain());
    assert!(
        answer.converged && answer.rms_after_um <= answer.rms_before_um && free.rms_after_um <= answer.rms_after_um
    );
    let most = |answer: &Registration| answer.motions.iter().map(|m| m.value.abs()).fold(0.0, f64::max);
    assert!(most(&answer) < most(&free), "{} and {}", most(&answer), most(&free));
    // the screw, and what is nearly the same over one flank
    assert!(answer.indistinguishable.len() >= 2);
    assert!(answer.motions.iter().filter(|m| m.determined).all(|m| m.bias_bound.is_some_and(|b| b > 0.0)));
    let again = registered(&reference, &deviations, &Motion::ALL, &FitSpec::new(Model::Linear));
    assert_eq!(again.pose, answer.pose);
}

#[test]
fn standard_errors_are_those_of_the_noise() {
    let gear = helical(15.0, Hand::Right);
    let reference = Reference::new(&gear);
    let clean = places(&gear, 3, &[Side::Left, Side::Right], |_, _, _| 0.0, 0.0);
    let mut random = Random::new(12);
    let (mut square, runs) = ([0.0; 5], 60);
    for _ in 0..runs {
        let noisy: Vec<MeasuredPoint> = clean
            .iter()
            .map(|touch| MeasuredPoint {
                point: touch.point + 5e-4 * Vector::from_fn(|_, _| random.normal()),
                ..*touch
            })
            .collect();
        let answer = registered(&reference, &measured(&reference, &noisy, 0.0), &FIVE, &plain());
        for (square, moved) in square.iter_mut().zip(&answer.motions) {
            *square += (moved.value / moved.std_error.expect("degrees of freedom")).powi(2) / f64::from(runs);
        }
    }
    // a mean of 60 squares has standard deviation 0.18
    assert!(square.iter().all(|s| (0.4..1.7).contains(s)), "{square:?}");
}

#[test]
fn modified_flanks_are_registered_without_residual() {
    let gear = helical(23.0, Hand::Right);
    let [low, high] = rolls(&gear);
    let relief = |_: Side, l: f64, z: f64| 20.0 * ((l - low) / (high - low)).powi(2) + 0.03 * (z - 22.0).powi(2);
    let reference = Reference { relief: Some(&relief), ..Reference::new(&gear) };
    let mut random = Random::new(13);
    let pose = random_pose(&mut random, &FIVE, 1.0);
    let touches = moved(&places(&gear, 4, &[Side::Left, Side::Right], |s, l, z| -relief(s, l, z), 0.0), &pose);
    let deviations = measured(&reference, &touches, 0.0);
    let answer = registered(&reference, &deviations, &FIVE, &plain());
    assert!(answer.rms_after_um < 1e-8, "{}", answer.rms_after_um);
    for motion in FIVE {
        assert!((answer.pose.get(motion) - pose.get(motion)).abs() < 1e-7);
    }
}

#[test]
fn gross_errors_do_not_pull_a_robust_registration() {
    let gear = helical(23.0, Hand::Left);
    let reference = Reference::new(&gear);
    let mut random = Random::new(14);
    let pose = random_pose(&mut random, &FIVE, 0.5);
    let mut touches = moved(&places(&gear, 4, &[Side::Left, Side::Right], |_, _, _| 0.0, 0.0), &pose);
    for touch in touches.iter_mut().step_by(17) {
        touch.point.x += 0.1;
    }
    touches[1].point.x = f64::NAN;
    let deviations = measured(&reference, &touches, 0.0);
    let include = Include { robust_weights: true, ..Include::default() };
    let tukey = FitSpec { estimator: Estimator::M(MEstimator::new(Loss::Tukey { c: 4.685 })), include, ..plain() };
    let robust = registered(&reference, &deviations, &FIVE, &tukey);
    let far =
        |answer: &Registration| FIVE.iter().map(|m| (answer.pose.get(*m) - pose.get(*m)).abs()).fold(0.0, f64::max);
    assert!(far(&robust) < 1e-4, "{}", far(&robust));
    assert!(far(&registered(&reference, &deviations, &FIVE, &plain())) > 1.0);
    let report = robust.fit.robust.as_ref().expect("a robust fit");
    let rejected: Vec<usize> = report.rejected.iter().flatten().map(|row| robust.rows[*row]).collect();
    assert!(rejected.contains(&17) && robust.rows.len() == touches.len() - 1 && !robust.rows.contains(&1));
    assert!(robust.deviations.nodes[1].deviation.is_nan() && robust.deviations.nodes.len() == touches.len());
}

#[test]
fn weights_borders_and_parameters_reach_the_fit() {
    let gear = helical(23.0, Hand::Left);
    let reference = Reference::new(&gear);
    let touches = places(&gear, 2, &[Side::Left, Side::Right], |side, _, _| side.sign() * 8.0, 0.0);
    let mut deviations = measured(&reference, &touches, 0.0);
    let spec = plain();
    // the left flanks alone: 8 µm of rotation; the right ones would say the opposite
    let weight: Vec<f64> = touches.iter().map(|t| if t.side == Some(Side::Left) { 1.0 } else { 0.0 }).collect();
    let motions = [Motion::Rotation];
    let asked = Registering { motions: &motions, pivot: None, weight: Some(&weight), spec: &spec };
    let answer = register(&reference, &deviations, &asked).expect("a registration");
    assert!((answer.pose.pivot - 22.0).abs() < 0.01, "the middle of the nodes");
    let expected = 8.0 / (1e-3 * gear.base_radius() * gear.base_helix_angle().cos());
    assert!((answer.pose.get(Motion::Rotation) - expected).abs() < 1e-7);
    let both = registered(&reference, &deviations, &motions, &spec);
    assert!((both.pose.get(Motion::Rotation) - expected).abs() < 1e-7, "both sides turn the same way");
    // a ridge halves a column of unit length
    let ridge = FitSpec { regularization: Regularization::Ridge { parameter: Parameter::Fixed(1.0) }, ..plain() };
    let half = registered(&reference, &deviations, &motions, &ridge);
    assert!((half.pose.get(Motion::Rotation) - 0.5 * expected).abs() < 1e-6);
    for node in &mut deviations.nodes {
        node.within = node.side == Side::Right;
    }
    assert_eq!(registered(&reference, &deviations, &motions, &spec).rows.len(), 50);
}

#[test]
fn impossible_registrations_are_refused() {
    let gear = helical(23.0, Hand::Left);
    let reference = Reference::new(&gear);
    let deviations = measured(&reference, &places(&gear, 1, &[Side::Left], |_, _, _| 0.0, 0.0)[..3], 0.0);
    let spec = plain();
    let refused = |asked: Registering| match register(&reference, &deviations, &asked) {
        Err(FitError::Invalid(faults)) => faults.list()[0].path.clone(),
        other => panic!("{other:?}"),
    };
    let asked = Registering { motions: &FIVE, pivot: None, weight: None, spec: &spec };
    assert_eq!(refused(asked.clone()), "points");
    assert_eq!(refused(Registering { motions: &[], ..asked.clone() }), "registration.motions");
    let twice = [Motion::XShift, Motion::XShift];
    assert_eq!(refused(Registering { motions: &twice, ..asked.clone() }), "registration.motions[1]");
    let one = [Motion::XShift];
    assert_eq!(
        refused(Registering { motions: &one, pivot: Some(f64::NAN), ..asked.clone() }),
        "registration.pivot_z_mm"
    );
    assert_eq!(refused(Registering { motions: &one, weight: Some(&[1.0]), ..asked.clone() }), "weight");
    let weight = [1.0, -1.0, 1.0];
    assert_eq!(refused(Registering { motions: &one, weight: Some(&weight), ..asked }), "weight[1]");
}
