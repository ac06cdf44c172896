//! Laws of patches: derivatives against differences, borders reproduced, affine maps and convex
//! hulls, known curvatures.

use flankfit_engine::geometry::{
    BSplineBasis,
    curve::{BSplineCurve, Curve, CurveShape},
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, BezierSurface, Border, Boundaries, CoonsPatch, Differential, GregoryPatch, LocalGeometry,
        Surface, coons::Twists, gregory::GregoryNet, normal, triangle::degenerate_borders,
    },
};
use proptest::prelude::*;

pub(crate) fn vector() -> impl Strategy<Value = Vector> {
    prop::array::uniform3(-1.0..1.0f64).prop_map(Vector::from)
}

/// A cubic B-spline between two points.
fn spline(from: Vector, to: Vector, inner: &[Vector], [low, high]: [f64; 2]) -> BSplineCurve {
    let basis = BSplineBasis::uniform(3, inner.len() - 1, low, high).unwrap();
    let points = [&[from], inner, &[to]].concat();
    BSplineCurve::new(basis, Dimension::Space, points, None).unwrap()
}

fn curve(from: Vector, to: Vector, inner: &[Vector], domain: [f64; 2]) -> CurveShape {
    CurveShape::BSpline(spline(from, to, inner, domain))
}

/// Boundary curves over different domains and with different knots, meeting at four points.
pub(crate) fn boundary_curves() -> impl Strategy<Value = [BSplineCurve; 4]> {
    let corners = prop::collection::vec(vector(), 4);
    (corners, prop::collection::vec(vector(), 4 * 4), 0.5..3.0f64).prop_map(|(c, inner, width)| {
        let c = [c[0], c[1] + Vector::y() * 3.0, c[2] + Vector::x() * 3.0, c[3] + Vector::new(3.0, 3.0, 0.0)];
        let domain = [1.0, 1.0 + width];
        [
            spline(c[0], c[1], &inner[0..3], domain),
            spline(c[2], c[3], &inner[4..8], [0.0, 1.0]),
            spline(c[0], c[2], &inner[8..10], domain),
            spline(c[1], c[3], &inner[12..16], domain),
        ]
    })
}

/// Every derivative of the jet against the central difference of the one below, at a place with no
/// break within 1e-5.
pub(crate) fn derivatives_agree(surface: &dyn Surface, u: f64, v: f64) -> Result<(), TestCaseError> {
    let [[a, b], [c, d]] = surface.domain();
    let (hu, hv) = ((b - a) * 1e-5, (d - c) * 1e-5);
    let (right, left) = (surface.jet(u + hu, v), surface.jet(u - hu, v));
    let (up, down) = (surface.jet(u, v + hv), surface.jet(u, v - hv));
    let here = surface.jet(u, v);
    let pairs = [
        (here.u, (right.value - left.value) / (2.0 * hu)),
        (here.v, (up.value - down.value) / (2.0 * hv)),
        (here.uu, (right.u - left.u) / (2.0 * hu)),
        (here.uv, (up.u - down.u) / (2.0 * hv)),
        (here.uv, (right.v - left.v) / (2.0 * hu)),
        (here.vv, (up.v - down.v) / (2.0 * hv)),
    ];
    for (k, (derivative, difference)) in pairs.into_iter().enumerate() {
        let size = derivative.norm().max(1.0);
        prop_assert!((derivative - difference).norm() < 2e-4 * size, "{k} at {u} {v}: {derivative:?} {difference:?}");
    }
    Ok(())
}

/// A place within the domain that keeps away from breaks.
pub(crate) fn smooth_place(surface: &dyn Surface, s: f64, t: f64) -> (f64, f64) {
    let domain = surface.domain();
    let breaks = surface.breaks();
    let place = |axis: usize, s: f64| {
        let [low, high] = domain[axis];
        let x = low + (0.01 + 0.98 * s) * (high - low);
        let near = breaks[axis].iter().any(|b| (b - x).abs() < 1e-3 * (high - low));
        if near { x + 2e-3 * (high - low) } else { x }
    };
    (place(0, s), place(1, t))
}

