//! The pair (W, L) of [`super::pair`] decomposed in double precision, where that leaves the figures
//! their digits: eigenvectors of `R⁻ᵀ LᵀL R⁻¹`, block by block.
//!
//! Eigenvalues of a symmetric matrix have errors of a few roundings ε of the largest one, ω. This
//! is checked before any result is used:
//! * δᵢ is taken as the Rayleigh quotient `‖Lzᵢ‖²`, whose relative error is of the second order in
//!   `ε ω/δᵢ`; a direction is without penalty where nothing but rounding is left, and there may be
//!   none in between;
//! * the filter `(I + λS)⁻¹` errs by `ε λω`, and since its directions do not depend on λ by no more
//!   than `ε ω` over the least δ that is not 0;
//! * what the heights have along a direction errs by ε of their length, which has to be far below
//!   their noise;
//! * Z errs by ε times its condition.
//!
//! Where one of them is too large there is no answer here, and the decomposition in twice the
//! precision takes over. The estimate itself does not depend on any of this: it is corrected until
//! it solves its normal equations ([`super::normal_system`]).

use nalgebra::DMatrix;

use super::{
    context::Context,
    oblique::{Block, Double, Oblique},
    pair::product,
    parity::{Class, Parity},
    penalty::{Penalty, triangular},
};
use crate::{factor::Separable, spec::Scaling};
use flankfit_numerics::{Dd, cancel, matvec, symmetric, triangular as solve};

/// Fewer coefficients cost little in twice the precision.
const LEAST: usize = 25;
/// Units of rounding of the largest eigenvalue below which one counts as free of the penalty.
const QUIET: f64 = 64.0 * f64::EPSILON;
/// No eigenvalue may lie between these roundings and this many times as much.
const GAP: f64 = 1e4;
/// The same for Rayleigh quotients, whose error is of the second order.
const NO_PENALTY: f64 = 1e-22;
/// Noise against the length of the heights.
const LEAST_NOISE: f64 = 1e-7;
/// Condition of Z.
const MOST_CONDITION: f64 = 1e6;
/// Error of filter factors.
const FILTER: f64 = 1e-8;

/// One axis in the combinations of a class; of nodes that do not separate the whole is the first
/// axis, and the second one a single function.
struct Side {
    /// `E R⁻¹`, from orthonormal coordinates to working coefficients.
    working: DMatrix<f64>,
    /// The same to scaled coefficients, in the combinations again, and back.
    scaled: DMatrix<f64>,
    unscaled: DMatrix<f64>,
    /// To Q's coordinates.
    images: DMatrix<f64>,
    /// `D E R⁻¹` of every summand of the penalty, with `FᵀF`.
    rough: Vec<[DMatrix<f64>; 2]>,
}

/// Matrices of one axis.
struct Axis<'a> {
    r: &'a DMatrix<Dd>,
    change: &'a DMatrix<Dd>,
    scale: Vec<Dd>,
    rough: Vec<&'a DMatrix<Dd>>,
}

impl<'a> Axis<'a> {
    fn new(r: &'a DMatrix<Dd>, change: &'a DMatrix<Dd>, scaling: Scaling, rough: Vec<&'a DMatrix<Dd>>) -> Self {
        let columns = solve::multiply_upper(r, change);
        let length = |j: usize| match scaling {
            Scaling::UnitLength => columns.column(j).iter().fold(Dd::ZERO, |sum, &x| sum + x * x).sqrt(),
            _ => Dd::ONE,
        };
        Axis { r, change, scale: (0..r.ncols()).map(length).collect(), rough }
    }

