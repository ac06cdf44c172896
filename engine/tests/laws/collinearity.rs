//! Section 5: variance inflation, correlation, variance proportions and near dependencies by their
//! definitions.

use crate::oracle::big::Big;
use crate::oracle::matrix::{column, dot, doubles, eigen, gram, inverse, least_squares, rows};
use crate::oracle::random::Random;
use crate::oracle::spectral::Columns;
use crate::problems::{Problem, Surface, assert_close, config, fit, linear, matrix, polynomial};
use flankfit_engine::estimation::spec::{Degree, FitSpec, Include, PolynomialBasis, Regularization, Scaling};
use proptest::prelude::*;

fn asked(spec: FitSpec) -> FitSpec {
    let include = Include { collinearity: true, ..Include::default() };
    FitSpec { include, regularization: Regularization::None, ..spec }
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn diagnostics_by_their_definitions(
        seed: u64, n in 2usize..7, extra in 2usize..12, log_condition in 1.0f64..10.0, none: bool,
    ) {
        let mut problem = Problem::graded(seed, n, extra, log_condition);
        problem.x.iter_mut().for_each(|row| row.insert(0, 1.0));
        let scaling = if none { Scaling::None } else { Scaling::UnitLength };
        let result = fit(&problem.nodes(), &asked(FitSpec { scaling, ..linear() }));
        let report = &result.collinearity;
        let x = rows(&problem.x);
        let n = n + 1;

        // VIF: 1 / (1 − R²) of each column on the others and the constant.
        prop_assert_eq!(report.columns[0].vif, None);
        let centred: Vec<Vec<Big>> = (0..n)
            .map(|j| {
                let values = column(&x, j);
                let mean = &values.iter().fold(Big::zero(), |s, v| &s + v) / &Big::from(values.len());
                values.iter().map(|v| v - &mean).collect()
            })
            .collect();
        for (j, own) in centred.iter().enumerate().skip(1) {
            let others: Vec<Vec<Big>> =
                (0..x.len()).map(|k| (0..n).filter(|i| *i != j).map(|i| x[k][i].clone()).collect()).collect();
            let left = least_squares(&others, &column(&x, j)).rss;
            let vif = (&dot(own, own) / &left).to_f64();
            assert_close("vif", report.columns[j].vif.unwrap(), vif, 1e-6, 0.0);
        }
        let correlation = report.correlation.as_ref().unwrap();
        for i in 1..n {
            for j in 1..n {
                let lengths = (dot(&centred[i], &centred[i]) * dot(&centred[j], &centred[j])).sqrt();
                let exact = (&dot(&centred[i], &centred[j]) / &lengths).to_f64();
                assert_close("correlation", correlation[i][j], exact, 0.0, 1e-9);
            }
        }

        // Belsley, Kuh and Welsch: on unit-length columns whatever the scaling of the fit.
        let unit = problem.spectrum(Columns::UnitLength);
        let variances = inverse(&gram(&unit.scaled));
        let proportions = report.variance_proportions.as_ref().unwrap();
        for j in 0..n {
            prop_assert_eq!(proportions[j].len(), n);
            for (i, proportion) in proportions[j].iter().enumerate() {
                let part = &(&unit.vectors[i][j] * &unit.vectors[i][j]) / &unit.eigenvalues[i];
                let exact = (&part / &variances[j][j]).to_f64();
                assert_close("proportion", *proportion, exact, 1e-6, 1e-9);
            }
            assert_close("sum", proportions[j].iter().sum(), 1.0, 1e-12, 0.0);
        }
        let lambda = doubles(&unit.eigenvalues);
        for near in &report.near_dependencies {
            let i = (0..n).min_by(|p, q| {
                let far = |i: &usize| (lambda[*i].ln() - near.eigenvalue.ln()).abs();
                far(p).total_cmp(&far(q))
            }).unwrap();
            assert_close("eigenvalue", near.eigenvalue, lambda[i], 1e-8, 0.0);
            let index = (lambda[n - 1] / lambda[i]).sqrt();
            assert_close("condition index", near.condition_index.unwrap(), index, 1e-7, 0.0);
            prop_assert!(near.terms.len() >= 2 && !near.sentence.is_empty());
            // With two terms their cosine; with more, R² (about 0) of the leading one on the
            // others.
            let place = |term: &String| result.coefficients.iter().position(|c| c.term == *term).unwrap();
            let terms: Vec<usize> = near.terms.iter().map(place).collect();
            if let [a, b] = terms[..] {
                let exact = dot(&column(&unit.scaled, a), &column(&unit.scaled, b)).to_f64();
                assert_close("cosine", near.cosine.unwrap(), exact, 0.0, 1e-12);
            } else {
                let others: Vec<Vec<Big>> =
                    unit.scaled.iter().map(|row| terms[1..].iter().map(|j| row[*j].clone()).collect()).collect();
                let left = least_squares(&others, &column(&unit.scaled, terms[0])).rss.to_f64();
                assert_close("what R² leaves", 1.0 - near.r_squared.unwrap(), left, 1e-6, 1e-12);
            }
            let gap = [i.wrapping_sub(1), i + 1].iter().filter_map(|k| lambda.get(*k))
                .map(|l| (l / lambda[i] - 1.0).abs()).fold(f64::INFINITY, f64::min);
            if gap > 1e-2 {
                let weights = near.weights.as_ref().unwrap();
                let sign = if weights[0] * unit.vectors[i][0].to_f64() < 0.0 { -1.0 } else { 1.0 };
                for (got, exact) in weights.iter().zip(&unit.vectors[i]) {
                    assert_close("weight", sign * got, exact.to_f64(), 0.0, 1e-6);
                }
            }
        }
        // Every eigenvalue above Belsley's rule has its sentence.
        let beyond = lambda.iter().filter(|l| lambda[n - 1] / **l > 900.0 * (1.0 + 1e-9)).count();
        prop_assert!(report.near_dependencies.len() >= beyond, "{} of {beyond}", report.near_dependencies.len());
    }
}