fn cross_curves(patch: &dyn Surface, bend: f64) -> [Option<CurveShape>; 4] {
    // cross derivatives that fit the borders' tangents but agree about no twist
    let domain = patch.domain();
    Border::ALL.map(|border| {
        let [low, high] = domain[border.axis()];
        let end = |t: f64| {
            let (u, v) = border.place(domain, t);
            let jet = patch.jet(u, v);
            if border.axis() == 1 { jet.u } else { jet.v }
        };
        let inner = [Vector::new(bend, 0.3, border as usize as f64), Vector::new(0.2, -bend, 1.0)];
        Some(curve(end(low), end(high), &inner, [low, high]))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn coons_patches_reproduce_their_borders_and_cross_derivatives(
        curves in boundary_curves(), bend in -1.0..1.0f64, (s, t) in (0.0..1.0f64, 0.0..1.0f64)
    ) {
        let curves = curves.map(CurveShape::BSpline);
        let boundaries = Boundaries::new(curves.clone(), 1e-14).unwrap();
        let flat = CoonsPatch::bilinear(boundaries.clone());
        let none = [const { None }; 4];
        let estimated = CoonsPatch::bicubic(boundaries.clone(), none.clone(), &Twists::Adini, 1e-14).unwrap();
        let zero = CoonsPatch::bicubic(boundaries.clone(), none, &Twists::Zero, 1e-14).unwrap();
        let cross = cross_curves(&flat, bend);
        let given = CoonsPatch::bicubic(boundaries, cross.clone(), &Twists::Adini, 1e-10).unwrap();
        prop_assert!(estimated.has_one_twist_at_each_corner() && !given.has_one_twist_at_each_corner());
        for patch in [&flat, &estimated, &zero, &given] {
            let domain = patch.domain();
            for border in Border::ALL {
                let shape = &curves[border as usize];
                let ([low, high], [a, b]) = (domain[border.axis()], shape.domain());
                for k in 0..=16 {
                    let x = f64::from(k) / 16.0;
                    let (u, v) = border.place(domain, low + x * (high - low));
                    let truth = shape.value(a + x * (b - a));
                    prop_assert!((patch.value(u, v) - truth).norm() < 3e-15 * 8.0, "{border} {k}");
                }
            }
            let (u, v) = smooth_place(patch, s, t);
            derivatives_agree(patch, u, v)?;
        }
        let domain = given.domain();
        for border in Border::ALL {
            let wanted = cross[border as usize].as_ref().unwrap();
            for k in 0..=16 {
                let [low, high] = domain[border.axis()];
                let t = low + f64::from(k) / 16.0 * (high - low);
                let (u, v) = border.place(domain, t);
                let jet = given.jet(u, v);
                let across = if border.axis() == 1 { jet.u } else { jet.v };
                prop_assert!((across - wanted.value(t)).norm() < 1e-12, "{border} {k}");
            }
        }
    }

    /// The fill of mapped borders is the mapped fill.
    #[test]
    fn coons_patches_follow_affine_maps(
        curves in boundary_curves(), map in prop::array::uniform9(-1.0..1.0f64), shift in vector(),
        (s, t) in (0.0..1.0f64, 0.0..1.0f64)
    ) {
        let matrix = nalgebra::Matrix3::from_column_slice(&map);
        let mapped = curves.clone().map(|spline| {
            let points = spline.control_points().iter().map(|p| matrix * p + shift).collect();
            BSplineCurve::new(spline.basis().clone(), Dimension::Space, points, None).unwrap()
        });
        let fill = |curves: [BSplineCurve; 4]| {
            let boundaries = Boundaries::new(curves.map(CurveShape::BSpline), 1e-14).unwrap();
            CoonsPatch::bicubic(boundaries, [const { None }; 4], &Twists::Adini, 1e-10).unwrap()
        };
        let (patch, image) = (fill(curves), fill(mapped));
        let (u, v) = smooth_place(&patch, s, t);
        prop_assert!((matrix * patch.value(u, v) + shift - image.value(u, v)).norm() < 1e-13);
    }

    #[test]
    fn gregory_patches_have_their_derivatives(
        points in prop::collection::vec(vector(), 20), (s, t) in (0.0..1.0f64, 0.0..1.0f64)
    ) {
        let net = std::array::from_fn(|i| std::array::from_fn(|j| points[4 * i + j]));
        let b = std::array::from_fn(|i| std::array::from_fn(|j| points[16 + 2 * i + j]));
        let patch = GregoryPatch::new([[0.0, 2.0], [3.0, 3.5]], Dimension::Space, GregoryNet { net, b }).unwrap();
        let (u, v) = smooth_place(&patch, s, t);
        derivatives_agree(&patch, u, v)?;
        // the borders are those of the net, and across u0 only the b points act
        let mut other = net;
        other[1][1] = b[0][0];
        other[1][2] = b[0][1];
        let bezier =
            BezierSurface::new([4, 4], patch.domain(), Dimension::Space, other.concat(), None).unwrap();
        let v = 3.0 + 0.5 * t;
        let (one, two) = (patch.jet(0.0, v), bezier.jet(0.0, v));
        prop_assert!((one.value - two.value).norm() < 1e-14 && (one.u - two.u).norm() < 1e-13);
    }

    #[test]
    fn a_bezier_patch_lies_in_the_hull_of_its_net_and_follows_affine_maps(
        points in prop::collection::vec(vector(), 12), weights in prop::collection::vec(0.1..3.0f64, 12),
        direction in vector(), (s, t) in (0.0..1.0f64, 0.0..1.0f64)
    ) {
        let unit = [[0.0, 1.0]; 2];
        let patch = BezierSurface::new([3, 4], unit, Dimension::Space, points.clone(), Some(weights.clone())).unwrap();
        let along: Vec<f64> = points.iter().map(|p| p.dot(&direction)).collect();
        let [low, high] = [f64::min, f64::max].map(|pick| along.iter().copied().reduce(pick).unwrap());
        let place = patch.value(s, t).dot(&direction);
        prop_assert!(place >= low - 1e-14 && place <= high + 1e-14);
        let (u, v) = smooth_place(&patch, s, t);
        derivatives_agree(&patch, u, v)?;
        let scaled: Vec<f64> = weights.iter().map(|w| 3.0 * w).collect();
        let moved: Vec<Vector> = points.iter().map(|p| p * 2.0 + direction).collect();
        let image = BezierSurface::new([3, 4], unit, Dimension::Space, moved, Some(scaled)).unwrap();
        prop_assert!((patch.value(u, v) * 2.0 + direction - image.value(u, v)).norm() < 1e-14);
    }
}

/// Control points and weights of an arc of a quarter turn, as (cos-like, sin-like) coordinates.
const QUARTER: [[f64; 3]; 3] = [[1.0, 0.0, 1.0], [1.0, 1.0, std::f64::consts::FRAC_1_SQRT_2], [0.0, 1.0, 1.0]];

/// The quarter turn about z of an arc in the plane of radius and height.
pub(crate) fn revolved(profile: &[[f64; 3]]) -> BSplineSurface {
    let basis = |n: usize| BSplineBasis::uniform(n - 1, 1, 0.0, 1.0).unwrap();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for [x, y, w] in QUARTER {
        for [radius, height, weight] in profile {
            points.push(Vector::new(radius * x, radius * y, *height));
            weights.push(w * weight);
        }
    }
    BSplineSurface::new([basis(3), basis(profile.len())], Dimension::Space, points, Some(weights)).unwrap()
}

fn near(a: f64, b: f64, digits: f64) {
    assert!((a - b).abs() <= 10f64.powf(-digits) * b.abs().max(1.0), "{a} is not {b}");
}

#[test]
fn curvatures_of_cylinder_cone_sphere_and_torus() {
    let cylinder = revolved(&[[2.0, 0.0, 1.0], [2.0, 5.0, 1.0]]);
    let sphere = revolved(&QUARTER.map(|[x, y, w]| [3.0 * x, 3.0 * y, w]));
    let torus = revolved(&QUARTER.map(|[x, y, w]| [4.0 + x, y, w]));
    for (s, t) in [(0.0, 0.0), (0.3, 0.7), (1.0, 0.4), (0.5, 0.9)] {
        let at = |surface: &BSplineSurface| Differential::at(surface, s, t).unwrap();
        let found = at(&cylinder);
        // the normal S_u × S_v points away from the axis
        let [high, low] = found.principal;
        near(high, 0.0, 14.5);
        near(low, -0.5, 14.5);
        assert!(found.directions[0].xy().norm() < 1e-14);
        let found = at(&sphere);
        near(found.gaussian, 1.0 / 9.0, 13.5);
        near(found.mean, -1.0 / 3.0, 13.5);
        assert!((found.normal - sphere.value(s, t) / 3.0).norm() < 1e-14);
        let found = at(&torus);
        let point = torus.value(s, t);
        // 1 along the small circle, cos / radius along the large one
        let radius = point.xy().norm();
        near(found.principal[0], -(radius - 4.0) / radius, 13.0);
        near(found.principal[1], -1.0, 13.0);
        assert!(!found.by_limit);
    }
}

#[test]
fn the_tip_of_a_triangle_has_its_limits() {
    let sphere = revolved(&QUARTER.map(|[x, y, w]| [2.0 * x, 2.0 * y, w]));
    let found = degenerate_borders(&sphere, 1e-12);
    assert_eq!(found.iter().map(|f| f.border).collect::<Vec<_>>(), [Border::V1]);
    assert!((found[0].point - Vector::z() * 2.0).norm() < 1e-15);
    for u in [0.0, 0.3, 1.0] {
        let tip = Differential::at(&sphere, u, 1.0).unwrap();
        assert!(tip.by_limit);
        assert!((tip.normal - Vector::z()).norm() < 1e-10, "{:?}", tip.normal);
        near(tip.gaussian, 0.25, 8.0);
        near(tip.mean, -0.5, 8.0);
    }
    // the tip of a cone has a normal along each line, and no curvature that is finite
    let cone = revolved(&[[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]);
    assert!(Differential::at(&cone, 0.5, 1.0).is_none());
    let local = LocalGeometry::at(&cone, 0.5, 1.0);
    assert!(local.differential.is_none() && local.normal == normal(&cone, 0.5, 1.0) && local.normal.is_some());
    let tilt = (cone.value(0.5, 0.0) + Vector::z()).normalize();
    assert!((normal(&cone, 0.5, 1.0).unwrap() - tilt).norm() < 1e-12);
    assert!(Differential::at(&cone, 0.5, 0.9).is_some());
}

/// Curvatures near a pole against those from the surface's equation at the same radius.
#[test]
fn curvatures_near_a_pole() {
    let sphere = revolved(&QUARTER.map(|[x, y, w]| [2.0 * x, 2.0 * y, w]));
    // z = r²
    let paraboloid = revolved(&[[1.0, 1.0, 1.0], [0.5, 0.0, 1.0], [0.0, 0.0, 1.0]]);
    let of_sphere = |_: f64| (0.25, 0.5);
    let of_paraboloid = |r: f64| {
        let s = 1.0 + 4.0 * r * r;
        (4.0 / (s * s), (2.0 + 4.0 * r * r) / s.powf(1.5))
    };
    let check = |surface: &BSplineSurface, truth: &dyn Fn(f64) -> (f64, f64)| {
        for decade in 1..=13 {
            for (u, share) in [(0.0, 1.0), (0.3, 0.7), (0.5, 0.4), (1.0, 0.2)] {
                let v = 1.0 - share * 10f64.powi(-decade);
                let found = Differential::at(surface, u, v).unwrap();
                let (gaussian, mean) = truth(surface.value(u, v).xy().norm());
                let errors = [found.gaussian / gaussian - 1.0, found.mean.abs() / mean - 1.0];
                assert!(errors.iter().all(|error| error.abs() < 1e-7), "1 − v = {:e}: {errors:?}", 1.0 - v);
                assert!(found.directions.iter().all(|d| d.dot(&found.normal).abs() < 1e-7));
            }
        }
    };
    check(&sphere, &of_sphere);
    check(&paraboloid, &of_paraboloid);
    // near the tip of a cone there is no limit, and curvature grows towards it
    let cone = revolved(&[[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]);
    for decade in 1..=7 {
        let found = Differential::at(&cone, 0.3, 1.0 - 10f64.powi(-decade)).unwrap();
        let [high, low] = found.principal.map(f64::abs);
        let radius = found.point.xy().norm();
        near(high.max(low) * radius * 2f64.sqrt(), 1.0, 6.0);
    }
}

#[test]
fn three_sided_coons_patches() {
    let [a, b, c] = [Vector::zeros(), Vector::x() * 3.0, Vector::new(1.0, 2.0, 1.0)];
    let side = |from: Vector, to: Vector| {
        curve(from, to, &[from * 0.7 + to * 0.3 + Vector::z() * 0.2, from * 0.2 + to * 0.8], [0.0, 1.0])
    };
    for missing in Border::ALL {
        let mut curves = match missing {
            Border::V1 => [side(a, c), side(b, c), side(a, b), side(a, b)],
            Border::V0 => [side(c, a), side(c, b), side(a, b), side(a, b)],
            Border::U1 => [side(a, b), side(a, b), side(a, c), side(b, c)],
            Border::U0 => [side(a, b), side(a, b), side(c, a), side(c, b)],
        }
        .map(Some);
        curves[missing as usize] = None;
        let boundaries = Boundaries::three_sided(curves.clone(), 1e-12).unwrap();
        assert_eq!(boundaries.collapsed(), Some(missing));
        let patch = CoonsPatch::bilinear(boundaries);
        let found = degenerate_borders(&patch, 1e-12);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].border, missing);
        assert!((found[0].point - c).norm() < 1e-15);
        let tip = missing.place(patch.domain(), 0.4);
        // the curved border opposite is drawn into the tip as a cone: a normal along each line, and
        // no curvature
        let normal = normal(&patch, tip.0, tip.1).expect("a limit");
        let (u, v) = (0.999 * tip.0 + 0.001 * 0.4, 0.999 * tip.1 + 0.001 * 0.4);
        let nearby = Differential::at(&patch, u, v).expect("a regular place");
        assert!((nearby.normal - normal).norm() < 5e-3 && !nearby.by_limit);
        assert!(Differential::at(&patch, tip.0, tip.1).is_none());
        let other = if missing == Border::U0 { Border::U1 } else { Border::U0 };
        curves[other as usize] = None;
        assert!(Boundaries::three_sided(curves, 1e-12).unwrap_err().to_string().contains("is missing; only one"));
    }
}

#[test]
fn refused_boundaries() {
    let line = |from: Vector, to: Vector, domain: [f64; 2], dimension| {
        let basis = BSplineBasis::uniform(1, 1, domain[0], domain[1]).unwrap();
        CurveShape::BSpline(BSplineCurve::new(basis, dimension, vec![from, to], None).unwrap())
    };
    let [o, x, y] = [Vector::zeros(), Vector::x(), Vector::y()];
    let unit = [0.0, 1.0];
    let space = |from, to| line(from, to, unit, Dimension::Space);
    let square = [space(o, y), space(x, x + y), space(o, x), space(y, x + y)];
    let with = |k: usize, curve: CurveShape| {
        let mut curves = square.clone();
        curves[k] = curve;
        Boundaries::new(curves, 1e-9).unwrap_err().to_string()
    };
    assert!(Boundaries::new(square.clone(), 0.0).is_ok());
    let fault = with(1, space(x, x + y * 1.5));
    assert_eq!(fault, "boundaries.u1: borders u1 and v1 are 0.5 apart at their corner, more than 1e-9");
    let plane = with(3, line(y, x + y, unit, Dimension::Plane));
    assert!(plane.starts_with("boundaries.v1: border v1 has values of 2 coordinates"), "{plane}");
    let heights = [unit, [0.0, 2.0], unit, unit].map(|domain| line(o, o, domain, Dimension::Graph));
    let fault = Boundaries::new(heights, 1e-9).unwrap_err();
    let message = "boundaries.u1: border u1 runs over [0, 2], the one opposite over [0, 1]";
    assert_eq!(fault.to_string(), message);
    let fault = Boundaries::new(square.clone(), f64::NAN).unwrap_err();
    assert_eq!(fault.to_string(), "tolerance: a tolerance of NaN is not a finite number ≥ 0");
    let good = Boundaries::new(square, 0.0).unwrap();
    let cross = [Some(space(x * 2.0, x)), None, None, None];
    let fault = CoonsPatch::bicubic(good.clone(), cross, &Twists::Zero, 1e-9).unwrap_err();
    let message = "cross_derivatives.u0: at the corner of u0 and v0 the cross derivative of u0 is 1 off";
    assert!(fault.to_string().starts_with(message), "{fault}");
    let twists = Twists::Given([[o, o], [Vector::repeat(f64::NAN), o]]);
    let fault = CoonsPatch::bicubic(good, [const { None }; 4], &twists, 1e-9).unwrap_err();
    assert_eq!(fault.to_string(), "twists[1][0]: twist (1, 0) is not finite");
}

/// Heights over the parameters: a patch of plane boundary curves of two families of planes
/// reproduces u·f(v) + g(v) + v·h(u) + k(u).
#[test]
fn heights_between_plane_curves() {
    let quadratic = |c: [f64; 3], [low, high]: [f64; 2]| {
        // control points of c₀ + c₁ t + c₂ t² on [low, high]
        let blossom = |a: f64, b: f64| Vector::x() * (c[0] + c[1] * 0.5 * (a + b) + c[2] * a * b);
        let basis = BSplineBasis::uniform(2, 1, low, high).unwrap();
        let points = vec![blossom(low, low), blossom(low, high), blossom(high, high)];
        CurveShape::BSpline(BSplineCurve::new(basis, Dimension::Graph, points, None).unwrap())
    };
    let truth = |u: f64, v: f64| u * (1.0 - v * v) + 2.0 * v + v * u * u - 0.5 * u;
    let (us, vs) = ([1.0, 3.0], [0.5, 2.0]);
    let over_v = |u: f64| quadratic([0.5 * u, 2.0 + u * u, -u], vs);
    let over_u = |v: f64| quadratic([2.0 * v, 0.5 - v * v, v], us);
    let curves = [over_v(us[0]), over_v(us[1]), over_u(vs[0]), over_u(vs[1])];
    let patch = CoonsPatch::bilinear(Boundaries::new(curves, 1e-12).unwrap());
    assert_eq!(patch.dimension(), Dimension::Graph);
    for (u, v) in [(1.0, 0.5), (1.7, 1.1), (2.9, 1.9)] {
        near(patch.value(u, v).x, truth(u, v), 14.0);
        assert!((patch.place(u, v).value - Vector::new(u, v, truth(u, v))).norm() < 1e-14);
    }
}
