//! Laws of the singular value decomposition, in both precisions.

use super::*;
use crate::dd::Dd;
use crate::svd_dd;
use proptest::prelude::*;

fn transpose_product<T: Laned>(a: &DMatrix<T>, b: &DMatrix<T>) -> DMatrix<T> {
    DMatrix::from_fn(a.ncols(), b.ncols(), |i, j| {
        a.column(i).iter().zip(b.column(j).iter()).fold(T::zero(), |sum, (&x, &y)| x.fma(y, sum))
    })
}

/// Properties that every decomposition has, to `digits` units of roundoff.
fn check<T: Laned>(a: &DMatrix<T>, svd: &Svd<T>, roundoffs: f64) {
    let n = a.ncols();
    let bound = roundoffs * T::EPSILON;
    assert_eq!((svd.sigma.len(), svd.us.shape(), svd.v.shape()), (n, a.shape(), (n, n)));
    assert!(svd.sigma.windows(2).all(|pair| pair[0] <= pair[1]), "{:?}", svd.sigma);
    let gram = transpose_product(&svd.v, &svd.v);
    for i in 0..n {
        for j in 0..n {
            let want = if i == j { T::one() } else { T::zero() };
            assert!((gram[(i, j)] - want).abs().to_f64() <= bound, "VᵀV[{i},{j}] = {:?}", gram[(i, j)]);
        }
    }
    let largest = a.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
    let av = transpose_product(&a.transpose(), &svd.v);
    for (x, y) in av.iter().zip(svd.us.iter()) {
        assert!((*x - *y).abs().to_f64() <= bound * largest, "A V = {x:?}, U S = {y:?}");
    }
    for i in 0..n {
        let length = svd.us.column(i).iter().fold(T::zero(), |sum, &x| x.fma(x, sum)).sqrt();
        let error = (length - svd.sigma[i]).abs().to_f64();
        assert!(error <= bound * svd.sigma[i].to_f64(), "column {i}: {length:?}, {:?}", svd.sigma[i]);
        for j in 0..i {
            let inner = svd.us.column(i).iter().zip(svd.us.column(j).iter()).fold(T::zero(), |s, (&x, &y)| x.fma(y, s));
            let limit = bound * svd.sigma[i].to_f64() * svd.sigma[j].to_f64();
            assert!(inner.abs().to_f64() <= limit, "{i}, {j}: {inner:?} > {limit:e}");
        }
        let v = svd.v.column(i);
        let largest = v.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max);
        let first = v.iter().find(|x| x.abs().to_f64() >= largest * (1.0 - SIGN_TIE));
        assert!(first.is_none_or(|x| x.to_f64() > 0.0), "sign of {v:?}");
    }
}

fn check_both(a: &DMatrix<f64>) -> (Svd<f64>, Svd<Dd>) {
    let double = svd(a.clone()).expect("converges");
    check(a, &double, 200.0);
    let wide = a.map(Dd::from);
    let plain = svd(wide.clone()).expect("converges");
    check(&wide, &plain, 200.0);
    let started = svd_dd(&wide).expect("converges");
    check(&wide, &started, 200.0);
    (double, started)
}

/// A decimal fraction to double-double precision.
fn decimal(text: &str) -> Dd {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let places = mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len() as i32);
    let digits = mantissa.chars().filter_map(|c| c.to_digit(10));
    let integer = digits.fold(Dd::ZERO, |value, digit| value * 10.0 + f64::from(digit));
    let power: i32 = exponent.parse().expect("an exponent");
    let ten = Dd::from(10.0);
    if power >= places { integer * ten.powi(power - places) } else { integer / ten.powi(places - power) }
}

fn compare(sigma: &[Dd], descending: &[&str], digits: i32) {
    for (sigma, want) in sigma.iter().rev().zip(descending) {
        let want = decimal(want);
        let error = ((*sigma - want) / want).abs().hi;
        assert!(error < 10f64.powi(-digits), "{sigma:?} for {want:?}: {error:e}");
    }
}

