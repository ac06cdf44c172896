//! Facets and elements: what is read back has the nodes, the orientation and the area of the
//! surface.

use std::{f64::consts::PI, sync::Arc};

use flankfit_engine::{
    formats::{
        Pieces, QuadMesh, fe_mesh,
        obj::{self, NamedLine, NamedMesh},
        sampling::{curve_nodes, curve_parameters},
        stl, vtk,
    },
    geometry::{
        space::Vector,
        surface::{BSplineSurface, Surface},
    },
    numerics::check::Faults,
};

use super::shapes::{bilinear, label, quarter_cone};

fn left() -> BSplineSurface {
    bilinear([[0., 0., 0.], [0., 2., 0.], [1., 0., 0.], [1., 2., 0.]])
}

/// The mesh of a cone, whose nodes at the apex coincide.
fn cone() -> QuadMesh {
    QuadMesh::of_surfaces(&[&quarter_cone()], [24, 5], 1e-9, true).expect("a mesh")
}

/// Area of a quarter of the cone of that radius and height.
fn cone_area() -> f64 {
    PI * 3.0 * 5.0 / 4.0
}

fn text(file: Result<Pieces, Faults>) -> String {
    String::from_utf8(file.expect("a file").whole()).expect("text")
}

fn numbers(line: &str) -> Vec<f64> {
    line.split([' ', ',']).filter_map(|word| word.parse().ok()).collect()
}

fn vectors<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<Vector> {
    lines.map(|line| Vector::from_row_slice(&numbers(line)[..3])).collect()
}

/// Area and the sum of normals of polygons, by triangles around the first corner.
fn area_vectors(nodes: &[Vector], faces: &[Vec<usize>]) -> Vec<Vector> {
    let of = |face: &Vec<usize>| {
        let fan = (1..face.len() - 1).map(|k| [face[0], face[k], face[k + 1]].map(|i| nodes[i]));
        fan.map(|[a, b, c]| (b - a).cross(&(c - a)) / 2.0).sum()
    };
    faces.iter().map(of).collect()
}

#[test]
fn obj_has_faces_that_turn_with_their_normals() {
    let mesh = Arc::new(cone());
    let other = Arc::new(QuadMesh::of_surfaces(&[&left()], [2, 4], 1e-9, true).expect("a mesh"));
    let line = [Vector::new(0., 0., 0.), Vector::new(0., 0.1 + 0.2, 1e-7)];
    let meshes =
        [NamedMesh { name: "der Kegel", mesh: Arc::clone(&mesh) }, NamedMesh { name: "", mesh: Arc::clone(&other) }];
    let text = text(obj::write(&meshes, &[NamedLine { name: "ä", points: line.to_vec().into() }], &label()));
    let starting = |word: &str| text.lines().filter(|l| l.starts_with(word)).collect::<Vec<_>>();
    assert_eq!(starting("o "), ["o der_Kegel", "o unnamed", "o ?"]);
    let (nodes, normals) = (vectors(starting("v ").into_iter()), vectors(starting("vn ").into_iter()));
    assert_eq!(nodes.len(), mesh.nodes().len() + other.nodes().len() + 2);
    assert_eq!(nodes[..mesh.nodes().len()], *mesh.nodes());
    let mut area = 0.0;
    for line in starting("f ") {
        let pairs: Vec<(usize, usize)> = line[2..]
            .split(' ')
            .map(|corner| corner.split_once("//").expect("a normal"))
            .map(|(a, b)| (a.parse().expect("a node"), b.parse().expect("a normal")))
            .collect();
        let face = pairs.iter().map(|(node, _)| node - 1).collect();
        let vector = area_vectors(&nodes, &[face])[0];
        assert!(pairs.iter().all(|(_, normal)| normals[normal - 1].dot(&vector) > 0.0), "{line}");
        area += vector.norm();
    }
    assert!((area - cone_area() - 2.0).abs() < 0.01, "{area}");
    let last = nodes.len();
    assert_eq!(starting("l "), [format!("l {} {last}", last - 1)]);
    assert_eq!(obj::write(&[], &[], &label()).unwrap_err().to_string(), "there is nothing to write");
}

