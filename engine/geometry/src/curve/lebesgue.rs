//! The Lebesgue constant: the largest value of `Σ |Cᵢ(t)|`, where Cᵢ is the curve through 1 at node
//! i and 0 at all others.
//!
//! Errors of the values up to e move the curve by up to e times this constant. Derivatives that are
//! given (tangents, end slopes) are held fixed, and so are the parameters of points. The sum is
//! sampled between all nodes; its highest peaks are then narrowed down.

use super::{
    BSplineCurve, Curve, CurveShape, Polynomial,
    barycentric::Barycentric,
    ends::Ends,
    figure::{Absence, ascending},
    interpolate::{Collocation, chosen_knots},
    method::{Method, Nodes, shape},
    polynomial::Form,
    tangents::Tangents,
};
use crate::space::{Dimension, Vector};
use flankfit_numerics::{cancel, check::Faults};

/// The most nodes for which the constant is computed: the work grows with their square.
pub const MOST_NODES: usize = 400;

/// The most conditions of a Hermite polynomial for which it is: there the work grows with their
/// cube.
pub const MOST_CONDITIONS: usize = 150;

/// Places between two nodes.
const SAMPLES: usize = 12;
/// Peaks that are narrowed down.
const PEAKS: usize = 4;
/// Places in the window around a peak, and how often it is narrowed to the two parts around its
/// highest place.
const WINDOW: usize = 16;
const PASSES: usize = 7;

/// The Lebesgue constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lebesgue {
    /// The largest Σ |Cᵢ(t)| over the curve's domain, at least 1.
    pub constant: f64,
    /// The parameter at which it is reached.
    pub at: f64,
}

pub(super) fn lebesgue(nodes: &Nodes, method: &Method, shape: &CurveShape) -> Result<Lebesgue, Absence> {
    let parameters = &nodes.parameters;
    let count = parameters.len();
    let within = |nodes: usize, most: usize| if nodes <= most { Ok(()) } else { Err(Absence::TooMany { nodes, most }) };
    match method {
        Method::Lagrange | Method::Newton => {
            let barycentric = match shape {
                CurveShape::Polynomial(polynomial) => match polynomial.form() {
                    Form::Barycentric(form) => Ok(form.clone()),
                    Form::Newton(_) => Barycentric::new(parameters.clone(), nodes.values.clone()),
                },
                _ => Barycentric::new(parameters.clone(), nodes.values.clone()),
            };
            let form = barycentric.map_err(|_| Absence::NotFinite)?;
            largest(parameters, |places| Some(places.iter().map(|t| form.amplification(*t)).collect()))
        }
        Method::Hermite { derivatives } => {
            within(count + derivatives.iter().map(Vec::len).sum::<usize>(), MOST_CONDITIONS)?;
            let zeros: Vec<Vec<Vector>> = derivatives.iter().map(|d| vec![Vector::zeros(); d.len()]).collect();
            cardinals(parameters, false, |unit| {
                let with_value = |(v, d): (&Vector, &Vec<Vector>)| [std::slice::from_ref(v), d.as_slice()].concat();
                let data: Vec<Vec<Vector>> = unit.iter().zip(&zeros).map(with_value).collect();
                Polynomial::hermite(Dimension::Space, parameters, &data).map(CurveShape::Polynomial)
            })
        }
        Method::CubicHermite(tangents) if !tangents.is_linear() => Err(Absence::NotLinear),
        Method::CubicHermite(_) | Method::CubicSpline(_) => {
            within(count, MOST_NODES)?;
            let method = homogeneous(method, count);
            cardinals(parameters, matches!(method, Method::CubicSpline(Ends::Periodic)), |unit| {
                let nodes =
                    Nodes { dimension: Dimension::Space, parameters: parameters.clone(), values: unit.to_vec() };
                self::shape(&nodes, &method)
            })
        }
        Method::BSpline { degree, knots } => {
            within(count, MOST_NODES)?;
            let basis = chosen_knots(*degree, parameters, knots).map_err(|_| Absence::NotFinite)?;
            let equations = Collocation::new(basis, parameters).map_err(|_| Absence::NotFinite)?;
            cardinals(parameters, false, |unit| {
                let points = equations.control_points(unit)?;
                let curve = BSplineCurve::new(equations.basis().clone(), Dimension::Space, points, None)?;
                Ok(CurveShape::BSpline(curve))
            })
        }
    }
}

