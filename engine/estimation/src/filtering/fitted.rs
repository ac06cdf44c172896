//! The fitted function at the nodes: the heights that were fitted less what was left of them.

use crate::{
    data::{Nodes, Sample},
    diagnostics::finite,
    error::FitError,
    result::FitResult,
    spec::{FitSpec, Include},
};

/// Fits `nodes`, and adds the fitted heights if `spec` includes them, with the heights of the nodes
/// if they have been `filtered`.
pub(super) fn fit_with_heights(
    nodes: &Nodes,
    spec: &FitSpec,
    filtered: bool,
    fit: impl FnOnce(&FitSpec) -> Result<FitResult, FitError>,
) -> Result<FitResult, FitError> {
    if !spec.include.fitted {
        return fit(spec);
    }
    let asked = FitSpec { include: Include { residuals: true, ..spec.include }, ..spec.clone() };
    let mut result = fit(&asked)?;
    let report = &mut result.residuals;
    let Some(left) = report.values.take() else { return Ok(result) };
    let sample = Sample::new(nodes);
    let heights: Vec<f64> = (0..sample.count()).map(|k| sample.z(k)).collect();
    let fitted: Vec<f64> = heights.iter().zip(&left).map(|(z, r)| z - r).collect();
    if fitted.iter().any(|z| !z.is_finite()) {
        return Err(finite::exceeds_double());
    }
    report.fitted = Some(fitted);
    report.heights = filtered.then_some(heights);
    report.values = spec.include.residuals.then_some(left);
    Ok(result)
}
