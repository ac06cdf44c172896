//! Sections that are easily missed or muddled: against roots of cubics along scan lines, loops of
//! known size, and planes that touch, pass corners or lie in the surface.

use std::f64::consts::PI;

use flankfit_engine::geometry::{
    BSplineBasis,
    space::{Dimension, Vector},
    surface::{
        BSplineSurface, BezierSurface, SurfaceShape,
        section::{Description, Plane, Section, SectionCurve, Sections},
    },
};
use proptest::prelude::*;

const FINE: Description = Description { tolerance: 1e-9, chords: false, most: 100_000 };
const LEVEL: Vector = Vector::new(0.0, 0.0, 1.0);

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |c, i| c * (n + 1 - i) as f64 / i as f64)
}

/// z = Σ c[i][j] (u − at₀)ⁱ (v − at₁)ʲ over the unit square, in Bernstein form.
fn powers<const M: usize, const N: usize>(at: [f64; 2], c: [[f64; N]; M]) -> BSplineSurface {
    // (x − a)^i in Bernstein form of degree n: Σ over its expansion in powers of x
    let form = |i: usize, n: usize, a: f64| -> Vec<f64> {
        (0..=n)
            .map(|k| {
                let term = |p: usize| {
                    let share = if p <= k { binomial(k, p) / binomial(n, p) } else { 0.0 };
                    binomial(i, p) * (-a).powi((i - p) as i32) * share
                };
                (0..=i).map(term).sum()
            })
            .collect()
    };
    let mut heights = vec![Vector::zeros(); M * N];
    for (i, row) in c.iter().enumerate() {
        for (j, own) in row.iter().enumerate() {
            let (along_u, along_v) = (form(i, M - 1, at[0]), form(j, N - 1, at[1]));
            for (k, height) in heights.iter_mut().enumerate() {
                height.x += own * along_u[k / N] * along_v[k % N];
            }
        }
    }
    BezierSurface::new([M, N], [[0.0, 1.0]; 2], Dimension::Graph, heights, None).unwrap().as_b_spline().clone()
}

/// (u − at₀)² + b (v − at₁)².
fn bowl(at: [f64; 2], b: f64) -> BSplineSurface {
    powers(at, [[0.0, 0.0, b], [0.0; 3], [1.0, 0.0, 0.0]])
}

fn level(surface: &BSplineSurface, offset: f64) -> Section {
    let shape = SurfaceShape::BSpline(surface.clone());
    Sections::of(&shape).by(&Plane { normal: LEVEL, offset }, FINE).unwrap()
}

fn refined(surface: &BSplineSurface, u: &[f64], v: &[f64]) -> BSplineSurface {
    surface.refine(0, u).unwrap().refine(1, v).unwrap()
}

fn lengths(found: &Section) -> Vec<f64> {
    let mut lengths: Vec<f64> = found.curves.iter().map(SectionCurve::length).collect();
    lengths.sort_by(f64::total_cmp);
    lengths
}

#[track_caller]
fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted}");
}

