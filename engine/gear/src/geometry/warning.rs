//! Warnings about a gear, as data.

use std::fmt;

use super::Geometry;
use crate::{Gear, generation::Root};
use flankfit_numerics::words::Shown;

/// Below this normal thickness (in normal modules) a tip counts as thin.
pub const THIN_TIP: f64 = 0.2;
/// Below this number of teeth ISO 1328-1 says nothing.
pub const FEW_TEETH: u32 = 5;

/// Something a designer should know. Diameters and lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warning {
    /// The tool's tip cuts into the involute.
    Undercut {
        /// Profile shift coefficient x.
        profile_shift: f64,
        /// Smallest x without undercut by this tool.
        least: f64,
        /// Root form diameter, where the involute starts.
        form_diameter: f64,
    },
    /// The protuberance cuts into the involute, as it is meant to where the flank is ground later.
    Protuberance {
        /// Protuberance of the tool.
        protuberance: f64,
        /// Root form diameter, where the involute starts.
        form_diameter: f64,
    },
    /// The flanks meet before the tip circle.
    PointedTip {
        /// Diameter where the flanks meet.
        pointed_diameter: f64,
        /// Tip diameter of the gear.
        tip_diameter: f64,
    },
    /// The tip's normal thickness is below 0.2 m_n.
    ThinTip {
        /// Normal thickness at the tip.
        thickness: f64,
        /// 0.2 m_n.
        least: f64,
    },
    /// The involute would start beyond the tip: no flank is left.
    TipBelowForm {
        /// Tip diameter of the gear.
        tip_diameter: f64,
        /// Root form diameter.
        form_diameter: f64,
    },
    /// An internal tooth reaches below the base circle, where no involute is.
    TipBelowBase {
        /// Tip diameter of the gear.
        tip_diameter: f64,
        /// Diameter of the base circle.
        base_diameter: f64,
    },
    /// The root circle asked for is deeper than the tool cuts.
    RootBelowTool {
        /// Root diameter asked for.
        root_diameter: f64,
        /// Root diameter that the tool cuts.
        generated: f64,
    },
    /// The tool cuts deeper than the root circle asked for.
    RootAboveTool {
        /// Root diameter asked for.
        root_diameter: f64,
        /// Root diameter that the tool cuts.
        generated: f64,
    },
    /// Fewer teeth than the tolerance standard covers.
    FewTeeth {
        /// Teeth of the gear.
        teeth: u32,
    },
    /// No tool is given: a standard rack tool that reaches the root circle is assumed.
    ToolAssumed {
        /// Addendum of the assumed tool.
        addendum: f64,
        /// Tip radius of the assumed tool.
        tip_radius: f64,
    },
    /// No rack with these flanks reaches the root circle: the involute goes straight down, without
    /// a fillet.
    NoFillet {
        /// Root diameter of the gear.
        root_diameter: f64,
    },
    /// A rack cannot cut an internal gear: the root is an arc of this radius in the transverse
    /// section.
    InternalRoot {
        /// Radius of the arc.
        radius: f64,
        /// Protuberance of the tool given, which has no meaning here.
        protuberance: f64,
    },
    /// That arc is smaller than asked, for the space takes no more.
    RootRadius {
        /// Tip radius asked for.
        asked: f64,
        /// Radius of the arc.
        used: f64,
    },
}

