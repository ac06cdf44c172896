//! Many places of one surface at once.
//!
//! B-spline and Bézier surfaces of degrees up to 5 are prepared span by span (`axis.rs`) and summed
//! without allocating; on a grid of places the sums over u are shared by a whole row. Other
//! surfaces are asked place by place. Above a size the work is shared out in chunks: every place is
//! computed in the same way whichever thread takes it.

use super::{
    BSplineSurface, Surface, SurfaceJet, SurfaceShape,
    axis::{Axis, Functions},
    b_spline::quotient,
};
use crate::{
    BSplineBasis,
    space::{Dimension, Vector},
};
use flankfit_numerics::{cancel, fma};
use rayon::prelude::*;
use std::ops::Range;

/// Places that one thread takes at a time; fewer are not shared out.
const CHUNK: usize = 4096;

/// A surface made ready for many places.
#[derive(Clone, Debug)]
pub struct Evaluator<'a> {
    surface: &'a SurfaceShape,
    plan: Plan,
}

#[derive(Clone, Debug)]
enum Plan {
    Cubic(Tensor<4>),
    Quintic(Tensor<6>),
    Direct,
}

impl<'a> Evaluator<'a> {
    /// Prepares `surface`: work in proportion to its control points.
    pub fn new(surface: &'a SurfaceShape) -> Self {
        let spline = match surface {
            SurfaceShape::BSpline(spline) => Some(spline),
            SurfaceShape::Bezier(patch) => Some(patch.as_b_spline()),
            _ => None,
        };
        let cubic = spline.and_then(Tensor::new).map(Plan::Cubic);
        let plan = cubic.or_else(|| spline.and_then(Tensor::new).map(Plan::Quintic)).unwrap_or(Plan::Direct);
        Evaluator { surface, plan }
    }

    /// The first coordinate at every place: z(u, v) of a graph.
    pub fn heights(&self, at: &[[f64; 2]]) -> Vec<f64> {
        match &self.plan {
            Plan::Cubic(tensor) => each(at, |u, v| tensor.height(u, v)),
            Plan::Quintic(tensor) => each(at, |u, v| tensor.height(u, v)),
            Plan::Direct => each(at, |u, v| self.surface.value(u, v).x),
        }
    }

    /// The value at every place.
    pub fn values(&self, at: &[[f64; 2]]) -> Vec<Vector> {
        match &self.plan {
            Plan::Cubic(tensor) => each(at, |u, v| tensor.jet::<0>(u, v).value),
            Plan::Quintic(tensor) => each(at, |u, v| tensor.jet::<0>(u, v).value),
            Plan::Direct => each(at, |u, v| self.surface.value(u, v)),
        }
    }

    /// Value and derivatives to order 2 at every place.
    pub fn jets(&self, at: &[[f64; 2]]) -> Vec<SurfaceJet> {
        match &self.plan {
            Plan::Cubic(tensor) => each(at, |u, v| tensor.jet::<2>(u, v)),
            Plan::Quintic(tensor) => each(at, |u, v| tensor.jet::<2>(u, v)),
            Plan::Direct => each(at, |u, v| self.surface.jet(u, v)),
        }
    }

    /// The values at all (u, v) of a grid, v running fastest.
    pub fn grid_values(&self, us: &[f64], vs: &[f64]) -> Vec<Vector> {
        match &self.plan {
            Plan::Cubic(tensor) => tensor.grid::<0, _>(us, vs, |jet| jet.value),
            Plan::Quintic(tensor) => tensor.grid::<0, _>(us, vs, |jet| jet.value),
            Plan::Direct => self.values(&crossings(us, vs)),
        }
    }

    /// The first coordinate at all (u, v) of a grid, v running fastest.
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     space::{Dimension, Vector},
    ///     surface::{BezierSurface, Evaluator, SurfaceShape},
    /// };
    ///
    /// // The saddle z = uv at 2 × 3 places, v running fastest.
    /// let heights = [0.0, 0.0, 0.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
    /// let saddle = BezierSurface::new([2, 2], [[0.0, 1.0]; 2], Dimension::Graph, heights, None)?;
    /// let saddle = SurfaceShape::Bezier(saddle);
    /// let grid = Evaluator::new(&saddle).grid_heights(&[0.5, 1.0], &[0.0, 0.5, 1.0]);
    /// assert_eq!(grid, [0.0, 0.25, 0.5, 0.0, 0.5, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn grid_heights(&self, us: &[f64], vs: &[f64]) -> Vec<f64> {
        match &self.plan {
            Plan::Cubic(tensor) => tensor.height_grid(us, vs),
            Plan::Quintic(tensor) => tensor.height_grid(us, vs),
            Plan::Direct => self.heights(&crossings(us, vs)),
        }
    }

    /// Value and derivatives to order 2 at all (u, v) of a grid, v running fastest.
    pub fn grid_jets(&self, us: &[f64], vs: &[f64]) -> Vec<SurfaceJet> {
        match &self.plan {
            Plan::Cubic(tensor) => tensor.grid::<2, _>(us, vs, |jet| jet),
            Plan::Quintic(tensor) => tensor.grid::<2, _>(us, vs, |jet| jet),
            Plan::Direct => self.jets(&crossings(us, vs)),
        }
    }
}

