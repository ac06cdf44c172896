//! Surfaces in their written form.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::points::{Net, Point, equal_rows};
use crate::{
    BSplineBasis,
    axes::{Degree, Domain},
    curve::CurveShape,
    space::{Dimension, HIGHEST_DEGREE, degree_too_high},
    surface::{
        BSplineSurface, BezierSurface, Border, Boundaries, CoonsPatch, GregoryPatch, Patchwork, Surface as _,
        SurfaceShape, boundaries::default_tolerance, coons::Twists, gregory::GregoryNet,
    },
};
use flankfit_numerics::{
    check::{Fault, Faults, rest_of},
    contract::refused,
    words::counted,
};

/// The written form of a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Surface(Form);

/// A surface. Values are numbers for a graph z(u, v), points [x, y, z] for a surface of space.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[schema(as = Surface)]
enum Form {
    /// Σ aᵢⱼ Nᵢ(u) Nⱼ(v).
    BSpline(PolynomialSpline),
    /// Σ wᵢⱼ aᵢⱼ Nᵢ(u) Nⱼ(v) / Σ wᵢⱼ Nᵢ(u) Nⱼ(v).
    Nurbs(NurbsSurface),
    /// A tensor Bézier patch; its degrees are one less than the numbers of control points.
    Bezier(BezierPatch),
    /// The bilinearly blended patch of four boundary curves.
    CoonsBilinear(Box<CoonsBilinearSurface>),
    /// The bicubically blended patch of four boundary curves and the derivatives across them.
    CoonsBicubic(Box<CoonsBicubicSurface>),
    /// Gregory's rational bicubic patch of 20 control points.
    Gregory(GregorySurface),
    /// Patches over the rectangles between lines of constant u and v; some may have three sides.
    Patchwork(PatchworkSurface),
}

flankfit_numerics::tagged!(Form {
    "b_spline" => BSpline,
    "nurbs" => Nurbs,
    "bezier" => Bezier,
    "coons_bilinear" => CoonsBilinear,
    "coons_bicubic" => CoonsBicubic,
    "gregory" => Gregory,
    "patchwork" => Patchwork,
});

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = BSplineSurface)]
struct PolynomialSpline {
    degree: Degree,
    /// Full knot vectors of u and of v, ascending.
    knots: [Vec<f64>; 2],
    /// Rows along u, within a row along v.
    control_points: Vec<Vec<Point>>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct NurbsSurface {
    degree: Degree,
    /// Full knot vectors of u and of v, ascending.
    knots: [Vec<f64>; 2],
    /// Rows along u, within a row along v.
    control_points: Vec<Vec<Point>>,
    /// One ≥ 0 for each control point.
    weights: Vec<Vec<f64>>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = BezierSurface)]
