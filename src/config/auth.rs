//! Who may call.

use clap::ValueEnum;

/// Whether callers need a key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Authentication {
    /// Once the store is PostgreSQL, a digest or an issuer is given, or a key exists at start.
    #[default]
    Auto,
    Required,
    /// Nobody is asked; keys that are sent are not looked at.
    Off,
}

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
