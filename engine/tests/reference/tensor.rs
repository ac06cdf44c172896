//! Tensor polynomials on a grid in millimetres, raw monomials.

use crate::answers::{answer, at_least, exact_of, judge_digits, plain, std_errors, values};
use crate::folder::{decimals, number, numbers, reference, table};
use crate::oracle::design::{Basis, crossings, surface};
use flankfit_engine::estimation::Nodes;
use flankfit_engine::estimation::spec::{Degree, Model, PolynomialBasis, Terms};

#[test]
fn bicubic_by_quadratic_between_30_and_40_mm() {
    let file = reference("tensor_polynomial_lsq_30_40mm");
    let (u, v, z) = (numbers(&file["x"]), numbers(&file["y"]), table(&file["z_rows_over_x"]).concat());
    let (degree, basis) = (Degree::Each(3, 2), PolynomialBasis::Monomial);
    let model = Model::Polynomial { degree, basis, terms: Terms::Tensor };
    let places = crossings(&u, &v);
    let axis = |k: usize| places.iter().map(|p| p[k]).collect::<Vec<f64>>();
    let truth = exact_of(&surface([Basis::Monomial, Basis::Monomial], [3, 2], &places, |_, _| true), &z);
    let grid = Nodes::grid(u, v, z.clone(), None, None).expect("checked nodes");
    let scattered = Nodes::scattered(axis(0), axis(1), z, None).expect("checked nodes");
    for (name, nodes) in [("grid", grid), ("scattered", scattered)] {
        let result = answer(&nodes, &plain(model.clone()));
        at_least(name, &values(&result), &decimals(&file["coef_dec"]), 12.0);
        at_least("standard errors", &std_errors(&result), &decimals(&file["se_dec"]), 8.0);
        judge_digits(name, &result, &truth, 13.0);
        let residual = &result.residuals;
        let near = |a: f64, b: &str| (a - number(&file[b])).abs() <= 1e-11 * number(&file[b]);
        assert!(near(residual.rss, "rss") && near(residual.sigma.unwrap(), "residual_sd"));
        assert!(near(residual.r_squared.unwrap(), "r2"));
    }
}
