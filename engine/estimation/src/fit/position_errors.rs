//! Fits of nodes whose positions are off: as weighted least squares at the positions that are
//! likeliest, and on as any fit.

use super::{
    conclude::conclude_with,
    error_checks::{CHAIN, OWN_MODEL},
    error_models::too_large,
};
use crate::{
    data::{Heights, Nodes, Sample},
    design::Design,
    diagnostics::within_range,
    error::{FitError, Unconverged},
    error_model::{
        position_spread::{Scatter, scatter},
        positions::{Positions, Settled, rounds},
        spread::ErrorSpread,
    },
    estimate::Frame,
    factor::Factor,
    problem::{Evidence, LinearProblem},
    result::{FitResult, HOLDING, NotEnclosed, PositionsReport, Warning},
    spec::{Estimator, FitSpec, Include, Model, NodeUncertainty, PositionKind, Prior},
};
use flankfit_numerics::{check::Faults, distribution::chi_squared};

/// Reason why the positions of these nodes are taken as exact.
fn unsuited(nodes: &Nodes, spec: &FitSpec, uncertainty: NodeUncertainty) -> Option<&'static str> {
    if matches!(nodes, Nodes::Matrix(_)) {
        Some("the columns of a measurement matrix have no positions")
    } else if !(uncertainty.height > 0.0) {
        Some("positions have no effect where the surface is level: give the uncertainty of the heights too")
    } else if spec.estimator != Estimator::LeastSquares {
        Some(OWN_MODEL)
    } else if matches!(spec.prior, Some(Prior::Iterations(_))) {
        Some(CHAIN)
    } else if spec.folds.is_some() {
        Some("cross-validation by blocks treats positions as exact: omit one of the two")
    } else if !spec.constraints.is_empty() {
        Some("a fit with constraints treats positions as exact: omit one of the two")
    } else {
        None
    }
}

