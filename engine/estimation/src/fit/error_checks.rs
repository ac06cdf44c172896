//! Models of the errors that a spec asks for, checked against the nodes.

use crate::{
    data::Nodes,
    error_model::{lines::Lines, mixture::Family, process::Process},
    fault::{ErrorsReason, Faults, Field},
    regularized::criterion_field,
    spec::{Along, Correlation, Criterion, Errors, Estimator, FitSpec, Matern, Prior, Scaling, Variance},
};

/// What does not go together, or does not suit the nodes.
pub(super) fn check(nodes: &Nodes, spec: &FitSpec) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if spec.estimator != Estimator::LeastSquares {
        faults.push(Field::EstimatorType, ErrorsReason::Robust);
    }
    if spec.node_uncertainty.is_some() {
        faults.push(Field::NodeUncertainty, ErrorsReason::Uncertainty);
    }
    if let Some(errors) = &spec.errors {
        if spec.regularization.criterion().is_some_and(Criterion::is_nodewise) {
            faults.push(criterion_field(spec), ErrorsReason::Press);
        }
        if spec.scaling == Scaling::Standardized {
            faults.push(Field::Scaling, ErrorsReason::Standardized);
        }
        if spec.variance != Variance::Constant {
            faults.push(Field::Variance, ErrorsReason::Both);
        }
        check_lines(nodes, errors, &mut faults);
        check_parameters(&errors.correlation, &mut faults);
    }
    if spec.variance != Variance::Constant && spec.noise_sigma.is_some() {
        faults.push(Field::NoiseSigma, ErrorsReason::Sigma);
    }
    if let Variance::Groups(groups) = &spec.variance
        && groups.len() != nodes.posted()
    {
        faults.push(Field::VarianceGroups, ErrorsReason::Count { given: groups.len(), nodes: nodes.posted() });
    }
    if let Variance::Power { of, .. } = spec.variance {
        match (nodes, of) {
            (Nodes::Matrix(_), _) => {
                faults.push(Field::VariancePowerOf, ErrorsReason::NoCoordinate("rows of a matrix"));
            }
            (Nodes::Curve(_), Along::V) => {
                faults.push(Field::VariancePowerOf, ErrorsReason::NoCoordinate("nodes of a curve"));
            }
            _ => {}
        }
    }
    let estimated = spec.errors.as_ref().is_some_and(|errors| given(errors.correlation).is_none());
    match &spec.prior {
        Some(Prior::Iterations(_)) => faults.push(Field::Prior, ErrorsReason::Chain),
        Some(Prior::Given { .. }) if estimated || spec.variance == Variance::Hc3 => {
            faults.push(Field::Prior, ErrorsReason::Prior);
        }
        _ => {}
    }
    faults.into_result(())
}

/// The fields that ask for errors which are not white.
pub fn asked_models(spec: &FitSpec) -> impl Iterator<Item = Field> {
    let unequal = spec.variance != Variance::Constant;
    spec.errors.is_some().then_some(Field::Errors).into_iter().chain(unequal.then_some(Field::Variance))
}

fn check_lines(nodes: &Nodes, errors: &Errors, faults: &mut Faults) {
    match (nodes, errors.along) {
        (Nodes::Grid(_), Along::Order) => faults.push(Field::ErrorsAlong, ErrorsReason::WhichWay),
        (Nodes::Curve(_) | Nodes::Scattered(_) | Nodes::Matrix(_), along @ (Along::U | Along::V)) => {
            faults.push(Field::ErrorsAlong, ErrorsReason::NoLines(along));
        }
        _ => {}
    }
    match (nodes, &errors.lines) {
        (Nodes::Grid(_) | Nodes::Curve(_), Some(_)) => faults.push(Field::ErrorsLine, ErrorsReason::LinesGiven),
        (_, Some(lines)) if lines.len() != nodes.posted() => {
            faults.push(Field::ErrorsLine, ErrorsReason::Count { given: lines.len(), nodes: nodes.posted() });
        }
        _ => {}
    }
}

fn check_parameters(correlation: &Correlation, faults: &mut Faults) {
    match *correlation {
        Correlation::Ar1 { rho: Some(rho) } if !(rho.abs() < 1.0) => {
            faults.push(Field::ErrorsRho, ErrorsReason::Correlation(rho));
        }
        Correlation::Ar2 { phi: Some([a, b]) } if !(b > -1.0 && b < 1.0 - a.abs()) => {
            faults.push(Field::ErrorsPhi, ErrorsReason::NotStationary([a, b]));
        }
        Correlation::Matern { parameters: Some(Matern { length, nugget }) } => {
            if !(length > 0.0 && length.is_finite()) {
                faults.push(Field::ErrorsLength, ErrorsReason::Length(length));
            }
            if !(0.0..1.0).contains(&nugget) {
                faults.push(Field::ErrorsNugget, ErrorsReason::Nugget(nugget));
            }
        }
        _ => {}
    }
}

/// The process with the parameters that were told.
pub(super) fn given(correlation: Correlation) -> Option<Process> {
    Some(match correlation {
        Correlation::Ar1 { rho } => Process::Ar1(rho?),
        Correlation::Ar2 { phi } => Process::Ar2(phi?),
        Correlation::Matern { parameters } => {
            let Matern { length, nugget } = parameters?;
            Process::Matern { length, nugget }
        }
    })
}

/// What is to be searched; `None` where parameters were told.
pub(super) fn family(correlation: &Correlation, lines: &Lines) -> Option<Family> {
    match correlation {
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
