//! Deviations of measured points and registration.

use serde_json::{Value, json};

use super::{pointers, taken};
use crate::{
    harness::TestApp,
    shapes::{close, numbers},
};

fn helical() -> Value {
    json!({"teeth": 31, "normal_module_mm": 2.0, "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 15.0,
        "hand": "right", "face_width_mm": 20.0})
}

/// Points of the service's own flank, moved along its normals by `out` µm; the laws hold the flank
/// to the formulas.
async fn points(app: &TestApp, flank: &str, tooth: u32, out: f64) -> Vec<Vec<f64>> {
    let request = json!({"gear": helical(), "flank": flank, "tooth": tooth,
                         "profile": {"axis": "diameter", "values": [63.0, 65.0, 67.0]},
                         "face_width_positions_mm": [1.0, 10.0, 19.0]});
    let answer = taken(app, "/v1/gears/flank", &request).await;
    let flat = |name: &str| -> Vec<Vec<f64>> {
        answer[name].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap().iter().map(numbers)).collect()
    };
    let (points, normals) = (flat("points"), flat("normals"));
    points.iter().zip(&normals).map(|(p, n)| (0..3).map(|c| p[c] + 1e-3 * out * n[c]).collect()).collect()
}

#[tokio::test]
async fn points_have_the_deviation_that_they_were_moved_by() {
    let app = TestApp::start().await;
    let mut all: Vec<Value> = Vec::new();
    for (flank, tooth) in [("left", 1), ("right", 1), ("left", 12)] {
        all.extend(points(&app, flank, tooth, 7.0).await.into_iter().map(Value::from));
    }
    all.push(Value::Null);
    let request = json!({"gear": helical(), "points": all});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    for k in 0..27 {
        close(answer["deviation_um"][k].as_f64().unwrap(), 7.0, 1e-9);
    }
    assert_eq!((answer["deviation_um"][27].clone(), answer["undefined"].clone()), (Value::Null, json!(1)));
    assert_eq!((&answer["tooth"][20], &answer["flank"][10]), (&json!(12), &json!("right")));
    close(answer["rms_um"].as_f64().unwrap(), 7.0, 1e-9);
    // transverse deviations are greater by 1 / cos β_b, and a ball's centre is off by its radius
    let beta_b = (15f64.to_radians().sin() * 20f64.to_radians().cos()).asin();
    let request = json!({"gear": helical(), "points": points(&app, "left", 1, 507.0).await, "probe_radius_mm": 0.5,
        "direction": "transverse"});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    close(answer["deviation_um"][4].as_f64().unwrap(), 7.0 / beta_b.cos(), 1e-9);

    let mut bad = points(&app, "left", 1, 0.0).await;
    bad[3] = vec![0.0, 10.0, 0.0];
    let request = json!({"gear": helical(), "points": bad});
    assert_eq!(pointers(&app, "/v1/gears/deviations", &request).await, ["/points/3"]);
    let request = json!({"gear": helical(), "points": bad, "strays": "undefined"});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    assert_eq!(answer["strays"][0]["index"], 3);
    app.stop().await;
}

#[tokio::test]
async fn a_turned_and_shifted_part_is_laid_back() {
    let app = TestApp::start().await;
    let (turn, shift) = (2e-4f64, [0.03, -0.02]);
    let mut all = Vec::new();
    for tooth in [1, 9, 17, 25] {
        for flank in ["left", "right"] {
            for p in points(&app, flank, tooth, 0.0).await {
                let (x, y) = (p[0] * turn.cos() - p[1] * turn.sin(), p[0] * turn.sin() + p[1] * turn.cos());
                all.push([x + shift[0], y + shift[1], p[2]]);
            }
        }
    }
    let request =
        json!({"gear": helical(), "points": all, "registration": {"motions": ["x_shift", "y_shift", "rotation"]}});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    let registration = &answer["registration"];
    let found: Vec<f64> =
        registration["motions"].as_array().unwrap().iter().map(|m| m["value"].as_f64().unwrap()).collect();
    for (found, truth) in found.iter().zip([30.0, -20.0, 200.0]) {
        assert!((found - truth).abs() < 1e-6, "{found} {truth}");
    }
    assert!(registration["rms_before_um"].as_f64().unwrap() > 5.0 && answer["rms_um"].as_f64().unwrap() < 1e-6);
    assert_eq!(registration["converged"], true);
    // on one flank a turn and a shift along the axis are the same screw
    let one: Vec<Vec<f64>> = points(&app, "left", 1, 3.0).await;
    let request = json!({"gear": helical(), "points": one, "registration": {"motions": ["axial_shift", "rotation"]}});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    let apart = &answer["registration"]["indistinguishable"][0];
    assert_eq!(apart["names"], json!(["axial_shift", "rotation"]), "{apart}");
    assert!(answer["registration"]["motions"].as_array().unwrap().iter().all(|m| m["determined"] == false));
    let request = json!({"gear": helical(), "points": one, "registration": {"motions": ["roll"]}});
    assert_eq!(pointers(&app, "/v1/gears/deviations", &request).await, ["/registration/motions/0"]);
    let request = json!({"gear": helical(), "points": one, "noise_sigma": 1.0});
    assert_eq!(pointers(&app, "/v1/gears/deviations", &request).await, ["/noise_sigma"]);
    app.stop().await;
}

