//! B-spline surfaces near the nodes of a grid, by least squares without weights.
//!
//! On a full grid the problem separates, `X = X_u ⊗ X_v`: first every column of nodes is fitted along u, then what comes out along v.
//! Each axis is a banded matrix of m rows with degree + 1 entries, triangularised by rotations (O(m degree²)), which then serves
//! all lines at once through the seminormal equations `RᵀR x = Xᵀz`, corrected by their own residuals (Björck 1987): the inner
//! loops run over lines side by side.
//!
//! Grids of up to [`FINE`] nodes are fitted with residuals in double-double, which gives the coefficients all digits of a double;
//! larger ones with residuals in double, which keeps them to rounding of the largest.

use super::{
    BSplineSurface,
    grid::{GridFault, NodeGrid, basis_of, check_degree},
};
use crate::geometry::{BSplineBasis, curve::knots, space::Vector};
use crate::numerics::{
    Dd, Real,
    dd::{two_prod, two_sum},
};

/// Grids of more nodes are fitted in plain double.
pub const FINE: usize = 4096;
/// Corrections of one solution, at most.
const CORRECTIONS: usize = 6;
/// A rotation of unit rows that leaves less on the diagonal than this has found no new direction.
const RANK: f64 = 1e-13;
const RANK_FINE: f64 = 1e-26;

/// Where the knots of an axis come from.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisKnots {
    /// The full vector.
    Given(Vec<f64>),
    /// This many spans, each with about as many nodes (Piegl and Tiller, Eqs. 9.68 and 9.69).
    Spans(usize),
    /// This many spans of equal width.
    Uniform(usize),
}

/// The surface of these degrees with the least sum of squared distances (in its values) from the nodes, and that sum.
pub fn least_squares(
    grid: &NodeGrid,
    degrees: [usize; 2],
    knots: [AxisKnots; 2],
) -> Result<(BSplineSurface, f64), GridFault> {
    let [knots_u, knots_v] = knots;
    let bases = [basis(grid, 0, degrees[0], knots_u)?, basis(grid, 1, degrees[1], knots_v)?];
    let [rows, columns] = grid.parameters().each_ref().map(Vec::len);
    let fine = rows * columns <= FINE;
    let along_u = AxisFit::new(0, &bases[0], &grid.parameters()[0], fine)?;
    let along_v = AxisFit::new(1, &bases[1], &grid.parameters()[1], fine)?;
    let size = bases[0].size() * bases[1].size();
    let mut points = vec![Vector::zeros(); size];
    for c in 0..grid.dimension().count() {
        let nodes = Block::of(columns, grid.values().iter().map(|p| p[c]).collect());
        let half = along_u.solve(&nodes).transposed();
        let whole = along_v.solve(&half).transposed();
        for (index, (point, x)) in points.iter_mut().zip(&whole.hi).enumerate() {
            if !x.is_finite() {
                return Err(GridFault::NotRepresentable { index });
            }
            point[c] = *x;
        }
    }
    let sum = residual_sum(grid, &[&along_u, &along_v], &points, bases[1].size());
    let surface = BSplineSurface::new(bases, grid.dimension(), points, None);
    Ok((surface.map_err(|_| GridFault::NotRepresentable { index: 0 })?, sum))
}

fn basis(grid: &NodeGrid, axis: usize, degree: usize, knots: AxisKnots) -> Result<BSplineBasis, GridFault> {
    let nodes = &grid.parameters()[axis];
    check_degree(axis, degree, nodes.len())?;
    let (low, high) = (nodes[0], nodes[nodes.len() - 1]);
    let spans_fault = |spans| GridFault::Spans { axis, spans, nodes: nodes.len(), degree };
    let checked = |spans: usize| {
        let fits = spans >= 1 && spans.saturating_add(degree) <= nodes.len();
        if fits { Ok(spans) } else { Err(spans_fault(spans)) }
    };
    let basis = match knots {
        AxisKnots::Given(knots) => basis_of(axis, degree, knots, nodes)?,
        AxisKnots::Spans(spans) => {
            let knots = knots::averaging_least_squares(degree, nodes, checked(spans)? + degree);
            basis_of(axis, degree, knots.map_err(|_| spans_fault(spans))?, nodes)?
        }
        AxisKnots::Uniform(spans) => BSplineBasis::uniform(degree, checked(spans)?, low, high)
            .map_err(|fault| GridFault::Knots { axis, fault })?,
    };
    if basis.size() > nodes.len() {
        return Err(GridFault::Functions { axis, functions: basis.size(), nodes: nodes.len() });
    }
    Ok(basis)
}

