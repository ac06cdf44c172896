//! Surfaces of requests: wire parts to checked surfaces.

use super::{
    curve_shape::{built, read_curve},
    net::{Net, equal_rows},
    point::PointBody,
    surface_shape::*,
};
use crate::api::{
    faults::{Faults, pointer_of},
    json::{
        members::{Member, of_object},
        slice::Slice,
        tags::{read_tag, unknown_type},
        value::{read_first, read_value},
    },
};
use flankfit_engine::{
    estimation::spec::{Degree, Domain},
    geometry::{
        BSplineBasis,
        curve::{Curve, CurveShape},
        space::{Dimension, HIGHEST_DEGREE, Vector, degree_too_high},
        surface::{
            BSplineSurface, BezierSurface, Boundaries, CoonsPatch, GregoryPatch, Patchwork, SurfaceShape,
            coons::Twists, gregory::GregoryNet,
        },
    },
    numerics::check::{self, rest_of},
    words::counted,
};

/// Corners may be this share of the largest coordinate apart, where no tolerance is given.
const CORNER_TOLERANCE: f64 = 1e-6;

/// The types of surfaces.
const SURFACES: &str = "b_spline, nurbs, bezier, coons_bilinear, coons_bicubic, gregory and patchwork are";

/// Reads a surface that stands at `at`.
pub fn read_surface(slice: &[u8], at: &str, faults: &mut Faults) -> Option<SurfaceShape> {
    match read_tag(slice, at, SURFACES, faults)?.as_str() {
        "b_spline" => {
            let body: BSplineSurfaceBody = read_value(slice, at, faults)?;
            b_spline(body.degree, body.knots, &body.control_points, None, at, faults).map(SurfaceShape::BSpline)
        }
        "nurbs" => {
            let body: NurbsSurfaceBody = read_value(slice, at, faults)?;
            let (degree, knots) = (body.degree, body.knots);
            b_spline(degree, knots, &body.control_points, Some(&body.weights), at, faults).map(SurfaceShape::BSpline)
        }
        "bezier" => bezier(read_value(slice, at, faults)?, at, faults).map(SurfaceShape::Bezier),
        "coons_bilinear" => {
            let members: BilinearCoonsMembers<'_> = of_object(slice, at, faults)?;
            let boundaries = boundaries(&members.boundaries, &members.tolerance, at, faults)?.0;
            Some(SurfaceShape::Coons(Box::new(CoonsPatch::bilinear(boundaries))))
        }
        "coons_bicubic" => {
            let members: BicubicCoonsMembers<'_> = of_object(slice, at, faults)?;
            let (boundaries, tolerance) = boundaries(&members.boundaries, &members.tolerance, at, faults)?;
            let cross = match members.cross_derivatives.text() {
                Some(slice) => borders(slice, &members.cross_derivatives.pointer(), faults)?,
                None => Default::default(),
            };
            const CROSS: &str = "cross_derivatives";
            let patch = CoonsPatch::bicubic(boundaries, cross, &Twists::default(), tolerance)
                .map_err(|found| found.moved("boundaries", CROSS).moved("twists[0][0]", CROSS));
            built(patch, at, faults).map(|patch| SurfaceShape::Coons(Box::new(patch)))
        }
        "gregory" => {
            gregory(&read_value(slice, at, faults)?, at, faults).map(|patch| SurfaceShape::Gregory(Box::new(patch)))
        }
        "patchwork" => patchwork(slice, at, faults).map(SurfaceShape::Patchwork),
        other => {
            unknown_type(at, other, SURFACES, faults);
            None
        }
    }
}

/// The boundary curves of the object at `at`, and the tolerance under which they meet.
fn boundaries(
    boundaries: &Member<'_, BordersBody>,
    tolerance: &Member<'_, f64>,
    at: &str,
    faults: &mut Faults,
) -> Option<(Boundaries, f64)> {
    let (curves, tolerance) = boundary_curves(boundaries, tolerance, faults)?;
    built(Boundaries::three_sided(curves, tolerance), at, faults).map(|boundaries| (boundaries, tolerance))
}

