//! B-spline and NURBS curves near points: y(x), or points of plane or space over a parameter, each
//! coordinate a fit of the service with the same measurement matrix.
//!
//! Knots are given, uniform, averaged by the parameters (Piegl and Tiller, Eqs. 9.68 and 9.69), or
//! placed by the residuals ([`super::adaptive`]). Estimator, regularisation, scaling and
//! diagnostics are those of the [`FitSpec`] handed over, its model aside. Errors are distances at
//! equal parameters.

use super::fault::{CurveFaults, CurveField, CurveRefused};
use super::{
    adaptive::{self, Adaptive, Step, Stop},
    swing::Swing,
};
use crate::estimation::fault::{Faults, Field, NodeList};
use crate::{
    estimation::{
        data::Nodes,
        error::FitError,
        fit::fit_together,
        result::FitResult,
        spec::{Degree, FitSpec, Include, Knots, Model},
    },
    fault::words,
    geometry::{
        BSplineBasis,
        curve::{
            BSplineCurve,
            fault::{CurveFault, Part},
            knots::averaging_least_squares,
            parametrization::Parametrization,
        },
        space::{ControlFault, Dimension, HIGHEST_DEGREE, Vector},
    },
    numerics::cancel,
};

/// Points and where on the curve they belong.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoints<'a> {
    /// y alone, or x and y, or x, y and z.
    pub coordinates: &'a [Vec<f64>],
    pub parameters: Parameters<'a>,
    /// Ω of least squares; 0 leaves a point out.
    pub weight: Option<&'a [f64]>,
}

/// The parameter of every point.
#[derive(Clone, Copy, Debug)]
pub enum Parameters<'a> {
    /// x of a graph, or parameters of points; in any order but for averaged knots.
    Given(&'a [f64]),
    /// From the points themselves; not for graphs.
    By(Parametrization),
}

/// Where knots come from.
#[derive(Clone, Debug, PartialEq)]
pub enum KnotPlacement {
    /// A full knot vector.
    Given(Vec<f64>),
    /// So many equal spans over the parameters.
    Spans(usize),
    /// So many control points, about as many parameters in every span.
    Averaged {
        controls: usize,
    },
    Adaptive(Adaptive),
}

/// What is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSettings {
    pub degree: usize,
    pub knots: KnotPlacement,
    /// Weights of NURBS, one per control point; not with adaptive knots, whose number is not known.
    pub weights: Option<Vec<f64>>,
    /// Everything else; its model is not looked at.
    pub spec: FitSpec,
}

/// A curve near points.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveFit {
    pub curve: BSplineCurve,
    /// One per point.
    pub parameters: Vec<f64>,
    /// One fit per coordinate, with the model that was used.
    pub results: Vec<FitResult>,
    /// The spec of those fits.
    pub spec: FitSpec,
    /// Largest and root mean square distance of counted points from the curve, at their parameters
    /// (unweighted).
    pub max_error: f64,
    pub rms_error: f64,
    /// The knots tried up to the best, which are those of the curve, where they were placed by
    /// residuals; and why they are the best.
    pub steps: Vec<Step>,
    pub stop: Option<Stop>,
}

impl CurveFit {
    /// How far the curve swings out between neighbouring points at worst: how far it leaves the box
    /// of its places at their parameters, over the extent of all points. Above [`super::WILD`] it
    /// is no curve near the `points` it was fitted to, whatever the residuals say.
    pub fn swing(&self, points: &CurvePoints) -> f64 {
        let counted = self.parameters.iter().enumerate().filter(|(k, _)| points.counts(*k));
        let mut distinct: Vec<f64> = counted.map(|(_, t)| *t).collect();
        distinct.sort_by(cancel::comparing(f64::total_cmp));
        distinct.dedup();
        Swing::of(points, &distinct).out(&self.curve)
    }
}

impl CurvePoints<'_> {
    /// Points of weight 0 say nothing.
    pub(super) fn counts(&self, k: usize) -> bool {
        self.weight.is_none_or(|weight| weight.get(k).is_none_or(|w| *w > 0.0))
    }
}

