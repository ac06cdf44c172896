//! Double-double numbers: an unevaluated sum `hi + lo` of two doubles, good for about 31 digits.
//!
//! The pair is normalised, `|lo| <= ulp(hi) / 2`, so two equal values have equal parts. One
//! operation errs by at most a few units of 2^-104, relative to its result. Nothing here looks at
//! overflow: a value above the range of a double becomes NaN or infinite ([`Dd::is_finite`]). Below
//! about 1e-290 the low part runs out of exponents.
//!
//! The building blocks are the error-free transformations of Dekker, Knuth and Ogita, Rump and
//! Oishi.

use std::cmp::Ordering;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{One, Zero};

use super::dispatch::fma;

/// A normalised unevaluated sum of two doubles.
///
/// ```
/// use flankfit_numerics::Dd;
///
/// // 1/3 to twice the digits: three of them are 1 to 31 digits, though no double is 1/3.
/// let third = Dd::ONE / 3.0;
/// assert!((third * 3.0 - Dd::ONE).abs().to_f64() < 1e-31);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Dd {
    /// The value rounded to double.
    pub hi: f64,
    /// Rounding error of `hi`: the value is `hi + lo`.
    pub lo: f64,
}

/// `a + b` as the rounded sum and its error, exactly.
///
/// ```
/// use flankfit_numerics::dd::two_sum;
///
/// // 2⁻⁶⁰ is lost in the sum, and found in its error.
/// let small = 2_f64.powi(-60);
/// assert_eq!(two_sum(1.0, small), (1.0, small));
/// ```
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_seen = sum - a;
    (sum, (a - (sum - b_seen)) + (b - b_seen))
}

/// [`two_sum`] in three operations, for `|a| >= |b|` or `a == 0`.
#[inline(always)]
pub fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// `a * b` as the rounded product and its error, exactly unless the error underflows.
///
/// ```
/// use flankfit_numerics::dd::two_prod;
///
/// // (1 + 2⁻³⁰)² = 1 + 2⁻²⁹ + 2⁻⁶⁰, whose last part a double does not hold.
/// let a = 1.0 + 2_f64.powi(-30);
/// assert_eq!(two_prod(a, a), (1.0 + 2_f64.powi(-29), 2_f64.powi(-60)));
/// ```
#[inline(always)]
pub fn two_prod(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, fma(a, b, -product))
}

/// The power of two `2^exponent`, for exponents of normal doubles (-1022 ..= 1023).
#[inline(always)]
pub(crate) fn pow2(exponent: i32) -> f64 {
    debug_assert!((-1022..=1023).contains(&exponent));
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// `x * 2^exponent` without overflow on the way, for any exponent.
#[inline]
pub fn ldexp(x: f64, exponent: i32) -> f64 {
    let mut left = exponent.clamp(-4000, 4000);
    let mut x = x;
    while left > 1000 {
        x *= pow2(1000);
        left -= 1000;
    }
    while left < -900 {
        x *= pow2(-900);
        left += 900;
    }
    x * pow2(left)
}

/// The binary exponent `e` with `2^e <= |x| < 2^(e+1)`, of a finite `x` that is not zero.
#[inline]
pub fn exponent_of(x: f64) -> i32 {
    let biased = ((x.to_bits() >> 52) & 0x7ff) as i32;
    if biased == 0 { exponent_of(x * pow2(200)) - 200 } else { biased - 1023 }
}

impl Dd {
    /// Zero.
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };

    /// `a + b`, exactly.
    #[inline(always)]
    pub fn sum(a: f64, b: f64) -> Self {
        let (hi, lo) = two_sum(a, b);
        Dd { hi, lo }
    }

    /// `a - b`, exactly.
    #[inline(always)]
    pub fn diff(a: f64, b: f64) -> Self {
        Self::sum(a, -b)
    }

    /// `a * b`, exactly.
    #[inline(always)]
    pub fn product(a: f64, b: f64) -> Self {
        let (hi, lo) = two_prod(a, b);
        Dd { hi, lo }
    }

    /// Normalises a sum whose first part dominates.
    #[inline(always)]
    fn quick(a: f64, b: f64) -> Self {
        let (hi, lo) = quick_two_sum(a, b);
        Dd { hi, lo }
    }

    /// The nearest double.
    #[inline(always)]
    pub fn to_f64(self) -> f64 {
        self.hi
    }

    /// True if both parts are finite.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.hi.is_finite() && self.lo.is_finite()
    }

    /// The absolute value.
    #[inline(always)]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// The square.
    #[inline(always)]
    pub fn square(self) -> Self {
        let (p, e) = two_prod(self.hi, self.hi);
        Self::quick(p, fma(2.0 * self.hi, self.lo, e))
    }

    /// The square root; NaN below zero, as for doubles.
    #[inline]
    pub fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Dd { hi: self.hi.sqrt(), lo: 0.0 };
        }
        // One Newton step from the double root doubles its digits.
        let root = self.hi.sqrt();
        let rest = (self - Self::product(root, root)).hi;
        Self::quick(root, rest / (2.0 * root))
    }

    /// The reciprocal.
    #[inline]
    pub fn recip(self) -> Self {
        Self::ONE / self
    }

    /// The integer power, by repeated squaring; `0^0` is 1.
    pub fn powi(self, exponent: i32) -> Self {
        let mut left = exponent.unsigned_abs();
        let mut base = self;
        let mut power = Self::ONE;
        while left > 0 {
            if left & 1 == 1 {
                power *= base;
            }
            left >>= 1;
            if left > 0 {
                base = base.square();
            }
        }
        if exponent < 0 { power.recip() } else { power }
    }

    /// `self * 2^exponent`.
    #[inline]
    pub fn ldexp(self, exponent: i32) -> Self {
        Dd { hi: ldexp(self.hi, exponent), lo: ldexp(self.lo, exponent) }
    }

    /// `self * factor`, exactly, where `factor` is a power of two.
    #[inline(always)]
    pub fn scale_pow2(self, factor: f64) -> Self {
        Dd { hi: self.hi * factor, lo: self.lo * factor }
    }
}

