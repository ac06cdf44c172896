//! Errors in modifications: in their range, a law, or a topography.

use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted},
};

/// Most nodes of one topography.
pub const MOST_NODES: usize = 1_000_000;

/// Most modifications of one flank.
pub const MOST: usize = 100;
/// What is shorter, mm, is no length on a flank: a relief over it would be a step, its slopes
/// beyond all numbers.
pub const LEAST_LENGTH: f64 = 1e-6;

/// A part of the range that modifications refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeField {
    /// Both diameters.
    Diameters,
    /// One of them.
    Diameter {
        /// 0 or 1.
        index: usize,
    },
    /// Both z.
    Helix,
    /// One of them.
    HelixEnd {
        /// 0 or 1.
        index: usize,
    },
}

/// Why a range is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RangeReason {
    /// A diameter below the base circle.
    #[error("{} mm has no involute; the base diameter is {} mm", Shown(*.diameter), Shown(*.base))]
    NoInvolute {
        /// mm.
        diameter: f64,
        /// d_b, mm.
        base: f64,
    },
    /// Diameters that are nearly the same.
    #[error("their roll lengths are less than {LEAST_LENGTH} mm apart")]
    ShortProfile,
    /// No z.
    #[error("{} is not a place on the axis", Shown(*.0))]
    NotOnAxis(f64),
    /// Ends that are nearly the same.
    #[error("the two ends are less than {LEAST_LENGTH} mm apart")]
    ShortHelix,
}

/// Faults of a range.
pub type RangeFaults = Faults<RangeField, RangeReason>;

/// A part of a topography.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopographyField {
    /// The grid as a whole.
    Whole,
    /// Places along the profile.
    Profile,
    /// One of them.
    ProfileValue {
        /// From 0.
        index: usize,
    },
    /// Places along the axis.
    Positions,
    /// One of them.
    Position {
        /// From 0.
        index: usize,
    },
    /// All rows.
    Relief,
    /// A row.
    ReliefRow {
        /// From 0.
        row: usize,
    },
    /// One number.
    ReliefValue {
        /// From 0.
        row: usize,
        /// From 0.
        column: usize,
    },
}

/// Why a topography is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TopographyReason {
    /// An axis without a place.
    #[error("a grid has at least one place on every axis")]
    EmptyAxis,
    /// A place beyond a kilometre.
    #[error("{} is not within ±1000000 mm", Shown(*.0))]
    Place(f64),
    /// A place that does not lie above the one before it.
    #[error("{} does not lie above the place before it by {LEAST_LENGTH} mm or more", Shown(*.0))]
    NotAscending(f64),
    /// So many nodes are too many.
    #[error("{} nodes; a topography has at most {}", .0, MOST_NODES)]
    TooMany(usize),
    /// A number of rows that is not that of the profile's places.
    #[error("{} for {}", counted(*.rows, "row", "rows"), counted(*.wanted, "profile value", "profile values"))]
    Rows {
        /// Given.
        rows: usize,
        /// Places along the profile.
        wanted: usize,
    },
    /// A row with another number of values than there are positions.
    #[error("{} for {wanted}", counted(*.values, "value", "values"))]
    Columns {
        /// Given.
        values: usize,
        /// Places along the axis.
        wanted: usize,
    },
    /// A relief of more than a metre.
    #[error("{} is not within ±1000000 µm", Shown(*.0))]
    Relief(f64),
    /// No surface goes through the nodes.
    #[error("{0}")]
    Grid(String),
}

/// Faults of a topography.
pub type TopographyFaults = Faults<TopographyField, TopographyReason>;

/// A part of a list of modifications.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawField {
    /// The list.
    List,
    /// The amount of one.
    Amount {
        /// From 0.
        number: usize,
    },
    /// The diameter where a relief starts.
    StartDiameter {
        /// From 0.
        number: usize,
    },
    /// The length of an end relief.
    Length {
        /// From 0.
        number: usize,
    },
}

/// Why a modification is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LawReason {
    /// So many are too many.
    #[error("{} modifications; at most {MOST} are superposed", .0)]
    TooMany(usize),
    /// An amount of more than one module, µm.
    #[error("{} is not within ±{} µm, one normal module", Shown(*.amount), Shown(*.most))]
    Amount {
        /// Given.
        amount: f64,
        /// m_n.
        most: f64,
    },
    /// A relief that starts outside of the range or at its own end, mm.
    #[error(
        "{} mm does not lie between {} mm and {} mm, or leaves no way to the end of the relief",
        Shown(*.diameter), Shown(.range[0]), Shown(.range[1])
    )]
    StartDiameter {
        /// Given.
        diameter: f64,
        /// At root and tip.
        range: [f64; 2],
    },
    /// A length that the range has not got, mm.
    #[error("{} mm is not within {LEAST_LENGTH} mm and {} mm, the range's length", Shown(*.length), Shown(*.most))]
    Length {
        /// Given.
        length: f64,
        /// Length of the range.
        most: f64,
    },
}

/// Faults of a list of modifications.
pub type LawFaults = Faults<LawField, LawReason>;
