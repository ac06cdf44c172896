//! Warnings about a registration or a correction: data, with a stable code and a sentence.

use std::fmt;

use super::{deviation::NoFoot, registration::Motion};
use flankfit_numerics::words::{Shown, counted, listed};

/// Something that the reader of a registration or of a correction must know.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A registration that did not converge.
    #[error("the motions still changed after {0} iterations")]
    RegistrationNotConverged(usize),
    /// Rotation and axial shift of a helical gear, which are one motion.
    #[error(
        "rotation and axial_shift: a screw motion carries the flanks of a helical gear into themselves, and these \
         points do not tell the two apart. Positions along z depend on how their joint effect is split: all of it is \
         taken as rotation, the axial shift is left at 0, and neither has a standard error"
    )]
    ScrewUndetermined,
    /// The axial shift of a spur gear.
    #[error(
        "axial_shift: the flanks of a spur gear are the same along the axis, and these points do not tell it; it is \
         left at 0"
    )]
    AxialShiftUndetermined,
    /// Motions that depend on each other over the points.
    #[error(
        "{}: these points do not tell them apart; their joint effect is shared between them by minimum norm, and none \
         has a standard error", listed(.0.iter().map(|motion| motion.name()))
    )]
    MotionsIndistinguishable(Vec<Motion>),
    /// An axial shift that modifications alone tell, µm.
    #[error(
        "axial_shift: {} µm are determined by the modifications alone, which change along z; deviations of the same shape \
         do the same. Leave it out of the motions to have positions along z without it", tenth(*.0)
    )]
    AxialShiftByModification(f64),
    /// An axial shift that takes up a rotation.
    #[error(
        "axial_shift: {} µm do to the flanks of this helical gear what a rotation by {} µrad does, and rotation is \
         not free: free it, alone or with the axial shift, if the part may be turned", tenth(*.shift), whole(*.rotation)
    )]
    AxialShiftForRotation {
        /// µm.
        shift: f64,
        /// The rotation that does the same, µrad.
        rotation: f64,
    },
    /// Nodes without a place on the flank.
    #[error(
        "{} no place on the flank once carried back and are undefined; the first is {first}: {reason}",
        counted(*.count, "node has", "nodes have")
    )]
    NodesLost {
        /// How many.
        count: usize,
        /// The first of them, from 0.
        first: usize,
        /// Why it has none.
        reason: NoFoot,
    },
    /// A rotation that is told up to whole pitches of so many µrad.
    #[error(
        "no point tells its tooth, and a gear that is turned by whole pitches ({} µrad) looks the same: of all such \
         rotations the one next to 0 is answered", whole(*.0)
    )]
    RotationModuloPitch(f64),
    /// So many points on other teeth than they are said to be of.
    #[error(
        "{} on another, where most others lie on theirs; their nodes are on the tooth that they lie on",
        contradicting(*.0)
    )]
    TeethContradict(usize),
    /// Points that fit other flanks about as well.
    #[error(
        "the points fit other flanks about as well, with another motion; the smaller motion is answered. Say which \
         flank each point is of"
    )]
    FlanksAmbiguous,
    /// So many points on other flanks than were nearest before.
    #[error(
        "{} to another flank than the one that was nearest before the part was laid in place",
        counted(*.0, "point belongs", "points belong")
    )]
    FlanksReassigned(usize),
    /// Deviations beyond those of any flank.
    #[error(
        "after the registration {} µm (rms) are left, more than any flank deviates by ({} µm): other motions, other \
         flanks or another gear", tenth(*.rms), tenth(*.limit)
    )]
    PoorFit {
        /// What is left, µm.
        rms: f64,
        /// What a flank may deviate by, µm.
        limit: f64,
    },
    /// Points far from where the others fit.
    #[error(
        "{} far from where the others fit; the first is {first}, with {} µm: dirt, another flank, or an error of \
         measurement", counted(*.count, "point lies", "points lie"), tenth(*.deviation)
    )]
    PointsMisfit {
        /// How many.
        count: usize,
        /// The first of them, from 0.
        first: usize,
        /// Its deviation, µm.
        deviation: f64,
    },
    /// So many points beyond the tip or the root circle.
    #[error(
        "{} beyond the tip or the root circle, where there is no flank", counted(*.0, "point lies", "points lie")
    )]
    PointsBeyondFlank(usize),
    /// A correction whose active set did not settle.
    #[error(
        "regularised fits do not agree on which settings stay at their limits: the best point within them is answered"
    )]
    LimitsNotSettled,
    /// Settings that were stopped at their limits.
    #[error(
        "{} would go further than allowed; the others make up for it as far as they can", quoted(.0)
    )]
    SettingsLimited(Vec<String>),
    /// Settings that the deviations say nothing about.
    #[error(
        "{}: {}; it stays as it is", quoted(.settings), .common.map_or_else(
            || "at these nodes it has no effect of its own".to_owned(),
            |common| format!(
                "it would change {common} nearly alike, and deviations without a datum do not show what {common} have \
                 in common"
            )
        )
    )]
    UndeterminedSettings {
        /// Which settings.
        settings: Vec<String>,
        /// The nodes that they would change alike; `None` for settings without an effect of their
        /// own at the nodes.
        common: Option<Common>,
    },
    /// Those of them that their limits move all the same.
    #[error(
        "{}: the deviations say nothing about it, but its limits do not let it stay as it is; it goes no further than \
         they ask for", quoted(.0)
    )]
    UndeterminedSettingsMoved(Vec<String>),
    /// Those of them whose limits were not needed.
    #[error(
        "{}: the deviations say nothing about it, so its limits and its increment were not needed", quoted(.0)
    )]
    LimitsWithoutEffect(Vec<String>),
    /// Plain least squares of settings that nearly depend on each other, as this sentence says.
    #[error(
        "plain least squares divides by what the sensitivity hardly knows ({0}): repeated, such a correction can \
         drive the settings away"
    )]
    UndampedCorrection(String),
    /// Settings that depend on each other exactly.
    #[error(
        "some settings depend on each other exactly on these nodes: the smallest changes that do the same are answered"
    )]
    DependentSettings,
}

