//! What estimated variances of groups do to the errors of weighted least squares.
//!
//! Weights that come of few residuals are uncertain themselves. In the coordinates of the
//! orthonormal rows qₖ of the weighted problem, with `S_g = Σ qₖqₖᵀ` over the nodes of group g, the
//! relative variances of the groups have the restricted information and the covariance
//!
//! ```text
//! I_gh = ½ [δ_gh (m_g − 2 tr S_g) + tr S_g S_h],  W = I⁻¹
//! ```
//!
//! The covariance of the coefficients becomes `σ²(1 + 2 Σ W_gh (δ_gh S_g − S_g S_h))`, and a form q
//! has as many degrees of freedom as its variance is determined by:
//!
//! ```text
//! ν = 2 ‖q‖⁴ / Σ W_gh (qᵀS_g q)(qᵀS_h q)
//! ```
//!
//! Ref.: Kackar and Harville, JASA 79, 1984; Kenward and Roger, Biometrics 53, 1997.

use nalgebra::DMatrix;

use super::mixture::lower_root;
use crate::numerics::{cancel::Asking, distribution::Student};

/// The shares of the groups in what the nodes say, and how well their variances are known.
pub(crate) struct GroupSpread {
    /// S_g.
    shares: Vec<DMatrix<f64>>,
    /// W.
    scatter: DMatrix<f64>,
    /// m − n.
    freedom: f64,
}

/// Numbers that shares may hold, and groups at most.
const MOST: usize = 4_000_000;
const MOST_GROUPS: usize = 100;

/// Degrees of freedom that Student's distribution begins with.
const LEAST_FREEDOM: f64 = 1.0;

impl GroupSpread {
    /// How many groups a fit of so many coefficients may have.
    pub(crate) fn most(coefficients: usize) -> usize {
        (MOST / coefficients.pow(2).max(1)).clamp(2, MOST_GROUPS)
    }

    /// Of orthonormal rows of `n` numbers; `group` has the place of each row's group among
    /// `groups`. `None` where the residuals leave a variance undetermined.
    pub(crate) fn new(n: usize, rows: &[f64], group: &[usize], groups: usize) -> Option<Self> {
        let mut shares = vec![DMatrix::<f64>::zeros(n, n); groups];
        let mut counts = vec![0.0; groups];
        for (row, &g) in rows.chunks_exact(n).zip(group).asking(n * n) {
            counts[g] += 1.0;
            for (j, &x) in row.iter().enumerate() {
                shares[g].column_mut(j).iter_mut().zip(row).for_each(|(to, y)| *to += x * y);
            }
        }
        let information = DMatrix::from_fn(groups, groups, |g, h| {
            let own = if g == h { counts[g] - 2.0 * shares[g].trace() } else { 0.0 };
            0.5 * (own + shares[g].dot(&shares[h]))
        });
        let scatter = information.cholesky()?.inverse();
        let freedom = (group.len() - n) as f64;
        Some(GroupSpread { shares, scatter, freedom })
    }

    /// A root of the covariance over σ².
    pub(crate) fn root(&self) -> Option<DMatrix<f64>> {
        let n = self.shares[0].nrows();
        let mut covariance = DMatrix::<f64>::identity(n, n);
        let mut mean = DMatrix::<f64>::zeros(n, n);
        for (g, share) in self.shares.iter().enumerate().asking(2 * n * n * n) {
            mean.fill(0.0);
            for (h, other) in self.shares.iter().enumerate() {
                let w = 2.0 * self.scatter[(g, h)];
                mean.zip_apply(other, |to, x| *to += w * x);
            }
            let own = 2.0 * self.scatter[(g, g)];
            covariance.zip_apply(share, |to, x| *to += own * x);
            covariance.gemm(-1.0, share, &mean, 1.0);
        }
        lower_root(&covariance)
    }

    /// The distribution of a form's error over its standard error.
    pub(crate) fn student(&self, form: &[f64]) -> Student {
        let square: f64 = form.iter().map(|x| x * x).sum();
        let of: Vec<f64> = self
            .shares
            .iter()
            .map(|share| {
                let columns = share.column_iter().zip(form);
                columns.map(|(column, q)| q * column.iter().zip(form).map(|(s, p)| s * p).sum::<f64>()).sum()
            })
            .collect();
        let pairs = (0..of.len()).flat_map(|g| (0..of.len()).map(move |h| (g, h)));
        let scatter: f64 = pairs.map(|(g, h)| self.scatter[(g, h)] * of[g] * of[h]).sum();
        let freedom = 2.0 * square * square / scatter;
        Student::new(if freedom.is_finite() { freedom.clamp(LEAST_FREEDOM, self.freedom) } else { self.freedom })
    }

    /// The group whose variance rests on the fewest degrees of freedom, and how many they are:
    /// `Σ(1 − h)²` over its nodes in effect, h being the leverages.
    pub(crate) fn least_freedom(&self, group: &[usize]) -> (usize, f64) {
        let free = |g: usize| {
            let count = group.iter().filter(|&&own| own == g).count() as f64;
            count - 2.0 * self.shares[g].trace() + self.shares[g].norm_squared()
        };
        (0..self.shares.len()).map(|g| (g, free(g))).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, self.freedom))
    }
}
