//! The height of a spline surface over a plane, times the weight, on one rectangle between knots:
//! a polynomial in Bernstein form.
//!
//! A polynomial lies within the hull of its coefficients, ascends where they ascend, and has along
//! a side no more zeros than they change their sign. Halved, the coefficients come near to the
//! values as the square of the width: so what is said of a cell is certain, and small cells can be
//! judged.

use crate::{
    BSplineBasis,
    polar::local_blossom,
    surface::{BSplineSurface, Surface},
};

use super::plane::Plane;

/// Coefficients over a rectangle, the second parameter running fastest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Form {
    counts: [usize; 2],
    coefficients: Vec<f64>,
}

impl Form {
    /// The height times the weight on knot spans `spans` of a spline surface.
    pub(super) fn of_spans(surface: &BSplineSurface, plane: &Plane, spans: [usize; 2]) -> Self {
        let parametric = surface.dimension().is_parametric();
        let local = Local { surface, spans };
        let weight = |k: usize| surface.weights().map_or(1.0, |weights| weights[k]);
        let point = |k: usize| surface.control_points()[k];
        if parametric {
            return local.form(|k| (plane.normal.dot(&point(k)) - plane.offset) * weight(k));
        }
        // (n_x u − d) w + n_y v w + n_z z w, of one degree more where there are weights
        let [[u0, u1], [v0, v1]] = local.range();
        let along = [plane.normal.x, plane.normal.y];
        let weights = surface.weights().map_or_else(|| Form::constant(1.0), |_| local.form(weight));
        let over_u = weights.times(0, [along[0] * u0 - plane.offset, along[0] * u1 - plane.offset]);
        let over_v = weights.times(1, [along[1] * v0, along[1] * v1]);
        let ground = over_u.times(1, [1.0; 2]).plus(&over_v.times(0, [1.0; 2]));
        let heights = local.form(|k| plane.normal.z * point(k).x * weight(k));
        let counts = [0, 1].map(|axis| ground.counts[axis].max(heights.counts[axis]));
        ground.raised(counts).plus(&heights.raised(counts))
    }

    fn constant(value: f64) -> Self {
        Form { counts: [1, 1], coefficients: vec![value] }
    }

    pub(super) fn size(&self) -> usize {
        self.coefficients.len()
    }

    fn plus(&self, other: &Self) -> Self {
        let sums = self.coefficients.iter().zip(&other.coefficients).map(|(a, b)| a + b).collect();
        Form { counts: self.counts, coefficients: sums }
    }

    fn raised(&self, counts: [usize; 2]) -> Self {
        let mut form = self.clone();
        for axis in 0..2 {
            while form.counts[axis] < counts[axis] {
                form = form.times(axis, [1.0; 2]);
            }
        }
        form
    }

    /// The product with a linear function of one parameter that has these values at the ends.
    fn times(&self, axis: usize, ends: [f64; 2]) -> Self {
        let mut counts = self.counts;
        counts[axis] += 1;
        let raised = self.counts[axis] as f64;
        let mut product = Form { counts, coefficients: vec![0.0; counts[0] * counts[1]] };
        for i in 0..self.counts[0] {
            for j in 0..self.counts[1] {
                let own = self.coefficients[i * self.counts[1] + j];
                let k = [i, j][axis] as f64;
                let next = if axis == 0 { (i + 1) * counts[1] + j } else { i * counts[1] + j + 1 };
                product.coefficients[i * counts[1] + j] += own * ends[0] * ((raised - k) / raised);
                product.coefficients[next] += own * ends[1] * ((k + 1.0) / raised);
            }
        }
        product
    }

    /// The form over the lower and over the upper part of one parameter, divided at a share.
    pub(super) fn divided(&self, axis: usize, share: f64) -> [Self; 2] {
        let [rows, columns] = self.counts;
        let (mut low, mut high) = (self.clone(), self.clone());
        let (lines, count, step) = if axis == 0 { (columns, rows, columns) } else { (rows, columns, 1) };
        for line in 0..lines {
            let start = if axis == 0 { line } else { line * columns };
            let at = |k: usize| start + k * step;
            for done in 1..count {
                for k in 0..count - done {
                    let (a, b) = (high.coefficients[at(k)], high.coefficients[at(k + 1)]);
                    high.coefficients[at(k)] = if share == 0.5 { 0.5 * (a + b) } else { a + share * (b - a) };
                }
                low.coefficients[at(done)] = high.coefficients[at(0)];
            }
        }
        [low, high]
    }

