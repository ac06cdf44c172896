//! Counts and indices at the end of their types' ranges: each is a 422 at its field.

use flankfit::api::examples::REQUEST_EXAMPLES;
use serde_json::{Value, json};

use crate::harness::{Answer, TestApp, send};

/// The request of an example, and where it goes.
fn example(name: &str) -> Value {
    let found = REQUEST_EXAMPLES.iter().find(|example| example.name == name).expect("an example");
    serde_json::from_str(found.text).expect("JSON")
}

/// The same with other values at some pointers; what is not there yet becomes a field.
fn with(name: &str, changes: &[(&str, Value)]) -> Value {
    let mut request = example(name);
    for (pointer, value) in changes {
        let (parent, field) = pointer.rsplit_once('/').expect("a pointer");
        match request.pointer_mut(parent).expect("a parent") {
            Value::Object(fields) => {
                fields.insert(field.to_owned(), value.clone());
            }
            Value::Array(items) => items[field.parse::<usize>().expect("an index")] = value.clone(),
            other => panic!("{other}"),
        }
    }
    request
}

async fn sent(app: &TestApp, path: &str, request: &Value) -> Answer {
    send(app.post(path, request.to_string())).await
}

/// Greatest signed and unsigned numbers of 64 bits, and some that overflow when doubled or when one
/// is added.
const COUNTS: [u64; 5] = [i64::MAX as u64, u64::MAX, u64::MAX - 1, u64::MAX / 2, 1 << 62];

