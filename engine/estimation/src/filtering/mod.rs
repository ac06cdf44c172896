//! Filters of the nodes before a fit: nodes in, nodes out, and what that did.
//!
//! Measured flanks carry peaks and roughness. Filters take them away before the model is fitted, in
//! the requested order: `hampel` finds peaks, `gaussian` (ISO 16610-21 and -31) and `spline` (ISO
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
mod fitted;
mod gaussian;
mod hampel;
mod lines;
mod spline;
mod steps;
mod windows;

use super::{
    data::{Nodes, masked, without},
    diagnostics::finite,
    error::FitError,
    fit::{Plans, fit_remembering as fit_nodes},
    prior::with_earlier,
    result::{Coefficient, FilterCollinearity, FilterKind, FitResult, MovedCoefficient, Warning},
    select::choose,
    spec::{Estimator, Filter, FitSpec, Include, Regularization},
};

/// Filters the nodes as `spec` asks and fits the rest of `spec` to what comes out. Pure, as the fit
/// itself is.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Degree, Model, PolynomialBasis, Regularization, Terms},
/// };
///
/// // A crowned helix: deviations in µm over the face width in mm, 3 − 0.04 (z − 10)².
/// let z: Vec<f64> = (0..=20).map(f64::from).collect();
/// let deviation = z.iter().map(|z| 3.0 - 0.04 * (z - 10.0).powi(2)).collect();
/// let nodes = Nodes::curve(z, deviation, None)?;
/// let model = Model::Polynomial {
///     degree: Degree::Both(2),
///     basis: PolynomialBasis::Monomial,
///     terms: Terms::Tensor,
/// };
/// let found =
///     fit(&nodes, &FitSpec { regularization: Regularization::None, ..FitSpec::new(model) })?;
///
/// // The same in powers of z is −1 + 0.8 z − 0.04 z².
/// for (coefficient, expected) in found.coefficients.iter().zip([-1.0, 0.8, -0.04]) {
///     assert!((coefficient.value - expected).abs() < 1e-12);
/// }
/// assert_eq!(found.coefficients[2].term, "x^2");
/// assert!(found.numerics.correct_digits > 12.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit(nodes: &Nodes, spec: &FitSpec) -> Result<FitResult, FitError> {
    fit_remembering(nodes, spec, &Plans::default())
}

/// The same, bit for bit, with what `plans` remembers of positions and spec.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, Plans, fit, fit_remembering,
///     spec::{Degree, Model, PolynomialBasis, Terms},
/// };
///
/// // Flanks of two teeth, measured at the same nodes.
/// let axis: Vec<f64> = (0..6).map(f64::from).collect();
/// let flank = |tooth: i32| {
///     let heights = (0..36).map(|k| f64::from((7 * k + 5 * tooth) % 11)).collect();
///     Nodes::grid(axis.clone(), axis.clone(), heights, None, None)
/// };
/// let model = Model::Polynomial {
///     degree: Degree::Both(2),
///     basis: PolynomialBasis::Chebyshev,
///     terms: Terms::Tensor,
/// };
/// let (plans, spec) = (Plans::default(), FitSpec::new(model));
/// for tooth in [1, 2] {
///     let nodes = flank(tooth)?;
///     assert_eq!(fit_remembering(&nodes, &spec, &plans)?, fit(&nodes, &spec)?);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit_remembering(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResult, FitError> {
    let result = match spec.exclude.is_empty() {
        true => with_and_without(nodes, spec, plans),
        false => with_and_without(&without(nodes, &spec.exclude)?, spec, plans),
    };
    Ok(result?.with_doubts())
}

