//! Residual sums of squares of subsets of the largest model's columns.
//!
//! With Q, b and residuals of the largest model, and P the projector on the span of some of its
//! columns in Q's coordinates: `RSS = RSS₀ + ‖(I − P)b‖²`, a node of row q has the residual `r₀ +
//! qᵀ(I − P)b` and `1 − h = (1 − h₀) + ‖(I − P)q‖²`. Every part is positive: nothing cancels.
//!
//! With m nodes and n coefficients, `−2 ln L = m (ln(2π RSS/m) + 1) − Σ ln w`; σ² counts as a
//! parameter: k = n + 1.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::subspace::{Subspace, Triangle};
use crate::{
    data::{Heights, Nodes, Partition, Sample},
    design::Design,
    factor::Factor,
    problem::{Evidence, LinearProblem, Rows},
    result::Candidate,
    selection::{Blockwise, g_prior, left_out, moved_by},
};
use flankfit_numerics::cancel::Asking;

/// Residuals this small against the heights are rounding.
const ROUNDING: f64 = 1e-13;
/// 1 − h below this is 0 to rounding.
const UNDETERMINED: f64 = 1e-10;

/// The nodes in the coordinates of the largest model.
pub(super) struct Problem {
    pub triangle: Triangle,
    /// R in doubles, and Qᵀ√Ωz.
    pub r: DMatrix<f64>,
    pub b: DVector<f64>,
    /// Number of the constant column, where there is one.
    pub constant: Option<usize>,
    pub blocks: Option<Blockwise>,
    rows: DMatrix<f64>,
    left: Vec<f64>,
    /// √w times the residuals.
    residuals: Vec<f64>,
    rss: f64,
    /// Σw and Σ ln w.
    pub weight: f64,
    logarithms: f64,
    /// Residual sum of squares of the constant alone, or of no term at all.
    whole: f64,
    /// A residual sum of squares up to which is rounding.
    rounding: f64,
}

impl Problem {
    /// `None` where columns of the largest model depend on each other.
    pub(super) fn new(
        nodes: &Nodes,
        sample: &Sample,
        design: &Design,
        factor: &Factor,
        folds: Option<&Partition>,
    ) -> Option<Self> {
        let triangle = Triangle::new(factor)?;
        let (m, n) = (sample.count(), design.size());
        let heights = Heights::new(sample).about_zero;
        let linear = LinearProblem { design, factor, heights, evidence: Evidence::Posted { sample, nodes } };
        let found = linear.of_working(factor.working.as_ref()?, true);
        let values = found.values?;
        let residuals: Vec<f64> = (0..m).map(|k| sample.w(k).sqrt() * values[k]).collect();
        let all = Rows::new(design, sample, &factor.r);
        let mut rows = DMatrix::zeros(n, m);
        let mut left = Vec::with_capacity(m);
        let mut blocks = folds.map(|folds| Blockwise::empty(folds.count, n));
        for k in (0..m).asking(4 * n * n) {
            let (q, rest) = all.at(k);
            if let (Some(blocks), Some(folds)) = (&mut blocks, folds) {
                blocks.add(folds.block[k], &q, residuals[k], sample.w(k));
            }
            rows.column_mut(k).copy_from_slice(&q);
            left.push(rest);
        }
        let mut problem = Problem {
            triangle,
            r: factor.r.map(|x| x.to_f64()),
            b: DVector::from_iterator(n, factor.qty.iter().map(|x| x.to_f64())),
            constant: design.constant,
            blocks,
            rows,
            left,
            residuals,
            rss: found.rss,
            weight: (0..m).map(|k| sample.w(k)).sum(),
            logarithms: (0..m).map(|k| sample.w(k).ln()).sum(),
            whole: found.rss,
            rounding: ROUNDING * ROUNDING * heights,
        };
        problem.whole += match problem.constant {
            Some(constant) => problem.orthogonal_part(&problem.triangle.subspace(&[constant])).norm_squared(),
            None => problem.b.norm_squared(),
        };
        Some(problem)
    }

    /// Component of the heights orthogonal to a subspace.
    fn orthogonal_part(&self, subspace: &Subspace) -> DVector<f64> {
        &self.b - &subspace.q * subspace.q.tr_mul(&self.b)
    }

    /// The figures of the model whose columns span `subspace`.
    pub(super) fn figures(&self, subspace: &Subspace) -> Candidate {
        let beyond = self.orthogonal_part(subspace);
        let (m, n, rss) = (self.left.len() as f64, subspace.q.ncols() as f64, self.rss + beyond.norm_squared());
        let k = n + 1.0;
        let existing = |x: f64| Some(x).filter(|x| x.is_finite());
        // of rounding there is no likelihood: it would be the greater the more terms there are
        let noisy = m > n && rss > self.rounding;
        let deviance = existing(m * ((TAU * rss / m).ln() + 1.0) - self.logarithms).filter(|_| noisy);
        let aic = deviance.map(|deviance| deviance + 2.0 * k);
        let flat = if self.constant.is_some() { 1.0 } else { 0.0 };
        Candidate {
            degree: None,
            terms: None,
            coefficients: subspace.q.ncols(),
            lambda: None,
            aic,
            aicc: aic.filter(|_| m > k + 1.0).map(|aic| aic + 2.0 * k * (k + 1.0) / (m - k - 1.0)),
            bic: deviance.map(|deviance| deviance + k * m.ln()),
            press: self.press(subspace, &beyond).and_then(existing),
            blocked_cv: self.blocked(subspace, &beyond).and_then(existing),
            reml: existing(g_prior(self.whole, rss, n - flat, m - flat, None)).filter(|_| noisy),
            rss,
            sigma: (m > n).then(|| (rss / (m - n)).sqrt()),
        }
    }

    /// True if a model with fewer terms than there are nodes leaves nothing but rounding.
    pub(super) fn is_exact(&self, candidate: &Candidate) -> bool {
        candidate.coefficients < self.left.len() && candidate.rss <= self.rounding
    }

    fn press(&self, subspace: &Subspace, beyond: &DVector<f64>) -> Option<f64> {
        let size = subspace.q.len();
        let each = self.rows.column_iter().zip(&self.left).zip(&self.residuals).asking(4 * size);
        each.map(|((row, left), residual)| {
            let rest = row - &subspace.q * subspace.q.tr_mul(&row);
            let left = left + rest.norm_squared();
            Some((residual + row.dot(beyond)) / left).filter(|_| left > UNDETERMINED).map(|r| r * r)
        })
        .sum()
    }

    fn blocked(&self, subspace: &Subspace, beyond: &DVector<f64>) -> Option<f64> {
        let Blockwise { blocks } = self.blocks.as_ref()?;
        let each = blocks.iter().asking(4 * self.b.len() * subspace.q.len());
        each.map(|block| {
            let (cross, rss) = moved_by(block, beyond);
            left_out(&(subspace.q.tr_mul(&block.inner) * &subspace.q), subspace.q.tr_mul(&cross), rss)
        })
        .sum()
    }
}
