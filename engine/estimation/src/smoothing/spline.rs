//! The natural cubic smoothing spline of points over one parameter: `min Σ w (y − g(x))² + λ ∫
//! g″²`.
//!
//! λ → 0 gives the natural interpolating spline, λ → ∞ the straight line of least squares. Knots
//! are all abscissae; the answer is a B-spline curve of degree 3 over them.
//!
//! Repeated abscissae are repeated measurements: g has one value there, so that only their weighted
//! mean and the sum of their weights enter the equations, and what they differ by stays in RSS
//! whatever λ is. m in the criteria is the number of points, not of abscissae. Points of weight 0
//! are left out. Abscissae must not descend: nothing is sorted.
//!
//! Standard errors of the fitted values are `σ √(leverage/w)`, σ² = RSS/(m − edf): the spread of
//! Wahba's posterior (1983), which contains the bias on the average over the abscissae. Several
//! coordinates share λ.

use super::{
    choice::{self, ChosenLambda, Problem, Smoothing},
    reinsch::{Equations, Solution},
};
use flankfit_geometry::{
    BSplineBasis,
    curve::BSplineCurve,
    space::{Dimension, Vector},
};
use flankfit_numerics::{Dd, cancel::Asking, check::Faults, words::Shown};

/// Points to be smoothed.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// Abscissae, or parameters of the points of a parametric curve; none below the one before it.
    pub x: &'a [f64],
    /// One to three coordinates, each as long as `x`.
    pub coordinates: &'a [Vec<f64>],
    /// Weights, not negative; 0 leaves a point out. All weigh 1 by default.
    pub weight: Option<&'a [f64]>,
}

/// Specification of a smoothing spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingSpec {
    /// Choice of λ.
    pub smoothing: Smoothing,
    /// σ of a height of weight 1, for `discrepancy` and `min_mse`.
    pub noise_sigma: Option<f64>,
    /// True if fitted values and their standard errors are requested.
    pub pointwise: bool,
}

/// A smoothing spline.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothingSpline {
    /// Degree 3, knots at the abscissae.
    pub curve: BSplineCurve,
    /// λ.
    pub lambda: f64,
    /// λ and how it was found.
    pub found: ChosenLambda,
    /// Trace of the matrix that makes fitted values of heights; between 2 and the number of
    /// abscissae.
    pub effective_degrees_of_freedom: f64,
    /// Points counted.
    pub count: usize,
    /// Distinct abscissae among the counted points.
    pub abscissae: usize,
    /// `Σ w r²` of each coordinate.
    pub rss: Vec<f64>,
    /// √(RSS/Σw) of each coordinate.
    pub rms: Vec<f64>,
    /// Largest absolute residual of each coordinate.
    pub max_abs: Vec<f64>,
    /// σ̂ = √(RSS/(m − edf)) of each coordinate; `None` where m ≤ edf.
    pub sigma: Vec<Option<f64>>,
    /// ∫ g″², over all coordinates.
    pub roughness: f64,
    /// Fitted values, if requested.
    pub pointwise: Option<Pointwise>,
}

/// At the distinct abscissae.
#[derive(Clone, Debug, PartialEq)]
pub struct Pointwise {
    /// Distinct abscissae of the counted points, ascending.
    pub x: Vec<f64>,
    /// Fitted values, by coordinate.
    pub fitted: Vec<Vec<f64>>,
    /// Standard errors, by coordinate; `None` without σ̂.
    pub standard_errors: Vec<Option<Vec<f64>>>,
}

/// Distinct abscissae with the mean heights and total weights of their points.
struct Merged {
    x: Vec<f64>,
    weight: Vec<f64>,
    heights: Vec<Vec<Dd>>,
    /// `Σ w (y − ȳ)²` of each coordinate.
    apart: Vec<f64>,
    count: usize,
}

