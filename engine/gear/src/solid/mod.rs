//! A sector of a gear as hexahedra: one tooth or several with their fillets and the rim, for finite
//! elements.
//!
//! A transverse section of quadrilaterals is swept along the helix. Flank, fillet and circles are
//! those of [`Tooth`](super::generation::tooth::Tooth); quadratic elements have their middle nodes
//! on them too. Sets of faces: `LEFT_FLANK_1`, `RIGHT_FLANK_1` (the involutes, by tooth, clockwise
//! from the one at the top), `ROOT` (fillets and root arcs), `TIP`, `BORE` (of an internal gear
//! `RIM`), `CUT_LEFT`, `CUT_RIGHT` (not on a whole ring), `END_LOW` (z = 0) and `END_HIGH`.

mod hex_mesh;
mod section;
mod spec;

use std::collections::BTreeMap;

pub use hex_mesh::{FACES, FaceSet, HexFace, HexMesh};
pub use section::Side as SolidSide;
pub use spec::{Elements, SolidSpec};

use self::section::{Section, Side};
use super::{Gear, generation::Root};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{
    cancel::checkpoint,
    check::Faults,
    words::{counted, rounded},
};

/// Most nodes of a mesh.
pub const MOST_NODES: usize = 2_000_000;

/// Thickness of the rim by default, in tooth depths.
const RIM: f64 = 1.5;

impl HexMesh {
    /// The mesh of a sector of `gear`.
    ///
    /// ```
    /// use flankfit_gear::{Gear, GearData, solid::{Elements, HexMesh, SolidSpec}};
    ///
    /// let gear = Gear::new(GearData { face_width: Some(10.0), ..GearData::spur(20, 2.0) })?;
    /// let mesh = HexMesh::of_gear(&gear, &SolidSpec::default())?;
    /// assert!(mesh.least_jacobian() > 0.0);
    /// // the flank of the tooth: 10 elements along the involute, 10 along the face width
    /// let flank = mesh.sets().iter().find(|set| set.name == "LEFT_FLANK_1").unwrap();
    /// assert_eq!(flank.faces.len(), 100);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_gear(gear: &Gear, spec: &SolidSpec) -> Result<Self, Faults> {
        let width = check(gear, spec)?;
        let section = Section::new(gear, spec, 0.5 * rim_diameter(gear, spec)?)?;
        let layers = spec.elements.width;
        let all = if spec.quadratic { section.nodes.len() } else { section.corners };
        let (corners, halves) = (section.corners, if spec.quadratic { 2 } else { 1 });
        // every second level of quadratic elements has the middles of upright edges only
        let mut nodes = Vec::with_capacity((layers + 1) * all + if spec.quadratic { layers * corners } else { 0 });
        for level in 0..=layers * halves {
            checkpoint();
            let z = width * level as f64 / (layers * halves) as f64;
            let own = if level % halves == 0 { all } else { corners };
            nodes.extend(section.nodes[..own].iter().map(|[radius, angle]| {
                let (sin, cos) = (angle + gear.turn_per_length() * z).sin_cos();
                Vector::new(-radius * sin, radius * cos, z)
            }));
        }
        let level = all + if spec.quadratic { corners } else { 0 };
        let first = |layer: usize| (layer * level) as u32;
        let mut elements = Vec::with_capacity(layers * section.quads.len() * if spec.quadratic { 20 } else { 8 });
        for layer in 0..layers {
            checkpoint();
            let (low, high, middle) = (first(layer), first(layer + 1), first(layer) + all as u32);
            for quad in &section.quads {
                let (ends, edges) = quad.nodes.split_at(4);
                let above = |nodes: &[u32], base: u32| nodes.iter().map(|node| node + base).collect::<Vec<_>>();
                elements.extend(above(ends, low));
                elements.extend(above(ends, high));
                if spec.quadratic {
                    elements.extend(above(edges, low));
                    elements.extend(above(edges, high));
                    elements.extend(above(ends, middle));
                }
            }
        }
        let sets = sets(&section, layers, gear.data().internal);
        let mesh = HexMesh { nodes, elements, quadratic: spec.quadratic, sets };
        if !(mesh.least_jacobian() > 0.0) {
            let message = "such large elements are inverted along fillet or helix: give more of them";
            return Err(Faults::one("elements", message));
        }
        Ok(mesh)
    }

    /// Nodes that the mesh of `spec` has at most.
    pub fn most_nodes(spec: &SolidSpec) -> usize {
        let Elements { involute, fillet, root, thickness, rim, width } = spec.elements;
        let add = usize::saturating_add;
        // fillets of an undercut tooth, and radial parts below the base circle, are counted twice
        let columns = add(add(root, fillet.saturating_mul(2)).saturating_mul(2), thickness);
        let rows = add(involute, fillet.saturating_mul(3));
        let section = add(add(columns, 1).saturating_mul(add(rim, 1)), add(thickness, 1).saturating_mul(rows));
        let each = section.saturating_mul(spec.teeth as usize).saturating_mul(add(width, 1));
        each.saturating_mul(if spec.quadratic { 4 } else { 1 })
    }
}