/// Sum of squared residuals over all coordinates.
fn residual_sum(grid: &NodeGrid, [along_u, along_v]: &[&AxisFit; 2], points: &[Vector], columns: usize) -> f64 {
    let mut sum = 0.0;
    for c in 0..grid.dimension().count() {
        let coefficients = Block::of(columns, points.iter().map(|p| p[c]).collect());
        // values at the nodes' v for every function of u, then at their u: in the order of the nodes
        let half = along_v.times(&coefficients.transposed()).transposed();
        let fitted = along_u.times(&half);
        sum += grid.values().iter().zip(&fitted.hi).map(|(z, f)| (z[c] - f) * (z[c] - f)).sum::<f64>();
    }
    sum
}

/// A matrix of unevaluated sums `hi + lo`, row by row.
struct Block {
    width: usize,
    hi: Vec<f64>,
    /// Empty where all are 0.
    lo: Vec<f64>,
}

impl Block {
    fn of(width: usize, hi: Vec<f64>) -> Self {
        Block { width, hi, lo: Vec::new() }
    }

    fn transposed(&self) -> Self {
        let height = self.hi.len() / self.width;
        let turn = |from: &[f64]| {
            let mut to = vec![0.0; from.len()];
            for (i, row) in from.chunks_exact(self.width).enumerate() {
                for (j, x) in row.iter().enumerate() {
                    to[j * height + i] = *x;
                }
            }
            to
        };
        Block { width: height, hi: turn(&self.hi), lo: turn(&self.lo) }
    }
}

/// The functions of one axis at its nodes, and the triangular factor of that matrix.
struct AxisFit {
    /// Entries of a row, degree + 1.
    band: usize,
    functions: usize,
    first: Vec<usize>,
    hi: Vec<f64>,
    /// Empty for a fit in plain double.
    lo: Vec<f64>,
    factor: Factor,
}

enum Factor {
    Double(Vec<f64>),
    Fine(Vec<Dd>),
}

impl AxisFit {
    fn new(axis: usize, basis: &BSplineBasis, nodes: &[f64], fine: bool) -> Result<Self, GridFault> {
        let (band, functions) = (basis.degree() + 1, basis.size());
        let support = |j: usize| (basis.knots()[j], basis.knots()[j + band]);
        let mut first = Vec::with_capacity(nodes.len());
        let (mut hi, mut lo) = (vec![0.0; nodes.len() * band], Vec::new());
        if fine {
            let mut values = vec![Dd::ZERO; band];
            lo.resize(hi.len(), 0.0);
            for (i, x) in nodes.iter().enumerate() {
                first.push(basis.values(*x, &mut values));
                for (j, value) in values.iter().enumerate() {
                    (hi[i * band + j], lo[i * band + j]) = (value.hi, value.lo);
                }
            }
        } else {
            for (x, row) in nodes.iter().zip(hi.chunks_exact_mut(band)) {
                first.push(basis.values(*x, row));
            }
        }
        // each function takes the next node that sees it
        let mut node = 0;
        for function in 0..functions {
            let sees =
                |i: usize| (first[i]..first[i] + band).contains(&function) && hi[i * band + function - first[i]] > 0.0;
            match (node..nodes.len()).find(|i| sees(*i)) {
                Some(found) => node = found + 1,
                None => {
                    let (low, high) = support(function);
                    return Err(GridFault::SchoenbergWhitney { axis, function, low, high });
                }
            }
        }
        let rank = |function: usize| {
            let (low, high) = support(function);
            GridFault::Rank { axis, function, low, high }
        };
        let mut fit = AxisFit { band, functions, first, hi, lo, factor: Factor::Double(Vec::new()) };
        fit.factor = match triangle(&fit, |k| fit.hi[k], RANK) {
            Ok(r) => Factor::Double(r),
            Err(_) if fine => Factor::Fine(fit.fine_triangle().map_err(rank)?),
            Err(function) => return Err(rank(function)),
        };
        Ok(fit)
    }

