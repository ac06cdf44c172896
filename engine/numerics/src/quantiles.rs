//! Medians and quantiles of finite numbers.
//!
//! A quantile between two order statistics is interpolated linearly (type 7 of Hyndman and Fan,
//! what most statistical programs give unasked); the median is the middle one, or the mean of the
//! two in the middle.

/// The median; `values` is put into another order. NaN for no values.
///
/// ```
/// use flankfit_numerics::quantiles::median;
///
/// assert_eq!(median(&mut [9.0, 1.0, 2.0, 3.0]), 2.5);
/// ```
pub fn median(values: &mut [f64]) -> f64 {
    let n = values.len();
    if n == 0 {
        return f64::NAN;
    }
    let (below, middle, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        return *middle;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    midpoint(lower, *middle)
}

/// The quantile of order `p` in [0, 1] of ascending values. NaN for no values.
pub fn quantile(ascending: &[f64], p: f64) -> f64 {
    let Some(last) = ascending.len().checked_sub(1) else { return f64::NAN };
    let place = p.clamp(0.0, 1.0) * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    let (low, high) = (ascending[below], ascending[above]);
    let share = place - below as f64;
    if share == 0.0 { low } else { low + share * (high - low) }
}

/// Between two numbers, without overflow.
fn midpoint(a: f64, b: f64) -> f64 {
    0.5 * a + 0.5 * b
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_values() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!(median(&mut [7.0]), 7.0);
        assert!(median(&mut []).is_nan() && quantile(&[], 0.5).is_nan());
        let values = [1.0, 2.0, 3.0, 4.0];
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(|p| quantile(&values, p)), [1.0, 1.75, 2.5, 3.25, 4.0]);
    }

    proptest! {
        #[test]
        fn the_median_is_the_middle_of_the_sorted(mut values in prop::collection::vec(-1e6..1e6f64, 1..40)) {
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let n = sorted.len();
            let middle = 0.5 * sorted[(n - 1) / 2] + 0.5 * sorted[n / 2];
            prop_assert_eq!(median(&mut values), middle);
            prop_assert!((quantile(&sorted, 0.5) - middle).abs() <= 1e-9);
        }
    }
}
