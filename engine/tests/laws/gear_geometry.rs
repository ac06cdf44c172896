//! Laws of the nominal flank: the involute, its normals, thicknesses, measures over teeth and
//! balls, and gears that cannot be.

use std::f64::consts::{FRAC_PI_2, PI};

use flankfit_engine::{
    gear::{
        Gear, GearData, Geometry, Hand, Side, Tool,
        geometry::{Balls, Span, Warning, pointed_diameter, tooth_thickness},
        involute::{Flank, inv_of_roll, roll_of_inv},
    },
    geometry::space::Vector,
};
use proptest::prelude::*;

pub fn data(teeth: u32, normal_module: f64, alpha_deg: f64, beta_deg: f64) -> GearData {
    GearData {
        teeth,
        normal_module,
        pressure_angle: alpha_deg.to_radians(),
        helix_angle: beta_deg.to_radians(),
        hand: Hand::Right,
        profile_shift: 0.0,
        face_width: Some(20.0),
        tip_diameter: None,
        root_diameter: None,
        internal: false,
        tool: None,
    }
}

/// Gears of all kinds that can exist.
pub fn any_gear() -> impl Strategy<Value = Gear> {
    let numbers = (12u32..200, 0.5..10.0f64, 14.5..28.0f64, 0.0..40.0f64, -0.4..0.7f64);
    (numbers, any::<bool>(), any::<bool>(), any::<bool>())
        .prop_map(|((teeth, module, alpha, beta, shift), left, internal, spur)| {
            let mut data =
                data(if internal { teeth + 30 } else { teeth }, module, alpha, if spur { 0.0 } else { beta });
            data.hand = if left { Hand::Left } else { Hand::Right };
            data.profile_shift = shift;
            data.internal = internal;
            data
        })
        .prop_filter_map("the gear can exist", |data| Gear::new(data).ok())
}

pub fn side_of(left: bool) -> Side {
    if left { Side::Left } else { Side::Right }
}

/// Distance by which the generating line of a point misses the base circle, from the point and the
/// transverse direction of its normal.
pub fn miss(gear: &Gear, point: &[f64; 3], normal: &[f64; 3]) -> f64 {
    let across = normal[0].hypot(normal[1]);
    ((point[0] * normal[1] - point[1] * normal[0]) / across).abs() - gear.base_radius()
}

fn array(v: Vector) -> [f64; 3] {
    [v.x, v.y, v.z]
}

#[test]
fn base_values_of_two_gears() {
    for (teeth, module, alpha, beta, base, helix) in
        [(83, 2.03, 18.0, 28.0, 179.0857, 26.519), (26, 1.44, 17.0, 25.0, 39.1433, 23.838)]
    {
        let geometry = Geometry::of(&Gear::new(data(teeth, module, alpha, beta)).unwrap());
        assert!((geometry.base_diameter_mm - base).abs() < 5e-5, "{}", geometry.base_diameter_mm);
        assert!((geometry.base_helix_angle_deg - helix).abs() < 5e-4);
    }
}

#[test]
fn spans_of_the_usual_table() {
    // W_k for m = 1, α = 20°, x = 0, as every handbook prints it.
    for (teeth, k, length) in [(10, 2, 4.5683), (17, 2, 4.6663), (20, 3, 7.6604), (30, 4, 10.7526), (40, 5, 13.8448)] {
        let gear = Gear::new(data(teeth, 1.0, 20.0, 0.0)).unwrap();
        let span = Span::over(&gear, k, None).unwrap();
        assert!((span.length_mm - length).abs() < 6e-5, "{teeth} {}", span.length_mm);
        if teeth >= 17 {
            assert_eq!(Geometry::of(&gear).span.unwrap().teeth, k);
        }
    }
}

#[test]
fn a_textbook_pinion_is_undercut_below_17_teeth() {
    let tool = Tool { tip_radius: 0.0, addendum_factor: 1.0, protuberance: 0.0 };
    for (teeth, undercut) in [(12, true), (17, true), (18, false), (30, false)] {
        let gear = Gear::new(GearData { tool: Some(tool), ..data(teeth, 2.0, 20.0, 0.0) }).unwrap();
        let geometry = Geometry::of(&gear);
        assert_eq!(geometry.undercut, undercut, "{teeth}");
        // x_min = h* − z sin² α / 2 = 1 − z / 17.097.
        let least = 1.0 - f64::from(teeth) / (2.0 / 20f64.to_radians().sin().powi(2));
        assert!((geometry.least_profile_shift_coefficient.unwrap() - least).abs() < 1e-12);
        assert_eq!(geometry.warnings.iter().any(|w| matches!(w, Warning::Undercut { .. })), undercut);
    }
}

