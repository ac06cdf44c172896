//! Settings of a solid mesh.

/// A sector of teeth with its rim.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSpec {
    /// Teeth side by side; all of the gear's make a ring without cuts.
    pub teeth: u32,
    /// End of the rim, mm: the bore, of an internal gear the outer diameter. By default one and
    /// a half tooth depths from the root circle.
    pub rim_diameter: Option<f64>,
    /// Whether edges have nodes in their middles, which lie on flank, fillet and helix too.
    pub quadratic: bool,
    /// Numbers of elements.
    pub elements: Elements,
}

/// Numbers of elements of each part; at most two million nodes in all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = SolidElements),
    serde(deny_unknown_fields, default)
)]
pub struct Elements {
    /// Along each involute.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub involute: usize,
    /// Along each fillet.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub fillet: usize,
    /// Along the root arc on each side of a tooth.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub root: usize,
    /// Across the tooth.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub thickness: usize,
    /// From the root to the end of the rim.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
    pub rim: usize,
    /// Along the face width.
    #[cfg_attr(feature = "contract", schema(minimum = 1))]
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
