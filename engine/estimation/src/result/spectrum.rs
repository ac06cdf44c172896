//! The eigenvalues, before and after regularisation.

/// Eigenvalues of the scaled Fisher information matrix.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Spectrum)
)]
pub struct SpectrumReport {
    /// Ascending.
    pub eigenvalues: Vec<f64>,
    /// λₙ/λ₁; absent when the rank is not full.
    pub condition: Option<f64>,
    /// Decimal logarithm of the condition number.
    pub log10_condition: Option<f64>,
    /// Sum of the decimal logarithms of the eigenvalues; absent where one is 0.
    pub log10_determinant: Option<f64>,
    /// Number of singular values above rounding error.
    pub rank: usize,
    /// In the order of the directions that the eigenvalues came from.
    pub regularized: RegularizedSpectrum,
}

/// After regularisation, in the order of the directions that the eigenvalues came from.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct RegularizedSpectrum {
    /// Eigenvalues after the regularisation.
    pub eigenvalues: Vec<f64>,
    /// Greatest over least; absent where it is infinite.
    pub condition: Option<f64>,
    /// Sum of the decimal logarithms of the eigenvalues; absent where one is 0.
    pub log10_determinant: Option<f64>,
}