/// Fits one curve of all coordinates.
pub fn curve(points: &CurvePoints, asked: &CurveSettings) -> Result<CurveFit, CurveRefused> {
    let dimension = check(points, asked)?;
    let parameters = parameters(points)?;
    let trial = Trial { points, asked, dimension, parameters: &parameters };
    // points of weight 0 say nothing, of the knots neither
    let counted: Vec<f64> = parameters.iter().enumerate().filter(|(k, _)| points.counts(*k)).map(|(_, &t)| t).collect();
    if counted.is_empty() && !parameters.is_empty() && points.weight.is_some_and(|w| w.iter().all(|w| *w == 0.0)) {
        return Err(CurveFaults::one(CurveField::Weights, "every point is of weight 0").into());
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
                let detail = format!("{controls} control points cannot be told from so few points, {}", counted.len());
                return Err(CurveFaults::one(CurveField::ControlCount, detail).into());
            }
            let knots = averaging_least_squares(asked.degree, &counted, *controls)
                .map_err(|fault| curve_fault(points, &fault))?;
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

/// Largest and root mean square.
pub fn summary(errors: &[(usize, f64)]) -> (f64, f64) {
    let squares: f64 = errors.iter().map(|(_, e)| e * e).sum();
    (errors.iter().map(|(_, e)| *e).fold(0.0, f64::max), (squares / errors.len().max(1) as f64).sqrt())
}

/// Equal spans.
pub fn uniform(degree: usize, spans: usize, [low, high]: [f64; 2]) -> Result<BSplineBasis, CurveFaults> {
    if spans == 0 {
        return Err(CurveFaults::one(Field::Spans, "at least one span"));
    }
    if spans.saturating_add(degree) > crate::estimation::design::MOST_COEFFICIENTS {
        return Err(CurveFaults::one(Field::Spans, format!("{spans} spans are more than a fit may have")));
    }
    BSplineBasis::uniform(degree, spans, low, high).map_err(|fault| CurveFaults::one(Field::Spans, fault.to_string()))
}

/// The points with everything but the knots.
pub struct Trial<'a> {
    pub points: &'a CurvePoints<'a>,
    pub asked: &'a CurveSettings,
    pub dimension: Dimension,
    pub parameters: &'a [f64],
}

/// All coordinates with one knot vector.
pub struct Fitted {
    pub basis: BSplineBasis,
    pub results: Vec<FitResult>,
    /// Posted number and distance of every counted point.
    pub errors: Vec<(usize, f64)>,
    pub spec: FitSpec,
}

impl Trial<'_> {
    /// The curve that the coefficients of all coordinates are the control points of.
    pub fn shape(&self, fitted: &Fitted) -> Result<BSplineCurve, CurveRefused> {
        let coordinate =
            |i: usize, c: usize| fitted.results.get(c).map_or(0.0, |result: &FitResult| result.coefficients[i].value);
        let controls = (0..fitted.basis.size()).map(|i| Vector::from_fn(|c, _| coordinate(i, c))).collect();
        BSplineCurve::new(fitted.basis.clone(), self.dimension, controls, self.asked.weights.clone())
            .map_err(|fault| CurveFaults::one(CurveField::Curve, fault.to_string()).into())
    }

    /// Fits with these knots.
    pub fn fit(&self, knots: Knots) -> Result<Fitted, CurveRefused> {
        let Knots::Curve(full) = &knots else {
            return Err(CurveFaults::one(Field::Knots, "one knot vector").into());
        };
        let basis = BSplineBasis::new(self.asked.degree, full.clone())
            .map_err(|fault| CurveFaults::one(fault.index().map_or(Field::Knots, Field::Knot), fault.to_string()))?;
        let degree = Degree::Both(self.asked.degree);
        let include = Include { residuals: true, ..self.asked.spec.include };
        let model = Model::BSpline { degree, knots, weights: self.asked.weights.clone() };
        let spec = FitSpec { model, include, ..self.asked.spec.clone() };
        let weight = self.points.weight.map(<[f64]>::to_vec);
        let nodes = self
            .points
            .coordinates
            .iter()
            .map(|y| Nodes::curve(self.parameters.to_vec(), y.clone(), weight.clone()))
            .collect::<Result<Vec<Nodes>, Faults>>()
            .map_err(|faults| translated(self.points, faults))?;
        let results = fit_together(&nodes, &spec).map_err(|error| match error {
            FitError::Invalid(faults) => translated(self.points, faults).into(),
            other => CurveRefused::Fit(other),
        })?;
        let mut squares = Vec::new();
        for result in &results {
            let values = result.residuals.values.as_deref().unwrap_or_default();
            squares.resize(values.len(), 0.0);
            squares.iter_mut().zip(values).for_each(|(sum, r)| *sum += r * r);
        }
        let counted = results.first().and_then(|result| result.residuals.node_indices.clone());
        let errors = squares
            .iter()
            .enumerate()
            .map(|(k, square)| (counted.as_ref().map_or(k, |counted| counted[k]), square.sqrt()))
            .collect();
        Ok(Fitted { basis, results, errors, spec })
    }
}

