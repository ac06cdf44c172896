//! Material taken off at a place of the flank.

/// Relief at a place and how it grows. µm, and µm per mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relief {
    /// Material removed.
    pub value: f64,
    /// Growth per mm of roll length.
    pub by_roll: f64,
    /// Growth per mm of z at the same roll length.
    pub by_z: f64,
}
