//! Proved intervals of the NIST StRD sets contain the exact results of their doubles.

use crate::answers::{answer, curve, matrix, monomials};
use crate::folder::{numbers, reference};
use crate::oracle::rational::{Dyadic, least_squares};
use flankfit_engine::estimation::Nodes;
use flankfit_engine::estimation::spec::{FitSpec, Include, Model};

/// Relative radii are a few units of the last place, also those of standard errors where there is
/// any noise above rounding.
fn check(name: &str, nodes: &Nodes, model: Model, rows: &[Vec<Dyadic>], y: &[f64]) {
    let include = Include { enclosure: true, ..Include::default() };
    let result = answer(nodes, &FitSpec { include, ..FitSpec::new(model) });
    let found = result.numerics.enclosure.unwrap_or_else(|| panic!("{name}: {:?}", result.warnings));
    let exact = least_squares(rows, y, None);
    let radius = |[low, high]: [f64; 2]| 0.5 * (high - low) / low.abs().max(high.abs());
    let noise = found.rss[0] > 1e-20;
    let std_errors = found.std_errors.expect("degrees of freedom");
    println!("{name}: radii up to {:e}", found.coefficients.iter().map(|ends| radius(*ends)).fold(0.0, f64::max));
    assert!(exact.rss.within(found.rss) && (!noise || radius(found.rss) < 1e-13), "{name}: {:?}", found.rss);
    for (j, (coefficient, std_error)) in found.coefficients.iter().zip(&std_errors).enumerate() {
        assert!(exact.coefficients[j].within(*coefficient), "{name}: coefficient {j} {coefficient:?}");
        assert!(radius(*coefficient) < 1e-13, "{name}: coefficient {j} {coefficient:?}");
        let square = exact.inverse[j].times_ratio(&exact.rss).by(y.len() - rows[0].len());
        assert!(square.root_within(*std_error), "{name}: standard error {j} {std_error:?}");
        assert!(!noise || radius(*std_error) < 1e-13, "{name}: standard error {j} {std_error:?}");
    }
}

fn exactly(x: &[Vec<f64>]) -> Vec<Vec<Dyadic>> {
    x.iter().map(|row| row.iter().map(|&x| Dyadic::from(x)).collect()).collect()
}

#[test]
fn polynomials() {
    for (name, degree) in
        [("nist_norris", 1), ("nist_pontius", 2), ("nist_wampler1", 5), ("nist_wampler2", 5), ("nist_wampler4", 5)]
    {
        let file = reference(name);
        let (x, y) = (numbers(&file["data"]["x"]), numbers(&file["data"]["y"]));
        let rows: Vec<Vec<Dyadic>> =
            x.iter().map(|&x| (0..=degree).map(|i| Dyadic::from(x).power(i)).collect()).collect();
        check(name, &curve(&x, &y), monomials(degree), &rows, &y);
        let powers: Vec<Vec<f64>> = x.iter().map(|x| (0..=degree as i32).map(|p| x.powi(p)).collect()).collect();
        check(&format!("{name} as a matrix"), &matrix(&powers, &y), Model::Linear, &exactly(&powers), &y);
    }
}

#[test]
fn matrices() {
    let file = reference("nist_noint1");
    let y = numbers(&file["data"]["y"]);
    let x: Vec<Vec<f64>> = numbers(&file["data"]["x"]).iter().map(|x| vec![*x]).collect();
    check("nist_noint1", &matrix(&x, &y), Model::Linear, &exactly(&x), &y);
    let file = reference("nist_longley");
    let y = numbers(&file["data"]["y"]);
    let columns: Vec<Vec<f64>> = (1..=6).map(|j| numbers(&file["data"][format!("x{j}")])).collect();
    let x: Vec<Vec<f64>> =
        (0..y.len()).map(|k| std::iter::once(1.0).chain(columns.iter().map(|c| c[k])).collect()).collect();
    check("nist_longley", &matrix(&x, &y), Model::Linear, &exactly(&x), &y);
}
