//! A kept correction goes by the gear that it was made for and by what the axes mean, whatever is
//! said later.

use reqwest::Method;
use serde_json::{Value, json};
use sqlx::{ConnectOptions, sqlite::SqliteConnectOptions};

use super::{import::job, spur};
use crate::{
    harness::{Answer, TestApp, send},
    shapes::close,
};

const U: [f64; 4] = [6.0, 8.0, 10.0, 12.0];
const V: [f64; 5] = [1.0, 4.0, 7.5, 11.0, 14.0];

fn shape(u: f64, v: f64) -> f64 {
    5.0 * (u - 9.0) / 3.0 - 4.0 * (v - 7.5) / 6.5 + 0.3 * (2.0 * u + v).sin()
}

/// Returns nodes with coordinates and heights multiplied by these factors, and the axes with the
/// matching units; axes that are not given are in mm and µm.
fn flank(share: f64, [u, v, z]: [f64; 3], axes: Option<Value>) -> Value {
    let rows: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| z * share * shape(*u, *v)).collect()).collect();
    let mut body = json!({"nodes": {"type": "grid", "u": U.map(|x| u * x), "v": V.map(|x| v * x), "z": rows},
                          "model": {"type": "polynomial", "degree": 2, "terms": "total"}, "flank": "left",
                          "axes": super::fit_figures::axes()});
    if let Some(Value::Object(given)) = axes {
        body["axes"].as_object_mut().unwrap().extend(given);
    }
    body
}

