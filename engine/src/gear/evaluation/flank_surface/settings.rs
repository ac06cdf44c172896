//! How the surface of a flank is evaluated.

use super::super::{
    limits::ToleranceLimits,
    settings::{DeviationSign, SlopeSign},
};
use crate::{
    estimation::FitSpec,
    gear::{Gear, Kind, Side, trace::Direction},
};

/// Shares of the evaluation range that are cut off, in %: 0 to below 100 together on each axis.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Border {
    /// At the root end of the profile.
    pub root: f64,
    /// At the tip end of the profile.
    pub tip: f64,
    /// At the end of small z.
    pub toe: f64,
    /// At the end of great z.
    pub heel: f64,
}

/// What is asked for beside the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceSettings {
    /// Flank that the nodes are on.
    pub side: Side,
    /// Evaluation range in the coordinate of the nodes, ascending; by default from the first to the
    /// last node that is there.
    pub profile_range: Option<[f64; 2]>,
    /// mm of z.
    pub helix_range: Option<[f64; 2]>,
    /// Shares of the range that are cut off.
    pub border: Border,
    /// How deviations count; a topography has no leads of its own, so `Din` is the same as
    /// `Material`.
    pub given: DeviationSign,
    /// Along what deviations were taken; figures are transverse, as limits are.
    pub direction: Direction,
    /// Sign of slopes and of twist.
    pub sign: SlopeSign,
    /// What the figures must lie within; slopes over the trimmed range have its share of it.
    pub limits: ToleranceLimits,
    /// Everything else about the fit; its model and domain are not looked at.
    pub spec: FitSpec,
}

impl SurfaceSettings {
    /// What deviations are multiplied with to be transverse.
    pub(super) fn to_transverse(&self, gear: &Gear) -> f64 {
        match self.direction {
            Direction::Transverse => 1.0,
            Direction::Normal => 1.0 / gear.base_helix_angle().cos(),
        }
    }

    /// What slopes of profile and helix are multiplied with.
    pub(super) fn signs(&self) -> [f64; 2] {
        // one topography counts in one way, as its profiles do
        let given = match self.given {
            DeviationSign::Din => DeviationSign::Material,
            given => given,
        };
        [Kind::Profile, Kind::Helix].map(|kind| self.sign.of_material(given, kind, self.side))
    }
}
