//! Whether this processor has the instructions that the program was compiled for.
//!
//! `.cargo/config.toml` compiles for x86-64-v3. On an older processor the first such instruction
//! would end the process by a signal, without a word; so the program asks before anything else.
//! `is_x86_feature_detected!` cannot be asked: it answers at compile time what the target has.

/// What is missing of x86-64-v3, where the program was compiled for it.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
pub fn missing() -> Vec<&'static str> {
    use std::arch::x86_64::{__cpuid, __cpuid_count};

    let highest = __cpuid(0).eax;
    let extended = __cpuid(0x8000_0000).eax;
    let basic = __cpuid(1).ecx;
    let words = Words {
        basic,
        structured: if highest >= 7 { __cpuid_count(7, 0).ebx } else { 0 },
        extended: if extended >= 0x8000_0001 { __cpuid(0x8000_0001).ecx } else { 0 },
        kept: if basic & OSXSAVE == 0 { 0 } else { kept_by_the_system() },
    };
    words.missing()
}

/// Any other target runs on every processor that can load it.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub fn missing() -> Vec<&'static str> {
    Vec::new()
}

/// Leaf 1, ecx: the system switches registers by XSAVE.
#[cfg(target_arch = "x86_64")]
const OSXSAVE: u32 = 1 << 27;

/// What CPUID and XGETBV tell.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Words {
    /// Leaf 1, ecx.
    basic: u32,
    /// Leaf 7, ebx.
    structured: u32,
    /// Leaf 0x8000_0001, ecx.
    extended: u32,
    /// XCR0: the registers that the system keeps.
    kept: u64,
}

#[cfg(target_arch = "x86_64")]
impl Words {
    /// Names of the parts of x86-64-v3 that are not there.
    fn missing(&self) -> Vec<&'static str> {
        let has = |word: u32, bit: u32| word >> bit & 1 == 1;
        // 256-bit registers need the system too
        let ymm = self.basic & OSXSAVE != 0 && self.kept & 6 == 6;
        let parts = [
            ("avx", has(self.basic, 28) && ymm),
            ("avx2", has(self.structured, 5) && ymm),
            ("bmi1", has(self.structured, 3)),
            ("bmi2", has(self.structured, 8)),
            ("f16c", has(self.basic, 29) && ymm),
            ("fma", has(self.basic, 12) && ymm),
            ("lzcnt", has(self.extended, 5)),
            ("movbe", has(self.basic, 22)),
        ];
        parts.iter().filter(|(_, there)| !there).map(|(name, _)| *name).collect()
    }
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

    /// A processor of 2013 under a system of today.
    const HASWELL: Words = Words {
        basic: OSXSAVE | 1 << 12 | 1 << 22 | 1 << 28 | 1 << 29,
        structured: 1 << 3 | 1 << 5 | 1 << 8,
        extended: 1 << 5,
        kept: 7,
    };

    #[test]
    fn nothing_is_missing_where_the_tests_run() {
        assert!(missing().is_empty());
        assert!(HASWELL.missing().is_empty());
    }

    #[test]
    fn what_is_missing_is_named() {
        let nehalem = Words { basic: 0, structured: 0, extended: 0, kept: 0 };
        assert_eq!(nehalem.missing().len(), 8);
        let without_fma = Words { basic: HASWELL.basic & !(1 << 12), ..HASWELL };
        assert_eq!(without_fma.missing(), ["fma"]);
        let old_system = Words { kept: 3, ..HASWELL };
        assert_eq!(old_system.missing(), ["avx", "avx2", "f16c", "fma"]);
    }
}
