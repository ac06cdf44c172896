//! Curves near points: least squares by the fit of the service, coordinate by coordinate, and
//! smoothing splines.

use super::{
    methods::{BSplineLeastSquaresCurveMethod, NearMethod, SmoothingSplineCurveMethod},
    near_result::{
        CoordinateFitBody, CoordinateResidualsBody, KnotInsertionBody, KnotInsertionStep, KnotInsertionStop,
        SmoothingBody,
    },
    points::GivenPoints,
    result::BuiltCurveBody,
};
use crate::api::{
    faults::Faults,
    fits::{answer::FitResultBody, canonical},
    json::{gather::gathered, writer::whole},
    problem::Problem,
    shapes::{fault::refused, places::out_of_range},
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::{
        FitSpec, Nodes,
        near::{self, Adaptive, CurveFit, CurvePoints, CurveSettings, KnotPlacement, Parameters, Stop},
        result::Warning,
        smoothing::{Smoothing, SmoothingSpline, smoothing_spline, spline},
        spec::{Criterion, Parameter},
    },
    geometry::curve::{Curve, CurveShape, Points},
    words::rounded,
};

/// Spans that adaptive knots begin with, and control points that they end with at most.
const FIRST_SPANS: usize = 1;
const MOST_CONTROLS: usize = 200;

/// Coordinates of points, each on its own.
struct Columns {
    names: &'static [&'static str],
    values: Vec<Vec<f64>>,
}

impl Columns {
    fn of(points: &Points) -> Self {
        match points {
            Points::Graph { y, .. } => Columns { names: &["y"], values: vec![y.clone()] },
            Points::Space { points, dimension, .. } => {
                let names = &["x", "y", "z"][..dimension.count()];
                Columns { names, values: (0..names.len()).map(|c| points.iter().map(|p| p[c]).collect()).collect() }
            }
        }
    }
}

/// Builds the curve. Processor work.
pub fn build(given: &GivenPoints, method: NearMethod, spec: FitSpec) -> Result<Vec<u8>, Problem> {
    match method {
        NearMethod::BSpline(method) => {
            let knots = placement(&method)?;
            let weight = method.weight.or_else(|| given.weight.clone());
            least_squares(given, weight, CurveSettings { degree: method.degree, knots, weights: None, spec })
        }
        NearMethod::Nurbs(method) => {
            let (knots, weights) = (KnotPlacement::Given(method.knots), Some(method.weights));
            let weight = method.weight.or_else(|| given.weight.clone());
            least_squares(given, weight, CurveSettings { degree: method.degree, knots, weights, spec })
        }
        NearMethod::Smoothing(method) => smoothed(given, &method),
    }
}

/// Returns the placement of the knots.
fn placement(method: &BSplineLeastSquaresCurveMethod) -> Result<KnotPlacement, Problem> {
    let BSplineLeastSquaresCurveMethod { knots, spans, control_count, tolerance, .. } = method;
    match (knots, spans, control_count, tolerance) {
        (Some(knots), None, None, None) => Ok(KnotPlacement::Given(knots.clone())),
        (None, Some(spans), None, None) => Ok(KnotPlacement::Spans(*spans)),
        (None, None, Some(controls), None) => Ok(KnotPlacement::Averaged { controls: *controls }),
        (None, None, None, Some(tolerance)) => Ok(KnotPlacement::Adaptive(Adaptive {
            spans: FIRST_SPANS,
            tolerance: *tolerance,
            most_controls: MOST_CONTROLS.max(method.degree.saturating_add(FIRST_SPANS)),
        })),
        _ => Err(Problem::invalid(Faults::one(
            "/method",
            "give exactly one of `knots`, `spans`, `control_count` and `tolerance`",
        ))),
    }
}

