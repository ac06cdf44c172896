//! Laws of the generated root: fillet, undercut, envelope, closed profile. The oracle is the tool
//! itself, moved over the gear in small steps.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use flankfit_engine::gear::{
    Gear, GearData, Geometry, Side, Tool,
    generation::{
        Polar, Root,
        envelope::{Envelope, Motion, TooManyBetween, ToolPoint, ToolProfile},
        rack::RackFillet,
        tooth::{Steps, Tooth},
    },
    geometry::Warning,
    involute::Flank,
};
use flankfit_engine::geometry::space::Vector;
use proptest::prelude::*;

use super::gear_geometry::{any_gear, data};

/// External gears with tools of all kinds, undercut ones among them.
fn generated() -> impl Strategy<Value = Gear> {
    let numbers = (7u32..120, 0.5..8.0f64, 14.5..25.0f64, 0.0..35.0f64, -0.5..0.8f64);
    (numbers, 0.0..0.9f64, 1.0..1.45f64, prop_oneof![Just(0.0), 0.05..0.35f64]).prop_filter_map(
        "the gear can exist",
        |((teeth, module, alpha, beta, shift), round, addendum, stands)| {
            let mut data = data(teeth, module, alpha, beta);
            data.profile_shift = shift;
            let (sin, cos) = data.pressure_angle.sin_cos();
            let full = (FRAC_PI_4 * cos - addendum * sin) / (1.0 - sin) * module;
            let tip_radius = round * full;
            data.tool = Some(Tool { tip_radius, addendum_factor: addendum, protuberance: stands * tip_radius });
            Gear::new(data).ok()
        },
    )
}

/// The tool's transverse profile, built from its description: the tip land, the rounding as a
/// circle of the normal section, the flank.
fn tool_points(gear: &Gear, count: usize, top: f64) -> Vec<[f64; 2]> {
    let data = gear.data();
    let tool = data.tool.unwrap();
    let (m, alpha) = (data.normal_module, data.pressure_angle);
    let rho = tool.tip_radius;
    // Normal section about the tool's datum line, the tool's middle at −π m / 2, its tip down.
    let depth = tool.addendum_factor * m;
    // The centre lies ρ above the tip and ρ − pr behind the flank line through (−π m/4, 0) that
    // leans by α.
    let height = rho - depth;
    let centre = -FRAC_PI_4 * m + height * alpha.tan() - (rho - tool.protuberance) / alpha.cos();
    let mut points = vec![[-FRAC_PI_2 * m, -depth]];
    let flank = |w: f64| -FRAC_PI_4 * m + w * alpha.tan();
    for k in 0..=count {
        let delta = PI * k as f64 / count as f64;
        let point = [centre + rho * delta.sin(), height - rho * delta.cos()];
        let past = delta > FRAC_PI_2 - alpha;
        // The rounding ends where it meets the flank for good.
        if past && (rho == 0.0 || point[0] <= flank(point[1])) {
            break;
        }
        points.push(point);
    }
    let last = points[points.len() - 1][1].max(-depth);
    points.extend((1..=count).map(|k| {
        let w = last + (top - last) * k as f64 / count as f64;
        [flank(w), w]
    }));
    points.dedup();
    let shift = data.profile_shift * m;
    points.iter().map(|[u, w]| [u / data.helix_angle.cos(), w + shift]).collect()
}

