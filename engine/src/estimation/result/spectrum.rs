//! The eigenvalues, before and after regularisation.

#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumReport {
    /// Of the scaled Fisher information matrix, ascending.
    pub eigenvalues: Vec<f64>,
    pub condition: Option<f64>,
    pub log10_condition: Option<f64>,
    pub log10_determinant: Option<f64>,
    pub rank: usize,
    /// In the order of the directions that the eigenvalues came from.
    pub regularized: RegularizedSpectrum,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct RegularizedSpectrum {
    pub eigenvalues: Vec<f64>,
    pub condition: Option<f64>,
    pub log10_determinant: Option<f64>,
}
