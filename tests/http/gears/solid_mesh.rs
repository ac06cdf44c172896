//! `POST /v1/gears/solid-mesh`: files of hexahedra, and what is refused.

use crate::harness::{TestApp, send};
use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

const PATH: &str = "/v1/gears/solid-mesh";

/// Change of the example.
type Change = fn(&mut Value);

fn example() -> Value {
    let example = REQUEST_EXAMPLES.iter().find(|example| example.name == "gear_solid_mesh").unwrap();
    serde_json::from_str(example.text).unwrap()
}

#[tokio::test]
async fn meshes_are_written_for_each_program() {
    let app = TestApp::start().await;
    for (format, begins, holds) in [
        ("abaqus", "*HEADING", "*ELEMENT, TYPE=C3D20, ELSET=GEAR"),
        ("adina", "* gear", "ENODES SUBSTRUC=0 GROUP=1 NNODES=20"),
        ("gmsh", "$Comments", "$MeshFormat\n2.2 0 8"),
    ] {
        let mut request = example();
        request["format"] = json!(format);
        let answer = send(app.post(PATH, request.to_string())).await;
        assert_eq!(answer.status, 200, "{}", answer.text);
        assert!(answer.text.starts_with(begins) && answer.text.contains(holds), "{format}: {:.300}", answer.text);
        for set in ["LEFT_FLANK_1", "RIGHT_FLANK_1", "ROOT", "TIP", "BORE", "CUT_LEFT", "CUT_RIGHT", "END_LOW"] {
            assert!(answer.text.contains(set), "{format}: {set}");
        }
    }
    let mut linear = example();
    linear["order"] = json!("linear");
    linear["teeth"] = json!(3);
    let answer = send(app.post(PATH, linear.to_string())).await;
    assert!(answer.text.contains("TYPE=C3D8I") && answer.text.contains("LEFT_FLANK_3"));
    let mut internal = example();
    internal["gear"]["internal"] = json!(true);
    internal["gear"]["teeth"] = json!(60);
    internal["rim_diameter_mm"] = json!(180.0);
    let answer = send(app.post(PATH, internal.to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    assert!(answer.text.contains("NAME=RIM,") && !answer.text.contains("BORE"));
}

#[tokio::test]
async fn errors_have_pointers() {
    let app = TestApp::start().await;
    let cases: [(Change, &str); 9] = [
        (|r| r["teeth"] = json!(25), "/teeth"),
        (|r| r["teeth"] = json!(0), "/teeth"),
        (|r| r["rim_diameter_mm"] = json!(70.0), "/rim_diameter_mm"),
        (|r| r["elements"]["rim"] = json!(0), "/elements/rim"),
        (|r| r["elements"]["width"] = json!(10_000_000), "/elements"),
        (|r| drop(r["gear"].as_object_mut().unwrap().remove("face_width_mm")), "/gear/face_width_mm"),
        (|r| r["gear"]["teeth"] = json!(-1), "/gear/teeth"),
        (|r| r["format"] = json!("nastran"), "/format"),
        (|r| r["layers"] = json!(3), "/layers"),
    ];
    for (change, pointer) in cases {
        let mut request = example();
        change(&mut request);
        let answer = send(app.post(PATH, request.to_string())).await;
        answer.problem(422, "invalid_request");
        assert_eq!(answer.pointers(), [pointer], "{request}: {}", answer.text);
    }
}
