//! Writes curves and surfaces as IGES and STEP, and next to each pair of files the true places of
//! every shape at many parameters.
//!
//! `tools/check_cad.py` opens the files with a CAD kernel and compares. The shapes are those that
//! files get wrong: circles and tori (weights, closed), a cone (a side without length), uneven
//! knots far from the origin, graphs with and without weights, loose ends, names outside of ASCII.
//!
//! Run: `cargo run -p engine-benches --example export_cad -- FOLDER`

use std::{error::Error, f64::consts::FRAC_1_SQRT_2, fs, path::Path};

use flankfit_engine::{
    formats::{CadShape, Label, NamedShape, UtcTime, iges, step},
    geometry::{
        BSplineBasis,
        curve::{BSplineCurve, Curve},
        space::{Dimension, Vector},
        surface::{BSplineSurface, Surface},
    },
};
use serde_json::{Value, json};

type Outcome<T> = Result<T, Box<dyn Error>>;

enum Shape {
    Curve(BSplineCurve),
    Surface(BSplineSurface),
}

/// A full turn in nine control points of degree 2: knots, directions in the plane, weights.
const TURN: ([f64; 12], [[f64; 2]; 9]) = (
    [0., 0., 0., 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1., 1., 1.],
    [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]],
);

fn turn_weight(i: usize) -> f64 {
    if i % 2 == 1 { FRAC_1_SQRT_2 } else { 1.0 }
}

fn circle(radius: f64) -> Outcome<BSplineCurve> {
    let (knots, directions) = TURN;
    let points = directions.map(|[x, y]| Vector::new(radius * x, radius * y, 0.0)).to_vec();
    let weights = (0..9).map(turn_weight).collect();
    Ok(BSplineCurve::new(BSplineBasis::new(2, knots.to_vec())?, Dimension::Plane, points, Some(weights))?)
}

/// The profile (distance from the z axis, height, weight) turned about the z axis; v runs along the
/// profile.
fn revolved(profile: &BSplineBasis, points: &[[f64; 3]]) -> Outcome<BSplineSurface> {
    let (knots, directions) = TURN;
    let mut net = Vec::new();
    let mut weights = Vec::new();
    for (i, [x, y]) in directions.into_iter().enumerate() {
        for [r, z, w] in points {
            net.push(Vector::new(r * x, r * y, *z));
            weights.push(turn_weight(i) * w);
        }
    }
    let bases = [BSplineBasis::new(2, knots.to_vec())?, profile.clone()];
    Ok(BSplineSurface::new(bases, Dimension::Space, net, Some(weights))?)
}

fn torus() -> Outcome<BSplineSurface> {
    let (knots, directions) = TURN;
    let tube: Vec<_> =
        directions.iter().enumerate().map(|(i, [x, y])| [30.0 + 8.0 * x, 8.0 * y, turn_weight(i)]).collect();
    revolved(&BSplineBasis::new(2, knots.to_vec())?, &tube)
}

/// A quarter of a cylinder: radius 12.5 about z, from z = −3 to 40.
fn cylinder() -> Outcome<BSplineSurface> {
    let bases = [BSplineBasis::new(2, vec![0., 0., 0., 2., 2., 2.])?, BSplineBasis::new(1, vec![-3., -3., 40., 40.])?];
    let corners = [[12.5, 0.0], [12.5, 12.5], [0.0, 12.5]];
    let points = corners.iter().flat_map(|[x, y]| [-3.0, 40.0].map(|z| Vector::new(*x, *y, z))).collect();
    let weights = vec![1.0, 1.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2, 1.0, 1.0];
    Ok(BSplineSurface::new(bases, Dimension::Space, points, Some(weights))?)
}

fn uneven() -> Outcome<[BSplineBasis; 2]> {
    Ok([
        BSplineBasis::new(3, vec![5.97, 5.97, 5.97, 5.97, 6.1, 7.3, 7.3, 10.9, 11.52, 11.52, 11.52, 11.52])?,
        BSplineBasis::new(3, vec![0.75, 0.75, 0.75, 0.75, 0.8, 3.0, 14.25, 14.25, 14.25, 14.25])?,
    ])
}

/// Something without symmetry in [−1, 1].
fn wave(i: usize, j: usize) -> f64 {
    (1.7 * i as f64 + 0.3 * (j * j) as f64 + 0.1).sin()
}

fn bicubic() -> Outcome<BSplineSurface> {
    let bases = uneven()?;
    let (m, n) = (bases[0].size(), bases[1].size());
    let point = |i: usize, j: usize| {
        Vector::new(1000.0 + 3.0 * i as f64 + wave(j, i), -2000.0 + 4.0 * j as f64 + wave(i, j), 7.0 * wave(i + 2, j))
    };
    let points = (0..m).flat_map(|i| (0..n).map(move |j| point(i, j))).collect();
    Ok(BSplineSurface::new(bases, Dimension::Space, points, None)?)
}