fn crossings(us: &[f64], vs: &[f64]) -> Vec<[f64; 2]> {
    us.iter().flat_map(|u| vs.iter().map(move |v| [*u, *v])).collect()
}

/// `f` at every place, in order.
fn each<T: Send>(at: &[[f64; 2]], f: impl Fn(f64, f64) -> T + Sync) -> Vec<T> {
    let handle = cancel::current();
    let f = |u: f64, v: f64| {
        cancel::ask(handle.as_ref());
        f(u, v)
    };
    if at.len() < 2 * CHUNK {
        return at.iter().map(|[u, v]| f(*u, *v)).collect();
    }
    at.par_iter().with_min_len(CHUNK).map(|[u, v]| f(*u, *v)).collect()
}

/// Two prepared axes and the control points between them, coordinate by coordinate.
#[derive(Clone, Debug)]
struct Tensor<const N: usize> {
    along_u: Axis<N>,
    along_v: Axis<N>,
    /// The net of each coordinate that counts; with weights, these times the coordinates, and the
    /// weights last. Filled up with N rows and columns of zeros, so that functions above the degree
    /// find something to be multiplied with.
    planes: Vec<Vec<f64>>,
    columns: usize,
    dimension: Dimension,
    is_rational: bool,
}

/// Common values of the places of one line of a grid: their numbers, and the sums over u for every
/// column.
#[derive(Default)]
struct Line {
    places: Range<usize>,
    row: Vec<f64>,
    weights: Vec<f64>,
}

/// Sums over the functions of u alone, for N columns, with derivatives by u.
type Row<const N: usize> = [[f64; N]; 3];

impl<const N: usize> Tensor<N> {
    fn new(spline: &BSplineSurface) -> Option<Self> {
        let (along_u, along_v) = (Axis::new(&spline.bases()[0])?, Axis::new(&spline.bases()[1])?);
        let [rows, given] = spline.bases().each_ref().map(BSplineBasis::size);
        let (columns, count) = (given + N, spline.dimension().count());
        let weight = |k: usize| spline.weights().map_or(1.0, |w| w[k]);
        let plane = |value: &dyn Fn(usize) -> f64| {
            let mut plane = vec![0.0; (rows + N) * columns];
            for (i, row) in plane.chunks_exact_mut(columns).take(rows).enumerate() {
                for (j, entry) in row[..given].iter_mut().enumerate() {
                    *entry = value(i * given + j);
                }
            }
            plane
        };
        let points = spline.control_points();
        let mut planes: Vec<Vec<f64>> = (0..count).map(|c| plane(&|k| points[k][c] * weight(k))).collect();
        let is_rational = spline.weights().is_some();
        if is_rational {
            planes.push(plane(&weight));
        }
        Some(Tensor { along_u, along_v, planes, columns, dimension: spline.dimension(), is_rational })
    }

    #[inline(always)]
    fn row<const ORDER: usize>(&self, plane: &[f64], i: usize, j: usize, functions: &Functions<N>) -> Row<N> {
        let mut row = [[0.0; N]; 3];
        for k in 0..N {
            let start = (i + k) * self.columns + j;
            let net = &plane[start..start + N];
            for order in 0..=ORDER {
                for c in 0..N {
                    row[order][c] = fma(functions[order][k], net[c], row[order][c]);
                }
            }
        }
        row
    }

    #[inline(always)]
    fn height(&self, u: f64, v: f64) -> f64 {
        let (i, fu) = self.along_u.at::<0>(u);
        let (j, fv) = self.along_v.at::<0>(v);
        let sum = |plane: &[f64]| dot(&self.row::<0>(plane, i, j, &fu)[0], &fv[0]);
        let height = sum(&self.planes[0]);
        if self.is_rational { height / sum(&self.planes[self.planes.len() - 1]) } else { height }
    }

    #[inline(always)]
    fn jet<const ORDER: usize>(&self, u: f64, v: f64) -> SurfaceJet {
        let (i, fu) = self.along_u.at::<ORDER>(u);
        let (j, fv) = self.along_v.at::<ORDER>(v);
        self.assembled::<ORDER>(&fv, |c| self.row::<ORDER>(&self.planes[c], i, j, &fu))
    }

    /// The jet from the rows of every plane.
    #[inline(always)]
    fn assembled<const ORDER: usize>(&self, fv: &Functions<N>, row: impl Fn(usize) -> Row<N>) -> SurfaceJet {
        let mut points = [Vector::zeros(); 6];
        for c in 0..self.dimension.count() {
            let sums = sums::<N, ORDER>(&row(c), fv);
            for (point, sum) in points.iter_mut().zip(sums) {
                point[c] = sum;
            }
        }
        if self.is_rational {
            return quotient(&points, &sums::<N, ORDER>(&row(self.planes.len() - 1), fv));
        }
        let [value, u, v, uu, uv, vv] = points;
        SurfaceJet { value, u, v, uu, uv, vv }
    }

