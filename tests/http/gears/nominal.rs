//! Geometry, flanks, sections and envelopes.

use serde_json::{Value, json};

use super::{pointers, spur, taken};
use crate::{
    harness::TestApp,
    shapes::{close, examples, numbers},
};

#[tokio::test]
async fn the_examples_are_answered() {
    let app = TestApp::start().await;
    for (operation, path) in [
        ("gear_geometry", "geometry"),
        ("gear_flank", "flank"),
        ("gear_profile", "profile"),
        ("gear_envelope", "envelope"),
        ("gear_tolerances", "tolerances"),
        ("evaluate_gear", "evaluate"),
        ("gear_pitch", "pitch"),
        ("gear_deviations", "deviations"),
        ("gear_flank_surface", "flank-surface"),
    ] {
        for (name, example) in examples(operation) {
            let answer = taken(&app, &format!("/v1/gears/{path}"), &example).await;
            assert!(answer.as_object().is_some_and(|answer| !answer.is_empty()), "{name}");
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn base_circles_of_the_paper() {
    let app = TestApp::start().await;
    for (teeth, module, alpha, beta, base, base_helix) in
        [(83, 2.03, 18.0, 28.0, 179.0857, 26.519), (26, 1.44, 17.0, 25.0, 39.1433, 23.838)]
    {
        let gear = json!({"teeth": teeth, "normal_module_mm": module, "normal_pressure_angle_deg": alpha,
            "helix_angle_deg": beta});
        let answer = taken(&app, "/v1/gears/geometry", &json!({"gear": gear})).await;
        assert!((answer["base_diameter_mm"].as_f64().unwrap() - base).abs() < 5e-5);
        assert!((answer["base_helix_angle_deg"].as_f64().unwrap() - base_helix).abs() < 5e-4);
        // π m_t / 2 without a profile shift
        let thickness = std::f64::consts::FRAC_PI_2 * answer["transverse_module_mm"].as_f64().unwrap();
        close(answer["tooth_thickness_mm"].as_f64().unwrap(), thickness, 1e-15);
    }
    let few = json!({"gear": {"teeth": 8, "normal_module_mm": 1.0}});
    let answer = taken(&app, "/v1/gears/geometry", &few).await;
    let codes: Vec<_> = answer["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect();
    assert!(answer["undercut"] == true && codes.contains(&"undercut"), "{codes:?}");
    for (change, pointer) in [
        (json!({"helix_angle_deg": 90}), "/gear/helix_angle_deg"),
        (json!({"tip_diameter_mm": 40}), "/gear/tip_diameter_mm"),
        (json!({"tip_diameter_mm": 53, "root_diameter_mm": 54}), "/gear/tip_diameter_mm"),
        (json!({"internal": true, "tip_diameter_mm": 60}), "/gear/tip_diameter_mm"),
        (json!({"helix_angle_deg": -5, "hand": "right"}), "/gear/hand"),
    ] {
        let mut gear = spur();
        gear.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        assert_eq!(pointers(&app, "/v1/gears/geometry", &json!({"gear": gear})).await, [pointer]);
    }
    app.stop().await;
}

/// Against the printed parametric form of the involute helicoid.
#[tokio::test]
async fn nodes_lie_on_the_involute_and_relief_is_taken_along_the_normal() {
    let app = TestApp::start().await;
    let gear = json!({"teeth": 26, "normal_module_mm": 1.44, "normal_pressure_angle_deg": 17.0, "helix_angle_deg": 25.0,
                      "hand": "left", "face_width_mm": 12.0});
    let (rolls, z) = ([4.0, 6.0, 9.0], [-3.0, 0.0, 5.0]);
    let mut request = json!({"gear": gear, "flank": "left", "profile": {"axis": "roll_length", "values": rolls},
        "face_width_positions_mm": z});
    let plain = taken(&app, "/v1/gears/flank", &request).await;
    let (alpha, beta) = (17f64.to_radians(), 25f64.to_radians());
    let alpha_t = (alpha.tan() / beta.cos()).atan();
    let r_b = 0.5 * 26.0 * 1.44 / beta.cos() * alpha_t.cos();
    let beta_b = (beta.sin() * alpha.cos()).asin();
    let psi_b = std::f64::consts::FRAC_PI_2 / 26.0 + alpha_t.tan() - alpha_t;
    let vector = |value: &Value| numbers(value);
    for (i, roll) in rolls.iter().enumerate() {
        for (j, z) in z.iter().enumerate() {
            let xi = roll / r_b;
            let phi = xi - psi_b + z * beta_b.tan() / r_b;
            let truth = [r_b * (phi.sin() - xi * phi.cos()), r_b * (phi.cos() + xi * phi.sin()), *z];
            let normal = [-beta_b.cos() * phi.cos(), beta_b.cos() * phi.sin(), beta_b.sin()];
            for c in 0..3 {
                assert!((vector(&plain["points"][i][j])[c] - truth[c]).abs() < 1e-13 * r_b, "{i} {j} {c}");
                assert!((vector(&plain["normals"][i][j])[c] - normal[c]).abs() < 1e-14, "{i} {j} {c}");
            }
        }
    }
    request["modifications"] = json!([{"type": "profile_crowning", "amount_um": 10.0}]);
    request["modification_range"] = json!({"profile_diameter_range_mm": [
        2.0 * r_b.hypot(4.0), 2.0 * r_b.hypot(8.0)], "helix_range_mm": [-3.0, 5.0]});
    let crowned = taken(&app, "/v1/gears/flank", &request).await;
    for (row, relief) in [(0, 10.0), (1, 0.0)] {
        let (before, after) = (vector(&plain["points"][row][1]), vector(&crowned["points"][row][1]));
        let normal = vector(&plain["normals"][row][1]);
        for c in 0..3 {
            assert!((after[c] - before[c] + 1e-3 * relief * normal[c]).abs() < 1e-12);
        }
        assert!((crowned["relief_um"][row][1].as_f64().unwrap() - relief).abs() < 1e-9);
    }
    request["profile"]["axis"] = json!("diameter");
    assert_eq!(
        pointers(&app, "/v1/gears/flank", &request).await,
        ["/profile/values/0", "/profile/values/1", "/profile/values/2"]
    );
    app.stop().await;
}

#[tokio::test]
async fn a_section_is_closed_and_an_envelope_is_the_involute() {
    let app = TestApp::start().await;
    let request = json!({"gear": spur(), "whole_gear": true});
    let answer = taken(&app, "/v1/gears/profile", &request).await;
    let area = |polygon: &Value| {
        let points: Vec<Vec<f64>> = polygon.as_array().unwrap().iter().map(numbers).collect();
        let next = points.iter().cycle().skip(1);
        0.5 * points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
    };
    // between the circles of root and tip, counterclockwise
    let (root, tip) = (49.5219f64 / 2.0, 54.0219f64 / 2.0);
    let gear = area(&answer["whole_gear"]);
    assert!(std::f64::consts::PI * root * root < gear && gear < std::f64::consts::PI * tip * tip, "{gear}");
    assert!(area(&answer["tooth"]) > 0.0);

    // a straight rack flank at 20° about the pitch line of z = 52, m = 1, left of the tooth, cuts
    // half angles ψ + inv α − inv α_y
    let slope = 20f64.to_radians().tan();
    let quarter = std::f64::consts::PI / 4.0;
    let points: Vec<[f64; 2]> = [-1.0, 1.0].iter().map(|y| [slope * y - quarter, *y]).collect();
    let request = json!({"tool": {"points": points, "steps": 2000}, "motion": {"type": "rack", "pitch_radius_mm": 26.0},
                         "radius_range_mm": [25.4, 26.6], "radii_mm": [25.8, 26.2]});
    let answer = taken(&app, "/v1/gears/envelope", &request).await;
    let r_b = 26.0 * 20f64.to_radians().cos();
    let inv = |r: f64| ((r * r - r_b * r_b).sqrt() / r_b) - (r_b / r).acos();
    for (found, radius) in numbers(&answer["half_angle_deg"]).iter().zip([25.8f64, 26.2]) {
        let truth = std::f64::consts::FRAC_PI_2 / 52.0 + inv(26.0) - inv(radius);
        assert!((found.to_radians() - truth).abs() < 1e-7, "{found} {}", truth.to_degrees());
    }
    app.stop().await;
}
