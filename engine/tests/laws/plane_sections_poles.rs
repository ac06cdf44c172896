//! Planes that pass a pole closely. Near a pole the parameters turn by a quarter within a tiny
//! distance, while the section is as smooth as anywhere.

use std::f64::consts::PI;

use crate::{
    oracle::random::Random,
    plane_sections::{from_circle, lies, plane, revolved, sphere},
};
use flankfit_engine::geometry::{
    BSplineBasis,
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, SurfaceShape,
        section::{Description, Plane, Section, SectionCurve, Sections},
    },
};

const FINE: Description = Description { tolerance: 1e-9, chords: false, most: 100_000 };

fn direction(random: &mut Random) -> Vector {
    Vector::from_fn(|_, _| random.normal()).normalize()
}

/// Distance from the pole, evenly in its logarithm.
fn nearness(random: &mut Random) -> f64 {
    10f64.powf(random.between(-5.0, -1.5))
}

fn cut(surface: &SurfaceShape, at: &Plane, how: Description) -> Section {
    let found = Sections::of(surface).by(at, how).unwrap();
    assert!(found.unresolved.is_empty() && !found.coincident, "{at:?}: {:?}", found.unresolved);
    for curve in &found.curves {
        assert!(curve.error <= how.tolerance, "{at:?}: {:e}", curve.error);
    }
    found
}

/// Every plane cuts one circle, once around, as long as it is.
#[test]
fn circles_of_a_sphere_near_its_poles() {
    let (radius, mut random) = (2.0, Random::new(501));
    let sphere = sphere(radius);
    for _ in 0..300 {
        let normal = direction(&mut random);
        let pole = Vector::z() * if random.normal() > 0.0 { radius } else { -radius };
        let side = if random.normal() > 0.0 { radius } else { -radius };
        let at = plane(normal, normal.dot(&pole) + side * nearness(&mut random));
        let own = radius * radius - at.offset * at.offset;
        if own < 1e-6 {
            continue;
        }
        let (own, centre) = (own.sqrt(), normal * at.offset);
        let found = cut(&sphere, &at, FINE);
        let [curve] = &found.curves[..] else { panic!("{at:?}: {} curves", found.curves.len()) };
        assert!(curve.closed, "{at:?}");
        assert!((curve.length() / (2.0 * PI * own) - 1.0).abs() < 1e-8, "{at:?}: {} of {own}", curve.length());
        lies(curve, from_circle(centre, normal, own));
        // always onwards
        let turn = |k: usize| {
            let place = &curve.points[k];
            normal.cross(&(place.point - centre)).normalize().dot(&place.tangent)
        };
        let way = turn(0).signum();
        assert!((0..curve.points.len()).all(|k| way * turn(k) > 0.999_999), "{at:?} runs back");
        let chords = Description { tolerance: 1e-5, chords: true, ..FINE };
        let found = cut(&sphere, &at, chords);
        let [line] = &found.curves[..] else { panic!("{at:?}: {} lines", found.curves.len()) };
        let length: f64 = line.points.windows(2).map(|pair| (pair[1].point - pair[0].point).norm()).sum();
        // chords of sagitta s are shorter than their arcs by 8 s/3 for each chord at most
        let short = 2.0 * PI * own - length;
        let most = 3.0 * 1e-5 * line.points.len() as f64 + 1e-12;
        assert!(short > -1e-12 && short < most, "{at:?}: {length} of {}", 2.0 * PI * own);
    }
}

/// The apple that a circle turned about one of its chords makes: its poles are tips, not planes.
#[test]
fn sections_of_a_torus_near_its_tips() {
    let (major, minor, mut random) = (0.5, 1.0, Random::new(502));
    // from tip to tip over the equator, in quadratic arcs of 60 degrees
    let profile: Vec<([f64; 2], f64)> = (0..9)
        .map(|k| {
            let angle = PI / 6.0 * f64::from(4 - k);
            let (weight, reach) = if k % 2 == 0 { (1.0, minor) } else { ((PI / 6.0).cos(), minor / (PI / 6.0).cos()) };
            ([if k % 8 == 0 { 0.0 } else { major + reach * angle.cos() }, reach * angle.sin()], weight)
        })
        .collect();
    let apple = revolved(&profile, 4);
    let tip = minor * (2.0 * PI / 3.0).sin();
    for _ in 0..100 {
        let side = if random.normal() > 0.0 { 1.0 } else { -1.0 };
        let near = nearness(&mut random);
        let found = cut(&apple, &plane(Vector::z(), side * (tip + near)), FINE);
        let half = (minor * minor - (tip + near).powi(2)).sqrt();
        let mut lengths: Vec<f64> = found.curves.iter().map(SectionCurve::length).collect();
        lengths.sort_by(f64::total_cmp);
        let [inner, outer] = lengths[..] else { panic!("{near}: {lengths:?}") };
        assert!((inner - 2.0 * PI * (major - half)).abs() < 1e-8, "{near}: {inner}");
        assert!((outer - 2.0 * PI * (major + half)).abs() < 1e-8, "{near}: {outer}");
        // a plane at any angle: on the torus everywhere, and as long as chords of it say
        let normal = direction(&mut random);
        let at = plane(normal, normal.dot(&Vector::z()) * side * tip + near);
        let on_torus = |p: Vector| (p.x.hypot(p.y) - major).hypot(p.z) - minor;
        let found = cut(&apple, &at, FINE);
        let length: f64 = found.curves.iter().map(SectionCurve::length).sum();
        found.curves.iter().for_each(|curve| lies(curve, |p| on_torus(p).hypot(normal.dot(&p) - at.offset)));
        let lines = cut(&apple, &at, Description { tolerance: 1e-6, chords: true, ..FINE });
        let chords = |line: &SectionCurve| -> f64 {
            line.points.windows(2).map(|pair| (pair[1].point - pair[0].point).norm()).sum()
        };
        let polylines: f64 = lines.curves.iter().map(chords).sum();
        assert!((length - polylines).abs() < 1e-4 * length.max(1e-2), "{at:?}: {length} {polylines}");
    }
}

/// Noise about the plane so small that rounding moves its zeros: the surface lies in the plane, and
/// that is found soon. Where noise exceeds rounding, curves are returned.
#[test]
fn noise_about_the_plane_lies_in_it() {
    let mut random = Random::new(503);
    let mut rough = |count: usize, noise: f64| {
        let basis = BSplineBasis::uniform(3, count - 3, 0.0, 1.0).unwrap();
        let heights = (0..count * count).map(|_| Vector::new(noise * random.normal(), 0.0, 0.0)).collect();
        let surface = BSplineSurface::new([basis.clone(), basis], Dimension::Graph, heights, None).unwrap();
        Sections::of(&SurfaceShape::BSpline(surface)).by(&plane(Vector::z(), 0.0), FINE)
    };
    for noise in [1e-9, 1e-10] {
        let found = rough(150, noise).unwrap();
        assert!(found.coincident && found.curves.is_empty() && found.unresolved.is_empty());
    }
    let found = rough(20, 1e-5).unwrap();
    assert!(!found.coincident && found.unresolved.is_empty() && found.curves.len() > 5);
    assert!(found.curves.iter().all(|curve| curve.error < 2e-9));
}