/// Smooths `points`.
///
/// ```
/// use flankfit_estimation::{
///     smoothing::{
///         Smoothing, smoothing_spline,
///         spline::{Points, SmoothingSpec},
///     },
///     spec::{Criterion, Parameter},
/// };
/// use flankfit_geometry::curve::Curve;
///
/// let x: Vec<f64> = (0..40).map(|k| f64::from(k) / 39.0).collect();
/// let noise = |k: usize| (k * 7919 % 101) as f64 / 505.0 - 0.1;
/// let y =
///     vec![x.iter().enumerate().map(|(k, x)| (4.0 * x).sin() + noise(k)).collect::<Vec<f64>>()];
/// let points = Points { x: &x, coordinates: &y, weight: None };
/// let smooth = |smoothing| {
///     smoothing_spline(&points, &SmoothingSpec { smoothing, noise_sigma: None, pointwise: false })
/// };
/// // Generalised cross-validation takes the noise away and leaves the wave.
/// let chosen = smooth(Smoothing::Parameter(Parameter::Criterion(Criterion::Gcv)))?;
/// assert!((chosen.curve.value(0.5).x - 2f64.sin()).abs() < 0.05);
/// // As many effective degrees of freedom as asked for.
/// let six = smooth(Smoothing::EffectiveDegrees(6.0))?;
/// assert!((six.effective_degrees_of_freedom - 6.0).abs() < 1e-6);
/// // Without a penalty the spline passes through every point.
/// let interpolating = smooth(Smoothing::Parameter(Parameter::Fixed(0.0)))?;
/// assert!(interpolating.max_abs[0] < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smoothing_spline(points: &Points, asked: &SmoothingSpec) -> Result<SmoothingSpline, Faults> {
    check(points)?;
    let merged = merge(points);
    let m = merged.x.len();
    if m < 2 {
        let message = format_args!("at least 2 distinct abscissae of weight above 0 are needed; found {m}");
        return Err(Faults::one("points", message));
    }
    let apart: f64 = merged.apart.iter().sum();
    let (found, mut solution) = if m == 2 {
        // the line through two points, whatever λ is
        let lambda = if let Smoothing::Parameter(crate::spec::Parameter::Fixed(lambda)) = asked.smoothing {
            lambda
        } else {
            0.0
        };
        (ChosenLambda { lambda, criterion: None, reached: true }, line(&merged))
    } else {
        let equations = Equations::new(&merged.x, &merged.weight);
        let problem = Problem {
            count: merged.count,
            coordinates: merged.heights.len(),
            variance: asked.noise_sigma.map(|s| s * s),
            range: equations.range(),
        };
        if !problem.range.iter().all(|x| x.is_finite()) {
            return Err(exceeds_double());
        }
        let figures = |lambda| Some(equations.figures(&merged.heights, lambda, apart));
        let found = choice::find(asked.smoothing, &problem, figures)
            .map_err(|faults| faults.moved("parameter.criterion", "parameter").within("method"))?;
        (found, equations.solve(&merged.heights, found.lambda))
    };
    solution.rss.iter_mut().zip(&merged.apart).for_each(|(rss, apart)| *rss += apart);
    report(points, asked, &merged, found, &solution)
}

fn check(points: &Points) -> Result<(), Faults> {
    let wanted = points.x.len();
    if !(1..=3).contains(&points.coordinates.len()) {
        return Err(coordinates(points.coordinates.len()));
    }
    let heights = if points.coordinates.len() == 1 { "points.y" } else { "points.xyz" };
    let lists = std::iter::once(("points.x", points.x))
        .chain(points.coordinates.iter().map(|y| (heights, &y[..])))
        .chain(points.weight.map(|weight| ("method.weight", weight)));
    for (list, numbers) in lists {
        let given = numbers.len();
        if given != wanted {
            let message = format_args!("{given} numbers where {wanted} are needed, one for each abscissa");
            return Err(Faults::one(list, message));
        }
        if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
            return Err(Faults::one(format_args!("{list}[{index}]"), format_args!("number {index} is not finite")));
        }
    }
    if let Some((index, &value)) = points.weight.unwrap_or_default().iter().enumerate().find(|(_, w)| **w < 0.0) {
        return Err(Faults::one(
            format_args!("method.weight[{index}]"),
            format_args!("the weight {} is negative or not finite; 0 leaves a point out", Shown(value)),
        ));
    }
    match points.x.windows(2).position(|pair| pair[1] < pair[0]) {
        None => Ok(()),
        Some(i) => {
            let (index, value, before) = (i + 1, Shown(points.x[i + 1]), Shown(points.x[i]));
            Err(Faults::one(
                format_args!("points.x[{index}]"),
                format_args!(
                    "abscissa {index} ({value}) lies below the one before it ({before}); the order of points is never \
                     changed"
                ),
            ))
        }
    }
}

/// Points of no or of more than three coordinates.
fn coordinates(given: usize) -> Faults {
    Faults::one("points", format_args!("{given} coordinates: one, two or three are possible"))
}

/// Error for intermediate numbers above the range of a double.
fn exceeds_double() -> Faults {
    Faults::one("points", "these numbers exceed the range of double precision: choose another unit")
}

fn merge(points: &Points) -> Merged {
    let weight = |i: usize| points.weight.map_or(1.0, |w| w[i]);
    let counted: Vec<usize> = (0..points.x.len()).filter(|&i| weight(i) > 0.0).collect();
    let dimension = points.coordinates.len();
    let mut merged = Merged {
        x: Vec::new(),
        weight: Vec::new(),
        heights: vec![Vec::new(); dimension],
        apart: vec![0.0; dimension],
        count: counted.len(),
    };
    for group in counted.chunk_by(|&a, &b| points.x[a] == points.x[b]).asking(200) {
        let total = group.iter().fold(Dd::ZERO, |sum, &i| sum + weight(i));
        merged.x.push(points.x[group[0]]);
        merged.weight.push(total.to_f64());
        for (c, y) in points.coordinates.iter().enumerate() {
            let mean = if let [only] = group {
                Dd::from(y[*only])
            } else {
                group.iter().fold(Dd::ZERO, |sum, &i| sum + Dd::product(weight(i), y[i])) / total
            };
            merged.heights[c].push(mean);
            let apart = group.iter().map(|&i| weight(i) * (Dd::from(y[i]) - mean).to_f64().powi(2));
            merged.apart[c] += apart.sum::<f64>();
        }
    }
    merged
}

