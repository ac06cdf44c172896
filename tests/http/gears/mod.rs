//! Gears over real HTTP.

mod against_design;
mod conformity;
mod correction;
mod correction_applied;
mod correction_flank;
mod correction_kept;
mod correction_request;
mod correction_target;
mod counting;
mod evaluation;
mod exchange;
mod fit_figures;
mod gear_correction;
pub mod import;
mod kept_traces;
#[path = "../../../engine/tests/formats/klingelnberg_file.rs"]
#[expect(dead_code, reason = "the writer is that of the formats' tests, of which a part is used here")]
mod klingelnberg_file;
mod measurands;
mod nominal;
mod one_value;
mod outliers;
mod p40;
mod pitch_kept;
mod points;
#[path = "../../../engine/tests/formats/qdas_file.rs"]
mod qdas_file;
mod quality_data;
mod refusals;
mod requirements;
#[path = "../../../engine/tests/formats/rexs_file.rs"]
#[expect(dead_code, reason = "the writer is that of the formats' tests, of which a part is used here")]
mod rexs_file;
mod solid_mesh;
mod teeth;

use serde_json::{Value, json};

use crate::harness::{TestApp, send};

/// A spur gear of a real measurement (`engine/tests/data/p40`).
fn spur() -> Value {
    json!({"teeth": 52, "normal_module_mm": 1.0, "normal_pressure_angle_deg": 20.0, "profile_shift_coefficient": 0.011,
           "face_width_mm": 15.0, "tip_diameter_mm": 54.0219, "root_diameter_mm": 49.5219})
}

/// The answer of a request that is taken.
async fn taken(app: &TestApp, path: &str, body: &Value) -> Value {
    let answer = send(app.post(path, body.to_string())).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

/// Pointers of a request that is refused.
async fn pointers(app: &TestApp, path: &str, body: &Value) -> Vec<String> {
    let answer = send(app.post(path, body.to_string())).await;
    assert_eq!(answer.status, 422, "{}", answer.text);
    let problem = answer.json();
    problem["errors"].as_array().unwrap().iter().map(|e| e["pointer"].as_str().unwrap().to_owned()).collect()
}
