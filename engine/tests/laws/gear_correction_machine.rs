//! Built-in sensitivities against flanks that are made with changed settings: where a line along
//! the nominal normal meets them is found by Newton's iteration on three unknowns, which shares
//! nothing with the formulas.

use flankfit_engine::gear::correction::machine::{FlankNode, Machine, Ranges, Sensitivity};
use flankfit_engine::gear::correction::{self, Correction, CorrectionSpec};
use flankfit_engine::gear::involute::Flank;
use flankfit_engine::gear::{Gear, GearData, Hand, Side};
use nalgebra::{Matrix3, Rotation3, Vector3};

type Point = Vector3<f64>;
const MINUTE: f64 = std::f64::consts::PI / 10_800.0;

fn gears() -> Vec<Gear> {
    let data = |teeth, helix: f64, hand, internal, shift| GearData {
        teeth,
        normal_module: 2.5,
        pressure_angle: 20f64.to_radians(),
        helix_angle: helix.to_radians(),
        hand,
        profile_shift: shift,
        face_width: Some(24.0),
        tip_diameter: None,
        root_diameter: None,
        internal,
        tool: None,
    };
    [
        data(31, 0.0, Hand::Right, false, 0.0),
        data(26, 24.0, Hand::Right, false, 0.3),
        data(43, 17.5, Hand::Left, false, -0.1),
        data(71, 12.0, Hand::Right, true, 0.2),
    ]
    .map(|data| Gear::new(data).unwrap())
    .to_vec()
}

/// Five by five nodes on both flanks between reference circle −1 mm and +2 mm, for external and
/// internal gears.
fn nodes(gear: &Gear) -> (Vec<FlankNode>, Ranges) {
    let at = |radius: f64| gear.roll_length(2.0 * radius).unwrap();
    let r = gear.reference_radius();
    let profile = [at(r - gear.outward()), at(r + 2.0 * gear.outward())];
    let helix = [-10.0, 11.0];
    let along = |range: [f64; 2], k: usize| range[0] + (range[1] - range[0]) * k as f64 / 4.0;
    let mut nodes = Vec::new();
    for side in [Side::Left, Side::Right] {
        for i in 0..5 {
            for j in 0..5 {
                nodes.push(FlankNode { side, roll_length: along(profile, i), z: along(helix, j) });
            }
        }
    }
    (nodes, Ranges { profile, helix })
}

/// Distance of the made flank along the nominal normal, mm.
fn distance(gear: &Gear, node: FlankNode, made: &dyn Fn(f64, f64) -> Point) -> f64 {
    let place = Flank::new(gear, node.side).at(node.roll_length, node.z);
    let mut x = Vector3::new(node.roll_length, node.z, 0.0);
    for _ in 0..30 {
        let miss = |x: &Point| made(x[0], x[1]) - place.point - place.normal * x[2];
        let here = miss(&x);
        let column = |i: usize| {
            let mut step = Vector3::zeros();
            step[i] = 1e-5;
            (miss(&(x + step)) - miss(&(x - step))) / 2e-5
        };
        let jacobian = Matrix3::from_columns(&[column(0), column(1), column(2)]);
        x -= jacobian.lu().solve(&here).unwrap();
    }
    x[2]
}

fn turned(point: Point, angle: f64) -> Point {
    Rotation3::from_axis_angle(&Vector3::z_axis(), angle) * point
}

