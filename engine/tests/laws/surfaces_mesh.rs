//! Laws of meshes of curves, of the continuity between patches, of conversions to B-splines, and of
//! the entry point to all surfaces.

use crate::surfaces::{boundary_curves, revolved, vector};
use flankfit_engine::geometry::{
    BSplineBasis,
    curve::{BSplineCurve, Curve, CurveShape, KnotChoice, Parametrization, interpolate::interpolate},
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, Boundaries, Built, CoonsPatch, Given, Method, Patchwork, Surface, SurfaceShape, build,
        construct::Net,
        continuity::{ContinuityClass, ContinuityTolerance, joints},
        coons::Twists,
        gregory_fill::gregory,
        least_squares::AxisKnots,
        mesh::{CurveMesh, Fill},
    },
};
use proptest::prelude::*;

const TOLERANCE: ContinuityTolerance = ContinuityTolerance { gap: 1e-11, angle: 1e-9, first: 1e-9, second: 1e-7 };

/// Cubic splines through the heights of `f` on lines of u and of v.
fn mesh_of(f: impl Fn(f64, f64) -> f64, us: &[f64], vs: &[f64]) -> CurveMesh {
    // more nodes on the curves than there are crossings
    let fine = |places: &[f64]| -> Vec<f64> {
        let parts = |w: &[f64]| [w[0], 0.7 * w[0] + 0.3 * w[1], 0.4 * w[0] + 0.6 * w[1]];
        places.windows(2).flat_map(parts).chain(places.last().copied()).collect()
    };
    let curve = |places: &[f64], value: &dyn Fn(f64) -> f64| {
        let places = fine(places);
        let values: Vec<Vector> = places.iter().map(|t| Vector::new(value(*t), 0.0, 0.0)).collect();
        let curve = interpolate(Dimension::Graph, &places, &values, 3, &KnotChoice::NotAKnot).unwrap();
        Some(CurveShape::BSpline(curve))
    };
    CurveMesh {
        us: us.to_vec(),
        vs: vs.to_vec(),
        over_v: us.iter().map(|u| curve(vs, &|v| f(*u, v))).collect(),
        over_u: vs.iter().map(|v| curve(us, &|u| f(u, *v))).collect(),
    }
}

/// Curves that are 0.002 apart where they cross: corners lie half-way, off both by 0.001, for every
/// kind of patch.
#[test]
fn a_gap_at_the_crossings_is_a_deviation_from_the_curves() {
    let (us, vs) = ([0.0, 0.5, 1.2], [1.0, 1.7, 2.2]);
    let mut mesh = mesh_of(|u, v| 0.3 * (u + v).sin(), &us, &vs);
    let apart = mesh_of(|u, v| 0.3 * (u + v).sin() + 0.002, &us, &vs);
    mesh.over_u = apart.over_u;
    for fill in [Fill::CoonsBilinear, Fill::CoonsBicubic, Fill::CoonsBicubicFlat, Fill::Gregory, Fill::Bezier] {
        let filled = mesh.fill(fill, 0.01).unwrap();
        assert!((filled.gap.value - 0.002).abs() < 1e-12);
        let off = filled.deviation.value;
        assert!(off > 0.001 - 1e-9 && off < 0.0015, "{fill:?} {off}");
        let mut worst = 0.0f64;
        for (u, curve) in us.iter().zip(&mesh.over_v) {
            for k in 0..=96 {
                let v = 1.0 + 1.2 * f64::from(k) / 96.0;
                worst = worst.max((filled.patchwork.value(*u, v) - curve.as_ref().unwrap().value(v)).norm());
            }
        }
        assert!(worst <= off + 1e-6, "{fill:?} {worst} {off}");
    }
}

