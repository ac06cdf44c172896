//! The matrix B as the product that Eq. 28 makes of it, and the inequalities about it.

/// `B = e Σ QᵢSᵢᵀ` (Eq. 28, one product for each regularised eigenvalue) and the inequalities
/// about it (Eqs. 42 to 46), in the scaled columns.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct MatrixBFactors {
    /// e, the largest cᵢ of Eq. 40.
    pub e: f64,
    /// One entry for each regularised eigenvalue, ascending.
    pub products: Vec<ProductOfB>,
    /// `λ_max[BᵀB]`.
    pub largest_eigenvalue: f64,
    /// Its bound by Eq. 42; for more than one eigenvalue the trace of BᵀB (Eq. 41).
    pub largest_eigenvalue_bound: f64,
    /// `λ_max[XᵀB + BᵀX]`.
    pub mixed_eigenvalue: f64,
    /// Its bound λ* − λ₁ (Eqs. 45 and 46).
    pub mixed_eigenvalue_bound: f64,
}

/// One product QSᵀ of B.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct ProductOfB {
    /// λᵢ, the eigenvalue that is raised.
    pub eigenvalue: f64,
    /// μ, the multiplier of Eq. 38.
    pub mu: f64,
    /// Q = XV (Eq. 37): one entry for each counted node.
    pub q: Vec<f64>,
    /// S = μV/e (Eq. 38): one entry for each coefficient.
    pub s: Vec<f64>,
}

impl MatrixBFactors {
    pub(crate) fn is_finite(&self) -> bool {
        let numbers = [
            self.e,
            self.largest_eigenvalue,
            self.largest_eigenvalue_bound,
            self.mixed_eigenvalue,
            self.mixed_eigenvalue_bound,
        ];
        let all = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        all(&numbers) && self.products.iter().all(|p| all(&[p.eigenvalue, p.mu]) && all(&p.q) && all(&p.s))
    }
}
