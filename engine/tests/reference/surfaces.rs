//! Patches against exactly computed points, derivatives, normals and curvatures.

use crate::folder::{number, numbers, reference, table};
use flankfit_engine::geometry::{
    BSplineBasis,
    curve::{BSplineCurve, CurveShape},
    space::{Dimension, Vector},
    surface::{
        BezierSurface, Boundaries, CoonsPatch, Differential, GregoryPatch, NodeGrid, Surface,
        coons::Twists,
        gregory::GregoryNet,
        least_squares::{AxisKnots, least_squares},
    },
};
use serde_json::Value;

const UNIT: [[f64; 2]; 2] = [[0.0, 1.0]; 2];

fn point(value: &Value) -> Vector {
    Vector::from_column_slice(&numbers(value))
}

fn net(value: &Value) -> Vec<Vector> {
    value.as_array().expect("rows").iter().flat_map(|row| row.as_array().expect("points")).map(point).collect()
}

/// A fraction such as `-59/36`.
fn fraction(value: &Value) -> f64 {
    let text = value.as_str().expect("a fraction");
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    above.parse::<f64>().expect("a number") / below.parse::<f64>().expect("a number")
}

fn near(what: &str, got: Vector, truth: Vector, digits: f64) {
    let off = (got - truth).norm();
    assert!(off <= 10f64.powf(-digits) * truth.norm().max(1.0), "{what}: {got:?} is not {truth:?}");
}

fn samples(file: &Value) -> impl Iterator<Item = (f64, f64, &Value)> {
    let all = file["samples"].as_array().expect("samples");
    all.iter().map(|s| (number(&s["u"]), number(&s["v"]), s))
}

#[test]
fn bicubic_bezier_patch() {
    let file = reference("bezier_patch_bicubic");
    let patch = BezierSurface::new([4, 4], UNIT, Dimension::Space, net(&file["control_net"]), None).expect("a net");
    for (u, v, sample) in samples(&file) {
        let jet = patch.jet(u, v);
        let derivatives =
            [("S", jet.value), ("S_u", jet.u), ("S_v", jet.v), ("S_uu", jet.uu), ("S_uv", jet.uv), ("S_vv", jet.vv)];
        for (name, got) in derivatives {
            near(name, got, point(&sample[name]), 14.0);
        }
        let shape = Differential::at(&patch, u, v).expect("a regular place");
        near("normal", shape.normal, point(&sample["unit_normal"]), 14.5);
        for (got, name) in [(shape.gaussian, "gaussian_curvature"), (shape.mean, "mean_curvature")] {
            let truth = number(&sample[name]);
            assert!((got - truth).abs() <= 1e-14 * truth.abs().max(1.0), "{name} {got} {truth}");
        }
        let [high, low] = shape.principal;
        assert!((high * low - shape.gaussian).abs() < 1e-14 && (0.5 * (high + low) - shape.mean).abs() < 1e-14);
    }
}

#[test]
fn a_bezier_patch_of_higher_degree() {
    let file = reference("bezier_patch_bicubic");
    let patch = BezierSurface::new([4, 4], UNIT, Dimension::Space, net(&file["control_net"]), None).expect("a net");
    let raised = patch.as_b_spline().elevate(0, 1).expect("a degree of 4");
    let rows = file["degree_elevated_u_net_fraction"].as_array().expect("rows");
    let truth = rows.iter().flat_map(|row| row.as_array().expect("points"));
    assert_eq!(raised.control_points().len(), 20);
    for (got, truth) in raised.control_points().iter().zip(truth) {
        // every fraction has a denominator that is a power of two
        assert_eq!(*got, Vector::from_iterator(truth.as_array().expect("coordinates").iter().map(fraction)));
    }
}

fn cubic(points: &Value) -> CurveShape {
    let basis = BSplineBasis::uniform(3, 1, 0.0, 1.0).expect("one span");
    let points = table(points).iter().map(|p| Vector::from_column_slice(p)).collect();
    CurveShape::BSpline(BSplineCurve::new(basis, Dimension::Space, points, None).expect("a cubic"))
}