/// Deviation for one unit, µm: central difference of flanks made with one unit more and less.
fn made(machine: Machine, name: &str, gear: &Gear, node: FlankNode, ranges: Ranges) -> f64 {
    let side = node.side;
    let of = |unit: f64| -> f64 {
        let with = |angle: f64| {
            let mut data = gear.data().clone();
            data.pressure_angle += angle;
            Gear::new(data).unwrap()
        };
        let nominal = Flank::new(gear, side);
        let (r, beta) = (gear.reference_radius(), gear.data().helix_angle);
        let gap = |x: f64, y: f64, z: f64| {
            turned(
                Vector3::new(x, y, 0.0),
                side.sign() * std::f64::consts::PI / gear.teeth() + gear.turn_per_length() * z,
            )
        };
        let mm = unit * 1e-3;
        match (machine, name) {
            (_, "profile_angle") => {
                let changed = with(unit * MINUTE);
                distance(gear, node, &|l, z| Flank::new(&changed, side).at(l, z).point)
            }
            (_, "helix_angle") => {
                let middle = 0.5 * (ranges.helix[0] + ranges.helix[1]);
                // the signed angle of the gear, above 0 for a right hand
                let signed = gear.hand() * beta;
                let more = ((signed + unit * MINUTE).tan() - signed.tan()) / r;
                distance(gear, node, &|l, z| turned(nominal.at(l, z).point, more * (z - middle)))
            }
            (_, "tooth_thickness") => {
                let angle = side.sign() * mm / beta.cos() / (2.0 * r);
                distance(gear, node, &|l, z| turned(nominal.at(l, z).point, angle))
            }
            (Machine::GeneratingGrinding, "tool_axis_offset") => {
                distance(gear, node, &|l, z| turned(nominal.at(l, z).point, mm / beta.cos() / r))
            }
            (Machine::FormGrinding, "tool_axis_offset") => {
                distance(gear, node, &|l, z| nominal.at(l, z).point + gap(-mm, 0.0, z))
            }
            (Machine::FormGrinding, "infeed") => distance(gear, node, &|l, z| nominal.at(l, z).point + gap(0.0, mm, z)),
            _ => unreachable!("{name}"),
        }
    };
    1e3 * (of(1.0) - of(-1.0)) / 2.0
}

fn column<'a>(s: &'a Sensitivity, name: &str) -> impl Iterator<Item = f64> + 'a {
    let j = s.settings.iter().position(|setting| setting.name == name).unwrap();
    s.matrix.iter().skip(j).step_by(s.settings.len()).copied()
}

#[test]
fn columns_are_those_of_made_flanks() {
    for gear in gears() {
        let (nodes, ranges) = nodes(&gear);
        for machine in [Machine::GeneratingGrinding, Machine::FormGrinding] {
            let sensitivity = machine.sensitivity(&gear, &nodes, ranges).unwrap();
            for name in ["profile_angle", "helix_angle", "tooth_thickness", "tool_axis_offset", "infeed"] {
                if !sensitivity.settings.iter().any(|s| s.name == name) {
                    continue;
                }
                for (node, entry) in nodes.iter().zip(column(&sensitivity, name)) {
                    let want = made(machine, name, &gear, *node, ranges);
                    assert!(
                        (entry - want).abs() < 2e-6 + 2e-5 * want.abs(),
                        "{machine:?} {name} {node:?}: {entry} is {want}"
                    );
                }
            }
        }
    }
}

/// Mean, f_Hα, f_Hβ by DIN, C_α, C_β and 4c_uv of deviations over 5 × 5 nodes: second-order surface
/// by a solve of the test's own.
fn figures(deviations: &[f64], side: Side) -> [f64; 6] {
    let along = |k: usize| k as f64 / 2.0 - 1.0;
    let x = nalgebra::DMatrix::from_fn(25, 6, |k, c| {
        let (u, v) = (along(k / 5), along(k % 5));
        [1.0, u, v, u * u, v * v, u * v][c]
    });
    let y = nalgebra::DVector::from_row_slice(deviations);
    let c = x.svd(true, true).solve(&y, 1e-12).unwrap();
    let s = if side == Side::Left { 1.0 } else { -1.0 };
    [c[0], 2.0 * c[1], s * 2.0 * c[2], -c[3], -c[4], 4.0 * c[5]]
}

