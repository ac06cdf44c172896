//! The pair (W, L) of working matrix and penalty, decomposed together: `W Z = U`, `‖L zᵢ‖² = δᵢ`.
//!
//! In the directions zᵢ both quadratic forms are diagonal, so `min ‖Wc − z‖² + λ‖Lc‖²` is the
//! filter `fᵢ = 1/(1 + λδᵢ)` on `aᵢ = uᵢᵀz` (the generalised singular value decomposition of Van
//! Loan). It is taken from the orthogonal factor of the two stacked, `[R; τL] = Q R_K`, `R R_K⁻¹ =
//! U C Vᵀ`, `Z = R_K⁻¹ V C⁻¹`: neither WᵀW nor LᵀL is formed and neither R nor L is inverted, so a
//! singular R and a penalty with a null space are no special cases. All of it in double-double: δ
//! spans the fourth or sixth power of the number of functions.

use nalgebra::DMatrix;

use super::penalty::triangular;
use flankfit_numerics::{
    Dd, Real,
    columns::axpy,
    lanes::{Ddx4, LANES, Lanes, lanes_for},
    svd_dd, triangular as solve,
};

/// Condition of the stacked factor from which on the penalised problem has no unique solution
/// within the arithmetic.
const MOST_CONDITION: f64 = 1e22;
/// A direction in which the penalty is this small against the matrix, times what rounding may have
/// put there, has none.
const NULL: f64 = 4.0;

/// Reason why there is no decomposition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PairFault {
    /// Matrix and penalty leave the same combination of coefficients free.
    Undetermined,
    NotConverged,
}

/// Directions by ascending 1/δ: first those that the nodes do not see, last those without penalty.
#[derive(Debug)]
pub(super) struct Pair {
    /// Column i is zᵢ, in working coefficients.
    pub z: DMatrix<Dd>,
    /// Z⁻¹.
    pub inverse: DMatrix<Dd>,
    /// uᵢ in Q's coordinates; 0 for a direction that the nodes do not see.
    pub u: DMatrix<Dd>,
    /// δᵢ; 0 without penalty.
    pub delta: Vec<f64>,
    /// Directions that the nodes do not see.
    pub silent: usize,
    /// Directions without penalty.
    pub free: usize,
}

impl Pair {
    /// Decomposes upper triangular `r` with `l`; `rank` is that of r.
    pub(super) fn new(r: &DMatrix<Dd>, l: &DMatrix<Dd>, rank: usize) -> Result<Self, PairFault> {
        let n = r.ncols();
        let size = |matrix: &DMatrix<Dd>| matrix.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
        let (of_r, of_l) = (size(r), size(l));
        // a power of 2, so that it rounds nothing
        let tau = (of_r / of_l).log2().round().clamp(-900.0, 900.0).exp2();
        let l = if l.nrows() > n { triangular(l.clone()) } else { l.clone() };
        let mut stacked = DMatrix::from_element(n + l.nrows(), n, Dd::ZERO);
        stacked.rows_mut(0, n).copy_from(r);
        for (mut to, from) in stacked.column_iter_mut().zip(l.column_iter()) {
            to.iter_mut().skip(n).zip(from.iter()).for_each(|(to, x)| *to = x.scale_pow2(tau));
        }
        let k = triangular(stacked);
        let smallest = (0..n).map(|i| k[(i, i)].to_f64().abs()).fold(f64::INFINITY, f64::min);
        if smallest.is_nan() || smallest <= size(&k) / MOST_CONDITION {
            return Err(PairFault::Undetermined);
        }
        let k_inverse = solve::inverse_upper(&k);
        let condition = size(&k) * size(&k_inverse);
        if condition.is_nan() || condition > MOST_CONDITION {
            return Err(PairFault::Undetermined);
        }
        let seen = solve::multiply_upper(r, &k_inverse);
        let svd = svd_dd(&seen).ok_or(PairFault::NotConverged)?;
        let v = separated(&product(&l, &k_inverse), svd.v, &svd.sigma).ok_or(PairFault::NotConverged)?;
        let rounding = NULL * (n as f64) * Dd::EPSILON * condition;
        let silent = n - rank;
        let mut z = product(&k_inverse, &v);
        let mut inverse = product(&v.transpose(), &k);
        let mut u = product(&seen, &v);
        let penalty = product(&l, &z);
        let mut delta = vec![0.0; n];
        for i in 0..n {
            let length =
                penalty.column(i).iter().fold(Dd::ZERO, |sum, &x| sum + x.scale_pow2(tau) * x.scale_pow2(tau)).sqrt();
            let felt = length.to_f64() > rounding;
            let c = u.column(i).iter().fold(Dd::ZERO, |sum, &x| sum + x * x).sqrt();
            if i < silent || c <= Dd::ZERO {
                u.column_mut(i).fill(Dd::ZERO);
                delta[i] = (length.to_f64() / tau).powi(2);
                continue;
            }
            let shrunk = Dd::ONE / c;
            z.column_mut(i).iter_mut().for_each(|x| *x *= shrunk);
            u.column_mut(i).iter_mut().for_each(|x| *x *= shrunk);
            inverse.row_mut(i).iter_mut().for_each(|x| *x *= c);
            delta[i] = if felt { ((length / c).to_f64() / tau).powi(2) } else { 0.0 };
        }
        let free = delta.iter().rev().take_while(|d| **d == 0.0).count();
        Ok(Pair { z, inverse, u, delta, silent, free })
    }