#[test]
fn hilbert_matrix_of_order_five() {
    // Computed with 100 digits from H[i][j] = 1/(i+j+1); the second list from its entries rounded
    // to double.
    let exact = DMatrix::from_fn(5, 5, |i, j| Dd::ONE / (i + j + 1) as f64);
    let svd = svd_dd(&exact).expect("converges");
    check(&exact, &svd, 100.0);
    compare(
        &svd.sigma,
        &[
            "1.567050691098230795533011",
            "0.2085342186110133359050025",
            "0.01140749162341980655945146",
            "0.0003058980401511917268794978",
            "3.287928772171862957115005e-6",
        ],
        24,
    );
    let (double, wide) = check_both(&exact.map(Dd::to_f64));
    let rounded = [
        "1.567050691098230784861999",
        "0.2085342186110133316812365",
        "0.01140749162341980229665118",
        "0.0003058980401511854319672615",
        "3.287928772175815890892489e-6",
    ];
    compare(&wide.sigma, &rounded, 24);
    compare(&double.sigma.iter().map(|&x| Dd::from(x)).collect::<Vec<_>>(), &rounded, 10);
}

#[test]
fn vandermonde_matrix_of_degree_ten() {
    // Equally spaced abscissae k/16 in [0, 1], whose powers are exact in double-double.
    let a = DMatrix::from_fn(17, 11, |i, j| Dd::from(i as f64 / 16.0).powi(j as i32));
    let svd = svd_dd(&a).expect("converges");
    check(&a, &svd, 200.0);
    // Computed with 100 digits from the entries, which are exact.
    let exact = [
        "5.746971235145292099768138",
        "2.737184255980733522434143",
        "0.9308142511894097287738603",
        "0.2640601861238878349016939",
        "0.06425171357874606301489991",
        "0.01343207327224034181238150",
        "0.002388857740499785393071228",
        "0.0003536397573043530347847329",
        "4.190933652869406331975292e-5",
        "3.702086349402795508346407e-6",
        "2.072679925206592015900748e-7",
    ];
    compare(&svd.sigma, &exact, 23);
    let qr = crate::qr_with_rhs(a, nalgebra::DVector::zeros(17));
    let of_factor = svd_dd(&qr.r).expect("converges");
    compare(&of_factor.sigma, &exact, 22);
    let double = crate::svd(qr.r.map(Dd::to_f64)).expect("converges");
    compare(&double.sigma.iter().map(|&x| Dd::from(x)).collect::<Vec<_>>(), &exact, 9);
}

#[test]
fn a_column_that_nearly_repeats_another() {
    // Columns 1, x, x + x^2 / 2^17 at x = i/8; computed with 100 digits.
    let a = DMatrix::from_fn(17, 3, |i, j| {
        let x = (i as f64 - 8.0) / 8.0;
        [1.0, x, x + x * x / 131_072.0][j]
    });
    let exact = ["4.123105625659847405434987", "3.570714214249910009007612", "7.421675880531268339648834e-6"];
    let (double, wide) = check_both(&a);
    compare(&wide.sigma, &exact, 24);
    compare(&double.sigma.iter().map(|&x| Dd::from(x)).collect::<Vec<_>>(), &exact, 9);
}

#[test]
fn laeuchli_matrix() {
    // A row of ones over eps I: singular values sqrt(3 + eps^2), eps, eps.
    for eps in [2f64.powi(-20), 2f64.powi(-40), 2f64.powi(-70)] {
        let a = DMatrix::from_fn(4, 3, |i, j| if i == 0 { 1.0 } else { f64::from(u8::from(i == j + 1)) * eps });
        let (double, wide) = check_both(&a);
        for i in 0..2 {
            assert!((double.sigma[i] / eps - 1.0).abs() < 1e-15);
            assert!(((wide.sigma[i] - eps) / eps).abs().hi < 1e-29);
        }
        let largest = (Dd::product(eps, eps) + 3.0).sqrt();
        assert!(((wide.sigma[2] - largest) / largest).abs().hi < 1e-29);
    }
}

