//! How the surface of a flank is evaluated.

use super::super::{
    limits::ToleranceLimits,
    settings::{DeviationSign, SlopeSign},
    spacing::LEAST_COVERED,
    warning::share,
};
use crate::{
    Gear, Kind, Side,
    tolerance::{Rounding, Tolerances},
    trace::Direction,
};
use flankfit_estimation::FitSpec;

/// Length that the slopes of a flank's second-order surface refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = SlopeReference)
)]
pub enum Reference {
    /// Slopes are extended linearly to the evaluation range (profiles) and to the face width
    /// (helices), as drawings and ISO 1328-1 have them.
    #[default]
    #[cfg_attr(feature = "contract", serde(rename = "reference_length"))]
    Length,
    /// Slopes are over the fitted range, and limits get its share of those lengths.
    Evaluated,
}

/// Direction and reference lengths of a flank's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FigureTerms {
    /// Direction in which figures count.
    pub direction: Direction,
    /// Length that slopes refer to.
    pub reference: Reference,
}

impl Default for FigureTerms {
    /// Along the normal, slopes over the reference lengths.
    fn default() -> Self {
        FigureTerms { direction: Direction::Normal, reference: Reference::Length }
    }
}

impl FigureTerms {
    /// Returns the factor that converts deviations along `from` to the direction of the figures.
    pub fn factor(&self, gear: &Gear, from: Direction) -> f64 {
        along(self.direction, gear) / along(from, gear)
    }
}

/// Returns the length along a direction of a transverse µm: cos β_b along the normal.
fn along(direction: Direction, gear: &Gear) -> f64 {
    match direction {
        Direction::Transverse => 1.0,
        Direction::Normal => gear.base_helix_angle().cos(),
    }
}

/// Slopes of profiles and helices: the lengths that they refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slopes {
    /// Lengths that the slopes are given over, mm.
    pub references: [f64; 2],
    /// Factors that extend slopes over the fitted range to the reference lengths.
    pub factors: [f64; 2],
    /// Shares of the reference lengths of ISO 1328-1.
    shares: [f64; 2],
    /// Factor from transverse tolerances to the direction of the figures.
    along: f64,
}

impl Slopes {
    /// Takes the lengths of the fitted ranges of roll length and z, and L_α.
    pub(crate) fn new(gear: &Gear, terms: FigureTerms, fitted: [f64; 2], profile: f64) -> Self {
        let whole = [profile, gear.data().face_width.unwrap_or(fitted[1])];
        let references = match terms.reference {
            Reference::Length => whole,
            Reference::Evaluated => fitted,
        };
        let ratio = |a: [f64; 2], b: [f64; 2]| [a[0] / b[0], a[1] / b[1]];
        let (factors, shares) = (ratio(references, fitted), ratio(references, whole));
        Slopes { references, factors, shares, along: along(terms.direction, gear) }
    }

    /// Takes the ranges of roll length and z of nodes; L_α is their range.
    pub(crate) fn of_nodes(gear: &Gear, terms: FigureTerms, ranges: [[f64; 2]; 2]) -> Self {
        let lengths = ranges.map(|[a, b]| (b - a).abs());
        Slopes::new(gear, terms, lengths, lengths[0])
    }

    /// Returns the limits of the profile slope and of the helix slope. Limits by class, which are
    /// transverse, are converted to the direction of the figures.
    pub(crate) fn limits(&self, limits: &ToleranceLimits, tolerances: Option<&Tolerances>) -> [Option<[f64; 2]>; 2] {
        let of = |kind, share| limits.slope_over(kind, share, self.along, tolerances, Rounding::Rounded);
        [of(Kind::Profile, self.shares[0]), of(Kind::Helix, self.shares[1])]
    }
}

/// True if nodes over `reached` cover enough of a range to compare its figures with limits.
pub fn covers(reached: [f64; 2], range: [f64; 2]) -> bool {
    share(reached, range) >= LEAST_COVERED
}

/// Shares of the evaluation range that are cut off at each edge, in percent: 0 to below 100
/// together on each axis. Default 0.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = BorderPercent),
    serde(deny_unknown_fields, default)
)]
pub struct Border {
    /// Share at the end of small diameters (of internal gears: of great ones), in percent of the
    /// profile's roll length.
    pub root: f64,
    /// Share at the tip end, in percent of the profile's roll length.
    pub tip: f64,
    /// Share at the end of small z.
    pub toe: f64,
    /// Share at the end of great z.
    pub heel: f64,
}

/// Specification in addition to the nodes.
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
    /// Direction in which deviations were taken.
    pub direction: Direction,
    /// Direction and reference lengths of the figures.
    pub terms: FigureTerms,
    /// Sign of slopes and of twist.
    pub sign: SlopeSign,
    /// Limits of the figures.
    pub limits: ToleranceLimits,
    /// Everything else about the fit; its model and domain are not looked at.
    pub spec: FitSpec,
}

impl SurfaceSettings {
    /// Factors by which slopes of profile and helix are multiplied.
    pub(super) fn signs(&self) -> [f64; 2] {
        // one topography counts in one way, as its profiles do
        let given = match self.given {
            DeviationSign::Din => DeviationSign::Material,
            given => given,
        };
        [Kind::Profile, Kind::Helix].map(|kind| self.sign.of_material(given, kind, self.side))
    }
}
