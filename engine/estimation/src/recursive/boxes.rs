//! Boxes with a margin around the nodes seen so far.

use crate::design::power_of_two;

/// Returns a box around `[low, high]` with some margin whose half-width is a power of 2 and whose
/// centre is a multiple of an eighth of it, so that mapping it to [-1, 1] is exact.
pub(super) fn roomy([low, high]: [f64; 2]) -> [f64; 2] {
    /// Half-width around a lone 0.
    const LONE: f64 = 1.0 / 1_048_576.0;
    /// Narrowest half-width against the distance from 0.
    const NARROW: f64 = 1.0 / (1u64 << 40) as f64;
    let far = low.abs().max(high.abs());
    let half = (0.5 * high - 0.5 * low).max(far * NARROW);
    let wanted = 1.25 * if half > 0.0 { half } else { LONE };
    let below = power_of_two(wanted);
    let half = if below < wanted { 2.0 * below } else { below };
    let step = 0.125 * half;
    let center = ((0.5 * low + 0.5 * high) / step).round() * step;
    [center - half, center + half]
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_geometry::Mapping;

    #[test]
    fn boxes_are_wide_enough_and_map_exactly() {
        for [low, high] in [[0.0, 0.0], [30.0, 34.0], [-1e-9, 1e-9], [1e9, 1e9], [1e300, 1e300], [0.1, 0.3]] {
            let [a, b] = roomy([low, high]);
            assert!(a <= low && high <= b && a < b, "{low} {high}: {a} {b}");
            let map = Mapping::over(a, b);
            assert_eq!((map.map::<f64>(a), map.map::<f64>(b)), (-1.0, 1.0));
            assert_eq!(map.scale, power_of_two(map.scale));
        }
    }
}
