//! χ² of what was measured against what was predicted, and its quantile.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::counted::Counted;
use flankfit_numerics::distribution::fisher;

/// 0.999 quantile of the standard normal distribution, one-sided.
const ONE_SIDED: f64 = 3.090_232_306_167_813;
/// The same, two-sided.
const TWO_SIDED: f64 = 3.290_526_731_491_894;
/// Probability above the quantile.
const TAIL: f64 = 0.001;

/// S for errors of J of the size `eta`, by what Woodbury's identity needs of it: with N its
/// diagonal and B the columns η C_j, η c and those of the scatter of teeth, `rᵀ S⁻¹ r = rᵀN⁻¹r −
/// ‖L⁻¹ BᵀN⁻¹r‖²`, `L Lᵀ = I + BᵀN⁻¹B`. The last are longer by the ratio of Student's quantile to
/// the normal one, since few teeth do not tell their scatter well.
pub(super) struct Covariance {
    diagonal: Vec<f64>,
    /// N^(-1/2) B.
    columns: DMatrix<f64>,
    inner: Cholesky<f64, nalgebra::Dyn>,
}

impl Covariance {
    pub(super) fn of(nodes: &Counted, known: f64, eta: f64, scatter: usize) -> Option<Self> {
        let settings = nodes.contributions.first()?.len();
        let more = eta * eta - known * known;
        let diagonal: Vec<f64> = nodes.variance.iter().zip(&nodes.single).map(|(s, u)| s + more * u).collect();
        let longer = match scatter {
            0 => 1.0,
            freedom => fisher::student_two_sided(TAIL, freedom as f64) / TWO_SIDED,
        };
        let all = settings + 1 + nodes.scatter.len();
        let columns = DMatrix::from_fn(nodes.before.len(), all, |i, j| {
            let entry = match j.checked_sub(settings + 1) {
                Some(of_scatter) => longer * nodes.scatter[of_scatter][i],
                None => eta * nodes.contributions[i].get(j).copied().unwrap_or(nodes.change[i]),
            };
            entry / diagonal[i].sqrt()
        });
        let inner = Cholesky::new(DMatrix::identity(all, all) + columns.tr_mul(&columns))?;
        Some(Covariance { diagonal, columns, inner })
    }

    /// `aᵀ S⁻¹ b`.
    pub(super) fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let white =
            |x: &[f64]| DVector::from_iterator(x.len(), x.iter().zip(&self.diagonal).map(|(x, s)| x / s.sqrt()));
        let (a, b) = (white(a), white(b));
        a.dot(&b) - self.columns.tr_mul(&a).dot(&self.inner.solve(&self.columns.tr_mul(&b)))
    }

    pub(super) fn square(&self, r: &[f64]) -> f64 {
        self.product(r, r).max(0.0)
    }
}

/// 0.999 quantile of χ² (Wilson and Hilferty; within 3 % for one degree of freedom, 1.2 % from
/// five, 0.2 % from thirty on), or of F times its degrees of freedom where σ was estimated from
/// some.
pub(super) fn quantile(freedom: usize, of_sigma: Option<usize>) -> f64 {
    let nu = freedom as f64;
    if let Some(of_sigma) = of_sigma {
        return nu * fisher::upper_quantile(TAIL, nu, of_sigma.max(1) as f64);
    }
    let spread = 2.0 / (9.0 * nu);
    nu * (1.0 - spread + ONE_SIDED * spread.sqrt()).powi(3)
}
