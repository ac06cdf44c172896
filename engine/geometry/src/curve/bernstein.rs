//! Polynomials in the basis of Bernstein, by their coefficients: products and halves.

/// The product of two polynomials over one interval; degrees add up.
pub(super) fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let (p, q) = (a.len() - 1, b.len() - 1);
    let (left, right, both) = (binomials(p), binomials(q), binomials(p + q));
    let mut sum = vec![0.0; p + q + 1];
    for i in 0..=p {
        for j in 0..=q {
            sum[i + j] += left[i] * a[i] * (right[j] * b[j]);
        }
    }
    sum.iter_mut().zip(both).for_each(|(s, c)| *s /= c);
    sum
}

/// The same polynomial, of one degree more.
pub(super) fn elevated(a: &[f64]) -> Vec<f64> {
    product(a, &[1.0, 1.0])
}

/// The coefficients over the left and the right half of the interval (de Casteljau).
pub(super) fn halves(a: &[f64]) -> [Vec<f64>; 2] {
    let n = a.len();
    let mut row = a.to_vec();
    let mut left = Vec::with_capacity(n);
    for k in 0..n {
        left.push(row[0]);
        for i in 0..n - 1 - k {
            row[i] = 0.5 * (row[i] + row[i + 1]);
        }
    }
    // what remains of each row is its last entry
    [left, row]
}

fn binomials(n: usize) -> Vec<f64> {
    let mut row = vec![1.0; n + 1];
    for k in 1..=n {
        row[k] = row[k - 1] * (n + 1 - k) as f64 / k as f64;
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(a: &[f64], t: f64) -> f64 {
        let n = a.len() - 1;
        let term = |(i, a): (usize, &f64)| a * binomials(n)[i] * t.powi(i as i32) * (1.0 - t).powi((n - i) as i32);
        a.iter().enumerate().map(term).sum()
    }

    #[test]
    fn products_and_halves() {
        let (a, b) = ([1.0, -2.0, 0.5, 3.0], [2.0, 1.0, -1.0]);
        let [left, right] = halves(&a);
        for t in [0.0, 0.3, 0.8, 1.0] {
            assert!((value(&product(&a, &b), t) - value(&a, t) * value(&b, t)).abs() < 1e-14);
            assert!((value(&elevated(&a), t) - value(&a, t)).abs() < 1e-15);
            assert!((value(&left, t) - value(&a, 0.5 * t)).abs() < 1e-15);
            assert!((value(&right, t) - value(&a, 0.5 + 0.5 * t)).abs() < 1e-15);
        }
    }
}
