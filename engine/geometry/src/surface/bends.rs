//! Bounds of the second derivatives over rectangles of parameters: what makes a bound of the
//! distance to a part of a surface valid.
//!
//! Derivatives of a B-spline are B-splines, and lie within the hull of their control points that
//! act on a span. Knots are inserted where a rectangle ends, so that those of each rectangle are
//! few and near.

use super::{BSplineSurface, Surface};
use crate::{BSplineBasis, space::Vector};
use flankfit_numerics::cancel;

/// A cut this near to a knot, relative to the domain, is taken for the knot.
const SAME: f64 = 1e-9;

/// Bounds of |S_uu|, |S_uv| and |S_vv|.
pub(crate) type Bends = [f64; 3];

/// Control points of a derivative in homogeneous coordinates, v running fastest.
struct Net {
    columns: usize,
    points: Vec<(Vector, f64)>,
}

impl BSplineSurface {
    /// For every rectangle between neighbouring `cuts` (ascending, within the domain), v running
    /// fastest. `None` where a weight of 0 leaves the derivatives without bound.
    pub(super) fn second_derivative_bounds(&self, cuts: [&[f64]; 2]) -> Option<Vec<Bends>> {
        let mut fine = self.clone();
        for (axis, cuts) in cuts.into_iter().enumerate() {
            let knots = self.bases()[axis].distinct_knots();
            let near = SAME * (knots[knots.len() - 1] - knots[0]);
            let is_new = |cut: &&f64| {
                let next = knots.partition_point(|knot| knot < cut);
                let away = |k: usize| knots.get(k).is_none_or(|knot| (knot - **cut).abs() > near);
                away(next) && away(next.wrapping_sub(1))
            };
            let inserted: Vec<f64> = cuts.iter().filter(is_new).copied().collect();
            if !inserted.is_empty() {
                fine = fine.refine(axis, &inserted).ok()?;
            }
        }
        let [us, vs] = [0, 1].map(|axis| spans(&fine.bases()[axis], cuts[axis]));
        let weight = |k: usize| fine.weights().map_or(1.0, |weights| weights[k]);
        let lift = |(k, point): (usize, &Vector)| (point * weight(k), weight(k));
        let columns = fine.bases()[1].size();
        let net = Net { columns, points: fine.control_points().iter().enumerate().map(lift).collect() };
        let (u, v) = (slopes(&net, &fine, 0, 0), slopes(&net, &fine, 1, 0));
        let (uu, uv, vv) = (slopes(&u, &fine, 0, 1), slopes(&u, &fine, 1, 0), slopes(&v, &fine, 1, 1));
        let nets = [net, u, v, uu, uv, vv];
        let mut all = Vec::with_capacity(us.len() * vs.len());
        for own_us in &us {
            for own_vs in &vs {
                cancel::checkpoint();
                let mut bound = [0.0f64; 3];
                for (i, j) in own_us.iter().flat_map(|i| own_vs.iter().map(move |j| (*i, *j))) {
                    let here = over_span(&fine, &nets, [i, j])?;
                    bound = std::array::from_fn(|k| bound[k].max(here[k]));
                }
                all.push(bound);
            }
        }
        Some(all)
    }
}

/// For every interval between cuts the knot spans with a width that share more than an end with it.
fn spans(basis: &BSplineBasis, cuts: &[f64]) -> Vec<Vec<usize>> {
    let (knots, p) = (basis.knots(), basis.degree());
    let wide: Vec<usize> = (p..basis.size()).filter(|s| knots[*s] < knots[s + 1]).collect();
    let within = |pair: &[f64]| {
        let first = wide.partition_point(|s| knots[s + 1] <= pair[0]);
        wide[first..].iter().copied().take_while(|s| knots[*s] < pair[1]).collect()
    };
    cuts.windows(2).map(within).collect()
}

/// The net of the derivative along `axis` of one that is the `order`-th along it already.
fn slopes(net: &Net, surface: &BSplineSurface, axis: usize, order: usize) -> Net {
    let basis = &surface.bases()[axis];
    let rows = net.points.len().checked_div(net.columns).unwrap_or(0);
    if basis.degree() <= order || rows == 0 {
        return Net { columns: 0, points: Vec::new() };
    }
    let (degree, knots) = (basis.degree() - order, &basis.knots()[order..]);
    let rate = |k: usize| {
        let width = knots[k + degree + 1] - knots[k + 1];
        // a function without support has no say
        if width > 0.0 { degree as f64 / width } else { 0.0 }
    };
    let (new_rows, columns) = if axis == 0 { (rows - 1, net.columns) } else { (rows, net.columns - 1) };
    let mut points = Vec::with_capacity(new_rows * columns);
    for i in 0..new_rows {
        for j in 0..columns {
            let here = i * net.columns + j;
            let next = if axis == 0 { here + net.columns } else { here + 1 };
            let ((p0, w0), (p1, w1)) = (net.points[here], net.points[next]);
            let rate = rate(if axis == 0 { i } else { j });
            points.push(((p1 - p0) * rate, (w1 - w0) * rate));
        }
    }
    Net { columns, points }
}

