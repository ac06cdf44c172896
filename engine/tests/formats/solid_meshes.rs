//! Solid meshes of gears: positive determinants, volumes, conformity, sets, and files that are read
//! back.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    f64::consts::PI,
    sync::Arc,
};

use flankfit_engine::{
    formats::{Label, UtcTime, solid_mesh},
    gear::{
        Gear, GearData, Hand, Side, Tool,
        generation::tooth::{Steps, Tooth},
        involute::Flank,
        solid::{Elements, HexMesh, SolidSpec},
    },
};

fn external() -> GearData {
    GearData { face_width: Some(12.0), ..GearData::spur(24, 2.5) }
}

fn gears() -> Vec<(&'static str, GearData)> {
    let helical = GearData {
        helix_angle: 25_f64.to_radians(),
        hand: Hand::Left,
        profile_shift: 0.3,
        pressure_angle: 18_f64.to_radians(),
        ..external()
    };
    let tool = Tool { tip_radius: 0.6, addendum_factor: 1.4, protuberance: 0.1 };
    vec![
        ("spur", external()),
        ("helical", helical.clone()),
        ("with protuberance", GearData { tool: Some(tool), teeth: 40, ..external() }),
        ("undercut", GearData { teeth: 12, ..external() }),
        ("internal", GearData { internal: true, teeth: 60, ..external() }),
        ("internal helical", GearData { internal: true, teeth: 72, hand: Hand::Right, ..helical }),
        ("shallow", GearData { root_diameter: Some(56.0), teeth: 24, ..external() }),
    ]
}

fn spec(quadratic: bool, factor: usize) -> SolidSpec {
    let Elements { involute, fillet, root, thickness, rim, width } =
        Elements { involute: 5, fillet: 4, root: 1, thickness: 4, rim: 3, width: 4 };
    let elements = Elements {
        involute: involute * factor,
        fillet: fillet * factor,
        root: root * factor,
        thickness: thickness * factor,
        rim: rim * factor,
        width: width * factor,
    };
    SolidSpec { quadratic, elements, ..SolidSpec::default() }
}

/// The area of one pitch between the rim's circle and the profile: ½ ∮ r² dφ over a fine polygon.
fn area(gear: &Gear, rim: f64) -> f64 {
    let steps = Steps { involute: 2000, fillet: 2000, tip: 2000, root: 2000 };
    let polygon = Tooth::new(gear, steps).unwrap().gear();
    let next = polygon.iter().cycle().skip(1);
    let double: f64 = polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
    (0.5 * double - PI * rim * rim).abs() / gear.teeth()
}

fn rim(mesh: &HexMesh) -> f64 {
    let set = mesh.sets().iter().find(|set| set.name == "BORE" || set.name == "RIM").unwrap();
    let node = mesh.nodes()[mesh.nodes_of(set)[0] as usize];
    node.x.hypot(node.y)
}

#[test]
fn determinants_are_positive_and_volumes_those_of_the_section() {
    for (name, data) in gears() {
        let gear = Gear::new(data).unwrap();
        let mut exact = None;
        for quadratic in [false, true] {
            let errors = [1, 2].map(|factor| {
                let mesh =
                    HexMesh::of_gear(&gear, &spec(quadratic, factor)).unwrap_or_else(|e| panic!("{name}: {e:?}"));
                assert!(mesh.least_jacobian() > 0.0, "{name}");
                let exact = *exact.get_or_insert_with(|| area(&gear, rim(&mesh)) * 12.0);
                (mesh.volume() - exact).abs() / exact
            });
            // straight edges err by the square of their length, curved ones by a higher power
            let (most, falls) = if quadratic { (3e-5, 5.0) } else { (4e-3, 3.0) };
            assert!(errors[0] < most, "{name} {quadratic}: {errors:?}");
            assert!(errors[1] < errors[0] / falls || errors[1] < 1e-6, "{name} {quadratic}: {errors:?}");
        }
    }
}

