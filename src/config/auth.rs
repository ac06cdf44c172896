//! Who may call.

use clap::ValueEnum;

/// The role of the keys that the settings name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum KeysRole {
    /// Reads and computes.
    Reader,
    /// Stores measurements as well.
    Operator,
    /// Decides as well.
    #[default]
    Engineer,
    /// Reads, and reads who did what.
    Auditor,
    /// Reads who did what, and makes keys.
    Admin,
}
