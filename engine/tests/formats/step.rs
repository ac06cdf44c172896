//! STEP: grammar, references and product structure; knots, weights and points come back bit by bit.

use flankfit_engine::{
    formats::{CadShape, NamedShape, step},
    geometry::{BSplineBasis, curve::BSplineCurve, surface::BSplineSurface},
};
use proptest::prelude::*;

use super::{
    shapes::{bilinear, curves, label, names, quarter_cone, surfaces},
    step_file::{File, Value, read},
};

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

fn check_knots(counts: &Value, knots: &Value, basis: &BSplineBasis) {
    let counts: Vec<usize> = counts.list().iter().map(Value::integer).collect();
    let knots = knots.reals();
    assert!(knots.windows(2).all(|k| k[0] < k[1]) && counts.len() == knots.len());
    let full: Vec<f64> = knots.iter().zip(&counts).flat_map(|(k, n)| vec![*k; *n]).collect();
    assert_eq!(bits(&full), bits(basis.knots()));
}

fn check_points(file: &File, points: &[Value], expected: &[flankfit_engine::geometry::space::Vector]) {
    assert_eq!(points.len(), expected.len());
    for (point, expected) in points.iter().zip(expected) {
        let coordinates = file.part(point.reference(), "CARTESIAN_POINT").expect("a point")[1].reals();
        assert_eq!(bits(&coordinates), bits(expected.as_slice()));
    }
}

/// Parameters of the parts of a simple or complex instance, and its name.
fn parts(file: &File, id: usize, kind: &str) -> (Vec<Value>, Vec<Value>, Option<Value>, Value) {
    let with_knots = format!("B_SPLINE_{kind}_WITH_KNOTS");
    let all = file.part(id, &with_knots).expect("a spline");
    match file.part(id, &format!("RATIONAL_B_SPLINE_{kind}")) {
        None => {
            let split = all.len() - if kind == "CURVE" { 3 } else { 5 };
            (all[1..split].to_vec(), all[split..].to_vec(), None, all[0].clone())
        }
        Some(weights) => {
            let bounded = format!("BOUNDED_{kind}");
            for part in [bounded.as_str(), kind, "GEOMETRIC_REPRESENTATION_ITEM"] {
                assert_eq!(file.part(id, part), Some(&[][..]));
            }
            let spline = file.part(id, &format!("B_SPLINE_{kind}")).expect("the spline's part").to_vec();
            let name = file.part(id, "REPRESENTATION_ITEM").expect("a name")[0].clone();
            (spline, all.to_vec(), Some(weights[0].clone()), name)
        }
    }
}

fn expected_weights(weights: Option<&[f64]>) -> Option<Vec<u64>> {
    weights.filter(|w| w.iter().any(|x| *x != w[0])).map(bits)
}

fn check_curve(file: &File, id: usize, curve: &BSplineCurve, name: &str) {
    let (spline, knots, weights, label) = parts(file, id, "CURVE");
    assert_eq!(label, Value::Text(name.to_owned()));
    assert_eq!(spline[0].integer(), curve.basis().degree());
    check_points(file, spline[1].list(), curve.control_points());
    check_knots(&knots[0], &knots[1], curve.basis());
    assert_eq!(weights.map(|w| bits(&w.reals())), expected_weights(curve.weights()));
}

fn check_surface(file: &File, id: usize, surface: &BSplineSurface) {
    let (spline, knots, weights, _) = parts(file, id, "SURFACE");
    let [u, v] = surface.bases();
    assert_eq!((spline[0].integer(), spline[1].integer()), (u.degree(), v.degree()));
    let rows = spline[2].list();
    assert_eq!(rows.len(), u.size());
    assert!(rows.iter().all(|row| row.list().len() == v.size()));
    check_points(file, &rows.iter().flat_map(Value::list).cloned().collect::<Vec<_>>(), surface.control_points());
    check_knots(&knots[0], &knots[2], u);
    check_knots(&knots[1], &knots[3], v);
    let flat = weights.map(|w| w.list().iter().flat_map(Value::reals).collect::<Vec<_>>());
    assert_eq!(flat.map(|w| bits(&w)), expected_weights(surface.weights()));
}

