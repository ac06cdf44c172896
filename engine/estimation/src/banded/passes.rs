//! Passes over the nodes: the Fisher information matrix `F = XᵀΩX` with `XᵀΩz`, and residuals with
//! their projections.
//!
//! One row of cells (a span of u) is a task; what tasks found is added in their order.

use rayon::prelude::*;

use super::{cells::Cells, pieces::Pieces};
use flankfit_numerics::{
    Dd, Real,
    band_cholesky::SymmetricBand,
    cancel::{self, Asking},
    with_fma,
};

/// From how many nodes on tasks are shared among threads.
const PARALLEL: usize = 65_536;
/// Rows of cells whose sums are kept at a time.
const ROWS: usize = 16;

/// The axes in one arithmetic.
pub(crate) struct Axes<T> {
    pub u: Pieces<T>,
    pub v: Pieces<T>,
}

impl<T: Real> Axes<T> {
    /// Coefficients.
    pub(crate) fn size(&self) -> usize {
        self.u.size * self.v.size
    }

    /// Half-bandwidth of F.
    pub(crate) fn width(&self) -> usize {
        self.u.degree * self.v.size + self.v.degree
    }

    /// Functions that are not 0 on a cell.
    fn functions(&self) -> usize {
        (self.u.degree + 1) * (self.v.degree + 1)
    }

    /// The coefficient of function `a` of a cell.
    fn coefficient(&self, (i, j): (usize, usize), a: usize) -> usize {
        let across = self.v.degree + 1;
        (self.u.first(i) + a / across) * self.v.size + self.v.first(j) + a % across
    }

    /// Values of all functions of the cell at a node.
    #[inline(always)]
    fn row(&self, (i, j): (usize, usize), u: f64, v: f64, room: &mut Room<T>) {
        self.u.values(i, u, &mut room.u);
        self.v.values(j, v, &mut room.v);
        let across = room.v.len();
        for (row, &along) in room.values.chunks_exact_mut(across).zip(&room.u) {
            for (value, &b) in row.iter_mut().zip(&room.v) {
                *value = along * b;
            }
        }
    }
}

struct Room<T> {
    u: Vec<T>,
    v: Vec<T>,
    values: Vec<T>,
}

impl<T: Real> Room<T> {
    fn new(axes: &Axes<T>) -> Self {
        let zeros = |n: usize| vec![T::of(0.0); n];
        Room { u: zeros(axes.u.degree + 1), v: zeros(axes.v.degree + 1), values: zeros(axes.functions()) }
    }
}

/// `F`, and `XᵀΩz` of each coordinate.
pub(crate) struct Normal<T> {
    pub fisher: SymmetricBand<T>,
    pub rhs: Vec<Vec<T>>,
}

/// Runs `work` over every row of cells and folds the results in order.
fn over_rows<P: Send>(cells: &Cells, work: impl Fn(usize) -> P + Sync, mut fold: impl FnMut(usize, P)) {
    let rows = cells.spans[0];
    let handle = cancel::current();
    let work = |i| cancel::carry(handle.as_ref(), || work(i));
    for start in (0..rows).step_by(ROWS) {
        cancel::checkpoint();
        let batch = start..(start + ROWS).min(rows);
        if cells.count() < PARALLEL {
            batch.for_each(|i| fold(i, work(i)));
        } else {
            let parts: Vec<P> = batch.clone().into_par_iter().map(work).collect();
            batch.zip(parts).for_each(|(i, part)| fold(i, part));
        }
    }
}

with_fma! {
    /// Adds the nodes of a cell to its share of F, row by row, and to those of the right-hand
    /// sides.
    fn add_cell<T: Real>(
        axes: &Axes<T>,
        cells: &Cells,
        at: (usize, usize),
        room: &mut Room<T>,
        gram: &mut [T],
        shares: &mut [T],
    ) {
        let (k, (i, j)) = (axes.functions(), at);
        let cell = i * cells.spans[1] + j;
        for node in (cells.start[cell]..cells.start[cell + 1]).asking(4 * k * k) {
            axes.row((i, j), cells.u[node], cells.v[node], room);
            let weight = cells.w(node);
            for (row, &value) in gram.chunks_exact_mut(k).zip(&room.values) {
                let weighted = value.mul_f64(weight);
                for (sum, &other) in row.iter_mut().zip(&room.values) {
                    *sum = weighted.mul_add(other, *sum);
                }
            }
            for (share, heights) in shares.chunks_exact_mut(k).zip(&cells.heights) {
                let height = weight * heights[node];
                for (sum, &value) in share.iter_mut().zip(&room.values) {
                    *sum += value.mul_f64(height);
                }
            }
        }
    }
}