struct BezierPatch {
    /// Rows along u, within a row along v; 2 to 26 of either.
    control_points: Vec<Vec<Point>>,
    /// For a rational patch, one ≥ 0 for each control point.
    weights: Option<Vec<Vec<f64>>>,
    /// Default [0, 1] both.
    domain: Option<Domain>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct CoonsBilinearSurface {
    boundaries: Borders,
    /// Largest distance between two curves at their corner, in the unit of the request. Default
    /// 1e-6 of the largest coordinate.
    #[schema(minimum = 0)]
    tolerance: Option<f64>,
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct CoonsBicubicSurface {
    boundaries: Borders,
    /// ∂S/∂u along u0 and u1, ∂S/∂v along v0 and v1; those left out are estimated.
    cross_derivatives: Option<Borders>,
    /// Largest distance between two curves at their corner, in the unit of the request. Default
    /// 1e-6 of the largest coordinate.
    #[schema(minimum = 0)]
    tolerance: Option<f64>,
}

/// Curves along the borders of a patch: `u0` and `u1` run along v at the least and the greatest u,
/// `v0` and `v1` along u. For points in space one may be missing: the patch then has three sides.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Borders {
    u0: Option<CurveShape>,
    u1: Option<CurveShape>,
    v0: Option<CurveShape>,
    v1: Option<CurveShape>,
}

impl Borders {
    /// Returns the curves in the order u0, u1, v0, v1.
    pub fn curves(self) -> [Option<CurveShape>; 4] {
        [self.u0, self.u1, self.v0, self.v1]
    }
}

impl From<[Option<CurveShape>; 4]> for Borders {
    fn from([u0, u1, v0, v1]: [Option<CurveShape>; 4]) -> Self {
        Borders { u0, u1, v0, v1 }
    }
}

#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct GregorySurface {
    /// A net of 4 × 4; of its inner four points these are the ones felt along v0 and v1.
    #[schema(min_items = 4, max_items = 4)]
    control_points: Vec<Vec<Point>>,
    /// 2 × 2: the inner points that are felt along u0 and u1.
    #[schema(min_items = 2, max_items = 2)]
    inner_points: Vec<Vec<Point>>,
    /// Default [0, 1] both.
    domain: Option<Domain>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct PatchworkSurface {
    /// Parameters of the patch borders, both ends included, ascending.
    #[schema(min_items = 2)]
    u: Vec<f64>,
    /// Parameters of the patch borders, both ends included, ascending.
    #[schema(min_items = 2)]
    v: Vec<f64>,
    /// A row for each interval of u, in it a patch for each interval of v. A patch cannot be a
    /// patchwork.
    #[schema(no_recursion)]
    patches: Vec<Vec<Form>>,
}

flankfit_numerics::written_as!(Surface, Form);
flankfit_numerics::written_as!(SurfaceShape, Form);

impl Serialize for SurfaceShape {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Surface::new(self, None).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for SurfaceShape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Form::deserialize(deserializer)?.try_into().map_err(refused)
    }
}

impl TryFrom<Form> for SurfaceShape {
    type Error = Faults;

    fn try_from(surface: Form) -> Result<Self, Faults> {
        match surface {
            Form::BSpline(PolynomialSpline { degree, knots, control_points }) => {
                b_spline(degree, knots, &control_points, None).map(SurfaceShape::BSpline)
            }
            Form::Nurbs(NurbsSurface { degree, knots, control_points, weights }) => {
                b_spline(degree, knots, &control_points, Some(&weights)).map(SurfaceShape::BSpline)
            }
            Form::Bezier(patch) => bezier(&patch).map(SurfaceShape::Bezier),
            Form::CoonsBilinear(patch) => {
                let (boundaries, _) = met(patch.boundaries, patch.tolerance)?;
                Ok(SurfaceShape::Coons(Box::new(CoonsPatch::bilinear(boundaries))))
            }
            Form::CoonsBicubic(patch) => {
                const CROSS: &str = "cross_derivatives";
                let (boundaries, tolerance) = met(patch.boundaries, patch.tolerance)?;
                let cross = patch.cross_derivatives.unwrap_or_default().curves();
                CoonsPatch::bicubic(boundaries, cross, &Twists::default(), tolerance)
                    .map(|patch| SurfaceShape::Coons(Box::new(patch)))
                    .map_err(|found| found.moved("boundaries", CROSS).moved("twists[0][0]", CROSS))
            }
            Form::Gregory(patch) => gregory(&patch).map(|patch| SurfaceShape::Gregory(Box::new(patch))),
            Form::Patchwork(work) => patchwork(work).map(SurfaceShape::Patchwork),
        }
    }
}

/// Returns boundary curves that meet, and the tolerance under which they do.
fn met(boundaries: Borders, tolerance: Option<f64>) -> Result<(Boundaries, f64), Faults> {
    let curves = boundaries.curves();
    let tolerance = tolerance.unwrap_or_else(|| default_tolerance(curves.iter().flatten()));
    Ok((Boundaries::three_sided(curves, tolerance)?, tolerance))
}

