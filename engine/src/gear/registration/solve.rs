//! The iteration of a registration.

use super::{Registering, Registration, answer::Found, columns::Freedom, part::Part, pose::Pose, start::Start};
use crate::{
    estimation::{FitError, fit},
    gear::deviation::{Deviations, Reference},
    numerics::cancel,
};

/// Most iterations; with motions of some hundred µm and µrad four to six are enough.
pub const MOST_ITERATIONS: usize = 50;
/// A step that moves no point by more than this, µm, ends the iteration …
const STEP: f64 = 1e-9;
/// … or by more than this share of the gear's radius, as far as doubles tell its coordinates.
const RELATIVE_STEP: f64 = 32.0 * f64::EPSILON;

/// How far points may go to other flanks than before; later ones stay, lest they go to and fro.
const REASSIGNING: usize = 25;

/// How the part lies. Only the nodes that take part decide; all are carried back. Faults point to
/// `/motions`, `/pivot_z_mm`, `/weight`, to `/points/i` for node i, and where a fit has them. Points
/// stay on the flanks that they are on.
pub fn register(reference: &Reference, deviations: &Deviations, asked: &Registering) -> Result<Registration, FitError> {
    registered(reference, deviations, asked, None)
}

/// The same where the part may lie anywhere: `deviations` are those of the points that `start` carried
/// back, and points whose flank or tooth is not told go to the nearest one anew after each step.
pub fn register_from(
    reference: &Reference,
    deviations: &Deviations,
    asked: &Registering,
    start: &Start,
) -> Result<Registration, FitError> {
    registered(reference, deviations, asked, Some(start))
}

fn registered(
    reference: &Reference,
    deviations: &Deviations,
    asked: &Registering,
    start: Option<&Start>,
) -> Result<Registration, FitError> {
    let freedom = Freedom::new(reference.gear, asked.motions)?;
    let mut part = Part::new(reference, deviations, asked, freedom, start)?;
    let pivot = part.pivot(asked)?;
    let mut pose = start.map_or(Pose { pivot, ..Pose::default() }, |start| start.pose.about(pivot));
    // what the fit finds, and regularises, counts from here
    let begun = part.freedom.coefficients(&pose);
    let mut p = begun.clone();
    let (mut iterations, mut converged) = (0, false);
    let last = loop {
        cancel::checkpoint();
        let reassigned = if iterations < REASSIGNING { part.reassign(&pose) } else { 0 };
        let state = part.at(&pose)?;
        let so_far: Vec<f64> = p.iter().zip(&begun).map(|(p, begun)| p - begun).collect();
        let heights: Vec<f64> =
            state.d.iter().zip(state.x.chunks_exact(p.len())).map(|(d, x)| d + dot(x, &so_far)).collect();
        let columns = &part.freedom.columns;
        let result = fit(&part.nodes(state.x.clone(), heights, columns)?, asked.spec)?;
        let next: Vec<f64> = result.coefficients.iter().zip(&begun).map(|(c, begun)| begun + c.value).collect();
        let step: Vec<f64> = next.iter().zip(&p).map(|(next, p)| next - p).collect();
        let moved = state.x.chunks_exact(p.len()).map(|x| dot(x, &step).abs()).fold(0.0, f64::max);
        part.freedom.set(&mut pose, &next, asked.spec.scaling);
        if !pose.is_sane() {
            return Err(FitError::NotConverged(
                "the registration ran away to tilts beyond 0.1 rad: free fewer motions, or regularise",
            ));
        }
        // doubles tell a coefficient of this size no finer
        let finest = RELATIVE_STEP * next.iter().fold(1e3 * reference.gear.tip_radius(), |most, p| most.max(p.abs()));
        (p, iterations) = (next, iterations + 1);
        converged = converged || (reassigned == 0 && moved <= STEP.max(finest));
        if converged || iterations == MOST_ITERATIONS {
            break result;
        }
    };
    part.answer(Found { pose, begun, iterations, converged }, last, asked)
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