/// The same before it is known that they meet.
pub fn boundary_curves(
    boundaries: &Member<'_, BordersBody>,
    tolerance: &Member<'_, f64>,
    faults: &mut Faults,
) -> Option<([Option<CurveShape>; 4], f64)> {
    let slice = boundaries.required_text(faults)?;
    let tolerance = tolerance.optional(faults)?;
    let curves = borders(slice, &boundaries.pointer(), faults)?;
    let tolerance = tolerance.unwrap_or_else(|| corner_tolerance(curves.iter().flatten()));
    Some((curves, tolerance))
}

/// How far curves may be apart where they should meet by default.
pub fn corner_tolerance<'a>(curves: impl Iterator<Item = &'a CurveShape>) -> f64 {
    let ends = curves.flat_map(|curve| curve.domain().map(|t| curve.value(t)));
    CORNER_TOLERANCE * ends.fold(0.0, |size: f64, end| size.max(end.amax()))
}

/// Curves along borders, in the order u0, u1, v0, v1.
pub fn borders(slice: &[u8], at: &str, faults: &mut Faults) -> Option<[Option<CurveShape>; 4]> {
    let before = faults.count();
    let BordersMembers { u0, u1, v0, v1 } = of_object(slice, at, faults)?;
    let curves = [u0, u1, v0, v1].map(|border| read_curve(border.text()?, &border.pointer(), faults));
    (faults.count() == before).then_some(curves)
}

fn b_spline(
    degree: Degree,
    knots: [Vec<f64>; 2],
    control_points: &[Vec<PointBody>],
    weights: Option<&[Vec<f64>]>,
    at: &str,
    faults: &mut Faults,
) -> Option<BSplineSurface> {
    let degree_of_each = matches!(degree, Degree::Each(..));
    let degrees = degree.each();
    let net = Net::read(control_points, &format!("{at}/control_points"), faults);
    let [u, v] = knots;
    if let Some(axis) = degrees.iter().position(|degree| *degree > HIGHEST_DEGREE) {
        let degree = degrees[axis];
        let place = if degree_of_each { format!("{at}/degree/{axis}") } else { format!("{at}/degree") };
        faults.append(Faults::of_engine(&place, &degree_too_high("", degree)));
        return None;
    }
    let mut basis =
        |axis: usize, knots| built(BSplineBasis::new(degrees[axis], knots), &format!("{at}/knots/{axis}"), faults);
    let (u, v) = (basis(0, u), basis(1, v));
    let (net, u, v) = (net?, u?, v?);
    for (axis, given, wanted) in [("row", net.columns, v.size()), ("column", net.rows, u.size())] {
        if given != wanted {
            let detail = format!("{given} control points in a {axis}, where degree and knots ask for {wanted}");
            faults.push(format!("{at}/control_points"), detail);
            return None;
        }
    }
    let weights = flat_weights(weights, net.columns, at, faults)?;
    built(BSplineSurface::new([u, v], surface_dimension(&net, at, faults)?, net.values, weights), at, faults)
}

/// Weights end to end; `None` on a fault, `Some(None)` where there are none.
fn flat_weights(
    weights: Option<&[Vec<f64>]>,
    columns: usize,
    at: &str,
    faults: &mut Faults,
) -> Option<Option<Vec<f64>>> {
    let Some(weights) = weights else { return Some(None) };
    let at = format!("{at}/weights");
    let given = equal_rows(weights, &at, faults)?;
    if given != columns {
        faults.push(
            at,
            format!(
                "{} in a row, for {}",
                counted(given, "weight", "weights"),
                counted(columns, "control point", "control points")
            ),
        );
        return None;
    }
    Some(Some(weights.concat()))
}

