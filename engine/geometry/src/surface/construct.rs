//! Construction of all surfaces: from data and a method to the surface with a report.

pub use super::method::{Given, Method, Net};
use super::{
    BSplineSurface, BezierSurface, Boundaries, CoonsPatch, GregoryPatch, GridFault, NodeGrid, Surface, SurfaceShape,
    construct_fault::SurfaceFault,
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
pub fn build(given: Given, method: Method) -> Result<Built, SurfaceFault> {
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

fn heights(u: Vec<f64>, v: Vec<f64>, z: &[Vec<f64>]) -> Result<NodeGrid, SurfaceFault> {
    if let Some(row) = z.iter().position(|row| row.len() != v.len()) {
        return Err(GridFault::Ragged { row, given: z[row].len(), wanted: v.len() }.into());
    }
    Ok(NodeGrid::heights(u, v, &z.concat())?)
}

fn on_grid(grid: NodeGrid, method: Method) -> Result<Built, SurfaceFault> {
    let mut built = match method {
        Method::BSpline { degrees, knots } => Built::of(SurfaceShape::BSpline(interpolate(&grid, degrees, knots)?)),
        Method::BSplineLeastSquares { degrees, knots } => {
            let (surface, sum) = least_squares(&grid, degrees, knots)?;
            Built { residual_sum_of_squares: Some(sum), ..Built::of(SurfaceShape::BSpline(surface)) }
        }
        Method::Nurbs { .. } => return Err(SurfaceFault::Combination { given: "a grid", method: "nurbs" }),
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
fn network(grid: &NodeGrid) -> Result<(CurveMesh, f64), SurfaceFault> {
    let [us, vs] = grid.parameters();
    let columns = vs.len();
    let through = |axis: usize, places: &[f64], nodes: Vec<Vector>| -> Result<Option<CurveShape>, SurfaceFault> {
        let degree = 3.min(places.len() - 1);
        let curve = interpolated_curve(grid.dimension(), places, &nodes, degree, &KnotChoice::NotAKnot);
        match curve {
            Ok(curve) => Ok(Some(CurveShape::BSpline(curve))),
            Err(fault) => Err(SurfaceFault::Network { axis, fault }),
        }
    };
    let nodes = grid.values();
    let over_v = nodes.chunks_exact(columns).map(|row| through(1, vs, row.to_vec())).collect::<Result<_, _>>()?;
    let column = |j: usize| nodes.iter().skip(j).step_by(columns).copied().collect();
    let over_u = (0..columns).map(|j| through(0, us, column(j))).collect::<Result<_, _>>()?;
    let size = nodes.iter().map(|p| p.norm()).fold(0.0, f64::max);
    Ok((CurveMesh { us: us.clone(), vs: vs.clone(), over_v, over_u }, 1e-12 * size))
}

fn in_mesh(mesh: &CurveMesh, tolerance: f64, method: &Method, given: &'static str) -> Result<Built, SurfaceFault> {
    let fill = match method {
        Method::CoonsBilinear => Fill::CoonsBilinear,
        Method::CoonsBicubic { twists: Twists::Zero } => Fill::CoonsBicubicFlat,
        Method::CoonsBicubic { twists: Twists::Adini } => Fill::CoonsBicubic,
        Method::CoonsBicubic { twists: Twists::Given(_) } => return Err(SurfaceFault::OwnTwists { given }),
        Method::Gregory => Fill::Gregory,
        Method::Bezier => Fill::Bezier,
        other => return Err(SurfaceFault::Combination { given, method: other.name() }),
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
) -> Result<Built, SurfaceFault> {
    let takes_cross = matches!(method, Method::CoonsBicubic { .. } | Method::Gregory);
    if !takes_cross && cross.iter().any(Option::is_some) {
        return Err(SurfaceFault::Combination { given: "derivatives across the borders", method: method.name() });
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
        other => Err(SurfaceFault::Combination { given: "boundary curves", method: other.name() }),
    }
}

/// A Coons patch keeps its curves but for what brings their corners together.
fn coons(patch: CoonsPatch) -> Built {
    let off = deviation(patch.boundaries(), &patch);
    Built { deviation: Some(off), ..Built::of(SurfaceShape::Coons(Box::new(patch))) }
}

fn of_net(net: Net, method: Method) -> Result<Built, SurfaceFault> {
    let columns = net.rows.first().map_or(0, Vec::len);
    let shape = [net.rows.len(), columns];
    if let Some(row) = net.rows.iter().position(|row| row.len() != columns) {
        return Err(SurfaceFault::RaggedNet { row, given: net.rows[row].len(), wanted: columns });
    }
    if net.dimension == Dimension::Plane {
        return Err(SurfaceFault::PlaneNet);
    }
    let weights = match &net.weights {
        Some(rows) => {
            if rows.len() != shape[0] {
                return Err(SurfaceFault::WeightRows { given: rows.len(), wanted: shape[0] });
            }
            if let Some(row) = rows.iter().position(|row| row.len() != columns) {
                return Err(SurfaceFault::RaggedWeights { row, given: rows[row].len(), wanted: columns });
            }
            Some(rows.concat())
        }
        None => None,
    };
    let domain = net.domain.unwrap_or([[0.0, 1.0]; 2]);
    let control = |fault| SurfaceFault::Control { fault, columns };
    let surface = match method {
        Method::Bezier => SurfaceShape::Bezier(
            BezierSurface::new(shape, domain, net.dimension, net.rows.concat(), weights)
                .map_err(|fault| SurfaceFault::Bezier { fault, columns })?,
        ),
        Method::BSpline { degrees, knots } | Method::Nurbs { degrees, knots } => {
            let [knots_u, knots_v] = knots;
            let basis = |axis: usize, knots| net_basis(axis, degrees[axis], shape[axis], knots, domain[axis]);
            let bases = [basis(0, knots_u)?, basis(1, knots_v)?];
            let surface = BSplineSurface::new(bases, net.dimension, net.rows.concat(), weights).map_err(control)?;
            SurfaceShape::BSpline(surface)
        }
        Method::Gregory => {
            let flat = net.rows.concat();
            let (Some(b), [4, 4], None) = (net.inner, shape, &weights) else {
                return Err(SurfaceFault::GregoryNet { rows: shape[0], columns });
            };
            let points = std::array::from_fn(|i| std::array::from_fn(|j| flat[4 * i + j]));
            let patch = GregoryPatch::new(domain, net.dimension, GregoryNet { net: points, b })?;
            SurfaceShape::Gregory(Box::new(patch))
        }
        other => return Err(SurfaceFault::Combination { given: "a net of control points", method: other.name() }),
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
) -> Result<BSplineBasis, SurfaceFault> {
    check_degree(axis, degree, controls)?;
    let basis = match knots {
        Some(knots) => BSplineBasis::new(degree, knots),
        None => BSplineBasis::uniform(degree, controls - degree, low, high),
    };
    let basis = basis.map_err(|fault| GridFault::Knots { axis, fault })?;
    if basis.size() == controls {
        return Ok(basis);
    }
    Err(SurfaceFault::KnotCount { axis, given: basis.knots().len(), wanted: controls + degree + 1 })
}
