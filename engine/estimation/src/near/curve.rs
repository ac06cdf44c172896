//! B-spline and NURBS curves near points: y(x), or points of plane or space over a parameter, each
//! coordinate a fit ([`crate::fit()`]) with the same measurement matrix.
//!
//! Knots are given, uniform, averaged by the parameters (Piegl and Tiller, Eqs. 9.68 and 9.69), or
//! placed by the residuals ([`super::adaptive`]). Estimator, regularisation, scaling and
//! diagnostics are those of the [`FitSpec`] handed over, its model aside. Errors are distances at
//! equal parameters.

use super::{
    adaptive::{self, Step, Stop},
    points::{CurvePoints, Parameters, of_knots, of_parameters, place},
    settings::{CurveSettings, KnotPlacement, POSITIONS_EXACT, WHITE_ONLY},
    swing::Swing,
    trial::{Fitted, Trial, summary, uniform},
};
use crate::{
    error::FitError,
    fit::requested_models,
    result::FitResult,
    spec::{FitSpec, Knots},
};
use flankfit_geometry::{
    curve::{BSplineCurve, knots::averaging_least_squares},
    space::{Dimension, HIGHEST_DEGREE, Vector, degree_too_high},
};
use flankfit_numerics::{
    cancel,
    check::Faults,
    words::{counted, entries},
};

/// A curve near points.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveFit {
    /// The curve; its control points are the coefficients of all coordinates.
    pub curve: BSplineCurve,
    /// One per point.
    pub parameters: Vec<f64>,
    /// One fit per coordinate, with the model that was used.
    pub results: Vec<FitResult>,
    /// The spec of those fits.
    pub spec: FitSpec,
    /// Largest distance of a counted point from the curve, at its parameter.
    pub max_error: f64,
    /// Root mean square of these distances.
    pub rms_error: f64,
    /// The knots tried where residuals placed them, up to the best, which are those of the curve.
    pub steps: Vec<Step>,
    /// Reason why knots were no longer added; `None` if they were not placed by residuals.
    pub stop: Option<Stop>,
}

impl CurveFit {
    /// Greatest oscillation of the curve between neighbouring points: the distance by which it
    /// leaves the box of its places at their parameters, over the extent of all points. Above
    /// [`super::WILD`] it is no curve near the `points` it was fitted to, whatever the residuals
    /// say.
    pub fn swing(&self, points: &CurvePoints) -> f64 {
        let counted = self.parameters.iter().enumerate().filter(|(k, _)| points.counts(*k));
        let mut distinct: Vec<f64> = counted.map(|(_, t)| *t).collect();
        distinct.sort_by(cancel::comparing(f64::total_cmp));
        distinct.dedup();
        Swing::of(points, &distinct).out(&self.curve)
    }
}

