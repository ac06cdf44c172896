//! Four numbers side by side, in double or double-double, for loops over nodes and over columns.
//!
//! Double-doubles keep their high and low parts apart, so that both fill whole vector registers.
//! Columns are slices of lanes padded with zeros. Padding never disturbs: every operation maps
//! zeros to zeros.
//!
//! Running sums ([`Lanes::accumulate`], [`Lanes::accumulate_late`], [`Lanes::join`]) are not
//! normalised: the low part may overlap the high one until [`Lanes::settled`]. Which of two
//! operations a loop takes, and in which order it adds the lanes up ([`Lanes::sum_of_pairs`],
//! [`Lanes::sum_of_halves`]), determines the last bits of its result.

use super::{dd::Dd, real::Real};
pub use super::{
    lanes_dd::Ddx4,
    vector::{F64x4, LANES},
};

/// A number type that comes in fours.
pub trait Laned: Real {
    /// Four of these numbers side by side.
    type Lanes: Lanes<Number = Self>;
}

impl Laned for f64 {
    type Lanes = F64x4;
}

impl Laned for Dd {
    type Lanes = Ddx4;
}

/// Four numbers of one type.
pub trait Lanes: Copy + Send + Sync {
    /// Number held by a lane.
    type Number: Real;

    /// Four zeros.
    const ZERO: Self;

    /// The number in lane `k`.
    fn get(&self, k: usize) -> Self::Number;
    /// Puts `x` into lane `k`.
    fn set(&mut self, k: usize, x: Self::Number);
    /// One number four times.
    fn splat(value: Self::Number) -> Self;
    /// Four doubles, exactly.
    fn from_doubles(values: F64x4) -> Self;
    /// `(x − center) · scale`, the map of an axis.
    fn mapped(x: F64x4, center: f64, scale: f64) -> Self;

    /// `self − other`.
    fn sub(self, other: Self) -> Self;
    /// `−self`.
    fn neg(self) -> Self;
    /// `self + self`, exactly.
    fn doubled(self) -> Self;
    /// `self · other`.
    fn mul(self, other: Self) -> Self;
    /// `self · other` for doubles.
    fn mul_doubles(self, other: F64x4) -> Self;
    /// `self · a + b`.
    fn fma(self, a: Self, b: Self) -> Self;
    /// `self + factor · x` with an error relative to the terms, not to the sum. That is all that an
    /// orthogonal transformation of a column needs, at half the cost.
    fn add_scaled(self, factor: Self::Number, x: Self) -> Self;
    /// [`Self::add_scaled`] for a factor that is a double.
    fn add_scaled_f64(self, factor: f64, x: Self) -> Self;

    /// `self + a · b` for a running sum.
    fn accumulate(self, a: Self, b: Self) -> Self;
    /// The same, where the rounding error of the sum is added last: the bits of factors and of
    /// singular values.
    fn accumulate_late(self, a: Self, b: Self) -> Self;
    /// The sum of two running sums.
    fn join(self, other: Self) -> Self;
    /// A running sum as a number again.
    fn settled(self) -> Self;
    /// `(x₀ + x₁) + (x₂ + x₃)`.
    fn sum_of_pairs(self) -> Self::Number;
    /// `(x₀ + x₂) + (x₁ + x₃)`.
    fn sum_of_halves(self) -> Self::Number;

    /// The nearest doubles.
    fn to_doubles(self) -> F64x4;
    /// High and low parts (the low part of a double is 0).
    fn parts(self) -> (F64x4, F64x4);
    /// Numbers of these parts, as [`Self::parts`] gives them.
    fn from_parts(hi: F64x4, lo: F64x4) -> Self;
}

/// Number of lanes that hold `len` numbers.
#[inline(always)]
pub fn lanes_for(len: usize) -> usize {
    len.div_ceil(LANES)
}

impl Lanes for F64x4 {
    type Number = f64;

    const ZERO: Self = F64x4::ZERO;