/// Half the tooth's angle that the profile says at a radius.
fn half_angle_at(flank: &[Polar], radius: f64) -> f64 {
    let k = flank.partition_point(|p| p.radius < radius).clamp(1, flank.len() - 1);
    let (a, b) = (flank[k - 1], flank[k]);
    let share = if b.radius > a.radius { (radius - a.radius) / (b.radius - a.radius) } else { 1.0 };
    a.half_angle + share * (b.half_angle - a.half_angle)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Brute force: wherever the tool gets to, no material is left; and it gets everywhere to the
    /// profile's border.
    #[test]
    fn the_profile_is_the_envelope_of_the_moving_tool(gear in generated()) {
        let steps = Steps { involute: 600, fillet: 600, tip: 4, root: 4 };
        let Ok(tooth) = Tooth::new(&gear, steps) else { return Ok(()) };
        let flank = tooth.flank();
        let (r, m) = (gear.reference_radius(), gear.data().normal_module);
        let top = flank[flank.len() - 1].radius;
        let tool = tool_points(&gear, 150, 2.5 * m);
        let mut nearest = vec![f64::INFINITY; 40];
        let radius_of = |k: usize| flank[0].radius + (top - flank[0].radius) * (k as f64 + 0.5) / 40.0;
        let turns = 1500;
        for step in 0..=turns {
            let turn = -1.3 + 2.6 * f64::from(step) / f64::from(turns);
            let (sin, cos) = turn.sin_cos();
            for [u, w] in &tool {
                let (x, y) = (u - r * turn, r + w);
                // Into the gear's frame.
                let (x, y) = (x * cos + y * sin, y * cos - x * sin);
                let radius = x.hypot(y);
                prop_assert!(radius > flank[0].radius * (1.0 - 1e-12));
                // At its foot the angle of a sharp fillet grows with the root of the radius, and is
                // not linear between points.
                if radius >= top || radius < flank[0].radius + 1e-3 * m {
                    continue;
                }
                let gap = (-x).atan2(y) - half_angle_at(flank, radius);
                prop_assert!(gap * radius > -1e-4 * m, "{} into the tooth at {radius}", gap * radius);
                let bin = ((radius - flank[0].radius) / (top - flank[0].radius) * 40.0) as usize;
                nearest[bin.min(39)] = nearest[bin.min(39)].min(gap * radius);
            }
        }
        for (bin, gap) in nearest.iter().enumerate() {
            prop_assert!(*gap < 0.02 * m, "the tool stays {gap} off around {}", radius_of(bin));
        }
    }

    #[test]
    fn fillet_meets_involute_and_root_circle(gear in generated()) {
        let root = Root::of(&gear);
        let fillet = root.rack().unwrap();
        let end = fillet.at(fillet.form_angle());
        let flank = Flank::new(&gear, Side::Left);
        let form = root.form_roll();
        let scale = gear.reference_radius();
        // But for an overhang that cuts once more outside.
        prop_assert!(2.0 * end.radius <= gear.diameter(form) + 1e-9 * scale);
        let form = if fillet.tool.protuberance > 0.0 { gear.roll_length(2.0 * end.radius).unwrap() } else { form };
        prop_assert!((2.0 * end.radius - gear.diameter(form)).abs() < 1e-9 * scale);
        prop_assert!((end.half_angle - flank.half_angle(form)).abs() < 1e-9, "{} {}", end.half_angle,
            flank.half_angle(form));
        let foot = fillet.at(0.0);
        prop_assert!((foot.radius - fillet.root_radius()).abs() < 1e-12 * scale);
        let point = |delta: f64| fillet.at(delta).point(1.0, 0.0);
        let direction = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]).atan2(b[0] - a[0]);
        if fillet.tool.tip_radius > 0.02 * gear.data().normal_module {
            // Along the root circle at its foot …
            let h = 1e-5;
            let along = direction(point(0.0), point(h));
            prop_assert!(((along - foot.half_angle + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2).abs() < 1e-3, "{along}");
        }
        let undercut = fillet.undercut();
        if !undercut && fillet.tool.protuberance == 0.0 && form > 0.05 * scale {
            // … and along the involute at its end.
            let h = 1e-5 * fillet.form_angle();
            let arc = direction(point(fillet.form_angle() - h), point(fillet.form_angle()));
            let at = |roll: f64| flank.at(roll, 0.0).point;
            let (a, b) = (at(form), at(form + 1e-5 * scale));
            let involute = (b.y - a.y).atan2(b.x - a.x);
            prop_assert!(((arc - involute + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2).abs() < 1e-3, "{arc} {involute}");
            // The textbook's form diameter.
            let data = gear.data();
            let tool = data.tool.unwrap();
            let straight = tool.addendum_factor * data.normal_module - tool.tip_radius
                * (1.0 - data.pressure_angle.sin());
            let sin_t = gear.transverse_pressure_angle().sin();
            let roll = scale * sin_t - (straight - data.profile_shift * data.normal_module) / sin_t;
            prop_assert!((form - roll).abs() < 1e-10 * scale);
        }
        let geometry = Geometry::of(&gear);
        let least = geometry.least_profile_shift_coefficient.unwrap();
        prop_assert_eq!(geometry.undercut, least > gear.data().profile_shift + 1e-12);
    }

    #[test]
    fn with_the_least_shift_the_involute_starts_on_the_base_circle(gear in generated()) {
        let mut data = gear.data().clone();
        let Some(tool) = data.tool.as_mut() else { return Ok(()) };
        tool.protuberance = 0.0;
        let Ok(plain) = Gear::new(data.clone()) else { return Ok(()) };
        let least = Geometry::of(&plain).least_profile_shift_coefficient.unwrap();
        if least.abs() > 1.0 {
            return Ok(());
        }
        data.profile_shift = least;
        let Ok(critical) = Gear::new(data.clone()) else { return Ok(()) };
        let geometry = Geometry::of(&critical);
        prop_assert!(!geometry.undercut && geometry.form_roll_length_mm < 1e-6 * critical.reference_radius());
        data.profile_shift = least - 0.05;
        if let Ok(below) = Gear::new(data) {
            let geometry = Geometry::of(&below);
            prop_assert!(geometry.undercut && geometry.form_diameter_mm > geometry.base_diameter_mm);
            let warned = geometry.warnings.iter().any(|w| matches!(w, Warning::Undercut { .. }));
            prop_assert!(warned);
        }
    }

    #[test]
    fn closed_profiles_are_simple_and_counterclockwise(gear in prop_oneof![generated(), any_gear()]) {
        let Ok(tooth) = Tooth::new(&gear, Steps { involute: 12, fillet: 12, tip: 3, root: 3 }) else { return Ok(()) };
        let closed = tooth.closed();
        let area = area(&closed);
        prop_assert!(area > 0.0);
        prop_assert!(is_simple(&closed));
        // Nearly as large as its mean width times its height.
        let depth = Geometry::of(&gear).tooth_depth_mm;
        prop_assert!(area < 1.3 * depth * gear.transverse_module() * PI
            && area > 0.1 * depth * gear.transverse_module());
        let whole = tooth.gear();
        let disc = PI * gear.root_radius().max(gear.tip_radius()).powi(2);
        let inner = PI * tooth.flank()[0].radius.min(gear.tip_radius()).powi(2);
        let found = self::area(&whole);
        prop_assert!(0.8 * inner < found && found < disc, "{inner} {found} {disc}");
        if gear.teeth() < 30.0 {
            prop_assert!(is_simple(&whole));
        }
        // Radii run one way along a flank.
        let out = gear.outward();
        prop_assert!(tooth.flank().windows(2).all(|w| out * (w[1].radius - w[0].radius) > -1e-12 * w[0].radius));
    }

    #[test]
    fn the_numerical_envelope_is_the_trochoid_and_the_involute(gear in generated()) {
        let fillet = *Root::of(&gear).rack().unwrap();
        let tooth = Tooth::new(&gear, Steps { involute: 400, fillet: 400, tip: 2, root: 2 });
        let Ok(tooth) = tooth else { return Ok(()) };
        let flank = tooth.flank();
        let m = gear.data().normal_module;
        let profile = ToolProfile::polyline(&tool_points(&gear, 400, 2.5 * m), 2).unwrap();
        let motion = Motion::Rack { pitch_radius: gear.reference_radius() };
        let [least, most] = [fillet.root_radius(), flank[flank.len() - 1].radius];
        let envelope = Envelope::of(&profile, motion, [0.9 * least, 1.1 * most]).unwrap();
        let radii: Vec<f64> = (1..60).map(|k| least + (most - least) * f64::from(k) / 60.0).collect();
        for (radius, found) in radii.iter().zip(envelope.boundary(&radii)) {
            let wanted = half_angle_at(flank, *radius);
            let found = found.unwrap();
            prop_assert!((found - wanted).abs() * radius < 4e-4 * m, "{radius}: {found} for {wanted}");
        }
    }
}

