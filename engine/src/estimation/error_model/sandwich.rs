//! The covariance of least squares where nothing is said of the variances of the errors.
//!
//! HC3 (MacKinnon and White, Journal of Econometrics 29, 1985): in the coordinates of the
//! orthonormal rows qₖ the covariance is `Σ qₖqₖᵀ (rₖ/(1 − hₖ))²`, hₖ = ‖qₖ‖² the leverage. The
//! division makes each residual that of a fit without its node.

use nalgebra::DMatrix;

use crate::numerics::cancel::Asking;

/// 1 − h from which on a node stands for itself alone.
const ALONE: f64 = 1e-10;

/// The covariance by HC3; `None` where a node alone determines a direction, so that its residual
/// says nothing.
pub(crate) fn hc3(n: usize, q: &[f64], residuals: &[f64]) -> Option<DMatrix<f64>> {
    let mut covariance = DMatrix::<f64>::zeros(n, n);
    for (row, r) in q.chunks_exact(n).zip(residuals).asking(n * n) {
        let rest = 1.0 - row.iter().map(|x| x * x).sum::<f64>();
        if rest < ALONE {
            return None;
        }
        let square = (r / rest).powi(2);
        for (j, &x) in row.iter().enumerate() {
            let share = square * x;
            covariance.column_mut(j).iter_mut().zip(row).for_each(|(to, y)| *to += share * y);
        }
    }
    Some(covariance)
}
