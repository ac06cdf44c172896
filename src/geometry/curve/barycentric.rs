//! The form of Lagrange (Eqs. 1 and 2), written barycentrically: `p(x) = Σ wᵢ yᵢ / (x − xᵢ) / Σ wᵢ / (x − xᵢ)`.
//!
//! A value costs O(n), is exact at the nodes and stable near them (Berrut and Trefethen 2004). Derivatives would lose digits near nodes in
//! that formula; they come from Newton's form over the same nodes in the order of Leja, which is stable at every place. That
//! form is kept over the axis scaled by a power of two to the length around 4 that neither overflows nor underflows.

use super::{CurveJet, fault::CurveFault, newton::Newton};
use crate::geometry::space::Vector;
use crate::numerics::Dd;
use crate::numerics::dd::{exponent_of, ldexp};

/// Weights outside of this range are scaled together by a power of two.
const LARGEST_WEIGHT: f64 = 1e280;

/// A polynomial in the barycentric form.
#[derive(Clone, Debug, PartialEq)]
pub struct Barycentric {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    values: Vec<Vector>,
    /// The same polynomial over `x · 2^exponent`.
    leja: Newton,
    exponent: i32,
}

impl Barycentric {
    /// The polynomial through `values` at `nodes`: as many, at least two, finite, and no node twice.
    pub fn new(nodes: Vec<f64>, values: Vec<Vector>) -> Result<Self, CurveFault> {
        let (low, high) = nodes.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        // half of each, so that the difference does not overflow
        let half = 0.5 * high - 0.5 * low;
        if !(half > 0.0) {
            return Err(CurveFault::NotRepresentable { index: 0 });
        }
        let exponent = -exponent_of(half);
        let scaled: Vec<f64> = nodes.iter().map(|x| ldexp(*x, exponent)).collect();
        let mut leja = Newton::default();
        for i in order_of_leja(&scaled) {
            leja.push(scaled[i], values[i])?;
        }
        let weights = weights(&scaled, exponent);
        Ok(Barycentric { nodes, weights, values, leja, exponent })
    }

    /// Abscissae, in the order given.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// `wᵢ = 1 / Π (xᵢ − xⱼ)`; where these overflow or underflow, all times one power of two, which changes nothing.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Ordinates or points, in the order given.
    pub fn values(&self) -> &[Vector] {
        &self.values
    }

    /// The value at `t`.
    pub fn value(&self, t: f64) -> Vector {
        let (mut numerator, mut denominator) = (Vector::zeros(), 0.0);
        for ((x, w), y) in self.nodes.iter().zip(&self.weights).zip(&self.values) {
            let share = w / (t - x);
            if !share.is_finite() {
                return *y;
            }
            numerator += y * share;
            denominator += share;
        }
        numerator / denominator
    }

    /// `Σ |Lᵢ(t)|`: how much an error in the values is amplified at `t` at most.
    pub(super) fn amplification(&self, t: f64) -> f64 {
        let (mut sizes, mut sum) = (0.0, 0.0);
        for (x, w) in self.nodes.iter().zip(&self.weights) {
            let share = w / (t - x);
            if !share.is_finite() {
                return 1.0;
            }
            sizes += share.abs();
            sum += share;
        }
        (sizes / sum).abs()
    }

    /// Value and derivatives to order 3.
    pub fn jet(&self, t: f64) -> CurveJet {
        let mut jet = self.leja.jet::<f64>(ldexp(t, self.exponent));
        jet[0] = self.value(t);
        for (order, derivative) in jet.iter_mut().enumerate().skip(1) {
            *derivative = derivative.map(|x| ldexp(x, self.exponent * order as i32));
        }
        jet
    }

    /// The polynomial over `x · 2^exponent` in Newton's form, with that exponent.
    pub(super) fn scaled_newton(&self) -> (&Newton, i32) {
        (&self.leja, self.exponent)
    }
}