    /// The form over a part, of which each end is a share of the whole.
    pub(super) fn part(&self, shares: [[f64; 2]; 2]) -> Self {
        let mut form = self.clone();
        for (axis, [from, to]) in shares.into_iter().enumerate() {
            if to < 1.0 {
                let [low, _] = form.divided(axis, to);
                form = low;
            }
            if from > 0.0 {
                let [_, high] = form.divided(axis, from / to);
                form = high;
            }
        }
        form
    }

    /// The least and the greatest coefficient.
    pub(super) fn hull(&self) -> [f64; 2] {
        self.coefficients.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)])
    }

    /// Returns true if it ascends, or descends, everywhere along a parameter, by steps above
    /// `least`.
    pub(super) fn is_monotone(&self, axis: usize, least: f64) -> bool {
        let [rows, columns] = self.counts;
        let step = if axis == 0 { columns } else { 1 };
        let (ends, along) = if axis == 0 { (rows - 1, columns) } else { (rows, columns - 1) };
        let mut steps = (0..ends).flat_map(|i| (0..along).map(move |j| i * columns + j));
        let difference = |k: usize| self.coefficients[k + step] - self.coefficients[k];
        let Some(first) = steps.next().map(difference) else { return false };
        first.abs() > least && steps.map(difference).all(|next| next.abs() > least && (next > 0.0) == (first > 0.0))
    }

    /// Coefficients of the side where the parameter `axis` is at its lower (0) or upper (1) end.
    pub(super) fn side(&self, axis: usize, end: usize) -> impl Iterator<Item = f64> {
        let [_, columns] = self.counts;
        let at = end * (self.counts[axis] - 1);
        let count = self.counts[1 - axis];
        (0..count).map(move |k| self.coefficients[if axis == 0 { at * columns + k } else { k * columns + at }])
    }
}

/// Two knot spans of a spline surface.
struct Local<'a> {
    surface: &'a BSplineSurface,
    spans: [usize; 2],
}

