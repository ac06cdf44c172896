//! Files of CAD and FE systems over HTTP.

use std::io::Read as _;

use serde_json::{Value, json};

use super::examples;
use crate::harness::{Answer, TestApp, send};

async fn export(app: &TestApp, kind: &str, request: &Value) -> Answer {
    let answer = send(app.post(&format!("/v1/{kind}/export"), request.to_string())).await;
    assert_eq!(answer.status, 200, "{request}: {}", answer.text);
    answer
}

fn patch() -> Value {
    examples("evaluate_surface")[0].1["surface"].clone()
}

#[tokio::test]
async fn every_format_of_a_curve() {
    let app = TestApp::start().await;
    let curve = examples("evaluate_curve")[0].1["curve"].clone();
    for (format, media, ending, holds) in [
        ("iges", "model/iges", "igs", "126,"),
        ("step", "model/step", "stp", "RATIONAL_B_SPLINE_CURVE"),
        ("obj", "model/obj", "obj", "\nl "),
        ("vtk", "text/plain", "vtk", "DATASET POLYDATA"),
        ("csv", "text/csv", "csv", "parameter,x,y,z\n0,1,0,0\n"),
    ] {
        let file = export(&app, "curves", &json!({"curve": curve, "format": format, "name": "tip; \"a\"/ä"})).await;
        assert_eq!(file.header("content-type"), media);
        let disposition = format!("attachment; filename=\"tip___a___.{ending}\"");
        assert_eq!(file.header("content-disposition"), disposition);
        assert!(file.text.contains(holds), "{format}: {}", file.text);
    }
    for (_, request) in examples("export_curve") {
        export(&app, "curves", &request).await;
    }
}

#[tokio::test]
async fn every_format_of_a_surface() {
    let app = TestApp::start().await;
    for (format, media, holds) in [
        ("iges", "model/iges", "128,"),
        ("step", "model/step", "AUTOMOTIVE_DESIGN_OR_AP242"),
        ("obj", "model/obj", "\nf "),
        ("stl_text", "model/stl", "facet normal"),
        ("vtk", "text/plain", "# vtk DataFile"),
        ("csv_nodes", "text/csv", "node,x,y,z\n1,"),
        ("csv_elements", "text/csv", "element,node_1"),
        ("abaqus", "text/plain", "*NODE"),
        ("adina", "text/plain", ""),
    ] {
        let file = export(&app, "surfaces", &json!({"surface": patch(), "format": format, "samples": [3, 2]})).await;
        assert_eq!(file.header("content-type"), media);
        let holds = if format == "step" { "B_SPLINE_SURFACE_WITH_KNOTS" } else { holds };
        assert!(file.text.contains(holds), "{format}: {}", file.text);
    }
    // 3 × 2 quadrilaterals have 4 × 3 nodes
    let nodes = export(&app, "surfaces", &json!({"surface": patch(), "format": "csv_nodes", "samples": [3, 2]})).await;
    assert_eq!(nodes.text.lines().count(), 1 + 12);
    let elements =
        export(&app, "surfaces", &json!({"surface": patch(), "format": "csv_elements", "samples": [3, 2]})).await;
    assert_eq!(elements.text.lines().count(), 1 + 6);
    // binary STL: 80 bytes of title, a count, 50 bytes for each triangle
    for (_, request) in examples("export_surface") {
        let response = app.post("/v1/surfaces/export", request.to_string()).send().await.unwrap();
        let bytes = response.bytes().await.unwrap();
        let triangles = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
        assert_eq!((triangles, bytes.len()), (2 * 20 * 20, 84 + 50 * 2 * 20 * 20));
    }
}

/// Files of many pieces arrive whole, whatever they are packed with.
#[tokio::test]
async fn packed_files_arrive_whole() {
    let app = TestApp::start().await;
    let request = json!({"surface": patch(), "format": "obj", "samples": [300, 300]}).to_string();
    let of = async |encoding: &str| {
        let response = app.post("/v1/surfaces/export", request.clone()).header("accept-encoding", encoding);
        let response = response.send().await.unwrap();
        let packed = response.headers().get("content-encoding").map(|name| name.to_str().unwrap().to_owned());
        assert_eq!(packed.as_deref().unwrap_or("identity"), encoding);
        response.bytes().await.unwrap().to_vec()
    };
    let plain = of("identity").await;
    assert!(plain.len() > 1 << 20, "many pieces: {}", plain.len());
    let (mut gunzipped, packed) = (Vec::new(), of("gzip").await);
    flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut gunzipped).unwrap();
    // both say when they were written
    assert_eq!(gunzipped.len(), plain.len());
    assert_eq!(zstd::decode_all(&of("zstd").await[..]).unwrap().len(), plain.len());
}

#[tokio::test]
async fn impossible_files_are_pointed_at() {
    let app = TestApp::start().await;
    for (request, pointer) in [
        (json!({"surface": patch()}), "/format"),
        (json!({"surface": patch(), "format": "dwg"}), "/format"),
        (json!({"format": "iges"}), "/surface"),
        (json!({"surface": patch(), "format": "stl", "samples": [0, 5]}), "/samples"),
        (json!({"surface": patch(), "format": "stl", "samples": [5]}), "/samples"),
        (json!({"surface": patch(), "format": "stl", "samples": [100000000, 1000000]}), "/samples/0"),
        (json!({"surface": patch(), "format": "stl", "samples": [10000000000u64, 1]}), "/samples/0"),
        (json!({"surface": patch(), "format": "stl", "samples": [1u64 << 62, 2]}), "/samples/0"),
        (json!({"surface": patch(), "format": "step", "tolerance": 0}), "/tolerance"),
        (json!({"surface": patch(), "format": "step", "name": ""}), "/name"),
    ] {
        let problem = send(app.post("/v1/surfaces/export", request.to_string())).await.problem(422, "invalid_request");
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{request}: {problem}");
    }
}
