//! Construction of all surfaces: from data and a method to the surface with a report.

pub use super::method::{Given, Method, Net};
use super::{
    BSplineSurface, BezierSurface, Boundaries, CoonsPatch, GregoryPatch, NodeGrid, Surface, SurfaceShape, check,
    continuity::{Joint, Worst, joints},
    coons::{Twists, corner_twists},
    gregory::GregoryNet,
    gregory_fill::{deviation, gregory},
    grid::check_degree,
    interpolate::interpolate,
    least_squares::least_squares,
    mesh::{CurveMesh, Fill, bicubic},
    triangle::{DegenerateBorder, degenerate_borders},
};
use crate::{
    BSplineBasis,
    curve::{CurveShape, KnotChoice, interpolate::interpolate as interpolated_curve},
    space::{Dimension, Vector},
};
use flankfit_numerics::{
    check::{Fault, Faults},
    words::counted,
};

/// Places between two crossing lines at which the continuity across a line is looked at.
const LOOKS: usize = 9;

/// A surface and what is to be said of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// The surface.
    pub shape: SurfaceShape,
    /// Parameters of the nodes along u and v, of a grid.
    pub parameters: Option<[Vec<f64>; 2]>,
    /// Sum of squared distances from the nodes, of a least-squares fit.
    pub residual_sum_of_squares: Option<f64>,
    /// The largest gap between curves that meet, of a mesh.
    pub gap: Option<Worst>,
    /// How far the surface is from its boundary curves at worst: where patches have cubic borders,
    /// or curves leave gaps.
    pub deviation: Option<Worst>,
    /// How its patches meet.
    pub joints: Vec<Joint>,
    /// Borders that are points.
    pub degenerate: Vec<DegenerateBorder>,
}

/// Makes a surface.
///
/// ```
/// use flankfit_geometry::surface::{Given, Method, build};
///
/// // z = u + 2v through its grid, degree 1 both ways.
/// let z = vec![vec![0.0, 2.0, 4.0], vec![1.0, 3.0, 5.0]];
/// let given = Given::Grid { u: vec![0.0, 1.0], v: vec![0.0, 1.0, 2.0], z };
/// let built = build(given, Method::BSpline { degrees: [1, 1], knots: [None, None] })?;
/// assert_eq!(built.shape.surface().value(0.5, 1.5).x, 3.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn build(given: Given, method: Method) -> Result<Built, Faults> {
    let mut built = match given {
        Given::Grid { u, v, z } => on_grid(heights(u, v, &z)?, method)?,
        Given::Points { rows, parametrization } => on_grid(NodeGrid::rows(&rows, parametrization)?, method)?,
        Given::Boundaries { curves, cross, tolerance } => in_boundaries(*curves, *cross, tolerance, method)?,
        Given::Mesh { mesh, tolerance } => in_mesh(&mesh, tolerance, &method, "a mesh")?,
        Given::ControlPoints(net) => of_net(net, method)?,
    };
    if let SurfaceShape::Patchwork(work) = &built.shape {
        built.joints = joints(work, LOOKS);
    }
    built.degenerate = degenerate_borders(&built.shape, 1e-12 * extent(&built.shape));
    Ok(built)
}

impl Built {
    fn of(shape: SurfaceShape) -> Self {
        Built {
            shape,
            parameters: None,
            residual_sum_of_squares: None,
            gap: None,
            deviation: None,
            joints: Vec::new(),
            degenerate: Vec::new(),
        }
    }
}

/// The longest distance of a corner from another, or from the middle of the parameters.
fn extent(shape: &SurfaceShape) -> f64 {
    let [[a, b], [c, d]] = shape.domain();
    let middle = shape.value(0.5 * a + 0.5 * b, 0.5 * c + 0.5 * d);
    let corners = [(a, c), (a, d), (b, c), (b, d)].map(|(u, v)| shape.value(u, v));
    corners.iter().flat_map(|p| [(p - middle).norm(), (p - corners[0]).norm()]).fold(0.0, f64::max)
}

/// A method that does not apply to what is given.
fn no_method(given: &str, method: &str) -> Faults {
    Faults::one("method", format_args!("the method {method} cannot build a surface from {given}"))
}

fn heights(u: Vec<f64>, v: Vec<f64>, z: &[Vec<f64>]) -> Result<NodeGrid, Faults> {
    check::even_rows(z.iter().map(Vec::len), v.len())?;
    NodeGrid::heights(u, v, &z.concat())
}