    fn fine_triangle(&self) -> Result<Vec<Dd>, usize> {
        triangle(self, |k| Dd { hi: self.hi[k], lo: self.lo[k] }, RANK_FINE)
    }

    /// Fits every column of `z`.
    fn solve(&self, z: &Block) -> Block {
        let width = z.width;
        let mut x = Block::of(width, vec![0.0; self.functions * width]);
        if !self.lo.is_empty() {
            x.lo = vec![0.0; x.hi.len()];
        }
        let double = match &self.factor {
            Factor::Double(r) => r,
            Factor::Fine(r) => {
                self.correct_fine(r, z, &mut x);
                return x;
            }
        };
        if self.lo.is_empty() {
            // as it comes, and one correction
            for correction in [false, true] {
                let mut step = self.gradient(z, correction.then_some(&x));
                seminormal(double, self.band, width, &mut step);
                x.hi.iter_mut().zip(step).for_each(|(x, s)| *x += s);
            }
            return x;
        }
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            let mut step = self.gradient_fine(z, &x).0;
            seminormal(double, self.band, width, &mut step);
            let (change, size) = (largest(&step), largest(&x.hi));
            add(&mut x, &step);
            if change <= 1e-18 * size || change == 0.0 {
                return x;
            }
            if change > 1e-2 * before {
                break;
            }
            before = change;
        }
        // the factor in double is too coarse for these nodes
        if before > 1e-17 * largest(&x.hi)
            && let Ok(r) = self.fine_triangle()
        {
            self.correct_fine(&r, z, &mut x);
        }
        x
    }

    fn correct_fine(&self, r: &[Dd], z: &Block, x: &mut Block) {
        for _ in 0..CORRECTIONS {
            let (hi, lo) = self.gradient_fine(z, x);
            let mut step: Vec<Dd> = hi.into_iter().zip(lo).map(|(hi, lo)| Dd::sum(hi, lo)).collect();
            seminormal(r, self.band, z.width, &mut step);
            let step: Vec<f64> = step.into_iter().map(Dd::to_f64).collect();
            let change = largest(&step);
            add(x, &step);
            if change <= 1e-20 * largest(&x.hi) {
                return;
            }
        }
    }

    /// `X x`, in double.
    fn times(&self, x: &Block) -> Block {
        let width = x.width;
        let mut product = vec![0.0; self.first.len() * width];
        for (i, out) in product.chunks_exact_mut(width).enumerate() {
            for j in 0..self.band {
                let a = self.hi[i * self.band + j];
                let row = &x.hi[(self.first[i] + j) * width..][..width];
                out.iter_mut().zip(row).for_each(|(out, x)| *out = a.mul_add(*x, *out));
            }
        }
        Block::of(width, product)
    }

    /// `Xᵀ(z − X x)` in double, or `Xᵀz` while there is no x.
    fn gradient(&self, z: &Block, x: Option<&Block>) -> Vec<f64> {
        let width = z.width;
        let mut gradient = vec![0.0; self.functions * width];
        let mut left = vec![0.0; width];
        for (i, first) in self.first.iter().enumerate() {
            let row = &self.hi[i * self.band..][..self.band];
            let mut rest: &[f64] = &z.hi[i * width..][..width];
            if let Some(x) = x {
                left.copy_from_slice(rest);
                for (j, a) in row.iter().enumerate() {
                    let x = &x.hi[(first + j) * width..][..width];
                    left.iter_mut().zip(x).for_each(|(r, x)| *r = (-a).mul_add(*x, *r));
                }
                rest = &left;
            }
            for (j, a) in row.iter().enumerate() {
                let sum = &mut gradient[(first + j) * width..][..width];
                sum.iter_mut().zip(rest).for_each(|(g, r)| *g = a.mul_add(*r, *g));
            }
        }
        gradient
    }

    /// The same to about twice the digits, as high and low parts.
    fn gradient_fine(&self, z: &Block, x: &Block) -> (Vec<f64>, Vec<f64>) {
        let width = z.width;
        let size = self.functions * width;
        let (mut hi, mut lo) = (vec![0.0; size], vec![0.0; size]);
        let (mut rest, mut rest_lo) = (vec![0.0; width], vec![0.0; width]);
        for (i, first) in self.first.iter().enumerate() {
            rest.copy_from_slice(&z.hi[i * width..][..width]);
            match z.lo.is_empty() {
                true => rest_lo.fill(0.0),
                false => rest_lo.copy_from_slice(&z.lo[i * width..][..width]),
            }
            for j in 0..self.band {
                let (a, a_lo) = (-self.hi[i * self.band + j], -self.lo[i * self.band + j]);
                let from = (first + j) * width;
                let (x, x_lo) = (&x.hi[from..][..width], &x.lo[from..][..width]);
                for k in 0..width {
                    accumulate(&mut rest[k], &mut rest_lo[k], (a, a_lo), (x[k], x_lo[k]));
                }
            }
            for j in 0..self.band {
                let a = (self.hi[i * self.band + j], self.lo[i * self.band + j]);
                let from = (first + j) * width;
                let (hi, lo) = (&mut hi[from..][..width], &mut lo[from..][..width]);
                for k in 0..width {
                    accumulate(&mut hi[k], &mut lo[k], a, (rest[k], rest_lo[k]));
                }
            }
        }
        (hi, lo)
    }
}

