//! Tensor B-spline surfaces near many scattered points: z(u, v), or (x, y, z) over (u, v) with one
//! matrix for all coordinates.
//!
//! Other fits analyse the whole spectrum; here, with thousands of coefficients, the result has what
//! a banded factorisation gives: coefficients to the same digits, residuals, σ̂, the condition of
//! the Fisher information matrix on columns of unit length, standard errors, and the number of
//! nodes in every cell. Regularisation is none, ridge (`k‖Â‖²` in columns of unit length, or in the
//! caller's with scaling `none`) or Tikhonov with the penalty of other fits; λ may be given or
//! found by `gcv`, `discrepancy`, `l_curve` or `min_mse` (the latter of fitted values). Several
//! coordinates share λ.

pub use super::surface_report::{Coordinate, SurfaceFit, SurfaceInclude, Weight};

use super::{
    settings::WHITE_ONLY,
    surface_report::{self, Problem},
};
use crate::{
    banded::{
        cells::{Cells, Places},
        penalty::penalty,
        pieces::{HIGHEST_DEGREE, Pieces},
        system::{Penalty, System, Unsolved},
        weight::{choose, trace_of},
    },
    data::negative_weight,
    design::{Axis, splines},
    error::{FitError, Unconverged},
    fit::requested_models,
    smoothing::choice::{ChosenLambda, Smoothing},
    spec::{Degree, Domain, Estimator, FitSpec, HIGHEST_ORDER, Model, Regularization, Scaling},
};
use flankfit_geometry::BSplineBasis;
use flankfit_numerics::{
    band_cholesky::SymmetricBand,
    check::Faults,
    words::{Shown, entries},
};

/// Coefficients at most, numbers of the banded matrix at most, and operations of its factorisation
/// at most.
const MOST_COEFFICIENTS: usize = 40_000;
const MOST_NUMBERS: usize = 20_000_000;
const MOST_OPERATIONS: f64 = 2e10;

/// Points over two parameters.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoints<'a> {
    /// First parameter of each point.
    pub u: &'a [f64],
    /// Second parameter of each point.
    pub v: &'a [f64],
    /// z alone, or x, y and z.
    pub coordinates: &'a [Vec<f64>],
    /// Ω of least squares; 0 leaves a point out. All weigh 1 by default.
    pub weight: Option<&'a [f64]>,
}

impl SurfacePoints<'_> {
    fn list(&self, coordinate: usize) -> &'static str {
        if self.coordinates.len() == 1 { "z" } else { ["x", "y", "z"][coordinate.min(2)] }
    }
}

/// Fits the `b_spline` of `spec` to scattered points.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec,
///     near::{SurfaceInclude, SurfacePoints, surface},
///     spec::{Degree, Knots, Model, Regularization},
/// };
/// use flankfit_geometry::surface::Surface;
///
/// // 500 scattered points of z = u v + u².
/// let u: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.618_034).fract()).collect();
/// let v: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.414_214).fract()).collect();
/// let z = vec![u.iter().zip(&v).map(|(u, v)| u * v + u * u).collect()];
/// let points = SurfacePoints { u: &u, v: &v, coordinates: &z, weight: None };
/// let model = Model::BSpline { degree: Degree::Both(2), knots: Knots::Spans(5), weights: None };
/// let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
/// let near = surface(&points, &spec, SurfaceInclude::default())?;
/// assert!(near.coordinates[0].rms < 1e-13);
/// assert!((near.surface.value(0.3, 0.7).x - 0.3).abs() < 1e-12);
/// assert_eq!((near.count, near.empty_spans), (500, 0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn surface(points: &SurfacePoints, spec: &FitSpec, include: SurfaceInclude) -> Result<SurfaceFit, FitError> {
    check_spec(spec)?;
    check_points(points)?;
    if points.weight.is_some_and(|w| w.iter().all(|w| *w == 0.0)) {
        return Err(Faults::one("nodes.weight", "every node is of weight 0").into());
    }
    let bases = bases(points, spec)?;
    check_size(&bases)?;
    // the narrower axis runs fastest, so that the band is narrow
    let swapped = bases[0].degree() * bases[1].size() + bases[1].degree()
        > bases[1].degree() * bases[0].size() + bases[0].degree();
    let [a, b] = &bases;
    let (ordered, places) =
        if swapped { ([b.clone(), a.clone()], (points.v, points.u)) } else { (bases.clone(), (points.u, points.v)) };
    let places = Places { u: places.0, v: places.1, heights: points.coordinates, weight: points.weight };
    let cells = Cells::new(&places, &Pieces::new(&ordered[0]), &Pieces::new(&ordered[1]));
    let system = System::new(cells, ordered.clone());
    let matrix = penalty_of(spec, &system, &ordered, swapped)?;
    let n = system.size();
    if matrix.is_none() && n > system.cells.count() {
        return Err(Faults::one(
            "model",
            format_args!(
                "{n} coefficients cannot be determined from {} counted nodes: use fewer spans, or `tikhonov`",
                system.cells.count()
            ),
        )
        .into());
    }
    let variance = spec.noise_sigma.map(|s| s * s);
    let found = match (&matrix, &spec.regularization) {
        (Some(matrix), Regularization::Ridge { parameter }) => Some((matrix, *parameter)),
        (Some(matrix), Regularization::Tikhonov(asked)) => Some((matrix, asked.parameter)),
        _ => None,
    }
    .map(|(matrix, parameter)| {
        let found = choose(&system, matrix, Smoothing::Parameter(parameter), variance).map_err(of_parameter)?;
        Ok::<(ChosenLambda, &SymmetricBand<f64>), FitError>((found, matrix))
    })
    .transpose()?;
    let penalty = found.map(|(found, matrix)| Penalty { lambda: found.lambda, matrix });
    let problem = Problem { system: &system, bases: &bases, swapped, include };
    let solved = system.solve(penalty).map_err(|fault| match fault {
        Unsolved::Undetermined(which) => FitError::Invalid(problem.undetermined(&which, penalty.is_some())),
        Unsolved::Stagnant => FitError::NotConverged(Unconverged::Refinement),
    })?;
    let weight = found.map(|(found, _)| Weight {
        lambda: found.lambda,
        criterion: found.criterion,
        reached: found.reached,
        trace: trace_of(&system),
    });
    surface_report::report(&problem, solved, penalty, weight)
}

