//! Four numbers side by side, in double or double-double, for kernels that run over many nodes.

use super::Dd;
pub use super::vector::{F64x4, LANES};

/// What the node kernels need of a number.
pub trait Lanes: Copy + Send + Sync {
    /// Four zeros.
    const ZERO: Self;
    /// One number four times, rounded where these have fewer digits.
    fn splat(value: Dd) -> Self;
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
    /// `self · a + b`.
    fn fma(self, a: Self, b: Self) -> Self;
    /// `self + a · b` for running sums, whose low part may overlap the high one: call
    /// [`Self::settled`] at the end.
    fn accumulate(self, a: Self, b: Self) -> Self;
    /// A running sum as a number again.
    fn settled(self) -> Self;
    /// `self · other`.
    fn mul(self, other: Self) -> Self;
    /// `self · other` for doubles.
    fn mul_doubles(self, other: F64x4) -> Self;
    /// The nearest doubles.
    fn to_doubles(self) -> F64x4;
    /// High and low parts (the low part of a double is 0).
    fn parts(self) -> (F64x4, F64x4);
    /// Numbers of these parts, as [`Self::parts`] gives them.
    fn from_parts(hi: F64x4, lo: F64x4) -> Self;
    /// The sum of the four.
    fn sum(self) -> Dd;
}

impl Lanes for F64x4 {
    const ZERO: Self = F64x4::ZERO;

    #[inline(always)]
    fn splat(value: Dd) -> Self {
        F64x4::splat(value.to_f64())
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
    fn fma(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn accumulate(self, a: Self, b: Self) -> Self {
        a.mul_add(b, self)
    }
    #[inline(always)]
    fn settled(self) -> Self {
        self
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
    #[inline(always)]
    fn sum(self) -> Dd {
        Dd::from(self.total())
    }
}

/// Four double-double numbers, high and low parts apart.
#[derive(Clone, Copy, Debug)]
pub struct Ddx4 {
    hi: F64x4,
    lo: F64x4,
}

/// Sum and its rounding error (Knuth).
#[inline(always)]
fn two_sum(a: F64x4, b: F64x4) -> (F64x4, F64x4) {
    let s = a + b;
    let bb = s - a;
    (s, (a - (s - bb)) + (b - bb))
}

/// The same where |a| ≥ |b| (Dekker).
#[inline(always)]
fn quick_two_sum(a: F64x4, b: F64x4) -> Ddx4 {
    let hi = a + b;
    Ddx4 { hi, lo: b - (hi - a) }
}

/// Product and its rounding error, by fused multiply-add.
#[inline(always)]
fn two_product(a: F64x4, b: F64x4) -> (F64x4, F64x4) {
    let p = a * b;
    (p, a.mul_sub(b, p))
}

impl Ddx4 {
    /// `self + lane · values`, a running sum as in [`Lanes::accumulate`].
    #[inline(always)]
    pub fn add_product(self, lane: Ddx4, values: F64x4) -> Self {
        let (p, e) = two_product(lane.hi, values);
        let (hi, carried) = two_sum(self.hi, p);
        Ddx4 { hi, lo: self.lo + lane.lo.mul_add(values, e + carried) }
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (s, e) = two_sum(self.hi, other.hi);
        let (t, f) = two_sum(self.lo, other.lo);
        let first = quick_two_sum(s, e + t);
        quick_two_sum(first.hi, first.lo + f)
    }
}

impl Lanes for Ddx4 {
    const ZERO: Self = Ddx4 { hi: F64x4::ZERO, lo: F64x4::ZERO };

    #[inline(always)]
    fn splat(value: Dd) -> Self {
        Ddx4 { hi: F64x4::splat(value.hi), lo: F64x4::splat(value.lo) }
    }
    #[inline(always)]
    fn from_doubles(values: F64x4) -> Self {
        Ddx4 { hi: values, lo: F64x4::ZERO }
    }
    #[inline(always)]
    fn mapped(x: F64x4, center: f64, scale: f64) -> Self {
        let (hi, lo) = two_sum(x, F64x4::splat(-center));
        Ddx4 { hi, lo }.mul_doubles(F64x4::splat(scale))
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.add(other.neg())
    }
    #[inline(always)]
    fn neg(self) -> Self {
        Ddx4 { hi: -self.hi, lo: -self.lo }
    }
    #[inline(always)]
    fn doubled(self) -> Self {
        Ddx4 { hi: self.hi + self.hi, lo: self.lo + self.lo }
    }
    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        self.mul(a).add(b)
    }
    #[inline(always)]
    fn accumulate(self, a: Self, b: Self) -> Self {
        let (p, e) = two_product(a.hi, b.hi);
        let (hi, carried) = two_sum(self.hi, p);
        let low = a.hi.mul_add(b.lo, a.lo.mul_add(b.hi, e + carried));
        Ddx4 { hi, lo: self.lo + low }
    }
    #[inline(always)]
    fn settled(self) -> Self {
        let (hi, lo) = two_sum(self.hi, self.lo);
        Ddx4 { hi, lo }
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (p, e) = two_product(self.hi, other.hi);
        quick_two_sum(p, self.hi.mul_add(other.lo, self.lo.mul_add(other.hi, e)))
    }
    #[inline(always)]
    fn mul_doubles(self, other: F64x4) -> Self {
        let (p, e) = two_product(self.hi, other);
        quick_two_sum(p, self.lo.mul_add(other, e))
    }
    #[inline(always)]
    fn to_doubles(self) -> F64x4 {
        self.hi
    }
    #[inline(always)]
    fn parts(self) -> (F64x4, F64x4) {
        (self.hi, self.lo)
    }
    #[inline(always)]
    fn from_parts(hi: F64x4, lo: F64x4) -> Self {
        Ddx4 { hi, lo }
    }
    #[inline(always)]
    fn sum(self) -> Dd {
        let (hi, lo) = (self.hi.to_array(), self.lo.to_array());
        let at = |i: usize| Dd { hi: hi[i], lo: lo[i] };
        (at(0) + at(1)) + (at(2) + at(3))
    }
}
