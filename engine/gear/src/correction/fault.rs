//! What is wrong with a correction, with the nodes of a machine's sensitivity, with a comparison.

use flankfit_numerics::fault::{
    Common, Faults,
    words::{Shown, counted, entries},
};

/// Most settings of a machine.
pub const MOST_SETTINGS: usize = 64;
/// Most entries of a sensitivity matrix.
pub const MOST_ENTRIES: usize = 2_000_000;

/// A part of a setting's limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitField {
    /// The least change.
    Min,
    /// The greatest change.
    Max,
    /// The step of changes.
    Increment,
}

/// A part of what a correction is computed from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CorrectionField {
    /// All deviations.
    Deviations,
    /// One of them.
    Deviation {
        /// From 0.
        index: usize,
    },
    /// The target of each node.
    Targets,
    /// One of them.
    Target {
        /// From 0.
        index: usize,
    },
    /// The weights.
    Weights,
    /// One of them.
    Weight {
        /// From 0.
        index: usize,
    },
    /// The settings of the machine.
    Settings,
    /// One of them.
    Setting {
        /// From 0.
        index: usize,
    },
    /// J.
    Matrix,
    /// An entry of J.
    Entry {
        /// The node, from 0.
        row: usize,
        /// The setting, from 0.
        column: usize,
    },
    /// The limits of all settings.
    Limits,
    /// A limit of a setting.
    Limit {
        /// The setting's name.
        setting: String,
        /// Which limit.
        limit: LimitField,
    },
    /// The traces that nodes belong to.
    Traces,
    /// Whether the deviations have a datum.
    Absolute,
    /// σ.
    NoiseSigma,
    /// r of Ineq. 51.
    CoefficientNormLimit,
    /// η.
    ResponseUncertainty,
    /// The share of the limits that needs no correction.
    KeepWithin,
}

/// Which nodes a correction has too few of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// Those with a deviation.
    Defined,
    /// Those that also have a weight.
    Weighted,
}

/// Why a correction is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CorrectionReason {
    /// There is none.
    #[error("there are no nodes")]
    NoNodes,
    /// So many settings are too few or too many.
    #[error("{}; a correction has 1 to {MOST_SETTINGS}", counted(*.0, "setting", "settings"))]
    SettingCount(usize),
    /// A setting without a name.
    #[error("a setting needs a name")]
    NoName,
    /// A name that two settings have.
    #[error("`{}` is there twice", .0)]
    Twice(String),
    /// A matrix of another size, or one that is too large.
    #[error(
        "{}; {} and {} ask for {} (at most {MOST_ENTRIES})",
        entries(*.given), counted(*.nodes, "node", "nodes"), counted(*.settings, "setting", "settings"),
        .nodes * .settings
    )]
    Matrix {
        /// Entries given.
        given: usize,
        /// How many there are.
        nodes: usize,
        /// How many there are.
        settings: usize,
    },
    /// NaN or infinite.
    #[error("{} is not a finite number", .0)]
    NotFinite(f64),
    /// An infinite deviation.
    #[error("the deviation is infinite; an undefined one is null")]
    Infinite,
    /// A weight that is none.
    #[error("{} is not a finite weight of at least 0", .0)]
    Weight(f64),
    /// Traces with a zero each, and a datum.
    #[error("traces that have a zero each have no common one: leave out the datum, or the traces")]
    TracesWithDatum,
    /// No share.
    #[error("{} is not a share between 0 and 1", Shown(*.0))]
    Share(f64),
    /// Every setting is fixed.
    #[error("every setting is fixed: there is nothing to correct")]
    AllFixed,
    /// Fewer nodes than settings.
    #[error(
        "{} cannot be determined from {} {}{}",
        counted(*.settings, "setting", "settings"), counted(*.nodes, "node", "nodes"),
        match .left { Left::Defined => "defined", Left::Weighted => "with a weight above 0" },
        .traces.map_or_else(String::new, |lost| format!(" of {} with a zero each", counted(lost, "trace", "traces")))
    )]
    TooFew {
        /// That may be changed.
        settings: usize,
        /// That take part.
        nodes: usize,
        /// What they are.
        left: Left,
        /// How many have a zero each.
        traces: Option<usize>,
    },
    /// No setting has an effect at the nodes.
    #[error("no setting that may be changed has an effect at the defined nodes")]
    NoEffect,
    /// Without a datum no setting can be determined.
    #[error(
        "the deviations have no datum, and every setting changes {} nearly alike: nothing can be determined",
        if *.traces { "all nodes of a trace" } else { "all nodes" }
    )]
    NoDatum {
        /// Whether traces have a zero each.
        traces: bool,
    },
    /// A limit that is NaN or infinite.
    #[error("the number is not finite; leave it out for none")]
    LimitNotFinite,
    /// A limit of a setting that is fixed.
    #[error("a setting that is fixed is not changed: it has no limits and no increment")]
    Fixed,
    /// Limits that leave nothing.
    #[error("the least change {} is above the greatest, {}", Shown(*.min), Shown(*.max))]
    Crossed {
        /// The least.
        min: f64,
        /// The greatest.
        max: f64,
    },
    /// No step.
    #[error("{} is not a step above 0", Shown(*.0))]
    Step(f64),
    /// No multiple of the step is a change that may be made.
    #[error("no multiple of {} lies within the limits", Shown(*.0))]
    NoMultiple(f64),
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
}

