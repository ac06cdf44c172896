//! Dependent columns: distinguished from independent ones, named, solved by minimum norm or refused
//! where λ₁ > 0 is needed.

use crate::oracle::matrix::{doubles, least_squares, rows, vector};
use crate::oracle::random::Random;
use crate::problems::{assert_close, config, fit, linear, matrix, polynomial, values};
use flankfit_engine::estimation::spec::{Degree, FitSpec, Parameter, PolynomialBasis, Regularization, Scaling};
use flankfit_engine::estimation::{FitError, FitResult, Nodes, fit as try_fit};
use proptest::prelude::*;

fn plain(spec: FitSpec) -> FitSpec {
    FitSpec { regularization: Regularization::None, ..spec }
}

fn check_deficient(result: &FitResult, rank: usize) {
    assert_eq!(result.spectrum.rank, rank);
    assert_eq!(result.spectrum.condition, None);
    assert_eq!(result.spectrum.log10_condition, None);
    let warning = result.warnings.iter().find(|w| w.code() == "rank_deficient");
    assert!(warning.is_some(), "{:?}", result.warnings);
    assert!(values(result).iter().all(|v| v.is_finite()));
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn duplicate_columns_share_the_least_solution(seed: u64, n in 1usize..6, extra in 2usize..9, power in -9i32..10,
        none: bool) {
        let mut random = Random::new(seed);
        let m = n + extra;
        let independent: Vec<Vec<f64>> = (0..m).map(|_| random.normals(n)).collect();
        let y = random.normals(m);
        // A copy of one column, multiplied by a power of 2: dependent to the last bit.
        let (of, factor) = (random.below(n), 2f64.powi(power));
        let x: Vec<Vec<f64>> =
            independent.iter().map(|row| [row.clone(), vec![factor * row[of]]].concat()).collect();
        let scaling = if none { Scaling::None } else { Scaling::UnitLength };
        let nodes = matrix(&x, &y, None);
        let result = fit(&nodes, &plain(FitSpec { scaling, ..linear() }));
        check_deficient(&result, n);

        let exact = least_squares(&rows(&independent), &vector(&y));
        assert_close("rss", result.residuals.rss, exact.rss.to_f64(), 1e-10, 0.0);
        let exact = doubles(&exact.coefficients);
        // In unit-length columns the copy takes half; in unscaled columns f / (1 + f²), the
        // original 1 / (1 + f²).
        let (own, copy) = if none {
            (1.0 / (1.0 + factor * factor), factor / (1.0 + factor * factor))
        } else {
            (0.5, 0.5 / factor)
        };
        let got = values(&result);
        for j in 0..n {
            let share = if j == of { own } else { 1.0 };
            assert_close("coefficient", got[j], exact[j] * share, 1e-9, 1e-11);
        }
        assert_close("copy", got[n], exact[of] * copy, 1e-9, 1e-11 * copy);
        let warning = result.warnings.iter().find(|w| w.code() == "rank_deficient").unwrap();
        for j in [of, n] {
            prop_assert!(warning.to_string().contains(&result.coefficients[j].term), "{warning}");
        }

        let refused = try_fit(&nodes, &FitSpec { scaling, ..linear() });
        let Err(FitError::RankDeficient { rank, columns, terms }) = refused else { panic!("{refused:?}") };
        prop_assert_eq!((rank, columns), (n, n + 1));
        let mut named = [result.coefficients[of].term.clone(), result.coefficients[n].term.clone()];
        let mut terms = terms.clone();
        named.sort();
        terms.sort();
        prop_assert_eq!(terms, named.to_vec());

        let ridge = Regularization::Ridge { parameter: Parameter::Fixed(1e-3) };
        let result = fit(&nodes, &FitSpec { scaling, regularization: ridge, ..linear() });
        prop_assert!(result.regularization.filter_factors[0].abs() < 1e-20);
        prop_assert!(values(&result).iter().all(|v| v.is_finite()));
    }
}

