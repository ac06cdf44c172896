//! The number type the algorithms are generic over: `f64`, or [`Dd`] where a double has too few
//! digits.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use nalgebra::Scalar;
use num_traits::{One, Zero};

use super::dd::{Dd, ldexp};
use super::dispatch::fma;

/// A real number of fixed precision.
pub trait Real:
    Copy
    + Scalar
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Zero
    + One
    + Send
    + Sync
{
    /// The unit roundoff: a bound on the relative error of one operation.
    const EPSILON: f64;

    /// The number `x`.
    fn of(x: f64) -> Self;
    /// The nearest double.
    fn to_f64(self) -> f64;
    /// The nearest number to `x`.
    fn of_dd(x: Dd) -> Self;
    /// This number, exactly.
    fn to_dd(self) -> Dd;
    /// The square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// `self * a + b`.
    fn fma(self, a: Self, b: Self) -> Self;
    /// [`Self::fma`] for loops that are to become vector instructions: on a processor that a build
    /// does not ask for, doubles are quick here only inside of kernels compiled twice.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// `self * factor`.
    fn mul_f64(self, factor: f64) -> Self;
    /// `self * 2^exponent`.
    fn ldexp(self, exponent: i32) -> Self;
    /// True if the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON / 2.0;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn of_dd(x: Dd) -> Self {
        x.hi
    }
    #[inline(always)]
    fn to_dd(self) -> Dd {
        Dd::from(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        fma(self, a, b)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        f64::mul_add(self, a, b)
    }
    #[inline(always)]
    fn mul_f64(self, factor: f64) -> Self {
        self * factor
    }
    #[inline(always)]
    fn ldexp(self, exponent: i32) -> Self {
        ldexp(self, exponent)
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

impl Real for Dd {
    /// 2^-104.
    const EPSILON: f64 = f64::EPSILON * f64::EPSILON;

    #[inline(always)]
    fn of(x: f64) -> Self {
        Dd::from(x)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.hi
    }
    #[inline(always)]
    fn of_dd(x: Dd) -> Self {
        x
    }
    #[inline(always)]
    fn to_dd(self) -> Dd {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Dd::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Dd::abs(self)
    }
    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn mul_f64(self, factor: f64) -> Self {
        self * factor
    }
    #[inline(always)]
    fn ldexp(self, exponent: i32) -> Self {
        Dd::ldexp(self, exponent)
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        Dd::is_finite(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn the_unit_roundoffs_are_powers_of_two() {
        assert_eq!(<f64 as Real>::EPSILON, 2f64.powi(-53));
        assert_eq!(<Dd as Real>::EPSILON, 2f64.powi(-104));
    }

    #[test]
    fn both_types_agree_on_small_integers() {
        fn probe<T: Real>() -> f64 {
            let x = T::of(9.0).sqrt().fma(T::of(4.0), -T::of(30.0)).abs().mul_f64(0.5).ldexp(2);
            T::of_dd(x.to_dd()).to_f64()
        }
        assert_eq!(probe::<f64>(), 36.0);
        assert_eq!(probe::<Dd>(), 36.0);
    }

    #[test]
    fn double_doubles_fill_matrices() {
        let identity = DMatrix::<Dd>::identity(3, 3);
        assert_eq!(&identity * &identity + DMatrix::zeros(3, 3), identity);
    }
}