/// Number of times that the curves pass `at` along parameter `axis`.
fn passed(found: &Section, axis: usize, at: f64) -> usize {
    let count = |curve: &SectionCurve| {
        let above: Vec<bool> = curve.points.iter().map(|point| point.parameters[axis] > at).collect();
        above.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    found.curves.iter().map(count).sum()
}

/// Number of roots in (0, 1) of a cubic with these Bernstein coefficients; `None` if two come too
/// near to each other to be counted.
fn roots(b: [f64; 4]) -> Option<usize> {
    let value = |t: f64| {
        let s = 1.0 - t;
        b[0] * s * s * s + 3.0 * b[1] * s * s * t + 3.0 * b[2] * s * t * t + b[3] * t * t * t
    };
    // between its extrema a cubic has one root where its sign changes
    let [d0, d1, d2] = [b[1] - b[0], b[2] - b[1], b[3] - b[2]];
    let (a, half, c) = (d0 - 2.0 * d1 + d2, d1 - d0, d0);
    let root = (half * half - a * c).max(0.0).sqrt();
    let mut places = vec![0.0, 1.0];
    places.extend([(-half - root) / a, (-half + root) / a].into_iter().filter(|t| *t > 0.0 && *t < 1.0));
    places.sort_by(f64::total_cmp);
    let values: Vec<f64> = places.into_iter().map(value).collect();
    let count = values.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count();
    values.iter().all(|value| value.abs() > 1e-4).then_some(count)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]
    /// Along scan lines the curves are where a cubic has its roots: none is missed, none is there
    /// twice, with one piece and with knots anywhere.
    #[test]
    fn scan_lines_pass_as_often_as_a_cubic_has_roots(
        heights in prop::collection::vec(-1.0..1.0f64, 16),
        offset in -0.3..0.3f64,
        knots in prop::array::uniform4(0.02..0.98f64),
    ) {
        let points = heights.iter().map(|z| Vector::new(*z, 0.0, 0.0)).collect();
        let patch = BezierSurface::new([4, 4], [[0.0, 1.0]; 2], Dimension::Graph, points, None).unwrap();
        let whole = patch.as_b_spline().clone();
        let [a, b, c, d] = knots;
        let fine = refined(&whole, &[a.min(b), a.max(b) + 1e-3], &[c.min(d), c.max(d) + 1e-3]);
        for surface in [&whole, &fine] {
            let found = level(surface, offset);
            prop_assert!(found.unresolved.is_empty() && !found.coincident);
            for curve in &found.curves {
                prop_assert!(curve.error <= 1e-9, "{}", curve.error);
                for point in &curve.points {
                    prop_assert!((point.point.z - offset).abs() < 1e-13);
                }
            }
            for k in 1..40 {
                let at = f64::from(k) / 40.0 + 1e-3;
                let bernstein =
                    [0, 1, 2, 3].map(|i| binomial(3, i) * at.powi(i as i32) * (1.0 - at).powi(3 - i as i32));
                for axis in 0..2 {
                    let along = [0, 1, 2, 3].map(|i| {
                        let height = |j: usize| heights[if axis == 0 { 4 * j + i } else { 4 * i + j }];
                        (0..4).map(|j| bernstein[j] * (height(j) - offset)).sum()
                    });
                    if let Some(count) = roots(along) {
                        prop_assert_eq!(passed(&found, axis, at), count, "axis {} at {}", axis, at);
                    }
                }
            }
        }
    }

    /// A small loop anywhere is found with its length, whatever lies between the knots.
    #[test]
    fn small_loops_are_found(
        at in prop::array::uniform2(0.1..0.9f64),
        size in -4.0..-1.1f64,
        knots in prop::array::uniform2(0.1..0.9f64),
    ) {
        let radius = 10_f64.powf(size);
        let cup = bowl(at, 1.0);
        for surface in [cup.clone(), refined(&cup, &knots[..1], &knots[1..]), refined(&cup, &at[..1], &at[1..])] {
            let found = level(&surface, radius * radius);
            prop_assert!(found.unresolved.is_empty() && found.contacts.is_empty());
            prop_assert_eq!(found.curves.len(), 1, "{}", radius);
            prop_assert!(found.curves[0].closed);
            close(found.curves[0].length(), 2.0 * PI * radius, 1e-9);
        }
    }

    /// A circle that leaves the domain by less than a cell and comes back is an arc; what only
    /// reaches in is an arc as well.
    #[test]
    fn circles_that_just_pass_a_border(place in 0.35..0.65f64, depth in -9.0..-3.0f64) {
        let (radius, out) = (0.3, 10_f64.powf(depth));
        let half = ((radius - out) / radius).acos();
        let inner = level(&bowl([place, radius - out], 1.0), radius * radius);
        prop_assert_eq!(inner.curves.len(), 1);
        prop_assert!(!inner.curves[0].closed && inner.unresolved.is_empty());
        close(inner.curves[0].length(), 2.0 * radius * (PI - half), 1e-7);
        let outer = level(&bowl([place, out - radius], 1.0), radius * radius);
        prop_assert_eq!(outer.curves.len(), 1);
        prop_assert!(outer.unresolved.is_empty());
        close(outer.curves[0].length(), 2.0 * radius * half, 1e-7);
        // a knot there changes nothing
        let whole = level(&refined(&bowl([0.5, 0.5], 1.0), &[], &[0.2 + out]), radius * radius);
        prop_assert_eq!(whole.curves.len(), 1);
        prop_assert!(whole.curves[0].closed && whole.unresolved.is_empty());
        close(whole.curves[0].length(), 2.0 * PI * radius, 1e-7);
    }
}

