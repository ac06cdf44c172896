//! The least value of a function of one variable between two places.

/// Steps at most.
const STEPS: usize = 80;
/// 1 − 1/φ.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Place and height of the least value between `low` and `high`, started at `middle`, a place
/// inside with its height: golden sections, quickened by parabolas (Brent 1973, chapter 5). The
/// place is good to `tolerance`; below √ε of the place rounding hides the minimum.
///
/// ```
/// use flankfit_numerics::minimize::minimum;
///
/// let f = |x: f64| (x - 2.0).powi(2) + 1.0;
/// let (x, height) = minimum([0.0, 5.0], (3.0, f(3.0)), 1e-8, f);
/// assert!((x - 2.0).abs() < 1e-7 && height == 1.0);
/// ```
#[inline]
pub fn minimum(
    [mut low, mut high]: [f64; 2],
    middle: (f64, f64),
    tolerance: f64,
    f: impl Fn(f64) -> f64,
) -> (f64, f64) {
    // the best place so far, the second best, and the one before that
    let ((mut x, mut fx), (mut w, mut fw), (mut v, mut fv)) = (middle, middle, middle);
    let (mut step, mut before) = (0.0f64, 0.0f64);
    for _ in 0..STEPS {
        let centre = 0.5 * (low + high);
        if (x - centre).abs() + 0.5 * (high - low) <= 2.0 * tolerance {
            break;
        }
        let mut parabolic = false;
        if before.abs() > tolerance {
            let (r, q) = ((x - w) * (fx - fv), (x - v) * (fx - fw));
            let (mut p, mut q2) = ((x - v) * q - (x - w) * r, 2.0 * (q - r));
            if q2 > 0.0 {
                p = -p
            } else {
                q2 = -q2
            }
            if p.abs() < (0.5 * q2 * before).abs() && p > q2 * (low - x) && p < q2 * (high - x) {
                (before, step) = (step, p / q2);
                parabolic = true;
            }
        }
        if !parabolic {
            before = if x < centre { high - x } else { low - x };
            step = GOLDEN * before;
        }
        let trial = if step.abs() >= tolerance { x + step } else { x + tolerance.copysign(step) };
        if trial <= low || trial >= high {
            break;
        }
        let ft = f(trial);
        if ft <= fx {
            if trial < x {
                high = x
            } else {
                low = x
            }
            (v, fv, w, fw, x, fx) = (w, fw, x, fx, trial, ft);
        } else {
            if trial < x {
                low = trial
            } else {
                high = trial
            }
            if ft <= fw || w == x {
                (v, fv, w, fw) = (w, fw, trial, ft);
            } else if ft <= fv || v == x || v == w {
                (v, fv) = (trial, ft);
            }
        }
    }
    (x, fx)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn of(low: f64, high: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
        let middle = low + 0.4 * (high - low);
        minimum([low, high], (middle, f(middle)), 1e-9, f)
    }

    /// The ends of an interval, the answer, and the function.
    type Case = (f64, f64, f64, fn(f64) -> f64);

    #[test]
    fn known_minima() {
        let cases: [Case; 5] = [
            (-3.0, 5.0, 1.0, |x| (x - 1.0) * (x - 1.0)),
            (2.0, 6.0, std::f64::consts::PI, f64::cos),
            (0.05, 3.0, 1.0 / std::f64::consts::E, |x| x * x.ln()),
            // a corner, where parabolas mislead
            (-1.0, 2.0, 0.3, |x| (x - 0.3).abs()),
            (-2.0, 1.0, -0.5, |x| (x + 0.5).abs().sqrt()),
        ];
        for (low, high, truth, f) in cases {
            let (x, height) = of(low, high, f);
            assert!((x - truth).abs() < 3e-8, "{x} {truth}");
            assert!(height == f(x) && height <= f(low) && height <= f(high));
        }
    }

    /// Minimisation for smoothing, where each evaluation factors a banded matrix.
    #[test]
    fn parabolas_need_few_evaluations() {
        let evaluations = |tolerance: f64, f: fn(f64) -> f64| {
            let count = Cell::new(0);
            minimum([-2.4, 2.4], (0.0, f(0.0)), tolerance, |x| {
                count.set(count.get() + 1);
                f(x)
            });
            count.get()
        };
        // golden sections alone would need 32
        type Case = (fn(f64) -> f64, usize);
        let cases: [Case; 3] = [
            (|x| (x - 0.7).powi(2), 5),
            (|x| (x - 1.0).exp() - x, 11),
            (|x| (1.0 + (x - 0.3).exp()).ln() - 0.4 * x, 12),
        ];
        for (f, most) in cases {
            let count = evaluations(1e-6, f);
            assert!(count <= most, "{count} {most}");
        }
    }

    #[test]
    fn a_decreasing_function_has_its_minimum_at_the_end() {
        let (x, _) = of(0.0, 1.0, |x| -x);
        assert!(1.0 - x < 1e-7, "{x}");
        // where there is no value, the start remains
        assert_eq!(minimum([0.0, 1.0], (0.5, 1.0), 1e-9, |_| f64::INFINITY).1, 1.0);
    }
}