    /// Turns the directions without penalty so that the last one runs along `constant` (working
    /// coefficients), which lies among them; false where it does not.
    pub(super) fn turn_last_to(&mut self, constant: &[Dd]) -> bool {
        let n = self.delta.len();
        let first = n - self.free;
        // its share in every direction: Z⁻¹ applied to it
        let mut share: Vec<Dd> = (first..n)
            .map(|i| self.inverse.row(i).iter().zip(constant).fold(Dd::ZERO, |sum, (&x, &c)| sum + x * c))
            .collect();
        let length = share.iter().fold(Dd::ZERO, |sum, &x| sum + x * x).sqrt();
        let Some(last) = share.last().copied() else { return false };
        if !(length > Dd::ZERO) {
            return false;
        }
        // the reflection that sends the shares to the last axis: I − 2hhᵀ/hᵀh
        let sign = if last < Dd::ZERO { -Dd::ONE } else { Dd::ONE };
        let end = share.len() - 1;
        share[end] = last + sign * length;
        let square = share.iter().fold(Dd::ZERO, |sum, &x| sum + x * x);
        let twice = (Dd::ONE + Dd::ONE) / square;
        for matrix in [&mut self.z, &mut self.u] {
            for row in 0..n {
                let inner = (0..share.len()).fold(Dd::ZERO, |sum, i| sum + matrix[(row, first + i)] * share[i]);
                (0..share.len()).for_each(|i| matrix[(row, first + i)] -= twice * inner * share[i]);
            }
        }
        for column in 0..n {
            let inner = (0..share.len()).fold(Dd::ZERO, |sum, i| sum + self.inverse[(first + i, column)] * share[i]);
            (0..share.len()).for_each(|i| self.inverse[(first + i, column)] -= twice * inner * share[i]);
        }
        true
    }
}

/// Cosines above this are distinguished by their sines.
const NEAR_ONE: f64 = 0.7;

/// Right singular vectors by ascending cosine `sigma`, those of cosines near 1 turned so that their
/// sines are those of `penalty`: cosines of 1 − 10⁻³⁰ are alike, their sines of 10⁻¹⁵ and 10⁻¹⁸ are
/// not (the second half of the cosine–sine decomposition). None if the iteration does not end.
fn separated(penalty: &DMatrix<Dd>, mut v: DMatrix<Dd>, sigma: &[Dd]) -> Option<DMatrix<Dd>> {
    let n = sigma.len();
    let first = sigma.iter().position(|c| c.to_f64() > NEAR_ONE).unwrap_or(n);
    let block = n - first;
    if block < 2 {
        return Some(v);
    }
    let near = v.columns(first, block).into_owned();
    // no fewer rows than columns
    let image = product(penalty, &near);
    let rows = image.nrows().max(block);
    let padded = DMatrix::from_fn(rows, block, |i, j| if i < image.nrows() { image[(i, j)] } else { Dd::ZERO });
    let turned = product(&near, &svd_dd(&padded)?.v);
    for i in 0..block {
        // sines ascend where cosines descend
        v.column_mut(n - 1 - i).copy_from(&turned.column(i));
    }
    Some(v)
}

