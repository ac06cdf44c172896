//! Sums that are known where coefficients are not, and B as a product, as they are answered.

use super::declare::{FieldsAs, ListAs, WriteAs, answer};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{EstimableSum, MatrixBFactors, ProductOfB},
    spec::Include,
};

answer! {
    /// A sum of the coefficients of nearly dependent terms that the nodes determine, of the
    /// unregularised estimate.
    #[schema(as = EstimableSum)]
    pub struct EstimableSumBody from EstimableSum {
        terms, weights, value, std_error, interval, condition_index, sentence,
    } {
        /// The terms whose coefficients cannot be separated.
        terms: Vec<String> = terms,
        /// Weight of the coefficient of each of `terms`; 1 for the leading one.
        weights: Vec<f64> = weights,
        /// Σ weight · coefficient, found without the large coefficients that cancel in it; in the
        /// unit of the leading coefficient.
        value: f64 = value,
        /// Standard error of `value`. Absent without an estimate of the noise, and for estimators
        /// that weight the matrix.
        std_error?: f64 = std_error,
        /// Student's confidence interval at `level`, `[low, high]`.
        #[schema(min_items = 2, max_items = 2)]
        interval?: [f64; 2] = interval,
        /// Ratio of the standard error of the sum to that of the best determined sum of the same
        /// terms, in columns of unit length: 1 to 30.
        condition_index: f64 = condition_index,
        /// The same in words.
        sentence: String = sentence,
    }
}

answer! {
    /// `B = e Σ QᵢSᵢᵀ` (Eq. 28, one product for each regularised eigenvalue) and the inequalities
    /// about it (Eqs. 42 to 46), in the scaled columns.
    #[schema(as = MatrixBFactors)]
    pub struct MatrixBFactorsBody from MatrixBFactors {
        e, products, largest_eigenvalue, largest_eigenvalue_bound, mixed_eigenvalue, mixed_eigenvalue_bound,
    } {
        /// e, the largest cᵢ of Eq. 40.
        e: f64 = e,
        /// One entry for each regularised eigenvalue, ascending.
        products: Vec<ProductOfBBody> = products,
        /// λ_max[BᵀB].
        largest_eigenvalue: f64 = largest_eigenvalue,
        /// Its bound by Eq. 42; for more than one eigenvalue the trace of BᵀB (Eq. 41).
        largest_eigenvalue_bound: f64 = largest_eigenvalue_bound,
        /// λ_max[XᵀB + BᵀX].
        mixed_eigenvalue: f64 = mixed_eigenvalue,
        /// Its bound λ* − λ₁ (Eqs. 45 and 46).
        mixed_eigenvalue_bound: f64 = mixed_eigenvalue_bound,
    }
}

answer! {
    /// One product QSᵀ of B.
    #[schema(as = ProductOfB)]
    pub struct ProductOfBBody from ProductOfB { eigenvalue, mu, q, s } {
        /// λᵢ, the eigenvalue that is raised.
        eigenvalue: f64 = eigenvalue,
        /// μ, the multiplier of Eq. 38.
        mu: f64 = mu,
        /// Q = XV (Eq. 37): one entry for each counted node.
        q: Vec<f64> = q,
        /// S = μV/e (Eq. 38): one entry for each coefficient.
        s: Vec<f64> = s,
    }
}
