//! Settings of authentication.

use clap::ValueEnum;

/// Authentication of callers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Authentication {
    /// Required if the store is PostgreSQL, a digest or an issuer is configured, or a key exists at
    /// start.
    #[default]
    Auto,
    Required,
    /// No key is required; keys that are sent are ignored.
    Off,
}

/// Role of the keys in the settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum KeysRole {
    /// Reads and computes.
    Reader,
    /// Also stores measurements.
    Operator,
    /// Also decides.
    #[default]
    Engineer,
    /// Reads, and reads the audit.
    Auditor,
    /// Reads the audit, and makes keys.
    Admin,
}