async fn measure(app: &TestApp, job: &str, body: &Value) {
    let made = send(app.post(&format!("{job}/iterations"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
}

async fn correct(app: &TestApp, job: &str, body: &Value) -> Answer {
    let made = send(app.post(&format!("{job}/iterations/1/correction"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made
}

async fn correction_of(app: &TestApp, job: &str) -> Value {
    send(app.get(&format!("{job}/iterations/1/correction"))).await.json()
}

fn by_machine() -> Value {
    json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2})
}

/// Settings that tilt the flank, whatever its coordinates are called.
fn by_matrix() -> Value {
    let rows: Vec<[f64; 2]> =
        U.iter().flat_map(|u| V.iter().map(move |v| [(u - 9.0) / 3.0, (v - 7.5) / 6.5])).collect();
    json!({"sensitivity": {"type": "matrix", "settings": ["a", "b"], "matrix": rows}, "noise_sigma_um": 0.2})
}

fn axis(quantity: &str, unit: &str) -> Value {
    json!({"quantity": quantity, "unit": unit})
}

#[tokio::test]
async fn a_correction_is_compared_by_the_gear_that_it_was_made_for() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    measure(&app, &job, &flank(1.0, [1.0; 3], None)).await;
    correct(&app, &job, &by_machine()).await;
    measure(&app, &job, &flank(0.5, [1.0; 3], None)).await;
    let before = correction_of(&app, &job).await;
    assert_eq!((&before["gear"], &before["answer"]["verdict"]), (&spur(), &json!("weaker")), "{before}");
    // another gear: other settings follow from it, but not for what was corrected
    let mut other = spur();
    for (key, value) in [("helix_angle_deg", json!(25.0)), ("normal_pressure_angle_deg", json!(17.5))] {
        other[key] = value;
    }
    for key in ["tip_diameter_mm", "root_diameter_mm"] {
        other.as_object_mut().unwrap().remove(key);
    }
    let patch = async |body: Value| send(app.client.request(Method::PATCH, app.url(&job)).json(&body)).await;
    assert_eq!(patch(json!({"gear": other})).await.status, 200);
    assert_eq!(correction_of(&app, &job).await, before);
    assert_eq!(patch(json!({"clear": ["gear"]})).await.status, 200);
    assert_eq!(correction_of(&app, &job).await, before);
    // the record says it as well, and so do those of deviations
    let record = format!("{job}/iterations/1/records/{}", before["id"].as_str().unwrap());
    assert_eq!(send(app.get(&record)).await.json()["gear"], spur());
    let grid = json!({"gear": other,
        "grid": {"flank": "left", "roll_length_mm": U, "z_mm": V, "deviation_um": vec![[0.0; 5]; 4]}});
    let kept = send(app.post(&format!("{job}/iterations/1/deviations"), grid.to_string())).await;
    assert_eq!((kept.status.as_u16(), kept.json().get("gear")), (201, None), "the job has none now");
    assert_eq!(patch(json!({"gear": spur()})).await.status, 200);
    let kept = send(app.post(&format!("{job}/iterations/1/deviations"), grid.to_string())).await;
    assert_eq!(kept.json()["gear"], spur());
    app.stop().await;
}

/// Corrections that were kept before their gear was kept with them: compared as long as the job's
/// gear makes the same of them.
#[tokio::test]
async fn a_correction_without_its_gear_is_compared_as_long_as_it_is_the_same() {
    let app = TestApp::start_on_file().await;
    let job = job(&app, Some(spur())).await;
    measure(&app, &job, &flank(1.0, [1.0; 3], None)).await;
    correct(&app, &job, &by_machine()).await;
    measure(&app, &job, &flank(0.5, [1.0; 3], None)).await;
    let file = app.directory.path().join("test.db");
    let mut own = SqliteConnectOptions::new().filename(file).connect().await.unwrap();
    sqlx::raw_sql("DROP TRIGGER records_no_update; UPDATE records SET gear = NULL").execute(&mut own).await.unwrap();
    sqlx::Connection::close(own).await.unwrap();
    let before = correction_of(&app, &job).await;
    assert_eq!((before.get("gear"), &before["answer"]["verdict"]), (None, &json!("weaker")), "{before}");
    let mut other = spur();
    other["normal_pressure_angle_deg"] = json!(17.5);
    let patched = send(app.client.request(Method::PATCH, app.url(&job)).json(&json!({"gear": other}))).await;
    assert_eq!(patched.status, 200, "{}", patched.text);
    let after = correction_of(&app, &job).await;
    assert_eq!(after.get("answer"), None, "{after}");
    assert!(after["not_compared"].as_str().unwrap().contains("the gear of the job has changed since"), "{after}");
    app.stop().await;
}

/// The same places in other units are the same places.
#[tokio::test]
async fn axes_that_say_the_same_in_other_units_are_compared() {
    let radius = 26.0 * 20f64.to_radians().cos();
    let [roll, angle] = [axis("roll_length", "mm"), axis("roll_length", "deg")];
    let height = json!({"quantity": "deviation", "unit": "mm", "positive": "material_in"});
    for (request, factors, axes) in [
        (by_machine(), [1e3, 1.0, 1.0], json!({"u": axis("roll_length", "um")})),
        (
            by_machine(),
            [(1.0 / radius).to_degrees(), 1e3, -1e-3],
            json!({"u": angle, "v": axis("face_width", "um"), "z": height}),
        ),
        (by_matrix(), [1.0, 1e3, -1e-3], json!({"u": roll, "v": axis("face_width", "um"), "z": height})),
    ] {
        let app = TestApp::start().await;
        let job = job(&app, Some(spur())).await;
        measure(&app, &job, &flank(1.0, [1.0; 3], None)).await;
        correct(&app, &job, &request).await;
        measure(&app, &job, &flank(0.5, factors, Some(axes.clone()))).await;
        let found = correction_of(&app, &job).await;
        let plain = {
            let job = super::import::job(&app, Some(spur())).await;
            measure(&app, &job, &flank(1.0, [1.0; 3], None)).await;
            correct(&app, &job, &request).await;
            measure(&app, &job, &flank(0.5, [1.0; 3], None)).await;
            correction_of(&app, &job).await
        };
        assert_eq!(found["answer"]["verdict"], "weaker", "{axes}: {found}");
        for key in ["response_ratio", "rms_measured_um", "chi_squared"] {
            let [a, b] = [&found, &plain].map(|one| one["answer"][key].as_f64().unwrap());
            close(a, b, 1e-6 * b.abs());
        }
        app.stop().await;
    }
}

/// The same numbers that mean something else are not compared.
#[tokio::test]
async fn axes_that_say_something_else_are_not_compared() {
    let app = TestApp::start().await;
    let curve = |share: f64, axes: Option<Value>| {
        let mut body = json!({"nodes": {"type": "curve", "x": U, "y": U.map(|u| share * (u - 8.0) * (u - 11.0))},
                              "model": {"type": "polynomial", "degree": 1}});
        if let Some(axes) = axes {
            body["axes"] = axes;
        }
        body
    };
    let tilt: Vec<[f64; 1]> = U.iter().map(|u| [u - 9.0]).collect();
    let along = json!({"sensitivity": {"type": "matrix", "settings": ["a"], "matrix": tilt}, "noise_sigma_um": 0.2});
    let surface = |axes: Value| flank(0.5, [1.0; 3], Some(axes));
    for (first, request, second, why) in [
        (flank(1.0, [1.0; 3], None), by_machine(), surface(json!({"u": axis("roll_length", "deg")})), "in mm?"),
        (flank(1.0, [1.0; 3], None), by_machine(), surface(json!({"v": axis("face_width", "um")})), "in mm?"),
        (flank(1.0, [1.0; 3], None), by_machine(), surface(json!({"u": axis("my own", "mm")})), "`my own`"),
        (flank(1.0, [1.0; 3], None), by_matrix(), surface(json!({"u": axis("roll_length", "deg")})), "in mm?"),
        (flank(1.0, [1.0; 3], None), by_matrix(), surface(json!({"v": axis("face_width", "um")})), "in mm?"),
        (flank(1.0, [1.0; 3], None), by_matrix(), surface(json!({"z": axis("waviness", "um")})), "`waviness`"),
        (curve(1.0, None), along.clone(), curve(0.5, Some(json!({"x": axis("diameter", "mm")}))), "not given"),
        (
            curve(1.0, Some(json!({"x": axis("face_width", "mm")}))),
            along,
            curve(0.5, Some(json!({"x": axis("roll_length", "mm")}))),
            "`roll_length` in `mm`, that of the corrected one `face_width` in `mm`",
        ),
    ] {
        let job = job(&app, Some(spur())).await;
        measure(&app, &job, &first).await;
        correct(&app, &job, &request).await;
        measure(&app, &job, &second).await;
        let found = correction_of(&app, &job).await;
        assert_eq!(found.get("answer"), None, "{found}");
        assert!(found["not_compared"].as_str().unwrap().contains(why), "{why}: {}", found["not_compared"]);
    }
    app.stop().await;
}