/// A big surface of another model.
fn no_b_spline() -> Faults {
    Faults::one("model.type", "surfaces with so many coefficients must be of type `b_spline`")
}

/// Places errors of the weight of a penalty.
fn of_parameter(faults: Faults) -> FitError {
    let parameter = "regularization.parameter";
    faults.moved("parameter", parameter).moved("degrees_of_freedom", parameter).into()
}

fn check_spec(spec: &FitSpec) -> Result<(), Faults> {
    let mut faults = Faults::default();
    match &spec.model {
        Model::BSpline { weights: None, .. } => {}
        Model::BSpline { .. } => faults.push("model.weights", "surfaces with so many coefficients have no weights"),
        _ => faults.append(no_b_spline()),
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push("estimator", "surfaces with so many coefficients are fitted by least squares");
    }
    if !spec.filters.is_empty() {
        faults.push("filters", "filters are for nodes in lines, not for scattered ones");
    }
    requested_models(spec).for_each(|path| faults.push(path, WHITE_ONLY));
    if spec.scaling == Scaling::Standardized {
        faults.push("scaling", "B-splines have no constant column: use `unit_length` or `none`");
    }
    if spec.node_uncertainty.is_some() {
        faults.push("node_uncertainty", "surfaces with so many coefficients have no perturbation bounds");
    }
    if spec.coefficient_norm_limit.is_some() {
        faults.push("coefficient_norm_limit", "surfaces with so many coefficients have no bias bounds");
    }
    if spec.noise_sigma.is_some_and(|s| !(s > 0.0 && s.is_finite())) {
        faults.push("noise_sigma", "σ is a finite number greater than 0");
    }
    match &spec.regularization {
        Regularization::None | Regularization::Ridge { .. } => {}
        Regularization::Tikhonov(asked) => {
            if asked.order > HIGHEST_ORDER {
                faults.push("regularization.order", format_args!("{} is not one of 0 to {HIGHEST_ORDER}", asked.order));
            }
            let weights = asked.weights.as_deref().unwrap_or(&[1.0, 1.0]);
            let sound = weights.len() == 2 && weights.iter().all(|w| *w >= 0.0 && w.is_finite());
            if !(sound && weights.iter().any(|w| *w > 0.0)) {
                faults.push("regularization.weights", "a surface takes [w_u, w_v], none negative, one greater than 0");
            }
        }
        _ => faults.push(
            "regularization.type",
            "with so many coefficients there is no spectrum: use `none`, `ridge` or `tikhonov`",
        ),
    }
    faults.into_result(())
}

