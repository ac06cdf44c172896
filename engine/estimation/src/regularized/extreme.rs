//! The largest eigenvalue of `M diag(d) Mᵀ` with its vector, by Lanczos' iteration.

use nalgebra::{DMatrix, DVector};

use flankfit_numerics::{
    matvec::{add, dot, times, transposed_times},
    root::boundary,
};

/// Steps of the iteration at most, and the residual at which it ends.
const STEPS: usize = 60;
const SETTLED: f64 = 1e-13;
const INVERSE_STEPS: usize = 3;

/// The largest eigenvalue of `M diag(d) Mᵀ`, d > 0, with `Mᵀx` for its eigenvector x of length 1.
///
/// Lanczos' iteration, every vector made orthogonal to all before it; at most 60 steps, or as many
/// as there are rows.
pub(super) fn largest(matrix: &DMatrix<f64>, d: &DVector<f64>) -> (f64, DVector<f64>) {
    let n = matrix.nrows();
    let scale = matrix.amax();
    if !(scale > 0.0) || !scale.is_finite() {
        return (0.0, DVector::zeros(matrix.ncols()));
    }
    let apply = |x: &DVector<f64>| matrix * matrix.tr_mul(x).component_mul(d);
    // a start that no symmetry of the problem can make orthogonal to the eigenvector sought
    let mut x = DVector::from_fn(n, |i, _| 1.0 + (1.7 * i as f64 + 0.3).sin());
    x /= x.norm();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let (mut diagonal, mut off_diagonal): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut value, mut ritz) = (0.0, vec![1.0]);
    for step in 0..STEPS.min(n) {
        let mut next = apply(&x);
        let own = next.dot(&x);
        diagonal.push(own);
        basis.push(x.clone());
        for _ in 0..2 {
            for known in &basis {
                let share = next.dot(known);
                next.axpy(-share, known, 1.0);
            }
        }
        let length = next.norm();
        (value, ritz) = top(&diagonal, &off_diagonal);
        if length * ritz[step].abs() <= SETTLED * value.abs() || length == 0.0 {
            break;
        }
        off_diagonal.push(length);
        x = next / length;
    }
    let mut vector = DVector::zeros(n);
    for (share, known) in ritz.iter().zip(&basis) {
        vector.axpy(*share, known, 1.0);
    }
    (value, matrix.tr_mul(&vector))
}

/// A matrix of blocks: the columns of each, counted over the whole, and its entries.
pub(super) type Blocks<'a> = Vec<(&'a [usize], &'a DMatrix<f64>)>;

/// Steps between two looks at the small eigenproblem.
const STRIDE: usize = 3;

/// The same for a matrix of blocks.
pub(super) fn largest_of_blocks(blocks: &Blocks, d: &[f64]) -> (f64, Vec<f64>) {
    let rows: usize = blocks.iter().map(|(_, matrix)| matrix.nrows()).sum();
    let mut image = vec![0.0; d.len()];
    let down = |x: &[f64], image: &mut [f64]| {
        let mut from = 0;
        for (members, matrix) in blocks {
            let mut inner = vec![0.0; matrix.ncols()];
            transposed_times(matrix, &x[from..from + matrix.nrows()], &mut inner);
            members.iter().zip(inner).for_each(|(&i, y)| image[i] = y);
            from += matrix.nrows();
        }
    };
    let up = |image: &[f64], x: &mut [f64]| {
        let mut from = 0;
        for (members, matrix) in blocks {
            let inner: Vec<f64> = members.iter().map(|&i| image[i] * d[i]).collect();
            times(matrix, &inner, &mut x[from..from + matrix.nrows()]);
            from += matrix.nrows();
        }
    };
    let mut x: Vec<f64> = (0..rows).map(|i| 1.0 + (1.7 * i as f64 + 0.3).sin()).collect();
    scale(&mut x);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut diagonal, mut off_diagonal): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut value, mut ritz) = (0.0, vec![1.0]);
    let most = STEPS.min(rows);
    for step in 0..most {
        down(&x, &mut image);
        let mut next = vec![0.0; rows];
        up(&image, &mut next);
        diagonal.push(dot(&next, &x));
        basis.push(x);
        for _ in 0..2 {
            for known in &basis {
                add(-dot(&next, known), known, &mut next);
            }
        }
        let length = scale(&mut next);
        if step % STRIDE == STRIDE - 1 || step + 1 == most || length == 0.0 {
            (value, ritz) = top(&diagonal, &off_diagonal);
            if length * ritz[step].abs() <= SETTLED * value.abs() || length == 0.0 {
                break;
            }
        }
        off_diagonal.push(length);
        x = next;
    }
    let mut vector = vec![0.0; rows];
    for (share, known) in ritz.iter().zip(&basis) {
        add(*share, known, &mut vector);
    }
    down(&vector, &mut image);
    (value, image)
}

