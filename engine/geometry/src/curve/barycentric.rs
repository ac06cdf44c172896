//! The form of Lagrange (Eqs. 1 and 2), written barycentrically: `p(x) = Σ wᵢ yᵢ / (x − xᵢ) / Σ wᵢ
//! / (x − xᵢ)`.
//!
//! A value costs O(n), is exact at the nodes and stable near them (Berrut and Trefethen 2004).
//! Where the nodes amplify errors (between many equal steps), the denominator, which is 1 / ℓ(x)
//! with ℓ(x) = Π (x − xᵢ), cancels to noise; there the first form of the formula is taken, `p(x) =
//! ℓ(x) Σ wᵢ yᵢ / (x − xᵢ)`, which is backward stable (Higham 2004), in double-double and with
//! exponents of its own, since products over hundreds of nodes leave the range of doubles.
//!
//! Derivatives would lose digits near nodes in either formula; they come from Newton's form over
//! the same nodes in the order of Leja. All is kept over the axis scaled by a power of two to the
//! length around 4 that neither overflows nor underflows.

use super::{CurveJet, check, newton::Newton};
use crate::space::Vector;
use flankfit_numerics::{
    Dd, cancel,
    check::Faults,
    dd::{exponent_of, ldexp},
};

/// Weights outside of this range are scaled together by a power of two.
const LARGEST_WEIGHT: f64 = 1e280;

/// Amplification of errors above which values are summed in double-double.
const TAME: f64 = 1e3;

/// Ratio of weights above which derivatives are too.
const EVEN: f64 = 1e4;

/// A polynomial in the barycentric form.
#[derive(Clone, Debug, PartialEq)]
pub struct Barycentric {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    values: Vec<Vector>,
    /// Nodes times `2^exponent`.
    scaled: Vec<f64>,
    /// Weights of the scaled nodes.
    factors: Vec<Scaled>,
    /// The same over a common power of two, the largest around 1.
    shares: Vec<f64>,
    /// Whether these are of like size.
    is_even: bool,
    /// The same polynomial over `x · 2^exponent`.
    leja: Newton,
    exponent: i32,
}

impl Barycentric {
    /// The polynomial through `values` at `nodes`: as many, at least two, finite, and no node
    /// twice.
    pub fn new(nodes: Vec<f64>, values: Vec<Vector>) -> Result<Self, Faults> {
        let (low, high) = nodes.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        // half of each, so that the difference does not overflow
        let half = 0.5 * high - 0.5 * low;
        if !(half > 0.0) {
            return Err(check::not_representable(0));
        }
        let exponent = -exponent_of(half);
        let scaled: Vec<f64> = nodes.iter().map(|x| ldexp(*x, exponent)).collect();
        // nodes far closer to 0 than the domain is long would lose digits, or become one
        if let Some(index) = (0..nodes.len()).find(|&i| ldexp(scaled[i], -exponent) != nodes[i]) {
            return Err(check::not_representable(index));
        }
        let mut leja = Newton::default();
        for i in order_of_leja(&scaled) {
            leja.push(scaled[i], values[i])?;
        }
        let factors: Vec<Scaled> = (0..scaled.len()).map(|i| factor(&scaled, i)).collect();
        let largest = factors.iter().map(|w| w.exponent).max().unwrap_or(0);
        let shares: Vec<f64> = factors.iter().map(|w| w.times_pow2(-largest).to_f64()).collect();
        let is_even = shares.iter().all(|w| w.abs() * EVEN > 1.0);
        let weights = weights(&factors, &shares, exponent);
        Ok(Barycentric { nodes, weights, values, scaled, factors, shares, is_even, leja, exponent })
    }

    /// Abscissae, in the order given.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// `wᵢ = 1 / Π (xᵢ − xⱼ)`; where these overflow or underflow, all times one power of two, which
    /// changes nothing.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Ordinates or points, in the order given.
    pub fn values(&self) -> &[Vector] {
        &self.values
    }