fn area(points: &[[f64; 2]]) -> f64 {
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    0.5 * pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

/// No two sides cross or touch, but neighbours in their common corner.
fn is_simple(points: &[[f64; 2]]) -> bool {
    let n = points.len();
    let side = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let crosses = |i: usize, j: usize| {
        let (a, b, c, d) = (points[i], points[(i + 1) % n], points[j], points[(j + 1) % n]);
        let apart = (0..2).any(|k| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]));
        !apart && side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
    };
    let distinct = (0..n).all(|i| points[i] != points[(i + 1) % n]);
    distinct && !(0..n).any(|i| (i + 2..n).any(|j| (i, j) != (0, n - 1) && crosses(i, j)))
}

/// A straight rack flank leaves the involute, to the last digits.
#[test]
fn a_straight_rack_leaves_the_involute() {
    for (teeth, beta) in [(30, 0.0), (45, 20.0)] {
        let gear = Gear::new(data(teeth, 2.0, 20.0, beta)).unwrap();
        let flank = Flank::new(&gear, Side::Left);
        let tan = gear.transverse_pressure_angle().tan();
        let point = |w: f64| [-0.5 * PI * 0.5 * gear.transverse_module() + w * tan, w];
        let profile = ToolProfile::polyline(&[point(-1.9), point(2.0)], 50).unwrap();
        let motion = Motion::Rack { pitch_radius: gear.reference_radius() };
        for tool in profile.points() {
            let [x, y] = motion.contact(tool).unwrap();
            let roll = gear.roll_length(2.0 * x.hypot(y)).unwrap();
            assert!(((-x).atan2(y) - flank.half_angle(roll)).abs() < 1e-13);
        }
    }
}