#[test]
fn equal_abscissae_leave_one_dimension() {
    for place in [5.0, 5.1, -0.3, 1e6] {
        let y = vec![1.0, 2.0, 4.0, 1.0, 3.0];
        let nodes = Nodes::curve(vec![place; 5], y, None).expect("checked nodes");
        for basis in [PolynomialBasis::Monomial, PolynomialBasis::Chebyshev, PolynomialBasis::Legendre] {
            let result = fit(&nodes, &plain(polynomial(Degree::Both(2), basis)));
            check_deficient(&result, 1);
            // Whatever the coefficients, the fitted height is the mean.
            assert_close("rss", result.residuals.rss, 6.8, 1e-12, 0.0);
            if basis == PolynomialBasis::Monomial {
                // Parallel unit columns share the mean 2.2 equally.
                for (j, value) in values(&result).iter().enumerate() {
                    assert_close("share", value * place.powi(j as i32), 2.2 / 3.0, 1e-9, 0.0);
                }
            }
            let refused = try_fit(&nodes, &polynomial(Degree::Both(2), basis));
            assert!(matches!(refused, Err(FitError::RankDeficient { rank: 1, columns: 3, .. })), "{refused:?}");
        }
    }
}

#[test]
fn nodes_on_a_diagonal_do_not_distinguish_u_from_v() {
    let t: Vec<f64> = (0..9).map(|i| 2.0 + 0.25 * i as f64).collect();
    let z = t.iter().map(|t| 1.0 + t + 0.5 * t * t).collect::<Vec<f64>>();
    let nodes = Nodes::scattered(t.clone(), t, z, None).expect("checked nodes");
    let result = fit(&nodes, &plain(polynomial(Degree::Both(1), PolynomialBasis::Monomial)));
    // 1, v, u, uv on u = v is 1, t, t, t².
    check_deficient(&result, 3);
    assert!(result.residuals.rss < 1e-24);
    let shares: Vec<f64> = values(&result);
    assert_close("u and v share", shares[1], shares[2], 1e-10, 0.0);
    let refused = try_fit(&nodes, &polynomial(Degree::Both(1), PolynomialBasis::Monomial));
    let Err(FitError::RankDeficient { rank: 3, columns: 4, terms }) = refused else { panic!("{refused:?}") };
    assert!(terms.contains(&"u".to_string()) && terms.contains(&"v".to_string()) && terms.len() == 2, "{terms:?}");
}

#[test]
fn a_column_of_zeros_gets_the_coefficient_0() {
    let x: Vec<Vec<f64>> = (0..6).map(|k| vec![1.0, k as f64, 0.0]).collect();
    let y = [1.0, 2.5, 2.0, 4.0, 5.5, 5.0];
    let result = fit(&matrix(&x, &y, None), &plain(linear()));
    check_deficient(&result, 2);
    assert_eq!(values(&result)[2], 0.0);
    let two: Vec<Vec<f64>> = x.iter().map(|row| row[..2].to_vec()).collect();
    let reduced = fit(&matrix(&two, &y, None), &plain(linear()));
    assert_close("slope", values(&result)[1], values(&reduced)[1], 1e-13, 0.0);
}

#[test]
fn nearly_dependent_is_not_dependent() {
    // Two columns that differ by 1e-12 of their length: double-double distinguishes them.
    let mut random = Random::new(4);
    let x: Vec<Vec<f64>> = (0..12)
        .map(|_| {
            let first = random.normal();
            vec![first, first + 1e-12 * random.normal(), random.normal()]
        })
        .collect();
    let y = random.normals(12);
    let result = fit(&matrix(&x, &y, None), &plain(linear()));
    assert_eq!(result.spectrum.rank, 3);
    let exact = doubles(&least_squares(&rows(&x), &vector(&y)).coefficients);
    for (got, exact) in values(&result).iter().zip(&exact) {
        assert_close("coefficient", *got, *exact, 1e-9, 0.0);
    }
}

#[test]
fn more_coefficients_than_nodes_are_refused() {
    let nodes = Nodes::curve(vec![1.0, 2.0, 3.0], vec![1.0, 2.0, 2.0], None).expect("checked nodes");
    let refused = try_fit(&nodes, &polynomial(Degree::Both(3), PolynomialBasis::Monomial));
    assert!(matches!(refused, Err(FitError::Invalid(_))), "{refused:?}");
}

#[test]
fn nodes_outside_a_given_domain_are_refused() {
    use flankfit_engine::estimation::spec::Domain;
    let nodes = Nodes::curve(vec![1.0, 2.0, 3.0, 5.5], vec![1.0, 2.0, 2.0, 1.0], None).expect("checked nodes");
    let domain = Some(Domain { u: Some([1.0, 5.0]), v: None });
    for basis in [PolynomialBasis::Monomial, PolynomialBasis::Legendre] {
        let refused = try_fit(&nodes, &FitSpec { domain, ..polynomial(Degree::Both(1), basis) });
        let Err(FitError::Invalid(faults)) = refused else { panic!("{refused:?}") };
        assert_eq!(faults.list()[0].path, "nodes.x[3]");
    }
}
