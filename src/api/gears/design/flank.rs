//! Nodes of a nominal or modified flank.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::modification::{self, ModificationBody, ModificationRangeBody};
use super::places::ProfileBody;
use crate::api::{
    gears::gear::GearBody,
    json::{value::read_json, writer::whole_of},
    problem::{Problem, Room},
    shapes::places::Values,
    warning::WarningBody,
};
use flankfit_engine::{
    formats::table::{self, ListedPoint},
    gear::{FlankGrid, Gear, GridSpec, Modifications, Side, flank_grid::MOST_NODES},
    geometry::space::Vector,
};

/// Nodes to compute on a flank.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = FlankRequest)]
pub struct FlankRequestBody {
    pub gear: GearBody,
    pub flank: Side,
    pub profile: ProfileBody,
    /// z of each column.
    pub face_width_positions_mm: Vec<f64>,
    /// Superposed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modifications: Vec<ModificationBody>,
    pub modification_range: Option<ModificationRangeBody>,
    /// 1 (the default) is the tooth at the top; numbers go clockwise as the viewer sees them.
    #[schema(minimum = 1)]
    pub tooth: Option<u32>,
}

/// Nodes: a row for each profile value with a node for each z. Normals are those of the modified
/// flank.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = FlankNodes)]
pub struct FlankBody {
    /// `[x, y, z]`, mm.
    #[schema(value_type = Vec<Vec<[f64; 3]>>)]
    pub points: Vec<Values>,
    /// Unit normals, out of the material.
    #[schema(value_type = Vec<Vec<[f64; 3]>>)]
    pub normals: Vec<Values>,
    /// Roll length of each row.
    #[schema(value_type = Vec<f64>)]
    pub roll_length_mm: Values,
    /// Diameter of each row, on the nominal flank.
    #[schema(value_type = Vec<f64>)]
    pub diameter_mm: Values,
    /// z of each column.
    #[schema(value_type = Vec<f64>)]
    pub z_mm: Values,
    /// Material removed at each node, with modifications.
    pub relief_um: Option<Vec<Vec<f64>>>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
}

/// Bytes of a node until it is written: point and normal, twice, and their text.
const NODE: usize = 2 * 6 * size_of::<f64>() + 6 * TEXT_OF_NUMBER;
/// A number in the text, with its comma.
pub(in crate::api) const TEXT_OF_NUMBER: usize = 24;

/// A request, computed.
struct Computed {
    gear: Gear,
    side: Side,
    modifications: Option<Modifications>,
    grid: FlankGrid,
    hand_assumed: Option<WarningBody>,
}

fn computed(text: &[u8], room: Room) -> Result<Computed, Problem> {
    let body: FlankRequestBody = read_json(text)?;
    let nodes = body.profile.values.len().saturating_mul(body.face_width_positions_mm.len());
    room(nodes.min(MOST_NODES) * NODE)?;
    let gear = body.gear.checked("/gear").map_err(Problem::invalid)?;
    let modifications =
        modification::read(&gear, &body.modifications, body.modification_range).map_err(Problem::invalid)?;
    let (axis, values) = body.profile.axis_and_values();
    let side: Side = body.flank;
    let spec = GridSpec { side, axis, values, positions: body.face_width_positions_mm, tooth: body.tooth.unwrap_or(1) };
    let grid = FlankGrid::new(&gear, &spec, modifications.as_ref()).map_err(Problem::invalid)?;
    Ok(Computed { gear, side, modifications, grid, hand_assumed: body.gear.hand_assumed() })
}

/// Answers a request as a list of points, `id,x,y,z,i,j,k`; the id is `row.column`, both from 1.
/// Processor work.
pub fn csv(text: &[u8], room: Room) -> Result<Vec<u8>, Problem> {
    let grid = computed(text, room)?.grid;
    let columns = grid.columns().max(1);
    let listed = grid.points.iter().zip(&grid.normals).enumerate().map(|(k, (point, normal))| ListedPoint {
        id: Some(format!("{}.{}", k / columns + 1, k % columns + 1)),
        point: Vector::from(*point),
        direction: Some(Vector::from(*normal)),
        line: 0,
    });
    let text = table::write_points(&listed.collect::<Vec<_>>()).map_err(Problem::internal)?;
    Ok(text.into_bytes())
}

/// Answers a request. Processor work.
pub fn answer(text: &[u8], room: Room) -> Result<Vec<u8>, Problem> {
    let Computed { gear, side, modifications, grid, hand_assumed } = computed(text, room)?;
    let columns = grid.columns();
    // no coordinate is −0
    let row = |row: &[[f64; 3]]| Values { width: 3, flat: row.as_flattened().iter().map(|x| x + 0.0).collect() };
    let rows = |nodes: &[[f64; 3]]| nodes.chunks(columns.max(1)).map(row).collect();
    let relief = |modifications: &Modifications| {
        let of = |roll: &f64| grid.positions.iter().map(|z| modifications.relief(side, *roll, *z).value).collect();
        grid.roll_lengths.iter().map(of).collect()
    };
    let warnings = grid.warnings.iter().map(|warning| WarningBody::new(warning.code(), warning));
    let body = FlankBody {
        points: rows(&grid.points),
        normals: rows(&grid.normals),
        diameter_mm: grid.roll_lengths.iter().map(|roll| gear.diameter(*roll)).collect::<Vec<_>>().into(),
        relief_um: modifications.as_ref().map(relief),
        warnings: warnings.chain(hand_assumed).collect(),
        roll_length_mm: grid.roll_lengths.into(),
        z_mm: grid.positions.into(),
    };
    whole_of(1024 + 6 * TEXT_OF_NUMBER * grid.points.len(), &body).map_err(Problem::not_finite)
}
