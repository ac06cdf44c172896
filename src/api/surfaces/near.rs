//! Surfaces near nodes: the full fit if its spectrum is affordable, the banded one for more
//! coefficients.

use super::{methods::Requested, result::BuiltSurfaceBody};
use crate::api::{
    curves::near_result::{BandedFitBody, CoordinateFitBody, CoordinateResidualsBody, PenaltyBody},
    faults::Faults,
    fits::{answer::FitResultBody, canonical},
    json::{gather::gathered, writer::whole},
    problem::Problem,
    shapes::{fault::refused, places::out_of_range},
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::{
        self, FitSpec, Nodes, Plans,
        near::{self, Shape, SurfaceFit, SurfaceInclude, SurfacePoints},
        spec::{Degree, Estimator, Include, Knots, Model, Regularization, Scaling},
    },
    geometry::surface::{SurfaceShape, construct::Method, least_squares::AxisKnots},
};

/// Number of coefficients up to which the full fit is used: above, its spectrum costs too much.
const FEW: usize = 150;

/// Fits the B-spline that was asked for to nodes with u and v, which stand at `base` in the
/// request.
pub fn build(
    nodes: &Nodes,
    requested: Requested,
    mut spec: FitSpec,
    plans: &Plans,
    base: &str,
) -> Result<Vec<u8>, Problem> {
    if matches!(nodes, Nodes::Curve(_) | Nodes::Matrix(_)) {
        return refuse(&format!("{base}/type"), "a surface needs nodes with u and v");
    }
    let Method::BSplineLeastSquares { degrees, knots } = requested.method else {
        return refuse("/method", "scattered nodes and grids with missing nodes need `b_spline_least_squares`");
    };
    let count = |axis: usize| match &knots[axis] {
        AxisKnots::Given(knots) => knots.len().saturating_sub(degrees[axis] + 1),
        AxisKnots::Uniform(spans) | AxisKnots::Spans(spans) => spans.saturating_add(degrees[axis]),
    };
    let size = count(0).saturating_mul(count(1));
    spec.model = Model::BSpline {
        // a number for both axes is at fault as such
        degree: if degrees[0] == degrees[1] { Degree::Both(degrees[0]) } else { Degree::Each(degrees[0], degrees[1]) },
        knots: match knots {
            [AxisKnots::Given(u), AxisKnots::Given(v)] => Knots::Surface(u, v),
            [AxisKnots::Uniform(u), AxisKnots::Uniform(v)] if u == v => Knots::Spans(u),
            [AxisKnots::Uniform(u), AxisKnots::Uniform(v)] => Knots::SpansEach(u, v),
            _ => return refuse("/method/placed_spans", "placed knots need a grid without missing nodes"),
        },
        weights: None,
    };
    if size > FEW && is_banded(&spec) {
        return banded(nodes, &spec, base);
    }
    let result = estimation::fit_remembering(nodes, &spec, plans).map_err(|error| refused(error, base))?;
    let Some(Shape::Surface(shape)) = near::shape_of(&spec, &result) else {
        return Err(Problem::internal("a fit of a B-spline surface is none"));
    };
    let fit = FitResultBody::new(&result, None, canonical::input_sha256(nodes, &spec));
    let body = BuiltSurfaceBody {
        fits: Some(vec![CoordinateFitBody { coordinate: "z".into(), result: fit }]),
        ..BuiltSurfaceBody::new(&shape, None)
    };
    whole(&body).map(gathered).map_err(|_| out_of_range(base))
}

/// Whether the fit of many coefficients knows all that is asked for.
fn is_banded(spec: &FitSpec) -> bool {
    let penalty = matches!(
        spec.regularization,
        Regularization::None | Regularization::Ridge { .. } | Regularization::Tikhonov(_)
    );
    penalty
        && spec.estimator == Estimator::LeastSquares
        && spec.filters.is_empty()
        && spec.scaling != Scaling::Standardized
        && spec.node_uncertainty.is_none()
        && spec.coefficient_norm_limit.is_none()
        && spec.include == Include { residuals: spec.include.residuals, ..Include::default() }
}

