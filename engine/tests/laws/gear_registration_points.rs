//! Measured points against the nominal flank: the closed form of the distance, ball compensation,
//! borders, errors.

use crate::gear_registration::{above, gear, helical, rolls, side};
use crate::oracle::random::Random;
use crate::problems::config;
use flankfit_engine::gear::deviation::{
    Border, Borders, Deviations, Direction, FootlessPoints, MeasuredPoint, Measurement, NoFoot, Reference, Topography,
    foot::foot, grid, measure,
};
use flankfit_engine::gear::flank_grid::{FlankGrid, GridSpec};
use flankfit_engine::gear::modification::{Flanks, Law, Modification, Modifications, Range};
use flankfit_engine::gear::{Gear, Hand, ProfileAxis, Side, involute::Flank};
use flankfit_engine::geometry::space::Vector;
use proptest::prelude::*;

fn anywhere(point: Vector) -> MeasuredPoint {
    MeasuredPoint::anywhere(point)
}

fn measured(gear: &Gear, touches: &[MeasuredPoint], measurement: &Measurement) -> Deviations {
    measure(&Reference::new(gear), touches, measurement).expect("points of the flank")
}

/// The closest place of the flank by search on an ever finer grid of (L, z), then by Newton on the
/// gradient of the squared distance with numerical derivatives of the points.
fn closest(gear: &Gear, side: Side, point: &Vector, mut place: [f64; 2]) -> ([f64; 2], f64) {
    let flank = Flank::new(gear, side);
    let square = |at: [f64; 2]| (flank.at(at[0], at[1]).point - point).norm_squared();
    let mut step = 0.5;
    for _ in 0..30 {
        let mut best = (square(place), place);
        for i in -4..=4 {
            for j in -4..=4 {
                let at = [place[0] + step * f64::from(i), place[1] + step * f64::from(j)];
                if at[0] >= 0.0 && square(at) < best.0 {
                    best = (square(at), at);
                }
            }
        }
        place = best.1;
        step *= 0.6;
    }
    for _ in 0..20 {
        let at = |du: f64, dv: f64| flank.at(place[0] + du, place[1] + dv).point;
        let h = 1e-4;
        let gap = at(0.0, 0.0) - point;
        let (u, v) = ((at(h, 0.0) - at(-h, 0.0)) / (2.0 * h), (at(0.0, h) - at(0.0, -h)) / (2.0 * h));
        let uu = (at(h, 0.0) - 2.0 * at(0.0, 0.0) + at(-h, 0.0)) / (h * h);
        let vv = (at(0.0, h) - 2.0 * at(0.0, 0.0) + at(0.0, -h)) / (h * h);
        let uv = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h);
        let (a, b, c) = (u.dot(&u) + gap.dot(&uu), u.dot(&v) + gap.dot(&uv), v.dot(&v) + gap.dot(&vv));
        let (p, q) = (gap.dot(&u), gap.dot(&v));
        let determinant = a * c - b * b;
        place = [place[0] - (c * p - b * q) / determinant, place[1] - (a * q - b * p) / determinant];
    }
    (place, square(place).sqrt())
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn a_point_moved_along_the_normal_deviates_by_that(seed: u64) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 1);
        let [low, high] = rolls(&gear);
        for k in 0..8 {
            let (side, tooth) = (side(k), 1 + random.below(gear.data().teeth as usize) as u32);
            let (roll, z) = (random.between(low, high), random.between(-40.0, 40.0));
            let delta = if k < 2 { 0.0 } else { random.between(-200.0, 200.0) };
            let point = above(&gear, tooth, side, roll, z, 1e-3 * delta);
            let accuracy = 1e-12 * gear.tip_radius().max(gear.root_radius()) * 1e3;
            let named = MeasuredPoint { tooth: Some(tooth), side: Some(side), ..MeasuredPoint::anywhere(point) };
            for touch in [anywhere(point), named] {
                let node = measured(&gear, &[touch], &Measurement::default()).nodes[0];
                prop_assert_eq!((node.tooth, node.side), (tooth, side));
                prop_assert!((node.deviation - delta).abs() < accuracy, "{} instead of {delta}", node.deviation);
                prop_assert!((node.roll_length - roll).abs() < 1e-9 && (node.z - z).abs() < 1e-9);
                prop_assert!((node.diameter(&gear) - gear.diameter(roll)).abs() < 1e-9);
            }
            let transverse = Measurement { direction: Direction::Transverse, ..Measurement::default() };
            let node = measured(&gear, &[named], &transverse).nodes[0];
            prop_assert!((node.deviation * gear.base_helix_angle().cos() - delta).abs() < accuracy);
            // and that size is indeed the way along the base tangent, in the plane z = const, from
            // a place of the same generating line
            let step = 1e-3 * node.deviation;
            let place = Flank::new(&gear, side).at(roll, z);
            let tangent = Vector::new(place.normal.x, place.normal.y, 0.0).normalize();
            let beside = place.point + tangent * step;
            let found = foot(&gear, side, Some(1), &beside, 0.0).expect("a foot");
            prop_assert!((1e3 * found.distance - delta).abs() < accuracy);
        }
    }

    #[test]
    fn a_ball_is_compensated_exactly(seed: u64, radius in 0.1f64..1.0) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 2);
        let [low, high] = rolls(&gear);
        for k in 0..6 {
            let (side, tooth) = (side(k), 1 + random.below(gear.data().teeth as usize) as u32);
            // a ball does not fit where concave flanks begin
            let (roll, z) = (random.between(low.max(radius), high), random.between(0.0, 30.0));
            let delta = random.between(-80.0, 80.0);
            let centre = above(&gear, tooth, side, roll, z, radius + 1e-3 * delta);
            let measurement = Measurement { ball_radius: radius, ..Measurement::default() };
            let touch = MeasuredPoint { side: Some(side), ..MeasuredPoint::anywhere(centre) };
            let deviations = measured(&gear, &[touch], &measurement);
            let node = deviations.nodes[0];
            prop_assert_eq!(node.tooth, tooth);
            prop_assert!((node.deviation - delta).abs() < 1e-9 * gear.root_radius());
            prop_assert!((node.roll_length - roll).abs() < 1e-9 && (node.z - z).abs() < 1e-9);
            let again = deviations.point(&Reference::new(&gear), 0).expect("a defined node");
            prop_assert!((again - centre).norm() < 1e-11);
        }
    }

    #[test]
    fn deviations_refer_to_the_relief_of_the_flank(seed: u64) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 3);
        let [low, high] = rolls(&gear);
        let relief = |side: Side, l: f64, z: f64| side.sign() * 3.0 + 0.04 * (l - low) * (l - low) + 0.1 * z;
        let reference = Reference { relief: Some(&relief), ..Reference::new(&gear) };
        for k in 0..6 {
            let (side, roll, z) = (side(k), random.between(low, high), random.between(-20.0, 20.0));
            let delta = random.between(-20.0, 20.0);
            let point = above(&gear, 3, side, roll, z, 1e-3 * (delta - relief(side, roll, z)));
            let touch = MeasuredPoint { side: Some(side), ..MeasuredPoint::anywhere(point) };
            let node = measure(&reference, &[touch], &Measurement::default()).expect("a point").nodes[0];
            prop_assert!((node.deviation - delta).abs() < 1e-8, "{} instead of {delta}", node.deviation);
        }
    }
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn the_closed_form_is_the_closest_point(seed: u64, delta in -0.4f64..0.4) {
        let gear = gear(seed);
        let mut random = Random::new(seed ^ 4);
        let [low, high] = rolls(&gear);
        for k in 0..2 {
            let (side, roll, z) = (side(k), random.between(low.max(0.5), high), random.between(-10.0, 10.0));
            let point = above(&gear, 1, side, roll, z, delta);
            let found = foot(&gear, side, Some(1), &point, 0.0).expect("a foot");
            let (place, distance) = closest(&gear, side, &point, [roll + 0.3, z - 0.4]);
            prop_assert!((found.distance.abs() - distance).abs() < 1e-9, "{} and {distance}", found.distance);
            prop_assert!((found.roll_length - place[0]).abs() < 1e-6 && (found.z - place[1]).abs() < 1e-6);
        }
    }

    #[test]
    fn mirrored_gears_have_mirrored_deviations(seed: u64, delta in -0.2f64..0.2) {
        let gear = gear(seed);
        let other = match gear.data().hand {
            Hand::Right => Hand::Left,
            Hand::Left => Hand::Right,
        };
        let mirrored = Gear::new(flankfit_engine::gear::GearData { hand: other, ..gear.data().clone() }).expect("the \
            same gear");
        let mut random = Random::new(seed ^ 5);
        let [low, high] = rolls(&gear);
        let point = above(&gear, 1, Side::Left, random.between(low.max(0.5), high), random.between(-9.0, 9.0), delta);
        let one = foot(&gear, Side::Left, None, &point, 0.0).expect("a foot");
        // in x: the other flank of the other hand
        let two = foot(&mirrored, Side::Right, None, &Vector::new(-point.x, point.y, point.z), 0.0).expect("a foot");
        prop_assert!((one.distance - two.distance).abs() < 1e-12 && (one.z - two.z).abs() < 1e-12);
        // turned upside down: the other flank of the same hand
        let three = foot(&gear, Side::Right, None, &Vector::new(-point.x, point.y, -point.z), 0.0).expect("a foot");
        prop_assert!((one.distance - three.distance).abs() < 1e-12 && (one.z + three.z).abs() < 1e-12);
        prop_assert!((one.roll_length - three.roll_length).abs() < 1e-12);
    }
}

