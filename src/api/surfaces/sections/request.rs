//! Sections of a surface by planes as they are asked for.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{
    faults::Faults,
    json::{members::of_request, request::request},
    problem::Problem,
};
use flankfit_engine::{
    geometry::{
        space::Vector,
        surface::{
            SurfaceShape,
            section::{Description, at_right_angles},
        },
    },
    words::Shown,
};

/// Most points of all sections.
pub(super) const MOST_POINTS: usize = 200_000;
/// How near curves come to the section where nothing is said, as splines and as chords.
const TOLERANCES: [f64; 2] = [1e-9, 1e-3];

request! {
    /// A surface and planes.
    pub struct SectionsRequest as SectionsRequestMembers {
        required surface: SurfaceShape,
        /// One or two families of parallel planes.
        #[schema(min_items = 1, max_items = 2)]
        required families: Vec<PlaneFamilyBody>,
        /// Default `b_spline`.
        optional form: SectionFormName,
        /// Largest distance of curves or chords from the section, in the unit of the request.
        /// Points of polylines lie on it up to rounding. Default 1e-9 for splines and 0.001 for
        /// polylines.
        #[schema(exclusive_minimum = 0)]
        optional tolerance: f64,
        /// If true, two families at right angles are also returned as a mesh of curves: heights
        /// over the frame of their normals, as `mesh` of `POST /v1/surfaces` takes them. Every
        /// plane must then cut the surface in one curve that crosses all planes of the other
        /// family. Default false.
        optional mesh: bool,
    }
}

/// Parallel planes: all points whose distance from the origin along the normal is an offset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PlaneFamily)]
pub struct PlaneFamilyBody {
    /// `[x, y, z]` of any length above 0; of a graph the parameters are x and y.
    #[schema(value_type = Vec<f64>, min_items = 3, max_items = 3)]
    pub normal: [f64; 3],
    /// Ascending, in the caller's unit of length; of a mesh 2 or more.
    #[schema(min_items = 1, max_items = 1000)]
    pub offsets: Vec<f64>,
}

/// Form of the curves of sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SectionForm)]
pub enum SectionFormName {
    /// Cubic B-splines over the length, through points of the section with its tangents.
    BSpline,
    /// Points of the section in a row.
    Polyline,
}

/// Parallel planes with a normal of length 1.
pub(super) struct Planes {
    pub normal: Vector,
    pub offsets: Vec<f64>,
}

/// A valid request.
pub(super) struct Checked {
    pub surface: SurfaceShape,
    pub families: Vec<Planes>,
    pub how: Description,
    pub mesh: bool,
}

pub(super) fn read(text: &[u8]) -> Result<Checked, Problem> {
    let mut faults = Faults::default();
    let members: SectionsRequestMembers<'_> = of_request(text, &mut faults)?;
    let surface = members.surface.required(&mut faults);
    let families = members.families.required(&mut faults);
    let chords = members.form.read(&mut faults) == Some(SectionFormName::Polyline);
    let tolerance = members.tolerance.read(&mut faults).unwrap_or(TOLERANCES[usize::from(chords)]);
    let mesh = members.mesh.read(&mut faults).unwrap_or(false);
    let families = families.map(|families| checked(&families, mesh, &mut faults));
    let (Some(surface), Some(families)) = (surface, families) else { return Err(Problem::invalid(faults)) };
    let how = Description { tolerance, chords, most: MOST_POINTS };
    faults.into_result(Checked { surface, families, how, mesh }).map_err(Problem::invalid)
}

fn checked(families: &[PlaneFamilyBody], mesh: bool, faults: &mut Faults) -> Vec<Planes> {
    if mesh && families.len() != 2 {
        faults.push("/families", "a mesh is made of 2 families");
    }
    let family = |(k, PlaneFamilyBody { normal, offsets }): (usize, &PlaneFamilyBody)| {
        let normal = Vector::from(*normal);
        // scaled first, so that squares stay within double
        let largest = normal.amax();
        if largest == 0.0 {
            faults.push(format!("/families/{k}/normal"), "a normal has a length above 0");
        }
        let normal = (normal / largest).normalize();
        if mesh && offsets.len() < 2 {
            faults.push(format!("/families/{k}/offsets"), "1 plane; a mesh needs 2 or more");
        }
        for (i, pair) in offsets.windows(2).enumerate() {
            if !(pair[0] < pair[1]) {
                let detail = format!("{} is not greater than {}", Shown(pair[1]), Shown(pair[0]));
                faults.push(format!("/families/{k}/offsets/{}", i + 1), detail);
            }
        }
        Planes { normal, offsets: offsets.clone() }
    };
    let planes: Vec<Planes> = families.iter().enumerate().take(2).map(family).collect();
    if let (true, [one, other]) = (mesh, &planes[..]) {
        // said before all planes are cut
        if let Err(skew) = at_right_angles([one.normal, other.normal]) {
            faults.push("/families", skew.to_string());
        }
    }
    planes
}