fn banded(nodes: &Nodes, spec: &FitSpec, base: &str) -> Result<Vec<u8>, Problem> {
    let (u, v, z, weight) = scattered(nodes)?;
    let coordinates = [z];
    let points = SurfacePoints { u: &u, v: &v, coordinates: &coordinates, weight: weight.as_deref() };
    // without a penalty they come with the factorisation, with one each asks for a solution
    let standard_errors = spec.regularization == Regularization::None;
    let include = SurfaceInclude { standard_errors, residuals: spec.include.residuals };
    let fit = near::surface(&points, spec, include).map_err(|error| refused(error, base))?;
    let built = BuiltSurfaceBody::new(&SurfaceShape::BSpline(fit.surface.clone()), None);
    let warnings = fit.warnings.iter().map(WarningBody::from).collect();
    let body = BuiltSurfaceBody { banded_fit: Some(fit.into()), warnings, ..built };
    whole(&body).map_err(|_| out_of_range(base))
}

impl From<SurfaceFit> for BandedFitBody {
    fn from(fit: SurfaceFit) -> Self {
        let [_, v] = fit.surface.bases();
        let (spans, controls) = (v.distinct_knots().len() - 1, v.size());
        let coordinate = |residuals: near::Coordinate| CoordinateResidualsBody {
            coordinate: "z".into(),
            rss: residuals.rss,
            rms: residuals.rms,
            max_abs: residuals.max_abs,
            sigma: residuals.sigma,
            std_errors: residuals.standard_errors.map(|errors| errors.chunks(controls).map(<[f64]>::to_vec).collect()),
            values: residuals.residuals,
        };
        BandedFitBody {
            count: fit.count,
            degrees_of_freedom: fit.degrees_of_freedom,
            effective_degrees_of_freedom: fit.effective_degrees_of_freedom,
            condition: fit.condition,
            coordinates: fit.coordinates.into_iter().map(coordinate).collect(),
            nodes_per_span: fit.nodes_per_span.chunks(spans).map(<[usize]>::to_vec).collect(),
            empty_spans: fit.empty_spans,
            penalty: fit.regularization.map(|weight| PenaltyBody {
                lambda: weight.lambda,
                criterion: weight.criterion,
                reached: weight.reached,
            }),
            arithmetic: fit.arithmetic,
            corrections: fit.corrections,
            last_correction: fit.last_correction,
        }
    }
}

type Columns = (Vec<f64>, Vec<f64>, Vec<f64>, Option<Vec<f64>>);

/// Nodes with u and v one by one; missing ones are left out.
fn scattered(nodes: &Nodes) -> Result<Columns, Problem> {
    match nodes {
        Nodes::Scattered(nodes) => {
            Ok((nodes.u().to_vec(), nodes.v().to_vec(), nodes.z().to_vec(), nodes.weight().map(<[f64]>::to_vec)))
        }
        Nodes::Grid(grid) => {
            let columns = grid.v().len();
            let counted = |k: &usize| !grid.z()[*k].is_nan() && grid.valid().as_ref().is_none_or(|valid| valid[*k]);
            let places: Vec<usize> = (0..grid.z().len()).filter(counted).collect();
            let of = |value: &dyn Fn(usize) -> f64| places.iter().map(|k| value(*k)).collect::<Vec<_>>();
            let weight = grid.weight().as_ref().map(|weight| of(&|k| weight[k]));
            Ok((of(&|k| grid.u()[k / columns]), of(&|k| grid.v()[k % columns]), of(&|k| grid.z()[k]), weight))
        }
        Nodes::Curve(_) | Nodes::Matrix(_) => refuse("/nodes/type", "a surface needs nodes with u and v"),
    }
}

fn refuse<T>(pointer: &str, detail: &str) -> Result<T, Problem> {
    Err(Problem::invalid(Faults::one(pointer, detail)))
}
