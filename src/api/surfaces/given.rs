//! Data of a surface: read from a request, or the nodes of an iteration.

use std::borrow::Cow;

use super::{
    methods::net,
    source::{HeightGridMembers, SurfaceSourceMembers},
};
use crate::api::{
    faults::Faults,
    fits::reader::nodes::RawNodes,
    json::members::{Member, of_object},
};
use flankfit_engine::{
    estimation::Nodes,
    geometry::{
        contract::{Borders, Net, Point},
        curve::{CurveShape, Parametrization},
        space::{Dimension, Vector},
        surface::{boundaries::default_tolerance, mesh::CurveMesh},
    },
    words::counted,
};

/// Data of the surface.
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
            faults.push(format!("/{second}"), format!("give exactly one of {}", names()));
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
            let tolerance = tolerance.optional(faults)?;
            let curves = boundaries.required(faults).map(Borders::curves)?;
            let tolerance = tolerance.unwrap_or_else(|| default_tolerance(curves.iter().flatten()));
            Some(GivenSurface::Boundaries { curves: Box::new(curves), tolerance })
        }
        "mesh" => {
            let mesh: CurveMesh = mesh.required(faults)?;
            let tolerance = tolerance.optional(faults)?;
            let curves = || mesh.over_v.iter().chain(&mesh.over_u).flatten();
            let tolerance = tolerance.unwrap_or_else(|| default_tolerance(curves()));
            Some(GivenSurface::Mesh { mesh, tolerance })
        }
        "control_points" => {
            let rows = control_points.required(faults)?;
            net(&rows, &control_points.pointer(), faults).map(GivenSurface::ControlPoints)
        }
        _ => Some(GivenSurface::Nodes(Cow::Owned(RawNodes::required(nodes, faults)?))),
    }
}

fn of_nodes<'a>(own: Option<&'a Nodes>, alternatives: &str, faults: &mut Faults) -> Option<GivenSurface<'a>> {
    match own {
        Some(nodes @ (Nodes::Grid(_) | Nodes::Scattered(_))) => Some(GivenSurface::Nodes(Cow::Borrowed(nodes))),
        Some(_) => {
            faults.push("", "the nodes of this iteration have no u and v: give the data of the surface");
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
    xyz: &Member<'_, Vec<Vec<Point>>>,
    parametrization: &Member<'_, Parametrization>,
    faults: &mut Faults,
) -> Option<GivenSurface<'static>> {
    const AT: &str = "/xyz";
    let parametrization = parametrization.optional(faults)?.unwrap_or(Parametrization::ChordLength);
    let net = net(&xyz.required(faults)?, AT, faults)?;
    if net.dimension != Dimension::Space {
        faults.push(format!("{AT}/0/0"), "points [x, y, z] are needed");
        return None;
    }
    Some(GivenSurface::Points { rows: net.values.chunks(net.columns).map(<[_]>::to_vec).collect(), parametrization })
}
