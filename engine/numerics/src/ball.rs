//! Proved intervals: a double-double midpoint and a radius.
//!
//! Rust has no directed rounding, so radii grow by a-priori bounds. An operation on midpoints errs
//! by at most 5u² of its result, u = 2⁻⁵³ (Joldes, Muller and Popescu, ACM Transactions on
//! Mathematical Software 44, 2017); [`ROUNDING`] is 8u². An operation on radii errs by u of its
//! result, which a factor above 1 covers. An underflow adds less than the smallest normal number.

use std::ops::{Add, Mul, Neg, Sub};

use super::dd::Dd;

/// Bound on the relative error of one operation in double-double: 8u².
pub const ROUNDING: f64 = 2.0 * f64::EPSILON * f64::EPSILON;

/// A bound computed in double precision as a sum of fewer than 2²⁰ products of numbers that are
/// not negative, made large enough for the rounding on the way.
#[inline(always)]
pub fn enlarged(bound: f64) -> f64 {
    bound * (1.0 + 1e-9)
}

/// All real numbers within `radius` of `mid`.
///
/// ```
/// use flankfit_numerics::Ball;
///
/// // No double is 1/3, and three times the interval that holds it holds 1.
/// let third = Ball::from(1.0).over(3.0);
/// let [low, high] = third.ends();
/// assert!(low < high && low.next_up() == high);
/// let [low, high] = (third * Ball::from(3.0)).ends();
/// assert!(low <= 1.0 && 1.0 <= high && high - low < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The middle.
    pub mid: Dd,
    /// Greatest distance from it.
    pub radius: f64,
}

impl Ball {
    /// Zero, exactly.
    pub const ZERO: Ball = Ball { mid: Dd::ZERO, radius: 0.0 };

    /// The numbers within `radius` of `mid`.
    #[inline(always)]
    pub fn new(mid: Dd, radius: f64) -> Self {
        Ball { mid, radius }
    }

    /// The same with a greater radius.
    #[inline(always)]
    pub fn widened(self, by: f64) -> Self {
        Ball { mid: self.mid, radius: enlarged(self.radius + by + f64::MIN_POSITIVE) }
    }

    /// An upper bound of the moduli.
    #[inline(always)]
    pub fn modulus(self) -> f64 {
        enlarged(self.mid.hi.abs() + self.radius)
    }

    /// True if this is zero and nothing else.
    #[inline(always)]
    pub fn is_zero(self) -> bool {
        self.mid.hi == 0.0 && self.radius == 0.0
    }

    /// The quotients by a double.
    #[inline]
    pub fn over(self, divisor: f64) -> Self {
        let mid = self.mid / divisor;
        let radius = enlarged(self.radius / divisor.abs() + ROUNDING * mid.hi.abs() + f64::MIN_POSITIVE);
        Ball { mid, radius }
    }

    /// The products with a power of two.
    #[inline(always)]
    pub fn scale_pow2(self, factor: f64) -> Self {
        Ball { mid: self.mid.scale_pow2(factor), radius: self.radius * factor.abs() }.widened(0.0)
    }

    /// Doubles at or below, and at or above, all of these numbers.
    pub fn ends(self) -> [f64; 2] {
        let reach = enlarged(self.radius + ROUNDING * self.mid.hi.abs());
        let (below, above) = (self.mid - reach, self.mid + reach);
        [
            if below.lo < 0.0 { below.hi.next_down() } else { below.hi },
            if above.lo > 0.0 { above.hi.next_up() } else { above.hi },
        ]
    }
}

impl From<f64> for Ball {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Ball { mid: Dd::from(x), radius: 0.0 }
    }
}

impl From<Dd> for Ball {
    #[inline(always)]
    fn from(mid: Dd) -> Self {
        Ball { mid, radius: 0.0 }
    }
}

impl Neg for Ball {
    type Output = Ball;
    #[inline(always)]
    fn neg(self) -> Ball {
        Ball { mid: -self.mid, ..self }
    }
}

impl Add for Ball {
    type Output = Ball;
    #[inline(always)]
    fn add(self, other: Ball) -> Ball {
        let mid = self.mid + other.mid;
        Ball { mid, radius: enlarged(self.radius + other.radius + ROUNDING * mid.hi.abs()) }
    }
}

impl Sub for Ball {
    type Output = Ball;
    #[inline(always)]
    fn sub(self, other: Ball) -> Ball {
        self + -other
    }
}

impl Mul for Ball {
    type Output = Ball;
    #[inline(always)]
    fn mul(self, other: Ball) -> Ball {
        let mid = self.mid * other.mid;
        let (a, b) = (self.mid.hi.abs(), other.mid.hi.abs());
        let moved = a * other.radius + (b + other.radius) * self.radius;
        Ball { mid, radius: enlarged(moved + ROUNDING * mid.hi.abs() + f64::MIN_POSITIVE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn holds(ball: Ball, x: i128) -> bool {
        let [low, high] = ball.ends();
        low.ceil() as i128 <= x && x <= high.floor() as i128
    }

    #[test]
    fn ends_lie_outside() {
        let just_above = Ball::from(Dd::sum(1.0, 1e-30)).ends();
        assert!(just_above[0] <= 1.0 && just_above[1] == 1.0_f64.next_up(), "{just_above:?}");
        assert_eq!(Ball::ZERO.ends(), [0.0, 0.0]);
        assert_eq!(Ball::new(Dd::ZERO, 1.0).ends().map(f64::signum), [-1.0, 1.0]);
        assert!(Ball::new(Dd::ZERO, f64::INFINITY).ends().iter().all(|x| !x.is_finite()));
    }

    proptest! {
        /// Integers that neither a double nor a double-double holds once they are multiplied.
        #[test]
        fn sums_and_products_of_integers(
            a in -(1i64 << 62)..(1i64 << 62), b in -(1i64 << 62)..(1i64 << 62), c in -1000i64..1000, d in 1i64..1000,
        ) {
            let ball = |x: i64| {
                let hi = x as f64;
                Ball::from(Dd::sum(hi, (x as i128 - hi as i128) as f64))
            };
            let (a, b, c, d) = (a as i128, b as i128, c as i128, d as i128);
            let (x, y) = (ball(a as i64), ball(b as i64));
            prop_assert!(holds(x + y, a + b) && holds(x - y, a - b));
            prop_assert!(holds(x * ball(c as i64) * ball(d as i64), a * c * d));
            prop_assert!(holds((x * ball(c as i64)).over(d as f64) * ball(d as i64), a * c));
            let product = Ball::from(a as f64) * Ball::from(b as f64);
            prop_assert!(holds(product, a as f64 as i128 * (b as f64 as i128)));
            let wide = x.widened(1e3);
            prop_assert!(holds(wide, a + 1000) && holds(wide * ball(c as i64), (a - 1000) * c));
            prop_assert!(wide.modulus() >= a.abs() as f64);
        }
    }
}
