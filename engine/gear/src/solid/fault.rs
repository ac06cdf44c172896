//! Why a gear has no solid mesh.

use crate::{GearField, GearReason, generation::fault::ToothReason};
use flankfit_numerics::fault::{
    Faults,
    words::{Shown, counted},
};

/// Most nodes of a mesh.
pub const MOST_NODES: usize = 2_000_000;

/// What a solid mesh is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidField {
    /// A datum of the gear.
    Gear(GearField),
    /// How many teeth the sector has.
    Teeth,
    /// The diameter at which the rim ends.
    RimDiameter,
    /// Numbers of elements.
    Elements,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidReason {
    /// A gear whose face width is not known.
    #[error("a solid needs the face width")]
    NoFaceWidth,
    /// More teeth than the gear has, or none.
    #[error("a sector of {wanted} teeth; the gear has {teeth}")]
    Teeth {
        /// Teeth asked for.
        wanted: u32,
        /// Those of the gear.
        teeth: u32,
    },
    /// A rim that ends on the wrong side of the root circle.
    #[error("the rim would end at a diameter of {} mm: {side} the root circle, {} mm", Shown(*.diameter),
        Shown(*.root), side = if *.internal { "choose one larger than" } else { "choose one smaller than" })]
    Rim {
        /// The diameter asked for.
        diameter: f64,
        /// That of the root circle.
        root: f64,
        /// Whether the gear is internal.
        internal: bool,
    },
    /// A direction without elements.
    #[error("at least one element along every direction")]
    NoElements,
    /// Too many nodes.
    #[error("{} asked for; a mesh has at most {MOST_NODES}", nodes(*.0))]
    TooMany(usize),
    /// A tooth whose flanks meet before its tip.
    #[error("the flanks meet at the tip: hexahedra need a tip of some width; give a smaller tip diameter")]
    Pointed,
    /// A root that bends under itself.
    #[error("the fillet bends back under the tooth at a diameter of {} mm: such a root is not meshed", Shown(*.0))]
    Undercut(f64),
    /// Elements that turn inside out.
    #[error("elements so large turn inside out along fillet or helix: give more of them")]
    Folded,
    /// There is no tooth.
    #[error(transparent)]
    Tooth(#[from] ToothReason),
    /// There is no gear.
    #[error(transparent)]
    Gear(#[from] GearReason),
}

/// How many; products that overflow are the greatest count there is.
fn nodes(count: usize) -> String {
    match count {
        usize::MAX => "more nodes than can be counted are".to_owned(),
        count => counted(count, "node", "nodes").to_string(),
    }
}

/// Faults of a solid mesh.
pub type SolidFaults = Faults<SolidField, SolidReason>;
