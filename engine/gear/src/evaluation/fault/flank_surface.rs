//! What is wrong with the nodes of a whole flank.

use super::limits::{ToleranceField, ToleranceReason};
use crate::NoInvolute;
use flankfit_numerics::fault::{
    Common, Faults,
    words::{Shown, entries},
};

/// A part of the nodes over a flank, or of what their surface is fitted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceField {
    /// Places along the profile.
    Profile,
    /// One of them.
    ProfileAt {
        /// From 0.
        index: usize,
    },
    /// Axial places.
    Positions,
    /// One of them.
    Position {
        /// From 0.
        index: usize,
    },
    /// All deviations.
    Deviations,
    /// One of them.
    Deviation {
        /// From 0.
        index: usize,
    },
    /// Which nodes are there.
    Valid,
    /// The range along the profile.
    ProfileRange,
    /// One end of it.
    ProfileRangeEnd {
        /// 0 or 1.
        index: usize,
    },
    /// The range along the axis.
    HelixRange,
    /// What is cut off at the ends of both ranges.
    Border,
    /// At the root.
    BorderRoot,
    /// At the tip.
    BorderTip,
    /// At the end of small z.
    BorderToe,
    /// At the end of great z.
    BorderHeel,
    /// A limit of a figure.
    Limit(ToleranceField),
}

impl From<ToleranceField> for SurfaceField {
    fn from(field: ToleranceField) -> Self {
        SurfaceField::Limit(field)
    }
}

/// Why the surface of a flank is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceReason {
    /// There is none.
    #[error("there are no nodes")]
    NoNodes,
    /// Another number of axial places than of places along the profile.
    #[error("{}, but {profile} would match the profile", entries(*.given))]
    Positions {
        /// Given.
        given: usize,
        /// Places along the profile.
        profile: usize,
    },
    /// Every node is missing.
    #[error("every node is missing")]
    AllMissing,
    /// Every node lies outside.
    #[error("no node is left within the trimmed range")]
    AllTrimmed,
    /// Nodes that leave more of the range open than a node distance and a twentieth of it.
    #[error(
        "the nodes that count reach from {} to {} mm, the range from {} to {} mm: its figures would be extrapolated; \
         name a range that the nodes cover",
        Shown(.reached[0]), Shown(.reached[1]), Shown(.range[0]), Shown(.range[1])
    )]
    NotCovered {
        /// The least and the greatest roll length or z of a node.
        reached: [f64; 2],
        /// The trimmed range.
        range: [f64; 2],
    },
    /// No share, percent.
    #[error("{} is not within 0 and 100", Shown(*.0))]
    Percent(f64),
    /// Shares that leave nothing.
    #[error("nothing is left between opposite borders")]
    NothingLeft,
    /// What is wrong with a limit.
    #[error(transparent)]
    Limit(#[from] ToleranceReason),
    /// A place without an involute.
    #[error(transparent)]
    NoInvolute(#[from] NoInvolute),
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
}

/// Faults of the surface of a flank.
pub type SurfaceFaults = Faults<SurfaceField, SurfaceReason>;

/// Why a flank has no surface.
pub type SurfaceRefused = crate::Refused<SurfaceField, SurfaceReason>;
