//! Rows of the orthogonal factor, `√w R⁻ᵀ` times those of the working matrix: what each node has in
//! Q's coordinates.

use nalgebra::DMatrix;

use crate::{
    data::Sample,
    design::{Design, Row},
    factor::scaled_condition,
};
use flankfit_numerics::{Dd, Real, dot, triangular};

/// Up to so many products, and from this condition of R on, rows are solved for in double-double.
const CHEAP: usize = 200_000;
const ILL_CONDITIONED: f64 = 1e4;
/// Remainder next to their leverage below which rows are solved again in double-double.
const CLOSE: f64 = 1e-3;

/// Rows of Q.
pub(crate) struct Rows<'a> {
    design: &'a Design,
    sample: &'a Sample<'a>,
    exact: &'a DMatrix<Dd>,
    /// R in doubles, where they do.
    double: Option<DMatrix<f64>>,
}

impl<'a> Rows<'a> {
    /// Rows of the nodes of `sample`, `r` being R.
    pub(crate) fn new(design: &'a Design, sample: &'a Sample<'a>, r: &'a DMatrix<Dd>) -> Self {
        let n = design.size();
        let cheap = sample.count().saturating_mul(n * n) <= CHEAP;
        let sound = || scaled_condition(r).is_some_and(|(_, condition)| condition < ILL_CONDITIONED);
        let double = (!cheap && sound()).then(|| r.map(|x| x.to_f64()));
        Rows { design, sample, exact: r, double }
    }

    /// The row of counted node `k` and 1 less its squared length.
    pub(crate) fn at(&self, k: usize) -> (Vec<f64>, f64) {
        if let Some(r) = &self.double {
            let q = self.row(k, r);
            let left = 1.0 - dot(&q, &q);
            if left > CLOSE {
                return (q, left);
            }
        }
        let q = self.row(k, self.exact);
        let left = q.iter().fold(Dd::ONE, |left, &x| left - x * x).to_f64();
        (q.iter().map(|x| x.to_f64()).collect(), left.max(0.0))
    }

    fn row<T: Real>(&self, k: usize, r: &DMatrix<T>) -> Vec<T> {
        let mut row = Row::<T>::new(self.design);
        row.at(self.design, self.sample, k);
        let root = T::of_dd(Dd::from(self.sample.w(k)).sqrt());
        let mut q = vec![T::of(0.0); self.design.size()];
        for (&j, &x) in row.index.iter().zip(&row.values) {
            q[j] = x * root;
        }
        triangular::solve_upper_transposed(r, &mut q);
        q
    }
}
