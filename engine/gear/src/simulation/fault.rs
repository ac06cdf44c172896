//! Errors in a simulated machine, and causes of the end of a run.

use crate::correction::fault::{ComparisonFaults, ComparisonRefused, CorrectionFaults, MOST_ENTRIES, MOST_SETTINGS};
use flankfit_estimation::FitError;
use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted, entries},
};

/// Most corrections of a run: settings that run away are still numbers then.
pub const MOST_CORRECTIONS: usize = 20;

/// How far a setting that is off may move a node, µm: a kilometre.
pub const MOST_DEVIATION: f64 = 1e9;

/// A part of a simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineField {
    /// The settings.
    Settings,
    /// J.
    Matrix,
    /// An entry of J.
    Entry {
        /// The node, from 0.
        row: usize,
        /// The setting, from 0.
        column: usize,
    },
    /// What settings are off by.
    SettingErrors,
    /// The error of one setting.
    SettingError {
        /// From 0.
        index: usize,
    },
    /// ρ.
    ResponseNoise,
    /// Noise of a measured deviation.
    ProbeNoise,
    /// Share of nodes that are missed.
    Missing,
    /// A change of all settings.
    Changes,
    /// The change of one setting.
    Change {
        /// From 0.
        index: usize,
    },
    /// The number of corrections.
    Corrections,
}

/// Why a machine is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineReason {
    /// So many settings are too few or too many.
    #[error("{}; a machine has 1 to {MOST_SETTINGS}", counted(*.0, "setting", "settings"))]
    SettingCount(usize),
    /// A matrix that is not of rows.
    #[error("{} are not rows of {columns} (at most {MOST_ENTRIES})", entries(*.given))]
    Matrix {
        /// Entries given.
        given: usize,
        /// How many settings there are.
        columns: usize,
    },
    /// NaN or infinite.
    #[error("{} is not a finite number", .0)]
    NotFinite(f64),
    /// Another number of entries than of settings.
    #[error("{} for {}", entries(*.given), counted(*.settings, "setting", "settings"))]
    PerSetting {
        /// Given.
        given: usize,
        /// How many there are.
        settings: usize,
    },
    /// No standard deviation.
    #[error("{} is not a finite deviation of at least 0", Shown(*.0))]
    Deviation(f64),
    /// A setting that moves a node too far, µm.
    #[error("it moves a node by {} µm; at most {MOST_DEVIATION:e} µm", Shown(*.0))]
    Effect(f64),
    /// A standard deviation out of its range.
    #[error("{} is not a deviation between 0 and {most:e}", Shown(*.value))]
    Beyond {
        /// Given.
        value: f64,
        /// The most.
        most: f64,
    },
    /// No share.
    #[error("{} is not a share of at least 0 and below 1", Shown(*.0))]
    Share(f64),
    /// Too few nodes are left.
    #[error(
        "it leaves {}, too few for {}",
        counted(*.nodes, "node", "nodes"), counted(*.settings, "setting", "settings")
    )]
    TooFew {
        /// What is left.
        nodes: usize,
        /// How many there are.
        settings: usize,
    },
    /// A setting that leaves the range of doubles.
    #[error("the setting would no longer be a finite number")]
    RanAway,
    /// So many corrections are too many.
    #[error("{} corrections; at most {MOST_CORRECTIONS}", .0)]
    TooManyCorrections(usize),
}

/// Faults of a simulated machine.
pub type MachineFaults = Faults<MachineField, MachineReason>;

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The machine is refused, or its settings ran away.
    #[error(transparent)]
    Machine(#[from] MachineFaults),
    /// A correction is refused.
    #[error(transparent)]
    Correction(#[from] CorrectionFaults),
    /// A measurement and what was predicted cannot be compared.
    #[error(transparent)]
    Comparison(#[from] ComparisonFaults),
    /// A fit was refused.
    #[error(transparent)]
    Fit(#[from] FitError),
}

impl From<ComparisonRefused> for RunError {
    fn from(refused: ComparisonRefused) -> Self {
        match refused {
            ComparisonRefused::Invalid(faults) => faults.into(),
            ComparisonRefused::Fit(error) => error.into(),
        }
    }
}
