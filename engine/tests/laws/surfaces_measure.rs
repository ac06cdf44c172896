//! Laws of what is measured on surfaces: closest points against dense sampling, areas of known
//! bodies.

use crate::oracle::random::Random;
use crate::surfaces::{boundary_curves, revolved, vector};
use flankfit_engine::geometry::{
    BSplineBasis,
    curve::CurveShape,
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, Boundaries, ClosestPoint, CoonsPatch, GregoryPatch, Surface, SurfacePoint, area::area,
        coons::Twists, gregory::GregoryNet,
    },
};
use proptest::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// No sample of the surface is closer, and the reported properties of the point hold.
fn not_beaten(surface: &(dyn Surface + Sync), node: &Vector, found: &SurfacePoint) -> Result<(), TestCaseError> {
    let [[a, b], [c, d]] = surface.domain();
    let n = 80;
    for i in 0..=n {
        for j in 0..=n {
            let (u, v) = (a + (b - a) * f64::from(i) / f64::from(n), c + (d - c) * f64::from(j) / f64::from(n));
            let distance = (surface.place(u, v).value - node).norm();
            prop_assert!(distance >= found.distance - 1e-13, "{u} {v}: {distance} < {found:?}");
        }
    }
    let [u, v] = found.parameters;
    prop_assert!(a <= u && u <= b && c <= v && v <= d);
    prop_assert!((surface.place(u, v).value - found.point).norm() < 1e-14);
    prop_assert!((found.distance - (node - found.point).norm()).abs() < 1e-14);
    prop_assert!(found.signed_distance.is_none_or(|s| s.abs() == found.distance));
    let inside = a < u && u < b && c < v && v < d;
    let smooth = surface.breaks()[0].iter().all(|x| *x != u) && surface.breaks()[1].iter().all(|y| *y != v);
    prop_assert!(!inside || !smooth || found.is_orthogonal, "{found:?}");
    Ok(())
}