/// The face width of a gear whose mesh can be asked for.
fn check(gear: &Gear, spec: &SolidSpec) -> Result<f64, Faults> {
    let mut faults = Faults::default();
    let Elements { involute, fillet, root, thickness, rim, width } = spec.elements;
    let most = HexMesh::most_nodes(spec);
    if [involute, fillet, root, thickness, rim, width].contains(&0) {
        faults.push("elements", "at least one element along every direction");
    } else if most > MOST_NODES {
        faults.push("elements", format_args!("{} requested; a mesh has at most {MOST_NODES}", nodes(most)));
    }
    let teeth = gear.data().teeth;
    if spec.teeth == 0 || spec.teeth > teeth {
        faults.push("teeth", format_args!("a sector of {} teeth; the gear has {teeth}", spec.teeth));
    }
    let face_width = gear.data().face_width;
    if face_width.is_none() {
        faults.push("gear.face_width_mm", "a solid needs the face width");
    }
    faults.into_result(face_width.unwrap_or(0.0))
}

/// How many in words; products that overflow are the greatest count there is.
fn nodes(count: usize) -> String {
    match count {
        usize::MAX => "more nodes than can be counted are".to_owned(),
        count => counted(count, "node", "nodes").to_string(),
    }
}

/// Returns the diameter at which the rim ends.
fn rim_diameter(gear: &Gear, spec: &SolidSpec) -> Result<f64, Faults> {
    let (out, root) = (gear.outward(), Root::of(gear).root_radius(gear));
    let depth = (gear.tip_radius() - root).abs();
    // a solid disc has no bore: a fifth of the root circle is left open
    let usual = 2.0 * (root - out * RIM * depth).max(0.2 * root);
    let diameter = spec.rim_diameter.unwrap_or(usual);
    let fits = diameter > 0.0 && diameter < 1e7 && out * (2.0 * root - diameter) > 1e-6 * root;
    if fits {
        return Ok(diameter);
    }
    let side = if gear.data().internal { "larger" } else { "smaller" };
    let [diameter, root] = [diameter, 2.0 * root].map(|x| rounded(x, 7));
    Err(Faults::one(
        "rim_diameter_mm",
        format_args!(
            "the rim would end at a diameter of {diameter} mm: choose one {side} than the root circle, {root} mm"
        ),
    ))
}

fn sets(section: &Section, layers: usize, internal: bool) -> Vec<FaceSet> {
    let mut sides: BTreeMap<Side, Vec<HexFace>> = BTreeMap::new();
    let (mut low, mut high) = (Vec::new(), Vec::new());
    let quads = section.quads.len();
    for layer in 0..layers {
        for (k, quad) in section.quads.iter().enumerate() {
            let element = (layer * quads + k) as u32;
            for (edge, side) in quad.sides.iter().enumerate() {
                if let Some(side) = side {
                    sides.entry(*side).or_default().push(HexFace { element, face: edge as u8 + 2 });
                }
            }
            if layer == 0 {
                low.push(HexFace { element, face: 0 });
            }
            if layer + 1 == layers {
                high.push(HexFace { element, face: 1 });
            }
        }
    }
    let named = |(side, faces): (Side, Vec<HexFace>)| FaceSet { name: name(side, internal), faces };
    let ends = [("END_LOW", low), ("END_HIGH", high)];
    let ends = ends.into_iter().map(|(name, faces)| FaceSet { name: name.to_owned(), faces });
    sides.into_iter().map(named).chain(ends).collect()
}

fn name(side: Side, internal: bool) -> String {
    match side {
        Side::LeftFlank(tooth) => return format!("LEFT_FLANK_{tooth}"),
        Side::RightFlank(tooth) => return format!("RIGHT_FLANK_{tooth}"),
        Side::Root => "ROOT",
        Side::Tip => "TIP",
        Side::Rim if internal => "RIM",
        Side::Rim => "BORE",
        Side::CutLeft => "CUT_LEFT",
        Side::CutRight => "CUT_RIGHT",
    }
    .to_owned()
}