/// Every face is one of two elements or lies in exactly one set; no two nodes are one place.
#[test]
fn elements_conform_and_sets_are_the_whole_border() {
    for (name, data) in gears() {
        let teeth = data.teeth;
        let gear = Gear::new(data).unwrap();
        for (quadratic, count) in [(false, 1), (true, 3), (false, teeth)] {
            let spec = SolidSpec { teeth: count, ..spec(quadratic, 1) };
            let mesh = HexMesh::of_gear(&gear, &spec).unwrap();
            assert!(mesh.nodes().len() <= HexMesh::most_nodes(&spec), "{name}");
            let mut seen: HashMap<Vec<u32>, usize> = HashMap::new();
            for element in 0..mesh.count() as u32 {
                for face in 0..6 {
                    let mut nodes: Vec<u32> =
                        mesh.face(flankfit_engine::gear::solid::HexFace { element, face }).collect();
                    nodes.sort_unstable();
                    *seen.entry(nodes).or_default() += 1;
                }
            }
            let mut border: BTreeSet<Vec<u32>> =
                seen.iter().filter(|(_, count)| **count == 1).map(|(nodes, _)| nodes.clone()).collect();
            assert!(seen.values().all(|count| *count <= 2), "{name}");
            for set in mesh.sets() {
                for face in &set.faces {
                    let mut nodes: Vec<u32> = mesh.face(*face).collect();
                    nodes.sort_unstable();
                    assert!(border.remove(&nodes), "{name}: {} holds a face that is none of the border", set.name);
                }
            }
            assert!(border.is_empty(), "{name}: {} faces of the border have no name", border.len());
            let names: BTreeSet<&str> = mesh.sets().iter().map(|set| set.name.as_str()).collect();
            assert_eq!(names.contains("CUT_LEFT"), count < teeth, "{name}");
            assert!(names.contains(format!("RIGHT_FLANK_{count}").as_str()), "{name}");
            let mut places: BTreeMap<[i64; 3], u32> = BTreeMap::new();
            let mut used = vec![false; mesh.nodes().len()];
            for element in 0..mesh.count() {
                mesh.element(element).iter().for_each(|node| used[*node as usize] = true);
            }
            assert!(used.iter().all(|used| *used), "{name}: a node of no element");
            for node in mesh.nodes() {
                let near = [node.x, node.y, node.z].map(|x| (x * 1e6).round() as i64);
                *places.entry(near).or_default() += 1;
            }
            assert!(places.values().all(|count| *count == 1), "{name}: two nodes at one place");
        }
    }
}

/// Nodes of the flanks lie on the involute helicoid, on their own side of the tooth.
#[test]
fn flanks_are_where_they_should_be() {
    for (name, data) in gears() {
        let gear = Gear::new(data).unwrap();
        let mesh = HexMesh::of_gear(&gear, &spec(true, 1)).unwrap();
        for (set, side) in [("LEFT_FLANK_1", Side::Left), ("RIGHT_FLANK_1", Side::Right)] {
            let set = mesh.sets().iter().find(|known| known.name == set).unwrap();
            let flank = Flank::new(&gear, side);
            for node in mesh.nodes_of(set) {
                let p = mesh.nodes()[node as usize];
                let Some(roll) = gear.roll_length(2.0 * p.x.hypot(p.y)) else { continue };
                let off = (flank.at(roll, p.z).point - p).norm();
                assert!(off < 1e-9, "{name}: {off:e}");
            }
        }
    }
}

#[test]
fn gears_without_a_solid_mesh_are_refused() {
    let of = |data: GearData, spec: SolidSpec| {
        let refused = HexMesh::of_gear(&Gear::new(data).unwrap(), &spec).unwrap_err();
        refused.to_string()
    };
    let plain = SolidSpec::default();
    assert_eq!(of(GearData::spur(24, 2.5), plain.clone()), "gear.face_width_mm: a solid needs the face width");
    for teeth in [25, 0] {
        let refused = of(external(), SolidSpec { teeth, ..plain.clone() });
        assert_eq!(refused, format!("teeth: a sector of {teeth} teeth; the gear has 24"));
    }
    let rim = |diameter: f64| SolidSpec { rim_diameter: Some(diameter), ..SolidSpec::default() };
    for diameter in [60.0, -1.0, f64::NAN] {
        let refused = of(external(), rim(diameter));
        assert!(refused.starts_with("rim_diameter_mm: the rim would end"), "{diameter}: {refused}");
    }
    let none = Elements { rim: 0, ..Elements::default() };
    let refused = of(external(), SolidSpec { elements: none, ..plain.clone() });
    assert_eq!(refused, "elements: at least one element along every direction");
    let many = Elements { width: usize::MAX, ..Elements::default() };
    let refused = of(external(), SolidSpec { elements: many, ..plain.clone() });
    assert!(refused.starts_with("elements: more nodes than can be counted are requested"), "{refused}");
    let pointed = GearData { profile_shift: 1.2, teeth: 9, ..external() };
    let refused = of(pointed, plain);
    assert!(refused.starts_with("gear.profile_shift_coefficient: "), "{refused}");
}