    /// Everything that has to be symmetric for the axis to be.
    fn forms(&self) -> Vec<DMatrix<f64>> {
        let gram = |factor: &DMatrix<Dd>| product(&factor.transpose(), factor).map(|x| x.to_f64());
        let scale = self.scale.iter().map(|s| s.to_f64());
        let scale = DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(self.scale.len(), scale));
        let own = [gram(self.r), self.change.map(|x| x.to_f64()), scale];
        own.into_iter().chain(self.rough.iter().map(|d| gram(d))).collect()
    }

    fn side(&self, class: &Class) -> Side {
        let e = class.matrix(self.r.ncols());
        let r = if class.is_identity() { self.r.clone() } else { triangular(product(self.r, &e)) };
        let working = product(&e, &solve::inverse_upper(&r));
        let mut caller = working.clone();
        for column in caller.as_mut_slice().chunks_exact_mut(self.r.ncols()) {
            solve::solve_upper(self.change, column);
            column.iter_mut().zip(&self.scale).for_each(|(x, &s)| *x *= s);
        }
        let mut unscaled = self.change.clone();
        unscaled.column_iter_mut().zip(&self.scale).for_each(|(mut column, &s)| {
            column.iter_mut().for_each(|x| *x /= s);
        });
        let back = product(&r, &product(&e.transpose(), &product(&unscaled, &e)));
        let plain = |matrix: DMatrix<Dd>| matrix.map(|x| x.to_f64());
        let rough = self.rough.iter().map(|d| {
            let f = product(d, &working);
            let f = if f.nrows() > f.ncols() { triangular(f) } else { f };
            let gram = product(&f.transpose(), &f);
            [plain(f), plain(gram)]
        });
        Side {
            rough: rough.collect(),
            scaled: plain(product(&e.transpose(), &caller)),
            unscaled: plain(back),
            images: plain(product(self.r, &working)),
            working: plain(working),
        }
    }
}

/// The single function 1.
fn one() -> Side {
    let one = || DMatrix::from_element(1, 1, 1.0);
    Side { working: one(), scaled: one(), unscaled: one(), images: one(), rough: vec![[one(), one()]] }
}

/// Nodes that do not separate.
fn whole(context: &Context, penalty: &Penalty) -> Side {
    let factor = context.linear.factor;
    let plain = |matrix: &DMatrix<Dd>| matrix.map(|x| x.to_f64());
    let working = solve::inverse_upper(&plain(&factor.r));
    let change = plain(&factor.change);
    let mut scaled = working.clone();
    for column in scaled.as_mut_slice().chunks_exact_mut(factor.size()) {
        solve::solve_upper(&change, column);
        column.iter_mut().zip(&context.columns.scale).for_each(|(x, s)| *x *= s.to_f64());
    }
    cancel::checkpoint();
    let f = matvec::product(&plain(&penalty.stacked(&context.linear.design.terms)), &working);
    let gram = matvec::product(&f.transpose(), &f);
    Side {
        working,
        scaled,
        unscaled: plain(&context.columns.matrix),
        images: DMatrix::identity(factor.size(), factor.size()),
        rough: vec![[f, gram]],
    }
}

/// `(A ⊗ B) X`.
fn kron_times(a: &DMatrix<f64>, b: &DMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    if b.shape() == (1, 1) {
        return matvec::product(a, x) * b[(0, 0)];
    }
    let (p, q, count) = (a.ncols(), b.ncols(), x.ncols());
    let half = b * nalgebra::DMatrixView::from_slice(x.as_slice(), q, p * count);
    let rows = b.nrows();
    let mut out = DMatrix::zeros(a.nrows() * rows, count);
    let columns = half.as_slice().chunks_exact(rows * p);
    for (to, from) in out.as_mut_slice().chunks_exact_mut(a.nrows() * rows).zip(columns) {
        for (from, shares) in from.chunks_exact(rows).zip(a.column_iter()) {
            for (to, &share) in to.chunks_exact_mut(rows).zip(shares.iter()).filter(|(_, share)| **share != 0.0) {
                to.iter_mut().zip(from).for_each(|(to, x)| *to += share * x);
            }
        }
    }
    out
}