/// Scales to length 1, and returns the length before.
fn scale(x: &mut [f64]) -> f64 {
    let length = dot(x, x).sqrt();
    if length > 0.0 {
        x.iter_mut().for_each(|x| *x /= length);
    }
    length
}

/// The largest eigenvalue of a symmetric tridiagonal matrix and its vector of length 1: bisection
/// on whether `xI − T` has pivots all positive, then inverse iteration with the first x that has.
fn top(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, Vec<f64>) {
    let n = diagonal.len();
    let off = |i: usize| off_diagonal.get(i).map_or(0.0, |b| b.abs());
    let reach = (0..n).map(|i| diagonal[i] + off(i) + if i > 0 { off(i - 1) } else { 0.0 });
    let mut above = reach.fold(f64::NEG_INFINITY, f64::max);
    above += above.abs() * 1e-15 + f64::MIN_POSITIVE;
    let below = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut pivots = vec![0.0; n];
    let positive = |x: f64, pivots: &mut Vec<f64>| {
        let mut last = 1.0;
        for i in 0..n {
            let carried = if i > 0 { off_diagonal[i - 1] * (off_diagonal[i - 1] / last) } else { 0.0 };
            last = x - diagonal[i] - carried;
            pivots[i] = last;
            if !(last > 0.0) {
                return false;
            }
        }
        true
    };
    let [_, above] = boundary([below, above], 0.0, |x| !positive(x, &mut pivots));
    let mut vector = vec![1.0; n];
    if positive(above, &mut pivots) {
        for _ in 0..INVERSE_STEPS {
            for i in 1..n {
                vector[i] += off_diagonal[i - 1] / pivots[i - 1] * vector[i - 1];
            }
            for i in (0..n).rev() {
                vector[i] = (vector[i] + if i + 1 < n { off_diagonal[i] * vector[i + 1] } else { 0.0 }) / pivots[i];
            }
            let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= length);
        }
    }
    (above, vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_tridiagonal_matrix() {
        // 2 on the diagonal, 1 next to it: 2 + 2 cos(π/(n+1)), vector sin(πi/(n+1))
        let n = 7;
        let (value, vector) = top(&[2.0; 7], &[1.0; 6]);
        let angle = std::f64::consts::PI / (n as f64 + 1.0);
        assert!((value - 2.0 - 2.0 * angle.cos()).abs() < 1e-14);
        for (i, x) in vector.iter().enumerate() {
            assert!((x - ((i as f64 + 1.0) * angle).sin() * 0.5).abs() < 1e-13, "{vector:?}");
        }
        assert_eq!(top(&[3.0], &[]).1, [1.0]);
    }

    #[test]
    fn of_blocks() {
        let blocks = [0, 1].map(|k| DMatrix::from_fn(20, 20, |i, j| ((3 * i + 5 * j + k) as f64).cos()));
        let members: [Vec<usize>; 2] = [(0..20).collect(), (20..40).collect()];
        let whole =
            DMatrix::from_fn(40, 40, |i, j| if i / 20 == j / 20 { blocks[i / 20][(i % 20, j % 20)] } else { 0.0 });
        for k in 0..2 {
            // the top comes from the one block, then from the other
            let d = DVector::from_fn(40, |i, _| if i / 20 == k % 2 { 3.0 + i as f64 } else { 1.0 });
            let both = members.iter().zip(&blocks).map(|(m, b)| (&m[..], b)).collect();
            let (value, image) = largest_of_blocks(&both, d.as_slice());
            let (truth, _) = largest(&whole, &d);
            assert!((value / truth - 1.0).abs() < 1e-12, "{k}: {value} {truth}");
            let rayleigh: f64 = (0..40).map(|i| d[i] * image[i] * image[i]).sum();
            assert!((rayleigh / truth - 1.0).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn the_largest_eigenvalue_and_its_vector() {
        let matrix = DMatrix::from_fn(9, 9, |i, j| ((3 * i + 5 * j) as f64).cos());
        let d = DVector::from_fn(9, |i, _| 10f64.powi(i as i32 - 4));
        let full = &matrix * DMatrix::from_diagonal(&d) * matrix.transpose();
        let eigen = full.clone().symmetric_eigen();
        let (value, image) = largest(&matrix, &d);
        assert!((value / eigen.eigenvalues.max() - 1.0).abs() < 1e-11);
        let rayleigh: f64 = (0..9).map(|i| d[i] * image[i] * image[i]).sum();
        assert!((rayleigh / value - 1.0).abs() < 1e-11);
        assert_eq!(largest(&DMatrix::zeros(3, 3), &DVector::from_element(3, 1.0)).0, 0.0);
    }
}