#[test]
fn nodes_of_the_modified_nominal_deviate_by_nothing() {
    for (k, hand) in [(0, Hand::Right), (1, Hand::Left)] {
        let gear = helical(24.0, hand);
        let range = Range::new(&gear, [98.0, 108.0], [0.0, 30.0]).expect("a range");
        let laws = [Law::ProfileCrowning { amount: 8.0 }, Law::HelixSlope { amount: -6.0 }, Law::Twist { amount: 5.0 }];
        let list = laws.map(|law| Modification { flanks: Flanks::Both, law }).to_vec();
        let modifications = Modifications::new(&gear, range, list).expect("modifications");
        let (side, tooth) = (side(k), 9);
        let spec = GridSpec {
            side,
            axis: ProfileAxis::Diameter,
            values: vec![98.5, 101.0, 104.0, 107.5],
            positions: vec![1.0, 12.0, 29.0],
            tooth,
        };
        let nominal = FlankGrid::new(&gear, &spec, Some(&modifications)).expect("a grid");
        let touches: Vec<MeasuredPoint> = nominal.points.iter().map(|p| anywhere(Vector::from(*p))).collect();
        let relief = |side, l, z| modifications.relief(side, l, z).value;
        let reference = Reference { relief: Some(&relief), ..Reference::new(&gear) };
        let found = measure(&reference, &touches, &Measurement::default()).expect("points of the flank");
        assert!(found.nodes.iter().all(|n| (n.tooth, n.side) == (tooth, side) && n.deviation.abs() < 1e-9));
        let unmodified = measured(&gear, &touches, &Measurement::default());
        assert!(unmodified.rms().expect("nodes") > 1.0);
    }
}

