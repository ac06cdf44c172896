//! Splines as every CAD system takes them.
//!
//! Points of space, ends of full multiplicity, weights above 0 or none, no jumps inside. Any other
//! B-spline is brought to this form without changing the shape or its parametrisation:
//! - y(x) and z(u, v) become (x, y, 0) and (u, v, z); with Greville abscissae as coordinates a
//!   spline gives its own parameter. Where there are weights the product of parameter and
//!   denominator is a spline of one degree more, and the whole is raised to it.
//! - Loose ends are clamped by inserting knots.
//! - At an inner knot of multiplicity degree + 1 the shape is cut in two, unless both sides meet
//!   there.

use super::{
    axis::Axis,
    export::nothing,
    polar::{Homogeneous, raised, refined},
};
use flankfit_geometry::{
    BSplineBasis,
    curve::{BSplineCurve, Curve},
    space::Vector,
    surface::{BSplineSurface, Surface},
};
use flankfit_numerics::{
    cancel::{self, Asking},
    check::Faults,
    words::Shown,
};

/// A shape that CAD files can hold.
#[derive(Clone, Copy, Debug)]
pub enum CadShape<'a> {
    /// A curve of plane or space, or a graph y(x).
    Curve(&'a BSplineCurve),
    /// A surface in space, or a graph z(u, v).
    Surface(&'a BSplineSurface),
}

/// A shape and its name in the file.
#[derive(Clone, Copy, Debug)]
pub struct NamedShape<'a> {
    /// Name of the entity in the file.
    pub name: &'a str,
    /// The curve or surface.
    pub shape: CadShape<'a>,
}

/// A curve in space.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CadCurve {
    pub(super) axis: Axis,
    pub(super) points: Vec<Vector>,
    pub(super) weights: Option<Vec<f64>>,
}

/// A surface in space; v runs fastest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CadSurface {
    pub(super) axes: [Axis; 2],
    pub(super) points: Vec<Vector>,
    pub(super) weights: Option<Vec<f64>>,
}

/// One piece of a shape.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Piece {
    Curve(CadCurve),
    Surface(CadSurface),
}

impl CadCurve {
    /// True if the curve ends where it begins.
    pub(super) fn is_closed(&self) -> bool {
        self.points.first() == self.points.last()
    }

    /// True if the curve has no extent.
    pub(super) fn is_point(&self) -> bool {
        self.points.iter().all(|p| *p == self.points[0])
    }

    /// Axis perpendicular to the plane of the curve, if that plane is parallel to two axes.
    pub(super) fn normal(&self) -> Option<Vector> {
        let flat = |k: &usize| self.points.iter().all(|p| p[*k] == self.points[0][*k]);
        [2, 1, 0].iter().find(|k| flat(k)).map(|k| Vector::ith(*k, 1.0))
    }
}

impl CadSurface {
    /// Control point and weight (i, j).
    fn control(&self, i: usize, j: usize) -> (Vector, Option<f64>) {
        let at = i * self.axes[1].size() + j;
        (self.points[at], self.weights.as_ref().map(|w| w[at]))
    }

    /// Equality of the first and the last line of control points, along u and along v.
    pub(super) fn is_closed(&self) -> [bool; 2] {
        let [m, n] = [self.axes[0].size(), self.axes[1].size()];
        [
            (0..n).all(|j| self.control(0, j) == self.control(m - 1, j)),
            (0..m).all(|i| self.control(i, 0) == self.control(i, n - 1)),
        ]
    }

    /// Border along parameter `along`, the other one being at its low or high end.
    pub(super) fn border(&self, along: usize, high: bool) -> CadCurve {
        let fixed = if high { self.axes[1 - along].size() - 1 } else { 0 };
        let (points, weights): (Vec<_>, Vec<_>) = (0..self.axes[along].size())
            .map(|k| if along == 0 { self.control(k, fixed) } else { self.control(fixed, k) })
            .unzip();
        let weights: Option<Vec<f64>> = weights.into_iter().collect();
        let weights = weights.filter(|w| w.iter().any(|x| *x != w[0]));
        CadCurve { axis: self.axes[along].clone(), points, weights }
    }
}

