//! The fit of the nodes of now, and the noise that a prior is weighed by.

use nalgebra::DMatrix;

use crate::{design::Design, spec::FitSpec};
use flankfit_numerics::Dd;

/// The fit of the nodes of now, by themselves.
pub(crate) struct Current<'a> {
    pub spec: &'a FitSpec,
    pub design: &'a Design,
    /// U: the caller's columns in Q's coordinates.
    pub columns: &'a DMatrix<Dd>,
    /// U⁻¹.
    pub inverse: DMatrix<Dd>,
    /// Â.
    pub coefficients: Vec<Dd>,
    pub rss: f64,
    pub freedom: usize,
}

/// σ, and the degrees of freedom of its estimate; `None` where it was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PooledNoise {
    pub sigma: f64,
    pub freedom: Option<usize>,
}

impl Current<'_> {
    /// Standard deviations of the caller's coefficients along the columns, in units of σ.
    pub(super) fn along(&self, deviations: &[f64], sigma: f64) -> DMatrix<f64> {
        let mut along = self.columns.clone();
        for (mut column, &deviation) in along.column_iter_mut().zip(deviations) {
            let factor = Dd::from(deviation) / Dd::from(sigma);
            column.iter_mut().for_each(|x| *x *= factor);
        }
        along.map(|x| x.to_f64())
    }
}