    /// The value at `t`.
    pub fn value(&self, t: f64) -> Vector {
        if let Some(at) = self.nodes.iter().position(|x| *x == t) {
            return self.values[at];
        }
        let place = ldexp(t, self.exponent);
        let (mut numerator, mut denominator, mut sizes) = (Vector::zeros(), 0.0f64, 0.0);
        for ((x, w), y) in self.scaled.iter().zip(&self.shares).zip(&self.values) {
            let share = w / (place - x);
            if !share.is_finite() {
                return *y;
            }
            numerator += y * share;
            denominator += share;
            sizes += share.abs();
        }
        if sizes <= TAME * denominator.abs() { numerator / denominator } else { self.first_form(place) }
    }

    /// ℓ(t) Σ wᵢ yᵢ / (t − xᵢ) in double-double, at a place of the scaled axis.
    fn first_form(&self, t: f64) -> Vector {
        let mut sums = [Dd::ZERO; 3];
        for (share, y) in self.cardinals(t).zip(&self.values) {
            for (sum, y) in sums.iter_mut().zip(y.iter()) {
                // so that no share outside the range of doubles meets a 0
                if *y != 0.0 {
                    *sum += share * *y;
                }
            }
        }
        Vector::from(sums.map(Dd::to_f64))
    }

    /// Lᵢ(t) for every node, at a place of the scaled axis that is none of them.
    fn cardinals(&self, t: f64) -> impl Iterator<Item = Dd> {
        let all = Scaled::product(self.scaled.iter().map(|x| Dd::diff(t, *x)));
        let share = move |(x, w): (&f64, &Scaled)| {
            let distance = Dd::diff(t, *x);
            let low = exponent_of(distance.hi);
            let mantissa = all.mantissa * w.mantissa / distance.ldexp(-low);
            mantissa.ldexp(all.exponent + w.exponent - low)
        };
        self.scaled.iter().zip(&self.factors).map(share)
    }

