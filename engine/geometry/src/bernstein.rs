//! Chebyshev polynomials in the basis of Bernstein over an interval, to twice the digits of double.

use nalgebra::DMatrix;

use super::Mapping;
use flankfit_numerics::Dd;

/// Column `j` holds the Bernstein coefficients of degree `degree` over `[low, high]` of `Tⱼ`, the
/// Chebyshev polynomial of the abscissa mapped by `mapping`.
///
/// By the three-term recurrence: a product with a linear function raises the degree by one, and
/// needs the values of that function at the ends only.
pub fn of_chebyshev(mapping: Mapping, [low, high]: [f64; 2], degree: usize) -> DMatrix<Dd> {
    let ends: [Dd; 2] = [mapping.map(low), mapping.map(high)];
    let mut columns = vec![vec![Dd::ONE]];
    if degree > 0 {
        columns.push(ends.to_vec());
    }
    for j in 2..=degree {
        let twice = times(&columns[j - 1], ends.map(|end| end + end));
        let before = elevated(&columns[j - 2], j);
        columns.push(twice.iter().zip(&before).map(|(&a, &b)| a - b).collect());
    }
    let columns: Vec<_> = columns.iter().map(|column| elevated(column, degree)).collect();
    DMatrix::from_fn(degree + 1, degree + 1, |i, j| columns[j][i])
}

/// The product with the linear function that has these values at the ends.
fn times(a: &[Dd], ends: [Dd; 2]) -> Vec<Dd> {
    let raised = a.len() as f64;
    (0..=a.len())
        .map(|i| {
            let left = if i < a.len() { ends[0] * a[i] * (raised - i as f64) } else { Dd::ZERO };
            let right = if i > 0 { ends[1] * a[i - 1] * i as f64 } else { Dd::ZERO };
            (left + right) / raised
        })
        .collect()
}

/// The same polynomial, of degree `degree`.
fn elevated(a: &[Dd], degree: usize) -> Vec<Dd> {
    (a.len()..=degree).fold(a.to_vec(), |a, _| times(&a, [Dd::ONE; 2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `T₁₂` over its own interval has the Bernstein coefficients (−1)ⁿ⁻ⁱ C(2n, 2i) / C(n, i).
    #[test]
    fn coefficients_of_the_whole_interval_are_known() {
        let binomial = |n: u32, k: u32| (1..=k).fold(1.0, |c, i| c * f64::from(n + 1 - i) / f64::from(i));
        let found = of_chebyshev(Mapping::over(-1.0, 1.0), [-1.0, 1.0], 12);
        for i in 0..=12 {
            let sign = if (12 - i) % 2 == 0 { 1.0 } else { -1.0 };
            let expected = sign * binomial(24, 2 * i) / binomial(12, i);
            let error = found[(i as usize, 12)].to_f64() - expected;
            assert!(error.abs() < 1e-14 * expected.abs(), "{i}: {error}");
        }
    }

    /// De Casteljau's scheme on part of the interval against cos(j arccos t).
    #[test]
    fn values_are_those_of_the_cosine() {
        let mapping = Mapping::over(30.0, 34.0);
        let (low, high) = (30.5, 31.25);
        let found = of_chebyshev(mapping, [low, high], 9);
        for s in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let angle = mapping.map::<f64>(low + s * (high - low)).acos();
            for j in 0..=9 {
                let mut row: Vec<f64> = found.column(j).iter().map(|c| c.to_f64()).collect();
                while row.len() > 1 {
                    row = row.windows(2).map(|pair| (1.0 - s) * pair[0] + s * pair[1]).collect();
                }
                assert!((row[0] - (j as f64 * angle).cos()).abs() < 1e-13, "{s} {j}");
            }
        }
    }
}
