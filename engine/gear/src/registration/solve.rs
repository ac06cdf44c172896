//! The iteration of a registration.

use super::{
    Motion, Registering, Registration,
    columns::{Column, Freedom},
    part::{Part, State},
    pose::Pose,
    search::SHIFTS,
    start::Start,
};
use crate::deviation::{Deviations, Reference};
use flankfit_estimation::{
    FitError, FitResult, FitSpec, Unconverged, fit, requested_models,
    spec::{Include, Regularization},
};
use flankfit_numerics::{cancel, check::Faults, dot};

/// Most iterations; with motions of some hundred µm and µrad four to six are enough.
pub(crate) const MOST_ITERATIONS: usize = 50;
/// End of the iteration.
pub(super) struct Iterated {
    pub(super) pose: Pose,
    /// Coefficients of the columns where it began.
    pub(super) begun: Vec<f64>,
    pub(super) iterations: usize,
    pub(super) converged: bool,
}

/// A step that moves no point by more than this, µm, ends the iteration …
const STEP: f64 = 1e-9;
/// … or by more than this share of the gear's radius, as far as doubles tell its coordinates.
const RELATIVE_STEP: f64 = 32.0 * f64::EPSILON;

/// Standard errors from which modifications tell a slide along the helices: what is less stays
/// rotation …
const SIGNIFICANT: f64 = 4.0;
/// … and so does what changes the deviations by less (root mean square), µm.
const LEAST_EFFECT: f64 = 1e-3;

/// How far points may go to other flanks than before; later ones stay, lest they go to and fro.
const REASSIGNING: usize = 25;

/// How the part lies. Only the nodes that take part decide; all are carried back. Points stay on
/// the flanks that they are on.
///
/// ```
/// use flankfit_estimation::{FitSpec, spec::Model};
/// use flankfit_geometry::space::Vector;
/// use flankfit_gear::{
///     Gear, GearData, Side,
///     deviation::{MeasuredPoint, Measurement, Reference, measure},
///     involute::Flank,
///     registration::{Motion, Registering, register},
/// };
///
/// // Both flanks of a tooth, measured on a gear that lies 7 µm too far to the right.
/// let gear = Gear::new(GearData::spur(52, 1.0))?;
/// let touches: Vec<MeasuredPoint> = [Side::Left, Side::Right]
///     .into_iter()
///     .flat_map(|side| (0..20).map(move |k| (side, 8.0 + 0.1 * f64::from(k))))
///     .map(|(side, roll)| Flank::new(&gear, side).at(roll, 0.0).point)
///     .map(|point| MeasuredPoint::anywhere(point + Vector::new(7e-3, 0.0, 0.0)))
///     .collect();
/// let reference = Reference::new(&gear);
/// let deviations = measure(&reference, &touches, &Measurement::default())?;
/// let spec = FitSpec::new(Model::Linear);
/// let asked = Registering { motions: &[Motion::XShift], pivot: None, weight: None, spec: &spec };
/// let found = register(&reference, &deviations, &asked)?;
/// assert!((found.motions[0].value - 7.0).abs() < 0.05 && found.rms_after_um < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn register(reference: &Reference, deviations: &Deviations, asked: &Registering) -> Result<Registration, FitError> {
    registered(reference, deviations, asked, None)
}

/// The same where the part may lie anywhere: `deviations` are those of the points that `start`
/// carried back, and points whose flank or tooth is not given go to the nearest one anew after each
/// step.
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
    if let Some(path) = requested_models(asked.spec).next() {
        let message = "a registration needs independent errors of one variance";
        return Err(Faults::one(path, message).into());
    }
    let mut part = Part::new(reference, deviations, asked, freedom, start)?;
    let pivot = part.pivot(asked)?;
    let pose = start.map_or(Pose { pivot, ..Pose::default() }, |start| start.pose.about(pivot));
    // what the fit finds, and regularises, counts from here
    let begun = part.freedom.coefficients(&pose);
    let (mut found, mut last) = part.iterated(pose, begun, asked)?;
    if let Some((with_slide, fit)) = slid(&mut part, &found, asked)? {
        (found, last) = (with_slide, fit);
    }
    part.answer(found, last, asked)
}

