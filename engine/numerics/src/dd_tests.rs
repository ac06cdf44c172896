//! Laws of double-double arithmetic, checked against integers of 128 bits.

use super::*;
use proptest::prelude::*;

/// An integer of at most 106 bits, exactly.
fn dd(x: i128) -> Dd {
    let hi = x as f64;
    Dd::sum(hi, (x - hi as i128) as f64)
}

/// The integer a double-double holds.
fn int(x: Dd) -> i128 {
    assert_eq!(x.lo.fract(), 0.0);
    x.hi as i128 + x.lo as i128
}

fn close(a: Dd, b: Dd, relative: f64) -> bool {
    (a - b).abs().hi <= relative * b.abs().hi
}

const TINY: f64 = 1.0 / ((1u128 << 100) as f64);

fn any_dd() -> impl Strategy<Value = Dd> {
    (-1e10..1e10f64, -1.0..1.0f64).prop_map(|(hi, lo)| Dd::sum(hi, lo * hi * 1e-16))
}

#[test]
fn roots_and_powers_at_the_edges() {
    assert_eq!(Dd::ZERO.sqrt(), Dd::ZERO);
    assert!(Dd::from(-1.0).sqrt().hi.is_nan());
    assert_eq!(Dd::from(2.0).powi(0), Dd::ONE);
    assert_eq!(Dd::ZERO.powi(0), Dd::ONE);
    assert_eq!(Dd::from(3.0).powi(40), dd(3i128.pow(40)));
    assert_eq!(Dd::from(2.0).powi(-7), Dd::from(0.0078125));
    assert!(!(Dd::ONE / Dd::ZERO).is_finite());
    assert_eq!(Dd::ZERO * Dd::from(5.0), Dd::ZERO);
}

#[test]
fn powers_of_two_cover_the_whole_range() {
    assert_eq!(ldexp(1.0, -1074), f64::from_bits(1));
    assert_eq!(ldexp(f64::from_bits(1), 1074), 1.0);
    assert_eq!(ldexp(f64::MAX, -2000), f64::MAX * pow2(-1000) * pow2(-1000));
    assert_eq!(exponent_of(f64::from_bits(1)), -1074);
    assert_eq!(exponent_of(-0.75), -1);
    assert_eq!(exponent_of(f64::MAX), 1023);
    assert_eq!(Dd::sum(1.0, 1e-20).ldexp(3), Dd::sum(8.0, 8e-20));
    assert_eq!(Dd::sum(1.0, 1e-20).scale_pow2(0.5), Dd::sum(0.5, 5e-21));
}

#[test]
fn one_third_has_thirty_digits() {
    let third = Dd::ONE / Dd::from(3.0);
    assert_eq!(third, Dd::ONE / 3.0);
    assert!(close(third * 3.0, Dd::ONE, TINY));
    assert!((third.lo - 1.850371707708594e-17).abs() < 1e-32);
}

#[test]
fn order_looks_at_both_parts() {
    assert!(Dd::sum(1.0, 1e-20) > Dd::ONE);
    assert!(Dd::sum(1.0, -1e-20) < Dd::ONE);
    assert_eq!(Dd::from(f64::NAN).partial_cmp(&Dd::ONE), None);
    assert_eq!(Dd::sum(-1.0, -1e-20).abs(), Dd::sum(1.0, 1e-20));
}

proptest! {
    #[test]
    fn error_free_transformations_are_exact(a in -(1i64 << 53)..(1i64 << 53), b in -(1i64 << 53)..(1i64 << 53),
        shift in 0..40u32) {
        let (x, y) = (a as f64, (b as f64) * f64::from(shift).exp2());
        let exact = i128::from(a) + (i128::from(b) << shift);
        let (s, e) = two_sum(x, y);
        prop_assert_eq!(s, x + y);
        prop_assert_eq!(s as i128 + e as i128, exact);
        let (s, e) = if x.abs() >= y.abs() { quick_two_sum(x, y) } else { quick_two_sum(y, x) };
        prop_assert_eq!(s as i128 + e as i128, exact);
        let (p, e) = two_prod(a as f64, b as f64);
        prop_assert_eq!(p as i128 + e as i128, i128::from(a) * i128::from(b));
    }

    #[test]
    fn sums_of_integers_are_exact(a in -(1i128 << 100)..(1i128 << 100), b in -(1i128 << 100)..(1i128 << 100),
        c in -(1i64 << 53)..(1i64 << 53)) {
        prop_assert_eq!(int(dd(a) + dd(b)), a + b);
        prop_assert_eq!(int(dd(a) - dd(b)), a - b);
        prop_assert_eq!(int(dd(a) + c as f64), a + i128::from(c));
        prop_assert_eq!(int(dd(a) - c as f64), a - i128::from(c));
        prop_assert_eq!(dd(a) > dd(b), a > b);
    }

    #[test]
    fn products_of_integers_are_exact(a in -(1i128 << 60)..(1i128 << 60), b in -(1i128 << 40)..(1i128 << 40)) {
        prop_assert_eq!(int(dd(a) * dd(b)), a * b);
        prop_assert_eq!(int(dd(a) * b as f64), a * b);
        prop_assert_eq!(int(dd(b).square()), b * b);
    }

    #[test]
    fn results_are_normalised(a in any_dd(), b in any_dd()) {
        for x in [a + b, a - b, a * b, a / b, a.abs().sqrt(), a.square(), a + b.hi, a * b.hi, a / b.hi] {
            prop_assert_eq!(two_sum(x.hi, x.lo), (x.hi, x.lo));
        }
    }

    #[test]
    fn division_undoes_multiplication(a in any_dd(), b in any_dd()) {
        prop_assume!(b.hi != 0.0);
        prop_assert!(close(a * b / b, a, TINY));
        prop_assert!(close(a / b * b, a, TINY));
        prop_assert!(close(a * b.hi / b.hi, a, TINY));
        prop_assert!(close(b.recip() * b, Dd::ONE, TINY));
    }

    #[test]
    fn the_root_squares_back(a in any_dd()) {
        let a = a.abs();
        prop_assert!(close(a.sqrt().square(), a, TINY));
        prop_assert!(close(a.square().sqrt(), a, TINY));
    }

    #[test]
    fn addition_survives_cancellation(a in any_dd(), b in any_dd()) {
        // The accurate sum errs relative to the result, not to the terms.
        prop_assert!(close((a + b) - a, b, 4.0 * TINY * (a.abs().hi / b.abs().hi.max(1e-300)).max(1.0)));
        prop_assert_eq!(a - a, Dd::ZERO);
        prop_assert_eq!(a + b, b + a);
    }

    #[test]
    fn compound_assignment_is_the_plain_operation(a in any_dd(), b in any_dd()) {
        let mut x = a;
        x += b;
        x *= b;
        x -= a;
        x /= Dd::from(7.0);
        prop_assert_eq!(x, ((a + b) * b - a) / Dd::from(7.0));
    }
}
