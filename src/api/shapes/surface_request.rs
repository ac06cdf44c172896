//! A surface asked for: what it is made of and a method in, the surface and its report out.

use serde::Serialize;
use utoipa::ToSchema;

use super::{
    curve_points::ParametrizationName,
    fit_fields::{self, FIT_KEYS, FitFields},
    kept::Built,
    net::Net,
    point::PointBody,
    surface_given::{self, GIVEN_KEYS, GivenSurface, HeightGridBody},
    surface_method_reader::{self, Asked},
    surface_methods::{MeshBody, SurfaceMethodBody},
    surface_near, surface_result,
    surface_shape::BordersBody,
};
use crate::{
    api::{
        nodes_schema::NodesBody,
        problem::Problem,
        reader::{self, Fields, NoExtra},
    },
    estimation::{Faults, Nodes, Plans},
    geometry::surface::{
        Border,
        construct::{self, Given},
        construct_fault::{Field, SurfaceFault},
    },
};

// The two requests are declared for the document; `build` reads them.
/// A surface to build, of exactly one of `grid`, `xyz`, `boundaries`, `mesh`, `control_points` and `nodes`.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct SurfaceRequest {
    #[serde(flatten)]
    #[schema(inline)]
    pub of: SurfaceParts,
    pub method: SurfaceMethodBody,
    /// For `b_spline_least_squares`.
    #[serde(flatten)]
    #[schema(inline)]
    pub fit: FitFields,
}

/// A surface to build and to keep with an iteration; by default of the iteration's own nodes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct KeptSurfaceRequest {
    #[serde(flatten)]
    #[schema(inline)]
    pub of: SurfaceParts,
    pub method: SurfaceMethodBody,
    /// For `b_spline_least_squares`.
    #[serde(flatten)]
    #[schema(inline)]
    pub fit: FitFields,
}

/// What a surface is made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct SurfaceParts {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<HeightGridBody>,
    /// Points `[x, y, z]` in rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub xyz: Option<Vec<Vec<Vec<f64>>>>,
    /// Of `xyz`; default `chord_length`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parametrization: Option<ParametrizationName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundaries: Option<BordersBody>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshBody>,
    /// Of `boundaries` and `mesh`: how far apart two curves may be where they meet, in the caller's unit. Default 1e-6 of the largest
    /// coordinate at their ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub tolerance: Option<f64>,
    /// Rows along u, within a row along v.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control_points: Option<Vec<Vec<PointBody>>>,
    /// Scattered nodes or a grid with missing nodes, for `b_spline_least_squares`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<NodesBody>,
}

/// Builds the surface of a request, made of the nodes of an iteration where it says nothing else. Processor work.
pub fn build(text: &[u8], own: Option<&Nodes>, plans: &Plans) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let keys = [&GIVEN_KEYS[..], &["parametrization", "tolerance", "method"], &FIT_KEYS[..]].concat();
    let fields = Fields::of_request(text, &keys, &mut faults)?;
    let given = surface_given::read(&fields, own, &mut faults);
    let asked =
        fields.required("method", "", &mut faults).and_then(|slice| surface_method_reader::read(slice, &mut faults));
    let fit = fit_fields::read(&fields, asked.as_ref().is_some_and(Asked::is_near), &mut faults);
    let (Some(given), Some(asked), Some(fit)) = (given, asked, fit) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let name = asked.name.to_owned();
    // Without a word on the fit, a whole grid is fitted axis by axis, whatever its size.
    let plain = FIT_KEYS.iter().all(|key| fields.get(key).is_none());
    let (given, tolerance) = match given {
        GivenSurface::Own | GivenSurface::Scattered(_) => {
            let posted = match &given {
                GivenSurface::Scattered(text) => Some(read_nodes(text)?),
                _ => None,
            };
            let Some(nodes) = posted.as_ref().or(own) else { return Err(Problem::internal("no nodes")) };
            match whole_grid(nodes) {
                Some(given) if plain || !asked.is_near() => (given, None),
                _ => return surface_near::build(nodes, asked, fit, plans).map(|result| Built { method: name, result }),
            }
        }
        GivenSurface::Grid { u, v, z } if asked.is_near() && !plain => {
            let nodes =
                Nodes::grid(u, v, z.concat(), None, None).map_err(|faults| Problem::invalid(of_grid(&faults)))?;
            return surface_near::build(&nodes, asked, fit, plans).map(|result| Built { method: name, result });
        }
        GivenSurface::Grid { u, v, z } => (Given::Grid { u, v, z }, None),
        GivenSurface::Points { rows, parametrization } => (Given::Points { rows, parametrization }, None),
        GivenSurface::Boundaries { curves, tolerance } => {
            let cross = Box::new(asked.cross.clone());
            (Given::Boundaries { curves, cross, tolerance }, Some(tolerance))
        }
        GivenSurface::Mesh { mesh, tolerance } => (Given::Mesh { mesh, tolerance }, Some(tolerance)),
        GivenSurface::ControlPoints(net) => (control_points(net, &asked), None),
    };
    let built = construct::build(given, asked.method).map_err(|fault| refused(&fault, &fields))?;
    Ok(Built { method: name, result: surface_result::built(&built, tolerance)? })
}

