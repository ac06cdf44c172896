//! Errors in the data of a gear, and errors shared by the modules below.

pub use flankfit_estimation::error::Refused;
use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted},
};

/// Most teeth of a gear.
pub const MOST_TEETH: u32 = 10_000;

/// A datum of a gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GearField {
    /// z.
    Teeth,
    /// m_n.
    NormalModule,
    /// α_n.
    PressureAngle,
    /// β.
    HelixAngle,
    /// x.
    ProfileShift,
    /// b.
    FaceWidth,
    /// d_a.
    TipDiameter,
    /// d_f.
    RootDiameter,
    /// The tool as a whole.
    Tool,
    /// Tip radius of the tool.
    ToolTipRadius,
    /// Addendum of the tool, in modules.
    ToolAddendum,
    /// Protuberance of the tool.
    ToolProtuberance,
}

/// What is wrong with a datum. Lengths in mm, angles in rad.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GearReason {
    /// No number of teeth.
    #[error("{}; a gear has 1 to {MOST_TEETH}", counted(*.0 as usize, "tooth", "teeth"))]
    Teeth(u32),
    /// A length below a µm or above a kilometre.
    #[error("{} mm is not a length of a µm to a kilometre", Shown(*.0))]
    Length(f64),
    /// An angle out of its range.
    #[error("{} rad is not within {} and {} rad", Shown(*.value), Shown(*.low), Shown(*.high))]
    Angle {
        /// What was given.
        value: f64,
        /// The range; its upper end is outside.
        low: f64,
        /// See `low`.
        high: f64,
    },
    /// A profile shift of more than a hundred modules.
    #[error("{} is not within −100 and 100", Shown(*.0))]
    ProfileShift(f64),
    /// A part of the tool below 0, or beyond every length.
    #[error("{} is not within 0 and 1000000", Shown(*.0))]
    ToolPart(f64),
    /// Flanks that meet outside of the root.
    #[error("the flanks of a tooth meet before the root: no tooth is left on {} mm", Shown(*.0))]
    NoTooth(f64),
    /// Teeth that touch each other.
    #[error("the teeth leave no space between them on {} mm", Shown(*.0))]
    NoSpace(f64),
    /// Tip and root circle are on the wrong sides of each other.
    #[error(
        "the tip diameter {} mm is not {} than the root diameter {} mm",
        Shown(*.tip), if *.internal { "smaller" } else { "greater" }, Shown(*.root)
    )]
    TipAndRoot {
        /// d_a.
        tip: f64,
        /// d_f.
        root: f64,
        /// Whether the teeth point inwards.
        internal: bool,
    },
    /// A tip circle within the base circle.
    #[error(
        "the tip diameter {} mm is not above the base circle of {} mm: no involute is left",
        Shown(*.tip), Shown(*.base)
    )]
    TipWithinBase {
        /// d_a.
        tip: f64,
        /// d_b.
        base: f64,
    },
    /// A root circle of an internal gear within the base circle.
    #[error(
        "the root diameter {} mm is not above the base circle of {} mm: no involute is left",
        Shown(*.root), Shown(*.base)
    )]
    RootWithinBase {
        /// d_f.
        root: f64,
        /// d_b.
        base: f64,
    },
    /// A root circle that follows from the other data and is none.
    #[error("the root circle that follows is not above 0; give a root diameter")]
    NoRoot,
    /// A protuberance that its rounding cannot carry.
    #[error(
        "{} mm is more than the tip radius of {} mm: the rounding would not reach the straight flank",
        Shown(*.protuberance), Shown(*.tip_radius)
    )]
    Protuberance {
        /// What was given.
        protuberance: f64,
        /// Tip radius of the tool.
        tip_radius: f64,
    },
    /// A tool whose flanks meet.
    #[error(
        "the flanks of the tool meet before its tip, an addendum of {} mm at a pressure angle of {} rad",
        Shown(*.addendum), Shown(*.pressure_angle)
    )]
    PointedTool {
        /// Addendum of the tool.
        addendum: f64,
        /// α_n.
        pressure_angle: f64,
    },
    /// A tip radius too large for the tool's tip.
    #[error("{} mm does not fit into the tool's tip, which takes {} mm", Shown(*.tip_radius), Shown(*.most))]
    ToolTipRadius {
        /// What was given.
        tip_radius: f64,
        /// The largest one.
        most: f64,
    },
    /// A tool that reaches the axis.
    #[error("the tool cuts through the gear's axis")]
    ThroughAxis,
    /// A fillet that ends beyond the tip.
    #[error("no involute is left: it would start on {} mm, beyond the end of the tooth on {} mm", Shown(*.from), Shown(*.end))]
    NoInvolute {
        /// Diameter at which it would start.
        from: f64,
        /// Diameter at which the tooth ends.
        end: f64,
    },
    /// A fillet that leaves nothing of the tooth.
    #[error("the tool cuts the teeth off on {} mm", Shown(*.0))]
    CutOff(f64),
}

/// Faults of a gear's data.
pub type GearFaults = Faults<GearField, GearReason>;

/// A number that no tooth of the gear has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{tooth} is not within 1 and {teeth}, the number of teeth")]
pub struct NoSuchTooth {
    /// The number.
    pub tooth: u32,
    /// z.
    pub teeth: u32,
}
