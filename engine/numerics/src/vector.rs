//! Four doubles in one register.
//!
//! Compilers turn loops over small arrays into vector instructions, but lose sight of them in
//! longer kernels. On x86-64 a [`F64x4`] is therefore such a register by name, elsewhere an array.
//! Operations are instructions by name where the whole build may use AVX and FMA. Where it may not
//! they are written lane by lane, of which the compiler makes the same instructions inside of
//! [`with_fma!`](super::with_fma). All do the same correctly rounded operations in the same order,
//! so that results do not depend on the processor.

use std::ops::{Add, Mul, Neg, Sub};

/// Number of lanes of a vector.
pub const LANES: usize = 4;

/// Four doubles.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct F64x4(register::Four);

impl F64x4 {
    /// Four zeros.
    pub const ZERO: Self = F64x4::new([0.0; LANES]);
    /// Four ones.
    pub const ONE: Self = F64x4::new([1.0; LANES]);

    /// These four numbers.
    #[inline(always)]
    pub const fn new(values: [f64; LANES]) -> Self {
        F64x4(register::load(values))
    }
    /// One number four times.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        F64x4::new([value; LANES])
    }
    /// The four numbers.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        register::store(self.0)
    }
    /// Borrows the four numbers in place.
    #[inline(always)]
    pub fn as_array(&self) -> &[f64; LANES] {
        register::numbers(&self.0)
    }
    /// The same, to write one of them.
    #[inline(always)]
    pub fn as_mut_array(&mut self) -> &mut [f64; LANES] {
        register::numbers_mut(&mut self.0)
    }
    /// `self · a + b`, rounded once.
    #[inline(always)]
    pub fn mul_add(self, a: Self, b: Self) -> Self {
        F64x4(machine::mul_add(self.0, a.0, b.0))
    }
    /// `self · a − b`, rounded once.
    #[inline(always)]
    pub fn mul_sub(self, a: Self, b: Self) -> Self {
        F64x4(machine::mul_sub(self.0, a.0, b.0))
    }
    /// 1/x of each.
    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        F64x4(machine::divide(Self::ONE.0, self.0))
    }
    /// √x of each; NaN below zero.
    #[inline(always)]
    pub fn square_root(self) -> Self {
        F64x4(machine::square_root(self.0))
    }
    /// The absolute value of each.
    #[inline(always)]
    pub fn abs(self) -> Self {
        F64x4(machine::abs(self.0))
    }
    /// The larger one; where either is NaN, `other`.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        F64x4(machine::larger(self.0, other.0))
    }
}

impl Add for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        F64x4(machine::add(self.0, other.0))
    }
}

impl Sub for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        F64x4(machine::subtract(self.0, other.0))
    }
}

impl Mul for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        F64x4(machine::multiply(self.0, other.0))
    }
}

impl Mul<f64> for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * F64x4::splat(factor)
    }
}

impl Neg for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        F64x4(machine::negate(self.0))
    }
}

/// Storage of four doubles.
#[cfg(target_arch = "x86_64")]
mod register {
    #![expect(unsafe_code, reason = "a register and an array of four doubles are the same bytes")]

    pub(super) type Four = std::arch::x86_64::__m256d;

    #[inline(always)]
    pub(super) const fn load(values: [f64; 4]) -> Four {
        // SAFETY: both are four doubles, one behind the other.
        unsafe { std::mem::transmute::<[f64; 4], Four>(values) }
    }
    #[inline(always)]
    pub(super) fn store(four: Four) -> [f64; 4] {
        // SAFETY: both are four doubles, one behind the other.
        unsafe { std::mem::transmute::<Four, [f64; 4]>(four) }
    }
    #[inline(always)]
    pub(super) fn numbers(four: &Four) -> &[f64; 4] {
        // SAFETY: both are four doubles, one behind the other.
        unsafe { &*std::ptr::from_ref(four).cast() }
    }
    #[inline(always)]
    pub(super) fn numbers_mut(four: &mut Four) -> &mut [f64; 4] {
        // SAFETY: both are four doubles, one behind the other.
        unsafe { &mut *std::ptr::from_mut(four).cast() }
    }
}

/// Storage of four doubles.
#[cfg(not(target_arch = "x86_64"))]
mod register {
    pub(super) type Four = [f64; 4];