impl Warning {
    /// A stable name.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::Undercut { .. } => "undercut",
            Warning::Protuberance { .. } => "protuberance",
            Warning::PointedTip { .. } => "pointed_tip",
            Warning::ThinTip { .. } => "thin_tip",
            Warning::TipBelowForm { .. } => "tip_below_form_diameter",
            Warning::TipBelowBase { .. } => "tip_below_base_circle",
            Warning::RootBelowTool { .. } => "root_below_tool",
            Warning::RootAboveTool { .. } => "root_above_tool",
            Warning::FewTeeth { .. } => "few_teeth",
            Warning::ToolAssumed { .. } => "tool_assumed",
            Warning::NoFillet { .. } => "no_fillet",
            Warning::InternalRoot { .. } => "internal_root",
            Warning::RootRadius { .. } => "root_radius_reduced",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = Shown;
        match *self {
            Warning::Undercut { profile_shift, least, form_diameter } => write!(
                f,
                "undercut: the profile shift coefficient {} is below {}, and the involute starts at {} mm only",
                mm(profile_shift),
                mm(least),
                mm(form_diameter)
            ),
            Warning::Protuberance { protuberance, form_diameter } => write!(
                f,
                "the protuberance of {} mm cuts the involute away below {} mm",
                mm(protuberance),
                mm(form_diameter)
            ),
            Warning::PointedTip { pointed_diameter, tip_diameter } => write!(
                f,
                "the flanks of a tooth meet on {} mm, before the tip diameter of {} mm",
                mm(pointed_diameter),
                mm(tip_diameter)
            ),
            Warning::ThinTip { thickness, least } => {
                write!(f, "the tip is {} mm thick in the normal section, less than {} mm", mm(thickness), mm(least))
            }
            Warning::TipBelowForm { tip_diameter, form_diameter } => write!(
                f,
                "no involute is left: it would start on {} mm, beyond the tip diameter of {} mm",
                mm(form_diameter),
                mm(tip_diameter)
            ),
            Warning::TipBelowBase { tip_diameter, base_diameter } => write!(
                f,
                "the tip diameter of {} mm lies within the base circle of {} mm, where the involute ends",
                mm(tip_diameter),
                mm(base_diameter)
            ),
            Warning::RootBelowTool { root_diameter, generated } => write!(
                f,
                "the tool cuts a root diameter of {} mm and does not reach {} mm",
                mm(generated),
                mm(root_diameter)
            ),
            Warning::RootAboveTool { root_diameter, generated } => write!(
                f,
                "the tool cuts a root diameter of {} mm, deeper than the {} mm asked for",
                mm(generated),
                mm(root_diameter)
            ),
            Warning::FewTeeth { teeth } => {
                write!(f, "{teeth} teeth: ISO 1328-1 has tolerances from {FEW_TEETH} teeth on")
            }
            Warning::ToolAssumed { addendum, tip_radius } => write!(
                f,
                "no tool is given: a rack with an addendum of {} mm and a tip radius of {} mm is assumed",
                mm(addendum),
                mm(tip_radius)
            ),
            Warning::NoFillet { root_diameter } => write!(
                f,
                "no rack with these flanks reaches the root diameter of {} mm: the flank goes down without a fillet",
                mm(root_diameter)
            ),
            Warning::InternalRoot { radius, .. } => write!(
                f,
                "a rack cannot cut an internal gear: its root is taken as an arc of {} mm in the transverse section",
                mm(radius)
            ),
            Warning::RootRadius { asked, used } => {
                write!(f, "the space takes a root arc of {} mm, not of {} mm", mm(used), mm(asked))
            }
        }
    }
}

/// Everything unusual, gravest first.
pub(super) fn of(gear: &Gear, root: &Root, geometry: &Geometry) -> Vec<Warning> {
    let data = gear.data();
    let mut found = Vec::new();
    let form_diameter = geometry.root_form_diameter;
    if geometry.usable.is_none() {
        found.push(Warning::TipBelowForm { tip_diameter: geometry.tip_form_diameter, form_diameter });
    }
    let pointed = geometry.pointed_diameter.filter(|at| gear.outward() * (2.0 * gear.tip_radius() - at) > 0.0);
    let least = THIN_TIP * data.normal_module;
    match pointed {
        Some(at) => found.push(Warning::PointedTip { pointed_diameter: at, tip_diameter: geometry.tip_diameter }),
        None if geometry.tip_thickness.normal < least => {
            found.push(Warning::ThinTip { thickness: geometry.tip_thickness.normal, least });
        }
        None => {}
    }
    if data.internal && gear.tip_radius() < gear.base_radius() {
        let (tip_diameter, base_diameter) = (geometry.tip_diameter, geometry.base_diameter);
        found.push(Warning::TipBelowBase { tip_diameter, base_diameter });
    }
    match root {
        Root::Rack(fillet) => {
            if fillet.undercut() {
                let least = fillet.least_shift(gear);
                found.push(Warning::Undercut { profile_shift: data.profile_shift, least, form_diameter });
            } else if fillet.tool.protuberance > 0.0 {
                found.push(Warning::Protuberance { protuberance: fillet.tool.protuberance, form_diameter });
            }
            let (root_diameter, generated) = (geometry.root_diameter, 2.0 * fillet.root_radius());
            if !fillet.tool.given {
                let (addendum, tip_radius) = (fillet.tool.addendum, fillet.tool.tip_radius);
                found.push(Warning::ToolAssumed { addendum, tip_radius });
            } else if root_diameter < generated - 1e-6 * data.normal_module {
                found.push(Warning::RootBelowTool { root_diameter, generated });
            } else if root_diameter > generated + 1e-6 * data.normal_module {
                found.push(Warning::RootAboveTool { root_diameter, generated });
            }
        }
        Root::Arc(arc) => {
            let protuberance = data.tool.map_or(0.0, |tool| tool.protuberance);
            found.push(Warning::InternalRoot { radius: arc.radius, protuberance });
            if let Some(asked) = data.tool.map(|tool| tool.tip_radius).filter(|asked| arc.radius < *asked) {
                found.push(Warning::RootRadius { asked, used: arc.radius });
            }
        }
        Root::Plain { .. } => found.push(Warning::NoFillet { root_diameter: geometry.root_diameter }),
    }
    if data.teeth < FEW_TEETH {
        found.push(Warning::FewTeeth { teeth: data.teeth });
    }
    found
}
