//! Computes changes of a grinding machine's settings from deviations of a flank.
//!
//! Run: `cargo run -p flankfit-engine --example correct_machine`

use std::error::Error;

use flankfit_engine::gear::{
    Gear, GearData, Side,
    correction::{
        Correction, CorrectionSpec,
        machine::{FlankNode, Machine, Ranges},
    },
};

fn main() -> Result<(), Box<dyn Error>> {
    let helix_angle = 15_f64.to_radians();
    let gear = Gear::new(GearData { helix_angle, face_width: Some(20.0), ..GearData::spur(52, 1.0) })?;
    let side = Side::Left;
    let nodes: Vec<FlankNode> = (0..9)
        .flat_map(|i| (0..11).map(move |j| (8.5 + 0.25 * f64::from(i), 2.0 * f64::from(j))))
        .map(|(roll_length, z)| FlankNode { side, roll_length, z })
        .collect();
    // The flank leans by 6 µm over its height and by 4 µm over its width.
    let deviation = nodes.iter().map(|node| 6.0 * (node.roll_length - 9.5) / 2.0 + 4.0 * (node.z - 10.0) / 20.0);
    let deviation: Vec<f64> = deviation.collect();

    let ranges = Ranges { profile: [8.5, 10.5], helix: [0.0, 20.0] };
    let known = Machine::GeneratingGrinding.sensitivity(&gear, &nodes, ranges)?;
    let asked =
        CorrectionSpec { noise_sigma: Some(0.3), ..CorrectionSpec::new(deviation, known.matrix, known.settings) };
    let solution = Correction::new(asked)?.solve()?;

    for setting in &solution.settings {
        let error = setting.std_error.map_or("-".into(), |error| format!("{error:.3}"));
        println!("{:22} {:9.3} ± {error} {}", setting.name, setting.change, setting.unit);
    }
    let predicted = &solution.predicted;
    println!("rms {:.2} µm before, {:.2} µm predicted", predicted.rms_before_um, predicted.rms_um);
    for group in &solution.indistinguishable {
        println!("{}", group.sentence);
    }
    Ok(())
}