/// Over span (i, j) of knots: sizes of all six nets about the middle of the control points there,
/// and from them those of the quotient.
fn over_span(surface: &BSplineSurface, nets: &[Net; 6], [i, j]: [usize; 2]) -> Option<Bends> {
    const ORDERS: [[usize; 2]; 6] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];
    let [p, q] = surface.bases().each_ref().map(BSplineBasis::degree);
    let (first_row, first_column) = (i - p, j - q);
    let acting = |which: usize| {
        let [du, dv] = ORDERS[which];
        let net = &nets[which];
        let (rows, columns) = ((p + 1).saturating_sub(du), (q + 1).saturating_sub(dv));
        (0..rows)
            .flat_map(move |a| (0..columns).map(move |b| net.points[(first_row + a) * net.columns + first_column + b]))
    };
    if surface.weights().is_none() {
        let largest = |which: usize| acting(which).map(|(point, _)| point.norm()).fold(0.0, f64::max);
        return Some([largest(3), largest(4), largest(5)]);
    }
    let least = acting(0).map(|(_, w)| w).fold(f64::INFINITY, f64::min);
    if !(least > 0.0) {
        return None;
    }
    let count = ((p + 1) * (q + 1)) as f64;
    let middle = acting(0).map(|(point, w)| point / w).sum::<Vector>() / count;
    let radius = acting(0).map(|(point, w)| (point / w - middle).norm()).fold(0.0, f64::max);
    // of the numerator about the middle, and of the weight
    let sizes: [[f64; 2]; 6] = std::array::from_fn(|which| {
        acting(which).fold([0.0f64; 2], |[about, weight], (point, w)| {
            [about.max((point - middle * w).norm()), weight.max(w.abs())]
        })
    });
    let [_, [qu, wu], [qv, wv], [quu, wuu], [quv, wuv], [qvv, wvv]] = sizes;
    let (su, sv) = ((qu + radius * wu) / least, (qv + radius * wv) / least);
    Some([
        (quu + 2.0 * su * wu + radius * wuu) / least,
        (quv + su * wv + sv * wu + radius * wuv) / least,
        (qvv + 2.0 * sv * wv + radius * wvv) / least,
    ])
}

/// The same where nothing but places can be asked for: the largest of 25 of each rectangle, with
/// a margin.
pub(crate) fn sampled(surface: &dyn Surface, u: [f64; 2], v: [f64; 2]) -> Bends {
    const SLACK: f64 = 3.0;
    let mut largest = [0.0f64; 3];
    for k in 0..25 {
        let at = |[low, high]: [f64; 2], share: f64| (low + (high - low) * share).clamp(low, high);
        let jet = surface.place(at(u, f64::from(k / 5) / 4.0), at(v, f64::from(k % 5) / 4.0));
        let here = [jet.uu.norm(), jet.uv.norm(), jet.vv.norm()];
        largest = std::array::from_fn(|k| largest[k].max(here[k]));
    }
    largest.map(|bend| SLACK * bend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Dimension;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
        /// Nowhere in a rectangle is a second derivative larger, and somewhere it is not much
        /// smaller.
        #[test]
        fn no_derivative_is_larger(
            values in prop::collection::vec(prop::array::uniform3(-9.0..9.0f64), 40),
            weights in prop::collection::vec(0.3..3.0f64, 40),
            rational in any::<bool>(),
            degrees in prop::array::uniform2(1usize..4),
        ) {
            let bases = [(degrees[0], 8), (degrees[1], 5)].map(|(p, n)| {
                BSplineBasis::uniform(p, n - p, 0.0, 2.0).unwrap()
            });
            let points = values.into_iter().map(Vector::from).collect();
            let surface =
                BSplineSurface::new(bases, Dimension::Space, points, rational.then_some(weights)).unwrap();
            let cuts = [0.0, 0.11, 0.5, 0.75, 1.3, 2.0];
            let found = surface.second_derivative_bounds([&cuts, &cuts]).unwrap();
            for (k, bound) in found.iter().enumerate() {
                let (i, j) = (k / 5, k % 5);
                for n in 0..49 {
                    let at = |k: usize, s: usize| cuts[k] + (cuts[k + 1] - cuts[k]) * (s as f64 + 0.5) / 7.0;
                    let jet = surface.jet(at(i, n / 7), at(j, n % 7));
                    for (bound, d) in bound.iter().zip([jet.uu, jet.uv, jet.vv]) {
                        prop_assert!(d.norm() <= bound * (1.0 + 1e-10) + 1e-10, "{bound} {}", d.norm());
                    }
                }
            }
        }
    }
}
