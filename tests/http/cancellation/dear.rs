//! The dearest request of each operation that its limits allow, or nearly: bodies are kept to some
//! megabytes, for it is not reading that is to be cancelled.

use serde_json::{Value, json};

/// Body of a request.
pub struct Body {
    pub media: &'static str,
    pub bytes: Vec<u8>,
}

fn of(value: &Value) -> Body {
    Body { media: "application/json", bytes: value.to_string().into_bytes() }
}

fn example(text: &str) -> Value {
    serde_json::from_str(text).expect("an example")
}

/// Numbers from 0 to 1 without any order.
fn noise(k: usize) -> f64 {
    ((12.9898 * k as f64).sin() * 43758.5453).rem_euclid(1.0)
}

fn list(count: usize, number: impl Fn(usize) -> f64) -> Value {
    (0..count).map(number).collect()
}

fn table(rows: usize, columns: usize, number: impl Fn(usize, usize) -> f64) -> Value {
    (0..rows).map(|i| list(columns, |j| number(i, j))).collect()
}

fn grid(rows: usize, columns: usize, height: impl Fn(usize, usize) -> f64) -> Value {
    json!({
        "type": "grid", "u": list(rows, |i| i as f64), "v": list(columns, |j| j as f64),
        "z": table(rows, columns, height)
    })
}

fn scattered(count: usize) -> Value {
    json!({
        "type": "scattered", "u": list(count, noise), "v": list(count, |k| noise(k + 1_000_003)),
        "z": list(count, |k| noise(k + 2_000_003))
    })
}

fn gear() -> Value {
    example(include_str!("../../../examples/requests/gear_flank_surface.json"))["gear"].clone()
}

/// The job that iterations belong to.
pub fn job() -> Value {
    json!({"name": "wheel", "gear": gear()})
}

/// Nodes with many equal heights: ties.
pub fn nodes() -> Value {
    grid(60, 60, |i, j| (10.0 * (3.0 * i as f64 + 7.0 * j as f64).sin()).floor())
}

fn lp_spec() -> Value {
    json!({
        "model": {"type": "polynomial", "degree": [14, 14], "basis": "chebyshev"},
        "estimator": {"type": "lp", "p": 1.0001}
    })
}

pub fn lp() -> Body {
    let mut request = lp_spec();
    request["nodes"] = nodes();
    of(&request)
}

pub fn lp_refit() -> Body {
    of(&lp_spec())
}

/// A fit that takes long enough to be left when it is computed again, and not too long to be stored
/// first.
pub fn replayed() -> Value {
    json!({
        "model": {"type": "polynomial", "degree": [3, 3], "basis": "chebyshev"},
        "estimator": {"type": "lp", "p": 1.5}
    })
}

pub fn nothing() -> Body {
    Body { media: "application/json", bytes: Vec::new() }
}

pub fn study() -> Body {
    let mut request = example(include_str!("../../../examples/requests/study_flank.json"));
    request["repetitions"] = json!(8_000);
    of(&request)
}

pub fn adaptive_curve() -> Body {
    of(&json!({
        "points": {"x": list(20_000, |k| 0.2 * k as f64), "y": list(20_000, noise)},
        "method": {"type": "b_spline_least_squares", "degree": 3, "tolerance": 1e-9},
        "regularization": {"type": "none"}
    }))
}

/// A cubic B-spline of many control points all over a disc.
fn curve(controls: usize) -> Value {
    let inner = (1..controls - 3).map(|k| k as f64);
    let end = (controls - 3) as f64;
    let knots: Vec<f64> = [0.0; 4].into_iter().chain(inner).chain([end; 4]).collect();
    let point = |k: usize| {
        let (turn, radius) = (k as f64, 1.0 + noise(k));
        json!([radius * turn.cos(), radius * turn.sin()])
    };
    json!({"type": "b_spline", "degree": 3, "knots": knots,
        "control_points": (0..controls).map(point).collect::<Value>()})
}

pub fn arc_lengths() -> Body {
    let at = list(10_000, |k| 19_997.0 * noise(k));
    of(&json!({"curve": curve(20_000), "at": at, "derivatives": 2, "include": ["arc_length"]}))
}

