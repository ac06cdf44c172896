//! The matrix B as the product that Eq. 28 makes of it, and the inequalities about it.

/// `B = e Σ QᵢSᵢᵀ` (Eq. 28, one product for each regularised eigenvalue), in the scaled columns,
/// with e = max cᵢ.
///
/// With Q = XV and S = μV/e the functional of Eq. 33 has its minimum (Eqs. 37, 38), μ = γ/(2λ): the
/// factor cᵢ of Eq. 40. In the exact scheme μ is its cᵢ.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixBFactors {
    /// e.
    pub e: f64,
    /// One entry for each regularised eigenvalue, ascending.
    pub products: Vec<ProductOfB>,
    /// `λ_max[BᵀB]`: the largest cᵢ²λᵢ.
    pub largest_eigenvalue: f64,
    /// Eq. 42, its bound; for more than one eigenvalue the trace (Eq. 41).
    pub largest_eigenvalue_bound: f64,
    /// λ_max[XᵀB + BᵀX]: the largest 2cᵢλᵢ.
    pub mixed_eigenvalue: f64,
    /// Eqs. 43 to 46, the bound λ* − λ₁.
    pub mixed_eigenvalue_bound: f64,
}

/// One product of B.
#[derive(Clone, Debug, PartialEq)]
pub struct ProductOfB {
    /// λᵢ.
    pub eigenvalue: f64,
    /// μ of Eq. 38.
    pub mu: f64,
    /// Q of Eq. 37, one entry for each counted node.
    pub q: Vec<f64>,
    /// S of Eq. 38, one entry for each column.
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