    /// The heights at us × vs, place by place; the sums over u are made when a place begins a new
    /// line.
    fn height_grid(&self, us: &[f64], vs: &[f64]) -> Vec<f64> {
        let across: Vec<(usize, [f64; N])> =
            vs.iter().map(|v| self.along_v.at::<0>(*v)).map(|(j, f)| (j, f[0])).collect();
        let count = us.len() * vs.len();
        let handle = cancel::current();
        let height = |line: &mut Line, k: usize| {
            cancel::ask(handle.as_ref());
            if !line.places.contains(&k) {
                let i = k / vs.len();
                line.places = i * vs.len()..(i + 1) * vs.len();
                self.fill(line, us[i]);
            }
            let (j, fv) = &across[k - line.places.start];
            let sum = |row: &[f64]| {
                let mut net = [0.0; N];
                net.copy_from_slice(&row[*j..*j + N]);
                dot(&net, fv)
            };
            if self.is_rational { sum(&line.row) / sum(&line.weights) } else { sum(&line.row) }
        };
        if count < 2 * CHUNK {
            let mut line = Line::default();
            return (0..count).map(|k| height(&mut line, k)).collect();
        }
        (0..count).into_par_iter().with_min_len(CHUNK).map_init(Line::default, height).collect()
    }

    /// Sums over the functions of `u` for every column, of the first coordinate and of the weights.
    fn fill(&self, line: &mut Line, u: f64) {
        let (i, fu) = self.along_u.at::<0>(u);
        let sum = |plane: &[f64], row: &mut Vec<f64>| {
            row.clear();
            row.resize(self.columns, 0.0);
            for k in 0..N {
                let net = &plane[(i + k) * self.columns..][..self.columns];
                row.iter_mut().zip(net).for_each(|(sum, c)| *sum = fma(fu[0][k], *c, *sum));
            }
        };
        sum(&self.planes[0], &mut line.row);
        if self.is_rational {
            sum(&self.planes[self.planes.len() - 1], &mut line.weights);
        }
    }

    /// The grid of places us × vs: the sums over u are made once for each u and every column.
    fn grid<const ORDER: usize, T: Send>(&self, us: &[f64], vs: &[f64], of: impl Fn(SurfaceJet) -> T + Sync) -> Vec<T> {
        let across: Vec<_> = vs.iter().map(|v| self.along_v.at::<ORDER>(*v)).collect();
        let handle = cancel::current();
        let line = |u: &f64| {
            let (i, fu) = self.along_u.at::<ORDER>(*u);
            let mut rows = vec![0.0; self.planes.len() * (ORDER + 1) * self.columns];
            for (sums, plane) in rows.chunks_exact_mut((ORDER + 1) * self.columns).zip(&self.planes) {
                for (order, sums) in sums.chunks_exact_mut(self.columns).enumerate() {
                    for k in 0..N {
                        let net = &plane[(i + k) * self.columns..][..self.columns];
                        for (sum, c) in sums.iter_mut().zip(net) {
                            *sum = fma(fu[order][k], *c, *sum);
                        }
                    }
                }
            }
            let at = |(j, fv): &(usize, Functions<N>)| {
                cancel::ask(handle.as_ref());
                of(self.assembled::<ORDER>(fv, |plane| {
                    let mut row = [[0.0; N]; 3];
                    for order in 0..=ORDER {
                        let start = (plane * (ORDER + 1) + order) * self.columns + j;
                        row[order].copy_from_slice(&rows[start..start + N]);
                    }
                    row
                }))
            };
            across.iter().map(at).collect::<Vec<T>>()
        };
        if us.len() * vs.len() < 2 * CHUNK {
            return us.iter().flat_map(line).collect();
        }
        us.par_iter().with_min_len(CHUNK.div_ceil(vs.len().max(1))).flat_map_iter(line).collect()
    }
}

#[inline(always)]
fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum = fma(a[i], b[i], sum);
    }
    sum
}

/// Value, u, v, uu, uv, vv of one coordinate.
#[inline(always)]
fn sums<const N: usize, const ORDER: usize>(row: &Row<N>, fv: &Functions<N>) -> [f64; 6] {
    let mut sums = [0.0; 6];
    sums[0] = dot(&row[0], &fv[0]);
    if ORDER > 0 {
        sums[1] = dot(&row[1], &fv[0]);
        sums[2] = dot(&row[0], &fv[1]);
    }
    if ORDER > 1 {
        sums[3] = dot(&row[2], &fv[0]);
        sums[4] = dot(&row[1], &fv[1]);
        sums[5] = dot(&row[0], &fv[2]);
    }
    sums
}
