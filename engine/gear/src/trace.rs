//! Traces: deviations of a tooth flank along a profile or along the helix.

use super::Side;

/// Limit of deviations, µm: a kilometre. Squares of greater ones may overflow.
pub const MOST_DEVIATION: f64 = 1e9;

/// Which way a trace runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = TraceKind)
)]
pub enum Kind {
    /// From root to tip in one transverse section.
    Profile,
    /// Along the face width on one cylinder.
    Helix,
}

/// Direction of deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = DeviationDirection)
)]
pub enum Direction {
    /// Along the base tangent in the transverse plane.
    #[default]
    Transverse,
    /// Along the normal: the transverse one times cos β_b.
    Normal,
}

/// One trace as it was measured, in the order of its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The tooth as its instrument names it: `1`, `44`, `1k`.
    pub tooth: String,
    /// Flank of the tooth.
    pub side: Side,
    /// Profile or helix.
    pub kind: Kind,
    /// Roll length of each sample of a profile, z of each sample of a helix, mm.
    pub at: Vec<f64>,
    /// z of a profile, diameter of a helix, mm, where known.
    pub section: Option<f64>,
    /// µm as given, NaN where undefined: an undefined sample keeps its place and is never counted.
    pub deviation: Vec<f64>,
}
