//! `POST /v1/surfaces/sections`: curves of sections, meshes of them, and what is refused.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::{close, examples, numbers};
use crate::harness::{TestApp, send};
use flankfit::api::surfaces::sections::SectionsBody;
use serde_json::{Value, json};

const PATH: &str = "/v1/surfaces/sections";

/// A cylinder of radius 2 about the z axis from 0 to 5, whole.
fn cylinder() -> Value {
    let corners = [[2., 0.], [2., 2.], [0., 2.], [-2., 2.], [-2., 0.], [-2., -2.], [0., -2.], [2., -2.], [2., 0.]];
    let rows: Vec<Value> = corners.iter().map(|[x, y]| json!([[x, y, 0.0], [x, y, 5.0]])).collect();
    let weights: Vec<Value> =
        (0..9).map(|k| if k % 2 == 0 { json!([1, 1]) } else { json!([FRAC_1_SQRT_2, FRAC_1_SQRT_2]) }).collect();
    json!({"type": "nurbs", "degree": [2, 1], "knots": [[0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], [0, 0, 1, 1]],
        "control_points": rows, "weights": weights})
}

async fn ask(app: &TestApp, request: &Value) -> Value {
    let answer = send(app.post(PATH, request.to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

#[tokio::test]
async fn a_cylinder_is_cut() {
    let app = TestApp::start().await;
    let families = json!([
        {"normal": [0, 0, 3], "offsets": [-1.0, 0.0, 2.5]},
        {"normal": [1, 0, 0], "offsets": [1.0, 2.0, 2.5]}
    ]);
    let found = ask(&app, &json!({"surface": cylinder(), "families": families})).await;
    let curves =
        |family: usize, plane: usize| found["families"][family]["sections"][plane]["curves"].as_array().unwrap();
    assert_eq!([0, 1, 2].map(|plane| curves(0, plane).len()), [0, 1, 1]);
    assert_eq!([0, 1, 2].map(|plane| curves(1, plane).len()), [2, 1, 0]);
    for plane in [1, 2] {
        let curve = &curves(0, plane)[0];
        assert_eq!((&curve["closed"], &curve["tangential"]), (&json!(true), &json!(false)));
        close(curve["length"].as_f64().unwrap(), 4.0 * PI, 1e-9);
        assert!(curve["error"].as_f64().unwrap() <= 1e-9);
        // the curve can be sent back
        let [low, high] = [0.0, curve["length"].as_f64().unwrap()];
        let at: Vec<f64> = (0..50).map(|k| low + (high - low) * f64::from(k) / 50.0).chain([high]).collect();
        let values =
            send(app.post("/v1/curves/evaluate", json!({"curve": curve["curve"], "at": at}).to_string())).await;
        for point in values.json()["values"].as_array().unwrap() {
            let p = numbers(point);
            close(p[0].hypot(p[1]), 2.0, 1e-9);
            close(p[2], [0.0, 0.0, 2.5][plane], 1e-9);
        }
    }
    assert_eq!(curves(1, 1)[0]["tangential"], true);
    let polyline = ask(
        &app,
        &json!({"surface": cylinder(), "families": [{"normal": [0, 0, 1], "offsets": [2.0]}], "form": "polyline",
            "tolerance": 1e-4}),
    )
    .await;
    let curve = &polyline["families"][0]["sections"][0]["curves"][0];
    for point in curve["points"].as_array().unwrap() {
        let p = numbers(point);
        close(p[0].hypot(p[1]), 2.0, 1e-13);
    }
    assert!(curve.get("curve").is_none() && curve["error"].as_f64().unwrap() <= 1e-4);
}

/// From sections to a mesh, from the mesh to patches, and from the patches to sections again: those
/// are the sections of the first surface.
#[tokio::test]
async fn a_mesh_of_sections_is_filled_and_cut_again() {
    let app = TestApp::start().await;
    for (name, request) in examples("sections_of_surface") {
        let found = ask(&app, &request).await;
        let body: SectionsBody = serde_json::from_value(found.clone()).unwrap();
        assert_eq!(serde_json::to_value(&body).unwrap(), found, "{name}");
        assert_eq!(found["mesh_frame"], json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        assert!(found["mesh_error"].as_f64().unwrap() <= 1e-6);
        for method in ["gregory", "coons_bicubic"] {
            let fill = json!({"mesh": found["mesh"], "method": {"type": method}, "tolerance": 1e-5});
            let filled = send(app.post("/v1/surfaces", fill.to_string())).await;
            assert_eq!(filled.status, 200, "{}", filled.text);
            let patches = filled.json()["surface"].clone();
            let at = json!([[0.5, 0.4], [1.0, 1.2], [1.5, 0.4], [1.2, 0.7]]);
            let evaluate = json!({"surface": patches, "at": at});
            let values = send(app.post("/v1/surfaces/evaluate", evaluate.to_string())).await.json();
            for (k, z) in numbers(&values["values"]).into_iter().enumerate() {
                let [x, y]: [f64; 2] = numbers(&at[k]).try_into().unwrap();
                // the patch is bilinear in x and of second degree in y: x = 2 s, y = 2 t
                let wanted = height(x / 2.0, y / 2.0);
                assert!((z - wanted).abs() < if k < 3 { 1e-5 } else { 2e-2 }, "{method} {k}: {z} is not {wanted}");
            }
            let again = json!({"surface": patches, "families": [{"normal": [1, 0, 0], "offsets": [1.0]}]});
            let cut = ask(&app, &again).await;
            let curves = cut["families"][0]["sections"][0]["curves"].as_array().unwrap();
            assert_eq!(curves.len(), 1, "{method}: the patches make one curve");
            let length = curves[0]["length"].as_f64().unwrap();
            let evaluate = json!({"curve": curves[0]["curve"], "at": [0.0, 0.5 * length, length]});
            let places = send(app.post("/v1/curves/evaluate", evaluate.to_string())).await.json();
            for point in places["values"].as_array().unwrap() {
                let p = numbers(point);
                close(p[0], 1.0, 1e-9);
                close(p[2], height(0.5, p[1] / 2.0), 1e-5);
            }
        }
    }
}

/// Height of the example's patch: Bernstein polynomials over its control heights.
fn height(s: f64, t: f64) -> f64 {
    let of = |x: f64| [(1.0 - x) * (1.0 - x), 2.0 * x * (1.0 - x), x * x];
    let rows = [[0.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 0.0]];
    rows.iter().zip(of(s)).map(|(row, a)| a * row.iter().zip(of(t)).map(|(z, b)| z * b).sum::<f64>()).sum()
}

/// Points of a polyline are nodes of a curve, and a section is a curve that can be written as a
/// file.
#[tokio::test]
async fn sections_are_posted_on() {
    let app = TestApp::start().await;
    let families = json!([{"normal": [-0.5, 0, 1], "offsets": [1.5]}]);
    let of = |form: &str| json!({"surface": cylinder(), "families": families, "form": form, "tolerance": 1e-3});
    let polyline = ask(&app, &of("polyline")).await;
    let points = &polyline["families"][0]["sections"][0]["curves"][0]["points"];
    let fit = json!({"points": {"xyz": points}, "method": {"type": "b_spline", "degree": 3}});
    let built = send(app.post("/v1/curves", fit.to_string())).await;
    assert_eq!(built.status, 200, "{}", built.text);
    let spline = ask(&app, &of("b_spline")).await;
    let curve = &spline["families"][0]["sections"][0]["curves"][0];
    assert!(curve["error"].as_f64().unwrap() <= 1e-3);
    let export = json!({"curve": curve["curve"], "format": "step"});
    let file = send(app.post("/v1/curves/export", export.to_string())).await;
    assert_eq!(file.status, 200, "{}", file.text);
    assert!(file.text.contains("B_SPLINE_CURVE"));
}

/// Planes that touch, lie in the surface, or are undecidable.
#[tokio::test]
async fn touching_planes_are_reported() {
    let app = TestApp::start().await;
    // z = (2 u − 1)² + (2 v − 1)², its lowest place in the middle, and a flat square
    let axis = [1.0, -1.0, 1.0];
    let cup: Value = (0..3).map(|i| (0..3).map(|j| json!(axis[i] + axis[j])).collect::<Value>()).collect();
    let surface = |heights: Value| json!({"type": "bezier", "control_points": heights});
    let level = |surface: Value| json!({"surface": surface, "families": [{"normal": [0, 0, 1], "offsets": [0.0]}]});
    let found = ask(&app, &level(surface(cup))).await;
    let section = &found["families"][0]["sections"][0];
    assert_eq!(section["contact_points"], json!([[0.5, 0.5, 0.0]]));
    assert_eq!((&section["curves"], &section["coincident"]), (&json!([]), &json!(false)));
    let found = ask(&app, &level(surface(json!([[0, 0], [0, 0]])))).await;
    assert_eq!(found["families"][0]["sections"][0]["coincident"], true);
    assert_eq!(found["warnings"][0]["code"], "coincident");
    // z = (2 u − 1)(2 v − 1): branches cross
    let found = ask(&app, &level(surface(json!([[1, -1], [-1, 1]])))).await;
    let section = &found["families"][0]["sections"][0];
    assert_eq!(section["branch_points"], json!([[0.5, 0.5, 0.0]]));
    assert_eq!(section["curves"].as_array().unwrap().len(), 4);
    // z = (2 u − 1)⁴: too flat to be decided
    let flat: Value = [1.0, -1.0, 1.0, -1.0, 1.0].map(|z| json!([z, z])).into_iter().collect();
    let found = ask(&app, &level(surface(flat))).await;
    assert_eq!(found["warnings"][0]["code"], "unresolved");
    assert!(!found["families"][0]["sections"][0]["unresolved_points"].as_array().unwrap().is_empty());
}

#[tokio::test]
async fn errors_have_pointers() {
    let app = TestApp::start().await;
    let family = |normal: Value, offsets: Value| json!({"normal": normal, "offsets": offsets});
    let plain = family(json!([0, 0, 1]), json!([1.0, 2.0]));
    let request = |families: Value| json!({"surface": cylinder(), "families": families});
    let with = |key: &str, value: Value| {
        let mut request = request(json!([plain]));
        request[key] = value;
        request
    };
    let mut large = request(json!([plain]));
    large["surface"]["control_points"][0][0] = json!([1e70, 0.0, 0.0]);
    let cases = [
        (large, "/surface"),
        (json!({"surface": cylinder()}), "/families"),
        (json!({"families": [plain]}), "/surface"),
        (request(json!([])), "/families"),
        (request(json!([plain, plain, plain])), "/families"),
        (request(json!([family(json!([0, 0, 0]), json!([1.0]))])), "/families/0/normal"),
        (request(json!([family(json!([0, 1]), json!([1.0]))])), "/families/0/normal"),
        (request(json!([family(json!([0, 0, 1]), json!([]))])), "/families/0/offsets"),
        (request(json!([family(json!([0, 0, 1]), json!([1.0, 1.0]))])), "/families/0/offsets/1"),
        (with("tolerance", json!(0)), "/tolerance"),
        (with("form", json!("nurbs")), "/form"),
        (with("mesh", json!(true)), "/families"),
        (with("planes", json!(1)), "/planes"),
        (request(json!([family(json!([0, 0, 1]), json!([1.0, null]))])), "/families/0/offsets/1"),
        (request(json!([{"normal": [0, 0, 1], "offsets": [1.0], "count": 3}])), "/families/0/count"),
    ];
    for (request, pointer) in cases {
        let answer = send(app.post(PATH, request.to_string())).await;
        assert_eq!(answer.pointers(), [pointer], "{request}: {}", answer.text);
    }
    // a field that is null counts as absent
    let plainly = ask(&app, &request(json!([plain]))).await;
    assert_eq!(ask(&app, &with("form", Value::Null)).await["families"], plainly["families"]);
    // a tolerance below rounding is accepted, with a warning that it is not met
    let found = ask(&app, &with("tolerance", json!(1e-300))).await;
    assert_eq!(found["warnings"][0]["code"], "tolerance_not_met");
    let mut meshed = request(json!([plain, family(json!([1, 0, 0]), json!([0.0, 1.0]))]));
    meshed["mesh"] = json!(true);
    let problem = send(app.post(PATH, meshed.to_string())).await.problem(422, "invalid_request");
    assert_eq!(problem["errors"][0]["pointer"], "/families/0/offsets/0", "{problem}");
    meshed["families"][1]["normal"] = json!([1, 0, 1]);
    let problem = send(app.post(PATH, meshed.to_string())).await.problem(422, "invalid_request");
    assert_eq!(problem["errors"][0]["pointer"], "/families", "{problem}");
}

/// Warnings name their planes as pointers, ten of each kind at most, and say how many more.
#[tokio::test]
async fn warnings_of_many_planes_are_few() {
    let app = TestApp::start().await;
    // steps up, level at each whole number
    let count = 14;
    let rows: Vec<Value> = (0..2 * count).map(|k| json!([[k, 0, k / 2], [k, 1, k / 2]])).collect();
    let knots: Vec<usize> = [0].into_iter().chain(0..2 * count).chain([2 * count - 1]).collect();
    let stairs = json!({"type": "b_spline", "degree": [1, 1], "knots": [knots, [0, 0, 1, 1]], "control_points": rows});
    let offsets = |count: usize| (0..count).map(|k| k as f64).collect::<Vec<_>>();
    let request =
        |count: usize| json!({"surface": stairs, "families": [{"normal": [0, 0, 1], "offsets": offsets(count)}]});
    for (asked, last) in [
        (10, None),
        (11, Some("/families: the same of 1 more plane")),
        (14, Some("/families: the same of 4 more planes")),
    ] {
        let found = ask(&app, &request(asked)).await;
        let warnings: Vec<&Value> =
            found["warnings"].as_array().unwrap().iter().filter(|w| w["code"] == "coincident").collect();
        let message = |k: usize| warnings[k]["message"].as_str().unwrap();
        assert!(message(0).starts_with("/families/0/offsets/0: a part of the surface"), "{found}");
        assert_eq!(warnings.len(), 10 + usize::from(last.is_some()), "{found}");
        assert_eq!(last, (asked > 10).then(|| message(10)));
    }
}