/// A Gregory patch of three sides as a B-spline within a millionth of its extent, which files take
/// by default.
#[test]
fn three_sided_gregory_patches_are_approached_closely() {
    let curve = |points: [[f64; 3]; 4]| {
        let points = points.map(Vector::from).to_vec();
        let basis = BSplineBasis::uniform(3, 1, 0.0, 1.0).unwrap();
        Some(CurveShape::BSpline(BSplineCurve::new(basis, Dimension::Space, points, None).unwrap()))
    };
    let left = curve([[0., 0., 0.], [1., 3., 2.], [2., 6., 3.], [5., 10., 0.]]);
    let right = curve([[10., 0., 1.], [9., 3., 3.], [8., 6., 2.], [5., 10., 0.]]);
    let bottom = curve([[0., 0., 0.], [3., -1., 1.], [7., 1., -2.], [10., 0., 1.]]);
    let boundaries = Boundaries::three_sided([left, right, bottom, None], 1e-9).unwrap();
    let (patch, _) = gregory(&boundaries, &[const { None }; 4], 1e-9).unwrap();
    assert!(!patch.is_polynomial());
    let found = SurfaceShape::Gregory(Box::new(patch.clone())).to_b_splines(1e-5);
    assert!(found.len() == 1 && found[0].deviation <= 1e-5, "{}", found[0].deviation);
    // also where it was not looked at: next to corners, where it is hardest
    let mut worst = 0.0f64;
    for i in 0..300 {
        for j in 0..300 {
            let at = |k: i32| (f64::from(k) / 300.0).powi(2);
            for (u, v) in [(at(i), at(j)), (1.0 - at(i), 1.0 - at(j)), (at(i), 1.0 - at(j)), (1.0 - at(i), at(j))] {
                worst = worst.max((found[0].surface.value(u, v) - patch.value(u, v)).norm());
            }
        }
    }
    assert!(worst < 1.5e-5, "{worst}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Whatever the filling: curves kept (or met by cubics at the nodes), and smooth across lines
    /// where that is promised.
    #[test]
    fn filled_meshes_keep_their_curves_and_join_smoothly(c in prop::collection::vec(-1.0..1.0f64, 4)) {
        let f = |u: f64, v: f64| c[0] * (u + c[1] * v).sin() + c[2] * (u * v).cos() + c[3] * u * u * v;
        let (us, vs) = ([0.0, 0.5, 1.2, 2.0], [1.0, 1.7, 2.2]);
        let mesh = mesh_of(f, &us, &vs);
        for fill in [Fill::CoonsBilinear, Fill::CoonsBicubic, Fill::CoonsBicubicFlat, Fill::Gregory, Fill::Bezier] {
            let filled = mesh.fill(fill, 1e-9).unwrap();
            let cubic_borders = matches!(fill, Fill::Gregory | Fill::Bezier);
            prop_assert!(filled.gap.value < 1e-13);
            prop_assert_eq!(filled.patchwork.patches().len(), 6);
            for (u, curve) in us.iter().zip(&mesh.over_v) {
                for k in 0..=20 {
                    let v = 1.0 + 1.2 * f64::from(k) / 20.0;
                    let off = (filled.patchwork.value(*u, v) - curve.as_ref().unwrap().value(v)).norm();
                    prop_assert!(off < if cubic_borders { filled.deviation.value + 1e-13 } else { 1e-13 }, "{fill:?} \
                        {u} {v} {off}");
                }
            }
            let found = joints(&filled.patchwork, 7);
            let lines = [us.to_vec(), vs.to_vec()];
            for joint in found.iter().filter(|j| lines[j.axis].contains(&j.at)) {
                let class = joint.class(&TOLERANCE);
                let promised = if fill == Fill::CoonsBilinear { ContinuityClass::C0 } else { ContinuityClass::C1 };
                prop_assert!(class >= promised, "{fill:?} {joint:?}");
            }
        }
    }

    /// Conversions are the same surface: exactly where they say so, else within what they say.
    #[test]
    fn converted_surfaces_are_the_surface(curves in boundary_curves(), inner in prop::collection::vec(vector(), 8),
        (s, t) in (0.0..1.0f64, 0.0..1.0f64)) {
        let boundaries = Boundaries::new(curves.map(CurveShape::BSpline), 1e-13).unwrap();
        let none = [const { None }; 4];
        let bilinear = CoonsPatch::bilinear(boundaries.clone());
        let bicubic = CoonsPatch::bicubic(boundaries.clone(), none.clone(), &Twists::Adini, 1e-12).unwrap();
        for patch in [bilinear, bicubic] {
            let shape = SurfaceShape::Coons(Box::new(patch.clone()));
            let found = shape.to_b_splines(1e-6);
            prop_assert_eq!((found.len(), found[0].deviation), (1, 0.0));
            let [[a, b], [c, d]] = patch.domain();
            let (u, v) = (a + s * (b - a), c + t * (d - c));
            let (one, other) = (patch.jet(u, v), found[0].surface.jet(u, v));
            prop_assert!((one.value - other.value).norm() < 2e-14, "{:?} {:?}", one.value, other.value);
            prop_assert!((one.u - other.u).norm() < 1e-11 && (one.v - other.v).norm() < 1e-11);
        }
        // incompatible twists: rational, hence approached
        let domain = boundaries.domain();
        let bent = |k: usize| {
            let border = flankfit_engine::geometry::surface::Border::ALL[k];
            let [low, high] = domain[border.axis()];
            let flat = CoonsPatch::bilinear(boundaries.clone());
            let end = |t: f64| {
                let (u, v) = border.place(domain, t);
                let jet = flat.jet(u, v);
                if border.axis() == 1 { jet.u } else { jet.v }
            };
            let basis = BSplineBasis::uniform(3, 1, low, high).unwrap();
            let points = vec![end(low), inner[2 * k], inner[2 * k + 1], end(high)];
            Some(CurveShape::BSpline(BSplineCurve::new(basis, Dimension::Space, points, None).unwrap()))
        };
        let cross = [bent(0), bent(1), bent(2), bent(3)];
        let (patch, _) = gregory(&boundaries, &cross, 1e-10).unwrap();
        let shape = SurfaceShape::Gregory(Box::new(patch.clone()));
        let found = shape.to_b_splines(1e-3);
        prop_assert!(found.len() == 1 && found[0].deviation > 0.0 && found[0].deviation <= 1e-3);
        let [[a, b], [c, d]] = patch.domain();
        let (u, v) = (a + s * (b - a), c + t * (d - c));
        prop_assert!((patch.value(u, v) - found[0].surface.value(u, v)).norm() < 1.5e-3);
        // across each border the Gregory patch takes the derivative given there at its ends
        let jet = patch.jet(a, c);
        let [value, slope, _, _] = cross[0].as_ref().unwrap().jet(c);
        prop_assert!((jet.u - value).norm() < 1e-12);
        let h = 1e-6 * (d - c);
        prop_assert!(((patch.jet(a, c + h).u - jet.u) / h - slope).norm() < 1e-3 * slope.norm().max(1.0));
    }
}

#[test]
fn a_kink_is_found_where_it_is() {
    // heights |u − 1| over a cubic basis with a knot of multiplicity 3 at 1
    let u = BSplineBasis::new(3, vec![0., 0., 0., 0., 1., 1., 1., 2., 2., 2., 2.]).unwrap();
    let v = BSplineBasis::uniform(1, 2, 0.0, 1.0).unwrap();
    let heights = [1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
    let points = heights.iter().flat_map(|z| [Vector::x() * *z; 3]).collect();
    let roof = BSplineSurface::new([u, v], Dimension::Graph, points, None).unwrap();
    let found = joints(&roof, 4);
    let edge: Vec<_> = found.iter().filter(|j| j.axis == 0).collect();
    assert_eq!(edge.len(), 2);
    for joint in edge {
        assert!(joint.at == 1.0 && joint.gap.value < 1e-14);
        assert!((joint.normal_angle.unwrap().value - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((joint.first_derivative.value - 2.0).abs() < 1e-12);
        assert_eq!(joint.class(&TOLERANCE), ContinuityClass::C0);
    }
    assert!(found.iter().filter(|j| j.axis == 1).all(|j| j.class(&TOLERANCE) == ContinuityClass::C2));
    // two cylinders' quarters that share a line but not its parameter's speed: one tangent plane
    let arc = |low: f64, high: f64, stretch: f64| {
        let line = |x: f64| [Vector::new(x, 0.0, 0.0), Vector::new(x, 1.0, 0.0)];
        let bases = [BSplineBasis::uniform(1, 1, low, high).unwrap(), BSplineBasis::uniform(1, 1, 0.0, 1.0).unwrap()];
        let points = [line(low), line(low + stretch)].concat();
        SurfaceShape::BSpline(BSplineSurface::new(bases, Dimension::Space, points, None).unwrap())
    };
    let plane =
        |second: SurfaceShape| Patchwork::new(vec![0.0, 1.0, 2.0], vec![0.0, 1.0], vec![arc(0.0, 1.0, 1.0), second]);
    let class = |work: &Patchwork| joints(work, 3)[0].class(&TOLERANCE);
    assert_eq!(class(&plane(arc(1.0, 2.0, 3.0)).unwrap()), ContinuityClass::G1);
    assert_eq!(class(&plane(arc(1.0, 2.0, 1.0)).unwrap()), ContinuityClass::C2);
    let apart = arc(1.0, 2.0, 1.0).to_b_splines(0.0).remove(0).surface;
    let points = apart.control_points().iter().map(|p| p + Vector::z() * 0.25).collect();
    let apart = BSplineSurface::new(apart.bases().clone(), Dimension::Space, points, None).unwrap();
    let apart = plane(SurfaceShape::BSpline(apart)).unwrap();
    assert_eq!(class(&apart), ContinuityClass::Apart);
    assert!((joints(&apart, 3)[0].gap.value - 0.25).abs() < 1e-13);

    let fault = plane(arc(1.0, 2.5, 1.0)).unwrap_err();
    let message = "patches[1][0]: patch 1 covers [[1.0, 2.5], [0.0, 1.0]], not its rectangle";
    assert!(fault.to_string().starts_with(message), "{fault}");
    assert_eq!(plane(SurfaceShape::BSpline(roof)).unwrap_err().list()[0].path, "patches[1][0]");
    let nested = SurfaceShape::Patchwork(plane(arc(1.0, 2.0, 1.0)).unwrap());
    let fault = Patchwork::new(vec![0.0, 2.0], vec![0.0, 1.0], vec![nested]).unwrap_err();
    assert_eq!(fault.to_string(), "patches[0][0]: patch 0 is a patchwork itself");
    let fault = Patchwork::new(vec![0.0, 2.0], vec![0.0, 1.0], vec![]).unwrap_err();
    assert_eq!(fault.to_string(), "patches: 0 patches for 1 × 1 rectangles");
}

/// A sphere's octant as a fan of curves from the equator to the pole, without a curve at the pole.
#[test]
fn a_mesh_whose_curves_run_together() {
    let sphere = revolved(&[[1.0, 0.0, 1.0], [1.0, 1.0, std::f64::consts::FRAC_1_SQRT_2], [0.0, 1.0, 1.0]]);
    let (us, vs) = (vec![0.0, 0.4, 1.0], vec![0.0, 0.5, 1.0]);
    let line = |places: &dyn Fn(f64) -> Vector| {
        let places: Vec<(f64, Vector)> = (0..=12).map(|k| f64::from(k) / 12.0).map(|t| (t, places(t))).collect();
        let (parameters, points): (Vec<f64>, Vec<Vector>) = places.into_iter().unzip();
        Some(CurveShape::BSpline(
            interpolate(Dimension::Space, &parameters, &points, 5, &KnotChoice::Averaging).unwrap(),
        ))
    };
    let mesh = CurveMesh {
        over_v: us.iter().map(|u| line(&|t| sphere.value(*u, t))).collect(),
        over_u: vs.iter().map(|v| if *v == 1.0 { None } else { line(&|t| sphere.value(t, *v)) }).collect(),
        us,
        vs,
    };
    for fill in [Fill::CoonsBilinear, Fill::CoonsBicubic, Fill::Gregory, Fill::Bezier] {
        let filled = mesh.fill(fill, 1e-4).unwrap();
        let built = build(Given::Mesh { mesh: mesh.clone(), tolerance: 1e-4 }, method_of(fill)).unwrap();
        assert_eq!(built.shape, SurfaceShape::Patchwork(filled.patchwork.clone()));
        assert_eq!(built.degenerate.len(), 1, "{fill:?}");
        assert!((built.degenerate[0].point - Vector::z()).norm() < 1e-13);
        for (u, v) in [(0.2, 0.3), (0.6, 0.8), (0.9, 0.95)] {
            assert!((filled.patchwork.value(u, v).norm() - 1.0).abs() < 0.03, "{fill:?}");
        }
    }
    let mut torn = mesh.clone();
    torn.over_u[1] = None;
    let missing = |mesh: CurveMesh| mesh.fill(Fill::Gregory, 1e-4).unwrap_err().to_string();
    assert!(missing(torn).starts_with("mesh.v_curves[1]: the curve is missing"));
    let mut torn = mesh.clone();
    torn.over_v[0] = None;
    assert!(missing(torn).contains("the curve is missing"));
}

fn method_of(fill: Fill) -> Method {
    match fill {
        Fill::CoonsBilinear => Method::CoonsBilinear,
        Fill::CoonsBicubic => Method::CoonsBicubic { twists: Twists::Adini },
        Fill::CoonsBicubicFlat => Method::CoonsBicubic { twists: Twists::Zero },
        Fill::Gregory => Method::Gregory,
        Fill::Bezier => Method::Bezier,
    }
}

#[test]
fn refused_meshes() {
    let (us, vs) = ([0.0, 1.0, 2.0], [0.0, 1.0]);
    let good = mesh_of(|u, v| u * v, &us, &vs);
    let fault = |change: &dyn Fn(&mut CurveMesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        mesh.fill(Fill::CoonsBilinear, 1e-9).unwrap_err().to_string()
    };
    assert!(fault(&|m| m.us[1] = 2.5).starts_with("nodes.u[2]: u number 2 (2) does not lie above"));
    let found = fault(&|m| {
        m.over_v.pop();
    });
    assert_eq!(found, "mesh.u_curves: 2 curves for 3 places");
    assert!(fault(&|m| m.over_u[1] = None).starts_with("mesh.v_curves[1]: the curve is missing"));
    assert!(fault(&|m| m.vs[1] = 1.5).starts_with("mesh.u_curves[0]: the curve runs over [0, 1], the mesh over"));
    let higher = mesh_of(|u, v| u * v + 0.5, &us, &vs);
    let found = fault(&|m| m.over_v[2] = higher.over_v[2].clone());
    let message = "mesh.u_curves[2]: curve 2 over v and curve 0 over u are 0.5";
    assert!(found.starts_with(message) && found.contains("apart where they cross"), "{found}");
    let basis = BSplineBasis::uniform(1, 1, 0.0, 2.0).unwrap();
    let plane = BSplineCurve::new(basis, Dimension::Plane, vec![Vector::zeros(); 2], None).unwrap();
    let found = fault(&|m| m.over_u[0] = Some(CurveShape::BSpline(plane.clone())));
    assert_eq!(found, "mesh.v_curves[0]: the curve has values of 2 coordinates, where 1 are needed");
    let fault = good.fill(Fill::Bezier, f64::INFINITY).unwrap_err();
    assert!(fault.to_string().starts_with("tolerance: patch (0, 0): a tolerance of"), "{fault}");
}

fn grid() -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let (u, v): (Vec<f64>, Vec<f64>) = ((0..7).map(f64::from).collect(), (0..6).map(|k| 0.5 * f64::from(k)).collect());
    let z = u.iter().map(|u| v.iter().map(|v| (0.4 * u).sin() * (v - 0.1 * u).cos()).collect()).collect();
    (u, v, z)
}

fn spline_method(spans: usize) -> Method {
    Method::BSplineLeastSquares { degrees: [3, 2], knots: [AxisKnots::Spans(spans), AxisKnots::Uniform(2)] }
}

/// Every method on a grid passes through the nodes, but for the one that passes near them.
#[test]
fn every_method_on_a_grid() {
    let (u, v, z) = grid();
    let through = Method::BSpline { degrees: [3, 4], knots: [None, None] };
    let methods = [
        through,
        Method::CoonsBilinear,
        Method::CoonsBicubic { twists: Twists::Adini },
        Method::Gregory,
        Method::Bezier,
    ];
    for method in methods {
        let name = format!("{method:?}");
        let built = build(Given::Grid { u: u.clone(), v: v.clone(), z: z.clone() }, method).unwrap();
        for (i, u) in u.iter().enumerate() {
            for (j, v) in v.iter().enumerate() {
                assert!((built.shape.value(*u, *v).x - z[i][j]).abs() < 1e-13, "{name}");
            }
        }
        assert!(built.degenerate.is_empty());
        let Built { joints, parameters, .. } = built;
        assert_eq!(parameters.unwrap(), [u.clone(), v.clone()]);
        let smooth = joints.iter().filter(|j| j.class(&TOLERANCE) >= ContinuityClass::C1).count();
        assert!(name == "CoonsBilinear" || smooth == joints.len(), "{name} {smooth} of {}", joints.len());
    }
    let near = build(Given::Grid { u, v, z }, spline_method(3)).unwrap();
    assert!(near.residual_sum_of_squares.unwrap() > 0.0);
}

#[test]
fn control_nets_and_boundary_curves_are_built_and_checked() {
    let row = |i: usize| (0..4).map(|j| Vector::new(i as f64, j as f64, (i * j) as f64)).collect::<Vec<_>>();
    let net = Net {
        rows: (0..4).map(row).collect(),
        dimension: Dimension::Space,
        weights: None,
        inner: None,
        domain: Some([[0.0, 3.0]; 2]),
    };
    let of = |net: &Net, method: Method| build(Given::ControlPoints(net.clone()), method);
    let both = |degree: usize| ([degree; 2], [None, None]);
    let (degrees, knots) = both(2);
    let spline = of(&net, Method::BSpline { degrees, knots }).unwrap();
    assert_eq!(spline.shape.domain(), [[0.0, 3.0]; 2]);
    let bezier = of(&net, Method::Bezier).unwrap();
    assert!((bezier.shape.value(1.5, 1.5) - Vector::new(1.5, 1.5, 2.25)).norm() < 1e-14);
    let inner = Some([[row(1)[1], row(1)[2]], [row(2)[1], row(2)[2]]]);
    let gregory = of(&Net { inner, ..net.clone() }, Method::Gregory).unwrap();
    assert!((gregory.shape.value(1.5, 1.5) - Vector::new(1.5, 1.5, 2.25)).norm() < 1e-14);
    let weights = Some(vec![vec![1.0, 2.0, 2.0, 1.0]; 4]);
    let (degrees, knots) = both(3);
    let rational = of(&Net { weights: weights.clone(), ..net.clone() }, Method::Nurbs { degrees, knots }).unwrap();
    assert!((rational.shape.value(1.5, 1.5).y - 1.5).abs() < 1e-14);

    let place = |net: &Net, method| of(net, method).unwrap_err().list()[0].path.clone();
    assert_eq!(place(&net, Method::Gregory), "control_points");
    assert_eq!(place(&net, Method::CoonsBilinear), "method");
    let mut bad = net.clone();
    bad.rows[2][1].x = f64::NAN;
    assert_eq!(place(&bad, Method::Bezier), "control_points[2][1]");
    bad.rows[3].pop();
    assert_eq!(place(&bad, Method::Bezier), "control_points[3]");
    let mut bad = Net { weights, ..net.clone() };
    bad.weights.as_mut().unwrap()[1][2] = -1.0;
    assert_eq!(place(&bad, Method::Bezier), "weights[1][2]");
    bad.weights.as_mut().unwrap().pop();
    assert_eq!(place(&bad, Method::Bezier), "weights");
    assert_eq!(place(&Net { domain: Some([[0.0, 1.0], [1.0, 1.0]]), ..net.clone() }, Method::Bezier), "domain[1]");
    assert_eq!(place(&Net { dimension: Dimension::Plane, ..net.clone() }, Method::Bezier), "control_points");
    let knots = |k: &[f64]| Method::BSpline { degrees: [1, 1], knots: [None, Some(k.to_vec())] };
    assert_eq!(place(&net, knots(&[0., 0., 1., 0.5, 2., 2.])), "knots[1][3]");
    assert_eq!(place(&net, knots(&[0., 0., 1., 2., 2.])), "knots[1]");
    assert_eq!(place(&net, Method::BSpline { degrees: [0, 1], knots: [None, None] }), "degree[0]");

    let line = |from: Vector, to: Vector| {
        let basis = BSplineBasis::uniform(1, 1, 0.0, 1.0).unwrap();
        Some(CurveShape::BSpline(BSplineCurve::new(basis, Dimension::Space, vec![from, to], None).unwrap()))
    };
    let [o, x, y] = [Vector::zeros(), Vector::x(), Vector::y()];
    let square = [line(o, y), line(x, x + y), line(o, x), line(y, x + y)];
    let around = |curves: [Option<CurveShape>; 4], method| {
        build(
            Given::Boundaries { curves: Box::new(curves), cross: Box::new([const { None }; 4]), tolerance: 1e-9 },
            method,
        )
    };
    let adini = Method::CoonsBicubic { twists: Twists::Adini };
    for method in [Method::CoonsBilinear, adini, Method::Gregory, Method::Bezier] {
        let built = around(square.clone(), method).unwrap();
        assert!((built.shape.value(0.25, 0.75) - Vector::new(0.25, 0.75, 0.0)).norm() < 1e-15);
        assert!(built.deviation.is_none_or(|d| d.value < 1e-15));
    }
    assert_eq!(around(square.clone(), spline_method(1)).unwrap_err().list()[0].path.clone(), "method");
    let mut torn = square.clone();
    torn[3] = line(y, x + y * 2.0);
    assert_eq!(around(torn, Method::Gregory).unwrap_err().list()[0].path.clone(), "boundaries.u1");
    let given = Given::Boundaries {
        curves: Box::new(square),
        cross: Box::new([line(x, x), None, None, None]),
        tolerance: 1e-9,
    };
    assert_eq!(build(given, Method::CoonsBilinear).unwrap_err().list()[0].path.clone(), "method");
}

#[test]
fn errors_of_grids_have_paths() {
    let (u, v, z) = grid();
    let place = |u: &[f64], v: &[f64], z: &[Vec<f64>], method: Method| {
        build(Given::Grid { u: u.to_vec(), v: v.to_vec(), z: z.to_vec() }, method).unwrap_err().list()[0].path.clone()
    };
    let spline = || Method::BSpline { degrees: [3, 3], knots: [None, None] };
    let mut ragged = z.clone();
    ragged[4].pop();
    assert_eq!(place(&u, &v, &ragged, spline()), "nodes.z[4]");
    assert_eq!(place(&u, &v, &z[1..], spline()), "nodes.z");
    let mut bad = z.clone();
    bad[2][3] = f64::INFINITY;
    assert_eq!(place(&u, &v, &bad, spline()), "nodes.z[2][3]");
    let mut turned = v.clone();
    turned.swap(2, 3);
    assert_eq!(place(&u, &turned, &z, spline()), "nodes.v[3]");
    assert_eq!(place(&u, &v, &z, spline_method(9)), "spans[0]");
    assert_eq!(place(&u, &v, &z, Method::Nurbs { degrees: [3, 3], knots: [None, None] }), "method");
    assert_eq!(place(&u, &v, &z, Method::BSpline { degrees: [3, 9], knots: [None, None] }), "nodes.v");
    let knots = [Some(vec![0., 0., 0., 0., 3., 2., 4., 6., 6., 6., 6.]), None];
    let fault = build(Given::Grid { u, v, z }, Method::BSpline { degrees: [3, 3], knots }).unwrap_err();
    assert_eq!(fault.list()[0].path, "knots[0][5]");
    assert!(fault.to_string().contains("knot 5 (2) lies below the one before it (3)"));
    let rows = vec![vec![Vector::zeros(), Vector::x(), Vector::x()], vec![Vector::y(), Vector::x(), Vector::z()]];
    let points = Given::Points { rows, parametrization: Parametrization::ChordLength };
    assert_eq!(build(points, Method::Gregory).unwrap_err().list()[0].path.clone(), "nodes.points[0][2]");
}