    /// `Σ |Lᵢ(t)|`: how much an error in the values is amplified at `t` at most. Infinite where
    /// that leaves the range of doubles.
    pub(super) fn amplification(&self, t: f64) -> f64 {
        let place = ldexp(t, self.exponent);
        if self.nodes.contains(&t) || self.scaled.contains(&place) {
            return 1.0;
        }
        let sum: f64 = self.cardinals(place).map(|share| share.hi.abs()).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    /// Value and derivatives to order 3.
    pub fn jet(&self, t: f64) -> CurveJet {
        let place = ldexp(t, self.exponent);
        let mut jet = if self.is_even { self.leja.jet::<f64>(place) } else { self.leja.jet::<Dd>(place) };
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
        cancel::checkpoint();
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

/// `mantissa · 2^exponent`, the mantissa's size from 1 to below 2.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scaled {
    mantissa: Dd,
    exponent: i32,
}

impl Scaled {
    fn new(x: Dd) -> Self {
        let exponent = exponent_of(x.hi);
        Scaled { mantissa: x.ldexp(-exponent), exponent }
    }

    /// Product of factors that are not 0.
    fn product(factors: impl Iterator<Item = Dd>) -> Self {
        factors.fold(Scaled { mantissa: Dd::ONE, exponent: 0 }, |product, factor| {
            let factor = Scaled::new(factor);
            let next = Scaled::new(product.mantissa * factor.mantissa);
            Scaled { exponent: product.exponent + factor.exponent + next.exponent, ..next }
        })
    }

    fn recip(self) -> Self {
        let inverse = Scaled::new(self.mantissa.recip());
        Scaled { exponent: inverse.exponent - self.exponent, ..inverse }
    }

    fn times_pow2(self, exponent: i32) -> Dd {
        self.mantissa.ldexp(self.exponent + exponent)
    }
}

/// `1 / Π (xᵢ − xⱼ)`.
fn factor(nodes: &[f64], i: usize) -> Scaled {
    let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
    Scaled::product(others.map(|(_, z)| Dd::diff(nodes[i], *z))).recip()
}

/// Weights of the unscaled nodes where these fit, else those of a common power of two.
fn weights(factors: &[Scaled], shares: &[f64], exponent: i32) -> Vec<f64> {
    // 1 / Π (x − z) of the unscaled nodes is 2^((n − 1) exponent) times that of the scaled ones
    let back = (factors.len() as i32 - 1) * exponent;
    let unscaled: Vec<f64> = factors.iter().map(|w| w.times_pow2(back).to_f64()).collect();
    let fits = |w: &f64| w.abs() < LARGEST_WEIGHT && w.abs() > LARGEST_WEIGHT.recip();
    if unscaled.iter().all(fits) { unscaled } else { shares.to_vec() }
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
    fn adjacent_doubles_are_refused_as_nodes() {
        let tiny = Barycentric::new(vec![0.0, f64::from_bits(1)], vec![Vector::zeros(); 2]);
        assert_eq!(tiny, Err(check::not_representable(0)));
        // but far below and above what squares of doubles can tell
        for size in [1e-300, 1e300] {
            let values = vec![Vector::zeros(), Vector::x(), Vector::zeros()];
            let hill = Barycentric::new(vec![-size, 0.0, size], values).unwrap();
            assert!((hill.value(0.5 * size).x - 0.75).abs() < 1e-15);
            assert!((hill.jet(0.5 * size)[1].x * size + 1.0).abs() < 1e-15);
        }
    }

    /// The function of Runge on [-1, 1] between equal steps.
    fn runge(n: usize) -> Barycentric {
        let nodes: Vec<f64> = (0..n).map(|i| -1.0 + 2.0 * i as f64 / (n - 1) as f64).collect();
        let values = nodes.iter().map(|x| Vector::new(1.0 / (1.0 + 25.0 * x * x), 0.0, 0.0)).collect();
        Barycentric::new(nodes, values).unwrap()
    }

    /// Against sums of exact fractions over the same doubles.
    #[test]
    fn equidistant_nodes_amplify_as_exact_fractions_do() {
        for (n, t, value, amplification) in [
            (31, 0.97, 1662.1783381525581, 4605639.866054569),
            (71, -1.0 + 1.0 / 70.0, 5127422237.461793, 1.16946415881031e18),
            (101, -0.99, -563075414810865.0, 7.291146362568355e26),
            (101, -0.996, -1358122842314242.0, 1.7575495454880397e27),
            (201, 0.997, 1.5974518729683015e40, 7.634976723984423e56),
        ] {
            let polynomial = runge(n);
            let near = |found: f64, exact: f64| (found / exact - 1.0).abs() < 1e-13;
            assert!(near(polynomial.value(t).x, value), "{n}: {:e} {value:e}", polynomial.value(t).x);
            assert!(near(polynomial.amplification(t), amplification), "{n}: {:e}", polynomial.amplification(t));
            assert_eq!(polynomial.jet(t)[0], polynomial.value(t));
        }
        let slope = runge(71).jet(-1.0 + 1.0 / 70.0)[1].x;
        assert!((slope / -751096678390.816 - 1.0).abs() < 1e-10, "{slope:e}");
        // as many nodes as there may be: products of distances far outside of the range of doubles
        let most = runge(500);
        let found = most.amplification(0.9995);
        assert!(found > 1e140 && found < 1e150 && most.value(0.9995).x.is_finite(), "{found:e}");
    }

    /// Nodes that scaling to the length of the domain would merge, or of which it would take
    /// digits.
    #[test]
    fn nodes_far_closer_than_the_domain_is_long() {
        let hill = Barycentric::new(vec![0.0, 1e-300, 1e300], vec![Vector::zeros(), Vector::x(), Vector::zeros()]);
        assert_eq!(hill, Err(check::not_representable(1)));
    }

    #[test]
    fn weights_of_equal_steps_are_binomials() {
        let nodes: Vec<f64> = (0..5).map(f64::from).collect();
        let polynomial = Barycentric::new(nodes, vec![Vector::zeros(); 5]).unwrap();
        assert_eq!(polynomial.weights(), [1.0, -4.0, 6.0, -4.0, 1.0].map(|w| w / 24.0));
    }
}
