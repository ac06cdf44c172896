//! Four numbers side by side, in double or double-double, for kernels that run over many nodes.
//!
//! Plain arrays and loops of fixed length: the compiler turns them into vector instructions, and the order of
//! every sum is fixed by the code, so results do not depend on the processor.

use super::Dd;

/// How many numbers stand side by side.
pub const LANES: usize = 4;

/// What the node kernels need of a number.
pub trait Lanes: Copy + Send + Sync {
    const ZERO: Self;
    /// Whether these are double-double numbers.
    const DOUBLE_DOUBLE: bool;
    fn splat(value: Dd) -> Self;
    fn from_doubles(values: [f64; LANES]) -> Self;
    /// `(x − center) · scale`, the map of an axis.
    fn mapped(x: [f64; LANES], center: f64, scale: f64) -> Self;
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    /// `self · a + b`.
    fn fma(self, a: Self, b: Self) -> Self;
    /// `self + a · b` for running sums, whose low part may overlap the high one: call [`Self::settled`] at the end.
    fn accumulate(self, a: Self, b: Self) -> Self;
    /// A running sum as a number again.
    fn settled(self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn mul_doubles(self, other: [f64; LANES]) -> Self;
    fn to_doubles(self) -> [f64; LANES];
    /// High and low parts (the low part of a double is 0).
    fn parts(self) -> ([f64; LANES], [f64; LANES]);
    fn from_parts(hi: [f64; LANES], lo: [f64; LANES]) -> Self;
    /// The sum of the four.
    fn sum(self) -> Dd;
}

/// Four doubles.
#[derive(Clone, Copy, Debug)]
pub struct F64x4(pub [f64; LANES]);

impl F64x4 {
    #[inline(always)]
    pub fn times(self, factor: f64) -> Self {
        F64x4(self.0.map(|x| x * factor))
    }

    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        F64x4(self.0.map(|x| 1.0 / x))
    }

    #[inline(always)]
    pub fn square_root(self) -> Self {
        F64x4(self.0.map(f64::sqrt))
    }
}

impl Lanes for F64x4 {
    const ZERO: Self = F64x4([0.0; LANES]);
    const DOUBLE_DOUBLE: bool = false;

