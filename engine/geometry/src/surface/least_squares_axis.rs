//! One axis of a least-squares fit on a grid: a banded matrix, its triangular factor, and solutions
//! for many lines side by side.
//!
//! Lines lie eight abreast, so that one step of the elimination is a few operations on whole
//! registers.

use super::check;
use crate::BSplineBasis;
use flankfit_numerics::{
    Dd, Real,
    cancel::Asking,
    check::Faults,
    dd::{two_prod, two_sum},
    fma,
};

/// Lines that are worked on side by side.
const ABREAST: usize = 8;
/// Corrections of one solution, at most.
const CORRECTIONS: usize = 6;
/// A row of functions sums to 1; rotations that leave less than this on the diagonal have found no
/// new direction.
const RANK: f64 = 1e-13;
const RANK_FINE: f64 = 1e-26;

type Lane<T> = [T; ABREAST];

/// A matrix of unevaluated sums `hi + lo`, row by row; its columns are the lines.
pub(super) struct Lines {
    rows: usize,
    columns: usize,
    /// The columns of a row filled up with zeros to whole lanes.
    hi: Vec<Lane<f64>>,
    /// Empty where all are 0.
    lo: Vec<Lane<f64>>,
}

impl Lines {
    /// `rows × columns` numbers, number k being entry (k / columns, k % columns).
    pub(super) fn of(rows: usize, columns: usize, number: impl Fn(usize) -> f64) -> Self {
        let mut lines = Self::zeros(rows, columns, false);
        let lanes = lines.lanes();
        for i in (0..rows).asking(2 * columns) {
            for j in 0..columns {
                lines.hi[i * lanes + j / ABREAST][j % ABREAST] = number(i * columns + j);
            }
        }
        lines
    }

    fn zeros(rows: usize, columns: usize, fine: bool) -> Self {
        let count = rows * columns.div_ceil(ABREAST);
        let lo = if fine { vec![[0.0; ABREAST]; count] } else { Vec::new() };
        Lines { rows, columns, hi: vec![[0.0; ABREAST]; count], lo }
    }

    /// Lanes of a row.
    fn lanes(&self) -> usize {
        self.columns.div_ceil(ABREAST)
    }

    /// The high parts, row by row.
    pub(super) fn entries(&self) -> impl Iterator<Item = f64> {
        let rows = self.hi.chunks_exact(self.lanes());
        rows.flat_map(|row| row.as_flattened()[..self.columns].iter().copied())
    }

    pub(super) fn transposed(&self) -> Self {
        let mut turned = Self::zeros(self.columns, self.rows, !self.lo.is_empty());
        let (from, to) = (ABREAST * self.lanes(), ABREAST * turned.lanes());
        for (source, target) in [(&self.hi, &mut turned.hi), (&self.lo, &mut turned.lo)] {
            let target = target.as_flattened_mut();
            for (i, row) in source.as_flattened().chunks_exact(from).enumerate() {
                for (j, x) in row[..self.columns].iter().enumerate() {
                    target[j * to + i] = *x;
                }
            }
        }
        turned
    }
}