#[test]
fn a_pointed_tooth_is_warned_of() {
    let gear = Gear::new(GearData { profile_shift: 1.2, ..data(12, 2.0, 20.0, 0.0) }).unwrap();
    let geometry = Geometry::of(&gear);
    let at = geometry.warnings.iter().find_map(|w| match w {
        Warning::PointedTip { pointed_diameter_mm, .. } => Some(*pointed_diameter_mm),
        _ => None,
    });
    let at = at.unwrap();
    assert!(at < geometry.tip_diameter_mm && geometry.tip_thickness_mm == 0.0);
    assert!((geometry.tip_form_diameter_mm - at).abs() < 1e-9);
    assert!(tooth_thickness(&gear, gear.roll_length(at).unwrap()).transverse < 1e-12);
}

#[test]
fn impossible_gears_are_named_by_their_fields() {
    type Change = fn(&mut GearData);
    let cases: [(&str, Change); 15] = [
        ("helix_angle_deg", |d| d.helix_angle = FRAC_PI_2),
        ("helix_angle_deg", |d| d.helix_angle = -0.1),
        ("normal_pressure_angle_deg", |d| d.pressure_angle = 0.0),
        ("normal_pressure_angle_deg", |d| d.pressure_angle = f64::NAN),
        ("teeth", |d| d.teeth = 0),
        ("normal_module_mm", |d| d.normal_module = -1.0),
        ("tip_diameter_mm", |d| d.tip_diameter = Some(55.0)),
        ("tip_diameter_mm", |d| (d.tip_diameter, d.root_diameter) = (Some(60.0), Some(61.0))),
        ("root_diameter_mm", |d| d.root_diameter = Some(70.0)),
        ("profile_shift_coefficient", |d| d.profile_shift = -30.0),
        ("profile_shift_coefficient", |d| d.profile_shift = 8.0),
        ("tool.tip_radius_mm", |d| d.tool = Some(Tool { tip_radius: 2.0, addendum_factor: 1.25, protuberance: 0.0 })),
        ("tool.addendum_factor", |d| d.tool = Some(Tool { tip_radius: 0.0, addendum_factor: 4.0, protuberance: 0.0 })),
        ("tool.protuberance_mm", |d| d.tool = Some(Tool { tip_radius: 0.1, addendum_factor: 1.25, protuberance: 0.2 })),
        ("tip_diameter_mm", |d| (d.internal, d.tip_diameter, d.root_diameter) = (true, Some(66.0), Some(64.0))),
    ];
    for (path, change) in cases {
        let mut gear = data(30, 2.0, 20.0, 0.0);
        change(&mut gear);
        let faults = Gear::new(gear).unwrap_err();
        assert!(faults.list().iter().any(|fault| fault.path == path), "{path}: {faults:?}");
        assert!(faults.list().iter().all(|fault| !fault.message.is_empty()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn points_lie_on_the_involute(gear in any_gear(), left: bool, share in 0.0..1.0f64, z in -50.0..50.0f64) {
        let flank = Flank::new(&gear, side_of(left));
        let roll = share * 2.0 * gear.base_radius();
        let place = flank.at(roll, z);
        let bound = 1e-14 * gear.base_radius().hypot(roll) + 1e-14;
        prop_assert!(miss(&gear, &array(place.point), &array(place.normal)).abs() < bound);
        prop_assert!((place.normal.norm() - 1.0).abs() < 1e-15);
        // The point itself is as far from the tangent point as the arc that was unrolled.
        let radius = place.point.x.hypot(place.point.y);
        prop_assert!((radius - 0.5 * gear.diameter(roll)).abs() < bound);
        let polar = (-place.point.x).atan2(place.point.y) - gear.turn_per_length() * z;
        let wanted = side_of(left).sign() * flank.half_angle(roll);
        prop_assert!(((polar - wanted + PI).rem_euclid(2.0 * PI) - PI).abs() < 1e-13 * (1.0 + z.abs()));
    }

    #[test]
    fn normals_are_orthogonal_to_the_surface_and_point_out(gear in any_gear(), left: bool, share in 0.05..0.6f64,
        z in -20.0..20.0f64) {
        let flank = Flank::new(&gear, side_of(left));
        let r = gear.base_radius();
        let (roll, h) = (share * r, 1e-5 * r);
        let at = |roll, z| flank.at(roll, z).point;
        let along = (at(roll + h, z) - at(roll - h, z)) / (2.0 * h);
        let across = (at(roll, z + h) - at(roll, z - h)) / (2.0 * h);
        let place = flank.at(roll, z);
        prop_assert!(place.normal.dot(&along).abs() < 1e-8 * along.norm());
        prop_assert!(place.normal.dot(&across).abs() < 1e-8 * across.norm());
        // Away from the middle of its own tooth.
        let turn = gear.turn_per_length() * z;
        let out = place.point + 1e-3 * place.normal * gear.data().normal_module;
        let angle = |p: Vector, z: f64| side_of(left).sign() * ((-p.x).atan2(p.y)
            - turn - gear.turn_per_length() * (p.z - z) + PI).rem_euclid(2.0 * PI);
        let wide = |p: Vector| (angle(p, z) - side_of(left).sign() * PI) * p.x.hypot(p.y);
        let thickness = |p: Vector| {
            let roll = gear.roll_length(2.0 * p.x.hypot(p.y)).unwrap_or(0.0);
            flank.half_angle(roll) * p.x.hypot(p.y)
        };
        prop_assert!(wide(out) > thickness(out));
    }

    #[test]
    fn a_tooth_is_as_thick_as_the_data_say(gear in any_gear()) {
        let data = gear.data();
        let thickness = gear.transverse_module() * (FRAC_PI_2 + 2.0 * data.profile_shift * data.pressure_angle.tan());
        let geometry = Geometry::of(&gear);
        prop_assert!((geometry.tooth_thickness_mm - thickness).abs() < 1e-12 * thickness);
        let normal = thickness * data.helix_angle.cos();
        prop_assert!((geometry.normal_tooth_thickness_mm - normal).abs() < 1e-12 * thickness);
        let roll = gear.roll_length(2.0 * gear.reference_radius()).unwrap();
        prop_assert!((tooth_thickness(&gear, roll).transverse - thickness).abs() < 1e-11 * gear.reference_radius());
        // From the points of both flanks, by their polar angles.
        let [left, right] = [Side::Left, Side::Right].map(|side| Flank::new(&gear, side).at(roll, 0.0).point);
        let angle = (-left.x).atan2(left.y) - (-right.x).atan2(right.y);
        prop_assert!((angle * gear.reference_radius() - thickness).abs() < 1e-11 * gear.reference_radius());
        let pitch = geometry.tooth_thickness_mm + geometry.space_width_mm;
        prop_assert!((pitch - geometry.transverse_pitch_mm).abs() < 1e-12 * pitch);
    }

    #[test]
    fn flanks_are_mirrored_and_turn_with_the_hand(gear in any_gear(), share in 0.0..0.8f64, z in -30.0..30.0f64) {
        let roll = share * gear.base_radius();
        let hand = if gear.data().hand == Hand::Right { Hand::Left } else { Hand::Right };
        let other = Gear::new(GearData { hand, ..gear.data().clone() }).unwrap();
        let left = Flank::new(&gear, Side::Left).at(roll, z);
        let mirrored = Flank::new(&other, Side::Right).at(roll, z);
        let bound = 1e-13 * gear.diameter(roll);
        prop_assert!((left.point.x + mirrored.point.x).abs() < bound
            && (left.point.y - mirrored.point.y).abs() < bound);
        prop_assert!((left.normal.x + mirrored.normal.x).abs() < 1e-13
            && (left.normal.z - mirrored.normal.z).abs() < 1e-13);
        // A right-hand helix turns counterclockwise towards the viewer.
        let turned = Flank::new(&gear, Side::Left).at(roll, z + 1e-3);
        let cross = left.point.x * turned.point.y - left.point.y * turned.point.x;
        if gear.data().helix_angle > 1e-3 {
            prop_assert!(cross * gear.hand() > 0.0);
        }
    }

    #[test]
    fn planes_of_a_span_touch_both_flanks(gear in any_gear()) {
        let geometry = Geometry::of(&gear);
        if gear.data().internal {
            return Ok(());
        }
        let span = geometry.span.unwrap();
        let half = 0.5 * span.length_mm;
        let (sin, cos) = gear.base_helix_angle().sin_cos();
        // Left flank of the leftmost tooth, right flank of the rightmost one.
        let shift = PI * f64::from(span.teeth - 1) / gear.teeth();
        let z = -gear.hand() * half * sin;
        let turned = |p: Vector, turn: f64| {
            let (s, c) = turn.sin_cos();
            Vector::new(p.x * c - p.y * s, p.x * s + p.y * c, p.z)
        };
        let left = Flank::new(&gear, Side::Left).at(half * cos, z);
        let right = Flank::new(&gear, Side::Right).at(half * cos, -z);
        let (a, b) = (turned(left.point, shift), turned(right.point, -shift));
        prop_assert!(((a - b).norm() - span.length_mm).abs() < 1e-10 * gear.reference_radius());
        let normal = turned(left.normal, shift);
        prop_assert!((normal.dot(&((a - b) / span.length_mm)) - 1.0).abs() < 1e-10);
        prop_assert!((normal + turned(right.normal, -shift)).norm() < 1e-9);
        prop_assert!((2.0 * a.x.hypot(a.y) - span.contact_diameter_mm).abs() < 1e-9 * span.contact_diameter_mm);
    }

    #[test]
    fn a_ball_touches_both_flanks_of_its_space(gear in any_gear(), z in -20.0..20.0f64) {
        let Some(balls) = Geometry::of(&gear).balls else { return Ok(()) };
        let roll = gear.roll_length(balls.contact_diameter_mm).unwrap();
        let place = Flank::new(&gear, Side::Left).at(roll, z);
        let centre = place.point + 0.5 * balls.ball_diameter_mm * place.normal;
        let scale = gear.reference_radius();
        prop_assert!((2.0 * centre.x.hypot(centre.y) - balls.centre_diameter_mm).abs() < 1e-9 * scale);
        // The middle of the space left of the tooth, which turns with z.
        let turn = (-centre.x).atan2(centre.y) - gear.turn_per_length() * centre.z - PI / gear.teeth();
        prop_assert!(((turn + PI).rem_euclid(2.0 * PI) - PI).abs() < 1e-9);
        let again = Balls::with(&gear, balls.ball_diameter_mm, None).unwrap();
        prop_assert!((again.dimension_mm - balls.dimension_mm).abs() < 1e-12 * scale);
    }

    #[test]
    fn involute_and_its_inverse(roll in 1e-9..50.0f64) {
        let back = roll_of_inv(inv_of_roll(roll));
        prop_assert!((back - roll).abs() < 1e-14 * roll);
    }

    #[test]
    fn flanks_meet_on_the_pointed_diameter(gear in any_gear()) {
        if let Some(at) = pointed_diameter(&gear) {
            let half = Flank::new(&gear, Side::Left).half_angle(gear.roll_length(at).unwrap());
            prop_assert!(half.abs() < 1e-12);
        } else {
            prop_assert!(gear.data().internal);
        }
    }
}

/// With ever more teeth both kinds become the same rack, the internal one turned over.
#[test]
fn internal_and_external_agree_in_the_rack_limit() {
    let gear =
        |teeth, internal| Gear::new(GearData { internal, profile_shift: 0.3, ..data(teeth, 2.0, 20.0, 15.0) }).unwrap();
    for height in [-1.0, 0.5, 1.5] {
        let mut last = f64::INFINITY;
        for teeth in [100, 1000, 10_000] {
            let thickness = |internal| {
                let gear = gear(teeth, internal);
                let radius = gear.reference_radius() + gear.outward() * height;
                tooth_thickness(&gear, gear.roll_length(2.0 * radius).unwrap()).normal
            };
            let [external, internal] = [false, true].map(thickness);
            let rack = 2.0 * (FRAC_PI_2 + 2.0 * (0.3 - 0.5 * height) * 20f64.to_radians().tan());
            let apart = (external - internal).abs().max((external - rack).abs());
            assert!(
                apart < 0.2 * last && apart < 30.0 / f64::from(teeth),
                "{height} {teeth} {external} {internal} {rack}"
            );
            last = apart;
        }
    }
}
