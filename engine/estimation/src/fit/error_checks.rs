//! Models of the errors in a spec, checked against the nodes.

use crate::{
    data::Nodes,
    error_model::{lines::Lines, mixture::Family, process::Process},
    regularized::criterion_path,
    spec::{Along, Correlation, Criterion, Errors, Estimator, FitSpec, Matern, Prior, Scaling, Variance},
};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, entries},
};

/// Messages for an estimator together with a model of the errors, and for earlier iterations.
pub(super) const OWN_MODEL: &str = "a model of the errors needs least squares: this estimator has its own";
pub(super) const CHAIN: &str = "earlier iterations are weighted with independent errors of one variance";

/// A list with another number of entries than posted nodes.
fn per_node(given: usize, nodes: &Nodes) -> String {
    format!("{}, but there are {} nodes", entries(given), nodes.posted())
}

/// Nodes without the coordinate that the variance is to be a power of.
fn no_coordinate(nodes: &str) -> String {
    format!("{nodes} have no such coordinate for a power of the variance: use groups or hc3")
}

/// Refuses combinations that exclude each other or do not suit the nodes.
pub(super) fn check(nodes: &Nodes, spec: &FitSpec) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if spec.estimator != Estimator::LeastSquares {
        faults.push("estimator.type", OWN_MODEL);
    }
    if spec.node_uncertainty.is_some() {
        faults.push("node_uncertainty", "perturbation bounds are those of independent errors of equal variance");
    }
    if let Some(errors) = &spec.errors {
        if spec.regularization.criterion().is_some_and(Criterion::is_nodewise) {
            faults.push(criterion_path(spec), "press and blocked_cv need independent nodes: use another criterion");
        }
        if spec.scaling == Scaling::Standardized {
            faults.push("scaling", "whitened rows cannot be centred by their means");
        }
        if spec.variance != Variance::Constant {
            faults.push("variance", "either correlated errors or unequal variances, not both");
        }
        check_lines(nodes, errors, &mut faults);
        check_parameters(&errors.correlation, &mut faults);
    }
    if spec.variance != Variance::Constant && spec.noise_sigma.is_some() {
        faults.push("noise_sigma", "variances are estimated from the residuals: omit the given σ");
    }
    if let Variance::Groups(groups) = &spec.variance
        && groups.len() != nodes.posted()
    {
        faults.push("variance.groups", per_node(groups.len(), nodes));
    }
    if let Variance::Power { of, .. } = spec.variance {
        match (nodes, of) {
            (Nodes::Matrix(_), _) => {
                faults.push("variance.power_of", no_coordinate("rows of a matrix"));
            }
            (Nodes::Curve(_), Along::V) => {
                faults.push("variance.power_of", no_coordinate("nodes of a curve"));
            }
            _ => {}
        }
    }
    let estimated = spec.errors.as_ref().is_some_and(|errors| given(errors.correlation, errors.along).is_none());
    match &spec.prior {
        Some(Prior::Iterations(_)) => faults.push("prior", CHAIN),
        Some(Prior::Given { .. }) if estimated || spec.variance == Variance::Hc3 => {
            faults.push(
                "prior",
                "a prior needs errors with given correlations or variances: they cannot be estimated with it",
            );
        }
        _ => {}
    }
    faults.into_result(())
}

/// Paths of the members that request errors which are not white.
pub fn requested_models(spec: &FitSpec) -> impl Iterator<Item = &'static str> {
    let unequal = spec.variance != Variance::Constant;
    spec.errors.is_some().then_some("errors").into_iter().chain(unequal.then_some("variance"))
}

fn check_lines(nodes: &Nodes, errors: &Errors, faults: &mut Faults) {
    match (nodes, errors.along) {
        (Nodes::Grid(_), Along::Both) if !matches!(errors.correlation, Correlation::Ar1 { .. }) => faults
            .push("errors.along", "errors along both axes are autoregressions of first order: use `ar1`, or one axis"),
        (Nodes::Curve(_) | Nodes::Scattered(_) | Nodes::Matrix(_), along @ (Along::U | Along::V | Along::Both)) => {
            faults.push(
                "errors.along",
                format_args!("only nodes of a grid lie on lines along {}: use `order`", along.name()),
            );
        }
        _ => {}
    }
    match (nodes, &errors.lines) {
        (Nodes::Grid(_) | Nodes::Curve(_), Some(_)) => {
            faults.push("errors.line", "curves and grids already define their lines")
        }
        (_, Some(lines)) if lines.len() != nodes.posted() => {
            faults.push("errors.line", per_node(lines.len(), nodes));
        }
        _ => {}
    }
}

fn check_parameters(correlation: &Correlation, faults: &mut Faults) {
    match *correlation {
        Correlation::Ar1 { rho: Some(rho) } if !(rho.abs() < 1.0) => {
            faults.push(
                "errors.parameters.rho",
                format_args!("{} is not a correlation: it must be above -1 and below 1", Shown(rho)),
            );
        }
        Correlation::Ar2 { phi: Some([a, b]) } if !(b > -1.0 && b < 1.0 - a.abs()) => {
            faults.push(
                "errors.parameters.phi",
                format_args!("no stationary process has φ₁ = {} and φ₂ = {}: -1 < φ₂ < 1 - |φ₁|", Shown(a), Shown(b)),
            );
        }
        Correlation::Matern { parameters: Some(Matern { length, nugget }) } => {
            if !(length > 0.0 && length.is_finite()) {
                faults.push(
                    "errors.parameters.length",
                    format_args!("{} is not a length: it must be above 0 and finite", Shown(length)),
                );
            }
            if !(0.0..1.0).contains(&nugget) {
                faults.push(
                    "errors.parameters.nugget",
                    format_args!("{} is not a share: it must be at least 0 and below 1", Shown(nugget)),
                );
            }
        }
        _ => {}
    }
}

/// Returns the process along `along` if its parameters are given.
pub(super) fn given(correlation: Correlation, along: Along) -> Option<Process> {
    Some(match correlation {
        Correlation::Ar1 { rho } if along == Along::Both => Process::Product([rho?; 2]),
        Correlation::Ar1 { rho } => Process::Ar1(rho?),
        Correlation::Ar2 { phi } => Process::Ar2(phi?),
        Correlation::Matern { parameters } => {
            let Matern { length, nugget } = parameters?;
            Process::Matern { length, nugget }
        }
    })
}

/// Returns the family to be searched; `None` if the parameters are given.
pub(super) fn family(correlation: &Correlation, lines: &Lines) -> Option<Family> {
    match correlation {
        Correlation::Ar1 { rho: None } if lines.across.is_some() => Some(Family::Product),
        Correlation::Ar1 { rho: None } => Some(Family::Ar1),
        Correlation::Ar2 { phi: None } => Some(Family::Ar2),
        Correlation::Matern { parameters: None } => {
            let (mut least, mut longest, mut length) = (f64::INFINITY, 0.0f64, 0.0);
            for &step in &lines.steps {
                length = if step.is_finite() { length + step } else { 0.0 };
                longest = longest.max(length);
                if step > 0.0 {
                    least = least.min(step);
                }
            }
            let shortest = if least.is_finite() { 0.5 * least } else { 0.5 };
            Some(Family::Matern { shortest, longest: (2.0 * longest).max(4.0 * shortest) })
        }
        _ => None,
    }
}