fn on_grid(grid: NodeGrid, method: Method) -> Result<Built, Faults> {
    let mut built = match method {
        Method::BSpline { degrees, knots } => Built::of(SurfaceShape::BSpline(interpolate(&grid, degrees, knots)?)),
        Method::BSplineLeastSquares { degrees, knots } => {
            let (surface, sum) = least_squares(&grid, degrees, knots)?;
            Built { residual_sum_of_squares: Some(sum), ..Built::of(SurfaceShape::BSpline(surface)) }
        }
        Method::Nurbs { .. } => return Err(no_method("a grid", "nurbs")),
        patches => {
            let (mesh, tolerance) = network(&grid)?;
            in_mesh(&mesh, tolerance, &patches, "a grid")?
        }
    };
    built.parameters = Some(grid.parameters().clone());
    Ok(built)
}

/// Cubic splines (not-a-knot) through the rows and columns of nodes, and the rounding that their
/// crossings may differ by.
fn network(grid: &NodeGrid) -> Result<(CurveMesh, f64), Faults> {
    let [us, vs] = grid.parameters();
    let columns = vs.len();
    let through = |axis: usize, places: &[f64], nodes: Vec<Vector>| -> Result<Option<CurveShape>, Faults> {
        let degree = 3.min(places.len() - 1);
        let curve = interpolated_curve(grid.dimension(), places, &nodes, degree, &KnotChoice::NotAKnot);
        match curve {
            Ok(curve) => Ok(Some(CurveShape::BSpline(curve))),
            Err(faults) => Err(faults.map(|Fault { message, .. }| Fault {
                path: format!("nodes.{}", check::AXES[axis]),
                message: format!("no curve through a line of nodes: {message}"),
            })),
        }
    };
    let nodes = grid.values();
    let over_v = nodes.chunks_exact(columns).map(|row| through(1, vs, row.to_vec())).collect::<Result<_, _>>()?;
    let column = |j: usize| nodes.iter().skip(j).step_by(columns).copied().collect();
    let over_u = (0..columns).map(|j| through(0, us, column(j))).collect::<Result<_, _>>()?;
    let size = nodes.iter().map(|p| p.norm()).fold(0.0, f64::max);
    Ok((CurveMesh { us: us.clone(), vs: vs.clone(), over_v, over_u }, 1e-12 * size))
}

fn in_mesh(mesh: &CurveMesh, tolerance: f64, method: &Method, given: &'static str) -> Result<Built, Faults> {
    let fill = match method {
        Method::CoonsBilinear => Fill::CoonsBilinear,
        Method::CoonsBicubic { twists: Twists::Zero } => Fill::CoonsBicubicFlat,
        Method::CoonsBicubic { twists: Twists::Adini } => Fill::CoonsBicubic,
        Method::CoonsBicubic { twists: Twists::Given(_) } => {
            return Err(Faults::one("method", format_args!("twists are given for one patch, not for {given}")));
        }
        Method::Gregory => Fill::Gregory,
        Method::Bezier => Fill::Bezier,
        other => return Err(no_method(given, other.name())),
    };
    let filled = mesh.fill(fill, tolerance)?;
    Ok(Built {
        gap: Some(filled.gap),
        deviation: Some(filled.deviation),
        ..Built::of(SurfaceShape::Patchwork(filled.patchwork))
    })
}

fn in_boundaries(
    curves: [Option<CurveShape>; 4],
    cross: [Option<CurveShape>; 4],
    tolerance: f64,
    method: Method,
) -> Result<Built, Faults> {
    let takes_cross = matches!(method, Method::CoonsBicubic { .. } | Method::Gregory);
    if !takes_cross && cross.iter().any(Option::is_some) {
        return Err(no_method("derivatives across the borders", method.name()));
    }
    let boundaries = Boundaries::three_sided(curves, tolerance)?;
    match method {
        Method::CoonsBilinear => Ok(coons(CoonsPatch::bilinear(boundaries))),
        Method::CoonsBicubic { twists } => Ok(coons(CoonsPatch::bicubic(boundaries, cross, &twists, tolerance)?)),
        Method::Gregory => {
            let (patch, off) = gregory(&boundaries, &cross, tolerance)?;
            Ok(Built { deviation: Some(off), ..Built::of(SurfaceShape::Gregory(Box::new(patch))) })
        }
        Method::Bezier => {
            let twists = corner_twists(&boundaries, &Twists::Adini)?;
            let patch = bicubic(&boundaries, &twists)?;
            let off = deviation(&boundaries, &patch);
            Ok(Built { deviation: Some(off), ..Built::of(SurfaceShape::Bezier(patch)) })
        }
        other => Err(no_method("boundary curves", other.name())),
    }
}

