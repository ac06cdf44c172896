//! Checks that the processor has the instructions that the program was compiled for.
//!
//! `.cargo/config.toml` compiles for x86-64-v3. On an older processor the first such instruction
//! would end the process by a signal, without a word; so the program asks before anything else.
//! `is_x86_feature_detected!` cannot be used: it returns at compile time what the target has. Nor
//! may the answer be a list or a text made here: moving it could be such an instruction.

/// Whether the processor has all of x86-64-v3, where the program was compiled for it.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
pub fn suffices() -> bool {
    use std::arch::x86_64::{__cpuid, __cpuid_count};

    let highest = __cpuid(0).eax;
    let extended = __cpuid(0x8000_0000).eax;
    if highest < 7 || extended < 0x8000_0001 {
        return false;
    }
    let basic = __cpuid(1).ecx;
    let kept = if basic & OSXSAVE == 0 { 0 } else { kept_by_the_system() };
    has_all(basic, __cpuid_count(7, 0).ebx, __cpuid(0x8000_0001).ecx, kept)
}

/// Any other target runs on every processor that can load it.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub fn suffices() -> bool {
    true
}

/// Leaf 1, ecx: the system switches registers by XSAVE.
#[cfg(target_arch = "x86_64")]
const OSXSAVE: u32 = 1 << 27;
/// Leaf 1, ecx: FMA, MOVBE, AVX, F16C.
#[cfg(target_arch = "x86_64")]
const BASIC: u32 = 1 << 12 | 1 << 22 | 1 << 28 | 1 << 29 | OSXSAVE;
/// Leaf 7, ebx: BMI1, AVX2, BMI2.
#[cfg(target_arch = "x86_64")]
const STRUCTURED: u32 = 1 << 3 | 1 << 5 | 1 << 8;
/// Leaf 0x8000_0001, ecx: LZCNT.
#[cfg(target_arch = "x86_64")]
const EXTENDED: u32 = 1 << 5;
/// XCR0: the system keeps registers of 256 bits.
#[cfg(target_arch = "x86_64")]
const KEPT: u64 = 6;

#[cfg(target_arch = "x86_64")]
fn has_all(basic: u32, structured: u32, extended: u32, kept: u64) -> bool {
    basic & BASIC == BASIC
        && structured & STRUCTURED == STRUCTURED
        && extended & EXTENDED == EXTENDED
        && kept & KEPT == KEPT
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
fn kept_by_the_system() -> u64 {
    #[expect(unsafe_code, reason = "there is no safe way to ask which registers the system keeps")]
    // SAFETY: only called where CPUID says that the instruction is there.
    unsafe {
        std::arch::x86_64::_xgetbv(0)
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_needed() {
        assert!(suffices(), "the tests run here");
        assert!(has_all(!0, !0, !0, !0) && has_all(BASIC, STRUCTURED, EXTENDED, KEPT));
        assert!(!has_all(0, 0, 0, 0));
        for bit in (0..32).map(|bit| 1 << bit) {
            assert_eq!(has_all(!bit, !0, !0, !0), BASIC & bit == 0, "leaf 1, {bit:x}");
            assert_eq!(has_all(!0, !bit, !0, !0), STRUCTURED & bit == 0, "leaf 7, {bit:x}");
            assert_eq!(has_all(!0, !0, !bit, !0), EXTENDED & bit == 0, "leaf 0x80000001, {bit:x}");
        }
        assert!(!has_all(!0, !0, !0, 3));
    }
}
