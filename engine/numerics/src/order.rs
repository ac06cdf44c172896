//! The ascending order of many doubles.
//!
//! Few are compared. Many are ordered digit by digit from the last one on (radix sort; Knuth, The
//! Art of Computer Programming, vol. 3, section 5.2.5), which takes time in proportion to their
//! number and is several times as fast as comparing.

use super::cancel;

/// Numbers from which on digits are cheaper than comparisons.
const MANY: usize = 2_000;
/// Bits of a digit.
const BITS: u32 = 11;

/// Numbers with their places in the list that they came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordered {
    /// The numbers, ascending; −0 comes before 0, NaN at the ends.
    pub sorted: Vec<f64>,
    /// Original index of each number; of equal ones the first comes first.
    pub from: Vec<u32>,
}

/// Orders numbers.
///
/// ```
/// use flankfit_numerics::order::ordered;
///
/// let order = ordered(&[2.0, -1.0, 2.0, 0.5]);
/// assert_eq!(order.sorted, [-1.0, 0.5, 2.0, 2.0]);
/// assert_eq!(order.from, [1, 3, 0, 2]);
/// ```
///
/// # Panics
///
/// With 2³² numbers or more.
pub fn ordered(values: &[f64]) -> Ordered {
    let count = u32::try_from(values.len()).expect("fewer numbers than memory holds");
    let mut keys: Vec<(u64, u32)> = values.iter().map(|&x| key(x)).zip(0..count).collect();
    if keys.len() < MANY {
        keys.sort_unstable();
    } else {
        keys = by_digits(keys);
    }
    Ordered {
        sorted: keys.iter().map(|&(key, _)| number(key)).collect(),
        from: keys.into_iter().map(|(_, k)| k).collect(),
    }
}

/// An integer in the order of the numbers.
fn key(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn number(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}

/// First by the leading digits, after which numbers of random last digits are in order but for few
/// neighbours; by all of them where that is not so.
fn by_digits(keys: Vec<(u64, u32)>) -> Vec<(u64, u32)> {
    let mut leading = by_digits_from(keys, u64::BITS - 3 * BITS);
    if settled(&mut leading) {
        return leading;
    }
    // equal numbers in the order in which they came
    leading.sort_unstable_by_key(|&(_, k)| k);
    by_digits_from(leading, 0)
}

/// Puts neighbours right by insertion; false, and given up, where that takes too many moves.
fn settled(keys: &mut [(u64, u32)]) -> bool {
    let mut left = 4 * keys.len();
    for i in 1..keys.len() {
        let entry = keys[i];
        let mut to = i;
        while to > 0 && keys[to - 1] > entry {
            keys[to] = keys[to - 1];
            to -= 1;
        }
        keys[to] = entry;
        let moves = i - to;
        if moves > left {
            return false;
        }
        left -= moves;
    }
    true
}

/// Sorts by the digits from `first` (a bit) on.
fn by_digits_from(mut keys: Vec<(u64, u32)>, first: u32) -> Vec<(u64, u32)> {
    let mut other = vec![(0, 0); keys.len()];
    for shift in (first..u64::BITS).step_by(BITS as usize) {
        cancel::checkpoint();
        let digit = |key: u64| (key >> shift) as usize & ((1 << BITS) - 1);
        let mut next = [0usize; 1 << BITS];
        keys.iter().for_each(|&(key, _)| next[digit(key)] += 1);
        if next[digit(keys[0].0)] == keys.len() {
            continue;
        }
        let mut sum = 0;
        next.iter_mut().for_each(|count| sum += std::mem::replace(count, sum));
        for &entry in &keys {
            let place = &mut next[digit(entry.0)];
            other[*place] = entry;
            *place += 1;
        }
        std::mem::swap(&mut keys, &mut other);
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by_comparing(values: &[f64]) -> Vec<u32> {
        let mut order: Vec<u32> = (0..values.len() as u32).collect();
        order.sort_by(|&a, &b| values[a as usize].total_cmp(&values[b as usize]));
        order
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn digits_give_the_order_that_comparing_gives(
            values in prop::collection::vec(
                prop_oneof![any::<f64>(), (-3i32..3).prop_map(f64::from), Just(-0.0)],
                1..5_000,
            )
        ) {
            let order = ordered(&values);
            prop_assert_eq!(&order.from, &by_comparing(&values));
            for (x, &k) in order.sorted.iter().zip(&order.from) {
                prop_assert_eq!(x.to_bits(), values[k as usize].to_bits());
            }
        }
    }

    #[test]
    fn numbers_that_differ_in_their_last_digits_are_ordered() {
        let values: Vec<f64> = (0..9_000u64).map(|i| 1.0 + (i * 7919 % 9_000 / 3) as f64 * f64::EPSILON).collect();
        assert_eq!(ordered(&values).from, by_comparing(&values));
    }

    #[test]
    fn many_numbers_of_all_sizes_are_ordered() {
        let values: Vec<f64> = (0..20_000u64)
            .map(|i| f64::from_bits(i.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
            .map(|x| if x.is_nan() { f64::INFINITY } else { x })
            .collect();
        assert_eq!(ordered(&values).from, by_comparing(&values));
    }
}
