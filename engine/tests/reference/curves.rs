//! Curves through points: polynomials, piecewise cubics, splines, B-splines and circles, against
//! exactly computed values.

use crate::folder::{number, numbers, reference, table};
use flankfit_engine::geometry::BSplineBasis;
use flankfit_engine::geometry::curve::{
    BSplineCurve, Curve, End, Ends, KnotChoice, PiecewisePolynomial, Polynomial, Tangents, cubic_hermite, cubic_spline,
    interpolate, polynomial::Form,
};
use flankfit_engine::geometry::space::{Dimension, Vector};
use serde_json::Value;

fn graph(y: &[f64]) -> Vec<Vector> {
    y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect()
}

/// Compared with the largest of the true values: they are sums in which the smaller ones cancel.
fn assert_near(what: &str, got: &[f64], truth: &[f64], tolerance: f64) {
    let largest = truth.iter().fold(0.0f64, |m, t| m.max(t.abs()));
    assert_eq!(got.len(), truth.len(), "{what}");
    for (i, (got, truth)) in got.iter().zip(truth).enumerate() {
        let miss = (got - truth).abs();
        assert!(miss <= tolerance * largest.max(f64::MIN_POSITIVE), "{what} {i}: {got:e} for {truth:e}");
    }
}

/// Values and derivatives at the file's places, as far as it has them.
fn assert_curve(what: &str, curve: &impl Curve, places: &[f64], truth: &Value, tolerance: f64) {
    let names =
        [("value", 0), ("derivative", 1), ("first_derivative", 1), ("second_derivative", 2), ("third_derivative", 3)];
    for (name, order) in names {
        if truth[name].is_null() {
            continue;
        }
        let got: Vec<f64> = places.iter().map(|t| curve.jet(*t)[order].x).collect();
        assert_near(&format!("{what} {name}"), &got, &numbers(&truth[name]), tolerance);
    }
    let values: Vec<f64> = places.iter().map(|t| curve.value(*t).x).collect();
    assert_near(what, &values, &numbers(&truth["value"]), tolerance);
}

/// Every coefficient to 14 digits of the largest of its power.
fn assert_pieces(what: &str, curve: &PiecewisePolynomial, truth: &Value) {
    let truth: Vec<Vec<f64>> = match truth["coef_local_powers"].is_null() {
        false => table(&truth["coef_local_powers"]),
        true => {
            let texts = truth["coef_local_powers_dec"].as_array().expect("rows");
            let row = |row: &Value| row.as_array().expect("a row").iter().map(decimal).collect();
            texts.iter().map(row).collect()
        }
    };
    for power in 0..4 {
        let got: Vec<f64> = (0..truth.len()).map(|i| curve.piece(i)[power].x).collect();
        let exact: Vec<f64> = truth.iter().map(|row| row[power]).collect();
        assert_near(&format!("{what} power {power}"), &got, &exact, 1e-14);
    }
}

fn decimal(text: &Value) -> f64 {
    text.as_str().expect("a decimal").parse().expect("a number")
}

/// The integral of a piecewise cubic by its coefficients.
fn integral(curve: &PiecewisePolynomial) -> f64 {
    let piece = |i: usize| {
        let h = curve.places()[i + 1] - curve.places()[i];
        curve.piece(i).iter().enumerate().map(|(k, c)| c.x * h.powi(k as i32 + 1) / (k + 1) as f64).sum::<f64>()
    };
    (0..curve.places().len() - 1).map(piece).sum()
}

