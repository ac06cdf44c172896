//! A surface asked for: what it is made of and a method in, the surface and its report out.

use super::{
    given::{self, GivenSurface},
    methods::{Requested, SurfaceMethod},
    near, result,
    source::SurfaceSource,
};
use crate::api::{
    built::Built,
    faults::{Faults, pointer_of},
    fits::{reader::fields, spec::request::FitFields},
    json::{
        members::{self, of_request},
        request::request,
    },
    problem::Problem,
    shapes::THROUGH,
};
use flankfit_engine::{
    estimation::{Nodes, Plans},
    geometry::{
        contract::Net,
        surface::construct::{self, Given, Method},
    },
    numerics::check,
};

/// Most patches of a mesh or grid that is filled.
const MOST_PATCHES: usize = 10_000;

request! {
    /// A surface to build from exactly one of `grid`, `xyz`, `boundaries`, `mesh`, `control_points`
    /// and `nodes`. For a surface of an iteration, the default is the iteration's nodes.
    pub struct SurfaceRequest as SurfaceRequestMembers {
        flatten of: SurfaceSource,
        required method: SurfaceMethod,
        /// For `b_spline_least_squares`.
        flatten fit: FitFields,
    }
}

/// Builds the surface of a request, made of the nodes of an iteration where it says nothing else.
/// Processor work.
pub fn build(text: &[u8], own: Option<&Nodes>, plans: &Plans) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let SurfaceRequestMembers { of, method, fit } = of_request(text, &mut faults)?;
    let kind = of.kind();
    let given = given::read(of, own, &mut faults);
    let requested = method.required(&mut faults).and_then(|method| method.requested(&mut faults));
    // Without a word on the fit, a whole grid is fitted axis by axis, whatever its size.
    let fit_given = members::given(&fit);
    let plain = fit_given.is_empty();
    let fit = fields::read(
        &fit,
        requested.as_ref().is_none_or(|requested| !requested.is_near()).then_some(THROUGH),
        &mut faults,
    );
    let (Some(given), Some(requested), Some(fit)) = (given, requested, fit) else {
        return Err(Problem::invalid(faults));
    };
    faults.into_result(()).map_err(Problem::invalid)?;
    let name = requested.name.to_owned();
    let near = |nodes: &Nodes, requested, base| {
        near::build(nodes, requested, fit, plans, base).map(|result| Built { method: name.clone(), result })
    };
    let (given, tolerance) = match given {
        GivenSurface::Nodes(nodes) => match whole_grid(&nodes) {
            Some(given) if plain || !requested.is_near() => (given, None),
            _ => return near(&nodes, requested, "/nodes"),
        },
        GivenSurface::Grid { u, v, z } if requested.is_near() && !plain => {
            let nodes = Nodes::grid(u, v, z.concat(), None, None)
                .map_err(|found| Problem::invalid(Faults::of_engine("/grid", &found)))?;
            return near(&nodes, requested, "/grid");
        }
        GivenSurface::Grid { u, v, z } => (Given::Grid { u, v, z }, None),
        GivenSurface::Points { .. } if requested.is_near() && !plain => {
            let mut faults = Faults::default();
            for key in fit_given {
                let detail = "points of space are fitted by plain least squares, axis by axis; this belongs to `nodes` \
                    or `grid`";
                faults.push(format!("/{key}"), detail);
            }
            return Err(Problem::invalid(faults));
        }
        GivenSurface::Points { rows, parametrization } => (Given::Points { rows, parametrization }, None),
        GivenSurface::Boundaries { curves, tolerance } => {
            let cross = Box::new(requested.cross.clone());
            (Given::Boundaries { curves, cross, tolerance }, Some(tolerance))
        }
        GivenSurface::Mesh { mesh, tolerance } => (Given::Mesh { mesh, tolerance }, Some(tolerance)),
        GivenSurface::ControlPoints(net) => (control_points(net, &requested), None),
    };
    check_patches(&given, &requested.method)?;
    let nodes = match &given {
        Given::Grid { u, v, .. } => Some(u.len() * v.len()),
        Given::Points { rows, .. } => Some(rows.iter().map(Vec::len).sum()),
        _ => None,
    };
    let built = construct::build(given, requested.method)
        .map_err(|found| Problem::invalid(Faults::placed(&found, |path| place(path, kind))))?;
    Ok(Built { method: name, result: result::built(&built, nodes, tolerance)? })
}

/// Limits the number of patches: each joint is examined and reported.
fn check_patches(given: &Given, method: &Method) -> Result<(), Problem> {
    let (at, [rows, columns]) = match given {
        Given::Grid { u, v, .. } => ("/grid", [u.len(), v.len()]),
        Given::Points { rows, .. } => ("/xyz", [rows.len(), rows.first().map_or(0, Vec::len)]),
        Given::Mesh { mesh, .. } => ("/mesh", [mesh.us.len(), mesh.vs.len()]),
        Given::Boundaries { .. } | Given::ControlPoints(_) => return Ok(()),
    };
    let fills =
        matches!(method, Method::CoonsBilinear | Method::CoonsBicubic { .. } | Method::Gregory | Method::Bezier);
    let patches = rows.saturating_sub(1).saturating_mul(columns.saturating_sub(1));
    if fills && patches > MOST_PATCHES {
        let detail = format!("{patches} patches are more than {MOST_PATCHES}: use a B-spline for so many nodes");
        return Err(Problem::invalid(Faults::one(at, detail)));
    }
    Ok(())
}

/// A grid without missing nodes or weights.
fn whole_grid(nodes: &Nodes) -> Option<Given> {
    let Nodes::Grid(grid) = nodes else { return None };
    let missing =
        grid.valid().as_ref().is_some_and(|valid| valid.contains(&false)) || grid.z().iter().any(|z| z.is_nan());
    if missing || grid.weight().is_some() {
        return None;
    }
    let z = grid.z().chunks(grid.v().len().max(1)).map(<[f64]>::to_vec).collect();
    Some(Given::Grid { u: grid.u().to_vec(), v: grid.v().to_vec(), z })
}

fn control_points(net: Net, requested: &Requested) -> Given {
    Given::ControlPoints(construct::Net {
        rows: net.values.chunks(net.columns.max(1)).map(<[_]>::to_vec).collect(),
        dimension: net.dimension,
        weights: requested.weights.clone(),
        inner: requested.inner,
        domain: requested.domain,
    })
}

/// The pointer of a path of the construction, of what is given as `kind`.
fn place(path: &str, kind: Option<&str>) -> String {
    let base = kind.map_or_else(String::new, |kind| format!("/{kind}"));
    if let Some(rest) = check::rest_of(path, "nodes") {
        return match (kind, rest.split_at(rest[1..].find('[').map_or(rest.len(), |end| end + 1))) {
            (Some("grid" | "nodes" | "mesh"), _) => base + &pointer_of(rest),
            // a column of points has no pointer of its own: that of its first point
            (Some("xyz"), (".v", index)) => format!("/xyz/0{}", pointer_of(index)),
            (_, (_, index)) => base + &pointer_of(index),
        };
    }
    match path.split(['.', '[']).next() {
        Some("boundaries" | "mesh" | "control_points" | "tolerance" | "method") => pointer_of(path),
        _ => match check::rest_of(path, "twists") {
            Some(rest) => format!("/method{}", pointer_of(rest)),
            None => format!("/method{}", pointer_of(path)),
        },
    }
}