fn read_nodes(text: &[u8]) -> Result<Nodes, Problem> {
    let request = [b"{\"nodes\":", text, b"}"].concat();
    let (nodes, NoExtra {}) = reader::read_nodes(&request)?;
    Ok(nodes)
}

/// A grid without missing nodes or weights.
fn whole_grid(nodes: &Nodes) -> Option<Given> {
    let Nodes::Grid(grid) = nodes else { return None };
    let missing = grid.valid.as_ref().is_some_and(|valid| valid.contains(&false)) || grid.z.iter().any(|z| z.is_nan());
    if missing || grid.weight.is_some() {
        return None;
    }
    let z = grid.z.chunks(grid.v.len().max(1)).map(<[f64]>::to_vec).collect();
    Some(Given::Grid { u: grid.u.clone(), v: grid.v.clone(), z })
}

/// Faults of nodes are faults of the grid they were made of.
fn of_grid(faults: &Faults) -> Faults {
    let mut out = Faults::default();
    for fault in faults.list() {
        out.push(fault.pointer.replacen("/nodes", "/grid", 1), fault.detail.clone());
    }
    out
}

fn control_points(net: Net, asked: &Asked) -> Given {
    Given::ControlPoints(construct::Net {
        rows: net.values.chunks(net.columns.max(1)).map(<[_]>::to_vec).collect(),
        dimension: net.dimension,
        weights: asked.weights.clone(),
        inner: asked.inner,
        domain: asked.domain,
    })
}

/// Where in the request the reason of a fault stands.
fn refused(fault: &SurfaceFault, fields: &Fields) -> Problem {
    let (field, indices) = fault.place();
    let mut indices = indices.into_iter();
    let base = GIVEN_KEYS.iter().find(|key| fields.get(key).is_some()).copied().unwrap_or("");
    let nodes = base == "grid" || base == "nodes";
    let border = |index: Option<usize>| index.and_then(|i| Border::ALL.get(i)).map_or("", |border| border.name());
    let mut pointer = match field {
        Field::U | Field::V | Field::Z if base.is_empty() => String::new(),
        Field::U if nodes || base == "mesh" => format!("/{base}/u"),
        Field::V if nodes || base == "mesh" => format!("/{base}/v"),
        Field::Z if nodes => format!("/{base}/z"),
        Field::U | Field::V | Field::Z | Field::Points => format!("/{base}"),
        Field::Boundaries => format!("/boundaries/{}", border(indices.next())),
        Field::Cross => format!("/method/cross_derivatives/{}", border(indices.next())),
        Field::Mesh => match indices.next() {
            Some(family) => format!("/mesh/{}", ["u_curves", "v_curves"][family.min(1)]),
            None => "/mesh".to_owned(),
        },
        Field::ControlPoints => "/control_points".to_owned(),
        Field::Inner => "/method/inner_points".to_owned(),
        Field::Weights => "/method/weights".to_owned(),
        Field::Knots => "/method/knots".to_owned(),
        Field::Degrees => "/method/degree".to_owned(),
        Field::Spans => "/method/spans".to_owned(),
        Field::Domain => "/method/domain".to_owned(),
        Field::Tolerance => "/tolerance".to_owned(),
        Field::Twists | Field::Method => "/method".to_owned(),
    };
    for index in indices {
        pointer.push_str(&format!("/{index}"));
    }
    Problem::invalid(Faults::one(pointer.trim_end_matches('/'), fault.to_string()))
}
