//! Least-squares B-splines with given knots: curves, weighted curves, a bicubic surface.

use crate::answers::{answer, at_least, exact_of, judge_digits, plain, std_errors, values};
use crate::folder::{decimals, number, numbers, reference, table};
use crate::oracle::big::Big;
use crate::oracle::design::{self, Basis, crossings, surface};
use flankfit_engine::estimation::Nodes;
use flankfit_engine::estimation::spec::{Degree, FitSpec, Include, Knots, Model};

fn curve(name: &str) {
    let file = reference(name);
    let (x, y, knots) = (numbers(&file["x"]), numbers(&file["y"]), numbers(&file["knots"]));
    let degree = file["degree"].as_u64().expect("a degree") as usize;
    let weight = (!file["weights"].is_null()).then(|| numbers(&file["weights"]));
    let nodes = Nodes::curve(x.clone(), y.clone(), weight.clone()).expect("checked nodes");
    let model = Model::BSpline { degree: Degree::Both(degree), knots: Knots::Curve(knots.clone()), weights: None };
    let include = Include { residuals: true, ..Include::default() };
    let result = answer(&nodes, &FitSpec { include, ..plain(model) });
    at_least(name, &values(&result), &decimals(&file["coef_dec"]), 13.0);
    at_least("standard errors", &std_errors(&result), &decimals(&file["se_dec"]), 8.0);
    let near = |a: f64, b: &str| (a - number(&file[b])).abs() <= 1e-12 * number(&file[b]);
    assert!(near(result.residuals.rss, "rss") && near(result.residuals.sigma.unwrap(), "residual_sd"));
    let residuals = result.residuals.values.as_ref().expect("asked for");
    for (got, truth) in residuals.iter().zip(numbers(&file["residuals"])) {
        assert!((got - truth).abs() < 1e-13, "{got:e} {truth:e}");
    }
    let mut columns = design::curve(Basis::BSpline(&knots), degree, &x);
    let mut heights: Vec<Big> = y.iter().map(|y| Big::from(*y)).collect();
    for (k, w) in weight.iter().flatten().enumerate() {
        let root = Big::from(*w).sqrt();
        columns[k].iter_mut().for_each(|c| *c = &*c * &root);
        heights[k] = &heights[k] * &root;
    }
    let exact = crate::oracle::matrix::least_squares(&columns, &heights).coefficients;
    judge_digits(name, &result, &exact, 14.0);
}

#[test]
fn linear() {
    curve("bspline_lsq_linear");
}

#[test]
fn cubic() {
    curve("bspline_lsq_cubic");
}

#[test]
fn cubic_with_weights() {
    curve("bspline_lsq_cubic_weighted");
}

#[test]
fn bicubic_on_a_grid() {
    let file = reference("tensor_bspline_lsq_grid");
    let (u, v, z) = (numbers(&file["x"]), numbers(&file["y"]), table(&file["z_rows_over_x"]).concat());
    let (in_u, in_v) = (numbers(&file["knots_x"]), numbers(&file["knots_y"]));
    let places = crossings(&u, &v);
    let axis = |k: usize| places.iter().map(|p| p[k]).collect::<Vec<f64>>();
    let truth: Vec<Big> = file["coef_dec"].as_array().expect("rows").iter().flat_map(decimals).collect();
    let exact = exact_of(&surface([Basis::BSpline(&in_u), Basis::BSpline(&in_v)], [3, 3], &places, |_, _| true), &z);
    let model = Model::BSpline { degree: Degree::Each(3, 3), knots: Knots::Surface(in_u, in_v), weights: None };
    let grid = Nodes::grid(u, v, z.clone(), None, None).expect("checked nodes");
    let scattered = Nodes::scattered(axis(0), axis(1), z, None).expect("checked nodes");
    for (name, nodes) in [("bicubic grid", grid), ("bicubic scattered", scattered)] {
        let result = answer(&nodes, &plain(model.clone()));
        // Some coefficients are a thousandth of the surface's height and lose that many digits.
        at_least(name, &values(&result), &truth, 12.0);
        judge_digits(name, &result, &exact, 14.0);
        let near = |a: f64, b: &str| (a - number(&file[b])).abs() <= 1e-12 * number(&file[b]);
        assert!(near(result.residuals.rss, "rss") && near(result.residuals.sigma.unwrap(), "residual_sd"));
    }
}
