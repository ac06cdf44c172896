//! Roots between two places where a function has different signs, and the place where a predicate
//! changes.
//!
//! [`root`] is Chandrupatla's method (1997): inverse quadratic interpolation where it is safe, else
//! bisection. [`boundary`] halves, for functions that only say on which side a place lies.

/// From this step on [`root`] only halves, so that it ends.
const INTERPOLATED: usize = 40;
/// Steps at most: enough to halve any bracket down to neighbouring doubles in practice.
const STEPS: usize = 200;

/// A root of `f` between two places with their values; `None` where the signs are the same. Ends
/// where the bracket is narrower than `tolerance(x)`, where f is 0, or where f has no value (NaN):
/// the better end is returned.
///
/// ```
/// use flankfit_numerics::root::root;
///
/// let x = root([(1.0, -1.0), (2.0, 2.0)], |_| 1e-15, |x| x * x - 2.0);
/// assert!((x.unwrap() - 2f64.sqrt()).abs() < 1e-15);
/// ```
#[inline]
pub fn root(
    [(mut b, mut fb), (mut a, mut fa)]: [(f64, f64); 2],
    tolerance: impl Fn(f64) -> f64,
    f: impl Fn(f64) -> f64,
) -> Option<f64> {
    if fa == 0.0 || fb == 0.0 {
        return Some(if fb == 0.0 { b } else { a });
    }
    if !(fa < 0.0 && fb > 0.0 || fa > 0.0 && fb < 0.0) {
        return None;
    }
    let mut t = 0.5;
    for step in 0..STEPS {
        let x = a + t * (b - a);
        let fx = f(x);
        if fx.is_nan() {
            break;
        }
        let (c, fc);
        if (fx < 0.0) == (fa < 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (x, fx);
        let nearest = if fa.abs() < fb.abs() { a } else { b };
        let limit = tolerance(nearest) / (b - a).abs();
        if limit > 0.5 || fa == 0.0 {
            return Some(nearest);
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        t = if step < INTERPOLATED && phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        t = t.clamp(limit, 1.0 - limit);
    }
    Some(if fa.abs() < fb.abs() { a } else { b })
}

/// Place between `low` and `high` (in either order of size) where `before` turns from true to
/// false: the last place found where it holds and the first where it does not. They are at most
/// `tolerance` times max(1, |high|) apart, neighbouring doubles for a tolerance of 0.
pub fn boundary([mut low, mut high]: [f64; 2], tolerance: f64, mut before: impl FnMut(f64) -> bool) -> [f64; 2] {
    for _ in 0..STEPS {
        let middle = 0.5 * low + 0.5 * high;
        if middle == low || middle == high || (high - low).abs() <= tolerance * high.abs().max(1.0) {
            break;
        }
        if before(middle) { low = middle } else { high = middle }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    fn between(low: f64, high: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
        root([(low, f(low)), (high, f(high))], |x| 1e-15 * x.abs().max(1e-300), f)
    }

    /// The ends of an interval, the answer, and the function.
    type Case = (f64, f64, f64, fn(f64) -> f64);

    #[test]
    fn known_roots() {
        let cases: [Case; 7] = [
            (0.0, 1.0, 0.739_085_133_215_160_6, |x| x.cos() - x),
            (2.0, 3.0, 2.094_551_481_542_326_5, |x| x * x * x - 2.0 * x - 5.0),
            (-1.0, 4.0, 0.567_143_290_409_783_8, |x| x * x.exp() - 1.0),
            (0.1, 10.0, 1.0, f64::ln),
            // flat near its root, and nearly a step
            (0.0, 3.0, 1.0, |x| (x - 1.0).powi(9)),
            (0.0, 1.0, 0.3, |x| (1e8 * (x - 0.3)).tanh()),
            (0.0, 1e9, 1e-3, |x| if x < 1.0 { x - 1e-3 } else { 1.0 }),
        ];
        for (low, high, truth, f) in cases {
            for (a, b) in [(low, high), (high, low)] {
                let found = between(a, b, f).unwrap();
                assert!((found - truth).abs() <= 4e-15 * truth.abs(), "{found} {truth}");
            }
        }
    }

    #[test]
    fn without_a_change_of_sign_there_is_none() {
        assert_eq!(between(1.0, 2.0, |x| x), None);
        assert_eq!(between(1.0, 2.0, |_| f64::NAN), None);
        assert_eq!(between(0.0, 2.0, |x| x), Some(0.0));
    }

    #[test]
    fn interpolation_is_quick_and_bisection_bounds_it() {
        let count = Cell::new(0);
        let counted = |x: f64| {
            count.set(count.get() + 1);
            x.exp() - 2.0
        };
        assert!((between(0.0, 5.0, counted).unwrap() - std::f64::consts::LN_2).abs() < 1e-15);
        assert!(count.get() < 16, "{}", count.get());
        // the better end where the function is lost on the way
        let lost = root([(0.0, -1.0), (1.0, 3.0)], |_| 0.0, |x| if x > 0.4 { f64::NAN } else { -1.0 });
        assert_eq!(lost, Some(0.0));
    }

    #[test]
    fn predicates_turn_between_neighbours() {
        let [low, high] = boundary([0.0, 4.0], 0.0, |x| x * x < 2.0);
        assert!(low * low < 2.0 && high * high >= 2.0 && low.next_up() == high);
        // falling brackets work alike
        let [inside, outside] = boundary([4.0, 0.0], 0.0, |x| x * x >= 2.0);
        assert_eq!([outside, inside], [low, high]);
        let [low, high] = boundary([0.0, 4.0], 1e-3, |x| x < 3.0);
        assert!(low < 3.0 && high >= 3.0 && high - low <= 4e-3);
    }
}
