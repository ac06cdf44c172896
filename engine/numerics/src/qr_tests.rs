//! Laws of the triangularisation, in both precisions.

use super::*;
use crate::dd::Dd;
use proptest::prelude::*;

/// `XᵀX` of `X = [A | y]` must be that of `[R | Qᵀy]` with the rest of `y`, entry by entry relative
/// to the columns.
fn check<T: Laned>(a: &DMatrix<T>, y: &DVector<T>) -> Qr<T> {
    let (m, n) = a.shape();
    let qr = qr_with_rhs(a.clone(), y.clone());
    assert_eq!((qr.r.shape(), qr.qty.len()), ((n, n), n));
    let old = |j: usize, i: usize| if j < n { a[(i, j)] } else { y[i] };
    let new = |j: usize, i: usize| if j < n { qr.r[(i, j)] } else { qr.qty[i] };
    for p in 0..=n {
        for q in 0..=n {
            // Powers of two keep the products of the largest entries in range.
            let unit = |j: usize| {
                let largest = (0..m).map(|i| old(j, i).to_f64().abs()).fold(0.0, f64::max);
                if largest > 0.0 { -exponent_of(largest) } else { 0 }
            };
            let (s, t) = (unit(p), unit(q));
            let mut before = T::zero();
            for i in 0..m {
                before = old(p, i).ldexp(s).fma(old(q, i).ldexp(t), before);
            }
            let mut after = T::zero();
            for i in 0..n {
                after = new(p, i).ldexp(s).fma(new(q, i).ldexp(t), after);
            }
            if p == n && q == n {
                after += qr.rss.ldexp(s).ldexp(t);
            }
            let error = (before - after).abs().to_f64();
            let bound = 20.0 * T::EPSILON * ((m + 4) * (n + 4)) as f64;
            assert!(error <= bound, "{m} x {n}: [{p}, {q}] {before:?} {after:?} {error:e}");
        }
    }
    for j in 0..n {
        assert!(qr.r[(j, j)] >= T::zero());
        for i in j + 1..n {
            assert!(qr.r[(i, j)].is_zero());
        }
    }
    for i in m..n {
        assert!(qr.qty[i].is_zero() && qr.r.row(i).iter().all(|x| x.is_zero()));
    }
    qr
}

fn check_both(a: &DMatrix<f64>, y: &DVector<f64>) -> (Qr<f64>, Qr<Dd>) {
    (check(a, y), check(&a.map(Dd::from), &y.map(Dd::from)))
}

fn waves(m: usize, n: usize) -> (DMatrix<f64>, DVector<f64>) {
    let a = DMatrix::from_fn(m, n, |i, j| ((i * n + j) as f64 * 0.7).sin() + 0.3);
    (a, DVector::from_fn(m, |i, _| (i as f64 * 0.3).cos()))
}

#[test]
fn every_shape() {
    for (m, n) in
        [(0, 0), (0, 2), (3, 0), (1, 1), (1, 3), (2, 5), (5, 5), (4, 3), (128, 4), (129, 5), (300, 7), (90, 70)]
    {
        let (a, y) = waves(m, n);
        check_both(&a, &y);
    }
    let (a, y) = waves(300, 70);
    check_both(&a, &y);
}

#[test]
fn zeros_and_dependent_columns() {
    for m in [3, 200] {
        let (a, y) = waves(m, 4);
        let qr = check_both(&DMatrix::zeros(m, 4), &y).0;
        assert!(qr.r.iter().all(|&x| x == 0.0));
        let mut zero_first = a.clone();
        zero_first.column_mut(0).fill(0.0);
        check_both(&zero_first, &y);
        let mut twice = a;
        let copy = twice.column(0).clone_owned();
        twice.set_column(1, &copy);
        check_both(&twice, &y);
        check_both(&twice, &DVector::zeros(m));
    }
    check_both(&DMatrix::from_row_slice(2, 3, &[1.0, 1.0, 0.0, 0.0, 0.0, 1.0]), &DVector::from_vec(vec![1.0, 2.0]));
}

#[test]
fn the_ends_of_the_range() {
    for m in [6, 200] {
        let (a, y) = waves(m, 4);
        let scales = [1e150, 1e-150, 1.0, 1e120];
        let scaled = DMatrix::from_fn(m, 4, |i, j| a[(i, j)] * scales[j]);
        let (qr, _) = check_both(&scaled, &y);
        let plain = qr_with_rhs(a, y);
        for (j, scale) in scales.iter().enumerate() {
            for i in 0..=j {
                let want = plain.r[(i, j)];
                assert!((qr.r[(i, j)] / scale - want).abs() < 1e-12, "{i}, {j}");
            }
        }
    }
}

#[test]
fn a_tiny_rest_below_a_large_row_is_kept() {
    let mut a = DMatrix::zeros(3, 2);
    a[(0, 0)] = 1.0;
    a[(0, 1)] = 1.0;
    a[(1, 1)] = 1e-170;
    let qr = qr_with_rhs(a, DVector::zeros(3));
    assert_eq!(qr.r[(1, 1)], 1e-170);
}

#[test]
fn nonfinite_entries_stay_visible() {
    for bad in [f64::NAN, f64::INFINITY] {
        let (mut a, y) = waves(5, 3);
        a[(4, 1)] = bad;
        assert!(qr_with_rhs(a, y).r.iter().any(|x| !x.is_finite()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn cross_products_are_kept(m in 1usize..20, n in 1usize..8, entries in prop::collection::vec(-1.0..1.0f64, 180),
        exponents in prop::collection::vec(-100i32..100, 8)) {
        let a = DMatrix::from_fn(m, n, |i, j| entries[i * n + j] * f64::from(exponents[j]).exp2());
        let y = DVector::from_column_slice(&entries[160..160 + m]);
        check_both(&a, &y);
    }

    #[test]
    fn the_rest_of_y_is_the_least_squares_residual(m in 4usize..20,
        entries in prop::collection::vec(-1.0..1.0f64, 80)) {
        let a = DMatrix::from_fn(m, 3, |i, j| entries[i * 3 + j]);
        let y = DVector::from_column_slice(&entries[60..60 + m]);
        let qr = qr_with_rhs(a.map(Dd::from), y.map(Dd::from));
        let mut x: Vec<Dd> = qr.qty.iter().copied().collect();
        prop_assume!((0..3).all(|i| qr.r[(i, i)].hi > 1e-3));
        crate::triangular::solve_upper(&qr.r, &mut x);
        let residual: Vec<Dd> = (0..m).map(|i| (0..3).fold(Dd::from(y[i]), |r, j| r - x[j] * a[(i, j)])).collect();
        for j in 0..3 {
            let inner: Dd = (0..m).map(|i| residual[i] * a[(i, j)]).sum();
            prop_assert!(inner.abs().hi < 1e-24);
        }
        let square: Dd = residual.iter().map(|r| r.square()).sum();
        prop_assert!((square - qr.rss).abs().hi < 1e-26);
    }
}