    #[inline(always)]
    fn get(&self, k: usize) -> f64 {
        self.as_array()[k]
    }
    #[inline(always)]
    fn set(&mut self, k: usize, x: f64) {
        self.as_mut_array()[k] = x;
    }
    #[inline(always)]
    fn splat(value: f64) -> Self {
        F64x4::splat(value)
    }
    #[inline(always)]
    fn from_doubles(values: F64x4) -> Self {
        values
    }
    #[inline(always)]
    fn mapped(x: F64x4, center: f64, scale: f64) -> Self {
        (x - F64x4::splat(center)) * scale
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn neg(self) -> Self {
        -self
    }
    #[inline(always)]
    fn doubled(self) -> Self {
        self + self
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn mul_doubles(self, other: F64x4) -> Self {
        self * other
    }
    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn add_scaled(self, factor: f64, x: Self) -> Self {
        F64x4::splat(factor).mul_add(x, self)
    }
    #[inline(always)]
    fn add_scaled_f64(self, factor: f64, x: Self) -> Self {
        self.add_scaled(factor, x)
    }
    #[inline(always)]
    fn accumulate(self, a: Self, b: Self) -> Self {
        a.mul_add(b, self)
    }
    #[inline(always)]
    fn accumulate_late(self, a: Self, b: Self) -> Self {
        a.mul_add(b, self)
    }
    #[inline(always)]
    fn join(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn settled(self) -> Self {
        self
    }
    #[inline(always)]
    fn sum_of_pairs(self) -> f64 {
        let x = self.to_array();
        (x[0] + x[1]) + (x[2] + x[3])
    }
    #[inline(always)]
    fn sum_of_halves(self) -> f64 {
        let x = self.to_array();
        (x[0] + x[2]) + (x[1] + x[3])
    }
    #[inline(always)]
    fn to_doubles(self) -> F64x4 {
        self
    }
    #[inline(always)]
    fn parts(self) -> (F64x4, F64x4) {
        (self, F64x4::ZERO)
    }
    #[inline(always)]
    fn from_parts(hi: F64x4, _lo: F64x4) -> Self {
        hi
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dd;

    #[test]
    fn lanes_are_summed_in_the_order_that_the_name_says() {
        let pairs = F64x4::new([1e300, 1.0, -1e300, 2.0]);
        assert_eq!((pairs.sum_of_pairs(), pairs.sum_of_halves()), (0.0, 3.0));
        // the low part of a double-double holds what doubles lose
        let fine = Ddx4::from_doubles(pairs);
        assert_eq!((fine.sum_of_pairs(), fine.sum_of_halves()), (Dd::from(3.0), Dd::from(3.0)));
    }

    fn holds_what_is_put_in<L: Lanes>(number: impl Fn(f64) -> L::Number)
    where
        L::Number: PartialEq + std::fmt::Debug,
    {
        let mut lanes = L::ZERO;
        for k in 0..LANES {
            lanes.set(k, number(k as f64));
        }
        for k in 0..LANES {
            assert_eq!(lanes.get(k), number(k as f64));
        }
    }

    #[test]
    fn every_lane_is_a_number() {
        holds_what_is_put_in::<F64x4>(|x| x + 0.5);
        holds_what_is_put_in::<Ddx4>(|x| Dd::ONE / 3.0 + x);
        assert_eq!([0, 1, 4, 5].map(lanes_for), [0, 1, 1, 2]);
    }

    /// A running sum carries what a double loses, in either order of its roundings.
    #[test]
    fn running_sums_keep_the_low_part() {
        let (third, three) = (Ddx4::splat(Dd::ONE / 3.0), Ddx4::splat(Dd::from(3.0)));
        let big = Ddx4::splat(Dd::from(1e10));
        for sum in [
            big.accumulate(third, three).accumulate(big, three.neg()),
            big.accumulate_late(third, three).accumulate_late(big, three.neg()),
            big.accumulate(third, three).join(Ddx4::ZERO.accumulate(big, three.neg())),
        ] {
            let sum = sum.settled().get(2);
            assert!((sum - Dd::from(1.0 - 2e10)).abs().to_f64() < 1e-20, "{sum:?}");
        }
        let scaled = big.add_scaled(Dd::ONE / 3.0, three).get(1);
        assert!((scaled - Dd::from(1e10 + 1.0)).abs().to_f64() < 1e-20);
    }
}
