//! Householder's reduction of a symmetric matrix to tridiagonal form.
//!
//! The matrix is read once for each reflection: a column takes the update of the reflection before
//! (of rank 2) and gives its part of the product with the present one on the same way.

use nalgebra::DMatrix;

use crate::{cancel, with_fma};

/// Reflections that are applied together.
const TOGETHER: usize = 32;

/// `A = H₀ H₁ … T … H₁ H₀`, `Hₖ = I − τₖ vₖvₖᵀ`.
pub(super) struct Reduced {
    pub diagonal: Vec<f64>,
    pub off_diagonal: Vec<f64>,
    /// Column k holds vₖ below its diagonal.
    reflections: DMatrix<f64>,
    tau: Vec<f64>,
}

with_fma! {
    /// Computes `a −= v wⱼ + w vⱼ`, then `p += a xⱼ`; returns `aᵀx`.
    fn take(a: &mut [f64], v: &[f64], w: &[f64], ends: [f64; 2], x: &[f64], own: f64, p: &mut [f64]) -> f64 {
        let [vj, wj] = ends;
        let ((a4, a), (v4, v), (w4, w)) = (a.as_chunks_mut::<4>(), v.as_chunks::<4>(), w.as_chunks::<4>());
        let ((x4, x), (p4, p)) = (x.as_chunks::<4>(), p.as_chunks_mut::<4>());
        let mut sums = [0.0f64; 4];
        for ((((a, v), w), x), p) in a4.iter_mut().zip(v4).zip(w4).zip(x4).zip(p4) {
            for k in 0..4 {
                a[k] = w[k].mul_add(-vj, v[k].mul_add(-wj, a[k]));
                p[k] = a[k].mul_add(own, p[k]);
                sums[k] = a[k].mul_add(x[k], sums[k]);
            }
        }
        let mut rest = 0.0f64;
        for ((((a, v), w), x), p) in a.iter_mut().zip(v).zip(w).zip(x).zip(p) {
            *a = w.mul_add(-vj, v.mul_add(-wj, *a));
            *p = a.mul_add(own, *p);
            rest = a.mul_add(*x, rest);
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
    }
}

/// Reduces a symmetric matrix, of which the lower triangle is read; entries of about 1.
pub(super) fn reduce(mut a: DMatrix<f64>) -> Reduced {
    let n = a.nrows();
    let (mut diagonal, mut off_diagonal, mut tau) = (vec![0.0; n], vec![0.0; n.saturating_sub(1)], vec![0.0; n]);
    // the update that is not yet made
    let (mut v, mut w) = (vec![0.0; n], vec![0.0; n]);
    let mut x = vec![0.0; n];
    let mut p = vec![0.0; n];
    for k in 0..n {
        cancel::every(2 * n * n, k);
        let entries = a.as_mut_slice();
        let column = &mut entries[k * n..(k + 1) * n];
        for i in k..n {
            column[i] -= v[i] * w[k] + w[i] * v[k];
        }
        diagonal[k] = column[k];
        if k + 1 == n {
            break;
        }
        let square: f64 = column[k + 2..].iter().map(|x| x * x).sum();
        let head = column[k + 1];
        x[..=k].fill(0.0);
        if square > 0.0 {
            let length = -head.hypot(square.sqrt()).copysign(head);
            tau[k] = (length - head) / length;
            let inverse = 1.0 / (head - length);
            column[k + 2..].iter_mut().for_each(|x| *x *= inverse);
            column[k + 1] = 1.0;
            off_diagonal[k] = length;
        } else {
            off_diagonal[k] = head;
            column[k + 1] = 1.0;
        }
        x[k + 1..].copy_from_slice(&column[k + 1..]);
        p.fill(0.0);
        for j in k + 1..n {
            let column = &mut entries[j * n..(j + 1) * n];
            column[j] -= 2.0 * v[j] * w[j];
            let (ends, own) = ([v[j], w[j]], x[j]);
            let below = take(&mut column[j + 1..], &v[j + 1..], &w[j + 1..], ends, &x[j + 1..], own, &mut p[j + 1..]);
            p[j] += column[j] * own + below;
        }
        let inner: f64 = p[k + 1..].iter().zip(&x[k + 1..]).map(|(p, x)| p * x).sum();
        let share = 0.5 * tau[k] * tau[k] * inner;
        for i in k + 1..n {
            (v[i], w[i]) = (x[i], tau[k] * p[i] - share * x[i]);
        }
        (v[k], w[k]) = (0.0, 0.0);
    }
    Reduced { diagonal, off_diagonal, reflections: a, tau }
}

impl Reduced {
    /// Turns eigenvectors of the tridiagonal matrix into those of the matrix it was made from:
    /// reflections by the dozen, `I − V T Vᵀ`.
    pub(super) fn turn(&self, vectors: &mut DMatrix<f64>) {
        let n = self.diagonal.len();
        let count = n.saturating_sub(1);
        for first in (0..count).step_by(TOGETHER).rev() {
            cancel::checkpoint();
            let width = TOGETHER.min(count - first);
            let rows = n - first - 1;
            let v =
                DMatrix::from_fn(
                    rows,
                    width,
                    |i, j| if i < j { 0.0 } else { self.reflections[(first + 1 + i, first + j)] },
                );
            let gram = v.transpose() * &v;
            let mut t = DMatrix::<f64>::zeros(width, width);
            for j in 0..width {
                let tau = self.tau[first + j];
                t[(j, j)] = tau;
                for i in 0..j {
                    t[(i, j)] = -tau * (i..j).map(|l| t[(i, l)] * gram[(l, j)]).sum::<f64>();
                }
            }
            let mut below = vectors.rows_mut(first + 1, rows);
            let along = t * (v.transpose() * &below);
            below.gemm(-1.0, &v, &along, 1.0);
        }
    }
}
