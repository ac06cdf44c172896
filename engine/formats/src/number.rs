//! Doubles as decimal numbers that come back to the last bit: the shortest digits that do.

/// A real number of ISO 10303-21, also read by every other program that reads C's numbers: `1.5`,
/// `-0.0`, `2.5E-7`.
///
/// The point is obligatory there. `x` is finite: whoever calls has made sure.
pub(super) fn real(x: f64) -> String {
    let digits = format!("{x:?}");
    match digits.split_once('e') {
        None => digits,
        Some((mantissa, exponent)) if mantissa.contains('.') => format!("{mantissa}E{exponent}"),
        Some((mantissa, exponent)) => format!("{mantissa}.0E{exponent}"),
    }
}

/// A real constant of IGES: without `D` it would be of single precision, so `D` is written wherever
/// seven digits do not suffice.
pub(super) fn iges_real(x: f64) -> String {
    let plain = real(x);
    let digits = plain.bytes().filter(u8::is_ascii_digit).count();
    if digits <= 7 && !plain.contains('E') {
        return plain;
    }
    let text = format!("{x:e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) if mantissa.contains('.') => format!("{mantissa}D{exponent}"),
        Some((mantissa, exponent)) => format!("{mantissa}.0D{exponent}"),
        None => plain,
    }
}

/// A real number in at most `width` characters (15 or more), rounded to as many digits as that
/// leaves.
pub(super) fn real_within(x: f64, width: usize) -> String {
    let plain = real(x);
    if plain.len() <= width {
        return plain;
    }
    let shorter = (1..17).rev().map(|digits| format!("{x:.digits$E}")).find(|text| text.len() <= width);
    // a digit, a point, another, E and four characters of exponent always fit
    shorter.unwrap_or(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn spelling() {
        assert_eq!([1.0, -0.0, 1e-7, 2.5e300].map(real), ["1.0", "-0.0", "1.0E-7", "2.5E300"]);
        assert_eq!(
            [0.5, -0.0, 0.1 + 0.2, 1e-7, -1234567.0, 12345678.0].map(iges_real),
            ["0.5", "-0.0", "3.0000000000000004D-1", "1.0D-7", "-1.234567D6", "1.2345678D7"]
        );
    }

    proptest! {
        #[test]
        fn every_bit_comes_back(x in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL
            | proptest::num::f64::ZERO) {
            prop_assert_eq!(real(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
            prop_assert_eq!(iges_real(x).replace('D', "E").parse::<f64>().unwrap().to_bits(), x.to_bits());
            prop_assert!(iges_real(x).len() <= 25 && real(x).contains('.'));
            let short = real_within(x, 20);
            prop_assert!(short.len() <= 20 && short.contains('.'));
            let gap = (short.parse::<f64>().unwrap() - x).abs();
            prop_assert!(gap <= 1e-12 * x.abs() || !x.is_normal(), "{short} {x:e}");
        }
    }
}