    #[inline(always)]
    fn splat(value: Dd) -> Self {
        F64x4([value.to_f64(); LANES])
    }
    #[inline(always)]
    fn from_doubles(values: [f64; LANES]) -> Self {
        F64x4(values)
    }
    #[inline(always)]
    fn mapped(x: [f64; LANES], center: f64, scale: f64) -> Self {
        F64x4(x.map(|x| (x - center) * scale))
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        F64x4(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        F64x4(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        F64x4(std::array::from_fn(|i| self.0[i].mul_add(a.0[i], b.0[i])))
    }
    #[inline(always)]
    fn accumulate(self, a: Self, b: Self) -> Self {
        a.fma(b, self)
    }
    #[inline(always)]
    fn settled(self) -> Self {
        self
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        F64x4(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }
    #[inline(always)]
    fn mul_doubles(self, other: [f64; LANES]) -> Self {
        F64x4(std::array::from_fn(|i| self.0[i] * other[i]))
    }
    #[inline(always)]
    fn to_doubles(self) -> [f64; LANES] {
        self.0
    }
    #[inline(always)]
    fn parts(self) -> ([f64; LANES], [f64; LANES]) {
        (self.0, [0.0; LANES])
    }
    #[inline(always)]
    fn from_parts(hi: [f64; LANES], _lo: [f64; LANES]) -> Self {
        F64x4(hi)
    }
    #[inline(always)]
    fn sum(self) -> Dd {
        Dd::from((self.0[0] + self.0[1]) + (self.0[2] + self.0[3]))
    }
}

/// Four double-double numbers, high and low parts apart.
#[derive(Clone, Copy, Debug)]
pub struct Ddx4 {
    hi: [f64; LANES],
    lo: [f64; LANES],
}

type Four = [f64; LANES];

#[inline(always)]
fn zip(a: Four, b: Four, f: impl Fn(f64, f64) -> f64) -> Four {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn plus(a: Four, b: Four) -> Four {
    zip(a, b, |a, b| a + b)
}

#[inline(always)]
fn minus(a: Four, b: Four) -> Four {
    zip(a, b, |a, b| a - b)
}

/// Sum and its rounding error (Knuth).
#[inline(always)]
fn two_sum(a: Four, b: Four) -> (Four, Four) {
    let s = plus(a, b);
    let bb = minus(s, a);
    (s, plus(minus(a, minus(s, bb)), minus(b, bb)))
}

/// The same where |a| ≥ |b| (Dekker).
#[inline(always)]
fn quick_two_sum(a: Four, b: Four) -> Ddx4 {
    let hi = plus(a, b);
    Ddx4 { hi, lo: minus(b, minus(hi, a)) }
}

/// Product and its rounding error, by fused multiply-add.
#[inline(always)]
fn two_product(a: Four, b: Four) -> (Four, Four) {
    let p = zip(a, b, |a, b| a * b);
    (p, std::array::from_fn(|i| a[i].mul_add(b[i], -p[i])))
}

impl Ddx4 {
    /// `self + lane · values`, a running sum as in [`Lanes::accumulate`].
    #[inline(always)]
    pub fn add_product(self, lane: Ddx4, values: Four) -> Self {
        let (p, e) = two_product(lane.hi, values);
        let (hi, carried) = two_sum(self.hi, p);
        let low: Four = std::array::from_fn(|i| lane.lo[i].mul_add(values[i], e[i] + carried[i]));
        Ddx4 { hi, lo: plus(self.lo, low) }
    }
}

impl Lanes for Ddx4 {
    const ZERO: Self = Ddx4 { hi: [0.0; LANES], lo: [0.0; LANES] };
    const DOUBLE_DOUBLE: bool = true;

    #[inline(always)]
    fn splat(value: Dd) -> Self {
        Ddx4 { hi: [value.hi; LANES], lo: [value.lo; LANES] }
    }
    #[inline(always)]
    fn from_doubles(values: Four) -> Self {
        Ddx4 { hi: values, lo: [0.0; LANES] }
    }
    #[inline(always)]
    fn mapped(x: Four, center: f64, scale: f64) -> Self {
        let (hi, lo) = two_sum(x, [-center; LANES]);
        Ddx4 { hi, lo }.mul_doubles([scale; LANES])
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (s, e) = two_sum(self.hi, other.hi);
        let (t, f) = two_sum(self.lo, other.lo);
        let first = quick_two_sum(s, plus(e, t));
        quick_two_sum(first.hi, plus(first.lo, f))
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.add(Ddx4 { hi: other.hi.map(|x| -x), lo: other.lo.map(|x| -x) })
    }
    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        self.mul(a).add(b)
    }
    #[inline(always)]
    fn accumulate(self, a: Self, b: Self) -> Self {
        let (p, e) = two_product(a.hi, b.hi);
        let (hi, carried) = two_sum(self.hi, p);
        let low: Four = std::array::from_fn(|i| a.hi[i].mul_add(b.lo[i], a.lo[i].mul_add(b.hi[i], e[i] + carried[i])));
        Ddx4 { hi, lo: plus(self.lo, low) }
    }
    #[inline(always)]
    fn settled(self) -> Self {
        let (hi, lo) = two_sum(self.hi, self.lo);
        Ddx4 { hi, lo }
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (p, e) = two_product(self.hi, other.hi);
        let cross: Four =
            std::array::from_fn(|i| self.hi[i].mul_add(other.lo[i], self.lo[i].mul_add(other.hi[i], e[i])));
        quick_two_sum(p, cross)
    }
    #[inline(always)]
    fn mul_doubles(self, other: Four) -> Self {
        let (p, e) = two_product(self.hi, other);
        let cross: Four = std::array::from_fn(|i| self.lo[i].mul_add(other[i], e[i]));
        quick_two_sum(p, cross)
    }
    #[inline(always)]
    fn to_doubles(self) -> Four {
        self.hi
    }
    #[inline(always)]
    fn parts(self) -> (Four, Four) {
        (self.hi, self.lo)
    }
    #[inline(always)]
    fn from_parts(hi: Four, lo: Four) -> Self {
        Ddx4 { hi, lo }
    }
    #[inline(always)]
    fn sum(self) -> Dd {
        let at = |i: usize| Dd { hi: self.hi[i], lo: self.lo[i] };
        (at(0) + at(1)) + (at(2) + at(3))
    }
}
