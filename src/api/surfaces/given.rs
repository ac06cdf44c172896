//! What a surface is made of: read from a request, or the nodes of an iteration.

use std::borrow::Cow;

use serde::Serialize;
use utoipa::ToSchema;

use crate::api::{
    curves::points::ParametrizationName,
    faults::Faults,
    fits::reader,
    json::{
        error::ReadError,
        extra::NoExtra,
        fields::{Fields, read_numbers, read_rows},
        part::read_part,
        slice::Slice,
    },
    shapes::{
        curve_shape::read_curve,
        net::{Net, equal_rows},
        point::PointBody,
        surface_reader::{boundary_curves, corner_tolerance},
    },
};
use flankfit_engine::{
    estimation::Nodes,
    fault::words::counted,
    geometry::{
        curve::{CurveShape, Parametrization},
        space::{Dimension, Vector},
        surface::mesh::CurveMesh,
    },
};

// Declared for the document; `read` reads it.
/// A grid of nodes: heights z(u, v) over two axes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = HeightGrid)]
pub struct HeightGridBody {
    /// Ascending.
    pub u: Vec<f64>,
    /// Ascending.
    pub v: Vec<f64>,
    /// A row for each u, within a row a height for each v. None may be missing.
    pub z: Vec<Vec<f64>>,
}

/// The fields of a request of which exactly one says what the surface is made of.
pub const GIVEN_KEYS: [&str; 6] = ["grid", "xyz", "boundaries", "mesh", "control_points", "nodes"];

/// What the surface is made of.
pub enum GivenSurface<'a> {
    Grid {
        u: Vec<f64>,
        v: Vec<f64>,
        z: Vec<Vec<f64>>,
    },
    Points {
        rows: Vec<Vec<Vector>>,
        parametrization: Parametrization,
    },
    Boundaries {
        curves: Box<[Option<CurveShape>; 4]>,
        tolerance: f64,
    },
    Mesh {
        mesh: CurveMesh,
        tolerance: f64,
    },
    ControlPoints(Net),
    /// Posted, or those of an iteration.
    Nodes(Cow<'a, Nodes>),
}

/// Reads what the fields of a request give.
pub fn read<'a>(fields: &Fields, own: Option<&'a Nodes>, faults: &mut Faults) -> Option<GivenSurface<'a>> {
    let there: Vec<_> = GIVEN_KEYS.iter().filter(|key| fields.get(key).is_some()).collect();
    let key = match there[..] {
        [key] => *key,
        [] => return of_nodes(own, faults),
        [_, second, ..] => {
            faults.push(format!("/{second}"), format!("exactly one of {} is wanted", GIVEN_KEYS.join(", ")));
            return None;
        }
    };
    for (option, of) in [("parametrization", &["xyz"][..]), ("tolerance", &["boundaries", "mesh"])] {
        if fields.get(option).is_some() && !of.contains(&key) {
            faults.push(format!("/{option}"), format!("it belongs to {}", of.join(" and ")));
            return None;
        }
    }
    let slice = fields.get(key)?;
    match key {
        "grid" => grid(slice, faults),
        "xyz" => points(slice, fields.get("parametrization"), faults),
        "boundaries" => {
            let (curves, tolerance) = boundary_curves(fields, "", faults)?;
            Some(GivenSurface::Boundaries { curves: Box::new(curves), tolerance })
        }
        "mesh" => mesh(slice, fields.get("tolerance"), faults),
        "control_points" => {
            let rows: Vec<Vec<PointBody>> = read_part(slice, "/control_points", faults)?;
            Some(GivenSurface::ControlPoints(Net::read(&rows, "/control_points", faults)?))
        }
        _ => posted_nodes(slice, faults),
    }
}

fn posted_nodes(slice: &[u8], faults: &mut Faults) -> Option<GivenSurface<'static>> {
    let request = [b"{\"nodes\":", slice, b"}"].concat();
    match reader::read_nodes(&request) {
        Ok((nodes, NoExtra {})) => Some(GivenSurface::Nodes(Cow::Owned(nodes))),
        Err(ReadError::Invalid(found)) => {
            faults.append(found);
            None
        }
        // the request as a whole was found to be JSON
        Err(ReadError::Malformed { detail }) => {
            faults.push("/nodes", detail);
            None
        }
    }
}