/// A Coons patch keeps its curves but for what brings their corners together.
fn coons(patch: CoonsPatch) -> Built {
    let off = deviation(patch.boundaries(), &patch);
    Built { deviation: Some(off), ..Built::of(SurfaceShape::Coons(Box::new(patch))) }
}

fn of_net(net: Net, method: Method) -> Result<Built, Faults> {
    let columns = net.rows.first().map_or(0, Vec::len);
    let shape = [net.rows.len(), columns];
    if let Some(row) = net.rows.iter().position(|row| row.len() != columns) {
        let given = counted(net.rows[row].len(), "point", "points");
        return Err(Faults::one(
            format_args!("control_points[{row}]"),
            format_args!("row {row} of the net has {given}, the first one {columns}"),
        ));
    }
    if net.dimension == Dimension::Plane {
        let message = "control points of a surface are heights or points of space, not of a plane";
        return Err(Faults::one("control_points", message));
    }
    let weights = match &net.weights {
        Some(rows) => {
            if rows.len() != shape[0] {
                let [given, wanted] = [rows.len(), shape[0]].map(|count| counted(count, "row", "rows"));
                let message = format_args!("{given} of weights for {wanted} of control points");
                return Err(Faults::one("weights", message));
            }
            if let Some(row) = rows.iter().position(|row| row.len() != columns) {
                let (given, wanted) =
                    (counted(rows[row].len(), "number", "numbers"), counted(columns, "point", "points"));
                return Err(Faults::one(
                    format_args!("weights[{row}]"),
                    format_args!("row {row} of the weights has {given}, a row of the net {wanted}"),
                ));
            }
            Some(rows.concat())
        }
        None => None,
    };
    let domain = net.domain.unwrap_or([[0.0, 1.0]; 2]);
    let surface = match method {
        Method::Bezier => {
            SurfaceShape::Bezier(BezierSurface::new(shape, domain, net.dimension, net.rows.concat(), weights)?)
        }
        Method::BSpline { degrees, knots } | Method::Nurbs { degrees, knots } => {
            let [knots_u, knots_v] = knots;
            let basis = |axis: usize, knots| net_basis(axis, degrees[axis], shape[axis], knots, domain[axis]);
            let bases = [basis(0, knots_u)?, basis(1, knots_v)?];
            let surface = BSplineSurface::new(bases, net.dimension, net.rows.concat(), weights)?;
            SurfaceShape::BSpline(surface)
        }
        Method::Gregory => {
            let flat = net.rows.concat();
            let (Some(b), [4, 4], None) = (net.inner, shape, &weights) else {
                let message = format_args!(
                    "a Gregory patch has a net of 4 × 4 points, 2 × 2 further inner points and no weights; the net is \
                     {} × {columns}",
                    shape[0]
                );
                return Err(Faults::one("control_points", message));
            };
            let points = std::array::from_fn(|i| std::array::from_fn(|j| flat[4 * i + j]));
            let patch = GregoryPatch::new(domain, net.dimension, GregoryNet { net: points, b })?;
            SurfaceShape::Gregory(Box::new(patch))
        }
        other => return Err(no_method("a net of control points", other.name())),
    };
    Ok(Built::of(surface))
}

/// Given knots, or clamped ones with spans of equal width.
fn net_basis(
    axis: usize,
    degree: usize,
    controls: usize,
    knots: Option<Vec<f64>>,
    [low, high]: [f64; 2],
) -> Result<BSplineBasis, Faults> {
    check_degree(axis, degree, controls)?;
    let basis = match knots {
        Some(knots) => BSplineBasis::new(degree, knots),
        None => BSplineBasis::uniform(degree, controls - degree, low, high),
    };
    let basis = basis.map_err(check::knots(axis))?;
    if basis.size() == controls {
        return Ok(basis);
    }
    let (given, wanted) = (counted(basis.knots().len(), "knot", "knots"), controls + degree + 1);
    Err(Faults::one(format_args!("knots[{axis}]"), format_args!("{given}; degree and control points need {wanted}")))
}
