//! `POST /v1/surfaces`: every method, and what is refused.

use super::{close, examples, numbers};
use crate::harness::{TestApp, send};
use flankfit::api::surfaces::result::BuiltSurfaceBody;
use serde_json::{Value, json};

async fn build(app: &TestApp, request: &Value) -> Value {
    let answer = send(app.post("/v1/surfaces", request.to_string())).await;
    assert_eq!(answer.status, 200, "{request}: {}", answer.text);
    assert!(!answer.text.contains("null"), "{}", answer.text);
    let body: BuiltSurfaceBody = serde_json::from_str(&answer.text).unwrap();
    assert_eq!(serde_json::to_value(&body).unwrap(), answer.json(), "every field is documented");
    answer.json()
}

async fn values(app: &TestApp, surface: &Value, at: &[[f64; 2]]) -> Vec<Value> {
    let request = json!({"surface": surface, "at": at});
    let answer = send(app.post("/v1/surfaces/evaluate", request.to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()["values"].as_array().unwrap().clone()
}

#[tokio::test]
async fn every_example_is_a_surface_that_can_be_sent_back() {
    let app = TestApp::start().await;
    for (name, request) in examples("create_surface") {
        let built = build(&app, &request).await;
        let ([a, b], [c, d]) = (
            numbers(&built["domain"]["u"])[..].try_into().unwrap(),
            numbers(&built["domain"]["v"])[..].try_into().unwrap(),
        );
        let found = values(&app, &built["surface"], &[[a, c], [b, d], [0.5 * (a + b), 0.5 * (c + d)]]).await;
        assert_eq!(found.len(), 3, "{name}");
    }
}

/// Coons' patch keeps its borders; at the middle it is the mean of the borders' middles, twice,
/// less that of the corners.
#[tokio::test]
async fn a_coons_patch_by_hand() {
    let app = TestApp::start().await;
    let request = examples("create_surface").into_iter().find(|(name, _)| *name == "surface_coons").unwrap().1;
    let built = build(&app, &request).await;
    assert_eq!(built["surface"]["type"], "coons_bilinear");
    let found = values(&app, &built["surface"], &[[0.0, 0.5], [0.5, 0.0], [0.5, 0.5]]).await;
    // the middle of a cubic Bézier curve: (a + 3b + 3c + d)/8
    close(numbers(&found[0])[2], (0.0 + 3.0 + 1.5 + 0.0) / 8.0, 1e-15);
    close(numbers(&found[1])[2], (0.0 + 3.0 - 1.5 + 0.0) / 8.0, 1e-15);
    let middles = [(3.0 - 1.5) / 8.0, (1.5 + 4.5 - 0.5) / 8.0, (3.0 + 1.5) / 8.0, (0.75 + 3.0 - 0.5) / 8.0];
    let corners = [0.0, 0.0, 0.0, -0.5];
    let middle = middles.iter().sum::<f64>() / 2.0 - corners.iter().sum::<f64>() / 4.0;
    close(numbers(&found[2])[2], middle, 1e-15);
    // as a bicubic one it keeps the same borders
    let mut bicubic = request.clone();
    bicubic["method"]["type"] = json!("coons_bicubic");
    let built = build(&app, &bicubic).await;
    let same = values(&app, &built["surface"], &[[0.0, 0.5], [0.5, 0.0]]).await;
    for (a, b) in same.iter().zip(&found) {
        close(numbers(a)[2], numbers(b)[2], 1e-13);
    }
}

/// A surface of degree 2 by 1 is reproduced by everything that holds such surfaces.
#[tokio::test]
async fn every_method_that_can_reproduces_a_surface() {
    let app = TestApp::start().await;
    let z = |u: f64, v: f64| 1.0 - 0.5 * u + 0.25 * u * u + 0.125 * v - 0.0625 * u * v;
    let (u, v) = ([0.0, 0.5, 1.0, 2.0, 3.0], [-1.0, 0.0, 1.5, 2.0]);
    let grid = json!({"u": u, "v": v, "z": u.map(|u| v.map(|v| z(u, v)))});
    let (mut su, mut sv, mut sz) = (vec![], vec![], vec![]);
    for k in 0..40 {
        let (a, b) = (3.0 * (f64::from(k) * 0.618_034).fract(), 3.0 * (f64::from(k) * 0.754_878).fract() - 1.0);
        su.push(a);
        sv.push(b);
        sz.push(z(a, b));
    }
    let scattered = json!({"type": "scattered", "u": su, "v": sv, "z": sz});
    let least = |spans: Value| json!({"type": "b_spline_least_squares", "degree": [2, 1], "spans": spans});
    let placed = json!({"type": "b_spline_least_squares", "degree": [2, 1], "placed_spans": [2, 1]});
    let knots = json!([[0, 0, 0, 3, 3, 3], [-1, -1, 2, 2]]);
    let given = json!({"type": "b_spline_least_squares", "degree": [2, 1], "knots": knots});
    for request in [
        json!({"grid": grid, "method": {"type": "b_spline", "degree": [2, 1]}}),
        json!({"grid": grid, "method": least(json!([2, 1]))}),
        json!({"grid": grid, "method": placed}),
        json!({"grid": grid, "method": given}),
        json!({"grid": grid, "method": least(json!([2, 1])), "regularization": {"type": "none"}}),
        json!({"grid": grid, "method": least(json!([1, 1])), "estimator": {"type": "least_absolute_deviations"}}),
        json!({"nodes": scattered, "method": given}),
        json!({"grid": grid, "method": {"type": "coons_bicubic"}}),
        json!({"grid": grid, "method": {"type": "bezier"}}),
        json!({"grid": grid, "method": {"type": "gregory"}}),
    ] {
        let built = build(&app, &request).await;
        let at = [[0.25, -0.5], [1.7, 0.75], [2.9, 1.9]];
        for ([u, v], value) in at.into_iter().zip(values(&app, &built["surface"], &at).await) {
            close(value.as_f64().unwrap(), z(u, v), 1e-11);
        }
    }
}

#[tokio::test]
async fn many_coefficients_take_the_banded_way() {
    let app = TestApp::start().await;
    let (mut u, mut v, mut z) = (vec![], vec![], vec![]);
    for k in 0..4000 {
        let (a, b) = ((f64::from(k) * 0.618_033_988_75).fract(), (f64::from(k) * 0.754_877_666_25).fract());
        u.push(a);
        v.push(b);
        z.push((3.0 * a).sin() * (2.0 * b).cos());
    }
    let nodes = json!({"type": "scattered", "u": u, "v": v, "z": z});
    let inner = (1..12).map(|i| f64::from(i) / 12.0);
    let knots: Vec<f64> = [0.0; 4].into_iter().chain(inner).chain([1.0; 4]).collect();
    let method = json!({"type": "b_spline_least_squares", "degree": 3, "knots": [knots, knots]});
    let built = build(&app, &json!({"nodes": nodes, "method": method})).await;
    let fit = &built["banded_fit"];
    assert_eq!(fit["count"], 4000);
    assert_eq!(fit["nodes_per_span"].as_array().unwrap().len(), 12);
    assert_eq!(fit["effective_degrees_of_freedom"].as_f64().unwrap(), 225.0);
    assert!(fit["coordinates"][0]["max_abs"].as_f64().unwrap() < 1e-5);
    let found = values(&app, &built["surface"], &[[0.3, 0.7]]).await[0].as_f64().unwrap();
    close(found, 0.9f64.sin() * 1.4f64.cos(), 1e-5);
    // σ √(H⁻¹)ⱼⱼ of a control point inside is smaller than at a corner, which few nodes determine
    let errors: Vec<Vec<f64>> = serde_json::from_value(fit["coordinates"][0]["std_errors"].clone()).unwrap();
    assert_eq!((errors.len(), errors[0].len()), (15, 15));
    assert!(errors.iter().flatten().all(|e| *e > 0.0) && errors[7][7] < errors[0][0]);
    let request = json!({"nodes": nodes, "method": method, "include": ["residuals"]});
    let fitted = build(&app, &request).await["banded_fit"]["coordinates"][0].clone();
    let residuals = numbers(&fitted["values"]);
    close(residuals.iter().map(|r| r * r).sum::<f64>(), fitted["rss"].as_f64().unwrap(), 1e-12);
    let misses = [0usize, 1234, 3999].map(|k| (k, [u[k], v[k]]));
    for ((k, at), value) in misses.into_iter().zip(values(&app, &built["surface"], &misses.map(|m| m.1)).await) {
        let miss = z[k] - value.as_f64().unwrap();
        assert!((residuals[k] - miss).abs() < 1e-12, "{k} {at:?}: {} is not {miss}", residuals[k]);
    }
    let penalised = json!({"nodes": nodes, "method": method,
        "regularization": {"type": "tikhonov", "order": 2, "parameter": {"criterion": "fixed", "value": 1e-6}}});
    let built = build(&app, &penalised).await;
    assert_eq!(built["banded_fit"]["penalty"]["lambda"], 1e-6);
    assert!(built["banded_fit"]["effective_degrees_of_freedom"].as_f64().unwrap() < 225.0);
}

/// Patches of a mesh meet as their filling promises.
#[tokio::test]
async fn continuity_of_patches_is_reported() {
    let app = TestApp::start().await;
    let request = examples("create_surface").into_iter().find(|(name, _)| *name == "surface_mesh").unwrap().1;
    for (fill, least) in [("coons_bilinear", "c0"), ("coons_bicubic", "c1"), ("bezier", "c1"), ("gregory", "g1")] {
        let mut request = request.clone();
        request["method"]["type"] = json!(fill);
        let built = build(&app, &request).await;
        assert_eq!(built["surface"]["type"], "patchwork");
        let order = ["apart", "c0", "g1", "c1", "c2"];
        let rank = |class: &Value| order.iter().position(|name| class == name).unwrap();
        let class = &built["continuity"]["class"];
        assert!(rank(class) >= rank(&json!(least)), "{fill}: {class}");
        let joint = &built["continuity"]["joints"][0];
        assert_eq!((&joint["constant"], &joint["at"]), (&json!("u"), &json!(1.0)));
        assert!(joint["gap"]["value"].as_f64().unwrap() < 1e-12);
        // the curves of the mesh lie on the surface: z = 0.5 u − 0.1 v² + 0.05 u²
        let found = values(&app, &built["surface"], &[[1.0, 1.3], [0.4, 2.0]]).await;
        close(found[0].as_f64().unwrap(), 0.5 - 0.169 + 0.05, 1e-12);
        close(found[1].as_f64().unwrap(), 0.2 - 0.4 + 0.008, 1e-12);
    }
}

#[tokio::test]
async fn a_patch_with_three_sides_has_a_degenerate_border() {
    let app = TestApp::start().await;
    let line = |a: [f64; 3], b: [f64; 3]| {
        json!({"type": "b_spline", "degree": 1, "knots": [0, 0, 1, 1],
        "control_points": [a, b]})
    };
    let (tip, left, right) = ([0.0, 0.0, 1.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]);
    let request = json!({"boundaries": {"u1": line(left, right), "v0": line(tip, left), "v1": line(tip, right)},
                         "method": {"type": "coons_bilinear"}});
    let built = build(&app, &request).await;
    assert_eq!(built["degenerate_borders"][0]["border"], "u0");
    assert_eq!(built["degenerate_borders"][0]["point"], json!([0.0, 0.0, 1.0]));
    let asked = json!({"surface": built["surface"], "at": [[0.0, 0.5], [0.5, 0.5]], "derivatives": 1});
    let found = send(app.post("/v1/surfaces/evaluate", asked.to_string())).await.json();
    let [tip, inside] = [0, 1].map(|i| numbers(&found["normals"][i]));
    for (a, b) in tip.iter().zip(inside) {
        close(*a, b, 1e-9);
    }
}

#[tokio::test]
async fn impossible_surfaces_are_pointed_at() {
    let app = TestApp::start().await;
    let grid = json!({"u": [0, 1, 2], "v": [0, 1], "z": [[1, 2], [2, 3], [3, 5]]});
    let with = |key: &str, value: Value| {
        let mut grid = grid.clone();
        grid[key] = value;
        grid
    };
    let spline = json!({"type": "b_spline", "degree": 1});
    let coons = examples("create_surface").into_iter().find(|(name, _)| *name == "surface_coons").unwrap().1;
    let mut apart = coons.clone();
    apart["boundaries"]["u1"]["control_points"][0][2] = json!(0.5);
    let mut lone = coons.clone();
    lone["boundaries"].as_object_mut().unwrap().retain(|key, _| key == "v0");
    let many: Vec<f64> = (0..102).map(f64::from).collect();
    let wide = json!({"u": many, "v": many, "z": vec![many.clone(); 102]});
    let cases = [
        (json!({"grid": wide, "method": {"type": "coons_bilinear"}}), "/grid"),
        (json!({"method": spline}), ""),
        (json!({"grid": grid}), "/method"),
        (json!({"grid": grid, "xyz": [], "method": spline}), "/xyz"),
        (json!({"grid": grid, "tolerance": 1, "method": spline}), "/tolerance"),
        (json!({"grid": with("u", json!([0, 2, 1])), "method": spline}), "/grid/u/2"),
        (json!({"grid": with("z", json!([[1, 2], [2], [3, 5]])), "method": spline}), "/grid/z/1"),
        (json!({"grid": with("z", json!([[1, 2], [2, null], [3, 5]])), "method": spline}), "/grid/z/1/1"),
        (json!({"grid": with("z", json!([[1, 2]])), "method": spline}), "/grid/z"),
        (json!({"grid": grid, "method": {"type": "b_spline", "degree": [3, 1]}}), "/grid/u"),
        (
            json!({"grid": grid, "method": {"type": "b_spline", "degree": 1, "knots": [[0, 0, 1, 2, 2], [0, 0, 1]]}}),
            "/method/knots/1",
        ),
        (json!({"grid": grid, "method": {"type": "b_spline_least_squares", "degree": 1}}), "/method"),
        (
            json!({"grid": grid, "method": {"type": "b_spline_least_squares", "degree": 1, "spans": [7, 1]}}),
            "/method/spans/0",
        ),
        (
            json!({"grid": grid,
                "method": {"type": "nurbs", "degree": 1, "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "weights": [[1]]}}),
            "/method",
        ),
        (json!({"grid": grid, "method": {"type": "loft"}}), "/method/type"),
        (json!({"grid": grid, "method": spline, "estimator": {"type": "rank"}}), "/estimator"),
        (apart, "/boundaries/u1"),
        (lone, "/boundaries/u1"),
        (json!({"control_points": [[1, 2], [3]], "method": {"type": "bezier"}}), "/control_points/1"),
        (json!({"control_points": [[[1, 2]]], "method": {"type": "bezier"}}), "/control_points"),
    ];
    for (request, pointer) in cases {
        let answer = send(app.post("/v1/surfaces", request.to_string())).await;
        let problem = answer.problem(422, "invalid_request");
        let first = problem["errors"][0]["pointer"].as_str().unwrap();
        assert_eq!(first, pointer, "{request}: {problem}");
    }
}
