//! Compensated sums and products of slices of doubles, with the result kept in double-double.
//!
//! Both behave as if computed in twice the precision: the error is about `len^2 * 2^-106` times the
//! sum of the moduli of the terms. Eight running sums hide the latency of the additions; the order
//! is fixed, so the same slices always give the same bits.

use super::{
    dd::{Dd, two_sum},
    with_fma,
};

const LANES: usize = 8;

/// The sum of the entries of `x`.
///
/// ```
/// use flankfit_numerics::sum2;
///
/// // Added up in order, doubles lose the 1.
/// assert_eq!(1e16 + 1.0 - 1e16, 0.0);
/// assert_eq!(sum2(&[1e16, 1.0, -1e16]).to_f64(), 1.0);
/// ```
pub fn sum2(x: &[f64]) -> Dd {
    let mut high = [0.0; LANES];
    let mut low = [0.0; LANES];
    let (blocks, rest) = x.as_chunks::<LANES>();
    for block in blocks {
        for k in 0..LANES {
            let (s, e) = two_sum(high[k], block[k]);
            high[k] = s;
            low[k] += e;
        }
    }
    for (k, &value) in rest.iter().enumerate() {
        let (s, e) = two_sum(high[k], value);
        high[k] = s;
        low[k] += e;
    }
    gather(high, low)
}

with_fma! {
    /// The scalar product of `x` and `y`, over the shorter of the two.
    ///
    /// ```
    /// use flankfit_numerics::dot2;
    ///
    /// assert_eq!(dot2(&[1e8, 1.0, -1e8], &[1e8, 1.0, 1e8]).to_f64(), 1.0);
    /// ```
    pub fn dot2(x: &[f64], y: &[f64]) -> Dd {
        let len = x.len().min(y.len());
        let mut high = [0.0; LANES];
        let mut low = [0.0; LANES];
        let (x_blocks, x_rest) = x[..len].as_chunks::<LANES>();
        let (y_blocks, y_rest) = y[..len].as_chunks::<LANES>();
        for (x, y) in x_blocks.iter().zip(y_blocks) {
            for k in 0..LANES {
                let (p, e) = (x[k] * y[k], x[k].mul_add(y[k], -(x[k] * y[k])));
                let (s, f) = two_sum(high[k], p);
                high[k] = s;
                low[k] += e + f;
            }
        }
        for (k, (&x, &y)) in x_rest.iter().zip(y_rest).enumerate() {
            let (p, e) = (x * y, x.mul_add(y, -(x * y)));
            let (s, f) = two_sum(high[k], p);
            high[k] = s;
            low[k] += e + f;
        }
        gather(high, low)
    }
}

fn gather(high: [f64; LANES], low: [f64; LANES]) -> Dd {
    let mut total = Dd::ZERO;
    for k in 0..LANES {
        total += Dd::sum(high[k], low[k]);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_sum_that_cancels_keeps_what_is_left() {
        assert_eq!(sum2(&[1e16, 1.0, -1e16, 1e-3]), Dd::sum(1.0, 1e-3));
        assert_eq!(sum2(&[]), Dd::ZERO);
    }

    #[test]
    fn the_shorter_slice_counts() {
        assert_eq!(dot2(&[1.0, 2.0, 3.0], &[4.0, 5.0]), Dd::from(14.0));
    }

    proptest! {
        #[test]
        fn integers_sum_exactly(x in prop::collection::vec(-(1i64 << 52)..(1i64 << 52), 0..60)) {
            let exact: i128 = x.iter().map(|&x| i128::from(x)).sum();
            let floats: Vec<f64> = x.iter().map(|&x| x as f64).collect();
            let sum = sum2(&floats);
            prop_assert_eq!(sum.hi as i128 + sum.lo as i128, exact);
        }

        #[test]
        fn integers_multiply_exactly(x in prop::collection::vec((-(1i64 << 48)..(1i64 << 48),
            -(1i64 << 48)..(1i64 << 48)), 0..40)) {
            let exact: i128 = x.iter().map(|&(x, y)| i128::from(x) * i128::from(y)).sum();
            let (x, y): (Vec<f64>, Vec<f64>) = x.iter().map(|&(x, y)| (x as f64, y as f64)).unzip();
            let dot = dot2(&x, &y);
            prop_assert_eq!(dot.hi as i128 + dot.lo as i128, exact);
        }
    }
}