fn b_spline(
    degree: Degree,
    [knots_u, knots_v]: [Vec<f64>; 2],
    control_points: &[Vec<Point>],
    weights: Option<&[Vec<f64>]>,
) -> Result<BSplineSurface, Faults> {
    const CONTROLS: &str = "control_points";
    let mut faults = Faults::default();
    let net = Net::new(control_points, CONTROLS, &mut faults);
    let degrees = degree.each();
    if let Some(axis) = degrees.iter().position(|degree| *degree > HIGHEST_DEGREE) {
        let place = if matches!(degree, Degree::Each(..)) { format!("degree[{axis}]") } else { "degree".to_owned() };
        faults.append(degree_too_high(&place, degrees[axis]));
        return Err(faults);
    }
    let mut basis = |axis: usize, knots| {
        let basis = BSplineBasis::new(degrees[axis], knots);
        basis.map_err(|found| faults.append(found.within(&format!("knots[{axis}]")))).ok()
    };
    let (Some(net), [Some(u), Some(v)]) = (net, [basis(0, knots_u), basis(1, knots_v)]) else { return Err(faults) };
    for (axis, given, wanted) in [("row", net.columns, v.size()), ("column", net.rows, u.size())] {
        if given != wanted {
            let message = format_args!("{given} control points in a {axis}, where degree and knots need {wanted}");
            return Err(Faults::one(CONTROLS, message));
        }
    }
    let weights = flat_weights(weights, net.columns)?;
    BSplineSurface::new([u, v], dimension(&net)?, net.values, weights)
}

/// Returns weights one after the other.
fn flat_weights(weights: Option<&[Vec<f64>]>, columns: usize) -> Result<Option<Vec<f64>>, Faults> {
    const WEIGHTS: &str = "weights";
    let Some(weights) = weights else { return Ok(None) };
    let mut faults = Faults::default();
    let Some(given) = equal_rows(weights, WEIGHTS, &mut faults) else { return Err(faults) };
    if given != columns {
        let given = counted(given, "weight", "weights");
        let wanted = counted(columns, "control point", "control points");
        return Err(Faults::one(WEIGHTS, format_args!("{given} in a row, for {wanted}")));
    }
    Ok(Some(weights.concat()))
}

/// Returns the dimension of control points, which are heights or points of space.
fn dimension(net: &Net) -> Result<Dimension, Faults> {
    if net.dimension == Dimension::Plane {
        let message = "points [x, y]; a surface has numbers or points [x, y, z]";
        return Err(Faults::one("control_points", message));
    }
    Ok(net.dimension)
}

fn bezier(patch: &BezierPatch) -> Result<BezierSurface, Faults> {
    let mut faults = Faults::default();
    let Some(net) = Net::new(&patch.control_points, "control_points", &mut faults) else { return Err(faults) };
    let weights = flat_weights(patch.weights.as_deref(), net.columns)?;
    let (shape, dimension) = ([net.rows, net.columns], dimension(&net)?);
    BezierSurface::new(shape, ranges(patch.domain), dimension, net.values, weights).map_err(in_domain)
}

fn gregory(patch: &GregorySurface) -> Result<GregoryPatch, Faults> {
    let mut faults = Faults::default();
    let net = Net::new(&patch.control_points, "control_points", &mut faults);
    let inner = Net::new(&patch.inner_points, "inner_points", &mut faults);
    let (Some(net), Some(inner)) = (net, inner) else { return Err(faults) };
    let dimension = dimension(&net)?;
    for (name, given, size) in [("control_points", &net, 4), ("inner_points", &inner, 2)] {
        if (given.rows, given.columns) != (size, size) {
            let message = format_args!("{} × {} points, where {size} × {size} are needed", given.rows, given.columns);
            return Err(Faults::one(name, message));
        }
    }
    if inner.dimension != dimension {
        return Err(Faults::one("inner_points", "they must be of the kind of the control points"));
    }
    let points = GregoryNet {
        net: std::array::from_fn(|i| std::array::from_fn(|j| net.values[4 * i + j])),
        b: std::array::from_fn(|i| std::array::from_fn(|j| inner.values[2 * i + j])),
    };
    GregoryPatch::new(ranges(patch.domain), dimension, points).map_err(in_domain)
}

