//! Decimal text to the nearest double, for numbers as measuring machines write them.
//!
//! Digits are gathered eight at a time into an integer `w`, and `w · 10^q` is rounded by one or two
//! 128-bit products with a truncated power of five (D. Lemire, *Number parsing at a gigabyte per
//! second*, Software: Practice and Experience 51, 2021). For at most 19 digits and −27 ≤ q ≤ 55 the
//! product always decides the rounding and neither overflows nor underflows. Everything else is
//! left to the general parser, which is slower and has no bounds.

/// Least and greatest power of ten that are handled here.
const LEAST: i64 = -27;
const GREATEST: i64 = 55;

/// Most digits that fit an integer of 64 bits, whatever they are.
const MOST_DIGITS: usize = 19;

/// The first 128 bits of 5^q, the highest bit set: truncated for q ≥ 0 (and exact, since 5^55 <
/// 2^128), rounded up for q < 0.
static POWERS: [u128; (GREATEST - LEAST + 1) as usize] = powers();

const fn powers() -> [u128; (GREATEST - LEAST + 1) as usize] {
    let mut table = [0; (GREATEST - LEAST + 1) as usize];
    let mut q = LEAST;
    while q <= GREATEST {
        let power = 5_u128.pow(q.unsigned_abs() as u32);
        table[(q - LEAST) as usize] = if q < 0 { reciprocal(power) } else { power << power.leading_zeros() };
        q += 1;
    }
    table
}

/// ⌊2^(127 + b) / d⌋ + 1, b the bits of d: the reciprocal of d with its highest bit at 127.
const fn reciprocal(d: u128) -> u128 {
    // Long division of 2^b · 2^127; 2^b / d is in (1, 2], so the quotient has 128 bits.
    let bits = 128 - d.leading_zeros();
    let mut quotient = 1_u128;
    let mut remainder = (1_u128 << bits) - d;
    let mut i = 0;
    while i < 127 {
        remainder <<= 1;
        quotient <<= 1;
        if remainder >= d {
            remainder -= d;
            quotient |= 1;
        }
        i += 1;
    }
    quotient + 1
}

/// The number at the beginning of `text` and its length, when it has a form and a size that are
/// handled here.
///
/// `text` begins with an optional sign and a digit, without a superfluous zero, and a decimal point
/// in it is followed by a digit. An exponent without digits is not taken.
#[inline]
pub fn parse(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let begin = usize::from(negative);
    let mut at = begin;
    let mut w = 0_u64;
    digits(text, &mut at, &mut w);
    let mut count = at - begin;
    let mut q = 0_i64;
    if text.get(at) == Some(&b'.') {
        at += 1;
        let point = at;
        digits(text, &mut at, &mut w);
        q = -((at - point) as i64);
        count += at - point;
    }
    if count > MOST_DIGITS {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let (exponent, end) = exponent(text, at + 1)?;
        q = q.saturating_add(exponent);
        at = end;
    }
    if w == 0 {
        return Some((0.0, at));
    }
    let value = nearest(w, q)?;
    Some((if negative { -value } else { value }, at))
}

/// Gathers the digits from `at` on. More than 19 of them overflow `w`, which the caller looks at.
#[inline]
fn digits(text: &[u8], at: &mut usize, w: &mut u64) {
    while let Some(eight) = text[*at..].first_chunk::<8>() {
        let Some(value) = eight_digits(u64::from_le_bytes(*eight)) else { break };
        *w = w.wrapping_mul(100_000_000).wrapping_add(value);
        *at += 8;
    }
    while let Some(digit) = text.get(*at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
        *w = w.wrapping_mul(10).wrapping_add(u64::from(digit));
        *at += 1;
    }
}

/// Eight ASCII digits, the first in the lowest byte, as a number: pairs, then pairs of pairs, then
/// the two halves.
#[inline]
fn eight_digits(bytes: u64) -> Option<u64> {
    let digits = bytes.wrapping_sub(0x3030_3030_3030_3030);
    // A byte below '0' borrows into its highest bit; one above '9' carries into it.
    if (bytes.wrapping_add(0x4646_4646_4646_4646) | digits) & 0x8080_8080_8080_8080 != 0 {
        return None;
    }
    Some(together(digits))
}

