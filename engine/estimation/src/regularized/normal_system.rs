//! `(RᵀR + λLᵀL) c = Rᵀb`, solved to more digits than a double has: corrections come from a
//! decomposition in double precision, residuals are formed in twice the precision.

use nalgebra::DMatrix;

use super::{context::Context, penalty::Penalty};
use crate::factor::multiply_upper_vector;
use flankfit_numerics::Dd;

/// Rounds at most; two or three are usual.
const ROUNDS: usize = 8;
/// A correction this small against the solution is the last one.
const SETTLED: f64 = 1e-20;
/// Corrections have to become smaller by this factor.
const CONTRACTION: f64 = 1e-2;

/// The system, before λ is known.
pub(super) struct NormalSystem<'a> {
    form: Form<'a>,
    rhs: Vec<Dd>,
}

enum Form<'a> {
    /// `G_u ⊗ G_v` and the summands of the penalty.
    Product {
        gram: [DMatrix<Dd>; 2],
        penalty: Vec<[DMatrix<Dd>; 2]>,
    },
    Whole {
        r: &'a DMatrix<Dd>,
        l: DMatrix<Dd>,
    },
}

fn gram(factor: &DMatrix<Dd>) -> DMatrix<Dd> {
    let transposed = factor.transpose();
    DMatrix::from_fn(factor.ncols(), factor.ncols(), |i, j| inner(transposed.row(i).iter(), factor.column(j).iter()))
}

fn inner<'a>(x: impl Iterator<Item = &'a Dd>, y: impl Iterator<Item = &'a Dd>) -> Dd {
    x.zip(y).filter(|(x, _)| **x != Dd::ZERO).fold(Dd::ZERO, |sum, (&x, &y)| sum + x * y)
}

/// `A X B` for symmetric A and B, which may be banded; X row by row.
fn between(a: &DMatrix<Dd>, x: &[Dd], b: &DMatrix<Dd>) -> Vec<Dd> {
    let (p, q) = (a.nrows(), b.nrows());
    let mut half = vec![Dd::ZERO; p * q];
    for (to, from) in half.chunks_exact_mut(q).zip(x.chunks_exact(q)) {
        for (to, column) in to.iter_mut().zip(b.column_iter()) {
            *to = inner(column.iter(), from.iter());
        }
    }
    let mut out = vec![Dd::ZERO; p * q];
    for (to, column) in out.chunks_exact_mut(q).zip(a.column_iter()) {
        for (&share, from) in column.iter().zip(half.chunks_exact(q)).filter(|(share, _)| **share != Dd::ZERO) {
            to.iter_mut().zip(from).for_each(|(to, &x)| *to += share * x);
        }
    }
    out
}

fn transposed_times(matrix: &DMatrix<Dd>, x: &[Dd]) -> Vec<Dd> {
    matrix.column_iter().map(|column| inner(column.iter(), x.iter())).collect()
}

impl<'a> NormalSystem<'a> {
    pub(super) fn new(context: &Context<'a>, penalty: &Penalty) -> Self {
        let factor = context.linear.factor;
        let rhs = transposed_times(&factor.r, &factor.qty);
        let form = match (&factor.separable, penalty) {
            (Some(separable), Penalty::Product(blocks)) => Form::Product {
                gram: [gram(&separable.axes.u.r), gram(&separable.axes.v.r)],
                penalty: blocks.iter().map(|(weight, u, v)| [gram(u) * Dd::from(*weight), gram(v)]).collect(),
            },
            _ => Form::Whole { r: &factor.r, l: penalty.stacked(&context.linear.design.terms) },
        };
        NormalSystem { form, rhs }
    }

    /// Remainder of the right-hand side at `c`.
    fn residual(&self, c: &[Dd], lambda: f64) -> Vec<Dd> {
        let mut left = self.rhs.clone();
        let mut subtract = |x: Vec<Dd>, factor: f64| left.iter_mut().zip(x).for_each(|(to, x)| *to -= x * factor);
        match &self.form {
            Form::Product { gram: [u, v], penalty } => {
                subtract(between(u, c, v), 1.0);
                penalty.iter().for_each(|[u, v]| subtract(between(u, c, v), lambda));
            }
            Form::Whole { r, l } => {
                let mut image = c.to_vec();
                multiply_upper_vector(r, &mut image);
                subtract(transposed_times(r, &image), 1.0);
                let mut rough = vec![Dd::ZERO; l.nrows()];
                for (column, &c) in l.column_iter().zip(c) {
                    rough
                        .iter_mut()
                        .zip(column.iter())
                        .filter(|(_, l)| **l != Dd::ZERO)
                        .for_each(|(to, &l)| *to += l * c);
                }
                subtract(transposed_times(l, &rough), lambda);
            }
        }
        left
    }

    /// c, found by corrections `inverse` of the residual; `None` where they do not become small.
    pub(super) fn solve(&self, lambda: f64, inverse: impl Fn(&[f64]) -> Vec<f64>) -> Option<Vec<Dd>> {
        let size = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let mut c = vec![Dd::ZERO; self.rhs.len()];
        let mut left = self.rhs.clone();
        let mut before = f64::INFINITY;
        for _ in 0..ROUNDS {
            let step = inverse(&left.iter().map(|x| x.hi).collect::<Vec<_>>());
            c.iter_mut().zip(&step).for_each(|(c, step)| *c += *step);
            let moved = size(&mut step.iter().copied());
            if moved <= SETTLED * size(&mut c.iter().map(|c| c.hi)) {
                return Some(c);
            }
            if !(moved <= CONTRACTION * before) {
                return None;
            }
            before = moved;
            left = self.residual(&c, lambda);
        }
        None
    }
}
