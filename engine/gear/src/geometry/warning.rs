//! Warnings about a gear, as data.

use super::Geometry;
use crate::{Gear, generation::Root};
use flankfit_numerics::{warnings, words::Shown};

/// Below this normal thickness (in normal modules) a tip counts as thin.
pub const THIN_TIP: f64 = 0.2;
/// Below this number of teeth ISO 1328-1 says nothing.
pub const FEW_TEETH: u32 = 5;

warnings! {
/// Something a designer should know. Diameters and lengths in mm.
#[derive(Copy)]
pub enum Warning {
    /// The tool's tip cuts into the involute.
    #[error(
        "undercut: the profile shift coefficient {} is below {}, and the involute starts at {} mm only",
        Shown(*.profile_shift_coefficient), Shown(*.least_profile_shift_coefficient), Shown(*.form_diameter_mm)
    )]
    "undercut" => Undercut {
        profile_shift_coefficient: f64,
        least_profile_shift_coefficient: f64,
        form_diameter_mm: f64,
    },
    /// The protuberance cuts into the involute, as it is meant to where the flank is ground later.
    #[error(
        "the protuberance of {} mm cuts the involute away below {} mm", Shown(*.protuberance_mm),
        Shown(*.form_diameter_mm)
    )]
    "protuberance" => Protuberance { protuberance_mm: f64, form_diameter_mm: f64 },
    /// The flanks meet before the tip circle.
    #[error(
        "the flanks of a tooth meet on {} mm, before the tip diameter of {} mm", Shown(*.pointed_diameter_mm),
        Shown(*.tip_diameter_mm)
    )]
    "pointed_tip" => PointedTip { pointed_diameter_mm: f64, tip_diameter_mm: f64 },
    /// The tip's normal thickness is below 0.2 m_n.
    #[error("the tip is {} mm thick in the normal section, less than {} mm", Shown(*.thickness_mm), Shown(*.least_mm))]
    "thin_tip" => ThinTip { thickness_mm: f64, least_mm: f64 },
    /// The involute would start above the tip: no flank is left.
    #[error(
        "there is no involute: it would start on {} mm, outside the tip diameter of {} mm", Shown(*.form_diameter_mm),
        Shown(*.tip_diameter_mm)
    )]
    "tip_below_form_diameter" => TipBelowForm { tip_diameter_mm: f64, form_diameter_mm: f64 },
    /// An internal tooth reaches below the base circle, where no involute is.
    #[error(
        "the tip diameter of {} mm lies within the base circle of {} mm, where the involute ends",
        Shown(*.tip_diameter_mm), Shown(*.base_diameter_mm)
    )]
    "tip_below_base_circle" => TipBelowBase { tip_diameter_mm: f64, base_diameter_mm: f64 },
    /// The root circle asked for is deeper than the tool cuts.
    #[error(
        "the tool cuts a root diameter of {} mm and does not reach {} mm", Shown(*.generated_diameter_mm),
        Shown(*.root_diameter_mm)
    )]
    "root_below_tool" => RootBelowTool { root_diameter_mm: f64, generated_diameter_mm: f64 },
    /// The tool cuts deeper than the root circle asked for.
    #[error(
        "the tool cuts a root diameter of {} mm, deeper than the requested {} mm", Shown(*.generated_diameter_mm),
        Shown(*.root_diameter_mm)
    )]
    "root_above_tool" => RootAboveTool { root_diameter_mm: f64, generated_diameter_mm: f64 },
    /// Fewer teeth than the tolerance standard covers.
    #[error("{teeth} teeth: ISO 1328-1 has tolerances from {FEW_TEETH} teeth on")]
    "few_teeth" => FewTeeth { teeth: u32 },
    /// No tool is given: a standard rack tool that reaches the root circle is assumed.
    #[error(
        "no tool is given: a rack with an addendum of {} mm and a tip radius of {} mm is assumed",
        Shown(*.addendum_mm), Shown(*.tip_radius_mm)
    )]
    "tool_assumed" => ToolAssumed { addendum_mm: f64, tip_radius_mm: f64 },
    /// No rack with these flanks reaches the root circle: the involute goes straight down, without
    /// a fillet.
    #[error(
        "no rack with these flanks reaches the root diameter of {} mm: the flank ends without a fillet",
        Shown(*.root_diameter_mm)
    )]
    "no_fillet" => NoFillet { root_diameter_mm: f64 },
    /// A rack cannot cut an internal gear: the root is an arc of this radius in the transverse
    /// section.
    #[error(
        "a rack cannot cut an internal gear: its root is taken as an arc of {} mm in the transverse section",
        Shown(*.radius_mm)
    )]
    "internal_root" => InternalRoot {
        /// Radius of the arc.
        radius_mm: f64,
        /// Protuberance of the tool given, which has no meaning here.
        protuberance_mm: f64,
    },
    /// That arc is smaller than asked, for the space takes no more.
    #[error("the space allows a root arc of {} mm, not of {} mm", Shown(*.used_mm), Shown(*.asked_mm))]
    "root_radius_reduced" => RootRadius { asked_mm: f64, used_mm: f64 },
}
}

