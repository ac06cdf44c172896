//! One axis of a B-spline surface, prepared for many evaluations.
//!
//! On each span the functions that are not 0 there are kept as polynomials of `τ = (x −
//! middle)/width`, |τ| ≤ 1/2, with coefficients worked out in double-double. A basis is then one
//! Horner scheme over N functions side by side: no recursion and no division. In τ the coefficients
//! of a polynomial that stays within [0, 1] are small, so that Horner's rule errs by a few
//! roundings of 1.

use crate::BSplineBasis;
use flankfit_numerics::{Dd, fma};

/// The finer the parts, the seldomer a place has to be looked for within its part.
const PARTS_PER_SPAN: usize = 16;

/// Functions of degree up to N − 1; those above the degree are 0.
#[derive(Clone, Debug)]
pub(super) struct Axis<const N: usize> {
    /// The distinct knots of the domain.
    breaks: Vec<f64>,
    pieces: Vec<Piece<N>>,
    /// For each of equal parts of the domain: the span that its lower end lies in.
    parts: Vec<usize>,
    parts_per_unit: f64,
}

#[derive(Clone, Debug)]
struct Piece<const N: usize> {
    /// The first function that is not 0.
    first: usize,
    middle: f64,
    /// 1 / width.
    rate: f64,
    /// `[power][function]`.
    coefficients: [[f64; N]; N],
}

/// Value, first and second derivative of N functions.
pub(super) type Functions<const N: usize> = [[f64; N]; 3];

impl<const N: usize> Axis<N> {
    /// `None` for a degree above N − 1.
    pub(super) fn new(basis: &BSplineBasis) -> Option<Self> {
        let p = basis.degree();
        if p >= N {
            return None;
        }
        let breaks = basis.distinct_knots();
        let pieces: Vec<Piece<N>> = breaks.windows(2).map(|span| piece(basis, span[0], span[1])).collect();
        let (low, high) = (breaks[0], breaks[pieces.len()]);
        let count = PARTS_PER_SPAN * pieces.len();
        let at = |k: usize| low + (high - low) * (k as f64 / count as f64);
        let span = |x: f64| breaks[1..pieces.len()].partition_point(|b| *b <= x);
        let parts = (0..=count).map(|k| span(at(k))).collect();
        Some(Axis { parts, parts_per_unit: count as f64 / (high - low), breaks, pieces })
    }

    /// The span of `x`; the first or the last one for an `x` outside.
    #[inline(always)]
    fn piece(&self, x: f64) -> &Piece<N> {
        // a cast saturates: what lies below is 0
        let part = (((x - self.breaks[0]) * self.parts_per_unit) as usize).min(self.parts.len() - 2);
        let mut span = self.parts[part];
        let end = self.parts[part + 1];
        if end > span + 4 {
            span += self.breaks[span + 1..=end].partition_point(|b| *b <= x);
        }
        while span + 1 < self.pieces.len() && x >= self.breaks[span + 1] {
            span += 1;
        }
        // rounding may have put x a part too high
        while span > 0 && x < self.breaks[span] {
            span -= 1;
        }
        &self.pieces[span]
    }

    /// The functions with derivatives to `ORDER`, and the first one's index.
    #[inline(always)]
    pub(super) fn at<const ORDER: usize>(&self, x: f64) -> (usize, Functions<N>) {
        let piece = self.piece(x);
        let t = (x - piece.middle) * piece.rate;
        let mut sums: Functions<N> = [[0.0; N]; 3];
        for coefficients in piece.coefficients.iter().rev() {
            for i in 0..N {
                if ORDER > 1 {
                    sums[2][i] = fma(sums[2][i], t, sums[1][i]);
                }
                if ORDER > 0 {
                    sums[1][i] = fma(sums[1][i], t, sums[0][i]);
                }
                sums[0][i] = fma(sums[0][i], t, coefficients[i]);
            }
        }
        if ORDER > 0 {
            let (first, second) = (piece.rate, 2.0 * piece.rate * piece.rate);
            for i in 0..N {
                sums[1][i] *= first;
                sums[2][i] *= second;
            }
        }
        (piece.first, sums)
    }
}

/// The polynomials of one span, from their derivatives at its middle.
fn piece<const N: usize>(basis: &BSplineBasis, low: f64, high: f64) -> Piece<N> {
    let p = basis.degree();
    let middle = 0.5 * low + 0.5 * high;
    let width = high - low;
    let mut coefficients = [[0.0; N]; N];
    let (mut first, mut scale) = (0, Dd::ONE);
    for (power, row) in coefficients.iter_mut().enumerate().take(p + 1) {
        let mut values = [Dd::ZERO; N];
        first = basis.derivatives_of(power, middle, &mut values[..=p]);
        if power > 0 {
            scale = scale * width / power as f64;
        }
        for (c, d) in row.iter_mut().zip(values) {
            *c = (d * scale).to_f64();
        }
    }
    Piece { first, middle, rate: 1.0 / width, coefficients }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_those_of_the_basis() {
        let knots = vec![-1.0, 0.0, 0.0, 0.0, 1e-3, 0.5, 0.5, 2.0, 2.0, 2.0, 7.0, 9.0];
        let basis = BSplineBasis::new(3, knots).unwrap();
        let axis = Axis::<4>::new(&basis).unwrap();
        for k in 0..=2000 {
            let x = 2.0 * f64::from(k) / 2000.0;
            let (first, functions) = axis.at::<2>(x);
            for order in 0..3 {
                let mut truth = [0.0; 4];
                assert_eq!(basis.derivatives_of(order, x, &mut truth), first, "{x}");
                let size = truth.iter().fold(1.0f64, |a, b| a.max(b.abs()));
                for i in 0..4 {
                    assert!((functions[order][i] - truth[i]).abs() <= 1e-14 * size, "{x} {order} {i}");
                }
            }
        }
        assert_eq!(axis.at::<0>(-5.0).0, basis.values(-5.0, &mut [0.0; 4]));
        assert_eq!(axis.at::<0>(50.0).0, basis.values(50.0, &mut [0.0; 4]));
    }

    #[test]
    fn lower_degrees_are_filled_up_with_zeros() {
        let basis = BSplineBasis::uniform(1, 3, 0.0, 3.0).unwrap();
        assert_eq!(
            Axis::<4>::new(&basis).unwrap().at::<1>(1.25),
            (1, [[0.75, 0.25, 0.0, 0.0], [-1.0, 1.0, 0.0, 0.0], [0.0; 4]])
        );
        assert!(Axis::<4>::new(&BSplineBasis::uniform(4, 1, 0.0, 1.0).unwrap()).is_none());
    }
}
