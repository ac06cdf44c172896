//! Least squares in rational numbers, exactly: sums of integers and an elimination without
//! fractions (Bareiss).

use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

/// `mantissa · 2^exponent`.
#[derive(Clone, Debug)]
pub struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    pub fn integer(value: i64) -> Self {
        Dyadic { mantissa: BigInt::from(value), exponent: 0 }
    }

    pub fn power(&self, exponent: usize) -> Self {
        Dyadic { mantissa: self.mantissa.pow(exponent as u32), exponent: self.exponent * exponent as i64 }
    }

    fn at(&self, exponent: i64) -> BigInt {
        &self.mantissa << (self.exponent - exponent) as u64
    }

    fn combined(&self, other: &Self, with: impl Fn(BigInt, BigInt) -> BigInt) -> Self {
        let exponent = self.exponent.min(other.exponent);
        Dyadic { mantissa: with(self.at(exponent), other.at(exponent)), exponent }
    }
}

impl From<f64> for Dyadic {
    fn from(value: f64) -> Self {
        let bits = value.to_bits();
        let stored = ((bits >> 52) & 0x7ff) as i64;
        assert!(stored < 0x7ff, "{value}");
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let (mut mantissa, mut exponent) =
            (if stored == 0 { fraction } else { fraction | 1 << 52 }, stored.max(1) - 1075);
        if mantissa == 0 {
            return Dyadic::integer(0);
        }
        let zeros = mantissa.trailing_zeros();
        (mantissa, exponent) = (mantissa >> zeros, exponent + i64::from(zeros));
        Dyadic { mantissa: BigInt::from(if value < 0.0 { -mantissa } else { mantissa }), exponent }
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;
    fn add(self, other: &Dyadic) -> Dyadic {
        self.combined(other, |a, b| a + b)
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;
    fn sub(self, other: &Dyadic) -> Dyadic {
        self.combined(other, |a, b| a - b)
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;
    fn mul(self, other: &Dyadic) -> Dyadic {
        Dyadic { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }
}

/// `over / under`, `under` > 0.
#[derive(Clone, Debug)]
pub struct Ratio {
    over: Dyadic,
    under: BigInt,
}

impl Ratio {
    fn new(over: Dyadic, under: &BigInt) -> Self {
        match under.sign() {
            Sign::Minus => Ratio { over: &Dyadic::integer(-1) * &over, under: -under },
            _ => Ratio { over, under: under.clone() },
        }
    }

    pub fn times(&self, factor: &Dyadic) -> Self {
        Ratio { over: &self.over * factor, under: self.under.clone() }
    }

    pub fn times_ratio(&self, other: &Ratio) -> Self {
        Ratio { over: &self.over * &other.over, under: &self.under * &other.under }
    }

    pub fn by(&self, divisor: usize) -> Self {
        Ratio { over: self.over.clone(), under: &self.under * BigInt::from(divisor) }
    }

    fn compared(&self, value: &Dyadic) -> Ordering {
        let scaled = Dyadic { mantissa: &value.mantissa * &self.under, exponent: value.exponent };
        (&self.over - &scaled).mantissa.cmp(&BigInt::from(0))
    }

    /// True if it lies in the interval.
    pub fn within(&self, [low, high]: [f64; 2]) -> bool {
        self.compared(&Dyadic::from(low)) != Ordering::Less && self.compared(&Dyadic::from(high)) != Ordering::Greater
    }

    /// True if the square root lies in the interval.
    pub fn root_within(&self, [low, high]: [f64; 2]) -> bool {
        let square = |x: f64| Dyadic::from(x).power(2);
        low >= 0.0 && self.compared(&square(low)) != Ordering::Less && self.compared(&square(high)) != Ordering::Greater
    }
}

/// The solution of a problem of least squares.
pub struct Exact {
    pub coefficients: Vec<Ratio>,
    /// The diagonal of (XᵀΩX)⁻¹.
    pub inverse: Vec<Ratio>,
    pub rss: Ratio,
}

/// Minimises `Σ w (z − Xc)²`, `rows` being those of X.
pub fn least_squares(rows: &[Vec<Dyadic>], heights: &[f64], weights: Option<&[f64]>) -> Exact {
    let (m, n) = (rows.len(), rows[0].len());
    // column by column one power of 2 makes integers
    let least = |list: &mut dyn Iterator<Item = &Dyadic>| list.map(|x| x.exponent).min().expect("a node");
    let powers: Vec<i64> = (0..n).map(|j| least(&mut rows.iter().map(|row| &row[j]))).collect();
    let x: Vec<Vec<BigInt>> = rows.iter().map(|row| row.iter().zip(&powers).map(|(x, &p)| x.at(p)).collect()).collect();
    let list = |values: Vec<Dyadic>| {
        let power = least(&mut values.iter());
        (values.iter().map(|x| x.at(power)).collect::<Vec<BigInt>>(), power)
    };
    let (z, of_z) = list(heights.iter().map(|&z| Dyadic::from(z)).collect());
    let (w, of_w) = list((0..m).map(|k| Dyadic::from(weights.map_or(1.0, |w| w[k]))).collect());
    let sum = |a: &dyn Fn(usize) -> BigInt| (0..m).fold(BigInt::from(0), |sum, k| sum + a(k) * &w[k]);
    let right: Vec<BigInt> = (0..n).map(|j| sum(&|k| &x[k][j] * &z[k])).collect();
    let mut table: Vec<Vec<BigInt>> = (0..n)
        .map(|i| {
            let gram = (0..n).map(|j| sum(&|k| &x[k][i] * &x[k][j]));
            let unit = (0..n).map(|j| BigInt::from(i32::from(i == j)));
            gram.chain([right[i].clone()]).chain(unit).collect()
        })
        .collect();
    let determinant = eliminate(&mut table);
    let solution = |i: usize| &table[i][n];
    // G c = b with G = 2^(w + pᵢ + pⱼ) G′, b = 2^(w + pᵢ + z) b′
    let coefficients =
        (0..n).map(|i| Ratio::new(Dyadic { mantissa: solution(i).clone(), exponent: of_z - powers[i] }, &determinant));
    let inverse = (0..n).map(|i| {
        let mantissa = table[i][n + 1 + i].clone();
        Ratio::new(Dyadic { mantissa, exponent: -of_w - 2 * powers[i] }, &determinant)
    });
    let reached = (0..n).fold(BigInt::from(0), |sum, i| sum + solution(i) * &right[i]);
    let left = sum(&|k| &z[k] * &z[k]) * &determinant - reached;
    Exact {
        coefficients: coefficients.collect(),
        inverse: inverse.collect(),
        rss: Ratio::new(Dyadic { mantissa: left, exponent: of_w + 2 * of_z }, &determinant),
    }
}

/// Turns the first n columns into D times the identity, without fractions, and returns D.
fn eliminate(table: &mut [Vec<BigInt>]) -> BigInt {
    let n = table.len();
    let mut before = BigInt::from(1);
    for k in 0..n {
        let pivot = (k..n).find(|&i| table[i][k].sign() != Sign::NoSign).expect("independent columns");
        if pivot != k {
            table.swap(k, pivot);
            table[k].iter_mut().for_each(|x| *x = -&*x);
        }
        let row = table[k].clone();
        for (i, other) in table.iter_mut().enumerate() {
            if i != k {
                let head = other[k].clone();
                other.iter_mut().zip(&row).for_each(|(x, p)| *x = (&*x * &row[k] - &head * p) / &before);
            }
        }
        before = row[k].clone();
    }
    before
}

#[test]
fn a_line_through_three_nodes() {
    let rows: Vec<Vec<Dyadic>> = [0.0, 0.5, 2.0].iter().map(|&x| vec![Dyadic::integer(1), Dyadic::from(x)]).collect();
    let exact = least_squares(&rows, &[1.0, 2.0, 3.0], Some(&[1.0, 2.0, 1.0]));
    // Σw = 4, Σwx = 3, Σwx² = 4.5, Σwz = 8, Σwxz = 8: c = (12, 8)/9, G⁻¹ = ((4.5, −3), (−3, 4))/9
    let is = |ratio: &Ratio, over: f64, under: f64| ratio.times(&Dyadic::from(under)).within([over, over]);
    assert!(is(&exact.coefficients[0], 12.0, 9.0) && is(&exact.coefficients[1], 8.0, 9.0), "{:?}", exact.coefficients);
    assert!(is(&exact.inverse[0], 4.5, 9.0) && is(&exact.inverse[1], 4.0, 9.0), "{:?}", exact.inverse);
    // Σwz² − bᵀc = 18 − (96 + 64)/9
    assert!(is(&exact.rss, 2.0, 9.0), "{:?}", exact.rss);
    assert!(exact.rss.times(&Dyadic::from(18.0)).root_within([2.0, 2.0]));
    assert!(!exact.rss.within([0.2, 0.22]) && exact.rss.within([0.2222, 0.2223]));
}
