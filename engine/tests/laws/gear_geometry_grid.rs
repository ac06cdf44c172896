//! Laws of node grids and of modifications.

use flankfit_engine::gear::{
    FlankGrid, Gear, GearData, Geometry, GridSpec, Modifications, ProfileAxis, Side,
    flank_grid::{GridWarning, MOST_NODES},
    involute::Flank,
    modification::{End, Flanks, Growth, Interpolation, Law, Modification, Range, Topography},
};
use proptest::prelude::*;

use super::gear_geometry::{any_gear, data, miss, side_of};

fn spec(side: Side, values: Vec<f64>, positions: Vec<f64>) -> GridSpec {
    GridSpec { side, axis: ProfileAxis::RollLength, values, positions, tooth: 1 }
}

fn both(law: Law) -> Modification {
    Modification { flanks: Flanks::Both, law }
}

fn gear() -> Gear {
    Gear::new(data(40, 2.0, 20.0, 15.0)).unwrap()
}

/// One of every kind, about as large as real ones.
fn laws(gear: &Gear, range: &Range) -> Vec<Modification> {
    let [root, tip] = range.profile();
    let at = |share: f64| gear.diameter(root + share * (tip - root));
    let rolls = {
        let mut rolls = vec![root, root + 0.3 * (tip - root), root + 0.6 * (tip - root), tip];
        rolls.sort_by(f64::total_cmp);
        rolls
    };
    let relief: Vec<Vec<f64>> =
        (0..4).map(|i| (0..5).map(|j| f64::from(i * i - j + 2 * (i * j % 3))).collect()).collect();
    let [low, high] = range.helix();
    let positions: Vec<f64> = (0..5).map(|j| low + (high - low) * f64::from(j) / 4.0).collect();
    let topography = |interpolation| Topography::new(&rolls, &positions, &relief, interpolation).unwrap();
    vec![
        both(Law::ProfileCrowning { amount: 7.0 }),
        both(Law::ProfileSlope { amount: -5.0 }),
        both(Law::TipRelief { amount: 30.0, start_diameter: at(0.7), growth: Growth::Parabolic }),
        both(Law::RootRelief { amount: 20.0, start_diameter: at(0.2), growth: Growth::Linear }),
        both(Law::HelixCrowning { amount: 9.0 }),
        both(Law::HelixSlope { amount: 6.0 }),
        both(Law::EndRelief { end: End::Low, amount: 15.0, length: 0.2 * (high - low), growth: Growth::Linear }),
        both(Law::EndRelief { end: End::High, amount: 12.0, length: 0.3 * (high - low), growth: Growth::Parabolic }),
        both(Law::Twist { amount: 10.0 }),
        both(Law::Topography(topography(Interpolation::BSpline))),
        both(Law::Topography(topography(Interpolation::Bilinear))),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn nodes_are_the_places_of_the_helicoid(gear in any_gear(), left: bool, tooth in 1u32..12) {
        let side = side_of(left);
        let base = gear.base_radius();
        let values: Vec<f64> = (0..7).map(|k| f64::from(k) * 0.2 * base).collect();
        let positions: Vec<f64> = (0..5).map(|k| -17.0 + 9.0 * f64::from(k)).collect();
        let grid = FlankGrid::new(&gear, &GridSpec { tooth, ..spec(side, values.clone(), positions.clone()) },
            None).unwrap();
        let flank = Flank::new(&gear, side);
        let (sin, cos) = (-f64::from(tooth - 1) * std::f64::consts::TAU / gear.teeth()).sin_cos();
        for (k, (point, normal)) in grid.points.iter().zip(&grid.normals).enumerate() {
            let (roll, z) = (values[k / positions.len()], positions[k % positions.len()]);
            let radius = base.hypot(roll);
            prop_assert!(miss(&gear, point, normal).abs() < 1e-14 * radius + 1e-14);
            prop_assert!((normal.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs() < 1e-15);
            let place = flank.at(roll, z);
            let turned = [place.point.x * cos - place.point.y * sin, place.point.x * sin + place.point.y * cos];
            prop_assert!((point[0] - turned[0]).hypot(point[1] - turned[1]) < 4e-15 * radius + 1e-14);
            prop_assert_eq!(point[2], z);
        }
    }

    #[test]
    fn normals_of_a_modified_flank_are_orthogonal_to_it(gear in any_gear(), left: bool, p in 0.05..0.95f64,
        q in 0.05..0.95f64) {
        let Some(range) = Range::whole(&gear) else { return Ok(()) };
        let [root, tip] = range.profile();
        let laws = laws(&gear, &range);
        let modifications = Modifications::new(&gear, range, laws).unwrap();
        let (roll, z) = (root + p * (tip - root), 20.0 * q);
        let h = 1e-4 * (tip - root).abs();
        let spec = spec(side_of(left), vec![roll - h, roll, roll + h], vec![z - h, z, z + h]);
        let grid = FlankGrid::new(&gear, &spec, Some(&modifications)).unwrap();
        let difference = |a: usize, b: usize| [0, 1, 2].map(|c| (grid.points[b][c] - grid.points[a][c]) / (2.0 * h));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let normal = grid.normals[4];
        prop_assert!((dot(normal, normal) - 1.0).abs() < 1e-14);
        // A kink within the step leaves half a step of slope.
        let kink = |places: &[f64], x: f64| places.iter().any(|place| (place - x).abs() <= h);
        let breaks: Vec<f64> = [0.2, 0.3, 0.6, 0.7].iter().map(|s| root + s * (tip - root)).collect();
        if !kink(&breaks, roll) && !kink(&[4.0, 5.0, 10.0, 14.0, 15.0], z) {
            for tangent in [difference(1, 7), difference(3, 5)] {
                let length = dot(tangent, tangent).sqrt();
                prop_assert!(dot(normal, tangent).abs() < 1e-7 * length + 1e-9, "{} of {length}", dot(normal, tangent));
            }
        }
        // It points out of the material.
        let nominal = FlankGrid::new(&gear, &spec, None).unwrap();
        prop_assert!(dot(normal, nominal.normals[4]) > 0.0);
        // And points have moved by the relief along it.
        let relief = 1e-3 * modifications.relief(side_of(left), roll, z).value;
        let moved = [0, 1, 2].map(|c| nominal.points[4][c] - relief * nominal.normals[4][c] - grid.points[4][c]);
        prop_assert!(dot(moved, moved).sqrt() < 1e-13 * gear.diameter(roll));
    }

    #[test]
    fn modifications_superpose(gear in any_gear(), p in -0.1..1.1f64, q in -0.1..1.1f64) {
        let Some(range) = Range::whole(&gear) else { return Ok(()) };
        let [root, tip] = range.profile();
        let (roll, z) = ((root + p * (tip - root)).max(0.0), 20.0 * q);
        let all = laws(&gear, &range);
        let sum: f64 = all.iter().map(|one| {
            Modifications::new(&gear, range, vec![one.clone()]).unwrap().relief(Side::Left, roll, z).value
        }).sum();
        let together = Modifications::new(&gear, range, all).unwrap();
        prop_assert!((together.relief(Side::Left, roll, z).value - sum).abs() < 1e-11);
        let h = 1e-6;
        let at = |roll, z| together.relief(Side::Right, roll, z);
        let jet = at(roll, z);
        // One-sided slopes at a kink: one of the two differences agrees.
        let near = |d: f64, slope: f64| (d - slope).abs() < 1e-3 * (1.0 + slope.abs());
        let agrees = |slope: f64, up: f64, down: f64| near(up, slope) || near(down, slope);
        prop_assert!(agrees(jet.by_roll, (at(roll + h, z).value - jet.value) / h,
            (jet.value - at(roll - h, z).value) / h));
        prop_assert!(agrees(jet.by_z, (at(roll, z + h).value - jet.value) / h,
            (jet.value - at(roll, z - h).value) / h));
    }

    #[test]
    fn axes_say_the_same(gear in any_gear(), share in 0.01..0.5f64) {
        let roll = share * gear.base_radius();
        let of = |axis, value| FlankGrid::new(&gear, &GridSpec { axis, ..spec(Side::Right, vec![value], vec![3.0]) },
            None).unwrap().points[0];
        let [a, b, c] = [
            of(ProfileAxis::RollLength, roll),
            of(ProfileAxis::RollAngle, roll / gear.base_radius()),
            of(ProfileAxis::Diameter, gear.diameter(roll)),
        ];
        for k in 0..3 {
            prop_assert!((a[k] - b[k]).abs() < 1e-14 * gear.diameter(roll));
            // From a diameter near the base circle a roll length has fewer digits.
            prop_assert!((a[k] - c[k]).abs() < 1e-14 * gear.diameter(roll) / share);
        }
    }
}

/// Relief at the corners and the middle of the range, as the table of the module says.
#[test]
fn signs_and_amounts() {
    let gear = gear();
    let range = Range::whole(&gear).unwrap();
    let [root, tip] = range.profile();
    let middle = 0.5 * (root + tip);
    let at = |law: Law| {
        let modifications = Modifications::new(&gear, range, vec![both(law)]).unwrap();
        let value = |roll, z| modifications.relief(Side::Left, roll, z).value;
        [value(root, 0.0), value(root, 20.0), value(tip, 0.0), value(tip, 20.0), value(middle, 10.0)]
    };
    let start = gear.diameter(middle);
    let (amount, growth) = (10.0, Growth::Linear);
    let cases = [
        (Law::ProfileCrowning { amount }, [10.0, 10.0, 10.0, 10.0, 0.0]),
        (Law::ProfileSlope { amount }, [-5.0, -5.0, 5.0, 5.0, 0.0]),
        (Law::TipRelief { amount, start_diameter: start, growth }, [0.0, 0.0, 10.0, 10.0, 0.0]),
        (Law::RootRelief { amount, start_diameter: start, growth }, [10.0, 10.0, 0.0, 0.0, 0.0]),
        (Law::HelixCrowning { amount }, [10.0, 10.0, 10.0, 10.0, 0.0]),
        (Law::HelixSlope { amount }, [-5.0, 5.0, -5.0, 5.0, 0.0]),
        (Law::EndRelief { end: End::Low, amount, length: 5.0, growth }, [10.0, 0.0, 10.0, 0.0, 0.0]),
        (Law::EndRelief { end: End::High, amount, length: 5.0, growth }, [0.0, 10.0, 0.0, 10.0, 0.0]),
        (Law::Twist { amount }, [2.5, -2.5, -2.5, 2.5, 0.0]),
    ];
    for (law, wanted) in cases {
        let found = at(law.clone());
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{law:?}: {found:?}");
    }
    let half = gear.diameter(0.5 * (middle + tip));
    for (growth, share) in [(Growth::Linear, 0.5), (Growth::Parabolic, 0.25)] {
        let law = Law::TipRelief { amount, start_diameter: start, growth };
        let modifications = Modifications::new(&gear, range, vec![both(law)]).unwrap();
        let found = modifications.relief(Side::Left, gear.roll_length(half).unwrap(), 3.0).value;
        assert!((found - 10.0 * share).abs() < 1e-9);
    }
}

#[test]
fn one_flank_alone_is_modified() {
    let gear = gear();
    let range = Range::whole(&gear).unwrap();
    let only = Modification { flanks: Flanks::Left, law: Law::ProfileCrowning { amount: 5.0 } };
    let modifications = Modifications::new(&gear, range, vec![only]).unwrap();
    assert!(modifications.is_none_on(Side::Right) && !modifications.is_none_on(Side::Left));
    assert_eq!(modifications.relief(Side::Right, range.profile()[0], 0.0).value, 0.0);
    let spec = spec(Side::Right, vec![10.0, 12.0], vec![0.0]);
    assert_eq!(FlankGrid::new(&gear, &spec, Some(&modifications)), FlankGrid::new(&gear, &spec, None));
}

#[test]
fn a_topography_interpolates_its_nodes_and_is_constant_outside() {
    let gear = gear();
    let range = Range::whole(&gear).unwrap();
    let (rolls, z) = ([10.0, 11.0, 13.0, 14.0], [0.0, 4.0, 9.0, 15.0, 20.0]);
    let relief: Vec<Vec<f64>> = (0..4).map(|i| (0..5).map(|j| f64::from(3 * i - j * j)).collect()).collect();
    for interpolation in [Interpolation::Bilinear, Interpolation::BSpline] {
        let topography = Topography::new(&rolls, &z, &relief, interpolation).unwrap();
        let modifications = Modifications::new(&gear, range, vec![both(Law::Topography(topography))]).unwrap();
        for (i, roll) in rolls.iter().enumerate() {
            for (j, z) in z.iter().enumerate() {
                assert!((modifications.relief(Side::Left, *roll, *z).value - relief[i][j]).abs() < 1e-11);
            }
        }
        let beyond = modifications.relief(Side::Left, 99.0, -5.0);
        assert!((beyond.value - relief[3][0]).abs() < 1e-11 && beyond.by_roll == 0.0 && beyond.by_z == 0.0);
    }
    // Bilinear in the middle of a cell.
    let topography = Topography::new(&rolls, &z, &relief, Interpolation::Bilinear).unwrap();
    let modifications = Modifications::new(&gear, range, vec![both(Law::Topography(topography))]).unwrap();
    let mean = 0.25 * (relief[1][1] + relief[1][2] + relief[2][1] + relief[2][2]);
    assert!((modifications.relief(Side::Right, 12.0, 6.5).value - mean).abs() < 1e-12);
    // A single column is the same at every z.
    let column: Vec<Vec<f64>> = relief.iter().map(|row| vec![row[2]]).collect();
    let topography = Topography::new(&rolls, &[7.0], &column, Interpolation::BSpline).unwrap();
    let modifications = Modifications::new(&gear, range, vec![both(Law::Topography(topography))]).unwrap();
    for z in [-3.0, 7.0, 30.0] {
        assert!((modifications.relief(Side::Left, 13.0, z).value - relief[2][2]).abs() < 1e-12);
    }
}

#[test]
fn errors_have_the_path_of_their_field() {
    let gear = gear();
    let base = 2.0 * gear.base_radius();
    let paths = |spec: &GridSpec| -> Vec<String> {
        FlankGrid::new(&gear, spec, None).unwrap_err().list().iter().map(|fault| fault.path.clone()).collect()
    };
    let good = spec(Side::Left, vec![10.0, 12.0], vec![0.0, 5.0]);
    assert_eq!(paths(&GridSpec { values: vec![10.0, 11.0, 12.0, -1.0], ..good.clone() }), ["profile.values[3]"]);
    let below = GridSpec { axis: ProfileAxis::Diameter, values: vec![base + 1.0, base - 1.0], ..good.clone() };
    assert_eq!(paths(&below), ["profile.values[1]"]);
    assert_eq!(paths(&GridSpec { positions: vec![f64::NAN], ..good.clone() }), ["face_width_positions_mm[0]"]);
    assert_eq!(paths(&GridSpec { values: vec![], ..good.clone() }), ["profile.values"]);
    assert_eq!(paths(&GridSpec { tooth: 41, ..good.clone() }), ["tooth"]);
    let many = GridSpec { values: vec![10.0; MOST_NODES / 2], positions: vec![0.0; 3], ..good };
    assert_eq!(paths(&many), ["profile.values"]);

    let range = Range::whole(&gear).unwrap();
    let refused = |laws: Vec<Law>| -> Vec<String> {
        let list = laws.into_iter().map(both).collect();
        let faults = Modifications::new(&gear, range, list).unwrap_err();
        faults.list().iter().map(|fault| fault.path.clone()).collect()
    };
    let growth = Growth::Linear;
    let tip = gear.diameter(range.profile()[1]);
    assert_eq!(
        refused(vec![
            Law::TipRelief { amount: 5.0, start_diameter: 1.0, growth },
            Law::ProfileCrowning { amount: f64::INFINITY },
            Law::RootRelief { amount: 5.0, start_diameter: 500.0, growth },
            Law::EndRelief { end: End::Low, amount: 1.0, length: 21.0, growth },
            Law::TipRelief { amount: 5.0, start_diameter: tip, growth },
        ]),
        ["[0].start_diameter_mm", "[1].amount_um", "[2].start_diameter_mm", "[3].length_mm", "[4].start_diameter_mm"]
    );
    let faults = Range::new(&gear, [1.0, 82.0], [3.0, 3.0]).unwrap_err();
    let found: Vec<&str> = faults.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(found, ["profile_diameter_range_mm[0]", "helix_range_mm"]);
    let ragged = Topography::new(&[10.0, 9.0], &[0.0, 1.0], &[vec![1.0, 2.0], vec![1.0]], Interpolation::Bilinear);
    let ragged = ragged.unwrap_err();
    let found: Vec<&str> = ragged.list().iter().map(|fault| &*fault.path).collect();
    assert_eq!(found, ["profile.values[1]", "relief_um[1]"]);
}

#[test]
fn a_grid_that_leaves_the_flank_is_warned_of() {
    let gear = Gear::new(GearData { face_width: Some(10.0), ..data(40, 2.0, 20.0, 15.0) }).unwrap();
    let geometry = Geometry::of(&gear);
    let (form, tip) = (geometry.form_roll_length_mm, geometry.tip_form_roll_length_mm);
    let grid = |values: Vec<f64>, positions| FlankGrid::new(&gear, &spec(Side::Left, values, positions), None).unwrap();
    assert!(grid(vec![form, tip], vec![0.0, 10.0]).warnings.is_empty());
    let found = grid(vec![0.5 * form, form, tip, tip + 1.0, tip + 2.0], vec![-6.0, 6.0]).warnings;
    let codes: Vec<&str> = found.iter().map(GridWarning::code).collect();
    assert_eq!(codes, ["above_tip", "below_form_diameter", "outside_face_width"]);
    assert!(matches!(found[0], GridWarning::AboveTip { first: 3, count: 2, .. }));
    assert!(matches!(found[1], GridWarning::BelowForm { first: 0, count: 1, .. }));
}

/// The number of threads does not enter.
#[test]
fn large_grids_are_the_same_node_by_node() {
    let gear = gear();
    let values: Vec<f64> = (0..300).map(|k| 5.0 + 0.04 * f64::from(k)).collect();
    let positions: Vec<f64> = (0..90).map(|k| 0.2 * f64::from(k)).collect();
    let modifications =
        Modifications::new(&gear, Range::whole(&gear).unwrap(), laws(&gear, &Range::whole(&gear).unwrap())).unwrap();
    let large =
        FlankGrid::new(&gear, &spec(Side::Left, values.clone(), positions.clone()), Some(&modifications)).unwrap();
    for (i, j) in [(0, 0), (17, 80), (299, 89), (150, 1)] {
        let one = FlankGrid::new(&gear, &spec(Side::Left, vec![values[i]], vec![positions[j]]), Some(&modifications))
            .unwrap();
        let k = i * large.columns() + j;
        assert_eq!((one.points[0], one.normals[0]), (large.points[k], large.normals[k]));
    }
}