/// Fits one curve of all coordinates.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec,
///     near::{Adaptive, CurvePoints, CurveSettings, KnotPlacement, Parameters, Stop, curve},
///     spec::{Model, Regularization},
/// };
/// use flankfit_geometry::curve::{Curve, Parametrization};
///
/// // A quarter of a circle of radius 20 mm, to 1 µm.
/// let angles: Vec<f64> =
///     (0..=60).map(|k| f64::from(k) / 60.0 * std::f64::consts::FRAC_PI_2).collect();
/// let coordinates = [
///     angles.iter().map(|a| 20.0 * a.cos()).collect(),
///     angles.iter().map(|a| 20.0 * a.sin()).collect(),
/// ];
/// let points = CurvePoints {
///     coordinates: &coordinates,
///     parameters: Parameters::By(Parametrization::ChordLength),
///     weight: None,
/// };
/// let settings = CurveSettings {
///     degree: 3,
///     knots: KnotPlacement::Adaptive(Adaptive { spans: 1, tolerance: 1e-3, most_controls: 20 }),
///     weights: None,
///     spec: FitSpec { regularization: Regularization::None, ..FitSpec::new(Model::Linear) },
/// };
/// let near = curve(&points, &settings)?;
/// assert_eq!(near.stop, Some(Stop::Tolerance));
/// assert!(near.max_error <= 1e-3);
/// let middle = near.curve.value(0.5);
/// assert!((middle.x.hypot(middle.y) - 20.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn curve(points: &CurvePoints, asked: &CurveSettings) -> Result<CurveFit, FitError> {
    let dimension = check(points, asked)?;
    let parameters = parameters(points)?;
    let trial = Trial { points, asked, dimension, parameters: &parameters };
    // points of weight 0 say nothing, of the knots neither
    let counted: Vec<f64> = parameters.iter().enumerate().filter(|(k, _)| points.counts(*k)).map(|(_, &t)| t).collect();
    if counted.is_empty() && !parameters.is_empty() && points.weight.is_some_and(|w| w.iter().all(|w| *w == 0.0)) {
        return Err(Faults::one("method.weight", "every point is of weight 0").into());
    }
    let (low, high) = counted.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &t| (a.min(t), b.max(t)));
    let (fitted, steps, stop) = match &asked.knots {
        KnotPlacement::Given(knots) => (trial.fit(Knots::Curve(knots.clone()))?, Vec::new(), None),
        KnotPlacement::Spans(spans) => {
            let domain = asked.spec.domain.and_then(|domain| domain.u).unwrap_or([low, high]);
            let basis = uniform(asked.degree, *spans, domain)?;
            (trial.fit(Knots::Curve(basis.knots().to_vec()))?, Vec::new(), None)
        }
        KnotPlacement::Averaged { controls } => {
            if *controls > counted.len() {
                let points = counted.len();
                let message = format_args!("{controls} control points cannot be determined from {points} points");
                return Err(Faults::one("method.control_count", message).into());
            }
            let knots = averaging_least_squares(asked.degree, &counted, *controls)
                .map_err(|faults| of_knots(points, faults))?;
            (trial.fit(Knots::Curve(knots))?, Vec::new(), None)
        }
        KnotPlacement::Adaptive(adaptive) => {
            let (fitted, steps, stop) = adaptive::place(&trial, adaptive, [low, high])?;
            (fitted, steps, Some(stop))
        }
    };
    let curve = trial.shape(&fitted)?;
    let Fitted { basis: _, mut results, errors, spec } = fitted;
    if !asked.spec.include.residuals {
        for result in &mut results {
            result.residuals.values = None;
            result.residuals.node_indices = None;
        }
    }
    let (max_error, rms_error) = summary(&errors);
    Ok(CurveFit { curve, parameters, results, spec, max_error, rms_error, steps, stop })
}

fn check(points: &CurvePoints, asked: &CurveSettings) -> Result<Dimension, Faults> {
    let Some(dimension) = Dimension::of(points.coordinates.len()) else {
        return Err(Faults::one("points", "a curve has one, two or three coordinates"));
    };
    let mut faults = Faults::default();
    let count = points.coordinates[0].len();
    for (c, y) in points.coordinates.iter().enumerate() {
        if y.len() != count {
            faults.push("points", format_args!("coordinate {c} has {}, the first one {count}", entries(y.len())));
        }
        for (k, x) in y.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
            faults.push(place(points, k, c), format_args!("{x} is not a finite number"));
        }
    }
    if dimension == Dimension::Graph && matches!(points.parameters, Parameters::By(_)) {
        faults.push("points.parametrization", "the parameter of a graph y(x) is x");
    }
    if let Parameters::Given(given) = points.parameters
        && given.len() != count
    {
        faults.push("points", format_args!("{} for {count} points", counted(given.len(), "parameter", "parameters")));
    }
    if let Some(weight) = points.weight
        && weight.len() != count
    {
        faults.push("method.weight", format_args!("{} for {count} points", entries(weight.len())));
    }
    if asked.degree > HIGHEST_DEGREE {
        faults.append(degree_too_high("model.degree", asked.degree));
    }
    if !asked.spec.filters.is_empty() {
        faults.push("filters", "points of a curve are not filtered");
    }
    if asked.spec.node_uncertainty.is_some_and(|uncertainty| uncertainty.kind.is_some()) {
        faults.push("node_uncertainty.position_kind", POSITIONS_EXACT);
    }
    requested_models(&asked.spec).for_each(|path| faults.push(path, WHITE_ONLY));
    if matches!(asked.knots, KnotPlacement::Adaptive(_)) && asked.weights.is_some() {
        faults.push(
            "model.weights",
            "with knots placed by residuals the number of control points is not known beforehand",
        );
    }
    faults.into_result(dimension)
}

fn parameters(points: &CurvePoints) -> Result<Vec<f64>, Faults> {
    match points.parameters {
        Parameters::Given(given) => Ok(given.to_vec()),
        Parameters::By(by) => {
            let at = |k: usize| Vector::from_fn(|c, _| points.coordinates.get(c).map_or(0.0, |x| x[k]));
            let places: Vec<Vector> = (0..points.coordinates[0].len()).map(at).collect();
            by.parameters(&places).map_err(|faults| of_parameters(points, faults))
        }
    }
}
