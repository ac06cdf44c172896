//! Quantities derived from the data of a gear.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{
    gears::gear::GearBody,
    json::{value::read_json, writer},
    problem::Problem,
    warning::WarningBody,
};
use flankfit_engine::gear::Geometry;

/// A gear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = GearGeometryRequest)]
pub struct GeometryRequestBody {
    pub gear: GearBody,
}

/// Derived quantities of a gear, with warnings.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = GearGeometry)]
pub struct GeometryBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub geometry: Geometry,
    /// Warnings about the gear: undercut, a pointed tip and the like.
    pub warnings: Vec<WarningBody>,
}

/// Answers a request.
pub fn answer(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let body: GeometryRequestBody = read_json(text)?;
    let gear = body.gear.checked("/gear").map_err(Problem::invalid)?;
    let geometry = Geometry::of(&gear);
    let warnings = warnings(&body.gear, &geometry);
    writer::whole(&GeometryBody { geometry, warnings }).map_err(Problem::not_finite)
}

/// Returns warnings about unusual or missing data of a gear.
pub(in crate::api) fn warnings(body: &GearBody, geometry: &Geometry) -> Vec<WarningBody> {
    let mut warnings: Vec<WarningBody> = geometry.warnings.iter().map(WarningBody::from).collect();
    warnings.extend(body.hand_assumed());
    warnings
}