/// Eight flanks, turned and shifted.
async fn laid(app: &TestApp, turn: f64, shift: [f64; 2]) -> (Vec<[f64; 3]>, Vec<u32>, Vec<&'static str>) {
    let (mut all, mut teeth, mut flanks) = (Vec::new(), Vec::new(), Vec::new());
    for tooth in [1, 9, 17, 25] {
        for flank in ["left", "right"] {
            for p in points(app, flank, tooth, 0.0).await {
                let (x, y) = (p[0] * turn.cos() - p[1] * turn.sin(), p[0] * turn.sin() + p[1] * turn.cos());
                all.push([x + shift[0], y + shift[1], p[2]]);
                teeth.push(tooth);
                flanks.push(flank);
            }
        }
    }
    (all, teeth, flanks)
}

#[tokio::test]
async fn a_part_may_lie_anywhere() {
    let app = TestApp::start().await;
    let motions = json!({"motions": ["x_shift", "y_shift", "rotation"]});
    let value = |answer: &Value, k: usize| answer["registration"]["motions"][k]["value"].as_f64().unwrap();
    let codes = |answer: &Value| -> Vec<String> {
        let warnings = answer["registration"]["warnings"].as_array().unwrap();
        warnings.iter().map(|warning| warning["code"].as_str().unwrap().to_owned()).collect()
    };
    // without teeth and flanks: turned by a third of a pitch and off centre by three quarters of a
    // module
    let pitch = std::f64::consts::TAU / 31.0;
    let (all, teeth, flanks) = laid(&app, 0.33 * pitch, [1.3, -0.8]).await;
    let request = json!({"gear": helical(), "points": all, "registration": motions});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    for (k, truth) in [1300.0, -800.0, 0.33e6 * pitch].into_iter().enumerate() {
        assert!((value(&answer, k) - truth).abs() < 1e-4, "{k}: {}", value(&answer, k));
    }
    assert_eq!(codes(&answer)[0], "rotation_modulo_pitch");
    assert_eq!(answer["flank"], json!(flanks));
    // a quarter of a turn and more is known where teeth and flanks are
    for turn in [1.7, -3.0] {
        let (all, ..) = laid(&app, turn, [1.3, -0.8]).await;
        let request =
            json!({"gear": helical(), "points": all, "teeth": teeth, "flanks": flanks, "registration": motions});
        let answer = taken(&app, "/v1/gears/deviations", &request).await;
        assert!((value(&answer, 2) - 1e6 * turn).abs() < 1e-4, "{}", value(&answer, 2));
        assert_eq!(codes(&answer), Vec::<String>::new());
        assert_eq!(answer["tooth"], json!(teeth));
    }
    // a motion that no point determines has no error
    let both = json!({"motions": ["axial_shift", "rotation"]});
    let (all, ..) = laid(&app, 0.0, [0.002, 0.0]).await;
    let answer =
        taken(&app, "/v1/gears/deviations", &json!({"gear": helical(), "points": all, "registration": both})).await;
    let found = answer["registration"]["motions"].as_array().unwrap();
    assert!(found.iter().all(|motion| motion["determined"] == false && motion.get("std_error").is_none()));
    assert!(codes(&answer).contains(&"motions_indistinguishable".to_owned()));
    app.stop().await;
}

/// A tooth of four that the operator miscounted, and three.
#[tokio::test]
async fn wrongly_named_teeth_are_warned_of() {
    let app = TestApp::start().await;
    let pitch = std::f64::consts::TAU / 31.0;
    let (all, teeth, flanks) = laid(&app, 1.2 * pitch, [0.9, -0.4]).await;
    let request = |wrong: &[u32]| {
        let named: Vec<u32> =
            teeth.iter().map(|tooth| if wrong.contains(tooth) { tooth % 31 + 1 + tooth / 8 } else { *tooth }).collect();
        let motions = json!({"motions": ["x_shift", "y_shift", "rotation"]});
        json!({"gear": helical(), "points": all, "teeth": named, "flanks": flanks, "registration": motions})
    };
    let answer = taken(&app, "/v1/gears/deviations", &request(&[9])).await;
    let registration = &answer["registration"];
    for (k, truth) in [900.0, -400.0, 1.2e6 * pitch].into_iter().enumerate() {
        let found = registration["motions"][k]["value"].as_f64().unwrap();
        assert!((found - truth).abs() < 1e-4, "{k}: {found}");
    }
    assert_eq!(answer["tooth"], json!(teeth));
    let codes: Vec<_> = registration["warnings"].as_array().unwrap().iter().map(|w| w["code"].clone()).collect();
    assert_eq!(codes, ["teeth_contradict"]);
    assert_eq!(pointers(&app, "/v1/gears/deviations", &request(&[9, 17, 25])).await, ["/teeth"]);
    // the screw that equals a rotation is named
    let (all, ..) = laid(&app, 0.58, [0.0, 0.0]).await;
    let alone = json!({"motions": ["axial_shift"]});
    let request = json!({"gear": helical(), "points": all, "teeth": teeth, "flanks": flanks, "registration": alone});
    let answer = taken(&app, "/v1/gears/deviations", &request).await;
    let warnings = answer["registration"]["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|warning| warning["code"] == "axial_shift_for_rotation"), "{warnings:?}");
    app.stop().await;
}
