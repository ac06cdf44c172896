//! Kernels compiled twice where the target may lack fused multiply-add.
//!
//! Everything here rests on `a · b + c` rounded once ([`f64::mul_add`]). A build for x86-64 without
//! flags has no instruction for it and calls the C library for each, by which loops over columns
//! get many times slower. The functions made by `with_fma!` are compiled a second time for
//! processors with AVX2 and FMA (Intel since 2013, AMD since 2015), and ask once in a call which of
//! both runs. The operations and their order are the same, and so are the results, bit by bit.
//! Where the whole build may use the instructions, nothing is asked and nothing is compiled twice.
//!
//! What is compiled twice is what is inlined: a kernel, its closures and what it calls
//! `#[inline(always)]`. Single operations outside of kernels ([`fma`]) ask for themselves.

/// Returns whether this processor has the instructions that the second version is compiled for.
#[doc(hidden)]
#[cfg(all(target_arch = "x86_64", not(all(target_feature = "avx2", target_feature = "fma"))))]
#[inline(always)]
pub fn has_fma() -> bool {
    use std::sync::atomic::{AtomicU8, Ordering};

    const UNKNOWN: u8 = 0;
    const NO: u8 = 1;
    const YES: u8 = 2;
    // one comparison for each operation that asks
    static ANSWER: AtomicU8 = AtomicU8::new(UNKNOWN);

    #[cold]
    fn ask() -> bool {
        let has = std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
        ANSWER.store(if has { YES } else { NO }, Ordering::Relaxed);
        has
    }

    match ANSWER.load(Ordering::Relaxed) {
        YES => true,
        NO => false,
        _ => ask(),
    }
}

/// `a · b + c`, rounded once, for sequences of dependent operations: where the build may not use
/// the instruction everywhere, no call into a library either. Loops that the compiler is to turn
/// into vector instructions take [`f64::mul_add`] inside of `with_fma!`.
#[inline(always)]
pub fn fma(a: f64, b: f64, c: f64) -> f64 {
    #[cfg(all(target_arch = "x86_64", not(all(target_feature = "avx2", target_feature = "fma"))))]
    if has_fma() {
        let mut result = a;
        #[expect(unsafe_code, reason = "a function with the instruction enabled could not be inlined here")]
        // SAFETY: the processor has been asked for the instruction, which touches registers alone.
        unsafe {
            std::arch::asm!(
                "vfmadd213sd {0}, {1}, {2}",
                inout(xmm_reg) result, in(xmm_reg) b, in(xmm_reg) c,
                options(pure, nomem, nostack, preserves_flags)
            );
        }
        return result;
    }
    a.mul_add(b, c)
}

/// Functions whose inner loops are multiplications with addition. Arguments are plain names.
#[macro_export]
macro_rules! with_fma {
    ($(
        $(#[$attribute:meta])*
        $visible:vis fn $name:ident $(<$($generic:ident: $bound:path),+>)?
            ($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? $body:block
    )+) => {$(
        $(#[$attribute])*
        #[inline(always)]
        $visible fn $name $(<$($generic: $bound),+>)? ($($argument: $type),*) $(-> $result)? {
            #[inline(always)]
            fn plain $(<$($generic: $bound),+>)? ($($argument: $type),*) $(-> $result)? $body

            #[cfg(all(target_arch = "x86_64", not(all(target_feature = "avx2", target_feature = "fma"))))]
            if $crate::dispatch::has_fma() {
                #[target_feature(enable = "avx2,fma")]
                fn fused $(<$($generic: $bound),+>)? ($($argument: $type),*) $(-> $result)? {
                    plain $(::<$($generic),+>)? ($($argument),*)
                }
                #[expect(unsafe_code, reason = "the version for processors with FMA runs on those alone")]
                // SAFETY: the processor has been asked for the instructions.
                return unsafe { fused $(::<$($generic),+>)? ($($argument),*) };
            }
            plain $(::<$($generic),+>)? ($($argument),*)
        }
    )+};
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::fma;

    with_fma! {
        /// Σ x y, rounded once for each term.
        fn chain(x: &[f64], y: &[f64]) -> f64 {
            x.iter().zip(y).fold(0.0, |sum: f64, (x, y)| x.mul_add(*y, sum))
        }
    }

    /// Sums whose bits differ between one and two roundings of a term.
    #[test]
    fn every_version_rounds_once() {
        let x: Vec<f64> = (0..100).map(|i| 1.0 + f64::from(i) * 1e-9).collect();
        let y: Vec<f64> = x.iter().rev().map(|x| -x).collect();
        let (mut sum, mut twice) = (0.0f64, 0.0);
        for (x, y) in x.iter().zip(&y) {
            sum = x.mul_add(*y, sum);
            twice += x * y;
        }
        assert_eq!(chain(&x, &y).to_bits(), sum.to_bits());
        assert_ne!(sum.to_bits(), f64::to_bits(twice));
    }

    proptest! {
        #[test]
        fn a_single_operation_is_that_of_the_library(a in any::<f64>(), b in any::<f64>(), c in any::<f64>()) {
            let (got, want) = (fma(a, b, c), a.mul_add(b, c));
            prop_assert!(got.to_bits() == want.to_bits() || got.is_nan() && want.is_nan(), "{got} {want}");
            let near = fma(a, b, -(a * b));
            prop_assert!(near.to_bits() == a.mul_add(b, -(a * b)).to_bits() || near.is_nan());
        }
    }
}
