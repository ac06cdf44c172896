//! Sections of a surface by planes as they are answered.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{contract::Triple, warning::WarningBody};
use flankfit_engine::geometry::{
    curve::CurveShape,
    space::Vector,
    surface::{
        mesh::CurveMesh,
        section::{Section, SectionCurve},
    },
};

/// Sections in the order of the planes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Sections)]
pub struct SectionsBody {
    /// In the order of the request.
    pub families: Vec<SectionFamilyBody>,
    /// With `mesh` of the request: heights along the third vector of `mesh_frame` over distances
    /// from the origin along the first and the second. `mesh` of `POST /v1/surfaces` takes it
    /// unchanged.
    pub mesh: Option<CurveMesh>,
    /// The unit vectors `[x, y, z]` along which u, v and heights of the mesh are counted: the
    /// normals of the two families and their vector product.
    #[schema(value_type = Option<Vec<Triple>>, min_items = 3, max_items = 3)]
    pub mesh_frame: Option<Vec<Vec<f64>>>,
    /// The largest difference in height that was found between curves of the mesh and the surface,
    /// in the caller's unit.
    pub mesh_error: Option<f64>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
}

/// Sections by parallel planes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SectionFamily)]
pub struct SectionFamilyBody {
    /// In the order of the offsets.
    pub sections: Vec<SectionBody>,
}

/// The section by one plane; without curves where the plane misses the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Section)]
pub struct SectionBody {
    /// Offset of the plane, in the unit of the request.
    pub offset: f64,
    /// Curves without corners, in no particular order.
    pub curves: Vec<SectionCurveBody>,
    /// `[x, y, z]` where branches cross; curves end there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(value_type = Vec<Triple>)]
    pub branch_points: Vec<Vec<f64>>,
    /// `[x, y, z]` where the plane touches the surface in a point.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(value_type = Vec<Triple>)]
    pub contact_points: Vec<Vec<f64>>,
    /// `[x, y, z]` of places where the section could not be determined, at most 1,000; a warning is
    /// included.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(value_type = Vec<Triple>)]
    pub unresolved_points: Vec<Vec<f64>>,
    /// True if a part of the surface lies in the plane; the curves exclude it.
    pub coincident: bool,
}

/// A curve of a section.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SectionCurve)]
pub struct SectionCurveBody {
    /// Curve in space with arc length as parameter; for the form `b_spline`.
    pub curve: Option<CurveShape>,
    /// `[x, y, z]` each; a closed curve repeats the first point at the end. For the form
    /// `polyline`.
    #[schema(value_type = Option<Vec<Triple>>)]
    pub points: Option<Vec<Vec<f64>>>,
    /// True if it is closed and smooth at the joint.
    pub closed: bool,
    /// True if the plane is tangent to the surface along the curve.
    pub tangential: bool,
    /// Length of the section's curve, in the caller's unit.
    pub length: f64,
    /// Largest distance found between the curve, or its chords, and the section, rounding included,
    /// in the unit of the request.
    pub error: f64,
}

/// Most places that are answered as unresolved.
const MOST_UNRESOLVED: usize = 1000;

pub(super) fn coordinates(point: &Vector) -> Vec<f64> {
    point.as_slice().to_vec()
}

/// `None` where a curve leaves the range of doubles.
pub(super) fn written(found: &Section, offset: f64, chords: bool) -> Option<SectionBody> {
    Some(SectionBody {
        offset,
        curves: found.curves.iter().map(|curve| written_curve(curve, chords)).collect::<Option<_>>()?,
        branch_points: found.branch_points.iter().map(coordinates).collect(),
        contact_points: found.contacts.iter().map(coordinates).collect(),
        unresolved_points: found.unresolved.iter().take(MOST_UNRESOLVED).map(coordinates).collect(),
        coincident: found.coincident,
    })
}

fn written_curve(curve: &SectionCurve, chords: bool) -> Option<SectionCurveBody> {
    let points = || curve.points.iter().map(|place| coordinates(&place.point)).collect();
    Some(SectionCurveBody {
        curve: if chords { None } else { Some(curve.shape().ok()?) },
        points: chords.then(points),
        closed: curve.closed,
        tangential: curve.tangential,
        length: curve.length(),
        error: curve.error,
    })
}
