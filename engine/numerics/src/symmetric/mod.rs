//! Eigenvalues and eigenvectors of symmetric matrices in double precision.
//!
//! Householder reflections reduce the matrix to tridiagonal form (`reduce`), which is taken apart
//! into halves and put together again (`divide`, Cuppen; Gu and Eisenstat). Errors of eigenvalues
//! are a few roundings of the *largest* one; where small ones have to keep their digits, one-sided
//! Jacobi rotations ([`super::jacobi`]) do.

mod divide;
mod reduce;
mod secular;

use nalgebra::DMatrix;

use super::{dd::exponent_of, dd::ldexp, tridiagonal::ql};

/// The eigenvalues, ascending, with vectors of length 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigen {
    /// Ascending.
    pub values: Vec<f64>,
    /// Column i belongs to eigenvalue i.
    pub vectors: DMatrix<f64>,
}

/// The exponent that scales the largest entry to 1; `None` if an entry is not finite.
fn exponent(a: &DMatrix<f64>) -> Option<i32> {
    let (mut largest, mut finite) = (0.0f64, true);
    for x in a.iter() {
        finite &= x.is_finite();
        largest = largest.max(x.abs());
    }
    finite.then(|| if largest > 0.0 { -exponent_of(largest) } else { 0 })
}

fn scaled(mut a: DMatrix<f64>, exponent: i32) -> DMatrix<f64> {
    a.iter_mut().for_each(|x| *x = ldexp(*x, exponent));
    a
}

/// Eigenvalues and eigenvectors of a symmetric matrix, of which the lower triangle is read; `None`
/// if an entry is not finite or an iteration does not end.
///
/// ```
/// use flankfit_numerics::symmetric::eigen;
/// use nalgebra::DMatrix;
///
/// // [[2, 1], [1, 2]] stretches (1, 1) by 3 and (1, −1) by 1.
/// let found = eigen(DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0])).unwrap();
/// assert!((found.values[0] - 1.0).abs() < 1e-15 && (found.values[1] - 3.0).abs() < 1e-15);
/// assert!((found.vectors[(0, 1)] / found.vectors[(1, 1)] - 1.0).abs() < 1e-15);
/// ```
pub fn eigen(a: DMatrix<f64>) -> Option<Eigen> {
    let exponent = exponent(&a)?;
    let reduced = reduce::reduce(scaled(a, exponent));
    let (values, mut vectors) = divide::eigen(reduced.diagonal.clone(), &reduced.off_diagonal)?;
    reduced.turn(&mut vectors);
    Some(Eigen { values: values.into_iter().map(|x| ldexp(x, -exponent)).collect(), vectors })
}

/// The eigenvalues alone, ascending, at a third of the work.
pub fn eigenvalues(a: DMatrix<f64>) -> Option<Vec<f64>> {
    let exponent = exponent(&a)?;
    let reduced = reduce::reduce(scaled(a, exponent));
    let (mut d, mut e) = (reduced.diagonal, reduced.off_diagonal);
    e.resize(d.len(), 0.0);
    ql(&mut d, &mut e, |_, _, _| ())?;
    d.sort_by(f64::total_cmp);
    Some(d.into_iter().map(|x| ldexp(x, -exponent)).collect())
}

/// The smallest and the largest eigenvalue, to a few roundings of the larger one in size.
///
/// ```
/// use flankfit_numerics::symmetric::extremes;
/// use nalgebra::DMatrix;
///
/// let [low, high] = extremes(DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0])).unwrap();
/// assert!((low - 1.0).abs() < 1e-15 && (high - 3.0).abs() < 1e-15);
/// ```
pub fn extremes(a: DMatrix<f64>) -> Option<[f64; 2]> {
    let exponent = exponent(&a)?;
    let reduced = reduce::reduce(scaled(a, exponent));
    Some(ends(&reduced.diagonal, &reduced.off_diagonal).map(|x| ldexp(x, -exponent)))
}