fn patchwork(work: PatchworkSurface) -> Result<Patchwork, Faults> {
    let mut faults = Faults::default();
    let Some(columns) = equal_rows(&work.patches, "patches", &mut faults) else { return Err(faults) };
    let mut patches = Vec::with_capacity(columns * work.patches.len());
    for (i, row) in work.patches.into_iter().enumerate() {
        for (j, patch) in row.into_iter().enumerate() {
            let place = format!("patches[{i}][{j}]");
            match patch {
                Form::Patchwork(_) => faults.push(place, "a patch is not a patchwork itself"),
                patch => match SurfaceShape::try_from(patch) {
                    Ok(patch) => patches.push(patch),
                    Err(found) => faults.append(found.within(&place)),
                },
            }
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let placed = |fault: Fault| match rest_of(&fault.path, "patches") {
        Some(_) => fault,
        None => Fault { path: String::new(), ..fault },
    };
    Patchwork::new(work.u, work.v, patches).map_err(|found| found.map(placed))
}

fn ranges(domain: Option<Domain>) -> [[f64; 2]; 2] {
    let Domain { u, v } = domain.unwrap_or_default();
    [u, v].map(|range| range.unwrap_or([0.0, 1.0]))
}

/// Places the ranges of a domain as they are written.
fn in_domain(found: Faults) -> Faults {
    found.moved("domain[0]", "domain.u").moved("domain[1]", "domain.v")
}

impl Surface {
    /// Returns the written form of a surface; `tolerance` is the one under which corners of curves
    /// were found to meet, if it was given.
    pub fn new(shape: &SurfaceShape, tolerance: Option<f64>) -> Self {
        Surface(Form::new(shape, tolerance))
    }
}

impl Form {
    fn new(shape: &SurfaceShape, tolerance: Option<f64>) -> Self {
        let domain = || {
            let [u, v] = shape.domain();
            Some(Domain { u: Some(u), v: Some(v) })
        };
        match shape {
            SurfaceShape::BSpline(surface) => of_b_spline(surface),
            SurfaceShape::Bezier(patch) => {
                let columns = patch.degrees()[1] + 1;
                Form::Bezier(BezierPatch {
                    control_points: Net::points(patch.dimension(), columns, patch.control_points()),
                    weights: patch.weights().map(|weights| rows(weights, columns)),
                    domain: domain(),
                })
            }
            SurfaceShape::Coons(patch) => of_coons(patch, tolerance),
            SurfaceShape::Gregory(patch) => {
                let GregoryNet { net, b } = patch.points();
                Form::Gregory(GregorySurface {
                    control_points: Net::points(patch.dimension(), 4, net.as_flattened()),
                    inner_points: Net::points(patch.dimension(), 2, b.as_flattened()),
                    domain: domain(),
                })
            }
            SurfaceShape::Patchwork(work) => {
                let [u, v] = work.lines().clone();
                let row = |patches: &[SurfaceShape]| patches.iter().map(|patch| Form::new(patch, tolerance)).collect();
                let patches = work.patches().chunks(v.len() - 1).map(row).collect();
                Form::Patchwork(PatchworkSurface { u, v, patches })
            }
        }
    }
}

fn of_b_spline(surface: &BSplineSurface) -> Form {
    let [u, v] = surface.bases();
    let degree = Degree::Each(u.degree(), v.degree());
    let knots = [u, v].map(|basis| basis.knots().to_vec());
    let control_points = Net::points(surface.dimension(), v.size(), surface.control_points());
    match surface.weights() {
        None => Form::BSpline(PolynomialSpline { degree, knots, control_points }),
        Some(weights) => Form::Nurbs(NurbsSurface { degree, knots, control_points, weights: rows(weights, v.size()) }),
    }
}

fn of_coons(patch: &CoonsPatch, tolerance: Option<f64>) -> Form {
    let (missing, curves) = (patch.boundaries().collapsed(), patch.boundaries().curves());
    let border = |border: Border| (Some(border) != missing).then(|| curves[border as usize].clone());
    let boundaries = Borders::from(Border::ALL.map(border));
    match patch.cross_derivatives() {
        None => Form::CoonsBilinear(Box::new(CoonsBilinearSurface { boundaries, tolerance })),
        Some(curves) => {
            let cross_derivatives = Some(Borders::from(curves.clone().map(Some)));
            Form::CoonsBicubic(Box::new(CoonsBicubicSurface { boundaries, cross_derivatives, tolerance }))
        }
    }
}

fn rows(values: &[f64], columns: usize) -> Vec<Vec<f64>> {
    values.chunks(columns).map(<[f64]>::to_vec).collect()
}