#[tokio::test]
async fn degrees_of_shapes() {
    let app = TestApp::start().await;
    let curve = |degree: u64| json!({"type": "b_spline", "degree": degree, "knots": [0, 1], "control_points": [0]});
    let surface = |degree: Value| {
        json!({"type": "b_spline", "degree": degree, "knots": [[0, 0, 1, 1], [0, 0, 1, 1]],
        "control_points": [[0, 0], [0, 0]]})
    };
    for count in COUNTS {
        for (path, name) in
            [("evaluate", "curve_evaluate"), ("export", "curve_export"), ("closest-points", "curve_closest")]
        {
            let request = with(name, &[("/curve", curve(count))]);
            let answer = sent(&app, &format!("/v1/curves/{path}"), &request).await;
            assert_eq!(answer.pointers(), ["/curve/degree"], "{path} {count}");
        }
        for (path, name) in [
            ("evaluate", "surface_evaluate"),
            ("export", "surface_export"),
            ("closest-points", "surface_closest"),
            ("sections", "surface_sections"),
        ] {
            for (degree, pointer) in [(json!(count), "/surface/degree"), (json!([1, count]), "/surface/degree/1")] {
                let request = with(name, &[("/surface", surface(degree))]);
                let answer = sent(&app, &format!("/v1/surfaces/{path}"), &request).await;
                assert_eq!(answer.pointers(), [pointer], "{path} {count}");
            }
        }
        for name in ["curve_nurbs_least_squares", "curve_least_squares", "curve_adaptive"] {
            let answer = sent(&app, "/v1/curves", &with(name, &[("/method/degree", json!(count))])).await;
            assert_eq!(answer.pointers(), ["/method/degree"], "{name} {count}");
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn a_mesh_without_places() {
    let app = TestApp::start().await;
    for axis in ["u", "v"] {
        let request = with("surface_mesh", &[(&format!("/mesh/{axis}"), json!([]))]);
        assert_eq!(sent(&app, "/v1/surfaces", &request).await.pointers(), [format!("/mesh/{axis}")]);
    }
    app.stop().await;
}

#[tokio::test]
async fn reliefs_over_no_length() {
    let app = TestApp::start().await;
    let range = "/modification_range/helix_range_mm";
    for (changes, expected) in [
        (vec![(range, json!([0, 1e-154]))], range),
        (vec![(range, json!([5e-324, 0]))], range),
        (
            vec![("/modification_range/profile_diameter_range_mm", json!([190.0, 190.000_000_1]))],
            "/modification_range/profile_diameter_range_mm",
        ),
        (
            vec![("/modifications/0", json!({"type": "end_relief", "end": "I", "amount_um": 9, "length_mm": 1e-300}))],
            "/modifications/0/length_mm",
        ),
        (vec![("/modifications/0/start_diameter_mm", json!(194.0 - 1e-13))], "/modifications/0/start_diameter_mm"),
    ] {
        let answer = sent(&app, "/v1/gears/flank", &with("gear_flank", &changes)).await;
        assert_eq!(answer.pointers(), [expected], "{changes:?}");
    }
    let relief = json!({
        "type": "grid", "profile": {"axis": "diameter", "values": [188, 190]}, "face_width_positions_mm": [0, 1e-300],
        "relief_um": [[1, 2], [3, 4]], "interpolation": "b_spline"
    });
    let answer = sent(&app, "/v1/gears/flank", &with("gear_flank", &[("/modifications/0", relief)])).await;
    assert_eq!(answer.pointers(), ["/modifications/0/face_width_positions_mm/1"]);
    app.stop().await;
}

/// 189 bytes halved 24 deep between every pair of points.
#[tokio::test]
async fn an_envelope_of_a_gear_that_spins() {
    let app = TestApp::start().await;
    let tool = json!({
        "points": [[-1.57, -1.25], [-1.240_360_956_2, -1.25], [-0.421_427_929_1, 1]], "steps": 40, "through": "polyline"
    });
    for radius in [1e-6, 1e-4] {
        let motion = json!({"type": "rack", "pitch_radius_mm": radius});
        let request = json!({"motion": motion, "radius_range_mm": [0.0247, 27.1], "tool": tool});
        let answer = sent(&app, "/v1/gears/envelope", &request).await;
        assert_eq!(answer.pointers(), ["/motion"]);
        assert!(
            answer.text.contains("200000 points") && answer.text.contains("larger pitch radius"),
            "{}",
            answer.text
        );
    }
    for (changes, expected) in [
        (vec![("/tool/steps", json!(0))], "/tool/steps"),
        (vec![("/tool/steps", json!(u64::MAX))], "/tool/points"),
        (vec![("/radii_mm", json!((1..=10_001).collect::<Vec<_>>()))], "/radii_mm"),
    ] {
        let answer = sent(&app, "/v1/gears/envelope", &with("gear_envelope", &changes)).await;
        assert_eq!(answer.pointers(), [expected], "{expected}");
    }
    app.stop().await;
}

/// A client that takes no encoding, not even none, gets its answer as it is: the work is done, and
/// what was stored is stored.
#[tokio::test]
async fn unsupported_encodings_get_a_plain_response() {
    let app = TestApp::start().await;
    for wanted in ["identity;q=0", "*;q=0", "gzip;q=0, identity; q=0", "br", "", "identity;q=0, br", "gzip;q=x"] {
        let fitted = send(app.post("/v1/fits", crate::harness::CURVE).header("accept-encoding", wanted)).await;
        assert_eq!(fitted.status, 200, "{wanted}: {}", fitted.text);
        let stored = send(app.post("/v1/jobs", r#"{"name":"w"}"#).header("accept-encoding", wanted)).await;
        assert_eq!(stored.status, 201, "{wanted}: {}", stored.text);
        assert_eq!(send(app.get("/v1/jobs/x").header("accept-encoding", wanted)).await.status, 404, "{wanted}");
    }
    for wanted in ["gzip", "gzip;q=0.5, identity;q=0", "br, GZIP"] {
        let taken = app.get("/openapi.json").header("accept-encoding", wanted).send().await.unwrap();
        assert_eq!(taken.headers()["content-encoding"], "gzip", "{wanted}");
    }
    app.stop().await;
}

#[tokio::test]
async fn enormous_exponents_are_no_internal_error() {
    let app = TestApp::start().await;
    for exponent in ["-31700000000000000000000000000000", "-9223372036854775807", "-9223372036854775800"] {
        let number = format!("8.289046e{exponent}");
        let body = format!(
            r#"{{"nodes":{{"type":"curve","x":[0,1,2,{number}],"y":[1,3,4.9,1.1]}},"model":{{"type":"polynomial","degree":1}}}}"#
        );
        assert!(app.fit(&body).await.status.as_u16() < 500, "{exponent}");
    }
    app.stop().await;
}

/// Members of something that is not an object, or not there, are not reported as missing.
#[tokio::test]
async fn one_mistake_is_one_error() {
    let app = TestApp::start().await;
    for (path, body, expected) in [
        ("/v1/curves", "[0,100]", vec![""]),
        ("/v1/fits", "7", vec![""]),
        ("/v1/gears/geometry", r#"{"raeg":{"teeth":7}}"#, vec!["/raeg", "/gear"]),
        ("/v1/gears/profile", r#"{"gear":[]}"#, vec!["/gear"]),
    ] {
        assert_eq!(send(app.post(path, body)).await.pointers(), expected, "{path} {body}");
    }
    let grid = json!({
        "gear": {"teeth": 52, "normal_module_mm": 1.0},
        "grid": {"flank": "left", "diameter_mm": [53, 52], "z_mm": [0], "deviation_um": [[1], [2]]}
    });
    assert_eq!(sent(&app, "/v1/gears/deviations", &grid).await.pointers(), ["/grid/diameter_mm/1"]);
    let newton = json!({
        "curve": {"type": "polynomial", "form": "newton", "nodes": [0, 1], "values": [[0, 0], 1]}, "at": [0]
    });
    assert_eq!(sent(&app, "/v1/curves/evaluate", &newton).await.pointers(), ["/curve/values"]);
    let long = format!(r#"{{"nodes":{{"type":"{}"}},"model":{{}}}}"#, "x".repeat(100_000));
    let answer = app.fit(&long).await;
    assert!(answer.pointers().contains(&"/nodes/type".to_owned()) && answer.text.len() < 4000, "{}", answer.text.len());
    app.stop().await;
}