fn graph(rational: bool) -> Outcome<BSplineSurface> {
    let bases = uneven()?;
    let (m, n) = (bases[0].size(), bases[1].size());
    let each = |f: fn(usize, usize) -> f64| (0..m).flat_map(move |i| (0..n).map(move |j| f(i, j)));
    let points = each(wave).map(|z| Vector::new(0.05 * z, 0.0, 0.0)).collect();
    let weights = rational.then(|| each(|i, j| 1.0 + 0.6 * wave(j, i)).collect());
    Ok(BSplineSurface::new(bases, Dimension::Graph, points, weights)?)
}

/// Knots whose ends have multiplicity 1.
fn loose(dimension: Dimension, rational: bool) -> Outcome<BSplineCurve> {
    let basis = BSplineBasis::new(3, vec![-2., -1., -0.5, 0., 1., 2.5, 2.5, 4., 5., 7., 7.5])?;
    let point = |i| Vector::new(5.0 * wave(i, 0), 5.0 * wave(0, i), 5.0 * wave(i, i));
    let masked = |i| if dimension == Dimension::Space { point(i) } else { Vector::new(point(i).x, 0.0, 0.0) };
    let weights = rational.then(|| (0..7).map(|i| 1.0 + 0.5 * wave(i, 3)).collect());
    Ok(BSplineCurve::new(basis, dimension, (0..7).map(masked).collect(), weights)?)
}

/// A file's name, and its shapes with their names.
type Case = (&'static str, Vec<(&'static str, Shape)>);

fn cases() -> Outcome<Vec<Case>> {
    let line = BSplineBasis::new(1, vec![0., 0., 1., 1.])?;
    let cone = revolved(&line, &[[0.0, 20.0, 1.0], [9.0, -4.0, 1.0]])?;
    Ok(vec![
        ("circle", vec![("circle", Shape::Curve(circle(25.0)?))]),
        ("loose_ends", vec![("loose ends", Shape::Curve(loose(Dimension::Space, false)?))]),
        ("graph_curve", vec![("y(x)", Shape::Curve(loose(Dimension::Graph, false)?))]),
        ("graph_curve_rational", vec![("y(x) with weights", Shape::Curve(loose(Dimension::Graph, true)?))]),
        ("torus", vec![("torus", Shape::Surface(torus()?))]),
        ("cylinder", vec![("a quarter", Shape::Surface(cylinder()?))]),
        ("cone", vec![("cone", Shape::Surface(cone))]),
        ("bicubic", vec![("uneven, far away", Shape::Surface(bicubic()?))]),
        ("graph", vec![("z(u,v)", Shape::Surface(graph(false)?))]),
        ("graph_rational", vec![("z(u,v) with weights", Shape::Surface(graph(true)?))]),
        (
            "several",
            vec![
                ("Zahnflanke 'links' \\ ä", Shape::Surface(bicubic()?)),
                ("a;b,c#1 'rim'", Shape::Curve(circle(9.0)?)),
                ("", Shape::Surface(cylinder()?)),
                ("the last one", Shape::Curve(loose(Dimension::Space, true)?)),
            ],
        ),
    ])
}

fn places([a, b]: [f64; 2], count: usize) -> Vec<f64> {
    (0..=count).map(|k| if k == count { b } else { a + (b - a) * k as f64 / count as f64 }).collect()
}

/// Parameters, and the places there.
fn expected(name: &str, shape: &Shape) -> Value {
    let row = |p: Vector| [p.x, p.y, p.z];
    match shape {
        Shape::Curve(curve) => {
            let at = places(curve.domain(), 211);
            let points: Vec<_> = at.iter().map(|t| row(curve.place(*t)[0])).collect();
            json!({"name": name, "kind": "curve", "at": at, "points": points})
        }
        Shape::Surface(surface) => {
            let [us, vs] = surface.domain().map(|domain| places(domain, 31));
            let at: Vec<_> = us.iter().flat_map(|u| vs.iter().map(move |v| [*u, *v])).collect();
            let points: Vec<_> = at.iter().map(|[u, v]| row(surface.place(*u, *v).value)).collect();
            json!({"name": name, "kind": "surface", "at": at, "points": points})
        }
    }
}

fn main() -> Outcome<()> {
    let folder = std::env::args().nth(1).ok_or("the folder to write to is missing")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    for (file, shapes) in cases()? {
        let label = Label {
            name: format!("{file} of z = 52, α = 20°"),
            author: "export_cad".to_owned(),
            organization: String::new(),
            written_at: UtcTime::new([2026, 1, 2], [3, 4, 5]).ok_or("no such moment")?,
        };
        let named: Vec<_> = shapes
            .iter()
            .map(|(name, shape)| {
                let shape = match shape {
                    Shape::Curve(curve) => CadShape::Curve(curve),
                    Shape::Surface(surface) => CadShape::Surface(surface),
                };
                NamedShape { name, shape }
            })
            .collect();
        fs::write(folder.join(format!("{file}.igs")), iges::write(&named, &label)?)?;
        fs::write(folder.join(format!("{file}.stp")), step::write(&named, &label)?)?;
        let values: Vec<Value> = shapes.iter().map(|(name, shape)| expected(name, shape)).collect();
        fs::write(folder.join(format!("{file}.json")), serde_json::to_string(&values)?)?;
    }
    Ok(())
}