fn line(merged: &Merged) -> Solution {
    let dimension = merged.heights.len();
    Solution {
        values: merged.heights.clone(),
        bends: vec![vec![Dd::ZERO; 2]; dimension],
        rss: vec![0.0; dimension],
        leverage: vec![1.0; 2],
        effective: 2.0,
        roughness: 0.0,
    }
}

fn report(
    points: &Points,
    asked: &SmoothingSpec,
    merged: &Merged,
    found: ChosenLambda,
    solution: &Solution,
) -> Result<SmoothingSpline, Faults> {
    let (m, dimension) = (merged.x.len(), merged.heights.len());
    let weight: f64 = merged.weight.iter().sum();
    let free = merged.count as f64 - solution.effective;
    // with as many abscissae as points and λ = 0 nothing is left but rounding
    let sigma: Vec<Option<f64>> = solution
        .rss
        .iter()
        .map(|rss| Some((rss / free).sqrt()).filter(|s| free > 1e-9 * merged.count as f64 && s.is_finite()))
        .collect();
    let fitted: Vec<Vec<f64>> =
        solution.values.iter().map(|values| values.iter().map(|value| value.to_f64()).collect()).collect();
    let max_abs =
        (0..dimension).map(|c| largest(points, merged, &solution.values[c], &points.coordinates[c])).collect();
    let pointwise = asked.pointwise.then(|| Pointwise {
        x: merged.x.clone(),
        standard_errors: sigma
            .iter()
            .map(|sigma| {
                let each = solution.leverage.iter().zip(&merged.weight);
                sigma.map(|sigma| each.map(|(leverage, w)| sigma * (leverage / w).sqrt()).collect())
            })
            .collect(),
        fitted,
    });
    let controls = controls(merged, solution);
    if !controls.iter().all(|p| p.iter().all(|x| x.is_finite())) || !solution.effective.is_finite() {
        return Err(exceeds_double());
    }
    let dimension = Dimension::of(dimension).ok_or_else(|| coordinates(dimension))?;
    let ends = |x: f64| std::iter::repeat_n(x, 4);
    let knots = ends(merged.x[0]).chain(merged.x[1..m - 1].iter().copied()).chain(ends(merged.x[m - 1])).collect();
    let basis = BSplineBasis::new(3, knots).map_err(|_| exceeds_double())?;
    let curve = BSplineCurve::new(basis, dimension, controls, None).map_err(|_| exceeds_double())?;
    Ok(SmoothingSpline {
        curve,
        lambda: found.lambda,
        found,
        effective_degrees_of_freedom: solution.effective,
        count: merged.count,
        abscissae: m,
        rms: solution.rss.iter().map(|rss| (rss / weight).sqrt()).collect(),
        rss: solution.rss.clone(),
        max_abs,
        sigma,
        roughness: solution.roughness,
        pointwise,
    })
}

fn largest(points: &Points, merged: &Merged, values: &[Dd], heights: &[f64]) -> f64 {
    let mut at = 0;
    let mut largest: f64 = 0.0;
    for (i, (&x, &y)) in points.x.iter().zip(heights).enumerate().asking(50) {
        if points.weight.is_some_and(|w| w[i] == 0.0) {
            continue;
        }
        while merged.x[at] < x {
            at += 1;
        }
        largest = largest.max((Dd::from(y) - values[at]).to_f64().abs());
    }
    largest
}

/// Control points by the polar form: over the knots a < b < c the one that belongs to them is
/// `g(b) + g′(b) (a + c − 2b)/3 + g″(b) (a − b)(c − b)/6`.
fn controls(merged: &Merged, solution: &Solution) -> Vec<Vector> {
    let m = merged.x.len();
    let step = |i: usize| Dd::diff(merged.x[i + 1], merged.x[i]);
    let (three, six) = (Dd::from(3.0), Dd::from(6.0));
    let of = |values: &[Dd], bends: &[Dd]| -> Vec<f64> {
        // slope at the right and at the left end of piece i
        let chord = |i: usize| (values[i + 1] - values[i]) / step(i);
        let right = |i: usize| chord(i) + step(i) * (bends[i] + bends[i + 1] * 2.0) / six;
        let left = |i: usize| chord(i) - step(i) * (bends[i] * 2.0 + bends[i + 1]) / six;
        let mut out = vec![values[0], values[0] + left(0) * step(0) / three];
        for i in (1..m - 1).asking(200) {
            let (before, after) = (step(i - 1), step(i));
            let moved = right(i - 1) * (after - before) / three - bends[i] * before * after / six;
            out.push(values[i] + moved);
        }
        out.push(values[m - 1] - right(m - 2) * step(m - 2) / three);
        out.push(values[m - 1]);
        out.iter().map(|x| x.to_f64()).collect()
    };
    let each: Vec<Vec<f64>> = solution.values.iter().zip(&solution.bends).map(|(v, b)| of(v, b)).collect();
    (0..m + 2).map(|i| Vector::from_fn(|c, _| each.get(c).map_or(0.0, |column| column[i]))).collect()
}