/// The same with the slide along the helices, where the modifications tell it; `None`, and the part
/// as it was, where they do not.
fn slid(part: &mut Part, alone: &Iterated, asked: &Registering) -> Result<Option<(Iterated, FitResult)>, FitError> {
    if part.freedom.is_whole() || part.reference.relief.is_none() || !part.supports_slide(&alone.pose, asked.spec)? {
        return Ok(None);
    }
    let (freedom, flank) = (part.freedom.with_slide(), part.flank.clone());
    let before = (std::mem::replace(&mut part.freedom, freedom), flank);
    let begun = alone.begun.iter().copied().chain([0.0]).collect();
    let most = 1e3 * SHIFTS * part.reference.gear.data().normal_module;
    // a slide that runs away is none
    if let Ok((mut found, fit)) = part.iterated(alone.pose, begun, asked)
        && found.converged
        && found.pose.get(Motion::AxialShift).abs() <= most
    {
        found.iterations += alone.iterations;
        return Ok(Some((found, fit)));
    }
    (part.freedom, part.flank) = before;
    Ok(None)
}

impl Part<'_> {
    /// Whether the slope of the modifications along z, at a place that was found without it, speaks
    /// for a slide.
    fn supports_slide(&self, pose: &Pose, spec: &FitSpec) -> Result<bool, FitError> {
        let columns = self.freedom.with_slide().columns;
        if self.rows.len() <= columns.len() {
            return Ok(false);
        }
        let State { x, d } = self.with_columns(pose, &columns)?;
        let n = columns.len();
        let spread = x.chunks_exact(n).map(|row| row[n - 1] * row[n - 1]).sum::<f64>() / self.rows.len() as f64;
        if spread == 0.0 {
            return Ok(false);
        }
        let plain = FitSpec { regularization: Regularization::None, include: Include::default(), ..spec.clone() };
        let result = fit(&self.nodes(x, d, &columns)?, &plain)?;
        let dependent =
            result.collinearity.near_dependencies.iter().any(|near| {
                near.condition_index.is_none() && near.terms.iter().any(|term| *term == Column::Slide.name())
            });
        let slide = &result.coefficients[n - 1];
        let size = slide.value.abs();
        let significant = slide.std_error.is_some_and(|error| size > SIGNIFICANT * error);
        Ok(!dependent && significant && size * spread.sqrt() > LEAST_EFFECT)
    }

    fn iterated(
        &mut self,
        mut pose: Pose,
        begun: Vec<f64>,
        asked: &Registering,
    ) -> Result<(Iterated, FitResult), FitError> {
        let mut p = self.freedom.coefficients(&pose);
        let (mut iterations, mut converged) = (0, false);
        let last = loop {
            cancel::checkpoint();
            let reassigned = if iterations < REASSIGNING { self.reassign(&pose) } else { 0 };
            let state = self.at(&pose)?;
            let so_far: Vec<f64> = p.iter().zip(&begun).map(|(p, begun)| p - begun).collect();
            let heights: Vec<f64> =
                state.d.iter().zip(state.x.chunks_exact(p.len())).map(|(d, x)| d + dot(x, &so_far)).collect();
            let columns = &self.freedom.columns;
            let result = fit(&self.nodes(state.x.clone(), heights, columns)?, asked.spec)?;
            let next: Vec<f64> = result.coefficients.iter().zip(&begun).map(|(c, begun)| begun + c.value).collect();
            let step: Vec<f64> = next.iter().zip(&p).map(|(next, p)| next - p).collect();
            let moved = state.x.chunks_exact(p.len()).map(|x| dot(x, &step).abs()).fold(0.0, f64::max);
            self.freedom.set(&mut pose, &next);
            if !pose.is_sane() {
                return Err(Unconverged::Registration.into());
            }
            // doubles tell a coefficient of this size no finer
            let finest =
                RELATIVE_STEP * next.iter().fold(1e3 * self.reference.gear.tip_radius(), |most, p| most.max(p.abs()));
            (p, iterations) = (next, iterations + 1);
            converged = converged || (reassigned == 0 && moved <= STEP.max(finest));
            if converged || iterations == MOST_ITERATIONS {
                break result;
            }
        };
        Ok((Iterated { pose, begun, iterations, converged }, last))
    }
}