#[test]
fn a_circle_that_touches_a_border_or_a_knot() {
    for surface in [bowl([0.5, 0.3], 1.0), refined(&bowl([0.5, 0.5], 1.0), &[0.5], &[0.2])] {
        let found = level(&surface, 0.09);
        assert!(found.unresolved.is_empty(), "{found:?}");
        close(lengths(&found).iter().sum(), 0.6 * PI, 1e-6);
        assert_eq!(found.curves.len(), 1);
    }
}

/// Cassini's ovals about a lemniscate: two loops, a figure of eight, one loop.
#[test]
fn ovals_of_cassini() {
    for c in [0.25_f64, 0.02] {
        let mut terms = [[0.0; 5]; 5];
        terms[4][0] = 1.0;
        terms[2][2] = 2.0;
        terms[0][4] = 1.0;
        terms[2][0] = -2.0 * c * c;
        terms[0][2] = 2.0 * c * c;
        for at in [[0.5, 0.5], [0.37, 0.61]] {
            let ovals = powers(at, terms);
            let near = 1e-3 * c.powi(4);
            let apart = level(&ovals, -near);
            assert_eq!((apart.curves.len(), apart.branch_points.len()), (2, 0), "{apart:?}");
            for curve in &apart.curves {
                let [first, .., last] = &curve.points[..] else { panic!() };
                assert!(curve.closed, "{c} {at:?}: {first:?} {last:?}");
            }
            let one = level(&ovals, near);
            assert_eq!((one.curves.len(), one.branch_points.len()), (1, 0));
            assert!(apart.unresolved.is_empty() && one.unresolved.is_empty());
            if c > 0.1 {
                let eight = level(&ovals, 0.0);
                assert_eq!((eight.curves.len(), eight.branch_points.len()), (2, 1), "{eight:?}");
                // Γ(1/4)² / √π times half of c √2
                let wanted = 5.244_115_108_584_24 * c * 2_f64.sqrt();
                close(lengths(&eight).iter().sum(), wanted, 1e-7);
            }
        }
    }
}

#[test]
fn sides_and_corners() {
    // u v over the square: two sides
    let corner = powers([0.0, 0.0], [[0.0, 0.0], [0.0, 1.0]]);
    let found = level(&corner, 0.0);
    assert_eq!(lengths(&found), [1.0, 1.0], "{found:?}");
    // u (v − 0.4): a side in two parts, and a line across
    let side = powers([0.0, 0.4], [[0.0, 0.0], [0.0, 1.0]]);
    for surface in [side.clone(), refined(&side, &[0.5], &[0.5]), refined(&side, &[0.5], &[0.4])] {
        let found = level(&surface, 0.0);
        let lengths = lengths(&found);
        assert_eq!(lengths.len(), 3, "{found:?}");
        for (length, wanted) in lengths.iter().zip([0.4, 0.6, 1.0]) {
            close(*length, wanted, 1e-9);
        }
        assert_eq!(found.branch_points.len(), 1);
    }
    // (u − 0.4)(v − 0.6) + 0.2 … inside, with a knot through the place where branches cross
    let inside = powers([0.4, 0.6], [[0.0, 0.0], [0.0, 1.0]]);
    for surface in [inside.clone(), refined(&inside, &[0.4], &[0.3]), refined(&inside, &[0.4], &[0.6])] {
        let found = level(&surface, 0.0);
        close(lengths(&found).iter().sum(), 2.0, 1e-9);
        assert_eq!((found.branch_points.len(), found.curves.len()), (1, 4), "{found:?}");
    }
    // from corner to corner
    let diagonal = powers([0.0, 0.0], [[0.0, -1.0], [1.0, 0.0]]);
    let found = level(&diagonal, 0.0);
    assert_eq!(found.curves.len(), 1, "{found:?}");
    close(found.curves[0].length(), 2_f64.sqrt(), 1e-12);
    // nothing but a corner
    let found = level(&powers([0.0, 0.0], [[0.0, 1.0], [1.0, 0.0]]), 0.0);
    assert!(found.curves.is_empty() && found.unresolved.is_empty());
}

