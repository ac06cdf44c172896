//! A sector of a gear as hexahedra, written for finite elements.

use std::sync::Arc;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    gears::gear::GearBody,
    json::{text::ShortText, value::read_json},
    problem::{Problem, Room},
    shapes::export::{File, file_name, label},
};
use flankfit_engine::{
    formats::solid_mesh,
    gear::solid::{Elements, HexMesh, MOST_NODES, SolidSpec},
    geometry::space::Vector,
};

/// A gear, and how its solid is meshed.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = SolidMeshRequest)]
pub struct SolidMeshRequestBody {
    /// The gear, with its face width.
    pub gear: GearBody,
    pub format: SolidFormatName,
    /// Default `linear`.
    pub order: Option<ElementOrderName>,
    /// Number of neighbouring teeth, with the rim below them; all teeth of the gear make a ring
    /// without cuts. Default 1.
    #[schema(minimum = 1)]
    pub teeth: Option<u32>,
    /// Inner end of the rim (the bore); for an internal gear its outer diameter. Default one and a
    /// half tooth depths from the root circle.
    #[schema(exclusive_minimum = 0)]
    pub rim_diameter_mm: Option<f64>,
    pub elements: Option<Elements>,
    /// Name of the gear in the file. Default `gear`.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 200)]
    pub name: Option<ShortText>,
}

/// Files of hexahedra: `abaqus` is read by CalculiX too, `gmsh` is MSH 2.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SolidFormat)]
pub enum SolidFormatName {
    Abaqus,
    Adina,
    Gmsh,
}

/// Hexahedra of 8 nodes, or of 20 with middle nodes on flank, fillet and helix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ElementOrder)]
pub enum ElementOrderName {
    Linear,
    Quadratic,
}

/// Bytes of a node until the file is sent: its place, the element that begins there with its nodes,
/// faces, and its place among those already numbered.
const NODE: usize = size_of::<Vector>() + 20 * size_of::<u32>() + 64;

/// Writes the mesh of a request, as far as there is `room` for it. Processor work.
pub fn file(text: &[u8], now: Timestamp, room: Room) -> Result<File, Problem> {
    let body: SolidMeshRequestBody = read_json(text)?;
    let gear = body.gear.checked("/gear").map_err(Problem::invalid)?;
    let spec = SolidSpec {
        teeth: body.teeth.unwrap_or(1),
        rim_diameter: body.rim_diameter_mm,
        quadratic: body.order == Some(ElementOrderName::Quadratic),
        elements: body.elements.unwrap_or_default(),
    };
    // more are refused in any case
    room(HexMesh::most_nodes(&spec).min(MOST_NODES) * NODE)?;
    let mesh = HexMesh::of_gear(&gear, &spec).map_err(Problem::invalid)?;
    let mesh = Arc::new(mesh);
    let name = body.name.map_or_else(|| "gear".to_owned(), String::from);
    let label = label(&name, now);
    let (ending, content) = match body.format {
        SolidFormatName::Abaqus => ("inp", solid_mesh::abaqus(&mesh, &label)),
        SolidFormatName::Adina => ("in", solid_mesh::adina(&mesh, &label)),
        SolidFormatName::Gmsh => ("msh", solid_mesh::gmsh(&mesh, &label)),
    };
    Ok(File { name: file_name(&name, ending), media: "text/plain", content })
}
