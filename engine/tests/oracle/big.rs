//! Binary floating point of 640 bits on top of big integers: `mantissa · 2^exponent`, rounded to
//! nearest. Every double is exact in it, and so is every product of a few doubles.

use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

const BITS: u64 = 640;

#[derive(Clone)]
pub struct Big {
    mantissa: BigInt,
    exponent: i64,
}

impl Big {
    pub fn zero() -> Self {
        Big { mantissa: BigInt::from(0), exponent: 0 }
    }

    pub fn one() -> Self {
        Big { mantissa: BigInt::from(1), exponent: 0 }
    }

    fn rounded(mantissa: BigInt, exponent: i64) -> Self {
        let excess = mantissa.bits().saturating_sub(BITS);
        if excess == 0 {
            return Big { mantissa, exponent };
        }
        // Arithmetic shifts floor, so adding half an ulp first rounds to nearest for both signs.
        let half = BigInt::from(1) << (excess - 1);
        Big { mantissa: (mantissa + half) >> excess, exponent: exponent + excess as i64 }
    }

    /// A decimal number as printed in tables: `-1.25`, `.11019`, `6.38e-16`, `0.78E+03`.
    pub fn parse(text: &str) -> Self {
        let text = text.trim();
        let (digits, power) = match text.find(['e', 'E']) {
            Some(at) => (&text[..at], text[at + 1..].trim_start_matches('+').parse::<i64>().expect("an exponent")),
            None => (text, 0),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let mantissa: BigInt = format!("{whole}{fraction}").parse().expect("decimal digits");
        let power = power - fraction.len() as i64;
        let scale = Big::rounded(BigInt::from(10).pow(power.unsigned_abs() as u32), 0);
        let number = Big::rounded(mantissa, 0);
        if power >= 0 { &number * &scale } else { &number / &scale }
    }

    pub fn is_zero(&self) -> bool {
        self.mantissa.sign() == Sign::NoSign
    }

    pub fn is_negative(&self) -> bool {
        self.mantissa.sign() == Sign::Minus
    }

    pub fn abs(&self) -> Self {
        if self.is_negative() { -self } else { self.clone() }
    }

    /// The square root; of a negative number (rounding around 0) it is 0.
    pub fn sqrt(&self) -> Self {
        if self.is_negative() || self.is_zero() {
            return Big::zero();
        }
        let mut shift = (2 * BITS).saturating_sub(self.mantissa.bits()) as i64;
        if (self.exponent - shift) % 2 != 0 {
            shift += 1;
        }
        Big::rounded((&self.mantissa << shift).sqrt(), (self.exponent - shift) / 2)
    }

    /// log10 of the absolute value, to double accuracy; −∞ for 0.
    pub fn log10(&self) -> f64 {
        if self.is_zero() {
            return f64::NEG_INFINITY;
        }
        let bits = self.mantissa.bits() as i64;
        let top = Big { mantissa: self.mantissa.clone(), exponent: -bits }.abs().to_f64();
        top.log10() + (self.exponent + bits) as f64 * std::f64::consts::LOG10_2
    }

    /// The nearest double (of the normal range).
    pub fn to_f64(&self) -> f64 {
        if self.is_zero() {
            return 0.0;
        }
        let (sign, magnitude) = (self.mantissa.sign(), self.mantissa.magnitude());
        // 64 leading bits with everything below folded into the last: converting u64 to f64 then
        // rounds correctly.
        let excess = magnitude.bits() as i64 - 64;
        let top = if excess > 0 {
            let kept = magnitude >> excess as u64;
            let lost = (&kept << excess as u64) != *magnitude;
            kept.iter_u64_digits().next().unwrap_or(0) | u64::from(lost)
        } else {
            magnitude.iter_u64_digits().next().unwrap_or(0)
        };
        let power = self.exponent + excess.max(0);
        let half = power / 2;
        let value = top as f64 * 2f64.powi(half as i32) * 2f64.powi((power - half) as i32);
        if sign == Sign::Minus { -value } else { value }
    }
}

impl From<f64> for Big {
    fn from(value: f64) -> Self {
        assert!(value.is_finite(), "{value} has no place here");
        let bits = value.to_bits();
        let stored = ((bits >> 52) & 0x7ff) as i64;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let mantissa = if stored == 0 { fraction } else { fraction | 1 << 52 };
        let mantissa = BigInt::from(if value < 0.0 { -mantissa } else { mantissa });
        Big { mantissa, exponent: stored.max(1) - 1075 }
    }
}

impl From<usize> for Big {
    fn from(value: usize) -> Self {
        Big { mantissa: BigInt::from(value), exponent: 0 }
    }
}

impl Add for &Big {
    type Output = Big;
    fn add(self, other: &Big) -> Big {
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        let (high, low) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        let gap = (high.exponent - low.exponent) as u64;
        // A number that lies wholly below the other's last bit cannot matter.
        if gap > 4 * BITS && low.mantissa.bits() < gap {
            return high.clone();
        }
        Big::rounded((&high.mantissa << gap) + &low.mantissa, low.exponent)
    }
}

impl Neg for &Big {
    type Output = Big;
    fn neg(self) -> Big {
        Big { mantissa: -&self.mantissa, exponent: self.exponent }
    }
}

impl Sub for &Big {
    type Output = Big;
    fn sub(self, other: &Big) -> Big {
        self + &-other
    }
}

impl Mul for &Big {
    type Output = Big;
    fn mul(self, other: &Big) -> Big {
        Big::rounded(&self.mantissa * &other.mantissa, self.exponent + other.exponent)
    }
}

impl Div for &Big {
    type Output = Big;
    fn div(self, other: &Big) -> Big {
        assert!(!other.is_zero(), "division by 0");
        let shift = BITS + 2 + other.mantissa.bits();
        Big::rounded((&self.mantissa << shift) / &other.mantissa, self.exponent - other.exponent - shift as i64)
    }
}

macro_rules! owned {
    ($($trait:ident $method:ident),*) => {$(
        impl $trait for Big {
            type Output = Big;
            fn $method(self, other: Big) -> Big {
                (&self).$method(&other)
            }
        }
    )*};
}
owned!(Add add, Sub sub, Mul mul, Div div);

impl PartialEq for Big {
    fn eq(&self, other: &Self) -> bool {
        (self - other).is_zero()
    }
}

impl PartialOrd for Big {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let difference = self - other;
        Some(match difference.mantissa.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        })
    }
}