impl From<f64> for Dd {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Dd { hi: x, lo: 0.0 }
    }
}

impl From<Dd> for f64 {
    #[inline(always)]
    fn from(x: Dd) -> Self {
        x.hi
    }
}

impl Neg for Dd {
    type Output = Dd;
    #[inline(always)]
    fn neg(self) -> Dd {
        Dd { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Dd {
    type Output = Dd;
    #[inline(always)]
    fn add(self, other: Dd) -> Dd {
        // Both error terms are kept, so that cancellation of the high parts costs no digits.
        let (s, e) = two_sum(self.hi, other.hi);
        let (t, f) = two_sum(self.lo, other.lo);
        let (s, e) = quick_two_sum(s, e + t);
        Dd::quick(s, e + f)
    }
}

impl Add<f64> for Dd {
    type Output = Dd;
    #[inline(always)]
    fn add(self, other: f64) -> Dd {
        let (s, e) = two_sum(self.hi, other);
        Dd::quick(s, e + self.lo)
    }
}

impl Sub for Dd {
    type Output = Dd;
    #[inline(always)]
    fn sub(self, other: Dd) -> Dd {
        self + -other
    }
}

impl Sub<f64> for Dd {
    type Output = Dd;
    #[inline(always)]
    fn sub(self, other: f64) -> Dd {
        self + -other
    }
}

impl Mul for Dd {
    type Output = Dd;
    #[inline(always)]
    fn mul(self, other: Dd) -> Dd {
        let (p, e) = two_prod(self.hi, other.hi);
        let cross = fma(self.hi, other.lo, self.lo * other.hi);
        Dd::quick(p, e + cross)
    }
}

impl Mul<f64> for Dd {
    type Output = Dd;
    #[inline(always)]
    fn mul(self, other: f64) -> Dd {
        let (p, e) = two_prod(self.hi, other);
        Dd::quick(p, fma(self.lo, other, e))
    }
}

impl Div for Dd {
    type Output = Dd;
    #[inline]
    fn div(self, other: Dd) -> Dd {
        // Long division, one double digit at a time; the third digit settles the last bits.
        let q1 = self.hi / other.hi;
        let rest = self - other * q1;
        let q2 = rest.hi / other.hi;
        let rest = rest - other * q2;
        let q3 = rest.hi / other.hi;
        Dd::quick(q1, q2) + q3
    }
}

impl Div<f64> for Dd {
    type Output = Dd;
    #[inline]
    fn div(self, other: f64) -> Dd {
        let q1 = self.hi / other;
        let rest = self - Dd::product(q1, other);
        let q2 = rest.hi / other;
        let rest = rest - Dd::product(q2, other);
        let q3 = rest.hi / other;
        Dd::quick(q1, q2) + q3
    }
}

macro_rules! assign {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Dd {
            #[inline(always)]
            fn $method(&mut self, other: Dd) {
                *self = *self $op other;
            }
        }
        impl $trait<f64> for Dd {
            #[inline(always)]
            fn $method(&mut self, other: f64) {
                *self = *self $op other;
            }
        }
    )*};
}
assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);

impl PartialOrd for Dd {
    #[inline(always)]
    fn partial_cmp(&self, other: &Dd) -> Option<Ordering> {
        match self.hi.partial_cmp(&other.hi) {
            Some(Ordering::Equal) => self.lo.partial_cmp(&other.lo),
            order => order,
        }
    }
}

impl Zero for Dd {
    #[inline(always)]
    fn zero() -> Self {
        Dd::ZERO
    }
    #[inline(always)]
    fn is_zero(&self) -> bool {
        self.hi == 0.0 && self.lo == 0.0
    }
}

impl One for Dd {
    #[inline(always)]
    fn one() -> Self {
        Dd::ONE
    }
}

impl Sum for Dd {
    fn sum<I: Iterator<Item = Dd>>(terms: I) -> Dd {
        terms.fold(Dd::ZERO, |total, term| total + term)
    }
}

#[cfg(test)]
#[path = "dd_tests.rs"]
mod tests;