#[test]
fn undefined_points_keep_their_place() {
    let gear = helical(20.0, Hand::Right);
    let good = above(&gear, 5, Side::Right, 14.0, 3.0, 2e-3);
    let touches = [
        anywhere(good),
        anywhere(Vector::new(f64::NAN, 1.0, 2.0)),
        anywhere(good),
        MeasuredPoint { tooth: Some(4), ..anywhere(Vector::new(1.0, 1.0, f64::NAN)) },
    ];
    let deviations = measured(&gear, &touches, &Measurement::default());
    assert_eq!(deviations.nodes.len(), 4);
    assert_eq!((deviations.undefined(), deviations.counted()), (2, 2));
    assert!(deviations.nodes[1].deviation.is_nan() && deviations.nodes[1].z.is_nan());
    assert_eq!(deviations.nodes[3].tooth, 4);
    assert_eq!(deviations.point(&Reference::new(&gear), 1), None);
    assert!((deviations.rms().expect("two nodes") - 2.0).abs() < 1e-8);
}

#[test]
fn points_that_are_not_of_the_flank_are_named() {
    let gear = helical(20.0, Hand::Left);
    let good = anywhere(above(&gear, 5, Side::Left, 14.0, 3.0, 0.0));
    let inside = anywhere(Vector::new(0.0, 0.9 * gear.base_radius(), 1.0));
    let wrong_tooth = MeasuredPoint { tooth: Some(6), ..good };
    let wrong_flank = MeasuredPoint { side: Some(Side::Right), ..good };
    let no_tooth = MeasuredPoint { tooth: Some(32), ..good };
    let endless = anywhere(Vector::new(f64::INFINITY, 1.0, 1.0));
    let before = anywhere(above(&gear, 5, Side::Left, 0.0, 3.0, 0.0) * 1.000_001);
    let touches = [good, inside, wrong_tooth, good, wrong_flank, no_tooth, endless, before];
    let faults = measure(&Reference::new(&gear), &touches, &Measurement::default()).expect_err("faults");
    let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(paths, ["points[1]", "points[2]", "points[4]", "teeth[5]", "points[6]"]);
    assert!(faults.list()[0].message.contains("inside the base circle"), "{}", faults.list()[0].message);
    assert!(faults.list()[1].message.contains("tooth 6"), "{}", faults.list()[1].message);

    // or they are left out, and listed
    let lenient = Measurement { strays: FootlessPoints::Undefined, ..Measurement::default() };
    let left = measured(&gear, &[good, inside, wrong_tooth], &lenient);
    assert_eq!((left.counted(), left.undefined()), (1, 2));
    assert!(matches!(left.strays[..], [(1, NoFoot::InsideBase { .. }), (2, NoFoot::Far { tooth: 6, .. })]));
}

