//! Filters of the nodes before a fit: nodes in, nodes out, and what that did.
//!
//! Measured flanks carry peaks and roughness. Filters take them away before the model is fitted, in
//! the order asked for: `hampel` finds peaks, `gaussian` (ISO 16610-21 and -31) and `spline` (ISO
//! 16610-22) keep the long waves. Cut-offs are in the unit of the axis; the result of a Gaussian or
//! spline filter is the low-pass part (waviness and form).
//!
//! Conventions: filters see heights only. A node that is missing (null, marked invalid, of weight
//! 0, removed by an earlier filter) has no weight under any window and stays missing; other node
//! weights say how certain a height is in the fit, and do not enter here. The nodes stored are
//! those posted: filters belong to what is asked of a fit.
//!
//! The paper (section 4) warns that filtering raises collinearity; `columns` says by how much.

mod columns;
mod gaussian;
mod hampel;
mod lines;
pub(super) mod reason;
mod spline;
mod steps;

use super::{
    data::Nodes,
    diagnostics::finite,
    error::FitError,
    fit::{Plans, fit_remembering as fit_nodes},
    result::{FilteringReport, FitResult, Warning},
    spec::{Filter, FitSpec},
};

/// Filters the nodes as `spec` asks and fits the rest of `spec` to what comes out. Pure, as the fit
/// itself is.
pub fn fit(nodes: &Nodes, spec: &FitSpec) -> Result<FitResult, FitError> {
    fit_remembering(nodes, spec, &Plans::default())
}

/// The same, bit for bit, with what `plans` remembers of positions and spec.
pub fn fit_remembering(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResult, FitError> {
    if spec.filters.is_empty() {
        return fit_nodes(nodes, spec, plans);
    }
    let mut applied = steps::apply(nodes, &spec.filters)?;
    let mut result = fit_nodes(&applied.nodes, spec, plans)?;
    if spec.filters.iter().any(|filter| !matches!(filter, Filter::Hampel(_))) {
        applied.warnings.push(Warning {
            code: "filtered_noise",
            message: "a low-pass filter leaves neighbouring heights with common noise: σ, standard errors and the \
                choice of λ* \
                      are those of the filtered heights and take their noise for independent"
                .into(),
        });
    }
    let [before, after] = columns::compare(nodes, &applied.nodes, &applied.steps, spec, &mut applied.warnings)?;
    let report = FilteringReport { filters: applied.reports, before, after };
    result.filtering = Some(finite::checked_filtering(report, &mut result.warnings)?);
    result.warnings.append(&mut applied.warnings);
    Ok(result)
}
#[cfg(test)]
mod tests;