/// `A B`.
pub(super) fn product(a: &DMatrix<Dd>, b: &DMatrix<Dd>) -> DMatrix<Dd> {
    let height = lanes_for(a.nrows());
    let mut columns = vec![Ddx4::ZERO; height * a.ncols()];
    for (j, column) in a.column_iter().enumerate() {
        let to = &mut columns[j * height..(j + 1) * height];
        column.iter().enumerate().for_each(|(i, &x)| to[i / LANES].set(i % LANES, x));
    }
    let mut out = DMatrix::from_element(a.nrows(), b.ncols(), Dd::ZERO);
    let mut sum = vec![Ddx4::ZERO; height];
    for (mut to, from) in out.column_iter_mut().zip(b.column_iter()) {
        sum.fill(Ddx4::ZERO);
        for (k, &factor) in from.iter().enumerate().filter(|(_, x)| **x != Dd::ZERO) {
            axpy(factor, &columns[k * height..(k + 1) * height], &mut sum);
        }
        to.iter_mut().enumerate().for_each(|(i, x)| *x = sum[i / LANES].get(i % LANES));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn upper(n: usize) -> DMatrix<Dd> {
        DMatrix::from_fn(n, n, |i, j| match i <= j {
            true => Dd::from(((7 * i + 3 * j) as f64).sin() + if i == j { 3.0 } else { 0.0 }),
            false => Dd::ZERO,
        })
    }

    fn second_differences(n: usize) -> DMatrix<Dd> {
        DMatrix::from_fn(n - 2, n, |i, j| match j.wrapping_sub(i) {
            0 | 2 => Dd::ONE,
            1 => Dd::from(-2.0),
            _ => Dd::ZERO,
        })
    }

    fn largest(matrix: DMatrix<Dd>) -> f64 {
        matrix.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max)
    }

    #[test]
    fn both_forms_are_diagonal() {
        let n = 7;
        let (r, l) = (upper(n), second_differences(n));
        let pair = Pair::new(&r, &l, n).unwrap();
        assert_eq!((pair.silent, pair.free), (0, 2));
        let identity = DMatrix::from_fn(n, n, |i, j| if i == j { Dd::ONE } else { Dd::ZERO });
        assert!(largest(product(&pair.inverse, &pair.z) - &identity) < 1e-27);
        assert!(largest(product(&r, &pair.z) - &pair.u) < 1e-27);
        assert!(largest(product(&pair.u.transpose(), &pair.u) - &identity) < 1e-27);
        let image = product(&l, &pair.z);
        let gram = product(&image.transpose(), &image);
        let delta = DMatrix::from_fn(n, n, |i, j| if i == j { Dd::from(pair.delta[i]) } else { Dd::ZERO });
        assert!(largest(gram - delta) < 1e-13);
        assert!(pair.delta.windows(2).all(|pair| pair[0] >= pair[1]));
    }

    #[test]
    fn a_free_direction_can_be_given_its_course() {
        let n = 6;
        let r = upper(n);
        let mut pair = Pair::new(&r, &second_differences(n), n).unwrap();
        let ones = vec![Dd::ONE; n];
        assert!(pair.turn_last_to(&ones));
        let last = pair.z.column(n - 1);
        assert!(last.iter().all(|&x| (x / last[0] - Dd::ONE).abs().to_f64() < 1e-27));
        assert!(largest(product(&r, &pair.z) - &pair.u) < 1e-27);
        let identity = DMatrix::from_fn(n, n, |i, j| if i == j { Dd::ONE } else { Dd::ZERO });
        assert!(largest(product(&pair.inverse, &pair.z) - identity) < 1e-27);
    }

    #[test]
    fn a_common_null_space_is_undetermined() {
        let mut r = upper(5);
        r.column_mut(0).fill(Dd::ZERO);
        let penalised_elsewhere = DMatrix::from_fn(1, 5, |_, j| if j == 3 { Dd::ONE } else { Dd::ZERO });
        assert_eq!(Pair::new(&r, &penalised_elsewhere, 4).unwrap_err(), PairFault::Undetermined);
        let pair = Pair::new(&r, &second_differences(5), 4).unwrap();
        assert_eq!(pair.silent, 1);
        assert!(pair.u.column(0).iter().all(|x| *x == Dd::ZERO) && pair.delta[0] > 0.0);
    }
}
