//! Shapes to be exported, drawn at random and by hand.

use flankfit_engine::{
    formats::{Label, UtcTime},
    geometry::{
        BSplineBasis,
        curve::BSplineCurve,
        space::{Dimension, Vector},
        surface::BSplineSurface,
    },
};
use proptest::prelude::*;

pub fn label() -> Label {
    Label {
        name: "Rad 'z = 52'; α, \\ 20°".to_owned(),
        author: "A. N. Other".to_owned(),
        organization: "Zahnräder, Söhne".to_owned(),
        written_at: UtcTime::new([2026, 11, 21], [16, 5, 9]).expect("a moment"),
    }
}

/// Any double that a coordinate may be.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -1e3..1e3, 1 => -1e-9..1e-9, 1 => Just(0.1 + 0.2), 1 => Just(-0.0), 1 => -1e300..1e300]
}

fn point() -> impl Strategy<Value = Vector> {
    [coordinate(), coordinate(), coordinate()].prop_map(|[x, y, z]| Vector::new(x, y, z))
}

/// A clamped basis, inner knots up to `degree` times.
fn basis() -> impl Strategy<Value = BSplineBasis> {
    let inner = prop::collection::vec((0.01..2.0f64, 1usize..4), 0..4);
    (1usize..5, -50.0..50.0f64, inner, 0.01..3.0f64).prop_map(|(degree, low, inner, last)| {
        let mut knots = vec![low; degree + 1];
        let mut at = low;
        for (step, times) in inner {
            at += step;
            knots.extend(vec![at; times.min(degree)]);
        }
        knots.extend(vec![at + last; degree + 1]);
        BSplineBasis::new(degree, knots).expect("ascending knots")
    })
}

fn weights(count: usize) -> impl Strategy<Value = Option<Vec<f64>>> {
    prop::option::of(prop::collection::vec(0.01..20.0f64, count))
}

pub fn curves() -> impl Strategy<Value = BSplineCurve> {
    basis().prop_flat_map(|basis| {
        let size = basis.size();
        (Just(basis), prop::collection::vec(point(), size), weights(size)).prop_map(|(basis, points, weights)| {
            BSplineCurve::new(basis, Dimension::Space, points, weights).expect("a curve")
        })
    })
}

pub fn surfaces() -> impl Strategy<Value = BSplineSurface> {
    (basis(), basis()).prop_flat_map(|(u, v)| {
        let size = u.size() * v.size();
        let net = (prop::collection::vec(point(), size), weights(size));
        (Just([u, v]), net).prop_map(|(bases, (points, weights))| {
            BSplineSurface::new(bases, Dimension::Space, points, weights).expect("a surface")
        })
    })
}

/// Names with everything that a format might stumble over.
pub fn names() -> impl Strategy<Value = String> {
    prop_oneof![Just(String::new()), "[ -~äß√𝄞\n]{1,90}"]
}

/// Corners (u low, v low), (u low, v high), (u high, v low), (u high, v high).
pub fn bilinear(corners: [[f64; 3]; 4]) -> BSplineSurface {
    let line = || BSplineBasis::new(1, vec![0., 0., 1., 1.]).expect("two knots twice");
    let points = corners.map(|[x, y, z]| Vector::new(x, y, z)).to_vec();
    BSplineSurface::new([line(), line()], Dimension::Space, points, None).expect("a surface")
}

/// A quarter of a cone: apex (0, 0, 4) at v = 0, radius 3 in the plane z = 0 at v = 1.
pub fn quarter_cone() -> BSplineSurface {
    let basis = |degree, knots: &[f64]| BSplineBasis::new(degree, knots.to_vec()).expect("knots");
    let bases = [basis(2, &[0., 0., 0., 1., 1., 1.]), basis(1, &[0., 0., 1., 1.])];
    let corners = [[3., 0.], [3., 3.], [0., 3.]];
    let points = corners.iter().flat_map(|[x, y]| [Vector::new(0., 0., 4.), Vector::new(*x, *y, 0.)]).collect();
    let middle = 0.5f64.sqrt();
    let weights = vec![1.0, 1.0, middle, middle, 1.0, 1.0];
    BSplineSurface::new(bases, Dimension::Space, points, Some(weights)).expect("a surface")
}