#[test]
fn polynomials_through_points() {
    for name in ["lagrange_30_40mm_8", "lagrange_runge_equispaced_11", "newton_bessel_burden_faires"] {
        let file = reference(name);
        let (x, y) = (numbers(&file["x"]), graph(&numbers(&file["y"])));
        let lagrange = Polynomial::lagrange(Dimension::Graph, x.clone(), y.clone()).expect("a polynomial");
        let newton = Polynomial::newton(Dimension::Graph, &x, &y).expect("a polynomial");
        let places = numbers(&file["t"]);
        // x = 1/7 of the file is no double, and the slope there is 3.5
        assert_curve(name, &lagrange, &places, &file, 1e-13);
        assert_curve(name, &newton, &places, &file, 1e-13);
        let Form::Barycentric(form) = lagrange.form() else { panic!("barycentric") };
        assert_near("weights", form.weights(), &numbers(&file["barycentric_weights"]), 1e-14);
        let Form::Newton(form) = newton.form() else { panic!("Newton") };
        let differences: Vec<f64> = form.differences().iter().map(|c| c[0].to_f64()).collect();
        for (got, truth) in differences.iter().zip(numbers(&file["newton_divided_differences"])) {
            // the given doubles differ from the file's fractions, and high differences feel that
            assert!((got - truth).abs() <= 1e-11 * truth.abs(), "{name} {got:e} {truth:e}");
        }
    }
}

#[test]
fn hermite_polynomials() {
    for name in ["hermite_mixed", "hermite_runge_7_first"] {
        let file = reference(name);
        let data: Vec<Vec<Vector>> = table(&file["data_per_node"]).iter().map(|d| graph(d)).collect();
        let hermite = Polynomial::hermite(Dimension::Graph, &numbers(&file["x"]), &data).expect("a polynomial");
        assert_curve(name, &hermite, &numbers(&file["t"]), &file, 1e-13);
        let Form::Newton(form) = hermite.form() else { panic!("Newton") };
        assert_eq!(form.nodes(), numbers(&file["newton_nodes_z"]));
        let differences: Vec<f64> = form.differences().iter().map(|c| c[0].to_f64()).collect();
        assert_near(name, &differences, &numbers(&file["newton_coef"]), 1e-13);
    }
}

#[test]
fn piecewise_cubic_hermite() {
    let file = reference("cubic_hermite_akima");
    let (x, y, places) = (numbers(&file["x"]), graph(&numbers(&file["y"])), numbers(&file["t"]));
    for case in file["interpolants"].as_array().expect("cases") {
        let name = case["method"].as_str().expect("a name");
        let slopes = numbers(&case["slopes"]);
        let rule = match name {
            "pchip" => Tangents::Monotone,
            "akima" => Tangents::Akima,
            "makima" => Tangents::ModifiedAkima,
            "finite_difference" => Tangents::FiniteDifference,
            "three_point_parabola" => Tangents::Parabola,
            other => panic!("an unknown rule {other}"),
        };
        for tangents in [rule, Tangents::Given(graph(&slopes))] {
            let curve = cubic_hermite(Dimension::Graph, &x, &y, &tangents).expect("a curve");
            let got: Vec<f64> = x.iter().map(|x| curve.jet(*x)[1].x).collect();
            assert_near(name, &got, &slopes, 1e-14);
            assert_pieces(name, &curve, case);
            assert_curve(name, &curve, &places, case, 1e-14);
            assert!((integral(&curve) - number(&case["integral"])).abs() < 1e-12);
        }
    }
}

#[test]
fn cubic_splines() {
    for name in ["akima", "exp_burden_faires", "n2_minimal", "n3_minimal", "n4_minimal", "runge11"] {
        let file = reference(&format!("cubic_spline_{name}"));
        let (x, y, places) = (numbers(&file["x"]), graph(&numbers(&file["y"])), numbers(&file["t"]));
        for case in file["splines"].as_array().expect("cases") {
            let kind = case["bc"].as_str().expect("a name");
            let given = || graph(&numbers(&case["bc_values"]));
            let ends = match kind {
                "natural" => Ends::natural(),
                "notaknot" => Ends::not_a_knot(),
                "periodic" => Ends::Periodic,
                "clamped" => Ends::clamped(given()[0], given()[1]),
                "second" => Ends::second_derivatives(given()[0], given()[1]),
                "mixed" => Ends::Each { start: End::Slope(given()[0]), end: End::SecondDerivative(given()[1]) },
                other => panic!("an unknown end {other}"),
            };
            let spline = cubic_spline(Dimension::Graph, &x, &y, &ends).expect("a spline");
            let what = format!("{name} {kind}");
            let slopes: Vec<f64> = x.iter().map(|x| spline.jet(*x)[1].x).collect();
            assert_near(&what, &slopes, &numbers(&case["slopes_at_nodes"]), 1e-14);
            assert_pieces(&what, &spline, case);
            assert_curve(&what, &spline, &places, case, 1e-14);
            assert!((integral(&spline) / number(&case["integral"]) - 1.0).abs() < 1e-14, "{what}");
        }
    }
}

