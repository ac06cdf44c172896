//! What a surface is made of: read from a request, or the nodes of an iteration.

use std::borrow::Cow;

use super::{
    methods::MeshMembers,
    source::{HeightGridMembers, SurfaceSourceMembers},
};
use crate::api::{
    curves::points::ParametrizationName,
    faults::Faults,
    fits::reader::nodes::RawNodes,
    json::{
        members::{Member, of_object},
        slice::Slice,
        value::read_first,
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
    geometry::{
        curve::{CurveShape, Parametrization},
        space::{Dimension, Vector},
        surface::mesh::CurveMesh,
    },
    words::counted,
};

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

/// Reads what the members of a request give.
pub fn read<'a>(
    source: SurfaceSourceMembers<'_>,
    own: Option<&'a Nodes>,
    faults: &mut Faults,
) -> Option<GivenSurface<'a>> {
    let alternatives = source.alternatives();
    let names = || alternatives.map(|(name, _)| name).join(", ");
    let there: Vec<_> = alternatives.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect();
    let kind = match there[..] {
        [name] => name,
        [] => return of_nodes(own, &names(), faults),
        [_, second, ..] => {
            faults.push(format!("/{second}"), format!("exactly one of {} is wanted", names()));
            return None;
        }
    };
    for (option, of) in [
        (source.parametrization.name_if_given(), &["xyz"][..]),
        (source.tolerance.name_if_given(), &["boundaries", "mesh"]),
    ] {
        if let Some(option) = option.filter(|_| !of.contains(&kind)) {
            faults.push(format!("/{option}"), format!("it belongs to {}", of.join(" and ")));
            return None;
        }
    }
    let SurfaceSourceMembers { grid, xyz, parametrization, boundaries, mesh, tolerance, control_points, nodes } =
        source;
    match kind {
        "grid" => read_grid(grid.text()?, faults),
        "xyz" => points(&xyz, &parametrization, faults),
        "boundaries" => {
            let (curves, tolerance) = boundary_curves(&boundaries, &tolerance, faults)?;
            Some(GivenSurface::Boundaries { curves: Box::new(curves), tolerance })
        }
        "mesh" => read_mesh(mesh.text()?, &tolerance, faults),
        "control_points" => {
            let _text = control_points.required_text(faults)?;
            let rows = control_points.optional(faults).flatten()?;
            Some(GivenSurface::ControlPoints(Net::read(&rows, &control_points.pointer(), faults)?))
        }
        _ => Some(GivenSurface::Nodes(Cow::Owned(RawNodes::required(nodes, faults)?))),
    }
}

fn of_nodes<'a>(own: Option<&'a Nodes>, alternatives: &str, faults: &mut Faults) -> Option<GivenSurface<'a>> {
    match own {
        Some(nodes @ (Nodes::Grid(_) | Nodes::Scattered(_))) => Some(GivenSurface::Nodes(Cow::Borrowed(nodes))),
        Some(_) => {
            faults.push("", "the nodes of this iteration have no u and v: say what the surface is made of");
            None
        }
        None => {
            faults.push("", format!("one of {alternatives} is missing"));
            None
        }
    }
}

fn read_grid(slice: &[u8], faults: &mut Faults) -> Option<GivenSurface<'static>> {
    let grid: HeightGridMembers<'_> = of_object(slice, "/grid", faults)?;
    let (u, v, z) = (grid.u.numbers(faults), grid.v.numbers(faults), grid.z.rows(faults));
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

fn points(
    xyz: &Member<'_, Vec<Vec<Vec<f64>>>>,
    parametrization: &Member<'_, ParametrizationName>,
    faults: &mut Faults,
) -> Option<GivenSurface<'static>> {
    const AT: &str = "/xyz";
    let name = parametrization.optional(faults)?;
    // a number in place of a point is refused with the points of other kinds
    let rows: Vec<Vec<PointBody>> = read_first(xyz.text()?, AT, faults)?;
    equal_rows(&rows, AT, faults)?;
    let net = Net::read(&rows, AT, faults)?;
    if net.dimension != Dimension::Space {
        faults.push(format!("{AT}/0/0"), "points [x, y, z] are wanted");
        return None;
    }
    let parametrization = name.unwrap_or(ParametrizationName::ChordLength);
    Some(GivenSurface::Points { rows: net.values.chunks(net.columns).map(<[_]>::to_vec).collect(), parametrization })
}

fn read_mesh(slice: &[u8], tolerance: &Member<'_, f64>, faults: &mut Faults) -> Option<GivenSurface<'static>> {
    let mesh: MeshMembers<'_> = of_object(slice, "/mesh", faults)?;
    let (us, vs) = (mesh.u.numbers(faults), mesh.v.numbers(faults));
    let over_v = mesh.u_curves.required_with(faults, curves);
    let over_u = mesh.v_curves.required_with(faults, curves);
    let tolerance = tolerance.optional(faults)?;
    let mesh = CurveMesh { us: us?, vs: vs?, over_v: over_v?, over_u: over_u? };
    let tolerance = tolerance.unwrap_or_else(|| corner_tolerance(mesh.over_v.iter().chain(&mesh.over_u).flatten()));
    Some(GivenSurface::Mesh { mesh, tolerance })
}

/// Curves of a family; `null` where one is missing.
fn curves(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Vec<Option<CurveShape>>> {
    let texts: Vec<Option<Slice>> = read_first(slice, at, faults)?;
    let before = faults.count();
    let read = |(i, text): (usize, &Option<Slice>)| {
        let text = text.as_ref()?;
        read_curve(text.0, &format!("{at}/{i}"), faults)
    };
    let curves = texts.iter().enumerate().map(read).collect();
    (faults.count() == before).then_some(curves)
}