#[test]
fn a_normal_determines_the_flank() {
    // in the middle of a tooth space both flanks are as near
    let gear = helical(20.0, Hand::Left);
    let space = std::f64::consts::PI / gear.teeth();
    let (sin, cos) = (space - 10.0 * gear.turn_per_length()).sin_cos();
    let middle = anywhere(gear.reference_radius() * Vector::new(sin, cos, 0.0) + Vector::new(0.0, 0.0, 10.0));
    let reach = Measurement { reach: Some(4.0), ..Measurement::default() };
    for (x, tooth, side) in [(1.0, 1, Side::Right), (-1.0, 2, Side::Left)] {
        let normal = Some(Vector::new(x, 0.0, 0.0));
        let node = measured(&gear, &[MeasuredPoint { normal, ..middle }], &reach).nodes[0];
        assert_eq!((node.tooth, node.side), (tooth, side));
        assert!(node.deviation > 1000.0);
        let wrong = MeasuredPoint { normal: normal.map(|n| -n), side: Some(side), tooth: Some(tooth), ..middle };
        let faults = measure(&Reference::new(&gear), &[wrong], &reach).expect_err("the other flank's normal");
        assert!(faults.list()[0].message.contains("into the material"), "{}", faults.list()[0].message);
    }
}

#[test]
fn tip_and_root_circles_that_are_given_hold() {
    let plain = helical(20.0, Hand::Left);
    let tip = 2.0 * plain.tip_radius();
    let gear =
        Gear::new(flankfit_engine::gear::GearData { tip_diameter: Some(tip), ..plain.data().clone() }).expect("a gear");
    let roll = gear.roll_length(tip + 6.0).expect("above the base circle");
    let point = anywhere(above(&gear, 1, Side::Left, roll, 0.0, 0.0));
    assert!(measure(&Reference::new(&plain), &[point], &Measurement::default()).is_ok());
    let faults = measure(&Reference::new(&gear), &[point], &Measurement::default()).expect_err("outside the tip");
    assert!(faults.list()[0].message.contains("tip circle"), "{}", faults.list()[0].message);
}

#[test]
fn settings_are_checked() {
    let gear = helical(20.0, Hand::Left);
    let bad = Measurement { ball_radius: -1.0, reach: Some(100.0), ..Measurement::default() };
    let faults = measure(&Reference::new(&gear), &[], &bad).expect_err("faults");
    let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(paths, ["probe_radius_mm", "reach_mm"]);
}

fn topography() -> Topography {
    Topography {
        tooth: 2,
        side: Side::Right,
        roll_length: (0..=10).map(|i| 10.0 + f64::from(i)).collect(),
        z: (0..=20).map(f64::from).collect(),
        deviation: (0..=10)
            .map(|i| (0..=20).map(|j| f64::from(i) - 0.3 * f64::from(j)).collect::<Vec<f64>>())
            .collect(),
        direction: Direction::Transverse,
    }
}

fn change_rows(topography: &mut Topography, change: impl FnOnce(&mut Vec<Vec<f64>>)) {
    let mut rows: Vec<Vec<f64>> = topography.deviation.iter().map(<[f64]>::to_vec).collect();
    change(&mut rows);
    topography.deviation = rows.iter().collect();
}