/// An involute pinion-type cutter leaves the involute, outside and inside.
#[test]
fn a_pinion_cutter_leaves_the_involute() {
    for internal in [false, true] {
        let gear = Gear::new(GearData { internal, ..data(60, 2.0, 20.0, 0.0) }).unwrap();
        let cutter = Gear::new(data(25, 2.0, 20.0, 0.0)).unwrap();
        let flank = Flank::new(&gear, Side::Left);
        let half = PI / cutter.teeth();
        let motion = Motion::Pinion { tool_pitch_radius: 25.0, gear_pitch_radius: 60.0, internal };
        let mut count = 0;
        for k in 1..40 {
            // The cutter's tooth left of the gear's own: from below on an internal gear, from above
            // on an external one.
            let (side, turn) = if internal { (Side::Right, half) } else { (Side::Left, PI - half) };
            let place = Flank::new(&cutter, side).at(0.35 * f64::from(k), 0.0);
            let (sin, cos) = turn.sin_cos();
            let turned = |v: Vector| [v.x * cos - v.y * sin, v.x * sin + v.y * cos];
            let tool = ToolPoint { point: turned(place.point), normal: turned(place.normal) };
            let Some([x, y]) = motion.contact(&tool) else { continue };
            let radius = x.hypot(y);
            let Some(roll) = gear.roll_length(2.0 * radius) else { continue };
            if !(57.0..=63.0).contains(&radius) {
                continue;
            }
            count += 1;
            let found = (-x).atan2(y);
            assert!(
                (found - flank.half_angle(roll)).abs() < 1e-12,
                "{internal} {radius}: {found} {}",
                flank.half_angle(roll)
            );
        }
        assert!(count > 5, "{internal}: {count}");
    }
}