/// docs/reference/machine-settings.md: what a positive change of every setting of both machines is
/// called on either flank, hand and kind of gear, by flanks that are made anew where they can be.
#[test]
fn every_setting_has_the_sense_that_its_page_says() {
    for gear in gears() {
        let (nodes, ranges) = nodes(&gear);
        for machine in [Machine::GeneratingGrinding, Machine::FormGrinding] {
            let sensitivity = machine.sensitivity(&gear, &nodes, ranges).unwrap();
            for setting in machine.settings() {
                let name = setting.name.as_str();
                for (side, part) in [(Side::Left, 0..25), (Side::Right, 25..50)] {
                    let s = if side == Side::Left { 1.0 } else { -1.0 };
                    let there = nodes[part.clone()].iter();
                    let anew: Vec<f64> = match name {
                        "profile_crowning" | "helix_crowning" | "twist" => {
                            column(&sensitivity, name).skip(part.start).take(25).collect()
                        }
                        _ => there.map(|node| made(machine, name, &gear, *node, ranges)).collect(),
                    };
                    for (entry, want) in column(&sensitivity, name).skip(part.start).zip(&anew) {
                        assert!(
                            (entry - want).abs() < 2e-6 + 2e-5 * want.abs(),
                            "{machine:?} {name}: {entry} is {want}"
                        );
                    }
                    let [mean, f_alpha, f_beta, c_alpha, c_beta, twist] = figures(&anew, side);
                    let context = format!("{machine:?} {name} {side:?}: {:?}", figures(&anew, side));
                    let none = |x: f64| x.abs() < 1e-4;
                    let one = |x: f64| (x - 1.0).abs() < 1e-9;
                    let beta = gear.data().helix_angle;
                    let normal = gear.data().pressure_angle.cos();
                    let good = match (machine, name) {
                        (_, "profile_angle") => {
                            f_alpha < -0.1 && none(f_beta) && none(c_alpha) && none(c_beta) && none(twist)
                        }
                        (_, "helix_angle") => {
                            let want = 1e3 * MINUTE * 21.0 * normal / beta.cos();
                            (f_beta / want - 1.0).abs() < 1e-4
                                && none(mean)
                                && none(f_alpha)
                                && none(c_alpha)
                                && none(twist)
                        }
                        (_, "profile_crowning") => {
                            one(c_alpha) && none(f_alpha) && none(f_beta) && none(c_beta) && none(twist)
                        }
                        (Machine::FormGrinding, "helix_crowning") => {
                            one(c_beta) && none(f_alpha) && none(f_beta) && none(c_alpha) && none(twist)
                        }
                        // the natural twist: 4 c_uv of −v_t², of either sign with the hand and the
                        // flank, none on spur gears
                        (_, "helix_crowning") => {
                            let sense = -s * gear.hand() * gear.outward() * (ranges.profile[1] - ranges.profile[0]);
                            one(c_beta) && if beta == 0.0 { none(twist) } else { twist * sense > 0.0 }
                        }
                        (_, "twist") => one(twist) && none(f_alpha) && none(f_beta) && none(c_alpha) && none(c_beta),
                        (_, "tooth_thickness") => (mean - 0.5 * normal).abs() < 1e-4 && none(f_alpha) && none(f_beta),
                        (Machine::GeneratingGrinding, "tool_axis_offset") => {
                            (mean - s * normal).abs() < 1e-4 && none(f_alpha) && none(f_beta)
                        }
                        (_, "infeed") => {
                            gear.outward() * mean > 0.2
                                && f_alpha > 0.05
                                && none(f_beta)
                                && none(twist)
                                && c_alpha.abs() < 0.05
                        }
                        (_, "tool_axis_offset") => {
                            s * mean > 0.5
                                && gear.outward() * s * f_alpha < -0.02
                                && none(f_beta)
                                && none(twist)
                                && c_alpha.abs() < 0.05
                        }
                        _ => false,
                    };
                    assert!(good, "{context}");
                }
            }
        }
    }
}

/// The textbook slope of a profile angle: −L_α tan α for each rad, on spur gears.
#[test]
fn a_greater_pressure_angle_takes_from_the_tip() {
    let gear = &gears()[0];
    let (nodes, ranges) = nodes(gear);
    let sensitivity = Machine::GeneratingGrinding.sensitivity(gear, &nodes, ranges).unwrap();
    let angle: Vec<f64> = column(&sensitivity, "profile_angle").collect();
    let slope = (angle[20] - angle[0]) / (ranges.profile[1] - ranges.profile[0]);
    assert!((slope + 1e3 * MINUTE * 20f64.to_radians().tan()).abs() < 1e-6, "{slope}");
    assert_eq!(angle[..25], angle[25..]);
}

/// Position of a worm when it touches a node: turned until its normal meets the pitch line, which
/// it then reaches at z_t.
fn tool_position(gear: &Gear, node: FlankNode) -> f64 {
    let place = Flank::new(gear, node.side).at(node.roll_length, node.z);
    let r = gear.reference_radius();
    let miss = |angle: f64| {
        let (p, n) = (turned(place.point, angle), turned(place.normal, angle));
        (-p.x) * n.y - (r - p.y) * n.x
    };
    let mut angle = place.point.x.atan2(place.point.y);
    for _ in 0..50 {
        angle -= miss(angle) * 2e-6 / (miss(angle + 1e-6) - miss(angle - 1e-6));
    }
    assert!(miss(angle).abs() < 1e-9);
    let (p, n) = (turned(place.point, angle), turned(place.normal, angle));
    let along = ((-p.x) * n.x + (r - p.y) * n.y) / (n.x * n.x + n.y * n.y);
    p.z + along * n.z
}

