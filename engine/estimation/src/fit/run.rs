//! Fits of nodes.

use super::{
    conclude::{conclude, conclude_robust, report},
    error_models::fit_errors,
    plan::Plans,
    position_errors::fit_positions,
};
use crate::{
    data::{Heights, Nodes, Sample},
    design::Design,
    diagnostics::within_range,
    error::FitError,
    estimate::Frame,
    factor::Factor,
    problem::{Evidence, LinearProblem},
    result::FitResult,
    robust::{Measured, estimate},
    spec::{FitSpec, Variance},
};
use flankfit_numerics::cancel::parts;

/// Approximate shares of the parts of a fit: nodes into R and QᵀY, an estimator that bounds the
/// influence of nodes, and the report.
const FACTOR: usize = 4;
const ESTIMATE: usize = 3;
const REPORT: usize = 3;
const STAGES: usize = FACTOR + ESTIMATE + REPORT;

/// Fits `spec` to `nodes`. Pure: no clock, no randomness, no state; the same input gives the same
/// bits.
pub(crate) fn fit(nodes: &Nodes, spec: &FitSpec) -> Result<FitResult, FitError> {
    fit_remembering(nodes, spec, &Plans::default())
}

/// The same, bit for bit; what depends on the positions of a full grid and the spec alone is kept
/// in `plans` and found there again when other heights are posted for them.
pub(crate) fn fit_remembering(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResult, FitError> {
    let sample = Sample::new(nodes);
    if spec.errors.is_some() || spec.variance != Variance::Constant {
        return fit_errors(nodes, &sample, spec);
    }
    if let Some(result) = fit_positions(nodes, &sample, spec)? {
        return Ok(result);
    }
    let heights = Heights::new(&sample);
    let evidence = Evidence::Posted { sample: &sample, nodes };
    if let Some((grid, plan)) = plans.of(nodes, &sample, spec)? {
        within_range(nodes.heights(), &heights)?;
        let stages = parts(STAGES);
        let factor = stages.run(FACTOR, || plan.factor(grid))?;
        let frame = plan.frame(&factor, spec, heights.weight)?;
        let linear = LinearProblem { design: &plan.design, factor: &factor, heights: heights.about_zero, evidence };
        let measured = Measured { linear: &linear, sample: &sample, heights: &heights };
        let robust = stages.run(ESTIMATE, || estimate(&spec.estimator, &measured))?;
        return stages.run(REPORT, || match robust {
            None => conclude(&linear, &heights, spec, frame, None),
            Some(robust) => conclude_robust(&linear, &sample, nodes, &heights, spec, frame, &robust),
        });
    }
    let design = Design::new(nodes, &sample, spec)?;
    within_range(nodes.heights(), &heights)?;
    let stages = parts(STAGES);
    let factor = stages.run(FACTOR, || Factor::new(&design, &sample))?;
    let linear = LinearProblem { design: &design, factor: &factor, heights: heights.about_zero, evidence };
    let measured = Measured { linear: &linear, sample: &sample, heights: &heights };
    let robust = stages.run(ESTIMATE, || estimate(&spec.estimator, &measured))?;
    stages.run(REPORT, || match robust {
        None => report(&linear, &heights, spec),
        Some(robust) => {
            let frame = Frame::new(&design, &factor, spec, heights.weight)?;
            conclude_robust(&linear, &sample, nodes, &heights, spec, &frame, &robust)
        }
    })
}

/// Fits several heights over the same places with the same weights (the coordinates of a curve):
/// bit for bit the result of [`fit`] for each, but the columns are analysed once.
pub(crate) fn fit_together(nodes: &[Nodes], spec: &FitSpec) -> Result<Vec<FitResult>, FitError> {
    let mut analysed: Option<(Design, Frame)> = None;
    let mut results = Vec::with_capacity(nodes.len());
    for nodes in nodes {
        let sample = Sample::new(nodes);
        let heights = Heights::new(&sample);
        let evidence = Evidence::Posted { sample: &sample, nodes };
        let given = match analysed.take() {
            Some((design, frame)) => (design, Some(frame)),
            None => (Design::new(nodes, &sample, spec)?, None),
        };
        within_range(nodes.heights(), &heights)?;
        let factor = Factor::new(&given.0, &sample)?;
        let (design, frame) = match given {
            (design, Some(frame)) => (design, frame),
            (design, None) => {
                let frame = Frame::new(&design, &factor, spec, heights.weight)?;
                (design, frame)
            }
        };
        let linear = LinearProblem { design: &design, factor: &factor, heights: heights.about_zero, evidence };
        let measured = Measured { linear: &linear, sample: &sample, heights: &heights };
        let result = match estimate(&spec.estimator, &measured)? {
            None => conclude(&linear, &heights, spec, &frame, None),
            Some(robust) => conclude_robust(&linear, &sample, nodes, &heights, spec, &frame, &robust),
        };
        results.push(result?.with_doubts());
        analysed = Some((design, frame));
    }
    Ok(results)
}