/// The method with zeros for all derivatives that are given.
fn homogeneous(method: &Method, count: usize) -> Method {
    match method {
        Method::CubicHermite(Tangents::Given(_)) => Method::CubicHermite(Tangents::Given(vec![Vector::zeros(); count])),
        Method::CubicSpline(ends) => Method::CubicSpline(ends.homogeneous()),
        other => other.clone(),
    }
}

/// The constant from curves through unit values, three at once as coordinates of points of space.
/// Of a period, whose ends are one node, the last unit belongs to the first.
fn cardinals(
    parameters: &[f64],
    period: bool,
    build: impl Fn(&[Vector]) -> Result<CurveShape, Faults>,
) -> Result<Lebesgue, Absence> {
    let count = parameters.len();
    let units = |first: usize, period: bool| {
        let mut unit = vec![Vector::zeros(); count];
        for k in 0..3.min(count - first) {
            unit[first + k][k] = 1.0;
        }
        if period {
            unit[count - 1] = unit[0];
        }
        unit
    };
    let own = if period { count - 1 } else { count };
    largest(parameters, |places| {
        let mut sums = vec![0.0; places.len()];
        for first in (0..own).step_by(3) {
            cancel::checkpoint();
            let mut unit = units(first, period);
            if period && first + 3 > own {
                // the unit that would stand at the last node alone is that of node 0, which has
                // been counted
                unit.iter_mut().for_each(|u| (own - first..3).for_each(|k| u[k] = 0.0));
            }
            let curve = build(&unit).ok()?;
            for (sum, t) in sums.iter_mut().zip(places) {
                *sum += curve.value(*t).abs().sum();
            }
        }
        Some(sums)
    })
}

/// The largest sum between the nodes. `sums` returns those of many places at once.
fn largest(parameters: &[f64], sums: impl Fn(&[f64]) -> Option<Vec<f64>>) -> Result<Lebesgue, Absence> {
    let sorted: Vec<f64> = ascending(parameters).into_iter().map(|i| parameters[i]).collect();
    let mut places = Vec::with_capacity(SAMPLES * sorted.len());
    for pair in sorted.windows(2) {
        places.extend((0..SAMPLES).map(|j| pair[0] + (pair[1] - pair[0]) * (j as f64 / SAMPLES as f64)));
    }
    places.extend(sorted.last());
    let coarse = sums(&places).ok_or(Absence::NotFinite)?;
    let mut peaks: Vec<usize> =
        (1..places.len() - 1).filter(|i| coarse[*i] >= coarse[i - 1] && coarse[*i] >= coarse[i + 1]).collect();
    peaks.sort_by(|a, b| coarse[*b].total_cmp(&coarse[*a]));
    peaks.truncate(PEAKS);
    // at a node the sum is 1
    let mut best = Lebesgue { constant: 1.0, at: sorted[0] };
    let mut windows: Vec<[f64; 2]> = peaks.iter().map(|i| [places[i - 1], places[i + 1]]).collect();
    for _ in 0..PASSES {
        let inner = |w: &[f64; 2]| {
            let [low, high] = *w;
            (0..=WINDOW).map(move |j| low + (high - low) * (j as f64 / WINDOW as f64)).collect::<Vec<f64>>()
        };
        let places: Vec<f64> = windows.iter().flat_map(inner).collect();
        let fine = sums(&places).ok_or(Absence::NotFinite)?;
        for ((window, places), fine) in windows.iter_mut().zip(places.chunks(WINDOW + 1)).zip(fine.chunks(WINDOW + 1)) {
            let mut top = 0;
            for j in 1..fine.len() {
                if fine[j] > fine[top] {
                    top = j;
                }
            }
            if fine[top] > best.constant {
                best = Lebesgue { constant: fine[top], at: places[top] };
            }
            *window = [places[top.saturating_sub(1)], places[(top + 1).min(WINDOW)]];
        }
    }
    if best.constant.is_finite() { Ok(best) } else { Err(Absence::NotFinite) }
}