impl Local<'_> {
    fn range(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|axis| {
            let (knots, span) = (self.surface.bases()[axis].knots(), self.spans[axis]);
            [knots[span], knots[span + 1]]
        })
    }

    /// Bernstein coefficients of the spline with these control values.
    fn form(&self, value: impl Fn(usize) -> f64) -> Form {
        let bases = self.surface.bases();
        let degrees = bases.each_ref().map(BSplineBasis::degree);
        let counts = degrees.map(|degree| degree + 1);
        let columns = bases[1].size();
        let mut coefficients: Vec<f64> = (0..counts[0] * counts[1])
            .map(|k| {
                (self.spans[0] - degrees[0] + k / counts[1]) * columns + self.spans[1] - degrees[1] + k % counts[1]
            })
            .map(value)
            .collect();
        for axis in 0..2 {
            let (p, span) = (degrees[axis], self.spans[axis]);
            if p == 0 {
                continue;
            }
            let knots = &bases[axis].knots()[span + 1 - p..=span + p];
            let (low, high) = (knots[p - 1], knots[p]);
            let (lines, step) = if axis == 0 { (counts[1], counts[1]) } else { (counts[0], 1) };
            for line in 0..lines {
                let start = if axis == 0 { line } else { line * counts[1] };
                let controls: Vec<[f64; 1]> = (0..=p).map(|k| [coefficients[start + k * step]]).collect();
                for k in 0..=p {
                    let arguments: Vec<f64> = (0..p).map(|i| if i < p - k { low } else { high }).collect();
                    let [coefficient] = local_blossom(knots, controls.clone(), &arguments);
                    coefficients[start + k * step] = coefficient;
                }
            }
        }
        Form { counts, coefficients }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Dimension, Vector};
    use proptest::prelude::*;

    /// By the sum over Bernstein polynomials.
    fn value(form: &Form, at: [f64; 2]) -> f64 {
        let binomial = |n: usize, k: usize| (1..=k).fold(1.0, |c, i| c * (n + 1 - i) as f64 / i as f64);
        let bernstein = |axis: usize, k: usize| {
            let n = form.counts[axis] - 1;
            binomial(n, k) * at[axis].powi(k as i32) * (1.0 - at[axis]).powi((n - k) as i32)
        };
        let own = |k: usize| (k / form.counts[1], k % form.counts[1]);
        form.coefficients.iter().enumerate().map(|(k, c)| c * bernstein(0, own(k).0) * bernstein(1, own(k).1)).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]
        /// Over every span, and over parts of it, the form is the height times the weight.
        #[test]
        fn it_is_the_height_times_the_weight(
            values in prop::collection::vec(prop::array::uniform3(-9.0..9.0f64), 40),
            weights in prop::collection::vec(0.3..3.0f64, 40),
            (rational, graph) in any::<(bool, bool)>(),
            degrees in prop::array::uniform2(1usize..5),
            normal in prop::array::uniform3(-1.0..1.0f64),
            shares in prop::array::uniform4(0.0..1.0f64),
        ) {
            let basis = |p: usize, n: usize| BSplineBasis::uniform(p, n - p, 1.0, 3.0).unwrap();
            let bases = [basis(degrees[0], 8), basis(degrees[1], 5)];
            let dimension = if graph { Dimension::Graph } else { Dimension::Space };
            let points = values.into_iter().map(Vector::from).collect();
            let heavy = weights.iter().map(|w| Vector::new(*w, 0.0, 0.0)).collect();
            let plain = BSplineSurface::new(bases.clone(), Dimension::Space, heavy, None).unwrap();
            let surface = BSplineSurface::new(bases, dimension, points, rational.then_some(weights)).unwrap();
            let plane = Plane { normal: normal.into(), offset: 0.7 };
            let [a, b, s, t] = shares;
            for i in degrees[0]..8 {
                for j in degrees[1]..5 {
                    let form = Form::of_spans(&surface, &plane, [i, j]);
                    let range = Local { surface: &surface, spans: [i, j] }.range();
                    let [low, high] = [a.min(b), a.max(b) + 1e-3].map(|x: f64| x.min(1.0));
                    let at = |axis: usize, share: f64| range[axis][0] + share * (range[axis][1] - range[axis][0]);
                    let part = form.part([[low, high], [0.25, 0.75]]);
                    let (x, y) = (low + s * (high - low), 0.25 + 0.5 * t);
                    let (u, v) = (at(0, x), at(1, y));
                    let weight = if rational { plain.value(u, v).x } else { 1.0 };
                    let wanted = (plane.normal.dot(&surface.place(u, v).value) - plane.offset) * weight;
                    let [least, most] = part.hull();
                    prop_assert!((value(&form, [x, y]) - wanted).abs() < 1e-11);
                    prop_assert!((value(&part, [s, t]) - wanted).abs() < 1e-11);
                    prop_assert!(least <= wanted + 1e-11 && wanted <= most + 1e-11);
                    let on_side = surface.place(at(0, low), v).value;
                    let weight = if rational { plain.value(at(0, low), v).x } else { 1.0 };
                    let wanted = (plane.normal.dot(&on_side) - plane.offset) * weight;
                    let side = Form { counts: [1, part.counts[1]], coefficients: part.side(0, 0).collect() };
                    prop_assert!((value(&side, [0.0, t]) - wanted).abs() < 1e-11);
                }
            }
        }
    }

    #[test]
    fn a_form_knows_where_it_is_monotone() {
        // u + v², which has no slope along v on one side
        let form = Form { counts: [2, 3], coefficients: vec![0.0, 0.0, 1.0, 1.0, 1.0, 2.0] };
        assert!(form.is_monotone(0, 1e-15) && !form.is_monotone(1, 1e-15));
        let [_, upper] = form.divided(1, 0.5);
        assert!(upper.is_monotone(1, 1e-15));
        assert_eq!(upper.hull(), [0.25, 2.0]);
    }
}
