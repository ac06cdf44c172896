//! A topography that is given as deviations from the unmodified involute, on a grid of roll lengths
//! and axial positions; like a measured point's, they get the relief of the reference added.

use super::{
    Deviations, Direction, Node, Reference,
    fault::{TopographyFaults, TopographyField, TopographyReason},
};
use crate::{Side, fault::NoSuchTooth, trace::MOST_DEVIATION};
use flankfit_numerics::{Rows, fault::Common};

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
pub fn grid(reference: &Reference, topography: &Topography) -> Result<Deviations, TopographyFaults> {
    let Topography { tooth, side, roll_length, z, deviation, direction } = topography;
    let mut faults = TopographyFaults::default();
    let teeth = reference.gear.data().teeth;
    if !(1..=teeth).contains(tooth) {
        faults.push(TopographyField::Tooth, NoSuchTooth { tooth: *tooth, teeth });
    }
    check_axis(&mut faults, TopographyField::RollLengths, |index| TopographyField::RollLength { index }, roll_length);
    check_axis(&mut faults, TopographyField::Positions, |index| TopographyField::Position { index }, z);
    if let Some(least) = roll_length.first().filter(|least| **least < 0.0) {
        faults.push(TopographyField::RollLength { index: 0 }, TopographyReason::BelowBase(*least));
    }
    if deviation.count() != roll_length.len() {
        let reason = TopographyReason::Rows { rows: deviation.count(), roll_lengths: roll_length.len() };
        faults.push(TopographyField::Deviations, reason);
    }
    for (i, row) in deviation.iter().enumerate() {
        if row.len() != z.len() {
            let reason = TopographyReason::Columns { given: row.len(), positions: z.len() };
            faults.push(TopographyField::Row { row: i }, reason);
        }
        for (j, value) in row.iter().enumerate().filter(|(_, value)| value.abs() > MOST_DEVIATION) {
            let reason = Common::DeviationBeyond { value: *value, most: MOST_DEVIATION };
            faults.push(TopographyField::Deviation { row: i, column: j }, reason);
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

fn check_axis(
    faults: &mut TopographyFaults,
    whole: TopographyField,
    place: fn(usize) -> TopographyField,
    axis: &[f64],
) {
    if axis.is_empty() {
        faults.push(whole, TopographyReason::EmptyAxis);
    }
    for (i, x) in axis.iter().enumerate() {
        if !x.is_finite() {
            faults.push(place(i), Common::NotFinite);
        } else if i > 0 && *x <= axis[i - 1] && axis[i - 1].is_finite() {
            faults.push(place(i), Common::NotAscending { value: *x, before: axis[i - 1] });
        }
    }
}