fn check(points: &CurvePoints, asked: &CurveSettings) -> Result<Dimension, CurveFaults> {
    let Some(dimension) = Dimension::of(points.coordinates.len()) else {
        return Err(CurveFaults::one(CurveField::Points, "one, two or three coordinates make a curve"));
    };
    let mut faults = CurveFaults::default();
    let count = points.coordinates[0].len();
    for (c, y) in points.coordinates.iter().enumerate() {
        if y.len() != count {
            faults.push(
                CurveField::Points,
                format!("coordinate {c} has {}, the first one {count}", words::entries(y.len())),
            );
        }
        for (k, x) in y.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
            faults.push(place(points, k, Some(c)), format!("{x} is not a finite number"));
        }
    }
    if dimension == Dimension::Graph && matches!(points.parameters, Parameters::By(_)) {
        faults.push(CurveField::Parametrization, "a graph y(x) has x for its parameter");
    }
    if let Parameters::Given(given) = points.parameters
        && given.len() != count
    {
        faults.push(
            CurveField::Points,
            format!("{} for {count} points", words::counted(given.len(), "parameter", "parameters")),
        );
    }
    if let Some(weight) = points.weight
        && weight.len() != count
    {
        faults.push(CurveField::Weights, format!("{} for {count} points", words::entries(weight.len())));
    }
    if asked.degree > HIGHEST_DEGREE {
        faults.push(Field::Degree, ControlFault::Degree { degree: asked.degree }.to_string());
    }
    if !asked.spec.filters.is_empty() {
        faults.push(Field::Filters, "points of a curve are not filtered");
    }
    if matches!(asked.knots, KnotPlacement::Adaptive(_)) && asked.weights.is_some() {
        faults.push(
            Field::ControlWeights,
            "with knots placed by residuals the number of control points is not known beforehand",
        );
    }
    faults.into_result(dimension)
}

/// Coordinate `c` of point `k`; without a coordinate its parameter.
fn place(points: &CurvePoints, k: usize, c: Option<usize>) -> CurveField {
    match (points.coordinates.len(), c, points.parameters) {
        (1, None, _) => CurveField::Abscissa(k),
        (1, Some(_), _) => CurveField::Ordinate(k),
        (_, None, Parameters::Given(_)) => CurveField::Parameter(k),
        (_, None, Parameters::By(_)) => CurveField::Point(k),
        (_, Some(c), _) => CurveField::Coordinate(k, c),
    }
}

fn parameters(points: &CurvePoints) -> Result<Vec<f64>, CurveFaults> {
    match points.parameters {
        Parameters::Given(given) => Ok(given.to_vec()),
        Parameters::By(by) => {
            let at = |k: usize| Vector::from_fn(|c, _| points.coordinates.get(c).map_or(0.0, |x| x[k]));
            let places: Vec<Vector> = (0..points.coordinates[0].len()).map(at).collect();
            by.parameters(&places).map_err(|fault| curve_fault(points, &fault))
        }
    }
}

fn curve_fault(points: &CurvePoints, fault: &CurveFault) -> CurveFaults {
    let field = match (fault.part(), fault.indices().first().copied()) {
        (Some(Part::Controls), _) => CurveField::ControlCount,
        (Some(Part::Degree), _) => Field::Degree.into(),
        (_, Some(k)) => place(points, k, None),
        (_, None) => CurveField::Points,
    };
    CurveFaults::one(field, fault.to_string())
}

/// Faults of the fit of a coordinate, as those of the curve.
fn translated(points: &CurvePoints, faults: Faults) -> CurveFaults {
    faults.placed(|field| match field {
        Field::Entry(NodeList::X, k) => place(points, k, None),
        Field::Entry(NodeList::Weight, k) => CurveField::Weight(k),
        field if field.is_of_nodes() => CurveField::Points,
        field => CurveField::Fit(field),
    })
}