/// Each next node is the one whose distances to all before it have the largest product.
pub(super) fn order_of_leja(nodes: &[f64]) -> Vec<usize> {
    let mut products: Vec<f64> = nodes.iter().map(|x| x.abs()).collect();
    let mut order = Vec::with_capacity(nodes.len());
    let mut taken = vec![false; nodes.len()];
    for step in 0..nodes.len() {
        let mut best = None;
        for i in (0..nodes.len()).filter(|i| !taken[*i]) {
            if best.is_none_or(|b: usize| products[i] > products[b]) {
                best = Some(i);
            }
        }
        let Some(next) = best else { break };
        taken[next] = true;
        order.push(next);
        for i in 0..nodes.len() {
            let distance = (nodes[i] - nodes[next]).abs().log2();
            products[i] = if step == 0 { distance } else { products[i] + distance };
        }
    }
    order
}

/// Weights of the unscaled nodes, from nodes scaled to a length between 2 and 4.
fn weights(scaled: &[f64], exponent: i32) -> Vec<f64> {
    let weight = |(i, x): (usize, &f64)| {
        let others = scaled.iter().enumerate().filter(|(j, _)| *j != i);
        others.fold(Dd::ONE, |product, (_, z)| product * Dd::diff(*x, *z)).recip().to_f64()
    };
    let weights: Vec<f64> = scaled.iter().enumerate().map(weight).collect();
    // 1 / Π (x − z) of the unscaled nodes is 2^((n − 1) exponent) times this
    let back = (scaled.len() as i32 - 1) * exponent;
    let unscaled: Vec<f64> = weights.iter().map(|w| ldexp(*w, back)).collect();
    let fits = |w: &f64| w.abs() < LARGEST_WEIGHT && w.abs() > LARGEST_WEIGHT.recip();
    if unscaled.iter().all(fits) { unscaled } else { weights }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chebyshev(n: usize, low: f64, high: f64) -> Vec<f64> {
        let angle = |i: usize| std::f64::consts::PI * (2 * i + 1) as f64 / (2 * n) as f64;
        (0..n).map(|i| 0.5 * (low + high) - 0.5 * (high - low) * angle(i).cos()).collect()
    }

    #[test]
    fn two_hundred_nodes_of_a_smooth_function() {
        let nodes = chebyshev(200, 0.0, 6000.0);
        let values = nodes.iter().map(|x| Vector::new((x / 100.0).sin(), 1.0, 0.0)).collect();
        let polynomial = Barycentric::new(nodes.clone(), values).unwrap();
        for x in [0.0, 0.3, nodes[17], nodes[17] + 1e-9, 3000.0, 5999.0] {
            let jet = polynomial.jet(x);
            let (s, c) = (x / 100.0).sin_cos();
            for (order, exact) in [s, c * 1e-2, -s * 1e-4, -c * 1e-6].into_iter().enumerate() {
                let size = 0.01f64.powi(order as i32);
                assert!((jet[order].x - exact).abs() < 1e-8 * size, "{x} {order} {} {exact}", jet[order].x);
            }
            assert_eq!(polynomial.value(nodes[17]), polynomial.values()[17]);
            assert!((jet[0].y - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn nodes_that_half_of_their_distance_cannot_tell_apart() {
        let tiny = Barycentric::new(vec![0.0, f64::from_bits(1)], vec![Vector::zeros(); 2]);
        assert!(matches!(tiny, Err(CurveFault::NotRepresentable { .. })));
        // but far below and above what squares of doubles can tell
        for size in [1e-300, 1e300] {
            let values = vec![Vector::zeros(), Vector::x(), Vector::zeros()];
            let hill = Barycentric::new(vec![-size, 0.0, size], values).unwrap();
            assert!((hill.value(0.5 * size).x - 0.75).abs() < 1e-15);
            assert!((hill.jet(0.5 * size)[1].x * size + 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn weights_of_equal_steps_are_binomials() {
        let nodes: Vec<f64> = (0..5).map(f64::from).collect();
        let polynomial = Barycentric::new(nodes, vec![Vector::zeros(); 5]).unwrap();
        assert_eq!(polynomial.weights(), [1.0, -4.0, 6.0, -4.0, 1.0].map(|w| w / 24.0));
    }
}
