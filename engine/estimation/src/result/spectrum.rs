//! The eigenvalues, before and after regularisation.

/// Eigenvalues of the Fisher information matrix of the scaled columns.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumReport {
    /// Eigenvalues of the scaled Fisher information matrix, ascending.
    pub eigenvalues: Vec<f64>,
    /// λₙ/λ₁; `None` where λ₁ is numerically zero.
    pub condition: Option<f64>,
    /// log₁₀ of the condition.
    pub log10_condition: Option<f64>,
    /// log₁₀ of the determinant; `None` where it is numerically zero.
    pub log10_determinant: Option<f64>,
    /// Number of eigenvalues that are numerically nonzero.
    pub rank: usize,
    /// In the order of the directions that the eigenvalues came from.
    pub regularized: RegularizedSpectrum,
}

/// Eigenvalues after regularisation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegularizedSpectrum {
    /// μᵢ = λᵢ (1 + cᵢ)² of each direction.
    pub eigenvalues: Vec<f64>,
    /// Largest over smallest eigenvalue; `None` where that is numerically zero.
    pub condition: Option<f64>,
    /// log₁₀ of the determinant; `None` where it is numerically zero.
    pub log10_determinant: Option<f64>,
}
