//! The restricted likelihood of a process along lines, and generalised least squares for it.
//!
//! All of it happens in the coordinates of plain least squares: orthonormal rows Q and what least
//! squares left, b. For correlations V, up to a constant,
//!
//! ```text
//! ln L = −½ ln det V − ½ ln det QᵀV⁻¹Q − ½(m − n) ln RSS
//! ```
//!
//! (Patterson and Thompson, Biometrika 58, 1971), or −RSS/2σ² in place of the last term where σ is
//! known.

use nalgebra::DMatrix;

use super::{
    lines::Lines,
    process::{Process, Whitening},
};
use flankfit_numerics::{cancel::Asking, triangular};

/// Orthonormal rows and residuals of least squares, in the order of the lines.
pub(crate) struct PlainRows {
    width: usize,
    rows: Vec<f64>,
    lines: Lines,
    /// m − n.
    pub freedom: f64,
}

/// Generalised least squares for one set of parameters.
#[derive(Clone, Debug)]
pub(crate) struct Generalised {
    /// ln L, up to a constant.
    pub log_likelihood: f64,
    /// The step from least squares, in the coordinates of the orthonormal rows.
    pub step: Vec<f64>,
    /// `RᵀR = QᵀV⁻¹Q`.
    pub r: DMatrix<f64>,
    /// √(RSS/(m − n)).
    pub sigma: f64,
}

impl PlainRows {
    /// `q` row by row and residuals, both times the root of the weight, by counted node.
    pub(crate) fn new(q: &[f64], residuals: &[f64], lines: Lines) -> Self {
        let n = q.len() / residuals.len();
        let mut rows = Vec::with_capacity(q.len() + residuals.len());
        for &k in &lines.nodes {
            rows.extend_from_slice(&q[k * n..][..n]);
            rows.push(residuals[k]);
        }
        let freedom = (residuals.len() - n) as f64;
        PlainRows { width: n + 1, rows, lines, freedom }
    }

    /// Products that one evaluation takes.
    pub(crate) fn work(&self) -> usize {
        self.rows.len().saturating_mul(self.width)
    }

    /// `None` where V is singular to rounding.
    pub(crate) fn at(&self, process: &Process, sigma: Option<f64>) -> Option<Generalised> {
        let whitening = Whitening::new(process, &self.lines)?;
        let (width, n) = (self.width, self.width - 1);
        let mut rows = self.rows.clone();
        whitening.whiten(&mut rows, width);
        let mut gram = DMatrix::<f64>::zeros(width, width);
        for row in rows.chunks_exact(width).asking(width * width) {
            for (j, &x) in row.iter().enumerate() {
                for (to, &y) in gram.column_mut(j).iter_mut().zip(&row[..=j]) {
                    *to += x * y;
                }
            }
        }
        let r = triangular::cholesky(&gram.view((0, 0), (n, n)).into_owned())?;
        let mut step: Vec<f64> = gram.column(n).iter().take(n).copied().collect();
        triangular::solve_upper_transposed(&r, &mut step);
        let rss = (gram[(n, n)] - step.iter().map(|x| x * x).sum::<f64>()).max(1e-14 * gram[(n, n)]);
        triangular::solve_upper(&r, &mut step);
        let determinant: f64 = (0..n).map(|i| libm::log(r[(i, i)])).sum();
        let fit = match sigma {
            None => 0.5 * self.freedom * libm::log(rss),
            Some(sigma) => 0.5 * rss / (sigma * sigma),
        };
        let log_likelihood = -whitening.half_log_determinant - determinant - fit;
        let sigma = sigma.unwrap_or((rss / self.freedom).sqrt());
        log_likelihood.is_finite().then_some(Generalised { log_likelihood, step, r, sigma })
    }
}