#[test]
fn two_parallel_columns_are_named() {
    // Eq. 26: with two terms, cos(X₁, X₂) and −v₁/v₂ are reported together and nearly agree.
    let mut random = Random::new(8);
    let x: Vec<Vec<f64>> = (0..20)
        .map(|_| {
            let first = random.between(1.0, 2.0);
            vec![random.between(-1.0, 1.0), first, 3.0 * first + 1e-3 * random.normal()]
        })
        .collect();
    let y = random.normals(20);
    let result = fit(&matrix(&x, &y, None), &asked(linear()));
    let near = &result.collinearity.near_dependencies[0];
    let names: Vec<&String> = result.coefficients[1..].iter().map(|c| &c.term).collect();
    let mut terms: Vec<&String> = near.terms.iter().collect();
    terms.sort();
    assert_eq!(terms, names);
    let (a, b) = (column(&rows(&x), 1), column(&rows(&x), 2));
    let cosine = (&dot(&a, &b) / &(dot(&a, &a) * dot(&b, &b)).sqrt()).to_f64();
    assert_close("cosine", near.cosine.unwrap(), cosine, 1e-12, 0.0);
    assert_close("Eq. 26", near.weight_ratio.unwrap(), cosine, 1e-3, 0.0);
    assert!(near.terms.iter().all(|t| near.sentence.contains(t.as_str())), "{}", near.sentence);
}

/// A partner of small weight without which the others would be determined far better: all three are
/// named, with results of the pair of its own.
#[test]
fn every_partner_of_a_dependency_is_named() {
    let mut random = Random::new(21);
    let x: Vec<Vec<f64>> = (0..40)
        .map(|_| {
            let [a, b, c, d] = [(); 4].map(|()| random.normal());
            vec![a, a + 0.02 * b + 1e-7 * c, b, d]
        })
        .collect();
    let y = random.normals(40);
    let result = fit(&matrix(&x, &y, None), &asked(linear()));
    let name = |j: usize| result.coefficients[j].term.clone();
    let [near] = &result.collinearity.near_dependencies[..] else { panic!("one dependency") };
    let mut terms = near.terms.clone();
    terms.sort();
    assert_eq!(terms, [name(0), name(1), name(2)]);
    assert!(near.condition_index.unwrap() > 1e6 && near.cosine.is_none() && near.r_squared.unwrap() > 1.0 - 1e-10);
    assert!((0..3).all(|j| near.sentence.contains(&name(j))), "{}", near.sentence);
    let (a, b) = (column(&rows(&x), 0), column(&rows(&x), 1));
    let cosine = (&dot(&a, &b) / &(dot(&a, &a) * dot(&b, &b)).sqrt()).to_f64();
    let index = ((1.0 + cosine) / (1.0 - cosine)).sqrt().round();
    assert!(
        near.sentence.contains("alone have cos = 0.99") && near.sentence.ends_with(&format!("condition index {index}"))
    );
}

#[test]
fn raw_monomials_in_millimetres_are_called_nearly_parallel() {
    let surface = Surface::new(1, [2, 2], 0.5, 1e-3);
    let result = fit(&surface.grid(), &asked(polynomial(Degree::Both(2), PolynomialBasis::Monomial)));
    let report = &result.collinearity;
    assert!(report.near_dependencies.len() >= 3);
    assert!(report.columns.iter().skip(1).all(|c| c.vif.unwrap() > 10.0), "{:?}", report.columns);
    // The grid has a matrix too: the diagnostics are those of the crossings.
    let scattered = fit(&surface.scattered(), &asked(polynomial(Degree::Both(2), PolynomialBasis::Monomial)));
    for (a, b) in report.columns.iter().zip(&scattered.collinearity.columns) {
        assert_eq!(a.vif.is_some(), b.vif.is_some());
        if let (Some(a), Some(b)) = (a.vif, b.vif) {
            assert_close("vif", a, b, 1e-9, 0.0);
        }
    }
    let x: Vec<Vec<f64>> =
        surface.nodes.iter().map(|[u, v]| (0..9).map(|k| u.powi(k / 3) * v.powi(k % 3)).collect()).collect();
    let unit = Problem { x, y: surface.z.clone() }.spectrum(Columns::UnitLength);
    let (lambda, _) = eigen(&gram(&unit.scaled));
    assert_close("least eigenvalue", report.near_dependencies[0].eigenvalue, lambda[0].to_f64(), 1e-6, 0.0);
}