/// A spline through points of the rounding comes near the exact one with the fourth power of their
/// distance.
#[test]
fn a_smooth_profile_by_points() {
    let tool = Tool { tip_radius: 0.8, addendum_factor: 1.25, protuberance: 0.0 };
    let gear = Gear::new(GearData { tool: Some(tool), ..data(40, 2.0, 20.0, 25.0) }).unwrap();
    let fillet = RackFillet::new(&gear, Root::of(&gear).rack().unwrap().tool);
    let error = |count: usize| {
        let delta = |k: usize| fillet.form_angle() * k as f64 / count as f64;
        let points: Vec<[f64; 2]> = (0..=count).map(|k| fillet.tool_point(delta(k)).0).collect();
        let profile = ToolProfile::spline(&points, 16).unwrap();
        let motion = Motion::Rack { pitch_radius: gear.reference_radius() };
        let exact: Vec<Polar> =
            (0..=20_000).map(|k| fillet.at(fillet.form_angle() * f64::from(k) / 20_000.0)).collect();
        profile
            .points()
            .iter()
            .skip(8)
            .filter_map(|tool| motion.contact(tool))
            .map(|[x, y]| ((-x).atan2(y) - half_angle_at(&exact, x.hypot(y))).abs() * 40.0)
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(8), error(32));
    assert!(fine < 2e-6 && fine < 0.05 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn roots_of_internal_gears_touch_involute_and_root_circle() {
    for (teeth, radius, beta) in [(60, 0.4, 0.0), (100, 0.6, 20.0), (45, 9.0, 0.0)] {
        let tool = Tool { tip_radius: radius, addendum_factor: 1.25, protuberance: 0.0 };
        let gear = Gear::new(GearData { internal: true, tool: Some(tool), ..data(teeth, 2.0, 20.0, beta) }).unwrap();
        let geometry = Geometry::of(&gear);
        let Root::Arc(arc) = Root::of(&gear) else { panic!("an arc") };
        let points = arc.points(50);
        let (foot, end) = (points[0], points[50]);
        assert!((foot.radius - gear.root_radius()).abs() < 1e-11);
        assert!((2.0 * end.radius - geometry.form_diameter_mm).abs() < 1e-11);
        let half = Flank::new(&gear, Side::Left).half_angle(arc.form_roll);
        assert!((end.half_angle - half).abs() < 1e-12);
        // No point of the arc lies outside the root circle, or in the material next to the
        // involute.
        assert!(points.iter().all(|p| p.radius <= gear.root_radius() * (1.0 + 1e-14)));
        let reduced = geometry.warnings.iter().any(|w| w.code() == "root_radius_reduced");
        assert_eq!(reduced, radius > 5.0);
        if reduced {
            assert!((foot.half_angle - PI / gear.teeth()).abs() < 1e-9);
        }
        assert!(geometry.warnings.iter().any(|w| w.code() == "internal_root"));
    }
}

#[test]
fn a_protuberance_starts_the_involute_higher() {
    let form = |protuberance: f64| {
        let tool = Tool { tip_radius: 0.6, addendum_factor: 1.4, protuberance };
        let gear = Gear::new(GearData { tool: Some(tool), ..data(40, 2.0, 20.0, 15.0) }).unwrap();
        let geometry = Geometry::of(&gear);
        (geometry.form_diameter_mm, geometry.warnings.iter().any(|w| w.code() == "protuberance"))
    };
    let (without, no) = form(0.0);
    let (little, yes) = form(0.02);
    let (more, _) = form(0.08);
    assert!(!no && yes && without < little && little < more && more < without + 2.0, "{without} {little} {more}");
}

#[test]
fn a_root_circle_that_disagrees_with_the_tool_is_warned_of() {
    let tool = Tool { tip_radius: 0.5, addendum_factor: 1.25, protuberance: 0.0 };
    let codes = |root: f64| {
        let gear =
            Gear::new(GearData { tool: Some(tool), root_diameter: Some(root), ..data(40, 2.0, 20.0, 0.0) }).unwrap();
        let geometry = Geometry::of(&gear);
        assert!((geometry.generated_root_diameter_mm.unwrap() - 75.0).abs() < 1e-9);
        geometry.warnings.iter().map(Warning::code).collect::<Vec<_>>()
    };
    assert_eq!(codes(74.0), ["root_below_tool"]);
    assert_eq!(codes(76.0), ["root_above_tool"]);
    assert!(codes(75.0).is_empty());
}

/// A pitch line that turns the gear a million times while the tool passes needs billions of points.
#[test]
fn an_envelope_has_a_total_of_points() {
    let points = [[-1.57, -1.25], [-1.2403609562, -1.25], [-0.4214279291, 1.0]];
    let profile = ToolProfile::polyline(&points, 40).unwrap();
    for pitch_radius in [1e-300, 1e-6, 1e-4] {
        let refused = Envelope::of(&profile, Motion::Rack { pitch_radius }, [0.0247, 27.1]);
        assert_eq!(refused, Err(TooManyBetween), "{pitch_radius}");
    }
    let made = Envelope::of(&profile, Motion::Rack { pitch_radius: 20.0 }, [0.0247, 27.1]).unwrap();
    assert!(made.branches.iter().map(Vec::len).sum::<usize>() < 10_000);
}

#[test]
fn profiles_of_tools_are_checked() {
    let point = |x: f64| [x, 0.5 * x];
    let paths = |points: &[[f64; 2]], parts| -> Vec<String> {
        ToolProfile::polyline(points, parts).unwrap_err().list().iter().map(|fault| fault.path.clone()).collect()
    };
    assert_eq!(paths(&[point(0.0)], 3), [""]);
    assert_eq!(paths(&[point(0.0), point(0.0)], 3), ["[1]"]);
    assert_eq!(paths(&[point(0.0), point(f64::NAN), point(2.0)], 3), ["[1]"]);
    assert_eq!(paths(&[point(0.0), point(1.0)], usize::MAX), [""]);
    // a saw: nearly half a turn at every corner
    let saw: Vec<[f64; 2]> = (0..2000).map(|k| [f64::from(k % 2), 1e-3 * f64::from(k)]).collect();
    assert_eq!(paths(&saw, 1), [""]);
}