/// Returns the fit, and, if nodes are suspected of gross errors, the fit without them.
fn with_and_without(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResult, FitError> {
    let mut result = fit_selected(nodes, spec, plans)?;
    let suspected = result.warnings.iter_mut().find_map(|warning| match warning {
        Warning::OutliersSuspected(found) => Some(found),
        _ => None,
    });
    let Some(found) = suspected else { return Ok(result) };
    let left_out: Vec<usize> = found.nodes.iter().map(|node| node.index).collect();
    let spec = FitSpec { include: Include::default(), predict: None, ..spec.clone() };
    // if the other nodes do not determine a fit, there is none without the suspected ones
    if let Ok(other) = fit_selected(&masked(nodes, &left_out), &spec, plans) {
        found.coefficients = result.coefficients.iter().filter_map(|one| moved(one, &other)).collect();
        result.without_suspected = Some(Box::new(other.with_doubts()));
    }
    Ok(result)
}

fn finds_peaks(filter: &Filter) -> bool {
    matches!(filter, Filter::Hampel(_))
}

/// Returns the warnings of a fit of the heights before smoothing that smoothing misleads: a
/// low-pass filter spreads a gross error over its neighbours and leaves their noise correlated.
fn checks_before_smoothing(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<Vec<Warning>, FitError> {
    if spec.estimator != Estimator::LeastSquares {
        return Ok(Vec::new());
    }
    let peaks: Vec<Filter> = spec.filters.iter().copied().filter(finds_peaks).collect();
    let plain = FitSpec {
        scaling: spec.scaling,
        domain: spec.domain,
        regularization: Regularization::None,
        ..FitSpec::new(spec.model.clone())
    };
    let found = fit_nodes(&steps::apply(nodes, &peaks)?.nodes, &plain, plans)?;
    Ok(found.warnings.into_iter().filter(is_misled).collect())
}

/// Returns whether smoothing makes a warning appear or disappear.
fn is_misled(warning: &Warning) -> bool {
    match warning {
        Warning::OutliersSuspected(_) => true,
        Warning::Residuals { warning } => warning.code() != "correlated_residuals",
        _ => false,
    }
}

/// Pairs a coefficient with that of the same term in another fit.
fn moved(one: &Coefficient, other: &FitResult) -> Option<MovedCoefficient> {
    let without = other.coefficients.iter().find(|other| other.key == one.key)?;
    let half_width = without.interval.as_ref().map(|interval| 0.5 * (interval.ends[1] - interval.ends[0]));
    let (value, without) = (one.value, without.value);
    let exceeds_interval = half_width.is_some_and(|half| (value - without).abs() > half);
    Some(MovedCoefficient { term: one.term.clone(), value, without, half_width, exceeds_interval })
}

/// Fits the requested model, or the selected one.
fn fit_selected(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResult, FitError> {
    if let Some(asked) = &spec.select {
        let chosen = match spec.filters.is_empty() {
            true => choose(nodes, spec, asked)?,
            false => choose(&steps::apply(nodes, &spec.filters)?.nodes, spec, asked)?,
        };
        let result = fit_model(chosen.nodes.as_ref().unwrap_or(nodes), &chosen.spec, plans)?;
        return chosen.into_result(result);
    }
    fit_model(nodes, spec, plans)
}

/// The fit of the model of `spec`.
fn fit_model(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResult, FitError> {
    if spec.filters.is_empty() {
        return fitted::fit_with_heights(nodes, spec, false, |spec| fit_nodes(nodes, spec, plans));
    }
    let mut applied = steps::apply(nodes, &spec.filters)?;
    let filtered = with_earlier(spec, |nodes| Ok(steps::apply(nodes, &spec.filters)?.nodes))?;
    let spec_of_filtered = filtered.as_ref().unwrap_or(spec);
    let mut result = fitted::fit_with_heights(&applied.nodes, spec_of_filtered, true, |spec| {
        fit_nodes(&applied.nodes, spec, plans)
    })?;
    if spec.filters.iter().any(|filter| !finds_peaks(filter)) {
        applied.warnings.push(Warning::FilteredNoise);
        result.warnings.retain(|warning| !is_misled(warning));
        result.warnings.extend(checks_before_smoothing(nodes, spec, plans)?);
    }
    let peaks = applied.reports.iter().filter(|report| report.kind == FilterKind::Hampel);
    let changed: usize = peaks.map(|report| report.changed).sum();
    if changed > 0 {
        applied.warnings.push(Warning::PeaksChanged { changed });
    }
    let [before, after] = columns::compare(nodes, &applied.nodes, &applied.steps, spec, &mut applied.warnings)?;
    let columns = FilterCollinearity { before, after };
    if !spec.include.peaks {
        applied.reports.iter_mut().for_each(|report| report.node_indices = None);
    }
    let (filters, columns) = finite::checked_filtering(applied.reports, columns, &mut result.warnings)?;
    (result.filters, result.filter_collinearity) = (Some(filters), Some(columns));
    result.warnings.append(&mut applied.warnings);
    Ok(result)
}
#[cfg(test)]
mod tests;