/// Fits nodes with uncertain positions; `None` if they are taken as exact, by default.
pub(super) fn fit_positions(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<Option<FitResult>, FitError> {
    let Some(uncertainty) = spec.node_uncertainty.filter(|uncertainty| uncertainty.position > 0.0) else {
        return Ok(None);
    };
    let refused = |message: &str| match uncertainty.kind {
        Some(_) => Err(Faults::one("node_uncertainty.position_kind", message).into()),
        None => Ok(None),
    };
    if let Some(message) = unsuited(nodes, spec, uncertainty) {
        return refused(message);
    }
    let design = Design::new(nodes, sample, spec)?;
    if rounds(sample.count(), design.size()).is_none() {
        return refused(&too_large(sample.count(), design.size()));
    }
    let heights = Heights::new(sample);
    within_range(nodes.heights(), &heights)?;
    let factor = Factor::new(&design, sample)?;
    let Some(working) = &factor.working else {
        return refused(
            "the columns are linearly dependent at these nodes, and positions are then treated as exact: use fewer \
             terms, or omit this",
        );
    };
    let kind = uncertainty.kind.unwrap_or_default();
    let positions = Positions {
        design: &design,
        sample,
        kind,
        ratio: uncertainty.position / uncertainty.height,
        within: match (&spec.model, design.domain) {
            (Model::BSpline { .. }, Some(domain)) => Some((domain.u.unwrap_or_default(), domain.v.unwrap_or_default())),
            _ => None,
        },
        r: factor.r.map(|x| x.to_f64()),
        length: heights.about_zero.sqrt(),
    };
    let start: Vec<f64> = working.iter().map(|x| x.to_f64()).collect();
    let Some(settled) = positions.settle(&start) else {
        return match uncertainty.kind {
            Some(_) => Err(Unconverged::Positions.into()),
            None => Ok(None),
        };
    };
    let specified =
        FitSpec { node_uncertainty: Some(NodeUncertainty { kind: Some(kind), ..uncertainty }), ..spec.clone() };
    concluded(nodes, sample, &specified, &design, settled).map(Some)
}

fn concluded(
    nodes: &Nodes,
    sample: &Sample,
    spec: &FitSpec,
    design: &Design,
    settled: Settled,
) -> Result<FitResult, FitError> {
    let moved = moved(nodes, sample, &settled)?;
    let sample = Sample::new(&moved);
    let heights = Heights::new(&sample);
    let factor = Factor::new(design, &sample)?;
    let frame = Frame::new(design, &factor, spec, heights.weight)?;
    let evidence = Evidence::Posted { sample: &sample, nodes: &moved };
    let linear = LinearProblem { design, factor: &factor, heights: heights.about_zero, evidence };
    let uncertainty = spec.node_uncertainty;
    let measured = uncertainty.filter(|given| given.kind == Some(PositionKind::Measured) && spec.prior.is_none());
    let scattered =
        measured.and_then(|given| scatter(design, &factor, &settled, given.position / given.height, spec.noise_sigma));
    let warning = scattered.as_ref().and_then(|found| {
        let figures = [found.share, found.bend, found.weights];
        let beyond = figures.iter().zip(HOLDING).any(|(figure, most)| *figure > most);
        beyond.then_some(Warning::PositionsUncertain {
            share: found.share,
            bend_std_errors: found.bend,
            weight_std_error: found.weights,
        })
    });
    let spread = scattered.map(|Scatter { root, .. }| ErrorSpread::new(root));
    let include = Include { enclosure: false, ..spec.include };
    let without = FitSpec { include, ..spec.clone() };
    let mut result = conclude_with(&linear, &heights, &without, &frame, None, spread.as_ref())?;
    let reason = NotEnclosed::OtherFit;
    result.warnings.extend(spec.include.enclosure.then_some(Warning::NoEnclosure { reason }));
    result.warnings.extend(warning);
    let sigma_ratio = result.residuals.sigma.zip(uncertainty).map(|(sigma, given)| sigma / given.height);
    let sigma_ratio = sigma_ratio.filter(|ratio| ratio.is_finite());
    result.warnings.extend(sigma_ratio.and_then(|ratio| contradiction(ratio, result.residuals.degrees_of_freedom)));
    result.positions = Some(PositionsReport {
        kind: uncertainty.and_then(|uncertainty| uncertainty.kind).unwrap_or_default(),
        rounds: settled.rounds,
        variance_share: settled.share,
        largest_shift: settled.largest_shift,
        sigma_ratio,
    });
    Ok(result)
}

/// Factor between σ and the given uncertainty from which on a warning is given.
const FAR: f64 = 3.0;
/// The probability that chance alone makes a ratio so far off.
const CHANCE: f64 = 1e-3;

/// Warning that the residuals contradict the given uncertainties.
fn contradiction(ratio: f64, freedom: usize) -> Option<Warning> {
    let count = freedom as f64;
    let above = chi_squared::upper_tail(count * ratio * ratio, count);
    let likely = above.min(1.0 - above) >= 0.5 * CHANCE;
    let near = (1.0 / FAR..=FAR).contains(&ratio);
    (!near && !likely).then_some(Warning::UncertaintyContradicted { sigma_ratio: ratio, degrees_of_freedom: freedom })
}

/// All posted nodes, those that count carried to where they were settled.
fn moved(nodes: &Nodes, sample: &Sample, settled: &Settled) -> Result<Nodes, Faults> {
    let posted = nodes.posted();
    let mut places: Vec<[f64; 2]> = match nodes {
        Nodes::Curve(curve) => curve.x.iter().map(|&x| [x, 0.0]).collect(),
        Nodes::Scattered(nodes) => nodes.u.iter().zip(&nodes.v).map(|(&u, &v)| [u, v]).collect(),
        Nodes::Grid(grid) => grid.u.iter().flat_map(|&u| grid.v.iter().map(move |&v| [u, v])).collect(),
        Nodes::Matrix(_) => vec![[0.0; 2]; posted],
    };
    let (mut heights, mut weights) = (vec![0.0; posted], vec![0.0; posted]);
    for k in 0..sample.count() {
        let at = sample.posted(k);
        (places[at], heights[at], weights[at]) = (settled.places[k], settled.heights[k], settled.weights[k]);
    }
    let (u, v) = places.into_iter().map(|[u, v]| (u, v)).unzip();
    let moved = match nodes {
        Nodes::Curve(_) => Nodes::curve(u, heights, Some(weights)),
        _ => Nodes::scattered(u, v, heights, Some(weights)),
    };
    moved.map_err(|faults| faults.within("nodes"))
}