fn least_squares(given: &GivenPoints, weight: Option<Vec<f64>>, settings: CurveSettings) -> Result<Vec<u8>, Problem> {
    let columns = Columns::of(&given.points);
    let points = CurvePoints {
        coordinates: &columns.values,
        parameters: match &given.points {
            Points::Graph { x, .. } => Parameters::Given(x),
            Points::Space { parametrization, .. } => Parameters::By(*parametrization),
        },
        weight: weight.as_deref(),
    };
    let fit = near::curve(&points, &settings).map_err(|error| refused(error, "/points"))?;
    let CurveFit { curve, parameters, results, spec, max_error: _, rms_error: _, steps, stop } = &fit;
    let mut fits = Vec::with_capacity(results.len());
    for ((result, heights), name) in results.iter().zip(&columns.values).zip(columns.names) {
        let nodes = Nodes::curve(parameters.clone(), heights.clone(), weight.clone())
            .map_err(|found| Problem::invalid(Faults::of_engine("/nodes", &found)))?;
        let result = FitResultBody::new(result, None, canonical::input_sha256(&nodes, spec));
        fits.push(CoordinateFitBody { coordinate: (*name).into(), result });
    }
    let mut warnings = match stop {
        Some(Stop::Tolerance) | None => Vec::new(),
        Some(_) => {
            let message = format!(
                "a point is still {} off the curve; `knot_insertion` says why no more knots were inserted",
                rounded(fit.max_error, 4)
            );
            vec![WarningBody::new("tolerance_not_met", message)]
        }
    };
    let swing = fit.swing(&points);
    if swing > near::WILD {
        let message = format!(
            "between the points the curve overshoots by {swing:.1} times their extent: use fewer control points, or \
             regularise"
        );
        warnings.push(WarningBody::new("swings_out", message));
    }
    let parametric = curve.dimension().is_parametric();
    let body = BuiltCurveBody {
        parameters: parametric.then(|| parameters.clone()),
        fits: Some(fits),
        knot_insertion: stop.map(|stop| KnotInsertionBody {
            stop: stop.into(),
            steps: steps.iter().map(KnotInsertionStep::from).collect(),
        }),
        warnings,
        ..BuiltCurveBody::new(&CurveShape::BSpline(curve.clone()))
    };
    whole(&body).map(gathered).map_err(|_| out_of_range("/points"))
}

impl From<&near::Step> for KnotInsertionStep {
    fn from(step: &near::Step) -> Self {
        let mut distinct = step.knots.clone();
        distinct.dedup();
        KnotInsertionStep { spans: distinct.len() - 1, max_error: step.max_error, rms: step.rms_error }
    }
}

impl From<Stop> for KnotInsertionStop {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Tolerance => KnotInsertionStop::ToleranceMet,
            Stop::TooFewPoints => KnotInsertionStop::TooFewPoints,
            Stop::MostControls | Stop::MostSteps => KnotInsertionStop::LimitReached,
        }
    }
}

fn smoothed(given: &GivenPoints, method: &SmoothingSplineCurveMethod) -> Result<Vec<u8>, Problem> {
    let columns = Columns::of(&given.points);
    let own;
    let x = match &given.points {
        Points::Graph { x, .. } => x,
        Points::Space { points, parametrization, .. } => {
            own = parametrization
                .parameters(points)
                .map_err(|found| Problem::invalid(Faults::placed(&found, |_| "/points/xyz".to_owned())))?;
            &own
        }
    };
    let smoothing = match (&method.parameter, method.degrees_of_freedom) {
        (Some(_), Some(_)) => {
            let detail = "give either `parameter` or `degrees_of_freedom`, not both";
            return Err(Problem::invalid(Faults::one("/method/degrees_of_freedom", detail)));
        }
        (None, Some(degrees)) => Smoothing::EffectiveDegrees(degrees),
        (None, None) => Smoothing::Parameter(Parameter::Criterion(Criterion::Gcv)),
        (Some(parameter), None) => {
            if let Parameter::Criterion(criterion) = parameter {
                let refused = |message| Problem::invalid(Faults::one("/method/parameter/criterion", message));
                criterion.check_among(&[]).map_err(refused)?;
            }
            Smoothing::Parameter(*parameter)
        }
    };
    let weight = method.weight.as_ref().or(given.weight.as_ref());
    let points = spline::Points { x, coordinates: &columns.values, weight: weight.map(Vec::as_slice) };
    let settings = spline::SmoothingSpec { smoothing, noise_sigma: method.noise_sigma, pointwise: false };
    let spline = smoothing_spline(&points, &settings).map_err(Problem::invalid)?;
    let warnings = if spline.found.reached {
        Vec::new()
    } else {
        vec![WarningBody::from(&Warning::LambdaAtLimit { parameter: "λ" })]
    };
    let body = BuiltCurveBody {
        parameters: (columns.names.len() > 1).then(|| x.clone()),
        smoothing: Some(smoothing_body(&spline, columns.names)),
        warnings,
        ..BuiltCurveBody::new(&CurveShape::BSpline(spline.curve.clone()))
    };
    whole(&body).map_err(|_| out_of_range("/points"))
}

fn smoothing_body(spline: &SmoothingSpline, names: &'static [&'static str]) -> SmoothingBody {
    let coordinate = |(c, name): (usize, &&'static str)| CoordinateResidualsBody {
        coordinate: (*name).into(),
        rss: spline.rss[c],
        rms: spline.rms[c],
        max_abs: spline.max_abs[c],
        sigma: spline.sigma[c],
        std_errors: None,
        values: None,
    };
    SmoothingBody {
        lambda: spline.lambda,
        criterion: spline.found.criterion,
        reached: spline.found.reached,
        effective_degrees_of_freedom: spline.effective_degrees_of_freedom,
        count: spline.count,
        abscissae: spline.abscissae,
        coordinates: names.iter().enumerate().map(coordinate).collect(),
    }
}