/// Message for a shape with numbers above the range of a double, by its place among the shapes.
pub fn not_finite(shape: usize) -> String {
    format!("shape {shape} exceeds the range of double precision in the file")
}

/// The pieces of every shape, each with its shape's place in `shapes`.
pub(super) fn pieces(shapes: &[NamedShape]) -> Result<Vec<(usize, Piece)>, Faults> {
    let mut all = Vec::new();
    for (shape, named) in shapes.iter().enumerate() {
        match named.shape {
            CadShape::Curve(curve) => {
                all.extend(curve_pieces(shape, curve)?.into_iter().map(|c| (shape, Piece::Curve(c))));
            }
            CadShape::Surface(surface) => {
                all.extend(surface_pieces(shape, surface)?.into_iter().map(|s| (shape, Piece::Surface(s))));
            }
        }
    }
    if all.is_empty() { Err(nothing()) } else { Ok(all) }
}

fn curve_pieces(shape: usize, curve: &BSplineCurve) -> Result<Vec<CadCurve>, Faults> {
    let basis = curve.basis();
    let graph = !curve.dimension().is_parametric();
    let height = graph.then_some(1);
    let (net, rational) = Control::net(shape, &[basis], curve.control_points(), curve.weights(), height)?;
    let lines = net.into_iter().map(|c| vec![c]).collect();
    let mut made = Vec::new();
    for (axis, lines) in brought_along(basis, lines, graph.then_some(0), rational) {
        let (points, weights) = Control::split(shape, lines.into_iter().flatten(), rational)?;
        made.push(CadCurve { axis, points, weights });
    }
    Ok(made)
}