/// Eigenvectors of one block, in orthonormal coordinates, and which directions they are.
struct Vectors {
    sides: [usize; 2],
    vectors: DMatrix<f64>,
    members: Vec<usize>,
}

/// The decomposition.
pub(super) struct DoublePair {
    pub oblique: Oblique,
    /// uᵢ in Q's coordinates.
    pub images: DMatrix<f64>,
    sides: [Vec<Side>; 2],
    blocks: Vec<Vectors>,
    /// The largest eigenvalue.
    largest: f64,
}

/// Eigenvectors of one block with their eigenvalues and Rayleigh quotients.
struct Decomposed {
    values: Vec<f64>,
    delta: Vec<f64>,
    vectors: DMatrix<f64>,
}

fn decomposed([u, v]: [&Side; 2], weights: &[f64]) -> Option<Decomposed> {
    cancel::checkpoint();
    let mut whole = DMatrix::zeros(0, 0);
    for (k, ((u, v), &weight)) in u.rough.iter().zip(&v.rough).zip(weights).enumerate() {
        let summand = if v[1].len() == 1 { &u[1] * (weight * v[1][0]) } else { (&u[1] * weight).kronecker(&v[1]) };
        whole = if k == 0 { summand } else { whole + summand };
    }
    let symmetric::Eigen { values, vectors } = symmetric::eigen(whole)?;
    let mut delta = vec![0.0; values.len()];
    for ((u, v), &weight) in u.rough.iter().zip(&v.rough).zip(weights) {
        let image = kron_times(&u[0], &v[0], &vectors);
        delta.iter_mut().zip(image.column_iter()).for_each(|(sum, x)| *sum += weight * x.norm_squared());
    }
    Some(Decomposed { values, delta, vectors })
}

/// True if the noise is far enough above rounding.
fn is_noisy(context: &Context) -> bool {
    let length = context.linear.factor.qty.iter().map(|b| b.to_f64().powi(2)).sum::<f64>();
    let left = context.least_squares.rss / context.degrees_of_freedom as f64;
    let least = LEAST_NOISE * LEAST_NOISE * length;
    context.degrees_of_freedom > 0 && context.variance.is_some_and(|variance| variance.min(left) > least)
}

impl DoublePair {
    /// `None` where double precision would not leave the digits.
    pub(super) fn new(context: &Context, penalty: &Penalty) -> Option<Self> {
        let (factor, scaling) = (context.linear.factor, context.spec.scaling);
        let n = factor.size();
        #[cfg(test)]
        if tests::WITHOUT.get() {
            return None;
        }
        let plain = n >= LEAST && context.columns.constant.is_none() && context.spectrum.full_rank();
        if !plain || !is_noisy(context) {
            return None;
        }
        let (parity, sides, weights) = match (&factor.separable, penalty) {
            (Some(Separable { axes, .. }), Penalty::Product(blocks)) => {
                let [u, v] = [
                    Axis::new(&axes.u.r, &axes.u.change, scaling, blocks.iter().map(|block| &block.1).collect()),
                    Axis::new(&axes.v.r, &axes.v.change, scaling, blocks.iter().map(|block| &block.2).collect()),
                ];
                let parity = Parity::new([&u.forms(), &v.forms()]);
                let of =
                    |axis: &Axis, k: usize| parity.axes[k].iter().map(|class| axis.side(class)).collect::<Vec<_>>();
                let sides = [of(&u, 0), of(&v, 1)];
                (parity, sides, blocks.iter().map(|block| block.0).collect())
            }
            _ => (Parity::none([n, 1]), [vec![whole(context, penalty)], vec![one()]], vec![1.0]),
        };
        let condition =
            |sides: &[Side]| sides.iter().map(|side| side.scaled.norm() * side.unscaled.norm()).fold(0.0f64, f64::max);
        if !(condition(&sides[0]) * condition(&sides[1]) <= MOST_CONDITION) {
            return None;
        }
        let found = parity.blocks().map(|[a, c]| decomposed([&sides[0][a], &sides[1][c]], &weights));
        let found: Vec<Decomposed> = found.collect::<Option<_>>()?;
        Self::assembled(context, parity, sides, found)
    }

