//! A topography that is given as deviations from the unmodified involute, on a grid of roll lengths
//! and axial positions; like a measured point's, they get the relief of the reference added.

use super::{Deviations, Direction, Node, Reference};
use crate::{Side, trace::MOST_DEVIATION};
use flankfit_numerics::{
    Rows,
    check::{Faults, deviation_exceeds, not_ascending, not_finite},
    words::{Shown, counted, entries},
};

/// Deviations at the crossings of two strictly ascending axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// From 1, clockwise.
    pub tooth: u32,
    /// Flank of the tooth.
    pub side: Side,
    /// mm, root to tip on external gears; a list of diameters goes through
    /// [`crate::Gear::roll_length`].
    pub roll_length: Vec<f64>,
    /// mm.
    pub z: Vec<f64>,
    /// µm, one row for each roll length; NaN where undefined.
    pub deviation: Rows,
    /// Line along which the deviations are taken.
    pub direction: Direction,
}

/// The topography as nodes, row by row.
pub fn grid(reference: &Reference, topography: &Topography) -> Result<Deviations, Faults> {
    let Topography { tooth, side, roll_length, z, deviation, direction } = topography;
    let mut faults = Faults::default();
    if let Some(message) = reference.gear.no_such_tooth(*tooth) {
        faults.push("tooth", message);
    }
    check_axis(&mut faults, "roll_length_mm", roll_length);
    check_axis(&mut faults, "z_mm", z);
    if let Some(least) = roll_length.first().filter(|least| **least < 0.0) {
        let least = Shown(*least);
        faults.push("roll_length_mm[0]", format_args!("{least} mm is below 0, the start of the involute"));
    }
    if deviation.count() != roll_length.len() {
        let (rows, wanted) = (counted(deviation.count(), "row", "rows"), roll_length.len());
        faults.push("deviation_um", format_args!("{rows}, but {wanted} would match roll_length_mm"));
    }
    for (i, row) in deviation.iter().enumerate() {
        if row.len() != z.len() {
            let (given, wanted) = (entries(row.len()), z.len());
            faults.push(format_args!("deviation_um[{i}]"), format_args!("{given}, but {wanted} would match z_mm"));
        }
        for (j, value) in row.iter().enumerate().filter(|(_, value)| value.abs() > MOST_DEVIATION) {
            faults.push(format_args!("deviation_um[{i}][{j}]"), deviation_exceeds(*value, MOST_DEVIATION));
        }
    }
    faults.into_result(())?;
    let factor = direction.from_normal(reference.gear);
    let relief = |roll_length: f64, z: f64| reference.relief(*side, roll_length, z) * factor;
    let relief = &relief;
    let nodes = roll_length
        .iter()
        .zip(deviation.iter())
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

fn check_axis(faults: &mut Faults, path: &str, axis: &[f64]) {
    if axis.is_empty() {
        faults.push(path, "the axis has no positions");
    }
    for (i, x) in axis.iter().enumerate() {
        if !x.is_finite() {
            faults.push(format_args!("{path}[{i}]"), not_finite());
        } else if i > 0 && *x <= axis[i - 1] && axis[i - 1].is_finite() {
            faults.push(format_args!("{path}[{i}]"), not_ascending(*x, axis[i - 1]));
        }
    }
}
