//! Dense linear algebra in the oracle's numbers, rows in vectors: normal equations by elimination,
//! eigenvalues by Jacobi.

use super::big::Big;

pub type Rows = Vec<Vec<Big>>;

pub fn rows(x: &[Vec<f64>]) -> Rows {
    x.iter().map(|row| row.iter().map(|v| Big::from(*v)).collect()).collect()
}

pub fn vector(y: &[f64]) -> Vec<Big> {
    y.iter().map(|v| Big::from(*v)).collect()
}

pub fn doubles(values: &[Big]) -> Vec<f64> {
    values.iter().map(Big::to_f64).collect()
}

pub fn dot(a: &[Big], b: &[Big]) -> Big {
    a.iter().zip(b).fold(Big::zero(), |sum, (p, q)| &sum + &(p * q))
}

pub fn column(x: &Rows, j: usize) -> Vec<Big> {
    x.iter().map(|row| row[j].clone()).collect()
}

pub fn times(x: &Rows, a: &[Big]) -> Vec<Big> {
    x.iter().map(|row| dot(row, a)).collect()
}

/// XᵀX.
pub fn gram(x: &Rows) -> Rows {
    let columns: Vec<Vec<Big>> = (0..x[0].len()).map(|j| column(x, j)).collect();
    columns.iter().map(|p| columns.iter().map(|q| dot(p, q)).collect()).collect()
}

/// The inverse, by Gauss–Jordan with partial pivoting.
pub fn inverse(a: &Rows) -> Rows {
    let n = a.len();
    let mut work: Rows = a.clone();
    for (i, row) in work.iter_mut().enumerate() {
        row.extend((0..n).map(|j| if i == j { Big::one() } else { Big::zero() }));
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|p, q| work[*p][k].abs().partial_cmp(&work[*q][k].abs()).expect("ordered"));
        work.swap(k, pivot.expect("a row"));
        let head = work[k][k].clone();
        let pivot: Vec<Big> = work[k].iter().map(|value| value / &head).collect();
        for (i, row) in work.iter_mut().enumerate() {
            let factor = row[k].clone();
            if i != k && !factor.is_zero() {
                row.iter_mut().zip(&pivot).for_each(|(value, p)| *value = &*value - &(&factor * p));
            }
        }
        work[k] = pivot;
    }
    work.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// A least-squares fit through the normal equations.
pub struct LeastSquares {
    pub coefficients: Vec<Big>,
    /// (XᵀX)⁻¹.
    pub covariance: Rows,
    pub residuals: Vec<Big>,
    pub rss: Big,
}

pub fn least_squares(x: &Rows, y: &[Big]) -> LeastSquares {
    let covariance = inverse(&gram(x));
    let moments: Vec<Big> = (0..x[0].len()).map(|j| dot(&column(x, j), y)).collect();
    let coefficients = times(&covariance, &moments);
    let residuals: Vec<Big> = times(x, &coefficients).iter().zip(y).map(|(f, y)| y - f).collect();
    let rss = dot(&residuals, &residuals);
    LeastSquares { coefficients, covariance, residuals, rss }
}

/// Eigenvalues ascending, and the eigenvector of each, by cyclic two-sided Jacobi.
pub fn eigen(a: &Rows) -> (Vec<Big>, Vec<Vec<Big>>) {
    let n = a.len();
    let mut a = a.clone();
    // Remainder of an exact 0 after elimination and rounding.
    let floor = a.iter().enumerate().map(|(i, row)| row[i].log10()).fold(f64::NEG_INFINITY, f64::max) - 180.0;
    let mut v: Rows = (0..n).map(|i| (0..n).map(|j| if i == j { Big::one() } else { Big::zero() }).collect()).collect();
    for _ in 0..60 {
        let mut still = true;
        for p in 0..n {
            for q in p + 1..n {
                // Relative to the diagonal, so that small eigenvalues of graded matrices converge
                // too.
                let scale = a[p][p].log10() + a[q][q].log10();
                if a[p][q].log10() < floor || 2.0 * a[p][q].log10() < scale - 200.0 {
                    continue;
                }
                still = false;
                let theta = &(&a[q][q] - &a[p][p]) / &(&Big::from(2.0) * &a[p][q]);
                let root = (&(&theta * &theta) + &Big::one()).sqrt();
                let t = &Big::one() / &(&theta.abs() + &root);
                let t = if theta.is_negative() { -&t } else { t };
                let c = &Big::one() / &(&(&t * &t) + &Big::one()).sqrt();
                let s = &t * &c;
                let turn = |x: &Big, y: &Big| (&(&c * x) - &(&s * y), &(&s * x) + &(&c * y));
                for row in a.iter_mut().chain(v.iter_mut()) {
                    (row[p], row[q]) = turn(&row[p], &row[q]);
                }
                let (upper, lower) = a.split_at_mut(q);
                for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
                    (*x, *y) = turn(x, y);
                }
            }
        }
        if still {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|i, j| a[*i][*i].partial_cmp(&a[*j][*j]).expect("ordered"));
            let values = order.iter().map(|i| a[*i][*i].clone()).collect();
            return (values, order.iter().map(|i| column(&v, *i)).collect());
        }
    }
    panic!("Jacobi did not converge in 60 sweeps");
}

#[test]
fn eigenvalues_of_a_known_matrix() {
    let a = rows(&[vec![2.0, -1.0, 0.0], vec![-1.0, 2.0, -1.0], vec![0.0, -1.0, 2.0]]);
    let (values, vectors) = eigen(&a);
    let root = Big::from(2.0).sqrt();
    for (value, truth) in values.iter().zip([Big::from(2.0) - root.clone(), Big::from(2.0), Big::from(2.0) + root]) {
        assert!((value - &truth).log10() < -150.0);
    }
    for (value, vector) in values.iter().zip(&vectors) {
        let image = times(&a, vector);
        assert!(image.iter().zip(vector).all(|(p, q)| (p - &(value * q)).log10() < -95.0));
    }
}