impl fmt::Debug for Big {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:e}", self.to_f64())
    }
}

/// Correct decimal digits of a double: −log10 of its relative error. Where the truth is 0, of its
/// absolute error.
pub fn digits(got: f64, truth: &Big) -> f64 {
    let error = &Big::from(got) - truth;
    if error.is_zero() {
        return f64::INFINITY;
    }
    if truth.is_zero() { -error.log10() } else { truth.log10() - error.log10() }
}

/// The digits of the worst entry.
pub fn worst_digits(got: &[f64], truth: &[Big]) -> f64 {
    assert_eq!(got.len(), truth.len());
    got.iter().zip(truth).map(|(g, t)| digits(*g, t)).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_oracle_itself() {
    let third = &Big::one() / &Big::from(3.0);
    assert_eq!(third.to_f64(), 1.0 / 3.0);
    assert_eq!(Big::from(2.0).sqrt().to_f64(), std::f64::consts::SQRT_2);
    assert_eq!(Big::parse("-6.62607015E-34").to_f64(), -6.62607015e-34);
    assert_eq!(Big::parse(".1").to_f64(), 0.1);
    assert!(Big::parse("0.1") < Big::from(0.1));
    assert!((digits(1.0 + 1e-10, &Big::one()) - 10.0).abs() < 1e-4);
    assert!((Big::from(1e-300).log10() + 300.0).abs() < 1e-12);
}
