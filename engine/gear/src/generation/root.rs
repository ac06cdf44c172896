//! The curve between involute and root circle, for any tool.

use super::{
    Polar,
    arc::RootArc,
    rack::{RackFillet, RackTool, STANDARD_TIP_RADIUS},
};
use crate::{Gear, Side, involute::Flank};

/// The root of a tooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Root {
    /// External gears: the fillet that a rack's tip leaves.
    Rack(RackFillet),
    /// Internal gears: an arc.
    Arc(RootArc),
    /// External gears whose root circle no rack with these flanks reaches: the involute down to the
    /// root circle, or to the base circle and radially from there.
    Plain {
        /// Roll length where the involute ends, mm.
        form_roll: f64,
        /// Radius of the root circle, mm.
        radius: f64,
        /// Angle of the flank at its lower end from the tooth's middle, rad.
        half_angle: f64,
    },
}

impl Root {
    /// The root that follows from a gear's data.
    pub fn of(gear: &Gear) -> Self {
        if gear.data().internal {
            let standard = STANDARD_TIP_RADIUS * gear.data().normal_module;
            return Root::Arc(RootArc::new(gear, gear.data().tool.map_or(standard, |tool| tool.tip_radius)));
        }
        match RackTool::of(gear) {
            Some(tool) => Root::Rack(RackFillet::new(gear, tool)),
            None => {
                let form_roll = gear.roll_length(2.0 * gear.root_radius()).unwrap_or(0.0);
                let half_angle = Flank::new(gear, Side::Left).half_angle(form_roll);
                Root::Plain { form_roll, radius: gear.root_radius(), half_angle }
            }
        }
    }

    /// The roll length at which the involute really starts, mm.
    pub fn form_roll(&self) -> f64 {
        match self {
            Root::Rack(fillet) => fillet.form_roll(),
            Root::Arc(arc) => arc.form_roll,
            Root::Plain { form_roll, .. } => *form_roll,
        }
    }

    /// The rack's fillet, where there is one.
    pub fn rack(&self) -> Option<&RackFillet> {
        match self {
            Root::Rack(fillet) => Some(fillet),
            Root::Arc(_) | Root::Plain { .. } => None,
        }
    }

    /// The root circle that is really there, mm: what the tool cuts, else the one in the gear's
    /// data.
    pub fn root_radius(&self, gear: &Gear) -> f64 {
        self.rack().map_or(gear.root_radius(), RackFillet::root_radius)
    }

    /// About `count` + 1 points of the left flank from the root circle to where the involute
    /// starts, external gears not above the radius `most`.
    pub fn points(&self, count: usize, most: f64, gear: &Gear) -> Vec<Polar> {
        match self {
            Root::Rack(fillet) => fillet.points(gear, count, most),
            Root::Arc(arc) => arc.points(count),
            Root::Plain { form_roll, radius, half_angle } => {
                let form = 0.5 * gear.diameter(*form_roll);
                let foot = Polar { radius: *radius, half_angle: *half_angle };
                if form > *radius { vec![foot, Polar { radius: form, ..foot }] } else { vec![foot] }
            }
        }
    }
}