pub fn closest_on_curve() -> Body {
    let points: Value = (0..1_000).map(|k| json!([noise(k), noise(k + 5_000)])).collect();
    of(&json!({"curve": curve(20_000), "points": points}))
}

pub fn curve_file() -> Body {
    of(&json!({"curve": curve(2_000), "format": "vtk", "tolerance": 1e-9}))
}

pub fn big_surface() -> Body {
    of(&json!({
        "nodes": scattered(30_000),
        "method": {"type": "b_spline_least_squares", "degree": 3, "spans": [100, 100]},
        "regularization": {"type": "tikhonov", "order": 2, "parameter": {"criterion": "gcv"}}
    }))
}

/// A bicubic B-spline surface with hills everywhere.
fn surface() -> Value {
    let knots: Vec<f64> = [0.0; 4].into_iter().chain((1..37).map(f64::from)).chain([37.0; 4]).collect();
    let row = |i: usize| (0..40).map(|j| json!([i, j, 5.0 * noise(40 * i + j)])).collect::<Value>();
    json!({
        "type": "b_spline", "degree": [3, 3], "knots": [knots, knots],
        "control_points": (0..40).map(row).collect::<Value>()
    })
}

pub fn surface_values() -> Body {
    let places = list(700, |k| 37.0 * k as f64 / 699.0);
    of(&json!({
        "surface": surface(), "grid": {"u": places, "v": places}, "derivatives": 2,
        "include": ["fundamental_forms", "area"]
    }))
}

/// Points so far away that nearly all of the surface is equally near.
pub fn closest_on_surface() -> Body {
    let points: Value = (0..5_000).map(|k| json!([20.0 + noise(k), 20.0 + noise(k + 7_000), 1e6])).collect();
    of(&json!({"surface": surface(), "points": points}))
}

/// Planes in all of which the hills have contours.
pub fn sections_of_surface() -> Body {
    let offsets = list(1_000, |k| 1.0 + 3e-3 * k as f64);
    of(&json!({"surface": surface(), "families": [{"normal": [0, 0, 1], "offsets": offsets}], "tolerance": 1e-4}))
}

/// Greatest export of nodes: 37 × 54 + 1 each way.
pub fn surface_file() -> Body {
    of(&json!({"surface": surface(), "format": "obj", "samples": [54, 54]}))
}

pub fn solid_mesh() -> Body {
    let elements = json!({"involute": 60, "fillet": 30, "root": 10, "thickness": 60, "rim": 40, "width": 25});
    of(&json!({"gear": gear(), "format": "gmsh", "order": "quadratic", "elements": elements}))
}

pub fn flank() -> Body {
    let mut request = example(include_str!("../../../examples/requests/gear_flank.json"));
    request["profile"]["values"] = list(1_400, |k| 187.0 + 6.0 * k as f64 / 1399.0);
    request["face_width_positions_mm"] = list(1_400, |k| 30.0 * k as f64 / 1399.0);
    of(&request)
}

pub fn profile() -> Body {
    of(&json!({
        "gear": gear(), "whole_gear": true, "steps": {"involute": 5_000, "fillet": 5_000, "tip": 50, "root": 50}
    }))
}

pub fn envelope() -> Body {
    let mut request = example(include_str!("../../../examples/requests/gear_envelope.json"));
    request["tool"]["steps"] = json!(60_000);
    request["radii_mm"] = list(10_000, |k| 24.7 + 2.4 * k as f64 / 9999.0);
    of(&request)
}

fn posted_traces() -> Value {
    let trace = |k: usize| {
        json!({
            "tooth": (k % 52 + 1).to_string(), "flank": "left", "kind": "profile", "section_z_mm": 7.5,
            "diameter_mm": list(5_000, |i| 50.3 + 3.7 * i as f64 / 5e3),
            "deviation_um": list(5_000, |i| noise(5_000 * k + i))
        })
    };
    (0..60).map(trace).collect()
}

pub fn traces() -> Body {
    let mut request = example(include_str!("../../../examples/requests/gear_evaluate.json"));
    request["traces"] = posted_traces();
    of(&request)
}