/// Everything unusual, gravest first.
pub(super) fn of(gear: &Gear, root: &Root, geometry: &Geometry) -> Vec<Warning> {
    let data = gear.data();
    let mut found = Vec::new();
    let form_diameter_mm = geometry.form_diameter_mm;
    if geometry.usable_profile.is_none() {
        found.push(Warning::TipBelowForm { tip_diameter_mm: geometry.tip_form_diameter_mm, form_diameter_mm });
    }
    let pointed = geometry.pointed_diameter_mm.filter(|at| gear.outward() * (2.0 * gear.tip_radius() - at) > 0.0);
    let least = THIN_TIP * data.normal_module;
    match pointed {
        Some(at) => {
            found.push(Warning::PointedTip { pointed_diameter_mm: at, tip_diameter_mm: geometry.tip_diameter_mm })
        }
        None if geometry.normal_tip_thickness_mm < least => {
            found.push(Warning::ThinTip { thickness_mm: geometry.normal_tip_thickness_mm, least_mm: least });
        }
        None => {}
    }
    if data.internal && gear.tip_radius() < gear.base_radius() {
        let (tip_diameter_mm, base_diameter_mm) = (geometry.tip_diameter_mm, geometry.base_diameter_mm);
        found.push(Warning::TipBelowBase { tip_diameter_mm, base_diameter_mm });
    }
    match root {
        Root::Rack(fillet) => {
            if fillet.undercut() {
                found.push(Warning::Undercut {
                    profile_shift_coefficient: data.profile_shift,
                    least_profile_shift_coefficient: fillet.least_shift(gear),
                    form_diameter_mm,
                });
            } else if fillet.tool.protuberance > 0.0 {
                found.push(Warning::Protuberance { protuberance_mm: fillet.tool.protuberance, form_diameter_mm });
            }
            let (root_diameter_mm, generated_diameter_mm) = (geometry.root_diameter_mm, 2.0 * fillet.root_radius());
            if !fillet.tool.given {
                let (addendum_mm, tip_radius_mm) = (fillet.tool.addendum, fillet.tool.tip_radius);
                found.push(Warning::ToolAssumed { addendum_mm, tip_radius_mm });
            } else if root_diameter_mm < generated_diameter_mm - 1e-6 * data.normal_module {
                found.push(Warning::RootBelowTool { root_diameter_mm, generated_diameter_mm });
            } else if root_diameter_mm > generated_diameter_mm + 1e-6 * data.normal_module {
                found.push(Warning::RootAboveTool { root_diameter_mm, generated_diameter_mm });
            }
        }
        Root::Arc(arc) => {
            let protuberance_mm = data.tool.map_or(0.0, |tool| tool.protuberance);
            found.push(Warning::InternalRoot { radius_mm: arc.radius, protuberance_mm });
            if let Some(asked) = data.tool.map(|tool| tool.tip_radius).filter(|asked| arc.radius < *asked) {
                found.push(Warning::RootRadius { asked_mm: asked, used_mm: arc.radius });
            }
        }
        Root::Plain { .. } => found.push(Warning::NoFillet { root_diameter_mm: geometry.root_diameter_mm }),
    }
    if data.teeth < FEW_TEETH {
        found.push(Warning::FewTeeth { teeth: data.teeth });
    }
    found
}