fn surface_pieces(shape: usize, surface: &BSplineSurface) -> Result<Vec<CadSurface>, Faults> {
    let [along_u, along_v] = surface.bases();
    let graph = !surface.dimension().is_parametric();
    let height = graph.then_some(2);
    let (net, rational) =
        Control::net(shape, &[along_u, along_v], surface.control_points(), surface.weights(), height)?;
    let lines = net.chunks(along_v.size()).map(<[_]>::to_vec).collect();
    let mut made = Vec::new();
    for (u, lines) in brought_along(along_u, lines, graph.then_some(0), rational) {
        for (v, lines) in brought_along(along_v, transposed(&lines), graph.then_some(1), rational) {
            let (points, weights) = Control::split(shape, transposed(&lines).into_iter().flatten(), rational)?;
            made.push(CadSurface { axes: [u.clone(), v], points, weights });
        }
    }
    Ok(made)
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Control {
    point: Vector,
    weight: f64,
}

/// Control points across an axis, line by line; a curve has lines of one.
type Lines = Vec<Vec<Control>>;

impl Control {
    /// The control net of a shape, and whether its weights matter. The number of a graph goes to
    /// coordinate `height`.
    fn net(
        shape: usize,
        bases: &[&BSplineBasis],
        points: &[Vector],
        weights: Option<&[f64]>,
        height: Option<usize>,
    ) -> Result<(Vec<Control>, bool), Faults> {
        if bases.iter().any(|basis| basis.degree() == 0) {
            let message = format_args!("shape {shape} has degree 0; curves and surfaces of CAD have at least 1");
            return Err(Faults::one("", message));
        }
        let weights = weights.unwrap_or(&[]);
        if let Some(index) = weights.iter().position(|w| !(*w > 0.0)) {
            let value = Shown(weights[index]);
            return Err(Faults::one(
                "",
                format_args!("weight {index} of shape {shape} is {value}; weights in CAD files are above 0"),
            ));
        }
        let rational = weights.iter().any(|w| *w != weights[0]);
        let control = |(i, point): (usize, &Vector)| Control {
            point: height.map_or(*point, |k| Vector::ith(k, point.x)),
            weight: if rational { weights[i] } else { 1.0 },
        };
        Ok((points.iter().enumerate().map(control).collect(), rational))
    }

    fn split(
        shape: usize,
        net: impl Iterator<Item = Control>,
        rational: bool,
    ) -> Result<(Vec<Vector>, Option<Vec<f64>>), Faults> {
        let (points, weights): (Vec<Vector>, Vec<f64>) = net.map(|c| (c.point, c.weight)).unzip();
        let sound = points.iter().all(|p| p.iter().all(|x| x.is_finite()));
        if sound && weights.iter().all(|w| *w > 0.0 && w.is_finite()) {
            Ok((points, rational.then_some(weights)))
        } else {
            Err(Faults::one("", not_finite(shape)))
        }
    }
}

fn transposed(lines: &Lines) -> Lines {
    (0..lines.first().map_or(0, Vec::len)).map(|j| lines.iter().map(|line| line[j]).collect()).collect()
}

/// Puts the parameter into coordinate `graph`, clamps the ends, and cuts where the shape jumps.
fn brought_along(basis: &BSplineBasis, mut lines: Lines, graph: Option<usize>, rational: bool) -> Vec<(Axis, Lines)> {
    let mut axis = Axis::from(basis);
    match graph {
        Some(k) if rational => {
            let higher = axis.raised();
            let times = |t: f64, mut f: Homogeneous| {
                f[k] = t * f[3];
                f
            };
            lines = across(&lines, rational, |controls| raised(basis, controls, &higher, times));
            axis = higher;
        }
        _ if !axis.is_clamped() => {
            let finer = axis.clamped();
            lines = across(&lines, rational, |controls| refined(basis, controls, &finer));
            axis = finer;
        }
        _ => {}
    }
    if let (Some(k), false) = (graph, rational) {
        for (line, place) in lines.iter_mut().zip(axis.greville()) {
            line.iter_mut().for_each(|control| control.point[k] = place);
        }
    }
    cut(axis, lines)
}

/// Applies a change of control points to each row across the lines.
fn across(lines: &Lines, rational: bool, change: impl Fn(&[Homogeneous]) -> Vec<Homogeneous>) -> Lines {
    let lift = |c: &Control| {
        let p = c.point * c.weight;
        [p.x, p.y, p.z, c.weight]
    };
    let lower = |[x, y, z, w]: &Homogeneous| {
        // without weights the sum of shares is 1 but for rounding
        let weight = if rational { *w } else { 1.0 };
        Control { point: Vector::new(*x, *y, *z) / weight, weight }
    };
    let rows: Lines = transposed(lines)
        .iter()
        .asking(1000)
        .map(|row| change(&row.iter().map(lift).collect::<Vec<_>>()).iter().map(lower).collect())
        .collect();
    transposed(&rows)
}

/// Cuts at inner knots of full multiplicity; where both sides have the same control points one of
/// them, and a knot, is dropped.
fn cut(mut axis: Axis, mut lines: Lines) -> Vec<(Axis, Lines)> {
    for at in axis.jumps().into_iter().rev() {
        cancel::checkpoint();
        if lines[at - 1] == lines[at] {
            axis.knots.remove(at);
            lines.remove(at);
        }
    }
    let mut starts = vec![0];
    starts.extend(axis.jumps());
    let order = axis.degree + 1;
    let ends = starts[1..].iter().copied().chain([lines.len()]);
    let piece = |(start, end): (&usize, usize)| {
        let knots = axis.knots[*start..end + order].to_vec();
        (Axis { degree: axis.degree, knots }, lines[*start..end].to_vec())
    };
    starts.iter().zip(ends).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_geometry::space::Dimension;

    fn rebuilt(curve: &CadCurve) -> BSplineCurve {
        let basis = BSplineBasis::new(curve.axis.degree, curve.axis.knots.clone()).unwrap();
        BSplineCurve::new(basis, Dimension::Space, curve.points.clone(), curve.weights.clone()).unwrap()
    }

    fn curve(degree: usize, knots: &[f64], dimension: Dimension, y: &[f64], w: Option<&[f64]>) -> BSplineCurve {
        let basis = BSplineBasis::new(degree, knots.to_vec()).unwrap();
        let points = y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect();
        BSplineCurve::new(basis, dimension, points, w.map(<[f64]>::to_vec)).unwrap()
    }

    #[track_caller]
    fn same_place(given: &BSplineCurve, pieces: &[CadCurve]) {
        for piece in pieces {
            let made = rebuilt(piece);
            let [a, b] = made.domain();
            for k in 0..16 {
                // not the end: there a piece and what follows it differ
                let t = a + (b - a) * f64::from(k) / 16.0;
                let gap = (made.value(t) - given.place(t)[0]).norm();
                assert!(gap < 1e-14 * (1.0 + made.value(t).norm()), "{t}: {gap:e}");
            }
        }
    }

    #[test]
    fn graphs_with_and_without_weights_and_with_loose_ends() {
        let (clamped, loose) = ([0., 0., 0., 1., 3., 3., 3.], [-1., -0.5, 0., 1., 3., 3.5, 3.5]);
        let (y, w) = ([1.0, -2.0, 0.5, 4.0], [1.0, 0.3, 2.0, 1.0]);
        for knots in [clamped, loose] {
            for weights in [None, Some(&w[..])] {
                let given = curve(2, &knots, Dimension::Graph, &y, weights);
                let pieces = curve_pieces(0, &given).unwrap();
                assert_eq!(pieces.len(), 1);
                assert_eq!(pieces[0].axis.degree, 2 + usize::from(weights.is_some()));
                assert!(pieces[0].axis.is_clamped());
                same_place(&given, &pieces);
            }
        }
    }

    #[test]
    fn jumps_are_cut_and_joints_are_not() {
        let knots = [0., 0., 1., 1., 2., 2., 3., 3.];
        let given = curve(1, &knots, Dimension::Plane, &[1.0, 2.0, 2.0, 3.0, 5.0, 4.0], None);
        let pieces = curve_pieces(0, &given).unwrap();
        assert_eq!(
            pieces.iter().map(|p| p.axis.knots.clone()).collect::<Vec<_>>(),
            [vec![0., 0., 1., 2., 2.], vec![2., 2., 3., 3.]]
        );
        same_place(&given, &pieces);
    }

    #[test]
    fn curves_that_cad_files_cannot_hold_are_refused() {
        let zero = curve(0, &[0., 1., 2.], Dimension::Graph, &[1.0, 2.0], None);
        assert!(curve_pieces(3, &zero).unwrap_err().to_string().starts_with("shape 3 has degree 0;"));
        let knots = [0., 0., 0., 1., 1., 1.];
        let weightless = curve(2, &knots, Dimension::Plane, &[1.0, 2.0, 3.0], Some(&[1.0, 0.0, 1.0]));
        assert!(curve_pieces(0, &weightless).unwrap_err().to_string().starts_with("weight 1 of shape 0 is 0;"));
        assert_eq!(pieces(&[]), Err(nothing()));
        // equal weights are no weights
        let plain = curve(2, &knots, Dimension::Plane, &[1.0, 2.0, 3.0], Some(&[0.3; 3]));
        assert_eq!(curve_pieces(0, &plain).unwrap()[0].weights, None);
    }

    #[test]
    fn a_rational_graph_over_two_axes() {
        let bases = [[0., 0., 0., 1., 2., 2., 2.], [-1., -1., -1., 0.5, 4., 4., 4.]]
            .map(|knots| BSplineBasis::new(2, knots.to_vec()).unwrap());
        let points = (0..16).map(|i| Vector::new(f64::from(i).sin(), 0.0, 0.0)).collect();
        let weights = (0..16).map(|i| 1.0 + 0.5 * f64::from(i * i).cos()).collect();
        let given = BSplineSurface::new(bases, Dimension::Graph, points, Some(weights)).unwrap();
        let piece = surface_pieces(0, &given).unwrap().remove(0);
        let bases = piece.axes.map(|axis| BSplineBasis::new(axis.degree, axis.knots).unwrap());
        let made = BSplineSurface::new(bases, Dimension::Space, piece.points, piece.weights).unwrap();
        for k in 0..=20 {
            let (u, v) = (0.1 * f64::from(k), 4.0 - 0.25 * f64::from(k));
            assert!((made.value(u, v) - given.place(u, v).value).norm() < 1e-14);
        }
    }
}