/// Eight digits, one a byte, as a number.
#[inline]
fn together(digits: u64) -> u64 {
    let pairs = (digits.wrapping_mul(10).wrapping_add(digits >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul(100).wrapping_add(pairs >> 16)) & 0x0000_ffff_0000_ffff;
    (fours.wrapping_mul(10_000).wrapping_add(fours >> 32)) & 0xffff_ffff
}

/// Bytes that are looked at for one number, its sign apart: eight digits, a point, 24 digits and
/// what follows.
const WINDOW: usize = 40;

/// The number at the beginning of `text` and its length when it has the usual form: strict JSON, at
/// most eight digits before a point and 24 behind it, and a text that goes on for a while. `None`
/// says nothing about the text.
///
/// How many digits a number has changes from one to the next and cannot be foreseen by the
/// processor, so hardly a branch depends on it: the sixteen bytes behind the point are made a
/// number at once, with what follows its digits shifted out.
#[inline]
pub fn usual(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let begin = usize::from(negative);
    let window: &[u8; WINDOW] = text.get(begin..)?.first_chunk()?;
    let mut at = 0;
    let mut w = 0;
    while at < 8 && window[at].is_ascii_digit() {
        w = 10 * w + u64::from(window[at] - b'0');
        at += 1;
    }
    if at == 0 || (window[0] == b'0' && at > 1) {
        return None;
    }
    let mut q = 0;
    if window[at] == b'.' {
        at += 1;
        let (value, count) = sixteen(window[at..].first_chunk()?)?;
        w = w.checked_mul(TENS[count])?.checked_add(value)?;
        at += count;
        q = -(count as i64);
        if (count == 16) & window[at].is_ascii_digit() {
            let (value, count) = eight(window[at..].first_chunk()?);
            w = w.checked_mul(TENS[count])?.checked_add(value)?;
            at += count;
            q -= count as i64;
        }
    }
    // Also where there were more digits than are looked at.
    if window.get(at).is_none_or(u8::is_ascii_digit) {
        return None;
    }
    at += begin;
    if let Some(b'e' | b'E') = text.get(at) {
        let (exponent, end) = exponent(text, at + 1)?;
        q = q.saturating_add(exponent);
        at = end;
    }
    let value = if w == 0 { 0.0 } else { nearest(w, q)? };
    Some((if negative { -value } else { value }, at))
}

/// Powers of ten.
const TENS: [u64; 17] = {
    let mut tens = [1; 17];
    let mut i = 1;
    while i < tens.len() {
        tens[i] = 10 * tens[i - 1];
        i += 1;
    }
    tens
};

/// The digits that sixteen bytes begin with as a number, and how many there are; `None` without
/// any.
#[inline]
fn sixteen(bytes: &[u8; 16]) -> Option<(u64, usize)> {
    const OVER_9: u128 = u128::from_le_bytes([0x76; 16]);
    const HIGHEST_BITS: u128 = u128::from_le_bytes([0x80; 16]);
    let digits = u128::from_le_bytes(*bytes) ^ u128::from_le_bytes([b'0'; 16]);
    // The highest bit of every byte above 9. A carry goes from such a byte to later ones only,
    // which do not count any more.
    let others = (digits.wrapping_add(OVER_9) | digits) & HIGHEST_BITS;
    let count = others.trailing_zeros() / 8;
    let digits = digits.checked_shl(128 - 8 * count)?;
    let (first, last) = (digits as u64, (digits >> 64) as u64);
    Some((together(first) * 100_000_000 + together(last), count as usize))
}

/// The same of eight bytes, which may begin without a digit.
fn eight(bytes: &[u8; 8]) -> (u64, usize) {
    bytes
        .iter()
        .take_while(|byte| byte.is_ascii_digit())
        .fold((0, 0), |(w, count), byte| (10 * w + u64::from(byte - b'0'), count + 1))
}

fn exponent(text: &[u8], mut at: usize) -> Option<(i64, usize)> {
    let negative = text.get(at) == Some(&b'-');
    at += usize::from(matches!(text.get(at), Some(b'-' | b'+')));
    let begin = at;
    let mut value = 0_i64;
    while let Some(digit) = text.get(at).filter(|byte| byte.is_ascii_digit()) {
        value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
        at += 1;
    }
    (at > begin).then_some((if negative { -value } else { value }, at))
}

/// The double nearest to `w · 10^q`, ties to even; `w` is not 0.
#[inline]
fn nearest(w: u64, q: i64) -> Option<f64> {
    if !(LEAST..=GREATEST).contains(&q) {
        return None;
    }
    let power = POWERS[(q - LEAST) as usize];
    let shift = w.leading_zeros();
    let w = w << shift;
    // The upper 128 bits of w · 5^q, the second product only where the first leaves the rounding
    // open.
    let mut product = u128::from(w) * (power >> 64);
    if product >> 64 & 0x1ff == 0x1ff {
        product = product.wrapping_add((u128::from(w) * (power & u128::from(u64::MAX))) >> 64);
    }
    let (high, low) = ((product >> 64) as u64, product as u64);
    let upper = (high >> 63) as u32;
    // 54 bits: the 53 of a double and one to round by.
    let cut = upper + 9;
    let mut mantissa = high >> cut;
    // 10^q = 5^q · 2^q, and 5^q has its highest bit at place ⌊q log₂ 5⌋.
    let exponent = ((217_706 * q) >> 16) + 63 + i64::from(upper) - i64::from(shift);
    // Exactly between two doubles: only where the product is exact, which needs a small power.
    if low <= 1 && (-4..=23).contains(&q) && mantissa & 3 == 1 && mantissa << cut == high {
        mantissa &= !1;
    }
    mantissa = (mantissa + (mantissa & 1)) >> 1;
    let carried = mantissa >> 53;
    let biased = (exponent + 1023) as u64 + carried;
    // A carry leaves 2^53, whose lower bits are zero either way.
    Some(f64::from_bits((biased << 52) | (mantissa & ((1 << 52) - 1))))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn agrees(text: &str) -> Result<(), TestCaseError> {
        if let Some((value, length)) = parse(text.as_bytes()) {
            let expected: f64 = text[..length].parse().unwrap();
            prop_assert_eq!(length, text.len());
            prop_assert_eq!(value.abs().to_bits(), expected.abs().to_bits(), "{}: {} for {}", text, value, expected);
        }
        // Whatever follows the number.
        for rest in [
            ",00000000000000000000000000000000000",
            "]}zzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzzz",
            " \u{7f}999999999999999999999999999999999",
        ] {
            if let Some((value, length)) = usual(format!("{text}{rest}").as_bytes()) {
                let expected: f64 = text.parse().unwrap();
                prop_assert_eq!(length, text.len());
                prop_assert_eq!(value.to_bits(), expected.to_bits(), "{}: {} for {}", text, value, expected);
            }
        }
        Ok(())
    }

    #[test]
    fn usual_numbers_are_handled_here() {
        for text in [
            "0",
            "-0.0",
            "1",
            "-1.5",
            "0.1",
            "123456789.125",
            "5.9700000000000006",
            "1e22",
            "9007199254740993",
            "1E-5",
            "0.000123456789012345",
            "-273.15",
            "1.7976931348623157e50",
            "8.98846567431158e-10",
            "4503599627370496.5",
            "4503599627370497.5",
            "9007199254740992",
            "9007199254740991",
            "18446744073709551615e0",
            "1234567890123456789",
        ] {
            let mantissa = text.split(['e', 'E']).next().unwrap();
            let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
            assert_eq!(parse(text.as_bytes()).is_some(), digits <= 19, "{text}");
            agrees(text).unwrap();
        }
        let with_more = |text: &str| usual(format!("{text}, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5").as_bytes());
        for text in [
            "0",
            "-1.5",
            "0.1",
            "5.9700000000000006",
            "1E-5",
            "-273.15",
            "12345678",
            "0.1234567890123456",
            "1.7e50",
            "0.0032247228043498855",
            "0.0012345678901234567890",
        ] {
            assert_eq!(with_more(text), Some((text.parse().unwrap(), text.len())), "{text}");
        }
        for text in [
            "01",
            "-01.5",
            "1.",
            ".5",
            "-",
            "1.e5",
            "1e",
            "1e+",
            "123456789",
            "1.7e99",
            "0.12345678901234567890123456789",
        ] {
            assert_eq!(with_more(text), None, "{text}");
        }
        assert_eq!(usual(b"1.5"), None, "the text ends");
        assert_eq!(parse(b"12,3"), Some((12.0, 2)));
        assert_eq!(parse(b"1e400"), None);
        assert_eq!(parse(b"1e"), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn every_text_gives_the_nearest_double(w in any::<u64>(), digits in 1..21_usize, point in 0..20_usize,
            exponent in -60..60_i64) {
            let mut text = w.to_string();
            text.truncate(digits);
            if point > 0 && point < text.len() {
                text.insert(point, '.');
            }
            agrees(&text)?;
            agrees(&format!("-{text}e{exponent}"))?;
        }

        #[test]
        fn shortest_and_long_forms_of_doubles(bits in any::<u64>(), scale in -40..40_i32) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let near_one = f64::from_bits((bits >> 12) | (1023 << 52)) * 10_f64.powi(scale);
            for value in [value, near_one] {
                agrees(&format!("{value:e}"))?;
                agrees(&format!("{value}"))?;
                agrees(&format!("{value:.16e}"))?;
            }
        }

        /// Halfway between neighbouring doubles, and one digit off it.
        #[test]
        fn ties_go_to_even(odd in (1_u64 << 52)..(1 << 53), shift in 0..11_u32, step in -1..=1_i64) {
            let halfway = (u128::from(odd) * 2 + 1) << shift;
            let text = (halfway as i128 + i128::from(step)).to_string();
            agrees(&text)?;
            let quarter = format!("{}.{}", odd / 4, [0, 25, 5, 75][(odd % 4) as usize]);
            agrees(&quarter)?;
        }
    }
}