#[test]
fn trivial_shapes() {
    check_both(&DMatrix::zeros(4, 3));
    check_both(&DMatrix::zeros(3, 0));
    check_both(&DMatrix::zeros(0, 2));
    check_both(&DMatrix::from_element(1, 1, -3.0));
    check_both(&DMatrix::from_row_slice(1, 4, &[1.0, -2.0, 0.0, 2.0]));
    check_both(&DMatrix::identity(5, 5));
    let (double, _) = check_both(&DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 5.0, 0.0]));
    assert_eq!(double.sigma, [0.0, 5.0]);
}

#[test]
fn nonfinite_matrices_have_no_svd() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut a = DMatrix::identity(3, 3);
        a[(1, 2)] = bad;
        assert_eq!(svd(a.clone()), None);
        assert_eq!(svd_dd(&a.map(Dd::from)), None);
    }
}

#[test]
fn dependent_columns_have_the_singular_value_zero() {
    let a = DMatrix::from_fn(6, 4, |i, j| [1.0, i as f64, 1.0, 2.0 * i as f64 - 1.0][j]);
    let (double, wide) = check_both(&a);
    for i in 0..2 {
        assert!(double.sigma[i] < 1e-14 && wide.sigma[i].hi < 1e-30);
    }
    assert!(double.sigma[2] > 1.0);
    let (double, _) = check_both(&DMatrix::from_element(3, 3, 0.1));
    assert_eq!(double.sigma[..2], [0.0, 0.0]);
}

#[test]
fn the_ends_of_the_range() {
    let a = DMatrix::from_fn(5, 3, |i, j| ((i * 3 + j) as f64).sin());
    let (reference, _) = check_both(&a);
    for factor in [2f64.powi(1000), 2f64.powi(-1000)] {
        let svd = svd(&a * factor).expect("converges");
        for (x, y) in svd.sigma.iter().zip(&reference.sigma) {
            assert_eq!(*x, y * factor);
        }
        assert_eq!(svd.v, reference.v);
    }
}

fn matrix_of(rows: std::ops::Range<usize>, beyond_columns: bool) -> impl Strategy<Value = DMatrix<f64>> {
    (rows, 1usize..9).prop_flat_map(move |(m, n)| {
        let m = if beyond_columns { m + n } else { m };
        prop::collection::vec(-1.0..1.0f64, m * n).prop_map(move |entries| DMatrix::from_vec(m, n, entries))
    })
}

fn matrix() -> impl Strategy<Value = DMatrix<f64>> {
    matrix_of(1..12, false)
}

/// At least as many rows as columns.
fn tall() -> impl Strategy<Value = DMatrix<f64>> {
    matrix_of(0..6, true)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn any_matrix(a in matrix()) {
        check_both(&a);
    }

    #[test]
    fn small_integers_with_dependent_columns(entries in prop::collection::vec(-2i8..3, 30), n in 1usize..7) {
        check_both(&DMatrix::from_fn(30 / n, n, |i, j| f64::from(entries[i * n + j])));
    }

    #[test]
    fn column_scaling_keeps_every_digit(a in tall(), exponents in prop::collection::vec(-200i32..200, 9)) {
        // The first vectors of an orthonormal set, scaled: the singular values are the scales.
        let q = svd(a.clone()).expect("converges");
        prop_assume!(q.sigma[0] > 1e-3);
        let mut scales: Vec<f64> = exponents[..a.ncols()].iter().map(|&e| f64::from(e).exp2()).collect();
        let graded = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| q.us[(i, j)] / q.sigma[j] * scales[j]);
        let (double, _) = check_both(&graded);
        scales.sort_by(f64::total_cmp);
        for (sigma, scale) in double.sigma.iter().zip(&scales) {
            prop_assert!((sigma / scale - 1.0).abs() < 1e-11, "{} {}", sigma, scale);
        }
    }

    #[test]
    fn graded_matrices_agree_in_both_precisions(a in tall(), exponents in prop::collection::vec(-150i32..150, 9)) {
        let condition = svd(a.clone()).expect("converges").sigma;
        prop_assume!(condition[0] > 1e-4 * condition[a.ncols() - 1]);
        let graded = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * f64::from(exponents[j]).exp2());
        let (double, wide) = check_both(&graded);
        for (x, y) in double.sigma.iter().zip(&wide.sigma) {
            prop_assert!((x / y.hi - 1.0).abs() < 1e-10);
        }
    }
}
