//! The roughness penalty of NURBS, whose functions `NᵢNⱼ / W` are no products of functions of u and
//! v.
//!
//! Cell by cell (one span of each axis) the derivatives at Gauss points times the roots of the
//! weights are rows of L, folded into one triangle. Integrands are rational, so the rule is not
//! exact, but it converges by a factor for every point: as fast as the zeros of W in the complex
//! plane are far. There are as many points as leave 12 digits while weights within a cell differ by
//! a factor of ten at most.

use nalgebra::DMatrix;

use crate::design::Axis;
use flankfit_geometry::{WeightNet, rational::quotient};
use flankfit_numerics::{Dd, Real, Triangle, quadrature::gauss_legendre};

/// Most Gauss points on a span in addition to the degree.
const MOST_BEYOND: f64 = 56.0;

/// Gauss points in addition to the degree for weights that differ by `ratio` within a cell: a
/// denominator that rises from 1 to `ratio` over a span as a parabola does has its zeros at a
/// distance of 1/√(ratio − 1).
fn additional_points(ratio: f64) -> usize {
    if ratio <= 1.0 { 0 } else { (16.0 / (1.0 / (ratio - 1.0).sqrt()).asinh()).ceil().min(MOST_BEYOND) as usize }
}

/// L (square, upper triangular) of `Σ w_axis ∫∫ (∂ᵏφ/∂axisᵏ)²` for working functions φ, the
/// integrals over the knots.
pub(super) fn factor(axes: [&Axis; 2], net: &WeightNet, weights: &[f64], order: usize) -> DMatrix<Dd> {
    let q = axes[1].size();
    let [spans_u, spans_v] = axes.map(spans);
    let ratio = |u: &Span, v: &Span| {
        let inside =
            (u.first..u.first + u.functions).flat_map(|i| (v.first..v.first + v.functions).map(move |j| (i, j)));
        let range = inside.map(|(i, j)| net.weights()[i * q + j]);
        let (least, largest) = range.fold((f64::INFINITY, 0.0f64), |(a, b), w| (a.min(w), b.max(w)));
        largest / least
    };
    let widest = spans_u.iter().flat_map(|u| spans_v.iter().map(move |v| ratio(u, v))).fold(1.0, f64::max);
    let beyond = additional_points(widest);
    let [cells_u, cells_v] = [(axes[0], spans_u), (axes[1], spans_v)]
        .map(|(axis, spans)| spans.into_iter().map(|span| cell(axis, span, beyond)).collect::<Vec<Cell>>());
    // what is differentiated: nothing, or along u and along v
    let terms: Vec<(f64, usize, usize)> = match order {
        0 => vec![(weights.iter().sum(), 0, 0)],
        _ => weights.iter().zip([(order, 0), (0, order)]).map(|(&w, (a, b))| (w, a, b)).filter(|t| t.0 > 0.0).collect(),
    };
    let n = axes[0].size() * q;
    let mut triangle = Triangle::<Dd>::new(n);
    let mut row = vec![Dd::ZERO; n];
    for cell_u in &cells_u {
        for cell_v in &cells_v {
            // what lies in one cell is brought together first, so that few rows go into the large
            // triangle
            let (k, l) = (cell_u.span.functions, cell_v.span.functions);
            let mut local = Triangle::<Dd>::new(k * l);
            let mut values = vec![Dd::ZERO; k * l];
            let place = |a: usize| (cell_u.span.first + a / l) * q + cell_v.span.first + a % l;
            for (at_u, at_v) in cell_u.points.iter().flat_map(|u| cell_v.points.iter().map(move |v| (u, v))) {
                let weight = |a: usize| net.weights()[place(a)];
                for &(share, along_u, along_v) in &terms {
                    let root = (at_u.weight * at_v.weight * share).sqrt();
                    let (high, along_u) = if along_v > 0 { (along_v, false) } else { (along_u, true) };
                    let derivative = |a: usize, d: usize| {
                        let (i, j) = (a / l, a % l);
                        if along_u { at_u.jets[i][d] * at_v.jets[j][0] } else { at_u.jets[i][0] * at_v.jets[j][d] }
                    };
                    let jet = |a: usize| -> [Dd; 4] {
                        std::array::from_fn(|d| if d <= high { derivative(a, d) } else { Dd::ZERO })
                    };
                    let mut whole = [Dd::ZERO; 4];
                    for a in 0..k * l {
                        whole.iter_mut().zip(jet(a)).for_each(|(sum, d)| *sum += d.mul_f64(weight(a)));
                    }
                    for (a, value) in values.iter_mut().enumerate() {
                        *value = quotient(high, jet(a), whole)[high] * root;
                    }
                    local.fold(&mut values, Dd::ZERO);
                }
            }
            let r = local.r();
            for a in 0..k * l {
                row.fill(Dd::ZERO);
                (a..k * l).for_each(|b| row[place(b)] = r[(a, b)]);
                triangle.fold(&mut row, Dd::ZERO);
            }
        }
    }
    triangle.r()
}

/// One span of an axis: its ends, the first function that is not 0, and how many there are.
struct Span {
    ends: [f64; 2],
    first: usize,
    functions: usize,
}

/// A span with its Gauss points.
struct Cell {
    span: Span,
    points: Vec<Point>,
}

/// A Gauss point: weight, and value and derivatives to order 3 of each function.
struct Point {
    weight: Dd,
    jets: Vec<[Dd; 4]>,
}

fn spans(axis: &Axis) -> Vec<Span> {
    // the single function 1 of a curve lives on one span
    let Axis::Spline(basis) = axis else { return vec![Span { ends: [0.0, 1.0], first: 0, functions: 1 }] };
    let p = basis.degree();
    let mut values = vec![0.0; p + 1];
    let ends = basis.distinct_knots();
    ends.windows(2)
        .map(|ends| Span {
            ends: [ends[0], ends[1]],
            first: basis.values(0.5 * ends[0] + 0.5 * ends[1], &mut values),
            functions: p + 1,
        })
        .collect()
}

fn cell(axis: &Axis, span: Span, beyond: usize) -> Cell {
    let Axis::Spline(basis) = axis else {
        let point = Point { weight: Dd::ONE, jets: vec![[Dd::ONE, Dd::ZERO, Dd::ZERO, Dd::ZERO]] };
        return Cell { span, points: vec![point] };
    };
    let p = basis.degree();
    let [low, high] = span.ends;
    let (half, middle) = (Dd::diff(high, low).mul_f64(0.5), Dd::sum(low, high).mul_f64(0.5));
    let mut values = vec![Dd::ZERO; p + 1];
    let points = gauss_legendre(p + 1 + beyond)
        .into_iter()
        .map(|(node, weight)| {
            let x = (middle + half * node).to_f64().clamp(low, high);
            let mut jets = vec![[Dd::ZERO; 4]; p + 1];
            for order in 0..4 {
                basis.derivatives_of(order, x, &mut values);
                jets.iter_mut().zip(&values).for_each(|(jet, &value)| jet[order] = value);
            }
            Point { weight: weight * half, jets }
        })
        .collect();
    Cell { span, points }
}
