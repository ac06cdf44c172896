//! Four double-double numbers side by side.

use super::{dd::Dd, lanes::Lanes, vector::F64x4};

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

    /// `self + p + e`, the low parts added without looking at their roundings.
    #[inline(always)]
    fn add_roughly(self, p: F64x4, e: F64x4) -> Self {
        let (s, f) = two_sum(self.hi, p);
        quick_two_sum(s, f + (self.lo + e))
    }
}

impl Lanes for Ddx4 {
    type Number = Dd;

    const ZERO: Self = Ddx4 { hi: F64x4::ZERO, lo: F64x4::ZERO };

    #[inline(always)]
    fn get(&self, k: usize) -> Dd {
        Dd { hi: self.hi.as_array()[k], lo: self.lo.as_array()[k] }
    }
    #[inline(always)]
    fn set(&mut self, k: usize, x: Dd) {
        self.hi.as_mut_array()[k] = x.hi;
        self.lo.as_mut_array()[k] = x.lo;
    }
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
    fn fma(self, a: Self, b: Self) -> Self {
        self.mul(a).add(b)
    }
    #[inline(always)]
    fn add_scaled(self, factor: Dd, x: Self) -> Self {
        let factor = Ddx4::splat(factor);
        let (p, e) = two_product(factor.hi, x.hi);
        self.add_roughly(p, factor.hi.mul_add(x.lo, factor.lo.mul_add(x.hi, e)))
    }
    #[inline(always)]
    fn add_scaled_f64(self, factor: f64, x: Self) -> Self {
        let factor = F64x4::splat(factor);
        let (p, e) = two_product(factor, x.hi);
        self.add_roughly(p, factor.mul_add(x.lo, e))
    }
    #[inline(always)]
    fn accumulate(self, a: Self, b: Self) -> Self {
        let (p, e) = two_product(a.hi, b.hi);
        let (hi, carried) = two_sum(self.hi, p);
        let low = a.hi.mul_add(b.lo, a.lo.mul_add(b.hi, e + carried));
        Ddx4 { hi, lo: self.lo + low }
    }
    #[inline(always)]
    fn accumulate_late(self, a: Self, b: Self) -> Self {
        let (p, e) = two_product(a.hi, b.hi);
        let low = a.hi.mul_add(b.lo, a.lo.mul_add(b.hi, e));
        let (hi, carried) = two_sum(self.hi, p);
        Ddx4 { hi, lo: self.lo + (low + carried) }
    }
    #[inline(always)]
    fn join(self, other: Self) -> Self {
        let (hi, carried) = two_sum(self.hi, other.hi);
        Ddx4 { hi, lo: self.lo + (carried + other.lo) }
    }
    #[inline(always)]
    fn settled(self) -> Self {
        let (hi, lo) = two_sum(self.hi, self.lo);
        Ddx4 { hi, lo }
    }
    #[inline(always)]
    fn sum_of_pairs(self) -> Dd {
        (self.get(0) + self.get(1)) + (self.get(2) + self.get(3))
    }
    #[inline(always)]
    fn sum_of_halves(self) -> Dd {
        (self.get(0) + self.get(2)) + (self.get(1) + self.get(3))
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
}