pub fn registered_points() -> Body {
    let point = |k: usize| {
        let turn = std::f64::consts::TAU * (k % 52) as f64 / 52.0 + 0.030;
        json!([26.0 * turn.sin(), 26.0 * turn.cos(), 7.0 * noise(k)])
    };
    of(&json!({
        "gear": gear(), "points": (0..40_000).map(point).collect::<Value>(), "strays": "undefined",
        "registration": {"motions": ["rotation", "x_shift", "y_shift"]}
    }))
}

pub fn robust_flank() -> Body {
    let mut request = example(include_str!("../../../examples/requests/gear_flank_surface.json"));
    request["profile"] = list(500, |k| 6.0 + 6.0 * k as f64 / 499.0);
    request["z_mm"] = list(500, |k| 1.0 + 13.0 * k as f64 / 499.0);
    request["deviation_um"] = table(500, 500, |i, j| 3.0 * noise(500 * i + j));
    request["estimator"] = json!({"type": "lp", "p": 1.0001});
    of(&request)
}

fn settings(count: usize) -> Value {
    (0..count).map(|j| json!(format!("setting {j}"))).collect()
}

pub fn correction() -> Body {
    let matrix = table(3_600, 60, |k, j| noise(60 * k + j) - 0.5);
    of(&json!({"sensitivity": {"type": "matrix", "settings": settings(60), "matrix": matrix}}))
}

pub fn closed_loop() -> Body {
    of(&json!({
        "corrections": 20, "settings": settings(60), "matrix": table(900, 60, |k, j| noise(60 * k + j) - 0.5),
        "grid": [30, 30], "setting_error": list(60, |_| 1.0), "store": false
    }))
}

/// Nodes of an iteration that a curve leads near.
pub fn curve_nodes() -> Value {
    json!({"type": "curve", "x": list(20_000, |k| 0.2 * k as f64), "y": list(20_000, noise)})
}

pub fn curve_of_nodes() -> Body {
    of(&json!({
        "method": {"type": "b_spline_least_squares", "degree": 3, "tolerance": 1e-9},
        "regularization": {"type": "none"}
    }))
}

pub fn surface_of_nodes() -> Body {
    of(&json!({
        "method": {"type": "b_spline_least_squares", "degree": 3, "spans": [100, 100]},
        "regularization": {"type": "tikhonov", "order": 2, "parameter": {"criterion": "gcv"}}
    }))
}

/// Model of a stream, and its first block.
pub fn stream() -> Value {
    json!({
        "model": {"type": "polynomial", "degree": [23, 23], "basis": "chebyshev"},
        "domain": {"u": [0.0, 1.0], "v": [0.0, 1.0]}, "regularization": {"type": "none"}
    })
}

pub fn block() -> Body {
    of(&json!({"sequence": 1, "nodes": scattered(12_000)}))
}

/// A stream that is worth finishing, whose blocks are not dear themselves.
pub fn full_stream() -> (Value, Value) {
    let mut spec = stream();
    spec["model"]["degree"] = json!([16, 16]);
    spec["include"] = json!(["residuals", "matrix_b"]);
    (spec, json!({"sequence": 1, "nodes": scattered(1_000)}))
}

fn form(name: &str, content: &str) -> Body {
    let head = format!("content-disposition: form-data; name=\"file\"; filename=\"{name}\"");
    let text = format!("--edge\r\n{head}\r\n\r\n{content}\r\n--edge--\r\n");
    Body { media: "multipart/form-data; boundary=edge", bytes: text.into_bytes() }
}

/// A model of very many parts.
pub fn rexs_model() -> Body {
    let mut text = String::from("<?xml version=\"1.0\"?><model version=\"1.4\"><components>");
    for k in 0..150_000 {
        text += &format!(
            "<component id=\"{k}\" type=\"shaft\"><attribute id=\"length\" unit=\"mm\">1</attribute></component>"
        );
    }
    text += "</components></model>";
    form("model.rexs", &text)
}

/// Points of a gear.
pub fn points_file() -> Body {
    let mut text = String::from("id,x,y,z\n");
    for k in 0..100_000 {
        let turn = std::f64::consts::TAU * (k % 52) as f64 / 52.0 + 0.030;
        text += &format!("{k},{},{},{}\n", 26.0 * turn.sin(), 26.0 * turn.cos(), 7.0 * noise(k));
    }
    form("points.csv", &text)
}