impl Warning {
    /// The stable code.
    pub fn code(&self) -> &'static str {
        use Warning::*;
        match self {
            RegistrationNotConverged(_) => "registration_not_converged",
            ScrewUndetermined | AxialShiftUndetermined | MotionsIndistinguishable(_) => "motions_indistinguishable",
            AxialShiftByModification(_) => "axial_shift_by_modification",
            AxialShiftForRotation { .. } => "axial_shift_for_rotation",
            NodesLost { .. } => "nodes_lost",
            RotationModuloPitch(_) => "rotation_modulo_pitch",
            TeethContradict(_) => "teeth_contradict",
            FlanksAmbiguous => "flanks_ambiguous",
            FlanksReassigned(_) => "flanks_reassigned",
            PoorFit { .. } => "poor_fit",
            PointsMisfit { .. } => "points_misfit",
            PointsBeyondFlank(_) => "points_beyond_flank",
            LimitsNotSettled => "limits_not_settled",
            SettingsLimited(_) => "settings_limited",
            UndeterminedSettings { .. } => "undetermined_settings",
            UndeterminedSettingsMoved(_) => "undetermined_settings_moved",
            LimitsWithoutEffect(_) => "limits_without_effect",
            UndampedCorrection(_) => "undamped_correction",
            DependentSettings => "dependent_settings",
        }
    }
}

/// The nodes whose common deviation is not told.
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
pub fn tenth(x: f64) -> Shown {
    Shown((x * 10.0).round() / 10.0)
}

/// The beginning of what is said of so many points on other teeth than they are said to be of.
pub fn contradicting(count: usize) -> impl fmt::Display {
    counted(count, "point said to be of one tooth lies", "points said to be of one tooth lie")
}

fn whole(x: f64) -> Shown {
    Shown(x.round())
}

/// Names of settings in a row.
fn quoted(names: &[String]) -> impl fmt::Display {
    listed(names.iter().map(|name| format!("`{name}`")))
}