fn check_points(points: &SurfacePoints) -> Result<(), Faults> {
    let m = points.u.len();
    let mut faults = Faults::default();
    if m == 0 {
        faults.push("nodes.u", "there are no nodes");
    }
    if u32::try_from(m).is_err() {
        faults.push("nodes.u", "there are more nodes than 32 bits can number");
    }
    if !matches!(points.coordinates.len(), 1 | 3) {
        faults.push("nodes", "one coordinate (z) or three (x, y, z) are fitted");
        return Err(faults);
    }
    let parts = [("u", points.u), ("v", points.v)]
        .into_iter()
        .chain(points.coordinates.iter().enumerate().map(|(c, z)| (points.list(c), &z[..])))
        .chain(points.weight.map(|w| ("weight", w)));
    for (list, numbers) in parts {
        if numbers.len() != m {
            faults.push(format_args!("nodes.{list}"), format_args!("{}, but u needs {m}", entries(numbers.len())));
        }
        for (k, x) in numbers.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
            faults.push(format_args!("nodes.{list}[{k}]"), format_args!("{x} is not a finite number"));
        }
    }
    for (k, w) in points.weight.unwrap_or_default().iter().enumerate().filter(|(_, w)| **w < 0.0) {
        faults.push(format_args!("nodes.weight[{k}]"), negative_weight(*w));
    }
    faults.into_result(())
}

fn bases(points: &SurfacePoints, spec: &FitSpec) -> Result<[BSplineBasis; 2], Faults> {
    let Model::BSpline { degree, knots, .. } = &spec.model else {
        return Err(no_b_spline());
    };
    let (p, q) = match degree {
        Degree::Both(p) => (*p, *p),
        Degree::Each(p, q) => (*p, *q),
    };
    if p.max(q) > HIGHEST_DEGREE {
        return Err(Faults::one(
            "model.degree",
            format_args!(
                "surfaces with so many coefficients have degrees up to \
            {HIGHEST_DEGREE}"
            ),
        ));
    }
    // nodes of weight 0 say nothing, of the domain neither
    let counts = |k: usize| points.weight.is_none_or(|w| w[k] > 0.0);
    let span = |x: &[f64]| {
        let counted = x.iter().enumerate().filter(|(k, _)| counts(*k));
        counted.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (_, &x)| [a.min(x), b.max(x)])
    };
    let Domain { u, v } = spec.domain.unwrap_or_default();
    let mut faults = Faults::default();
    for (field, range) in [("domain.u", u), ("domain.v", v)] {
        if range.is_some_and(|[low, high]| !(low < high && (high - low).is_finite())) {
            faults.push(field, "not a range from low to high");
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let domains = (u.unwrap_or_else(|| span(points.u)), v.unwrap_or_else(|| span(points.v)));
    let (Axis::Spline(along), Axis::Spline(across)) = splines(knots, (p, q), true, domains)? else {
        return Err(Faults::one("model.knots", "a surface needs knots for u and for v"));
    };
    for (list, places, basis) in [("u", points.u, &along), ("v", points.v, &across)] {
        let (low, high) = basis.domain();
        for (k, x) in places.iter().enumerate().filter(|(k, x)| counts(*k) && (**x < low || **x > high)) {
            faults.push(
                format_args!("nodes.{list}[{k}]"),
                format_args!("{} lies outside the span of the knots [{}, {}]", Shown(*x), Shown(low), Shown(high)),
            );
        }
    }
    faults.into_result([along, across])
}

fn check_size(bases: &[BSplineBasis; 2]) -> Result<(), Faults> {
    let [u, v] = bases;
    let n = u.size().saturating_mul(v.size());
    let width = (u.degree() * v.size() + v.degree()).min(v.degree() * u.size() + u.degree());
    let operations = n as f64 * width as f64 * width as f64;
    if n > MOST_COEFFICIENTS || n.saturating_mul(width + 1) > MOST_NUMBERS || operations > MOST_OPERATIONS {
        return Err(Faults::one(
            "model",
            format_args!("{n} coefficients with a band of {width} are too many: use fewer spans"),
        ));
    }
    Ok(())
}

fn penalty_of(
    spec: &FitSpec,
    system: &System,
    ordered: &[BSplineBasis; 2],
    swapped: bool,
) -> Result<Option<SymmetricBand<f64>>, Faults> {
    let fisher = &system.normal.fisher;
    match &spec.regularization {
        Regularization::Ridge { .. } => {
            let mut matrix = SymmetricBand::zeros(fisher.size(), fisher.width());
            let unit = spec.scaling == Scaling::UnitLength;
            (0..fisher.size()).for_each(|j| matrix.add(j, j, if unit { fisher.get(j, j) } else { 1.0 }));
            Ok(Some(matrix))
        }
        Regularization::Tikhonov(asked) => {
            let given = asked.weights.as_deref().unwrap_or(&[1.0, 1.0]);
            let weights = if swapped { [given[1], given[0]] } else { [given[0], given[1]] };
            let [u, v] = ordered;
            let rough = |basis: &BSplineBasis, weight: f64| weight > 0.0 && basis.degree() >= asked.order;
            if !rough(u, weights[0]) && !rough(v, weights[1]) {
                return Err(Faults::one(
                    "regularization.order",
                    format_args!("derivatives of order {} vanish for every function of this model", asked.order),
                ));
            }
            Ok(Some(penalty([u, v], asked.order, weights)))
        }
        _ => Ok(None),
    }
}
