//! A tooth is loaded by CalculiX: the support takes what the load is, and the deflection has
//! settled.
//!
//! Needs the program `ccx` (Debian: `calculix-ccx`) and is therefore ignored by default; `.ci/run`
//! asks for it by name. Without `ccx` it fails.

use std::{collections::BTreeSet, fs, path::Path, process::Command, sync::Arc};

use flankfit_engine::{
    formats::{Label, UtcTime, solid_mesh},
    gear::{
        Gear, GearData, Hand,
        solid::{Elements, HexMesh, SolidSpec},
    },
};

/// Support at rim and cuts, a force of one newton along −x spread over the nodes of the tip.
struct Answer {
    /// Sums of the forces at the support.
    reaction: [f64; 3],
    /// The tip's mean displacement along −x, mm: where the force does its work.
    deflection: f64,
}

fn solve(folder: &Path, name: &str, gear: &Gear, spec: &SolidSpec) -> Answer {
    let mesh = Arc::new(HexMesh::of_gear(gear, spec).unwrap());
    let label = Label {
        name: name.to_owned(),
        author: String::new(),
        organization: String::new(),
        written_at: UtcTime::epoch(),
    };
    let mut deck = String::from_utf8(solid_mesh::abaqus(&mesh, &label).whole()).unwrap();
    let set = |name: &str| mesh.nodes_of(mesh.sets().iter().find(|set| set.name == name).unwrap());
    let tip = set("TIP");
    let rim = if gear.data().internal { "RIM" } else { "BORE" };
    // a node that is in a set twice would be counted twice
    let fixed: BTreeSet<u32> = [rim, "CUT_LEFT", "CUT_RIGHT"].into_iter().flat_map(set).collect();
    deck += "*NSET, NSET=FIXED\n";
    fixed.iter().for_each(|node| deck += &format!("{},\n", node + 1));
    deck += "*MATERIAL, NAME=STEEL\n*ELASTIC\n206000., 0.3\n*SOLID SECTION, ELSET=GEAR, MATERIAL=STEEL\n";
    deck += "*STEP\n*STATIC\n*BOUNDARY\nFIXED, 1, 3\n*CLOAD\n";
    // numbers have 20 columns at most
    for node in &tip {
        deck += &format!("{}, 1, {:.12e}\n", node + 1, -1.0 / tip.len() as f64);
    }
    deck += "*NODE PRINT, NSET=FIXED, TOTALS=ONLY\nRF\n*NODE PRINT, NSET=N_TIP\nU\n*END STEP\n";
    fs::write(folder.join(format!("{name}.inp")), deck).unwrap();
    let run = Command::new("ccx").arg(name).current_dir(folder).output();
    let run = run.unwrap_or_else(|error| panic!("ccx (Debian: calculix-ccx) is needed: {error}"));
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && !said.contains("*ERROR"), "{said}");
    assert!(!said.contains("nonpositive jacobian"), "{said}");
    let found = fs::read_to_string(folder.join(format!("{name}.dat"))).unwrap();
    let numbers = |line: &str| -> Vec<f64> { line.split_whitespace().filter_map(|word| word.parse().ok()).collect() };
    let after = |head: &str| found.split(head).nth(1).unwrap_or_else(|| panic!("no {head} in {found:.500}"));
    let total = after("total force").lines().skip(1).map(numbers).find(|numbers| numbers.len() == 3).unwrap();
    let moved: Vec<Vec<f64>> = after("displacements")
        .lines()
        .skip(1)
        .map(numbers)
        .skip_while(Vec::is_empty)
        .take_while(|n| n.len() == 4)
        .collect();
    assert_eq!(moved.len(), tip.len());
    let deflection = -moved.iter().map(|row| row[1]).sum::<f64>() / tip.len() as f64;
    Answer { reaction: [total[0], total[1], total[2]], deflection }
}

fn elements(factor: usize) -> Elements {
    let Elements { involute, fillet, root, thickness, rim, width } =
        Elements { involute: 3, fillet: 2, root: 1, thickness: 3, rim: 2, width: 3 };
    Elements {
        involute: involute * factor,
        fillet: fillet * factor,
        root: root * factor,
        thickness: thickness * factor,
        rim: rim * factor,
        width: width * factor,
    }
}

#[test]
#[ignore = "needs CalculiX (Debian: calculix-ccx); .ci/run asks for it"]
fn a_tooth_carries_its_load() {
    let folder = std::env::temp_dir().join(format!("calculix-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let spur = GearData { face_width: Some(12.0), ..GearData::spur(24, 2.5) };
    let helical = GearData { helix_angle: 20_f64.to_radians(), hand: Hand::Left, ..spur.clone() };
    let internal = GearData { internal: true, teeth: 60, ..spur.clone() };
    for (name, data) in [("spur", spur), ("helical", helical), ("internal", internal)] {
        let gear = Gear::new(data).unwrap();
        let mut finest = None;
        for (order, quadratic, factor) in [("fine", true, 2), ("quadratic", true, 1), ("linear", false, 2)] {
            let spec = SolidSpec { quadratic, elements: elements(factor), ..SolidSpec::default() };
            let Answer { reaction, deflection } = solve(&folder, &format!("{name}-{order}"), &gear, &spec);
            let off = (reaction[0] - 1.0).abs().max(reaction[1].abs()).max(reaction[2].abs());
            assert!(off < 1e-6, "{name} {order}: {reaction:?}");
            assert!(deflection > 0.0);
            let fine = *finest.get_or_insert(deflection);
            println!(
                "{name} {order}: {deflection:.6e} mm/N, {:+.2} % of the finest",
                100.0 * (deflection / fine - 1.0)
            );
            assert!((deflection / fine - 1.0).abs() < 0.1, "{name} {order}: {deflection} {fine}");
        }
    }
    fs::remove_dir_all(&folder).unwrap();
}