/// Faults of a correction.
pub type CorrectionFaults = Faults<CorrectionField, CorrectionReason>;

/// A part of what a machine's sensitivity is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineField {
    /// The range along the profile.
    ProfileRange,
    /// The range along the axis.
    HelixRange,
    /// All nodes.
    Nodes,
    /// The roll length of one.
    RollLength {
        /// From 0.
        node: usize,
    },
    /// The axial position of one.
    Position {
        /// From 0.
        node: usize,
    },
}

impl MachineField {
    /// Whether it is one of the nodes, or all of them.
    pub fn is_of_nodes(self) -> bool {
        matches!(self, MachineField::Nodes | MachineField::RollLength { .. } | MachineField::Position { .. })
    }
}

/// Why a machine has no sensitivity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineReason {
    /// No roll lengths, mm.
    #[error("{} to {} mm is not a range of roll lengths", Shown(.0[0]), Shown(.0[1]))]
    ProfileRange([f64; 2]),
    /// No z, mm.
    #[error("{} to {} mm is not an ascending range of z", Shown(.0[0]), Shown(.0[1]))]
    HelixRange([f64; 2]),
    /// There is none.
    #[error("{}; at least one is needed", counted(0, "node", "nodes"))]
    NoNodes,
    /// No roll length, mm.
    #[error("{} is not a roll length of at least 0 mm", Shown(*.0))]
    RollLength(f64),
    /// No z, mm.
    #[error("{} is not a place on a gear, mm", Shown(*.0))]
    Position(f64),
}

/// Faults of a machine's sensitivity.
pub type MachineFaults = Faults<MachineField, MachineReason>;

/// A part of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComparisonField {
    /// A list with an entry for each node.
    List(NodeList),
    /// An entry of it.
    Entry {
        /// Which list.
        list: NodeList,
        /// The node, from 0.
        index: usize,
    },
    /// What each setting contributes at each node.
    Contributions,
    /// One of them.
    Contribution {
        /// From 0.
        index: usize,
    },
    /// The traces that nodes belong to.
    Traces,
    /// σ.
    NoiseSigma,
    /// η.
    ResponseUncertainty,
}

/// A list of a comparison with an entry for each node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeList {
    /// Deviations before the correction.
    Before,
    /// Deviations after it.
    Measured,
    /// Weights.
    Weight,
    /// Leverages.
    Leverage,
}

/// Why a comparison is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonReason {
    /// No node can be compared.
    #[error("no node is defined before, predicted and measured")]
    NoNodes,
    /// ±∞.
    #[error("the number is infinite")]
    Infinite,
    /// Below 0.
    #[error("{} is not a number of at least 0", Shown(*.0))]
    Negative(f64),
    /// Another number of contributions than of nodes and settings.
    #[error("{}; nodes and settings ask for {wanted}", entries(*.given))]
    Contributions {
        /// Given.
        given: usize,
        /// Their product.
        wanted: usize,
    },
    /// A contribution that is NaN or infinite.
    #[error("it is not a finite number")]
    Contribution,
    /// What is wrong with numbers of any kind.
    #[error(transparent)]
    Common(#[from] Common),
}

/// Faults of a comparison.
pub type ComparisonFaults = Faults<ComparisonField, ComparisonReason>;

/// Why nothing was compared.
pub type ComparisonRefused = crate::Refused<ComparisonField, ComparisonReason>;