    fn assembled(context: &Context, parity: Parity, sides: [Vec<Side>; 2], found: Vec<Decomposed>) -> Option<Self> {
        let n = context.linear.factor.size();
        let largest = found.iter().flat_map(|block| &block.values).copied().fold(0.0, f64::max);
        let mut order = Vec::with_capacity(n);
        for (b, block) in found.iter().enumerate() {
            for (i, (&value, &delta)) in block.values.iter().zip(&block.delta).enumerate() {
                let free = value <= QUIET * largest;
                let clear = if free { delta <= NO_PENALTY * largest } else { value >= GAP * QUIET * largest };
                if !clear {
                    return None;
                }
                order.push((if free { 0.0 } else { delta }, b, i));
            }
        }
        order.sort_by(|x, y| y.0.total_cmp(&x.0));
        let mut members: Vec<Vec<usize>> = found.iter().map(|block| vec![0; block.values.len()]).collect();
        order.iter().enumerate().for_each(|(i, &(_, b, k))| members[b][k] = i);
        let delta = order.iter().map(|&(delta, _, _)| delta).collect();
        let heights: Vec<f64> = context.linear.factor.qty.iter().map(|b| b.to_f64()).collect();
        let (mut images, mut a) = (DMatrix::zeros(n, n), vec![0.0; n]);
        let (mut blocks, mut directions) = (Vec::new(), Vec::new());
        for ((at, Decomposed { vectors, .. }), members) in parity.blocks().zip(found).zip(members) {
            let [u, v] = [&sides[0][at[0]], &sides[1][at[1]]];
            let own = kron_times(&u.images, &v.images, &vectors);
            for (&i, image) in members.iter().zip(own.column_iter()) {
                images.column_mut(i).copy_from(&image);
                a[i] = image.iter().zip(&heights).map(|(u, b)| u * b).sum();
            }
            let z = kron_times(&u.scaled, &v.scaled, &vectors);
            let dual = kron_times(&u.unscaled.transpose(), &v.unscaled.transpose(), &vectors);
            directions.push(Block { members: members.clone(), z, dual });
            blocks.push(Vectors { sides: at, vectors, members });
        }
        let double = Double::new(parity, directions);
        let oblique = Oblique::of_blocks(double, delta, a, context.variance);
        Some(DoublePair { oblique, images, sides, blocks, largest })
    }

    /// True if the filter at `lambda` keeps its digits.
    pub(super) fn trusts(&self, lambda: f64) -> bool {
        let least = self.oblique.delta.iter().copied().filter(|delta| *delta > 0.0).fold(f64::INFINITY, f64::min);
        8.0 * f64::EPSILON * self.largest * lambda.min(1.0 / least) <= FILTER
    }

    /// `(RᵀR + λLᵀL)⁻¹ g`, in working coefficients.
    pub(super) fn inverse(&self, lambda: f64, g: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; g.len()];
        for Vectors { sides: [a, c], vectors, members } in &self.blocks {
            let (u, v) = (&self.sides[0][*a].working, &self.sides[1][*c].working);
            let g = DMatrix::from_column_slice(g.len(), 1, g);
            let mut along = vectors.tr_mul(&kron_times(&u.transpose(), &v.transpose(), &g));
            along.iter_mut().zip(members).for_each(|(x, &i)| *x *= self.oblique.factor(i, lambda));
            let back = kron_times(u, v, &(vectors * along));
            out.iter_mut().zip(back.iter()).for_each(|(to, x)| *to += x);
        }
        out
    }
}

#[cfg(test)]
#[path = "double_pair_tests.rs"]
mod tests;