#[test]
fn bilinear_coons_patch_of_cubics() {
    let file = reference("coons_bilinear_cubic_boundaries");
    let curves = ["D0", "D1", "C0", "C1"].map(|name| cubic(&file[name]));
    let boundaries = Boundaries::new(curves, 0.0).expect("curves that meet");
    let patch = CoonsPatch::bilinear(boundaries.clone());
    for (u, v, sample) in samples(&file) {
        let jet = patch.jet(u, v);
        for (name, got) in [("S", jet.value), ("S_u", jet.u), ("S_v", jet.v)] {
            near(name, got, point(&sample[name]), 14.5);
        }
    }
    // the equivalent Bézier net, and the same net filled again from its borders and its own twists
    // and cross derivatives
    let rows = file["equivalent_bicubic_bezier_net_fraction"].as_array().expect("rows");
    let exact: Vec<Vector> = rows
        .iter()
        .flat_map(|row| row.as_array().expect("points"))
        .map(|p| Vector::from_iterator(p.as_array().expect("coordinates").iter().map(fraction)))
        .collect();
    let bezier = BezierSurface::new([4, 4], UNIT, Dimension::Space, exact, None).expect("a net");
    let twists = std::array::from_fn(|i| std::array::from_fn(|j| bezier.jet(i as f64, j as f64).uv));
    let bicubic = |twists| CoonsPatch::bicubic(boundaries.clone(), [const { None }; 4], &twists, 0.0).expect("a patch");
    for patch_of in [bicubic(Twists::Adini), bicubic(Twists::Given(twists))] {
        for k in 0..=60 {
            let (u, v) = (f64::from(k * 7 % 61) / 60.0, f64::from(k) / 60.0);
            let (one, other) = (patch.jet(u, v), bezier.jet(u, v));
            near("value", one.value, other.value, 14.5);
            near("uv", one.uv, other.uv, 13.5);
            near("vv", one.vv, other.vv, 13.0);
            near("bicubically blended", patch_of.value(u, v), other.value, 14.5);
        }
    }
}

#[test]
fn gregory_patch() {
    let file = reference("gregory_patch_bicubic");
    let flat = net(&file["boundary_and_corner_net"]);
    let mut points =
        GregoryNet { net: std::array::from_fn(|i| std::array::from_fn(|j| flat[4 * i + j])), b: Default::default() };
    let pairs = &file["inner_pairs_a_b"];
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let pair = table(&pairs[format!("{}{}", i + 1, j + 1)]);
        points.net[i + 1][j + 1] = Vector::from_column_slice(&pair[0]);
        points.b[i][j] = Vector::from_column_slice(&pair[1]);
    }
    let patch = GregoryPatch::new(UNIT, Dimension::Space, points).expect("a net");
    for (u, v, sample) in samples(&file) {
        near("S", patch.value(u, v), point(&sample["S"]), 14.5);
    }
    let across = &file["cross_boundary_derivative_u0"];
    near("S_u", patch.jet(0.0, fraction(&across["v_fraction"])).u, point(&across["S_u"]), 14.5);
}

#[test]
fn bicubic_least_squares_on_a_grid() {
    let file = reference("tensor_bspline_lsq_grid");
    let z = table(&file["z_rows_over_x"]).concat();
    let grid = NodeGrid::heights(numbers(&file["x"]), numbers(&file["y"]), &z).expect("a grid");
    let knots = ["knots_x", "knots_y"].map(|name| AxisKnots::Given(numbers(&file[name])));
    let (surface, rss) = least_squares(&grid, [3, 3], knots).expect("a fit");
    let truth = file["coef"].as_array().expect("rows").iter().flat_map(numbers);
    for (got, truth) in surface.control_points().iter().zip(truth) {
        // the reference has decimal heights; as doubles they leave the smallest coefficient its
        // first 13 digits
        assert!((got.x - truth).abs() <= 1e-13 * truth.abs(), "{} {truth}", got.x);
    }
    assert!((rss - number(&file["rss"])).abs() <= 1e-13 * rss);
    for sample in file["samples"].as_array().expect("samples") {
        let jet = surface.jet(number(&sample["x"]), number(&sample["y"]));
        for (name, got) in
            [("d00", jet.value), ("d10", jet.u), ("d01", jet.v), ("d20", jet.uu), ("d11", jet.uv), ("d02", jet.vv)]
        {
            let truth = number(&sample[name]);
            assert!((got.x - truth).abs() <= 5e-14 * truth.abs().max(1e-1), "{name} {} {truth}", got.x);
        }
    }
}