/// If the plane touches so flatly that no second derivative decides on the kind of contact, the
/// place is reported and does not go missing.
#[test]
fn flat_contact_is_reported() {
    let cubic = [[0.0], [0.0], [0.0], [1.0]];
    let quartic = [[0.0], [0.0], [0.0], [0.0], [1.0]];
    let monkey = [[0.0, 0.0, 0.0], [0.0, 0.0, -3.0], [0.0; 3], [1.0, 0.0, 0.0]];
    let wide = |c: &[[f64; 1]]| -> Vec<[f64; 2]> { c.iter().map(|[x]| [*x, 0.0]).collect() };
    let [cubic, quartic] = [wide(&cubic), wide(&quartic)];
    for at in [[0.5, 0.5], [0.37, 0.61]] {
        let surfaces = [
            powers::<4, 2>(at, cubic.clone().try_into().unwrap()),
            powers::<5, 2>(at, quartic.clone().try_into().unwrap()),
            powers(at, monkey),
        ];
        for (k, surface) in surfaces.iter().enumerate() {
            let found = level(surface, 0.0);
            assert!(!found.unresolved.is_empty() || !found.curves.is_empty(), "{k} {at:?}");
            assert!(!found.coincident, "{k} {at:?}");
        }
    }
}

/// A roof with a flat part in the plane.
#[test]
fn a_part_in_the_plane() {
    let heights = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
    let knots = |knots: &[f64]| BSplineBasis::new(1, knots.to_vec()).unwrap();
    let bases = [knots(&[0., 0., 1., 2., 2.]), knots(&[0., 0., 1., 1.])];
    let roof = BSplineSurface::new(bases, Dimension::Graph, heights, None).unwrap();
    let found = level(&roof, 0.0);
    assert!(found.coincident && found.unresolved.is_empty());
    assert_eq!(lengths(&found), [1.0], "its border: {found:?}");
    let above = level(&roof, 0.25);
    assert!(!above.coincident);
    assert_eq!(lengths(&above), [1.0]);
    close(above.curves[0].points[0].point.x, 1.25, 1e-15);
}

/// Weights that nearly vanish make the parameters nearly constant at the sides.
#[test]
fn sections_with_nearly_stationary_parameters() {
    let basis = BSplineBasis::uniform(2, 1, 0.0, 1.0).unwrap();
    let point = |k: usize| Vector::new((k / 3) as f64, (k % 3) as f64, ((k / 3) * (k % 3)) as f64);
    for light in [0.1, 1e-2, 1e-4, 1e-6] {
        let weight = |k: usize| if k.is_multiple_of(2) && k != 4 { 1.0 } else { light };
        let points = (0..9).map(point).collect();
        let bases = [basis.clone(), basis.clone()];
        let surface = BSplineSurface::new(bases, Dimension::Space, points, Some((0..9).map(weight).collect())).unwrap();
        for offset in [0.5, 0.9999, 1.0] {
            let found = level(&surface, offset);
            assert!(!found.curves.is_empty() || !found.unresolved.is_empty(), "{light} {offset}");
            for curve in &found.curves {
                curve.shape().unwrap();
                assert!(curve.points.iter().all(|point| (point.point.z - offset).abs() < 1e-12));
            }
        }
    }
}
