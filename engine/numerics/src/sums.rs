//! Compensated sums of slices of doubles, with the result kept in double-double.
//!
//! They behave as if computed in twice the precision: the error is about `len^2 * 2^-106` times the
//! sum of the moduli of the terms. Eight running sums hide the latency of the additions; the order
//! is fixed, so the same slices always give the same bits.

use super::dd::{Dd, two_sum};

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
    fn a_sum_that_cancels_keeps_its_remainder() {
        assert_eq!(sum2(&[1e16, 1.0, -1e16, 1e-3]), Dd::sum(1.0, 1e-3));
        assert_eq!(sum2(&[]), Dd::ZERO);
    }

    proptest! {
        #[test]
        fn integers_sum_exactly(x in prop::collection::vec(-(1i64 << 52)..(1i64 << 52), 0..60)) {
            let exact: i128 = x.iter().map(|&x| i128::from(x)).sum();
            let floats: Vec<f64> = x.iter().map(|&x| x as f64).collect();
            let sum = sum2(&floats);
            prop_assert_eq!(sum.hi as i128 + sum.lo as i128, exact);
        }
    }
}
