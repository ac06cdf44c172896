//! Inner loops over four numbers at a time.
//!
//! Columns are stored as slices of lanes (double-doubles with their high and low parts apart, so
//! that both fill whole vector registers), padded with zeros. Padding never disturbs: every
//! operation maps zeros to zeros.
//!
//! Sums of double-doubles are "sloppy" here: their error is relative to the terms, not to the sum,
//! which is all that an orthogonal transformation of a column needs, at half the cost.

use super::dd::{Dd, quick_two_sum, two_prod, two_sum};

/// How many numbers stand side by side.
pub const WIDTH: usize = 4;

/// Four numbers of type `T`.
pub trait Lanes<T>: Copy + Send + Sync {
    /// Four zeros.
    const ZERO: Self;

    /// The number in lane `k`.
    fn get(&self, k: usize) -> T;
    /// Puts `x` into lane `k`.
    fn set(&mut self, k: usize, x: T);
    /// `self + x * y` in every lane, for running sums: not normalised, only [`Lanes::total`] may
    /// follow.
    fn accumulate(self, x: Self, y: Self) -> Self;
    /// The sum of two running sums.
    fn join(self, other: Self) -> Self;
    /// The sum over the lanes of a running sum.
    fn total(self) -> T;
    /// `self + factor * x`.
    fn add_scaled(self, factor: T, x: Self) -> Self;
    /// `self + factor * x` for a factor that is a double.
    fn add_scaled_f64(self, factor: f64, x: Self) -> Self;
    /// `self * factor`.
    fn scale(self, factor: T) -> Self;
}

/// Four doubles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct F64Lanes([f64; WIDTH]);

/// Four double-doubles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct DdLanes {
    hi: [f64; WIDTH],
    lo: [f64; WIDTH],
}

impl Lanes<f64> for F64Lanes {
    const ZERO: Self = F64Lanes([0.0; WIDTH]);

    #[inline(always)]
    fn get(&self, k: usize) -> f64 {
        self.0[k]
    }
    #[inline(always)]
    fn set(&mut self, k: usize, x: f64) {
        self.0[k] = x;
    }
    #[inline(always)]
    fn accumulate(mut self, x: Self, y: Self) -> Self {
        for k in 0..WIDTH {
            self.0[k] = x.0[k].mul_add(y.0[k], self.0[k]);
        }
        self
    }
    #[inline(always)]
    fn join(mut self, other: Self) -> Self {
        for k in 0..WIDTH {
            self.0[k] += other.0[k];
        }
        self
    }
    #[inline(always)]
    fn total(self) -> f64 {
        (self.0[0] + self.0[2]) + (self.0[1] + self.0[3])
    }
    #[inline(always)]
    fn add_scaled(mut self, factor: f64, x: Self) -> Self {
        for k in 0..WIDTH {
            self.0[k] = factor.mul_add(x.0[k], self.0[k]);
        }
        self
    }
    #[inline(always)]
    fn add_scaled_f64(self, factor: f64, x: Self) -> Self {
        self.add_scaled(factor, x)
    }
    #[inline(always)]
    fn scale(mut self, factor: f64) -> Self {
        for k in 0..WIDTH {
            self.0[k] *= factor;
        }
        self
    }
}

impl Lanes<Dd> for DdLanes {
    const ZERO: Self = DdLanes { hi: [0.0; WIDTH], lo: [0.0; WIDTH] };

    #[inline(always)]
    fn get(&self, k: usize) -> Dd {
        Dd { hi: self.hi[k], lo: self.lo[k] }
    }
    #[inline(always)]
    fn set(&mut self, k: usize, x: Dd) {
        self.hi[k] = x.hi;
        self.lo[k] = x.lo;
    }
    #[inline(always)]
    fn accumulate(mut self, x: Self, y: Self) -> Self {
        for k in 0..WIDTH {
            let (p, e) = two_prod(x.hi[k], y.hi[k]);
            let e = x.hi[k].mul_add(y.lo[k], x.lo[k].mul_add(y.hi[k], e));
            let (s, f) = two_sum(self.hi[k], p);
            self.hi[k] = s;
            self.lo[k] += e + f;
        }
        self
    }
    #[inline(always)]
    fn join(mut self, other: Self) -> Self {
        for k in 0..WIDTH {
            let (s, f) = two_sum(self.hi[k], other.hi[k]);
            self.hi[k] = s;
            self.lo[k] += f + other.lo[k];
        }
        self
    }
    #[inline(always)]
    fn total(self) -> Dd {
        let lane = |k: usize| Dd::sum(self.hi[k], self.lo[k]);
        (lane(0) + lane(2)) + (lane(1) + lane(3))
    }
    #[inline(always)]
    fn add_scaled(mut self, factor: Dd, x: Self) -> Self {
        for k in 0..WIDTH {
            let (p, e) = two_prod(factor.hi, x.hi[k]);
            let e = factor.hi.mul_add(x.lo[k], factor.lo.mul_add(x.hi[k], e));
            let (s, f) = two_sum(self.hi[k], p);
            (self.hi[k], self.lo[k]) = quick_two_sum(s, f + (self.lo[k] + e));
        }
        self
    }
    #[inline(always)]
    fn add_scaled_f64(mut self, factor: f64, x: Self) -> Self {
        for k in 0..WIDTH {
            let (p, e) = two_prod(factor, x.hi[k]);
            let e = factor.mul_add(x.lo[k], e);
            let (s, f) = two_sum(self.hi[k], p);
            (self.hi[k], self.lo[k]) = quick_two_sum(s, f + (self.lo[k] + e));
        }
        self
    }
    #[inline(always)]
    fn scale(mut self, factor: Dd) -> Self {
        for k in 0..WIDTH {
            let (p, e) = two_prod(self.hi[k], factor.hi);
            let e = self.hi[k].mul_add(factor.lo, self.lo[k].mul_add(factor.hi, e));
            (self.hi[k], self.lo[k]) = quick_two_sum(p, e);
        }
        self
    }
}

/// How many lanes hold `len` numbers.
#[inline(always)]
pub fn lanes_for(len: usize) -> usize {
    len.div_ceil(WIDTH)
}
