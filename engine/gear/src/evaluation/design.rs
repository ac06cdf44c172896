//! The design line of a trace on a modified flank.

use super::settings::Settings;
use crate::{Gear, Kind, Modifications, Trace, trace::Direction};
use flankfit_numerics::cancel::Asking;

/// Deviations of a flank machined as designed along `trace`: µm for each sample, in the sign
/// and direction of its deviations. `None` where the section of the trace is not known, or is no
/// diameter of the involute.
pub fn design(gear: &Gear, modifications: &Modifications, trace: &Trace, settings: &Settings) -> Option<Vec<f64>> {
    if modifications.is_none_on(trace.side) {
        return Some(vec![0.0; trace.at.len()]);
    }
    let section = trace.section?;
    let along = match settings.direction {
        Direction::Normal => 1.0,
        Direction::Transverse => 1.0 / gear.base_helix_angle().cos(),
    };
    // a relief takes material away
    let scale = -along * settings.given.to_material(trace.kind, trace.side);
    let line: Vec<f64> = match trace.kind {
        Kind::Profile => {
            let column = modifications.column(trace.side, section);
            trace
                .at
                .iter()
                .asking(1000)
                .map(|roll| scale * modifications.row(trace.side, *roll).at(&column).value)
                .collect()
        }
        Kind::Helix => {
            let row = modifications.row(trace.side, gear.roll_length(section)?);
            trace.at.iter().asking(1000).map(|z| scale * row.at(&modifications.column(trace.side, *z)).value).collect()
        }
    };
    Some(line)
}