#[test]
fn stl_omits_faces_without_area() {
    let mesh = Arc::new(cone());
    let text = text(stl::ascii_file(Arc::clone(&mesh), &label()));
    // of 24 × 5 quadrilaterals the 24 at the apex are triangles
    let expected = 24 * 5 * 2 - 24;
    assert_eq!(text.matches("endfacet").count(), expected);
    let corners = vectors(text.lines().filter(|l| l.contains("vertex")));
    let normals = vectors(text.lines().filter(|l| l.contains("facet normal")));
    let faces: Vec<Vec<usize>> = (0..expected).map(|k| vec![3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let areas = area_vectors(&corners, &faces);
    assert!((areas.iter().map(Vector::norm).sum::<f64>() - cone_area()).abs() < 0.01);
    for (normal, area) in normals.iter().zip(&areas) {
        assert!((normal - area / area.norm()).norm() < 1e-12);
    }
    assert!(
        text.starts_with("solid Rad 'z = 52'; ?, \\ 20?\n") && text.ends_with("endsolid Rad 'z = 52'; ?, \\ 20?\n")
    );

    let bytes = stl::binary_file(Arc::clone(&mesh), &label()).expect("a file").whole();
    assert!(!bytes.starts_with(b"solid"));
    assert_eq!(bytes[80..84], u32::try_from(expected).expect("few").to_le_bytes());
    assert_eq!(bytes.len(), 84 + 50 * expected);
    let first: Vec<f32> = bytes[84..132].chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    for (k, x) in first.iter().enumerate() {
        let exact = if k < 3 { normals[0][k] } else { corners[(k - 3) / 3][(k - 3) % 3] };
        assert!((f64::from(*x) - exact).abs() < 1e-6);
    }
}

#[test]
fn coordinates_above_single_precision_are_refused() {
    let far = bilinear([[0., 0., 0.], [0., 1e39, 0.], [1., 0., 0.], [1., 1e39, 0.]]);
    let mesh = Arc::new(QuadMesh::of_surfaces(&[&far], [1, 1], 1e-9, true).expect("a mesh"));
    let refused = stl::binary_file(Arc::clone(&mesh), &label()).unwrap_err();
    assert_eq!(refused.to_string(), "node 1 exceeds the range of the file's numbers");
    assert!(stl::ascii_file(Arc::clone(&mesh), &label()).is_ok());
}

#[test]
fn vtk_poly_data_counts_its_cells() {
    let mesh = Arc::new(cone());
    let line = [Vector::zeros(), Vector::new(1., 2., 3.)];
    let meshes = [NamedMesh { name: "", mesh: Arc::clone(&mesh) }];
    let text = text(vtk::poly_data(&meshes, &[NamedLine { name: "", points: line.to_vec().into() }], &label()));
    let nodes = mesh.nodes().len();
    assert!(text.contains(&format!("POINTS {} double\n", nodes + 2)));
    assert!(text.contains(&format!("LINES 1 3\n2 {nodes} {}\n", nodes + 1)));
    assert!(text.contains(&format!("POLYGONS 120 {}\n", 24 * 4 + 96 * 5)));
    assert!(text.contains(&format!("POINT_DATA {}\n", nodes + 2)));
}

/// Node rows and element rows of a listing, by the lines before and behind them.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    let lines: Vec<&str> = text.lines().collect();
    let from = lines.iter().position(|l| *l == start).unwrap_or_else(|| panic!("{start}"));
    let length = lines[from + 1..].iter().position(|l| l.starts_with(end)).unwrap_or(lines.len() - from - 1);
    lines[from + 1..from + 1 + length].to_vec()
}

fn integers(line: &str) -> Vec<usize> {
    line.split([' ', ',']).filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn finite_element_lists_describe_the_same_mesh() {
    let right = bilinear([[1., 0., 0.], [1., 2., 0.], [3., 0., 0.], [3., 2., 1.]]);
    let surfaces: [&dyn Surface; 3] = [&left(), &right, &quarter_cone()];
    let mesh = Arc::new(QuadMesh::of_surfaces(&surfaces, [24, 5], 1e-9, true).expect("a mesh"));
    // 25×6 twice with 6 in common; the cone has one apex instead of 25, and one foot on a corner of
    // the second patch
    assert_eq!(mesh.nodes().len(), 294 + 25 * 5 + 1 - 1);
    assert_eq!(mesh.faces().len(), 3 * 120);

    let nodes = text(Ok(fe_mesh::nodes_csv(Arc::clone(&mesh))));
    let elements = text(Ok(fe_mesh::elements_csv(Arc::clone(&mesh))));
    assert!(nodes.starts_with("node,x,y,z\n1,") && elements.starts_with("element,node_1,node_2,node_3,node_4\n1,"));
    let places: Vec<Vector> = nodes.lines().skip(1).map(|l| Vector::from_row_slice(&numbers(l)[1..])).collect();
    assert_eq!(places, mesh.nodes());
    let rows: Vec<Vec<usize>> = elements.lines().skip(1).map(integers).collect();
    assert!(rows.iter().enumerate().all(|(k, row)| row.len() == 5 && row[0] == k + 1));
    let faces: Vec<Vec<usize>> = rows.iter().map(|row| row[1..].iter().map(|i| i - 1).collect()).collect();
    let areas = area_vectors(&places, &faces);
    assert!(areas.iter().all(|a| a.norm() > 1e-3));
    let cone: f64 = areas[240..].iter().map(Vector::norm).sum();
    assert!((cone - cone_area()).abs() < 0.01, "{cone}");

    let inp = text(fe_mesh::abaqus(Arc::clone(&mesh), &label()));
    let listed = between(&inp, "*NODE, NSET=NODES", "*");
    assert_eq!(listed.len(), places.len());
    for (k, line) in listed.iter().enumerate() {
        let row = numbers(line);
        assert!(line.split(", ").all(|word| word.len() <= 20));
        assert_eq!(row[0], (k + 1) as f64);
        assert!((Vector::from_row_slice(&row[1..]) - places[k]).norm() <= 1e-12 * places[k].norm());
    }
    let mut listed = between(&inp, "*ELEMENT, TYPE=S4, ELSET=FLANK", "*");
    listed.extend(between(&inp, "*ELEMENT, TYPE=S3, ELSET=FLANK", "*"));
    let mut elements: Vec<Vec<usize>> = listed.iter().map(|l| integers(l)).collect();
    assert_eq!(elements.iter().filter(|e| e.len() == 4).count(), 24);
    elements.sort();
    for (row, element) in rows.iter().zip(&elements) {
        assert_eq!(row[..element.len()], *element);
    }

    let adina = text(fe_mesh::adina(Arc::clone(&mesh), &label()));
    let listed = between(&adina, "COORDINATES NODE SYSTEM=0", "@");
    assert!(listed.is_empty(), "data follow the line that clears the table");
    let blocks: Vec<&str> = adina.split("@CLEAR\n").skip(1).map(|b| b.split("@\n").next().expect("a block")).collect();
    assert_eq!(blocks[0].lines().count(), places.len());
    assert!(adina.lines().all(|l| l.len() <= 80));
    assert_eq!(blocks[1].lines().map(integers).collect::<Vec<_>>(), rows);
    let empty = Arc::new(QuadMesh::default());
    for refused in [fe_mesh::abaqus(Arc::clone(&empty), &label()), fe_mesh::adina(Arc::clone(&empty), &label())] {
        assert_eq!(refused.unwrap_err().to_string(), "there is nothing to write");
    }
}

#[test]
fn a_line_of_chords() {
    let border = flankfit_engine::geometry::curve::BSplineCurve::new(
        flankfit_engine::geometry::BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 1.]).expect("knots"),
        flankfit_engine::geometry::space::Dimension::Graph,
        [0.0, 2.0, 0.0].map(|y| Vector::new(y, 0.0, 0.0)).to_vec(),
        None,
    )
    .expect("a curve");
    // y = 4 x (1 − x): chords of width h stray by h², to within rounding
    let nodes = curve_nodes(&border, &curve_parameters(&border, 0.0626).expect("parameters")).expect("nodes");
    assert_eq!(nodes.len(), 5);
    assert_eq!(nodes[1], Vector::new(0.25, 0.75, 0.0));
}
