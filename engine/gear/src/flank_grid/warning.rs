//! Warnings of a grid that exceeds the usable flank.

use std::fmt;

use crate::{Gear, Geometry};
use flankfit_numerics::words::{Shown, counted};

/// A grid that leaves the flank that is really there: the involute itself goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridWarning {
    /// So many profile values, `first` the first of them, lie above the tip form diameter (mm).
    BeyondTip {
        /// Index of the first of them.
        first: usize,
        /// How many there are.
        count: usize,
        /// Tip form diameter, mm.
        diameter: f64,
    },
    /// They lie below the root form diameter (mm), where fillet or undercut has replaced the
    /// involute.
    BelowForm {
        /// Index of the first of them.
        first: usize,
        /// How many there are.
        count: usize,
        /// Root form diameter, mm.
        diameter: f64,
    },
    /// The places span more than the face width (mm).
    BeyondFace {
        /// Distance of the outermost places.
        span: f64,
        /// Face width of the gear.
        face_width: f64,
    },
}

impl GridWarning {
    /// A stable name.
    pub fn code(&self) -> &'static str {
        match self {
            GridWarning::BeyondTip { .. } => "beyond_tip",
            GridWarning::BelowForm { .. } => "below_form_diameter",
            GridWarning::BeyondFace { .. } => "beyond_face_width",
        }
    }
}

impl fmt::Display for GridWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            GridWarning::BeyondTip { first, count, diameter } => write!(
                f,
                "{}, from number {first} on, beyond the tip form diameter of {} mm: no material is there",
                counted(count, "profile value lies", "profile values lie"),
                Shown(diameter)
            ),
            GridWarning::BelowForm { first, count, diameter } => write!(
                f,
                "{}, from number {first} on, below the root form diameter of {} mm, where fillet or undercut has \
                 replaced the involute",
                counted(count, "profile value lies", "profile values lie"),
                Shown(diameter)
            ),
            GridWarning::BeyondFace { span, face_width } => {
                write!(f, "the places span {} mm, the face is {} mm wide", Shown(span), Shown(face_width))
            }
        }
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
        found.push(GridWarning::BeyondTip { first, count, diameter: geometry.tip_form_diameter_mm });
    }
    if let Some((first, count)) = beyond(geometry.form_roll_length_mm, -outward) {
        found.push(GridWarning::BelowForm { first, count, diameter: geometry.form_diameter_mm });
    }
    if let Some(face_width) = gear.data().face_width {
        let (low, high) = positions.iter().fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(*z), high.max(*z)));
        if high - low > face_width + margin {
            found.push(GridWarning::BeyondFace { span: high - low, face_width });
        }
    }
    found
}