/// Sums F and the right-hand sides.
pub(crate) fn normal<T: Real>(axes: &Axes<T>, cells: &Cells) -> Normal<T> {
    let (n, k, across) = (axes.size(), axes.functions(), cells.spans[1]);
    let coordinates = cells.heights.len();
    let mut total =
        Normal { fisher: SymmetricBand::zeros(n, axes.width()), rhs: vec![vec![T::of(0.0); n]; coordinates] };
    let stride = k * k + k * coordinates;
    over_rows(
        cells,
        |i| {
            let mut sums = vec![T::of(0.0); across * stride];
            let mut room = Room::new(axes);
            for (j, sums) in sums.chunks_exact_mut(stride).enumerate().asking(stride) {
                let (gram, shares) = sums.split_at_mut(k * k);
                add_cell(axes, cells, (i, j), &mut room, gram, shares);
            }
            sums
        },
        |i, sums| {
            for (j, sums) in sums.chunks_exact(stride).enumerate().asking(10 * stride) {
                let (gram, shares) = sums.split_at(k * k);
                if cells.start[i * across + j] == cells.start[i * across + j + 1] {
                    continue;
                }
                for a in 0..k {
                    let row = axes.coefficient((i, j), a);
                    for b in 0..=a {
                        total.fisher.add(row, axes.coefficient((i, j), b), gram[a * k + b]);
                    }
                    for (rhs, share) in total.rhs.iter_mut().zip(shares.chunks_exact(k)) {
                        rhs[row] += share[a];
                    }
                }
            }
        },
    );
    total
}

/// Sums of a pass over the residuals, by coordinate.
pub(crate) struct Residuals {
    /// `XᵀΩr`.
    pub projected: Vec<Vec<Dd>>,
    /// `Σ w r²`.
    pub rss: Vec<Dd>,
    pub max_abs: Vec<f64>,
    /// In the order of the cells, when kept.
    pub values: Vec<Vec<f64>>,
}

/// Residuals of the coefficients `c` (by coordinate), formed in `T`.
pub(crate) fn residuals<T: Real>(axes: &Axes<T>, cells: &Cells, c: &[Vec<Dd>], keep: bool) -> Residuals {
    let (n, k, across) = (axes.size(), axes.functions(), cells.spans[1]);
    let c: Vec<Vec<T>> = c.iter().map(|c| c.iter().map(|&x| T::of_dd(x)).collect()).collect();
    let coordinates = c.len();
    let mut total = Residuals {
        projected: vec![vec![Dd::ZERO; n]; coordinates],
        rss: vec![Dd::ZERO; coordinates],
        max_abs: vec![0.0; coordinates],
        values: vec![Vec::with_capacity(if keep { cells.count() } else { 0 }); coordinates],
    };
    over_rows(
        cells,
        |i| {
            let mut room = Room::new(axes);
            let mut shares = vec![T::of(0.0); across * k * coordinates];
            let mut part = (vec![Dd::ZERO; coordinates], vec![0.0f64; coordinates], vec![Vec::new(); coordinates]);
            let mut local = vec![T::of(0.0); k];
            for d in 0..coordinates {
                for j in (0..across).asking(20 * k) {
                    let cell = i * across + j;
                    (0..k).for_each(|a| local[a] = c[d][axes.coefficient((i, j), a)]);
                    let share = &mut shares[(d * across + j) * k..][..k];
                    let mut rss = T::of(0.0);
                    for node in (cells.start[cell]..cells.start[cell + 1]).asking(20 * k) {
                        axes.row((i, j), cells.u[node], cells.v[node], &mut room);
                        let mut residual = T::of(cells.heights[d][node]);
                        for (&value, &c) in room.values.iter().zip(&local) {
                            residual = (-value).fma(c, residual);
                        }
                        let weighted = residual.mul_f64(cells.w(node));
                        rss = weighted.fma(residual, rss);
                        for (sum, &value) in share.iter_mut().zip(&room.values) {
                            *sum = value.fma(weighted, *sum);
                        }
                        let plain = residual.to_f64();
                        part.1[d] = part.1[d].max(plain.abs());
                        if keep {
                            part.2[d].push(plain);
                        }
                    }
                    part.0[d] += rss.to_dd();
                }
            }
            (shares, part)
        },
        |i, (shares, (rss, max_abs, values))| {
            for d in 0..coordinates {
                for j in (0..across).asking(10 * k) {
                    for a in 0..k {
                        total.projected[d][axes.coefficient((i, j), a)] += shares[(d * across + j) * k + a].to_dd();
                    }
                }
                total.rss[d] += rss[d];
                total.max_abs[d] = total.max_abs[d].max(max_abs[d]);
                total.values[d].extend_from_slice(&values[d]);
            }
        },
    );
    total
}
