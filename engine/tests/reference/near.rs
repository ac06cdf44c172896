//! Least-squares B-splines as shapes: values and derivatives of the curve, and the bicubic surface
//! from the same nodes scattered.

use crate::answers::plain;
use crate::folder::{number, numbers, reference, table};
use flankfit_engine::estimation::near::{
    CurvePoints, CurveSettings, KnotPlacement, Parameters, SurfaceInclude, SurfacePoints, curve, surface,
};
use flankfit_engine::estimation::spec::{Degree, Knots, Model};
use flankfit_engine::geometry::curve::Curve;
use flankfit_engine::geometry::surface::Surface;

fn close(what: &str, got: f64, truth: f64, scale: f64) {
    assert!((got - truth).abs() <= 2e-13 * scale, "{what}: {got} {truth}");
}

#[test]
fn curves_with_given_knots() {
    for name in ["bspline_lsq_linear", "bspline_lsq_cubic", "bspline_lsq_cubic_weighted"] {
        let file = reference(name);
        let (x, y) = (numbers(&file["x"]), [numbers(&file["y"])]);
        let degree = file["degree"].as_u64().expect("a degree") as usize;
        let weight = (!file["weights"].is_null()).then(|| numbers(&file["weights"]));
        let points = CurvePoints { coordinates: &y, parameters: Parameters::Given(&x), weight: weight.as_deref() };
        let knots = KnotPlacement::Given(numbers(&file["knots"]));
        let asked = CurveSettings { degree, knots, weights: None, spec: plain(Model::Linear) };
        let found = curve(&points, &asked).expect("a curve");
        for (control, truth) in found.curve.control_points().iter().zip(numbers(&file["coef"])) {
            close(name, control.x, truth, 1.0);
        }
        let orders = ["value", "derivative_1", "derivative_2", "derivative_3"];
        for (i, t) in numbers(&file["t"]).into_iter().enumerate() {
            let jet = found.curve.jet(t);
            for (order, key) in orders.iter().enumerate().filter(|(_, key)| !file[**key].is_null()) {
                let truths = numbers(&file[*key]);
                // derivatives differ at the knots of a lower degree by the side that is meant
                if order < degree {
                    close(key, jet[order].x, truths[i], 1.0 + truths.iter().fold(0.0, |a: f64, b| a.max(b.abs())));
                }
            }
        }
        close("rss", found.results[0].residuals.rss, number(&file["rss"]), number(&file["rss"]));
    }
}

#[test]
fn a_bicubic_surface_from_scattered_nodes() {
    let file = reference("tensor_bspline_lsq_grid");
    let (x, y, z) = (numbers(&file["x"]), numbers(&file["y"]), table(&file["z_rows_over_x"]));
    let (mut u, mut v) = (Vec::new(), Vec::new());
    for a in &x {
        for b in &y {
            u.push(*a);
            v.push(*b);
        }
    }
    let knots = Knots::Surface(numbers(&file["knots_x"]), numbers(&file["knots_y"]));
    let spec = plain(Model::BSpline { degree: Degree::Each(3, 3), knots, weights: None });
    let heights = [z.concat()];
    let points = SurfacePoints { u: &u, v: &v, coordinates: &heights, weight: None };
    let found = surface(&points, &spec, SurfaceInclude::default()).expect("a surface");
    for (control, truth) in found.surface.control_points().iter().zip(table(&file["coef"]).concat()) {
        close("coefficient", control.x, truth, 1.0);
    }
    close("rss", found.coordinates[0].rss, number(&file["rss"]), number(&file["rss"]));
    close("sd", found.coordinates[0].sigma.expect("σ"), number(&file["residual_sd"]), number(&file["residual_sd"]));
    for sample in file["samples"].as_array().expect("samples") {
        let jet = found.surface.jet(number(&sample["x"]), number(&sample["y"]));
        let got =
            [("d00", jet.value), ("d10", jet.u), ("d01", jet.v), ("d20", jet.uu), ("d11", jet.uv), ("d02", jet.vv)];
        got.iter().for_each(|(key, value)| close(key, value.x, number(&sample[*key]), 4.0));
    }
}