/// Adds `a x` to the unevaluated sum.
#[inline(always)]
fn accumulate(hi: &mut f64, lo: &mut f64, a: (f64, f64), x: (f64, f64)) {
    let (product, error) = two_prod(a.0, x.0);
    let (sum, rest) = two_sum(*hi, product);
    *hi = sum;
    *lo += rest + a.0.mul_add(x.1, a.1.mul_add(x.0, error));
}

fn add(x: &mut Block, step: &[f64]) {
    for ((hi, lo), s) in x.hi.iter_mut().zip(&mut x.lo).zip(step) {
        let (sum, rest) = two_sum(*hi, *s);
        (*hi, *lo) = two_sum(sum, rest + *lo);
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, x| a.max(x.abs()))
}

/// The upper triangular factor, row j holding columns j to j + band − 1; or the function that no node determines.
fn triangle<T: Real>(fit: &AxisFit, entry: impl Fn(usize) -> T, rank: f64) -> Result<Vec<T>, usize> {
    let (band, n) = (fit.band, fit.functions);
    let mut r = vec![T::zero(); n * band];
    let mut row = vec![T::zero(); band];
    for (i, first) in fit.first.iter().enumerate() {
        for (j, x) in row.iter_mut().enumerate() {
            *x = entry(i * band + j);
        }
        // rotates the row into rows first, first + 1, …; it never grows longer than the band
        for k in 0..band {
            let x = row[k];
            if x.is_zero() {
                continue;
            }
            let above = &mut r[(first + k) * band..][..band - k];
            let length = above[0].fma(above[0], x * x).sqrt();
            let (c, s) = (above[0] / length, x / length);
            for (a, b) in above.iter_mut().zip(&mut row[k..]) {
                (*a, *b) = (c.fma(*a, s * *b), c.fma(*b, -(s * *a)));
            }
        }
    }
    match (0..n).find(|j| !(r[j * band].abs().to_f64() > rank)) {
        Some(function) => Err(function),
        None => Ok(r),
    }
}

/// Solves `RᵀR x = g` in place for all columns.
fn seminormal<T: Real>(r: &[T], band: usize, width: usize, g: &mut [T]) {
    let n = r.len() / band;
    for j in 0..n {
        let (done, rest) = g.split_at_mut((j + 1) * width);
        let (row, inverse) = (&r[j * band..][..band], T::one() / r[j * band]);
        let here = &mut done[j * width..];
        here.iter_mut().for_each(|x| *x *= inverse);
        for (below, a) in rest.chunks_exact_mut(width).zip(&row[1..]) {
            below.iter_mut().zip(&*here).for_each(|(b, x)| *b = (-*a).fma(*x, *b));
        }
    }
    for j in (0..n).rev() {
        let (done, rest) = g.split_at_mut((j + 1) * width);
        let (row, inverse) = (&r[j * band..][..band], T::one() / r[j * band]);
        let here = &mut done[j * width..];
        for (below, a) in rest.chunks_exact(width).zip(&row[1..]) {
            here.iter_mut().zip(below).for_each(|(x, b)| *x = (-*a).fma(*b, *x));
        }
        here.iter_mut().for_each(|x| *x *= inverse);
    }
}
