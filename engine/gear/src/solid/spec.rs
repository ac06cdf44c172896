//! Settings of a solid mesh.

/// A sector of teeth with its rim.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSpec {
    /// Teeth side by side; all of the gear's make a ring without cuts.
    pub teeth: u32,
    /// Where the rim ends, mm: the bore, of an internal gear the outer diameter. By default one and
    /// a half tooth depths from the root circle.
    pub rim_diameter: Option<f64>,
    /// Whether edges have nodes in their middles, which lie on flank, fillet and helix too.
    pub quadratic: bool,
    /// Numbers of elements.
    pub elements: Elements,
}

/// Into how many elements each part goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Elements {
    /// Along each involute.
    pub involute: usize,
    /// Along each fillet.
    pub fillet: usize,
    /// Along the root arc on each side of a tooth.
    pub root: usize,
    /// Across the tooth.
    pub thickness: usize,
    /// From the root to the end of the rim.
    pub rim: usize,
    /// Along the face width.
    pub width: usize,
}

impl Default for Elements {
    fn default() -> Self {
        Elements { involute: 10, fillet: 6, root: 2, thickness: 8, rim: 6, width: 10 }
    }
}

impl Default for SolidSpec {
    fn default() -> Self {
        SolidSpec { teeth: 1, rim_diameter: None, quadratic: false, elements: Elements::default() }
    }
}