/// Surfaces are heights or points of space.
fn surface_dimension(net: &Net, at: &str, faults: &mut Faults) -> Option<Dimension> {
    if net.dimension == Dimension::Plane {
        faults.push(format!("{at}/control_points"), "points [x, y]; a surface has numbers or points [x, y, z]");
        return None;
    }
    Some(net.dimension)
}

fn bezier(body: BezierSurfaceBody, at: &str, faults: &mut Faults) -> Option<BezierSurface> {
    let net = Net::read(&body.control_points, &format!("{at}/control_points"), faults)?;
    let weights = flat_weights(body.weights.as_deref(), net.columns, at, faults)?;
    let (columns, dimension) = (net.columns, surface_dimension(&net, at, faults)?);
    let patch = BezierSurface::new([net.rows, columns], domain(body.domain), dimension, net.values, weights);
    built(in_domain(patch), at, faults)
}

fn gregory(body: &GregoryBody, at: &str, faults: &mut Faults) -> Option<GregoryPatch> {
    let net = Net::read(&body.control_points, &format!("{at}/control_points"), faults);
    let inner = Net::read(&body.inner_points, &format!("{at}/inner_points"), faults);
    let (net, inner) = (net?, inner?);
    let dimension = surface_dimension(&net, at, faults)?;
    for (name, given, size) in [("control_points", &net, 4), ("inner_points", &inner, 2)] {
        if (given.rows, given.columns) != (size, size) {
            let detail = format!("{} × {} points, where {size} × {size} are wanted", given.rows, given.columns);
            faults.push(format!("{at}/{name}"), detail);
            return None;
        }
    }
    if inner.dimension != dimension {
        faults.push(format!("{at}/inner_points"), "they must be of the kind of the control points");
        return None;
    }
    let net_of = |i: usize, j: usize| net.values[4 * i + j];
    let points = GregoryNet {
        net: std::array::from_fn(|i| std::array::from_fn(|j| net_of(i, j))),
        b: std::array::from_fn(|i| std::array::from_fn(|j| -> Vector { inner.values[2 * i + j] })),
    };
    built(in_domain(GregoryPatch::new(domain(body.domain), dimension, points)), at, faults)
}

fn patchwork(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Patchwork> {
    let members: PatchworkMembers<'_> = of_object(slice, at, faults)?;
    let (u, v) = (members.u.numbers(faults), members.v.numbers(faults));
    let texts = members.patches.required_text(faults)?;
    let at_patches = members.patches.pointer();
    let texts: Vec<Vec<Slice>> = read_first(texts, &at_patches, faults)?;
    let columns = equal_rows(&texts, &at_patches, faults)?;
    let before = faults.count();
    let mut patches = Vec::with_capacity(texts.len() * columns);
    for (k, text) in texts.iter().flatten().enumerate() {
        let (text, place) = (text.0, format!("{at_patches}/{}", Net::place(columns, k)));
        // looked at first: patchworks within each other could be as deep as the text is long
        match read_tag(text, &place, SURFACES, faults).as_deref() {
            Some("patchwork") => faults.push(place, "a patch is not a patchwork itself"),
            Some(_) => patches.extend(read_surface(text, &place, faults)),
            None => {}
        }
    }
    let (u, v) = (u?, v?);
    if faults.count() > before {
        return None;
    }
    let place = |path: &str| match rest_of(path, "patches") {
        Some(rest) => format!("{at_patches}{}", pointer_of(rest)),
        None => at.to_owned(),
    };
    Patchwork::new(u, v, patches).map_err(|found| faults.append(Faults::placed(&found, place))).ok()
}

fn domain(body: Option<Domain>) -> [[f64; 2]; 2] {
    let body = body.unwrap_or(Domain { u: None, v: None });
    [body.u, body.v].map(|range| range.unwrap_or([0.0, 1.0]))
}

/// Places the ranges of a domain as a request has them.
fn in_domain<T>(made: Result<T, check::Faults>) -> Result<T, check::Faults> {
    made.map_err(|found| found.moved("domain[0]", "domain.u").moved("domain[1]", "domain.v"))
}