fn label() -> Label {
    Label { name: "tooth".into(), author: String::new(), organization: String::new(), written_at: UtcTime::epoch() }
}

/// The three files hold the same nodes and elements, each in its program's order.
#[test]
fn files_are_read_back() {
    let gear = Gear::new(external()).unwrap();
    for quadratic in [false, true] {
        let mesh = Arc::new(HexMesh::of_gear(&gear, &spec(quadratic, 1)).unwrap());
        let text = |pieces: flankfit_engine::formats::Pieces| String::from_utf8(pieces.whole()).unwrap();
        let [abaqus, adina, gmsh] = [
            text(solid_mesh::abaqus(&mesh, &label())),
            text(solid_mesh::adina(&mesh, &label())),
            text(solid_mesh::gmsh(&mesh, &label())),
        ];
        let numbers = |line: &str| -> Vec<f64> {
            line.split([',', ' '])
                .filter(|s| !s.is_empty())
                .map(|s| s.parse().unwrap_or_else(|_| panic!("{line}")))
                .collect()
        };
        let between = |text: &str, from: &str, to: &str| -> Vec<String> {
            let begin = text.find(from).unwrap_or_else(|| panic!("no {from}")) + from.len();
            let rest = &text[begin..];
            let rest = &rest[rest.find('\n').unwrap() + 1..];
            rest[..rest.find(to).unwrap()].replace(",\n", ",").lines().map(str::to_owned).collect()
        };
        let count = if quadratic { 20 } else { 8 };
        let kind = if quadratic { "TYPE=C3D20," } else { "TYPE=C3D8I," };
        let of_abaqus = between(&abaqus, kind, "*NSET");
        let of_adina = between(&adina, "NNODES=", "@\n*\nNODESET");
        let of_gmsh = between(&gmsh, "$Elements\n", "$EndElements");
        assert_eq!((of_abaqus.len(), of_adina.len() - 1), (mesh.count(), mesh.count()));
        for i in 0..mesh.count() {
            let own: Vec<f64> = mesh.element(i).iter().map(|node| f64::from(*node) + 1.0).collect();
            assert_eq!(numbers(&of_abaqus[i])[1..], own);
            let adina = &numbers(&of_adina[i + 1])[1..];
            assert_eq!((adina.len(), &adina[4..8], &adina[..4]), (count, &own[..4], &own[4..8]));
            let gmsh = &numbers(&of_gmsh[i])[5..];
            assert_eq!((gmsh.len(), &gmsh[..8]), (count, &own[..8]));
            // the middle of an edge lies between its ends: the numbering of each program's manual
            if quadratic {
                let at = |node: f64| mesh.nodes()[node as usize - 1];
                let middle = |of: &[f64], k: usize, [a, b]: [usize; 2]| {
                    let off = (at(of[k]) - (at(of[a]) + at(of[b])) * 0.5).norm();
                    let chord = (at(of[a]) - at(of[b])).norm();
                    assert!(off < 0.2 * chord, "{k}: {off} of {chord}");
                };
                let around =
                    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
                let by_ends =
                    [[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];
                for k in 0..12 {
                    middle(&own, 8 + k, around[k]);
                    middle(adina, 8 + k, around[k]);
                    middle(gmsh, 8 + k, by_ends[k]);
                }
            }
        }
        for set in mesh.sets() {
            assert!(abaqus.contains(&format!("*SURFACE, NAME={}, TYPE=ELEMENT", set.name)));
            assert!(adina.contains(&format!("DESCRIPT='{}'", set.name)) && gmsh.contains(&format!("\"{}\"", set.name)));
        }
        let nodes = between(&gmsh, "$Nodes\n", "$EndNodes");
        for (line, node) in nodes.iter().zip(mesh.nodes()) {
            let [_, x, y, z] = numbers(line)[..] else { panic!("{line}") };
            assert!(((x - node.x).abs() + (y - node.y).abs() + (z - node.z).abs()) < 1e-10);
        }
    }
}
