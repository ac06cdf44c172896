//! Sections by planes against closed forms: sphere, cylinder, torus (circles, figure of eight,
//! Villarceau's circles), helicoid; and what planes do that touch.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use flankfit_engine::geometry::{
    BSplineBasis,
    curve::Curve,
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, BezierSurface, Surface, SurfaceJet, SurfaceShape,
        mesh::Fill,
        section::{
            Description, Family, MeshOfSections, NoMesh, Plane, Section, SectionCurve, Sections, mesh_of_sections,
        },
    },
};

const FINE: Description = Description { tolerance: 1e-9, chords: false, most: 100_000 };

fn v(x: f64, y: f64, z: f64) -> Vector {
    Vector::new(x, y, z)
}

pub fn plane(normal: Vector, offset: f64) -> Plane {
    Plane { normal: normal.normalize(), offset }
}

/// A circle as four quadratic arcs: places and weights.
fn circle() -> Vec<([f64; 2], f64)> {
    let corners = [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]];
    corners.into_iter().enumerate().map(|(k, at)| (at, if k % 2 == 0 { 1.0 } else { FRAC_1_SQRT_2 })).collect()
}

fn knots(arcs: usize) -> BSplineBasis {
    let mut knots = vec![0.0];
    knots.extend((0..=arcs).flat_map(|k| [k as f64; 2]));
    knots.push(arcs as f64);
    BSplineBasis::new(2, knots).unwrap()
}

/// The profile (radius, height, weight) of `arcs` quadratic arcs about the z axis.
pub fn revolved(profile: &[([f64; 2], f64)], arcs: usize) -> SurfaceShape {
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for ([x, y], turned) in circle() {
        for ([radius, height], own) in profile {
            points.push(v(x * radius, y * radius, *height));
            weights.push(turned * own);
        }
    }
    let bases = [knots(4), knots(arcs)];
    SurfaceShape::BSpline(BSplineSurface::new(bases, Dimension::Space, points, Some(weights)).unwrap())
}

pub fn sphere(radius: f64) -> SurfaceShape {
    let half = circle()[..5].iter().map(|([x, y], w)| ([radius * y, -radius * x], *w)).collect::<Vec<_>>();
    revolved(&half, 2)
}

fn torus(major: f64, minor: f64) -> SurfaceShape {
    let whole = circle().iter().map(|([x, y], w)| ([major + minor * x, minor * y], *w)).collect::<Vec<_>>();
    revolved(&whole, 4)
}

fn cylinder(radius: f64, height: f64) -> SurfaceShape {
    revolved(&[([radius, 0.0], 1.0), ([radius, 0.5 * height], 1.0), ([radius, height], 1.0)], 1)
}

/// Description of a section's parts.
fn brief(found: &Section) -> String {
    let ends = |curve: &SectionCurve| {
        let [first, .., last] = &curve.points[..] else { panic!() };
        let (a, b) = (first.point, last.point);
        format!(
            "{} points, {:.6} long, closed {}, {a:.4?} to {b:.4?}",
            curve.points.len(),
            curve.length(),
            curve.closed
        )
    };
    let curves: Vec<String> = found.curves.iter().map(ends).collect();
    let Section { branch_points, contacts, unresolved, .. } = found;
    format!("{curves:#?} branches {branch_points:?} contacts {contacts:?} unresolved {unresolved:?}")
}

fn cut(surface: &SurfaceShape, at: Plane) -> Section {
    let found = Sections::of(surface).by(&at, FINE).unwrap_or_else(|fault| panic!("{at:?}: {fault}"));
    assert!(found.unresolved.is_empty() && !found.coincident, "{at:?}: {}", brief(&found));
    for curve in &found.curves {
        assert!(curve.error <= FINE.tolerance, "{at:?} {}: {}", curve.error, brief(&found));
    }
    found
}

/// Every place of the curve, and every place of its spline, is as near to what `off` measures from.
pub fn lies(curve: &SectionCurve, off: impl Fn(Vector) -> f64) {
    for place in &curve.points {
        assert!(off(place.point).abs() < 1e-9, "{:?} is off by {:e}", place.point, off(place.point));
    }
    let shape = curve.shape().unwrap();
    let [low, high] = shape.domain();
    for k in 0..=700 {
        let at = shape.value(low + (high - low) * f64::from(k) / 700.0);
        assert!(off(at).abs() < 1.1e-9, "{at:?} is off by {:e}", off(at));
    }
}

/// The distance from a circle in space.
pub fn from_circle(centre: Vector, normal: Vector, radius: f64) -> impl Fn(Vector) -> f64 {
    move |p| {
        let along = normal.normalize().dot(&(p - centre));
        let flat = p - centre - normal.normalize() * along;
        along.hypot(flat.norm() - radius)
    }
}

fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted}");
}

#[test]
fn sections_of_a_sphere_are_circles() {
    let ball = sphere(10.0);
    let normals = [v(0., 0., 1.), v(0., 1., 0.), v(1., 2., 3.), v(1e-3, 0., 1.)];
    for normal in normals {
        for offset in [-9.5, 0.0, 7.0, 10.0 - 1e-7] {
            let at = plane(normal, offset);
            let found = cut(&ball, at);
            let [curve] = &found.curves[..] else { panic!("{normal:?} {offset}: {}", brief(&found)) };
            assert!(curve.closed && !curve.tangential, "{normal:?} {offset}");
            let radius = (100.0 - offset * offset).sqrt();
            lies(curve, from_circle(at.normal * offset, at.normal, radius));
            close(curve.length(), 2.0 * PI * radius, 1e-8 * radius.max(1.0));
            assert!(found.contacts.is_empty() && found.branch_points.is_empty(), "{normal:?} {offset}");
        }
        let found = cut(&ball, plane(normal, 10.0));
        assert!(found.curves.is_empty(), "{normal:?}: {}", brief(&found));
        let [contact] = found.contacts[..] else { panic!("{normal:?}: {}", brief(&found)) };
        assert!((contact - normal.normalize() * 10.0).norm() < 1e-5, "{contact:?}");
        for beyond in [10.0 + 1e-7, 25.0, -11.0] {
            assert_eq!(cut(&ball, plane(normal, beyond)), Section::default(), "{normal:?}");
        }
    }
}

/// Through one pole, through both, and with the seam within the plane.
#[test]
fn sections_through_poles() {
    let ball = sphere(10.0);
    for (normal, offset) in [(v(1., 0., 1.), 10.0 / 2_f64.sqrt()), (v(1., 3., 0.), 0.0), (v(0., 1., 0.), 0.0)] {
        let at = plane(normal, offset);
        let found = cut(&ball, at);
        let [curve] = &found.curves[..] else { panic!("{normal:?}: {}", brief(&found)) };
        let radius = (100.0 - offset * offset).sqrt();
        assert!(curve.closed && found.branch_points.is_empty() && found.contacts.is_empty(), "{}", brief(&found));
        lies(curve, from_circle(at.normal * offset, at.normal, radius));
        close(curve.length(), 2.0 * PI * radius, 1e-8);
    }
}

#[test]
fn sections_of_a_cylinder_are_circles_lines_and_ellipses() {
    let tube = cylinder(10.0, 20.0);
    // across, and along both of its ends
    for height in [7.3, 0.0, 20.0] {
        for turned in [1.0, -1.0] {
            let found = cut(&tube, plane(v(0., 0., turned), turned * height));
            let [curve] = &found.curves[..] else { panic!("{height}: {}", brief(&found)) };
            assert!(curve.closed, "{height}");
            lies(curve, from_circle(v(0., 0., height), v(0., 0., 1.), 10.0));
            close(curve.length(), 20.0 * PI, 1e-8);
        }
    }
    // along the axis: two lines, on one of which the plane passes the seam
    for normal in [v(1., 0., 0.), v(0., 1., 0.), v(3., 4., 0.)] {
        for offset in [6.0, 0.0] {
            let found = cut(&tube, plane(normal, offset));
            assert_eq!(found.curves.len(), 2, "{normal:?} {offset}: {}", brief(&found));
            for curve in &found.curves {
                close(curve.length(), 20.0, 1e-10);
                let at = plane(normal, offset);
                lies(curve, |p| (at.normal.dot(&p) - offset).hypot(p.x.hypot(p.y) - 10.0));
            }
        }
        // touching
        let found = cut(&tube, plane(normal, 10.0));
        let [curve] = &found.curves[..] else { panic!("{normal:?}: {}", brief(&found)) };
        assert!(curve.tangential && !curve.closed);
        let line = normal.normalize() * 10.0;
        for place in &curve.points {
            assert!((place.point.x - line.x).hypot(place.point.y - line.y) < 1e-6, "{:?}", place.point);
        }
        close(curve.length(), 20.0, 1e-9);
    }
    // oblique: z = 10 + x / 2
    let found = cut(&tube, Plane { normal: v(-0.5, 0., 1.).normalize(), offset: 10.0 / 1.25_f64.sqrt() });
    let [curve] = &found.curves[..] else { panic!("{}", brief(&found)) };
    assert!(curve.closed);
    lies(curve, |p| (p.z - 10.0 - 0.5 * p.x).hypot(p.x.hypot(p.y) - 10.0));
}

