//! Lines of the section as they come from cells: places in a row.

use super::field::Kind;

/// Places in a row on one line of the section.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    pub places: Vec<([f64; 2], Kind)>,
    /// Whether the last place is followed by the first.
    pub closed: bool,
}

/// Parts of the section in a rectangle of parameters.
#[derive(Default)]
pub(super) struct Pieces {
    pub chains: Vec<Chain>,
    /// Places at which branches cross.
    pub branches: Vec<[f64; 2]>,
    /// Places at which the plane touches in a point.
    pub contacts: Vec<[f64; 2]>,
    pub coincident: bool,
    /// Parts too small to distinguish.
    pub unresolved: Vec<[f64; 2]>,
}