/// A wavy surface of heights or of points, with an edge where a knot is double.
fn wavy() -> impl Strategy<Value = BSplineSurface> {
    (prop::collection::vec(vector(), 7 * 6), any::<bool>()).prop_map(|(noise, graph)| {
        let u = BSplineBasis::new(3, vec![0., 0., 0., 0., 1., 1., 1., 2., 2., 2., 2.]).unwrap();
        let v = BSplineBasis::uniform(2, 4, 0.0, 2.0).unwrap();
        let place = |k: usize| Vector::new((k / 6) as f64 / 3.0, (k % 6) as f64 * 0.4, 0.0);
        let points: Vec<Vector> = noise
            .iter()
            .enumerate()
            .map(|(k, n)| if graph { Vector::new(n.x, 0.0, 0.0) } else { place(k) + n * 0.8 })
            .collect();
        let dimension = if graph { Dimension::Graph } else { Dimension::Space };
        BSplineSurface::new([u, v], dimension, points, None).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn no_sample_is_closer_than_the_closest_point(surface in wavy(), nodes in prop::collection::vec(vector(), 6)) {
        let closest = ClosestPoint::on(&surface);
        let nodes: Vec<Vector> = nodes.iter().map(|n| n * 2.0 + Vector::new(1.0, 1.0, 0.0)).collect();
        for (node, found) in nodes.iter().zip(closest.to_each(&nodes)) {
            not_beaten(&surface, node, &found)?;
            prop_assert_eq!(found, closest.to(node));
        }
    }

    #[test]
    fn nor_on_patches_that_are_rational(curves in boundary_curves(), points in prop::collection::vec(vector(), 20),
        node in vector()) {
        let boundaries = Boundaries::new(curves.map(CurveShape::BSpline), 1e-13).unwrap();
        let coons = CoonsPatch::bicubic(boundaries, [const { None }; 4], &Twists::Adini, 1e-12).unwrap();
        let node = node * 3.0;
        not_beaten(&coons, &node, &ClosestPoint::on(&coons).to(&node))?;
        let net = std::array::from_fn(|i| std::array::from_fn(|j| points[4 * i + j] + Vector::new(i as f64, j as f64,
            0.0)));
        let b = std::array::from_fn(|i| std::array::from_fn(|j| points[16 + 2 * i + j] + Vector::new(1.5, 1.5, 0.0)));
        let gregory = GregoryPatch::new([[0.0, 1.0]; 2], Dimension::Space, GregoryNet { net, b }).unwrap();
        not_beaten(&gregory, &node, &ClosestPoint::on(&gregory).to(&node))?;
    }

    /// A point lifted along the normal by less than the radius of curvature has its foot where it
    /// came from.
    #[test]
    fn a_lifted_point_falls_back(s in 0.02..0.98f64, t in 0.02..0.98f64, lift in -0.8..3.0f64) {
        let quarter = [[1.0, 0.0, 1.0], [1.0, 1.0, FRAC_1_SQRT_2], [0.0, 1.0, 1.0]];
        let torus = revolved(&quarter.map(|[x, y, w]| [4.0 + x, y, w]));
        let foot = torus.value(s, t);
        let ring = Vector::new(foot.x, foot.y, 0.0).normalize() * 4.0;
        let normal = foot - ring;
        let found = ClosestPoint::on(&torus).to(&(foot + normal * lift));
        prop_assert!((found.point - foot).norm() < 1e-13, "{found:?}");
        prop_assert!((found.signed_distance.unwrap() - lift).abs() < 1e-14);
        prop_assert!((found.parameters[0] - s).abs() < 1e-13 && (found.parameters[1] - t).abs() < 1e-13);
        prop_assert!(found.is_orthogonal || lift.abs() < 1e-9);
    }
}

/// Heights that jump by several times the distance of the control points: many feet, the nearest of
/// them in a narrow valley.
#[test]
fn the_nearest_of_many_feet_on_rough_heights() {
    let mut random = Random::new(4711);
    for size in [1.0, 4.0, 12.0] {
        let bases = [(12, 10.0), (9, 6.0)].map(|(n, high)| BSplineBasis::uniform(3, n - 3, 0.0, high).unwrap());
        let heights = (0..108).map(|_| Vector::new(size * random.normal(), 0.0, 0.0)).collect();
        let surface = BSplineSurface::new(bases, Dimension::Graph, heights, None).unwrap();
        let places: Vec<Vector> = (0..=240)
            .flat_map(|i| (0..=180).map(move |j| (f64::from(i) / 24.0, f64::from(j) / 30.0)))
            .map(|(u, v)| surface.place(u, v).value)
            .collect();
        let nodes: Vec<Vector> = (0..1000)
            .map(|_| {
                let [a, b, c] = [0; 3].map(|_| random.unit());
                Vector::new(12.0 * a - 1.0, 8.0 * b - 1.0, 3.0 * size * (c - 0.5))
            })
            .collect();
        for (node, found) in nodes.iter().zip(ClosestPoint::on(&surface).to_each(&nodes)) {
            let nearest = places.iter().map(|p| (p - node).norm_squared()).fold(f64::INFINITY, f64::min).sqrt();
            assert!(found.distance <= nearest * (1.0 + 1e-9), "{size} {node:?}: {found:?} {nearest}");
            let at = surface.place(found.parameters[0], found.parameters[1]).value;
            assert!((at - found.point).norm() < 1e-14 * (1.0 + at.norm()));
        }
    }
}

#[test]
fn corners_borders_and_the_tip() {
    let quarter = [[1.0, 0.0, 1.0], [1.0, 1.0, FRAC_1_SQRT_2], [0.0, 1.0, 1.0]];
    let sphere = revolved(&quarter);
    let closest = ClosestPoint::on(&sphere);
    let tip = closest.to(&Vector::new(0.0, 0.0, 3.0));
    assert!((tip.distance - 2.0).abs() < 1e-14 && (tip.signed_distance.unwrap() - 2.0).abs() < 1e-14);
    // below the equator the border is closest, at 45° to the normal
    let border = closest.to(&Vector::new(2.0 * FRAC_1_SQRT_2, 2.0 * FRAC_1_SQRT_2, -1.0));
    assert!((border.distance - 2f64.sqrt()).abs() < 1e-14 && !border.is_orthogonal);
    assert!((border.parameters[0] - 0.5).abs() < 1e-14 && border.parameters[1] == 0.0);
    let corner = closest.to(&Vector::new(2.0, -1.0, -1.0));
    assert_eq!(corner.parameters, [0.0, 0.0]);
    assert!((corner.distance - 3f64.sqrt()).abs() < 1e-15);
    // the centre is as far from every point
    assert!((closest.to(&Vector::zeros()).distance - 1.0).abs() < 1e-15);
    let inside = closest.to(&Vector::new(0.3, 0.2, 0.1));
    assert!((inside.signed_distance.unwrap() - 0.14f64.sqrt() + 1.0).abs() < 1e-15);
}

#[test]
fn areas_of_known_bodies() {
    let quarter = [[1.0, 0.0, 1.0], [1.0, 1.0, FRAC_1_SQRT_2], [0.0, 1.0, 1.0]];
    let known = [
        (revolved(&[[2.0, 0.0, 1.0], [2.0, 5.0, 1.0]]), 2.0 * PI * 2.0 * 5.0 / 4.0),
        (revolved(&quarter.map(|[x, y, w]| [3.0 * x, 3.0 * y, w])), 4.0 * PI * 9.0 / 8.0),
        // a quarter turn of the outer upper quarter of a tube: Pappus, with the centroid 2/π
        // outside of the tube's centre
        (revolved(&quarter.map(|[x, y, w]| [4.0 + x, y, w])), PI / 2.0 * PI / 2.0 * (4.0 + 2.0 / PI)),
        (revolved(&[[0.0, 0.0, 1.0], [3.0, 4.0, 1.0]]), PI * 3.0 * 5.0 / 4.0),
    ];
    for (surface, truth) in known {
        let found = area(&surface, 1e-13);
        assert!((found.area - truth).abs() < 1e-13 * truth, "{found:?} {truth}");
        assert!(found.converged && found.error_estimate <= 1e-13 * truth);
    }
    // z = u v over the unit square: ∬ √(1 + u² + v²)
    let bases = [1, 1].map(|p| BSplineBasis::uniform(p, 1, 0.0, 1.0).unwrap());
    let points = [0.0, 0.0, 0.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
    let saddle = BSplineSurface::new(bases, Dimension::Graph, points, None).unwrap();
    let truth = (2.0 * 3f64.sqrt() + 4.0 * 2f64.ln() + 8.0 * (0.5 + 0.5 * 3f64.sqrt()).ln() - 4.0 * 2f64.ln()) / 6.0
        - PI / 18.0;
    let simpson = {
        // an independent sum: composite Simpson of high resolution
        let n = 400;
        let weight = |k: usize| {
            if k == 0 || k == n {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        let mut sum = 0.0;
        for i in 0..=n {
            for j in 0..=n {
                let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                sum += weight(i) * weight(j) * (1.0 + u * u + v * v).sqrt();
            }
        }
        sum / (9.0 * (n * n) as f64)
    };
    let found = area(&saddle, 1e-12);
    assert!((found.area - simpson).abs() < 1e-10, "{found:?} {simpson} {truth}");
    // what cannot be had is not claimed
    assert!(!area(&saddle, 0.0).converged || area(&saddle, 0.0).error_estimate == 0.0);
}