#[test]
fn sections_of_a_torus() {
    let ring = torus(10.0, 3.0);
    let up = v(0., 0., 1.);
    for height in [0.0, 1.8, -2.9] {
        let found = cut(&ring, plane(up, height));
        assert_eq!(found.curves.len(), 2, "{height}: {}", brief(&found));
        let half = (9.0 - height * height).sqrt();
        let mut lengths: Vec<f64> = found.curves.iter().map(SectionCurve::length).collect();
        lengths.sort_by(f64::total_cmp);
        close(lengths[0], 2.0 * PI * (10.0 - half), 1e-7);
        close(lengths[1], 2.0 * PI * (10.0 + half), 1e-7);
    }
    // on top of it: the plane touches along a circle
    let found = cut(&ring, plane(up, 3.0));
    let [curve] = &found.curves[..] else { panic!("{}", brief(&found)) };
    assert!(curve.tangential && curve.closed);
    close(curve.length(), 20.0 * PI, 1e-6);
    // upright: the implicit equation of the torus
    let torus_height = |p: Vector| ((p.x.hypot(p.y) - 10.0).hypot(p.z) - 3.0).abs();
    for (offset, curves) in [(0.0, 2), (5.0, 2), (6.99, 2), (7.01, 1), (10.0, 1), (12.9, 1)] {
        let found = cut(&ring, plane(v(1., 1., 0.), offset));
        assert_eq!(found.curves.len(), curves, "{offset}: {}", brief(&found));
        let normal = v(1., 1., 0.).normalize();
        for curve in &found.curves {
            assert!(curve.closed, "{offset}");
            lies(curve, |p| torus_height(p).hypot(normal.dot(&p) - offset));
        }
    }
    // inside of the hole it touches: a figure of eight
    for normal in [v(1., 0., 0.), v(3., 4., 0.)] {
        let found = cut(&ring, plane(normal, 7.0));
        let [branch] = found.branch_points[..] else { panic!("{}", brief(&found)) };
        assert!((branch - normal.normalize() * 7.0).norm() < 1e-6, "{branch:?}");
        assert_eq!(found.curves.len(), 2, "{}", brief(&found));
        for curve in &found.curves {
            let ends = [curve.points[0].point, curve.points[curve.points.len() - 1].point];
            assert!(ends.iter().all(|end| (end - branch).norm() < 1e-6) && !curve.closed);
            lies(curve, torus_height);
        }
    }
    let found = cut(&ring, plane(v(1., 2., 0.), 13.0));
    assert!(found.curves.is_empty() && found.contacts.len() == 1, "{}", brief(&found));
}

/// A plane through the centre that touches the torus twice cuts two circles of the major radius.
#[test]
fn circles_of_villarceau() {
    let tilt = 0.3_f64.asin();
    let at = plane(v(-tilt.sin(), 0., tilt.cos()), 0.0);
    let found = cut(&torus(10.0, 3.0), at);
    assert_eq!((found.branch_points.len(), found.curves.len()), (2, 4), "{}", brief(&found));
    let mut whole = 0.0;
    for curve in &found.curves {
        let side = if curve.points[curve.points.len() / 2].point.y > 0.0 { 1.0 } else { -1.0 };
        let circles = [3.0, -3.0].map(|y| from_circle(v(0., y, 0.), at.normal, 10.0));
        let off = |p: Vector| circles[0](p).min(circles[1](p));
        lies(curve, off);
        whole += curve.length();
        assert!(side != 0.0);
    }
    close(whole, 40.0 * PI, 1e-6);
}

/// (u cos t, u sin t, 2 t), a surface that no B-spline is.
struct Helicoid;

impl Surface for Helicoid {
    fn dimension(&self) -> Dimension {
        Dimension::Space
    }

    fn domain(&self) -> [[f64; 2]; 2] {
        [[-5.0, 5.0], [0.0, 2.0 * PI]]
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.domain().map(|range| range.to_vec())
    }

    fn jet(&self, u: f64, t: f64) -> SurfaceJet {
        let (sin, cos) = t.sin_cos();
        SurfaceJet {
            value: v(u * cos, u * sin, 2.0 * t),
            u: v(cos, sin, 0.0),
            v: v(-u * sin, u * cos, 2.0),
            uu: Vector::zeros(),
            uv: v(-sin, cos, 0.0),
            vv: v(-u * cos, -u * sin, 0.0),
        }
    }
}