#[test]
fn b_spline_basis() {
    for name in ["cubic_nonuniform_multiple", "linear", "nurbs_book_2_2"] {
        let file = reference(&format!("bspline_basis_{name}"));
        let degree = file["degree"].as_u64().expect("a degree") as usize;
        let basis = BSplineBasis::new(degree, numbers(&file["knots"])).expect("knots");
        assert_eq!(basis.size() as u64, file["n_basis"].as_u64().expect("a number"));
        for row in file["table"].as_array().expect("rows") {
            let t = number(&row["t"]);
            for order in 0..=degree {
                let truth = numbers(&row[format!("d{order}")]);
                let mut values = vec![0.0; degree + 1];
                let first = basis.derivatives_of(order, t, &mut values);
                let mut all = vec![0.0; basis.size()];
                all[first..=first + degree].copy_from_slice(&values);
                assert_near(&format!("{name} {t} order {order}"), &all, &truth, 1e-13);
            }
        }
    }
}

#[test]
fn b_spline_through_points() {
    let file = reference("bspline_interp_notaknot");
    let (x, y, places) = (numbers(&file["x"]), graph(&numbers(&file["y"])), numbers(&file["t"]));
    let knots = numbers(&file["knots"]);
    for choice in [KnotChoice::NotAKnot, KnotChoice::Given(knots.clone())] {
        let curve = interpolate(Dimension::Graph, &x, &y, 3, &choice).expect("a curve");
        assert_eq!(curve.basis().knots(), knots);
        let controls: Vec<f64> = curve.control_points().iter().map(|p| p.x).collect();
        assert_near("control points", &controls, &numbers(&file["coef"]), 1e-15);
        assert_curve("notaknot", &curve, &places, &file, 1e-14);
    }
    let spline = cubic_spline(Dimension::Graph, &x, &y, &Ends::not_a_knot()).expect("a spline");
    assert_curve("the spline", &spline, &places, &file, 1e-14);
}

#[test]
fn circles() {
    let file = reference("nurbs_circle");
    let decimals = |v: &Value| -> Vec<Vec<f64>> {
        let row = |r: &Value| r.as_array().expect("a row").iter().map(decimal).collect();
        v.as_array().expect("rows").iter().map(row).collect()
    };
    for case in file["curves"].as_array().expect("cases") {
        let what = case["description"].as_str().expect("a text");
        let degree = case["degree"].as_u64().expect("a degree") as usize;
        let basis = BSplineBasis::new(degree, numbers(&case["knots"])).expect("knots");
        let points = table(&case["control_points"]).iter().map(|p| Vector::new(p[0], p[1], 0.0)).collect();
        let curve = BSplineCurve::new(basis, Dimension::Plane, points, Some(numbers(&case["weights"]))).expect(what);
        let truths = [
            decimals(&case["points_dec"]),
            decimals(&case["first_derivative_dec"]),
            decimals(&case["second_derivative_dec"]),
        ];
        for (i, t) in numbers(&case["t"]).into_iter().enumerate() {
            let jet = curve.jet(t);
            assert!((jet[0].norm() - 1.0).abs() < 1e-15 && (curve.value(t).norm() - 1.0).abs() < 1e-15, "{what} {t}");
            for (order, truth) in truths.iter().enumerate() {
                // the derivatives of the seven-point circle jump at knots that are no doubles
                if order > 0 && curve.breaks().contains(&t) {
                    continue;
                }
                let truth = Vector::new(truth[i][0], truth[i][1], 0.0);
                let miss = (jet[order] - truth).amax();
                assert!(miss <= 2e-14 * truth.amax(), "{what} {t} order {order}: {miss:e}");
            }
        }
    }
}