/// From the product down to the items of its representations.
fn items(file: &File) -> Vec<usize> {
    let [definition] = file.all("SHAPE_DEFINITION_REPRESENTATION")[..] else { panic!("one definition") };
    let shape = file.part(definition[0].reference(), "PRODUCT_DEFINITION_SHAPE").expect("a shape");
    let product = file.part(shape[2].reference(), "PRODUCT_DEFINITION").expect("a definition");
    let formation = file.part(product[2].reference(), "PRODUCT_DEFINITION_FORMATION").expect("a formation");
    let product = file.part(formation[2].reference(), "PRODUCT").expect("a product");
    assert_eq!(product[0], Value::Text(label().name));
    let mut representations = vec![definition[1].reference()];
    for relation in file.all("SHAPE_REPRESENTATION_RELATIONSHIP") {
        assert_eq!(relation[2].reference(), representations[0]);
        representations.push(relation[3].reference());
    }
    let mut items = Vec::new();
    for id in representations {
        let (_, values) = &file.data[&id][0];
        let context = &file.data[&values[2].reference()];
        assert!(context.iter().any(|(name, _)| name == "GLOBAL_UNIT_ASSIGNED_CONTEXT"));
        items.extend(values[1].list().iter().map(Value::reference));
    }
    items
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn shapes_come_back(curve in curves(), surface in surfaces(), first in names(), second in names()) {
        let shapes = [
            NamedShape { name: &first, shape: CadShape::Curve(&curve) },
            NamedShape { name: &second, shape: CadShape::Surface(&surface) },
        ];
        let file = read(&step::write(&shapes, &label()).expect("a file"));
        let items = items(&file);
        let set = items.iter().find_map(|id| file.part(*id, "GEOMETRIC_CURVE_SET")).expect("a set of curves");
        check_curve(&file, set[1].list()[0].reference(), &curve, &first);
        let model = items.iter().find_map(|id| file.part(*id, "SHELL_BASED_SURFACE_MODEL")).expect("a model");
        let shell = file.part(model[1].list()[0].reference(), "OPEN_SHELL").expect("a shell");
        let face = file.part(shell[1].list()[0].reference(), "ADVANCED_FACE").expect("a face");
        prop_assert_eq!(&face[0], &Value::Text(second));
        check_surface(&file, face[2].reference(), &surface);
    }
}

/// Edges of the only face, each with the vertices it runs between, in the direction of the loop.
fn around(file: &File) -> Vec<[usize; 2]> {
    let [edges] = file.all("EDGE_LOOP")[..] else { panic!("one loop") };
    let ends = |id: &Value| {
        let oriented = file.part(id.reference(), "ORIENTED_EDGE").expect("an oriented edge");
        let edge = file.part(oriented[3].reference(), "EDGE_CURVE").expect("an edge");
        let [from, to] = [edge[1].reference(), edge[2].reference()];
        if oriented[4] == Value::Enumeration("T".into()) { [from, to] } else { [to, from] }
    };
    edges[1].list().iter().map(ends).collect()
}

#[test]
fn the_loop_around_a_face_closes() {
    let square = bilinear([[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 1.]]);
    for (surface, sides) in [(square, 4), (quarter_cone(), 3)] {
        let shapes = [NamedShape { name: "f", shape: CadShape::Surface(&surface) }];
        let file = read(&step::write(&shapes, &label()).expect("a file"));
        let edges = around(&file);
        assert_eq!(edges.len(), sides);
        for (k, edge) in edges.iter().enumerate() {
            assert_eq!(edge[1], edges[(k + 1) % sides][0]);
        }
        assert_eq!(file.all("VERTEX_POINT").len(), sides);
    }
}

#[test]
fn header_units_and_repeatability() {
    let square = bilinear([[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 1.]]);
    let shapes = [NamedShape { name: "f", shape: CadShape::Surface(&square) }];
    let text = step::write(&shapes, &label()).expect("a file");
    let file = read(&text);
    let header: Vec<&str> = file.header.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(header, ["FILE_DESCRIPTION", "FILE_NAME", "FILE_SCHEMA"]);
    let named = &file.header[1].1;
    let one = |text: &str| Value::List(vec![Value::Text(text.to_owned())]);
    assert_eq!(named[..2], [Value::Text(label().name), Value::Text("2026-11-21T16:05:09Z".to_owned())]);
    assert_eq!(named[2..4], [one("A. N. Other"), one("Zahnräder, Söhne")]);
    let schema = one("AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }");
    assert_eq!(file.header[2].1, [schema]);
    let length = file.data.values().find(|i| i[0].0 == "LENGTH_UNIT").expect("a unit of length");
    let [milli, metre] = ["MILLI", "METRE"].map(|word| Value::Enumeration(word.to_owned()));
    assert_eq!(length[2], ("SI_UNIT".to_owned(), vec![milli, metre]));
    assert_eq!(step::write(&shapes, &label()).as_ref(), Ok(&text));
}