    #[inline(always)]
    pub(super) const fn load(values: [f64; 4]) -> Four {
        values
    }
    #[inline(always)]
    pub(super) fn store(four: Four) -> [f64; 4] {
        four
    }
    #[inline(always)]
    pub(super) fn numbers(four: &Four) -> &[f64; 4] {
        four
    }
    #[inline(always)]
    pub(super) fn numbers_mut(four: &mut Four) -> &mut [f64; 4] {
        four
    }
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx", target_feature = "fma"))]
mod machine {
    #![expect(unsafe_code, reason = "this module exists only where the compiler may use AVX and FMA everywhere")]

    use std::arch::x86_64::*;

    use super::register::{Four, load};

    /// An operation on registers whose only demand is that the processor has AVX and FMA.
    macro_rules! operations {
        ($($name:ident($($x:ident),+) = $instruction:ident($($argument:expr),+);)+) => {$(
            #[inline(always)]
            pub(super) fn $name($($x: Four),+) -> Four {
                // SAFETY: the module is compiled only for targets that have the instruction.
                unsafe { $instruction($($argument),+) }
            }
        )+};
    }

    operations! {
        add(a, b) = _mm256_add_pd(a, b);
        subtract(a, b) = _mm256_sub_pd(a, b);
        multiply(a, b) = _mm256_mul_pd(a, b);
        divide(a, b) = _mm256_div_pd(a, b);
        mul_add(a, b, c) = _mm256_fmadd_pd(a, b, c);
        mul_sub(a, b, c) = _mm256_fmsub_pd(a, b, c);
        square_root(a) = _mm256_sqrt_pd(a);
        larger(a, b) = _mm256_max_pd(a, b);
        negate(a) = _mm256_xor_pd(a, load([-0.0; 4]));
        abs(a) = _mm256_andnot_pd(load([-0.0; 4]), a);
    }
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx", target_feature = "fma")))]
mod machine {
    use super::register::{Four, load, store};

    /// An operation on each lane.
    macro_rules! operations {
        ($($name:ident($($x:ident),+) = $result:expr;)+) => {$(
            #[inline(always)]
            pub(super) fn $name($($x: Four),+) -> Four {
                $(let $x = store($x);)+
                let lane = |k: usize| {
                    $(let $x: f64 = $x[k];)+
                    $result
                };
                load([lane(0), lane(1), lane(2), lane(3)])
            }
        )+};
    }

    operations! {
        add(a, b) = a + b;
        subtract(a, b) = a - b;
        multiply(a, b) = a * b;
        divide(a, b) = a / b;
        mul_add(a, b, c) = a.mul_add(b, c);
        mul_sub(a, b, c) = a.mul_add(b, -c);
        square_root(a) = a.sqrt();
        larger(a, b) = if a > b { a } else { b };
        negate(a) = -a;
        abs(a) = a.abs();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn same(got: F64x4, want: impl Fn(usize) -> f64) {
        for (k, got) in got.to_array().into_iter().enumerate() {
            let want = want(k);
            assert!(got.to_bits() == want.to_bits() || (got.is_nan() && want.is_nan()), "{k}: {got} {want}");
        }
    }

    proptest! {
        /// Every operation is, bit by bit, the scalar one in every lane.
        #[test]
        fn lanes_agree_with_scalar_operations(
            x in prop::array::uniform4(any::<f64>()),
            y in prop::array::uniform4(any::<f64>()),
            z in prop::array::uniform4(any::<f64>()),
        ) {
            let (a, b, c) = (F64x4::new(x), F64x4::new(y), F64x4::new(z));
            same(a + b, |k| x[k] + y[k]);
            same(a - b, |k| x[k] - y[k]);
            same(a * b, |k| x[k] * y[k]);
            same(a * 3.5, |k| x[k] * 3.5);
            same(-a, |k| -x[k]);
            same(a.abs(), |k| x[k].abs());
            same(a.reciprocal(), |k| 1.0 / x[k]);
            same(a.square_root(), |k| x[k].sqrt());
            same(a.mul_add(b, c), |k| x[k].mul_add(y[k], z[k]));
            same(a.mul_sub(b, c), |k| x[k].mul_add(y[k], -z[k]));
            same(a.larger(b), |k| if x[k] > y[k] { x[k] } else { y[k] });
        }
    }
}