/// The functions of one axis at its nodes, and the triangular factor of that matrix.
pub(super) struct AxisFit {
    /// Entries of a row, degree + 1.
    band: usize,
    functions: usize,
    /// The first function that is not 0 at each node.
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
    /// Checks that the nodes determine every function and factors the matrix; `fine` for residuals
    /// in double-double.
    pub(super) fn new(axis: usize, basis: &BSplineBasis, nodes: &[f64], fine: bool) -> Result<Self, Faults> {
        let (band, functions) = (basis.degree() + 1, basis.size());
        let support = |j: usize| [basis.knots()[j], basis.knots()[j + band]];
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
                None => return Err(check::no_node(axis, function, support(function))),
            }
        }
        let rank = |function: usize| check::undetermined(axis, function, support(function));
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

    /// Fits every line of `z`.
    pub(super) fn solve(&self, z: &Lines) -> Lines {
        let mut x = Lines::zeros(self.functions, z.columns, !self.lo.is_empty());
        let double = match &self.factor {
            Factor::Double(r) => r,
            Factor::Fine(r) => {
                self.correct_fine(r, z, &mut x);
                return x;
            }
        };
        if self.lo.is_empty() {
            // as it comes, and one correction
            for corrects in [false, true] {
                let mut step = self.gradient(z, corrects.then_some(&x));
                seminormal(double, self.band, z.lanes(), &mut step);
                for (x, s) in x.hi.as_flattened_mut().iter_mut().zip(step.as_flattened()) {
                    *x += s;
                }
            }
            return x;
        }
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            let mut step = self.gradient_fine(z, &x).0;
            seminormal(double, self.band, z.lanes(), &mut step);
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

    fn correct_fine(&self, r: &[Dd], z: &Lines, x: &mut Lines) {
        for _ in 0..CORRECTIONS {
            let (hi, lo) = self.gradient_fine(z, x);
            let joined = |(hi, lo): (Lane<f64>, Lane<f64>)| std::array::from_fn(|l| Dd::sum(hi[l], lo[l]));
            let mut step: Vec<Lane<Dd>> = hi.into_iter().zip(lo).map(joined).collect();
            seminormal(r, self.band, z.lanes(), &mut step);
            let step: Vec<Lane<f64>> = step.into_iter().map(|lane| lane.map(Dd::to_f64)).collect();
            add(x, &step);
            if largest(&step) <= 1e-20 * largest(&x.hi) {
                return;
            }
        }
    }

    /// `X x`, in double.
    pub(super) fn times(&self, x: &Lines) -> Lines {
        let lanes = x.lanes();
        let mut product = Lines::zeros(self.first.len(), x.columns, false);
        for (i, out) in product.hi.chunks_exact_mut(lanes).enumerate().asking(4 * lanes * self.band) {
            let row = &self.hi[i * self.band..][..self.band];
            let x = &x.hi[self.first[i] * lanes..];
            for (c, out) in out.iter_mut().enumerate() {
                for (j, a) in row.iter().enumerate() {
                    multiply_add(out, *a, &x[j * lanes + c]);
                }
            }
        }
        product
    }

    /// `Xᵀ(z − X x)` in double; without x, `Xᵀz`.
    fn gradient(&self, z: &Lines, x: Option<&Lines>) -> Vec<Lane<f64>> {
        let lanes = z.lanes();
        let mut gradient = vec![[0.0; ABREAST]; self.functions * lanes];
        for (i, first) in self.first.iter().enumerate().asking(10 * lanes * self.band) {
            let row = &self.hi[i * self.band..][..self.band];
            let target = &mut gradient[first * lanes..];
            for c in 0..lanes {
                let mut rest = z.hi[i * lanes + c];
                if let Some(x) = x {
                    for (j, a) in row.iter().enumerate() {
                        multiply_add(&mut rest, -a, &x.hi[(first + j) * lanes + c]);
                    }
                }
                for (j, a) in row.iter().enumerate() {
                    multiply_add(&mut target[j * lanes + c], *a, &rest);
                }
            }
        }
        gradient
    }

    /// The same to about twice the digits, as high and low parts.
    fn gradient_fine(&self, z: &Lines, x: &Lines) -> (Vec<Lane<f64>>, Vec<Lane<f64>>) {
        let lanes = z.lanes();
        let zeros = vec![[0.0; ABREAST]; self.functions * lanes];
        let (mut hi, mut lo) = (zeros.clone(), zeros);
        for (i, first) in self.first.iter().enumerate().asking(10 * lanes * self.band) {
            let entry = |j: usize| (self.hi[i * self.band + j], self.lo[i * self.band + j]);
            for c in 0..lanes {
                let mut rest = z.hi[i * lanes + c];
                let mut rest_lo = z.lo.get(i * lanes + c).copied().unwrap_or_default();
                for j in 0..self.band {
                    let (a, a_lo) = entry(j);
                    let at = (first + j) * lanes + c;
                    accumulate(&mut rest, &mut rest_lo, (-a, -a_lo), (&x.hi[at], &x.lo[at]));
                }
                for j in 0..self.band {
                    let at = (first + j) * lanes + c;
                    accumulate(&mut hi[at], &mut lo[at], entry(j), (&rest, &rest_lo));
                }
            }
        }
        (hi, lo)
    }
}

