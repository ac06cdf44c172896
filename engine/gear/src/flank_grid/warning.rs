//! Warnings about a grid that exceeds the usable flank.

use crate::{Gear, Geometry};
use flankfit_numerics::{
    warnings,
    words::{Shown, counted},
};

warnings! {
/// A grid that leaves the flank that is really there: the involute itself goes on.
#[derive(Copy)]
pub enum GridWarning {
    /// Profile values from index `first` on lie above the tip form diameter (mm).
    #[error(
        "{}, from number {first} on, outside the tip form diameter of {} mm, where there is no material",
        counted(*.count, "profile value lies", "profile values lie"), Shown(*.diameter)
    )]
    "above_tip" => AboveTip { first: usize, count: usize, diameter: f64 },
    /// They lie below the root form diameter (mm), where fillet or undercut has replaced the
    /// involute.
    #[error(
        "{}, from number {first} on, below the root form diameter of {} mm, where fillet or undercut has replaced the \
         involute", counted(*.count, "profile value lies", "profile values lie"), Shown(*.diameter)
    )]
    "below_form_diameter" => BelowForm { first: usize, count: usize, diameter: f64 },
    /// The places span more than the face width (mm).
    #[error("the places span {} mm, but the face is {} mm wide", Shown(*.span), Shown(*.face_width))]
    "outside_face_width" => OutsideFace { span: f64, face_width: f64 },
}
}

/// Returns warnings about nodes off the flank.
pub(super) fn warnings(gear: &Gear, roll_lengths: &[f64], positions: &[f64]) -> Vec<GridWarning> {
    let geometry = Geometry::of(gear);
    let mut found = Vec::new();
    // Callers round: what lies outside by less than this is on the border.
    let margin = 1e-6 * gear.data().normal_module;
    let outward = gear.outward();
    let beyond = |limit: f64, towards: f64| {
        let mut outside = roll_lengths.iter().enumerate().filter(|(_, roll)| towards * (**roll - limit) > margin);
        outside.next().map(|(first, _)| (first, 1 + outside.count()))
    };
    if let Some((first, count)) = beyond(geometry.tip_form_roll_length_mm, outward) {
        found.push(GridWarning::AboveTip { first, count, diameter: geometry.tip_form_diameter_mm });
    }
    if let Some((first, count)) = beyond(geometry.form_roll_length_mm, -outward) {
        found.push(GridWarning::BelowForm { first, count, diameter: geometry.form_diameter_mm });
    }
    if let Some(face_width) = gear.data().face_width {
        let (low, high) = positions.iter().fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(*z), high.max(*z)));
        if high - low > face_width + margin {
            found.push(GridWarning::OutsideFace { span: high - low, face_width });
        }
    }
    found
}
