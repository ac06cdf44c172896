//! Contribution of two incompatible twists at a corner to a patch (Gregory 1974).
//!
//! Cross-boundary derivatives given along two borders that meet may disagree about the mixed
//! derivative at the corner. Gregory's remedy weighs both, `T = (s Tᵤ + t Tᵥ) / (s + t)`, with s
//! and t the local parameters from the corner. Written as `T = (Tᵤ + Tᵥ)/2 + (Tᵤ − Tᵥ)/2 · (s −
//! t)/(s + t)` everything rational is in one function, whose derivatives are worked out here in a
//! form that neither divides by small numbers nor cancels.

use super::jets::{NumberJet, product};

/// The jet of `W(s, t) = (1 − s)² (1 − t)² φ(s, t)` with `φ = s t (s − t)/(s + t)`.
///
/// With r = s/(s+t) and w = t/(s+t): φ_s = t (r − w + 2rw), φ_t = s (r − w − 2rw), φ_ss = 4w³, φ_tt
/// = −4r³ and φ_st = (r − w)(1 + 2rw). The second derivatives are functions of direction alone and
/// have no limit at the corner. There they are replaced by φ_ss along t = 0, φ_tt along s = 0
/// and φ_st along the diagonal: 0, all three.
pub(super) fn twist_share(s: f64, t: f64) -> NumberJet {
    let sum = s + t;
    let phi = if sum == 0.0 {
        [0.0; 6]
    } else {
        let (r, w) = (s / sum, t / sum);
        let difference = (s - t) / sum;
        let double = 2.0 * r * w;
        [
            s * t * difference,
            t * (difference + double),
            s * (difference - double),
            4.0 * w * w * w,
            difference * (1.0 + double),
            -4.0 * r * r * r,
        ]
    };
    let fade = |x: f64| [(1.0 - x) * (1.0 - x), -2.0 * (1.0 - x), 2.0];
    let f = product(fade(s), fade(t));
    [
        f[0] * phi[0],
        f[1] * phi[0] + f[0] * phi[1],
        f[2] * phi[0] + f[0] * phi[2],
        f[3] * phi[0] + 2.0 * f[1] * phi[1] + f[0] * phi[3],
        f[4] * phi[0] + f[1] * phi[2] + f[2] * phi[1] + f[0] * phi[4],
        f[5] * phi[0] + 2.0 * f[2] * phi[2] + f[0] * phi[5],
    ]
}

/// [`twist_share`] of the corner (i, j) of the unit square, by the square's own parameters.
pub(super) fn twist_share_at(corner: [usize; 2], s: f64, t: f64) -> NumberJet {
    let local = |end: usize, x: f64| if end == 0 { x } else { 1.0 - x };
    let sign = |end: usize| if end == 0 { 1.0 } else { -1.0 };
    let [a, b] = corner.map(sign);
    let [w, ws, wt, wss, wst, wtt] = twist_share(local(corner[0], s), local(corner[1], t));
    [w, a * ws, b * wt, wss, a * b * wst, wtt]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every derivative against the central difference of the one below it.
    #[test]
    fn derivatives_agree_with_differences() {
        let h = 1e-6;
        for corner in [[0, 0], [0, 1], [1, 0], [1, 1]] {
            let at = |s: f64, t: f64| twist_share_at(corner, s, t);
            for (s, t) in [(0.3, 0.4), (0.9, 0.2), (0.01, 0.6), (0.5, 0.5)] {
                let here = at(s, t);
                let (by_s, by_t) = ((at(s + h, t), at(s - h, t)), (at(s, t + h), at(s, t - h)));
                let slope = |(high, low): &(NumberJet, NumberJet), k: usize| (high[k] - low[k]) / (2.0 * h);
                for (derivative, below, pair) in
                    [(1, 0, &by_s), (2, 0, &by_t), (3, 1, &by_s), (4, 1, &by_t), (4, 2, &by_s), (5, 2, &by_t)]
                {
                    assert!((here[derivative] - slope(pair, below)).abs() < 1e-8, "{corner:?} {s} {t} {derivative}");
                }
            }
        }
    }

    #[test]
    fn it_vanishes_on_the_borders_and_stays_finite_at_the_corner() {
        assert_eq!(twist_share(0.0, 0.0), [0.0; 6]);
        for x in [0.0, 1e-300, 0.5, 1.0] {
            assert_eq!(twist_share(0.0, x)[0], 0.0);
            assert_eq!(twist_share(x, 0.0)[0], 0.0);
        }
        assert!(twist_share(1e-200, 3e-200).iter().all(|d| d.is_finite() && d.abs() <= 4.0));
    }
}