#[test]
fn crowning_has_its_natural_twist_in_generating_grinding_only() {
    for gear in gears() {
        let (nodes, ranges) = nodes(&gear);
        let (middle, half) = (0.5 * (ranges.helix[0] + ranges.helix[1]), 0.5 * (ranges.helix[1] - ranges.helix[0]));
        let worm = Machine::GeneratingGrinding.sensitivity(&gear, &nodes, ranges).unwrap();
        let wheel = Machine::FormGrinding.sensitivity(&gear, &nodes, ranges).unwrap();
        for ((node, worm), wheel) in
            nodes.iter().zip(column(&worm, "helix_crowning")).zip(column(&wheel, "helix_crowning"))
        {
            let v = |z: f64| (z - middle) / half;
            assert!((wheel + v(node.z).powi(2)).abs() < 1e-12);
            let want = -v(tool_position(&gear, *node)).powi(2);
            assert!((worm - want).abs() < 1e-6, "{node:?}: {worm} is {want}");
        }
        let names = |machine: Machine| machine.settings().into_iter().map(|s| s.name).collect::<Vec<_>>();
        assert!(names(Machine::GeneratingGrinding).contains(&"twist".to_owned()));
        assert!(!names(Machine::FormGrinding).contains(&"twist".to_owned()));
    }
}

/// On one flank alone a shifted worm and a thicker tooth are the same; on both they are
/// distinguished.
#[test]
fn one_flank_cannot_distinguish_offset_from_thickness() {
    for gear in gears() {
        let (nodes, ranges) = nodes(&gear);
        let solve = |nodes: &[FlankNode]| {
            let s = Machine::GeneratingGrinding.sensitivity(&gear, nodes, ranges).unwrap();
            let deviation = column(&s, "tooth_thickness").map(|x| 6.0 * x).collect();
            Correction::new(CorrectionSpec::new(deviation, s.matrix, s.settings)).unwrap().solve().unwrap()
        };
        let one = solve(&nodes[..25]);
        let together = one.indistinguishable.iter().any(|group| {
            ["tooth_thickness", "tool_axis_offset"].iter().all(|name| group.names.iter().any(|n| n == name))
        });
        assert!(together, "{:?}", one.indistinguishable);
        assert!(one.predicted.rms_um < 1e-6);
        let both = solve(&nodes);
        let change = |name: &str| both.settings.iter().find(|s| s.name == name).unwrap().change;
        assert!((change("tooth_thickness") + 6.0).abs() < 0.2 && change("tool_axis_offset").abs() < 1e-6);
    }
}

/// On one flank of a form grinder thickness, infeed and offset cancel only all three together: any
/// two of them are determined far better.
#[test]
fn the_sentence_names_every_partner() {
    let gear = &gears()[1];
    let (nodes, ranges) = nodes(gear);
    let s = Machine::FormGrinding.sensitivity(gear, &nodes[..25], ranges).unwrap();
    let deviation = column(&s, "infeed").collect();
    let solution = Correction::new(CorrectionSpec::new(deviation, s.matrix, s.settings)).unwrap().solve().unwrap();
    let worst = &solution.indistinguishable[0];
    for name in ["tooth_thickness", "infeed", "tool_axis_offset"] {
        assert!(worst.names.iter().any(|n| n == name) && worst.sentence.contains(name), "{}", worst.sentence);
    }
    assert!(worst.sentence.contains("alone have cos"), "{}", worst.sentence);
}

#[test]
fn impossible_nodes_and_ranges_have_their_places() {
    let gear = &gears()[0];
    let (mut nodes, ranges) = nodes(gear);
    nodes[3].roll_length = -1.0;
    nodes[4].z = f64::NAN;
    let backwards = Ranges { helix: [5.0, 5.0], ..ranges };
    let faults = Machine::FormGrinding.sensitivity(gear, &nodes, backwards).unwrap_err();
    let paths: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(paths, ["helix_range_mm", "nodes[3].roll_length_mm", "nodes[4].z_mm"]);
    // the base circle is a place on the involute
    (nodes[3].roll_length, nodes[4].z) = (0.0, 0.0);
    assert!(Machine::FormGrinding.sensitivity(gear, &nodes, ranges).unwrap().matrix.iter().all(|x| x.is_finite()));
}