#[test]
fn a_grid_is_the_same_as_its_points() {
    let gear = helical(25.0, Hand::Right);
    let relief = |_: Side, l: f64, z: f64| 0.2 * l - 0.05 * z;
    let reference = Reference { relief: Some(&relief), ..Reference::new(&gear) };
    let mut topography = topography();
    change_rows(&mut topography, |rows| rows[3][4] = f64::NAN);
    let nodes = grid(&reference, &topography).expect("a grid");
    assert_eq!((nodes.nodes.len(), nodes.undefined()), (231, 1));
    let touches: Vec<MeasuredPoint> = (0..231)
        .map(|i| {
            let point = nodes.point(&reference, i).unwrap_or(Vector::repeat(f64::NAN));
            MeasuredPoint { tooth: Some(2), side: Some(Side::Right), ..MeasuredPoint::anywhere(point) }
        })
        .collect();
    let transverse = Measurement { direction: Direction::Transverse, ..Measurement::default() };
    let again = measure(&reference, &touches, &transverse).expect("points");
    for (a, b) in nodes.nodes.iter().zip(&again.nodes) {
        assert_eq!(a.deviation.is_nan(), b.deviation.is_nan());
        assert!(a.deviation.is_nan() || (a.deviation - b.deviation).abs() < 1e-9 && (a.z - b.z).abs() < 1e-10);
    }
}

#[test]
fn bad_grids_are_refused() {
    let gear = helical(25.0, Hand::Right);
    let mut bad = topography();
    bad.tooth = 0;
    bad.roll_length[1] = 9.0;
    bad.z[3] = f64::NAN;
    change_rows(&mut bad, |rows| {
        rows[2].pop();
        rows[4][5] = f64::INFINITY;
    });
    let faults = grid(&Reference::new(&gear), &bad).expect_err("faults");
    let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(paths, ["tooth", "roll_length_mm[1]", "z_mm[3]", "deviation_um[2]", "deviation_um[4][5]"]);
}

#[test]
fn borders_leave_the_edges_out() {
    let gear = helical(25.0, Hand::Right);
    let mut nodes = grid(&Reference::new(&gear), &topography()).expect("a grid");
    // 11 roll lengths over 10 mm, 21 positions over 20 mm
    nodes.set_borders(&Borders::trimmed(&gear, 10.0, 20.0, 5.0, 10.0)).expect("borders");
    assert_eq!((nodes.counted(), nodes.trimmed()), (8 * 18, 231 - 8 * 18));
    assert!(nodes.nodes.iter().filter(|n| n.counts()).all(|n| (11.0..=18.0).contains(&n.roll_length)));
    assert!(nodes.nodes.iter().filter(|n| n.counts()).all(|n| (1.0..=18.0).contains(&n.z)));
    let face = Border::Range { from: 3.0, to: 4.0 };
    nodes.set_borders(&Borders { profile: Border::Whole, face }).expect("borders");
    assert_eq!(nodes.counted(), 22);
    let none = Borders { face: Border::Range { from: 3.1, to: 3.9 }, ..Borders::default() };
    assert!(nodes.set_borders(&none).is_err());
    assert_eq!(nodes.counted(), 22);
    let mad =
        Borders { profile: Border::Trimmed { low: 60.0, high: 40.0 }, face: Border::Range { from: f64::NAN, to: 1.0 } };
    let faults = nodes.set_borders(&mad).expect_err("faults");
    let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(paths, ["diameter_range_mm", "z_range_mm"]);
}

#[test]
fn a_whole_gear_falls_into_its_flanks() {
    let gear = helical(25.0, Hand::Left);
    let mut touches = Vec::new();
    for k in 0..120 {
        let (tooth, z) = (1 + (7 * k as u32) % 31, 0.2 * k as f64);
        touches.push(anywhere(above(&gear, tooth, side(k / 31), 12.0 + 0.02 * k as f64, z, 1e-3 * f64::from(tooth))));
    }
    touches[40].point.y = f64::NAN;
    let deviations = measured(&gear, &touches, &Measurement::default());
    let flanks = deviations.flanks();
    assert_eq!(flanks.len(), 62);
    assert_eq!(flanks.iter().map(|flank| flank.index.len()).sum::<usize>(), 119);
    for (i, flank) in flanks.iter().enumerate() {
        assert_eq!((flank.tooth, flank.side), (1 + i as u32 / 2, side(i)));
        assert!(flank.deviation.iter().all(|d| (d - f64::from(flank.tooth)).abs() < 1e-8));
        assert!(flank.index.iter().zip(&flank.z).all(|(k, z)| (z - 0.2 * *k as f64).abs() < 0.02));
        assert_eq!(flank.roll_length.len(), flank.index.len());
    }
}
