//! Warnings about a registration or a correction: data, with a stable code and a sentence.

use std::fmt;

use super::{deviation::NoFoot, registration::Motion};
use flankfit_numerics::{
    warnings,
    words::{Shown, counted, listed},
};

warnings! {
/// Something that the reader of a registration or of a correction must know.
pub enum Warning {
    /// A registration that did not converge.
    #[error("the motions still changed after {iterations} iterations")]
    "registration_not_converged" => RegistrationNotConverged { iterations: usize },
    /// Rotation and axial shift of a helical gear, which are one motion.
    #[error(
        "rotation and axial_shift: a screw motion maps the flanks of a helical gear to themselves, and these points \
         do not distinguish the two. Positions along z (`z_mm`) depend on how their joint effect is split: all of \
         it counts as rotation, the axial shift is 0, and neither has a standard error"
    )]
    "motions_indistinguishable" => ScrewUndetermined,
    /// The axial shift of a spur gear.
    #[error(
        "axial_shift: the flanks of a spur gear are the same along the axis, and these points do not determine it; it \
         is 0"
    )]
    "motions_indistinguishable" => AxialShiftUndetermined,
    /// Motions that depend on each other over the points.
    #[error(
        "{}: these points do not distinguish them; their joint effect is split by minimum norm, and none has a \
         standard error", listed(.motions.iter().map(|motion| motion.name()))
    )]
    "motions_indistinguishable" => MotionsIndistinguishable { motions: Vec<Motion> },
    /// An axial shift that modifications alone tell, µm.
    #[error(
        "axial_shift: {} µm are determined only by modifications that change along z; deviations of the same shape \
         have the same effect. Omit it from the motions to get `z_mm` without it", tenth(*.shift_um)
    )]
    "axial_shift_by_modification" => AxialShiftByModification { shift_um: f64 },
    /// An axial shift that takes up a rotation.
    #[error(
        "axial_shift: {} µm have the same effect on the flanks of this helical gear as a rotation by {} µrad, and \
         rotation is not free: free it, alone or with the axial shift, if the part may be turned", tenth(*.shift_um),
        whole(*.rotation_urad)
    )]
    "axial_shift_for_rotation" => AxialShiftForRotation { shift_um: f64, rotation_urad: f64 },
    /// Nodes without a place on the flank.
    #[error(
        "{} no place on the flank after the registration and are undefined; the first is {first}: {reason}",
        counted(*.count, "node has", "nodes have")
    )]
    "nodes_lost" => NodesLost {
        /// How many.
        count: usize,
        /// The first of them, from 0.
        first: usize,
        /// Why it has none.
        #[cfg_attr(feature = "contract", serde(skip))]
        reason: NoFoot,
    },
    /// A rotation that is determined up to whole pitches of so many µrad.
    #[error(
        "no point names its tooth, and a gear turned by whole pitches ({} µrad) looks the same: the rotation nearest \
         to 0 is returned", whole(*.pitch_urad)
    )]
    "rotation_modulo_pitch" => RotationModuloPitch { pitch_urad: f64 },
    /// So many points on other teeth than they are said to be of.
    #[error(
        "{} on another, while most others lie on their own; `tooth` has the actual one: see `teeth`",
        counted(*.count, "point said to be of one tooth lies", "points said to be of one tooth lie")
    )]
    "teeth_contradict" => TeethContradict { count: usize },
    /// Points that fit other flanks about as well.
    #[error(
        "the points fit other flanks about as well, with another motion; the smaller motion is returned. Give the \
         flank of each point"
    )]
    "flanks_ambiguous" => FlanksAmbiguous,
    /// So many points on other flanks than were nearest before.
    #[error(
        "{} to another flank than the one that was nearest before the registration",
        counted(*.count, "point belongs", "points belong")
    )]
    "flanks_reassigned" => FlanksReassigned { count: usize },
    /// Deviations greater than those of any flank.
    #[error(
        "after the registration {} µm (rms) remain, more than any flank deviates ({} µm): check motions, flanks and \
         gear", tenth(*.rms_um), tenth(*.limit_um)
    )]
    "poor_fit" => PoorFit { rms_um: f64, limit_um: f64 },
    /// Points far from where the others fit.
    #[error(
        "{} far from the fit to the others; the first is {first}, with {} µm: check for dirt, another flank, or a \
         measurement error", counted(*.count, "point lies", "points lie"), tenth(*.deviation_um)
    )]
    "points_misfit" => PointsMisfit {
        /// How many.
        count: usize,
        /// The first of them, from 0.
        first: usize,
        /// Its deviation.
        deviation_um: f64,
    },
    /// So many points outside the tip or the root circle.
    #[error(
        "{} outside the tip or the root circle, where there is no flank", counted(*.count, "point lies", "points lie")
    )]
    "points_outside_flank" => PointsOutsideFlank { count: usize },
    /// A correction whose active set did not settle.
    #[error(
        "the set of settings at their limits did not converge: the best point within the limits is returned"
    )]
    "limits_not_settled" => LimitsNotSettled,
    /// Settings that were stopped at their limits.
    #[error(
        "{} would exceed their limits; the other settings compensate as far as possible", quoted(.settings)
    )]
    "settings_limited" => SettingsLimited { settings: Vec<String> },
    /// Settings that the deviations say nothing about.
    #[error(
        "{}: {}; it is not changed", quoted(.settings), .common.map_or_else(
            || "at these nodes it has no independent effect".to_owned(),
            |common| format!(
                "it would change {common} nearly equally, and deviations without a datum do not show the common part \
                 of {common}"
            )
        )
    )]
    "undetermined_settings" => UndeterminedSettings {
        /// Which settings.
        settings: Vec<String>,
        /// The nodes that they would change alike; `None` for settings without an effect of their
        /// own at the nodes.
        #[cfg_attr(feature = "contract", serde(skip))]
        common: Option<Common>,
    },
    /// Those of them that their limits move all the same.
    #[error(
        "{}: the deviations do not determine it, but its limits require a change; it is changed only as far as they \
         require", quoted(.settings)
    )]
    "undetermined_settings_moved" => UndeterminedSettingsMoved { settings: Vec<String> },
    /// Those of them whose limits were not needed.
    #[error(
        "{}: the deviations do not determine it, so its limits and its increment were not used", quoted(.settings)
    )]
    "limits_without_effect" => LimitsWithoutEffect { settings: Vec<String> },
    /// Plain least squares of settings that nearly depend on each other, as this sentence says.
    #[error(
        "plain least squares amplifies effects that the sensitivity hardly determines ({0}): repeated corrections of \
         this kind can diverge"
    )]
    #[cfg_attr(feature = "contract", serde(skip))]
    "undamped_correction" => UndampedCorrection(String),
    /// Settings that depend on each other exactly.
    #[error(
        "some settings are exactly dependent at these nodes: the smallest changes with the same effect are returned"
    )]
    "dependent_settings" => DependentSettings,
}
}

/// The nodes whose common deviation is not determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Common {
    /// All of the flank.
    Nodes,
    /// All of a trace.
    NodesOfTrace,
    /// All of one of several flanks.
    NodesOfFlank,
}

impl fmt::Display for Common {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Common::Nodes => "all nodes",
            Common::NodesOfTrace => "all nodes of a trace",
            Common::NodesOfFlank => "all nodes of a flank",
        })
    }
}

/// Rounded to a tenth.
pub(crate) fn tenth(x: f64) -> Shown {
    Shown((x * 10.0).round() / 10.0)
}

fn whole(x: f64) -> Shown {
    Shown(x.round())
}

/// Names of settings in a row.
fn quoted(names: &[String]) -> impl fmt::Display {
    listed(names.iter().map(|name| format!("`{name}`")))
}
