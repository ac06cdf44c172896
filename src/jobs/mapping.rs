//! Mappings of tables of nodes, kept to be proposed again.

/// Mappings that are kept of a tenant; a new one takes the place of the oldest.
pub const MOST_MAPPINGS: u32 = 100;

/// How a table was read that became an iteration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptMapping {
    /// Digest of the instrument's name and the form of the table.
    pub key: [u8; 32],
    /// JSON.
    pub mapping: String,
}