#[test]
fn sections_of_a_helicoid() {
    let cut = |at: Plane| Sections::of_surfaces(&[&Helicoid]).by(&at, FINE).unwrap();
    // level: a ruling
    let found = cut(plane(v(0., 0., 1.), 5.0));
    let [curve] = &found.curves[..] else { panic!("{}", brief(&found)) };
    let (sin, cos) = 2.5_f64.sin_cos();
    lies(curve, |p| (p.z - 5.0).hypot(p.x * sin - p.y * cos));
    close(curve.length(), 10.0, 1e-10);
    // upright, next to the axis: y = d tan(z / 2)
    let found = cut(plane(v(1., 0., 0.), 1.5));
    assert_eq!(found.curves.len(), 3, "{}", brief(&found));
    for curve in &found.curves {
        lies(curve, |p| (p.x - 1.5).hypot(p.y * (0.5 * p.z).cos() - 1.5 * (0.5 * p.z).sin()));
    }
    // through the axis: the axis and two rulings across it
    let found = cut(plane(v(1., 0., 0.), 0.0));
    assert_eq!(found.branch_points.len(), 2, "{}", brief(&found));
    assert_eq!(found.curves.len(), 7, "{}", brief(&found));
    let whole: f64 = found.curves.iter().map(SectionCurve::length).sum();
    close(whole, 4.0 * PI + 20.0, 1e-8);
}

#[test]
fn chords_and_limits() {
    let how = Description { tolerance: 1e-2, chords: true, most: 1000 };
    let found = Sections::of(&sphere(10.0)).by(&plane(v(0., 0., 1.), 0.0), how).unwrap();
    let [curve] = &found.curves[..] else { panic!() };
    let sagitta = |pair: &[flankfit_engine::geometry::surface::section::SectionPoint]| {
        10.0 - (0.5 * (pair[0].point + pair[1].point)).norm()
    };
    let worst = curve.points.windows(2).map(sagitta).fold(0.0, f64::max);
    assert!(worst <= 1e-2 && (worst - curve.error).abs() < 1e-6, "{worst} {}", curve.error);
    assert!(curve.points.len() < 400);
    let few = Description { most: 50, ..FINE };
    assert!(Sections::of(&sphere(10.0)).by(&plane(v(0., 0., 1.), 0.0), few).is_err());
    // a flat surface in the plane
    let flat = BezierSurface::new([2, 2], [[0.0, 1.0]; 2], Dimension::Graph, vec![Vector::zeros(); 4], None).unwrap();
    let found = Sections::of(&SurfaceShape::Bezier(flat)).by(&plane(v(0., 0., 1.), 0.0), FINE).unwrap();
    assert!(found.coincident);
}

/// The mesh of a surface by planes of two normals.
fn meshed(surface: &SurfaceShape, normals: [Vector; 2], offsets: [&[f64]; 2]) -> Result<MeshOfSections, NoMesh> {
    let cutter = Sections::of(surface);
    let cut = |k: usize| -> Vec<Section> {
        let at = |offset: &f64| cutter.by(&Plane { normal: normals[k], offset: *offset }, FINE).unwrap();
        offsets[k].iter().map(at).collect()
    };
    let found = [0, 1].map(cut);
    let family = |k: usize| Family { normal: normals[k], offsets: offsets[k], sections: &found[k] };
    mesh_of_sections(surface, [family(0), family(1)], FINE)
}

/// A graph cut by two families of planes: the mesh has its heights, and patches that fill the mesh
/// come near to it.
#[test]
fn two_families_make_a_mesh_that_is_filled() {
    let cap = sphere(10.0);
    let us: Vec<f64> = (0..=6).map(|k| -3.0 + f64::from(k)).collect();
    let vs: Vec<f64> = (0..=4).map(|k| -2.0 + f64::from(k)).collect();
    let tilted = [v(1., 0., 0.), v(0., 1., 0.)];
    // of the two halves of the ball only one reaches over the mesh as heights: cut it off
    let half = circle()[2..5].iter().map(|([x, y], w)| ([10.0 * y, -10.0 * x], *w)).collect::<Vec<_>>();
    let upper = revolved(&half, 1);
    let found = meshed(&upper, tilted, [&us, &vs]).unwrap();
    assert!(found.error <= 1e-9);
    for (x, curve) in us.iter().zip(&found.mesh.over_v) {
        let curve = curve.as_ref().unwrap();
        for k in 0..=100 {
            let y = -2.0 + 4.0 * f64::from(k) / 100.0;
            close(curve.value(y).x, (100.0 - x * x - y * y).sqrt(), 1.1e-9);
        }
    }
    let filled = found.mesh.fill(Fill::Gregory, 1e-8).unwrap();
    for k in 0..=400 {
        let (x, y) = (-3.0 + 6.0 * f64::from(k % 21) / 20.0, -2.0 + 4.0 * f64::from(k / 21) / 20.0);
        let height = filled.patchwork.value(x, y).x;
        close(height, (100.0 - x * x - y * y).sqrt(), 2e-4);
    }
    assert!(matches!(meshed(&cap, tilted, [&us, &vs]), Err(NoMesh::Curves { family: 0, plane: 0, .. })));
    assert_eq!(meshed(&cap, [v(1., 0., 0.), v(0.6, 0.8, 0.)], [&us, &vs]), Err(NoMesh::Skew { cosine: 0.6 }));
}