/// Adds `a x`.
#[inline(always)]
fn multiply_add<T: Real>(sum: &mut Lane<T>, a: T, x: &Lane<T>) {
    for l in 0..ABREAST {
        sum[l] = a.fma(x[l], sum[l]);
    }
}

/// Adds `a x` to the unevaluated sums.
#[inline(always)]
fn accumulate(hi: &mut Lane<f64>, lo: &mut Lane<f64>, a: (f64, f64), x: (&Lane<f64>, &Lane<f64>)) {
    for l in 0..ABREAST {
        let (product, error) = two_prod(a.0, x.0[l]);
        let (sum, rest) = two_sum(hi[l], product);
        hi[l] = sum;
        lo[l] += rest + fma(a.0, x.1[l], fma(a.1, x.0[l], error));
    }
}

fn add(x: &mut Lines, step: &[Lane<f64>]) {
    let parts = x.hi.as_flattened_mut().iter_mut().zip(x.lo.as_flattened_mut());
    for ((hi, lo), s) in parts.zip(step.as_flattened()) {
        let (sum, rest) = two_sum(*hi, *s);
        (*hi, *lo) = two_sum(sum, rest + *lo);
    }
}

fn largest(values: &[Lane<f64>]) -> f64 {
    values.as_flattened().iter().fold(0.0, |a, x| a.max(x.abs()))
}

/// The upper triangular factor, row j holding columns j to j + band − 1; or the function that no
/// node determines.
fn triangle<T: Real>(fit: &AxisFit, entry: impl Fn(usize) -> T, rank: f64) -> Result<Vec<T>, usize> {
    let (band, n) = (fit.band, fit.functions);
    let mut r = vec![T::zero(); n * band];
    let mut row = vec![T::zero(); band];
    for (i, first) in fit.first.iter().enumerate().asking(10 * band * band) {
        for (j, x) in row.iter_mut().enumerate() {
            *x = entry(i * band + j);
        }
        // rotated into rows first, first + 1, …, whose own entries reach no further than this
        // one's, since nodes ascend
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

/// Solves `RᵀR x = g` in place for all lines.
fn seminormal<T: Real>(r: &[T], band: usize, lanes: usize, g: &mut [Lane<T>]) {
    let n = r.len() / band;
    let scale = |lane: &mut Lane<T>, factor: T| lane.iter_mut().for_each(|x| *x *= factor);
    for j in (0..n).asking(10 * lanes * band) {
        let (done, rest) = g.split_at_mut((j + 1) * lanes);
        let (row, inverse) = (&r[j * band..][..band], T::one() / r[j * band]);
        let here = &mut done[j * lanes..];
        here.iter_mut().for_each(|lane| scale(lane, inverse));
        for (below, a) in rest.chunks_exact_mut(lanes).zip(&row[1..]) {
            below.iter_mut().zip(&*here).for_each(|(below, x)| multiply_add(below, -*a, x));
        }
    }
    for j in (0..n).rev().asking(10 * lanes * band) {
        let (done, rest) = g.split_at_mut((j + 1) * lanes);
        let (row, inverse) = (&r[j * band..][..band], T::one() / r[j * band]);
        let here = &mut done[j * lanes..];
        for (below, a) in rest.chunks_exact(lanes).zip(&row[1..]) {
            here.iter_mut().zip(below).for_each(|(x, below)| multiply_add(x, -*a, below));
        }
        here.iter_mut().for_each(|lane| scale(lane, inverse));
    }
}