fn of_nodes<'a>(own: Option<&'a Nodes>, faults: &mut Faults) -> Option<GivenSurface<'a>> {
    match own {
        Some(nodes @ (Nodes::Grid(_) | Nodes::Scattered(_))) => Some(GivenSurface::Nodes(Cow::Borrowed(nodes))),
        Some(_) => {
            faults.push("", "the nodes of this iteration have no u and v: say what the surface is made of");
            None
        }
        None => {
            faults.push("", format!("one of {} is missing", GIVEN_KEYS.join(", ")));
            None
        }
    }
}

fn grid(slice: &[u8], faults: &mut Faults) -> Option<GivenSurface<'static>> {
    let fields = Fields::of_part(slice, "/grid", &["u", "v", "z"], faults)?;
    let mut axis = |name: &str| {
        let slice = fields.required(name, "/grid", faults)?;
        read_numbers(slice, &format!("/grid/{name}"), faults)
    };
    let (u, v) = (axis("u"), axis("v"));
    let z = fields.required("z", "/grid", faults).and_then(|slice| read_rows(slice, "/grid/z", faults));
    let (u, v, (flat, lengths)) = (u?, v?, z?);
    if lengths.len() != u.len() {
        faults.push(
            "/grid/z",
            format!("{} for {} of u", counted(lengths.len(), "row", "rows"), counted(u.len(), "value", "values")),
        );
        return None;
    }
    let mut rest = flat.as_slice();
    let z = lengths
        .iter()
        .map(|length| {
            let (row, after) = rest.split_at(*length);
            rest = after;
            row.to_vec()
        })
        .collect();
    Some(GivenSurface::Grid { u, v, z })
}

fn points(slice: &[u8], parametrization: Option<&[u8]>, faults: &mut Faults) -> Option<GivenSurface<'static>> {
    const AT: &str = "/xyz";
    let name: Option<ParametrizationName> = match parametrization {
        Some(slice) => Some(read_part(slice, "/parametrization", faults)?),
        None => None,
    };
    let rows: Vec<Vec<PointBody>> = read_part(slice, AT, faults)?;
    equal_rows(&rows, AT, faults)?;
    let net = Net::read(&rows, AT, faults)?;
    if net.dimension != Dimension::Space {
        faults.push(format!("{AT}/0/0"), "points [x, y, z] are wanted");
        return None;
    }
    let parametrization = name.unwrap_or(ParametrizationName::ChordLength).into();
    Some(GivenSurface::Points { rows: net.values.chunks(net.columns).map(<[_]>::to_vec).collect(), parametrization })
}

fn mesh(slice: &[u8], tolerance: Option<&[u8]>, faults: &mut Faults) -> Option<GivenSurface<'static>> {
    let fields = Fields::of_part(slice, "/mesh", &["u", "v", "u_curves", "v_curves"], faults)?;
    let mut axis = |name: &str| {
        let slice = fields.required(name, "/mesh", faults)?;
        read_numbers(slice, &format!("/mesh/{name}"), faults)
    };
    let (us, vs) = (axis("u"), axis("v"));
    let mut family = |name: &str| {
        let slice = fields.required(name, "/mesh", faults)?;
        curves(slice, &format!("/mesh/{name}"), faults)
    };
    let (over_v, over_u) = (family("u_curves"), family("v_curves"));
    let tolerance: Option<f64> = match tolerance {
        Some(slice) => Some(read_part(slice, "/tolerance", faults)?),
        None => None,
    };
    let mesh = CurveMesh { us: us?, vs: vs?, over_v: over_v?, over_u: over_u? };
    let tolerance = tolerance.unwrap_or_else(|| corner_tolerance(mesh.over_v.iter().chain(&mesh.over_u).flatten()));
    Some(GivenSurface::Mesh { mesh, tolerance })
}

/// Curves of a family; `null` where one is missing.
fn curves(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Vec<Option<CurveShape>>> {
    let texts: Vec<Option<Slice>> = read_part(slice, at, faults)?;
    let before = faults.count();
    let read = |(i, text): (usize, &Option<Slice>)| {
        let text = text.as_ref()?;
        read_curve(text.0, &format!("{at}/{i}"), faults)
    };
    let curves = texts.iter().enumerate().map(read).collect();
    (faults.count() == before).then_some(curves)
}