/// A profile and a helix do not show a twist wherever they cross, nor does one trace; the angles
/// are found without it. Nodes over the flank, or over a part of it, show it.
#[test]
fn a_cross_leaves_the_twist_undetermined() {
    let gear = &gears()[0];
    let (_, ranges) = nodes(gear);
    let at = |range: [f64; 2], share: f64| range[0] + share * (range[1] - range[0]);
    let node =
        |u: f64, v: f64| FlankNode { side: Side::Left, roll_length: at(ranges.profile, u), z: at(ranges.helix, v) };
    let shares = |count: u32| (0..count).map(move |k| f64::from(k) / f64::from(count - 1));
    let grid = |size: f64| -> Vec<FlankNode> {
        shares(5).flat_map(|u| shares(7).map(move |v| (size * u, size * v))).map(|(u, v)| node(u, v)).collect()
    };
    let cross = |u: f64, v: f64, [along_profile, along_helix]: [u32; 2]| -> Vec<FlankNode> {
        // the coordinate that is fixed scatters by a thousandth of the flank
        let jitter = |x: f64| 1e-3 * (97.0 * x).sin();
        let profile = shares(along_profile).map(|x| node(x, v + jitter(x)));
        profile.chain(shares(along_helix).map(|x| node(u + jitter(x), x))).collect()
    };
    let profiles = |places: &[f64]| -> Vec<FlankNode> {
        places.iter().flat_map(|v| shares(30).map(|u| (u, *v))).map(|(u, v)| node(u, v)).collect()
    };
    for (places, shown) in [
        (cross(0.5, 0.5, [40, 40]), false),
        (cross(0.9, 0.5, [40, 40]), false),
        (cross(0.7, 0.2, [960, 60]), false),
        (cross(0.6, 0.6, [60, 960]), false),
        (profiles(&[0.8]), false),
        (profiles(&[0.1, 0.5, 0.9]), true),
        (grid(1.0), true),
        (grid(0.2), true),
    ] {
        let Sensitivity { mut settings, matrix } =
            Machine::GeneratingGrinding.sensitivity(gear, &places, ranges).unwrap();
        let is_cross = !shown && places.len() > 30;
        // two angles are off, and each node by something of its own
        let deviation = |(k, row): (usize, &[f64])| -3.0 * row[0] + 2.0 * row[1] + 0.3 * (7.0 * k as f64).sin();
        let deviations: Vec<f64> = matrix.chunks_exact(settings.len()).enumerate().map(deviation).collect();
        let terms = Default::default();
        let flank = correction::Flank { gear: gear.clone(), side: Side::Left, places, ranges, traces: None, terms };
        assert_eq!(flank.shows_twist(&deviations, None), shown);
        // slopes of traces with zeros of their own show as much
        let traces = flank
            .places
            .iter()
            .enumerate()
            .map(|(k, place)| if is_cross { k / 40 } else { place.z.to_bits() as usize });
        let apart = correction::Flank { traces: Some(traces.collect()), ..flank.clone() };
        assert_eq!(apart.shows_twist(&deviations, None), shown);
        // corners of hardly any weight, or without a deviation, show nothing
        let (mut more, mut weights) = (deviations.clone(), vec![1.0; deviations.len()]);
        let mut corners = flank.clone();
        for (u, v) in [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            corners.places.push(node(u, v));
            more.push(1.0);
            weights.push(1e-9);
        }
        assert_eq!(corners.shows_twist(&more, Some(&weights)), shown);
        more[deviations.len()..].fill(f64::NAN);
        assert_eq!(corners.shows_twist(&more, None), shown);
        let twist = settings.iter().position(|setting| setting.twists).unwrap();
        settings[twist].hidden = !shown;
        let spec = CorrectionSpec { absolute: false, ..CorrectionSpec::new(deviations, matrix, settings) };
        let solution = Correction::new(spec).unwrap().solve().unwrap();
        assert!(shown || solution.settings[twist].undetermined);
        if is_cross {
            for (setting, wanted) in solution.settings.iter().zip([3.0, -2.0]) {
                let error = setting.std_error.unwrap();
                assert!((setting.change - wanted).abs() < 4.0 * error && error < 0.5, "{setting:?}");
            }
        }
    }
}
