//! A topography that is given as deviations from the unmodified involute, on a grid of roll lengths
//! and axial positions; like a measured point's, they get the relief of the reference added.
//!
//! Faults point into the object that holds `roll_length_mm`, `z_mm` and `deviation_um`.

use super::{Deviations, Direction, Node, Reference, measure::no_tooth};
use crate::{
    estimation::Faults,
    fault::words::{Shown, counted, entries},
    gear::{Side, trace::MOST_DEVIATION},
};

/// Deviations at the crossings of two strictly ascending axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// From 1, clockwise.
    pub tooth: u32,
    pub side: Side,
    /// mm, root to tip on external gears; a list of diameters goes through
    /// [`crate::gear::Gear::roll_length`].
    pub roll_length: Vec<f64>,
    /// mm.
    pub z: Vec<f64>,
    /// µm, one row for each roll length; NaN where undefined.
    pub deviation: Vec<Vec<f64>>,
    pub direction: Direction,
}

/// The topography as nodes, row by row.
pub fn grid(reference: &Reference, topography: &Topography) -> Result<Deviations, Faults> {
    let Topography { tooth, side, roll_length, z, deviation, direction } = topography;
    let mut faults = Faults::default();
    let teeth = reference.gear.data().teeth;
    if !(1..=teeth).contains(tooth) {
        faults.push("/tooth", no_tooth(*tooth, teeth));
    }
    check_axis(&mut faults, "/roll_length_mm", roll_length);
    check_axis(&mut faults, "/z_mm", z);
    if let Some(least) = roll_length.first().filter(|least| **least < 0.0) {
        faults.push("/roll_length_mm/0", format!("{} mm is below 0, the start of the involute", Shown(*least)));
    }
    if deviation.len() != roll_length.len() {
        let detail = format!(
            "{}, but {} would match roll_length_mm",
            counted(deviation.len(), "row", "rows"),
            roll_length.len()
        );
        faults.push("/deviation_um", detail);
    }
    for (i, row) in deviation.iter().enumerate() {
        if row.len() != z.len() {
            let detail = format!("{}, but {} would match z_mm", entries(row.len()), z.len());
            faults.push(format!("/deviation_um/{i}"), detail);
        }
        for (j, value) in row.iter().enumerate().filter(|(_, value)| value.abs() > MOST_DEVIATION) {
            let detail = format!("{} is beyond {} µm", Shown(*value), Shown(MOST_DEVIATION));
            faults.push(format!("/deviation_um/{i}/{j}"), detail);
        }
    }
    faults.into_result(())?;
    let factor = direction.from_normal(reference.gear);
    let relief = |roll_length: f64, z: f64| reference.relief(*side, roll_length, z) * factor;
    let relief = &relief;
    let nodes = roll_length
        .iter()
        .zip(deviation)
        .flat_map(|(&roll_length, row)| {
            z.iter().zip(row).map(move |(&z, &deviation)| Node {
                tooth: *tooth,
                side: *side,
                roll_length,
                z,
                deviation: deviation + relief(roll_length, z),
                within: true,
            })
        })
        .collect();
    Ok(Deviations { direction: *direction, ball_radius: 0.0, nodes, strays: Vec::new() })
}

fn check_axis(faults: &mut Faults, pointer: &str, axis: &[f64]) {
    if axis.is_empty() {
        faults.push(pointer, "the axis has no positions");
    }
    for (i, x) in axis.iter().enumerate() {
        if !x.is_finite() {
            faults.push(format!("{pointer}/{i}"), "the number is not finite in double precision");
        } else if i > 0 && *x <= axis[i - 1] {
            let detail = format!("{} does not ascend: it follows {}", Shown(*x), Shown(axis[i - 1]));
            faults.push(format!("{pointer}/{i}"), detail);
        }
    }
}