/// Both ends of the spectrum of a tridiagonal matrix: bisection on whether `T − xI` has pivots that
/// are all positive, and `xI − T`. The two go side by side, since each waits for divisions.
fn ends(diagonal: &[f64], off_diagonal: &[f64]) -> [f64; 2] {
    let n = diagonal.len();
    let off = |i: usize| off_diagonal.get(i).map_or(0.0, |b| b.abs());
    let reach = |i: usize| off(i) + if i > 0 { off(i - 1) } else { 0.0 };
    let least = (0..n).map(|i| diagonal[i] - reach(i)).fold(f64::INFINITY, f64::min);
    let most = (0..n).map(|i| diagonal[i] + reach(i)).fold(f64::NEG_INFINITY, f64::max);
    let inner = |better: fn(f64, f64) -> f64| diagonal.iter().copied().reduce(better).unwrap_or(0.0);
    let (mut low, mut high) = ([least, inner(f64::min)], [inner(f64::max), most]);
    let width = 2.0 * f64::EPSILON * least.abs().max(most.abs());
    while low[1] - low[0] > width || high[1] - high[0] > width {
        let (x, y) = (0.5 * (low[0] + low[1]), 0.5 * (high[0] + high[1]));
        let (mut below, mut above) = (diagonal[0] - x, y - diagonal[0]);
        let (mut all_below, mut all_above) = (below > 0.0, above > 0.0);
        for (d, b) in diagonal[1..].iter().zip(off_diagonal) {
            below = d - x - b * (b / below);
            above = y - d - b * (b / above);
            all_below &= below > 0.0;
            all_above &= above > 0.0;
            if !all_below && !all_above {
                break;
            }
        }
        low[usize::from(!all_below)] = x;
        high[usize::from(all_above)] = y;
        if x == low[0] && x == low[1] || y == high[0] && y == high[1] {
            break;
        }
    }
    [low[0], high[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(a: &DMatrix<f64>) {
        let n = a.nrows();
        let size = a.amax().max(f64::MIN_POSITIVE);
        let Eigen { values, vectors } = eigen(a.clone()).unwrap();
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1]));
        let bound = 4.0 * (n as f64 + 4.0) * f64::EPSILON;
        let gram = vectors.transpose() * &vectors;
        assert!((gram - DMatrix::identity(n, n)).amax() < bound, "not orthogonal: {n}");
        let moved = a * &vectors;
        let stretched = DMatrix::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
        assert!((moved - stretched).amax() < bound * size * (n as f64).sqrt(), "no eigenvectors: {n}");
        let alone = eigenvalues(a.clone()).unwrap();
        for (x, y) in alone.iter().zip(&values) {
            assert!((x - y).abs() < bound * size * n as f64, "{n}: {x} {y}");
        }
        let [low, high] = extremes(a.clone()).unwrap();
        assert!((low - values[0]).abs() < bound * size * n as f64, "{n}: {low} {}", values[0]);
        assert!((high - values[n - 1]).abs() < bound * size * n as f64, "{n}: {high} {}", values[n - 1]);
    }

    fn random(n: usize, mut state: u64) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let x = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
                (a[(i, j)], a[(j, i)]) = (x, x);
            }
        }
        a
    }

    #[test]
    fn of_any_size() {
        for n in [1, 2, 3, 7, 24, 25, 26, 51, 100, 137] {
            check(&random(n, n as u64));
        }
    }

    #[test]
    fn with_equal_and_with_graded_eigenvalues() {
        for n in [40, 90] {
            check(&DMatrix::identity(n, n));
            check(&DMatrix::from_element(n, n, 1.0));
            check(&DMatrix::zeros(n, n));
            // pairs of equal ones: a product with itself, and powers of 10
            let half = random(n / 10, 5);
            check(&half.kronecker(&random(10, 6)));
            let both = half.kronecker(&DMatrix::identity(10, 10))
                + DMatrix::identity(n / 10, n / 10).kronecker(&random(10, 6));
            check(&both);
            let graded = DMatrix::from_fn(n, n, |i, j| random(n, 9)[(i, j)] * 10f64.powi(-((i + j) as i32) / 6));
            check(&graded);
            check(&(random(n, 3) * 1e-200));
            check(&(random(n, 3) * 1e200));
        }
    }

    #[test]
    fn of_a_second_difference() {
        // 2 on the diagonal, −1 next to it: 2 − 2 cos(kπ/(n+1)), vectors sin
        let n = 130;
        let a = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        check(&a);
        for (k, value) in eigen(a).unwrap().values.iter().enumerate() {
            let truth = 2.0 - 2.0 * ((k + 1) as f64 * std::f64::consts::PI / (n as f64 + 1.0)).cos();
            assert!((value - truth).abs() < 1e-14, "{k}: {value} {truth}");
        }
    }

    #[test]
    fn nonfinite_matrices_have_no_eigenvalues() {
        assert_eq!(eigen(DMatrix::from_element(2, 2, f64::NAN)), None);
        assert_eq!(eigenvalues(DMatrix::from_element(2, 2, f64::INFINITY)), None);
    }
}
