//! Numbers that are too large, paths of errors, gears and borders that leave nothing.

use serde_json::{Value, json};

use super::{pointers, spur, taken};
use crate::{harness::TestApp, shapes::close};

fn twenty() -> Value {
    json!({"teeth": 20, "normal_module_mm": 2.0, "face_width_mm": 10.0})
}

#[tokio::test]
async fn numbers_out_of_range_are_refused_with_their_pointer() {
    let app = TestApp::start().await;
    let mut index = vec![0.0; 20];
    (index[0], index[3]) = (1e308, -1e308);
    let request = json!({"gear": twenty(), "left": {"index_deviation_um": index}, "readings_um": vec![1e300; 20]});
    assert_eq!(
        pointers(&app, "/v1/gears/pitch", &request).await,
        ["/left/index_deviation_um/0", "/left/index_deviation_um/3"]
            .into_iter()
            .map(str::to_owned)
            .chain((0..20).map(|k| format!("/readings_um/{k}")))
            .collect::<Vec<_>>()
    );
    let request = json!({"gear": twenty(), "left": {"index_deviation_um": vec![0.0; 20]}, "diameter_mm": 1e300});
    assert_eq!(pointers(&app, "/v1/gears/pitch", &request).await, ["/diameter_mm"]);
    let z: Vec<f64> = (0..9).map(f64::from).collect();
    let trace = json!({"tooth": "1", "flank": "left", "kind": "helix", "z_mm": z, "deviation_um": z});
    let mut large = trace.clone();
    large["deviation_um"][4] = json!(1e150);
    let of = |trace: Value, evaluation: Value| json!({"gear": twenty(), "traces": [trace], "evaluation": evaluation});
    for (trace, evaluation, pointer) in [
        (large, json!({"helix_range_mm": [1.0, 7.0]}), "/traces/0/deviation_um/4"),
        (
            trace.clone(),
            json!({"helix_range_mm": [1.0, 7.0], "helix_reference_length_mm": 1e300}),
            "/evaluation/helix_reference_length_mm",
        ),
        (trace.clone(), json!({"helix_range_mm": [1.0, 1e300]}), "/evaluation/helix_range_mm"),
        (trace, json!({"helix_range_mm": [1.0, 1.0000001]}), "/evaluation/helix_range_mm"),
    ] {
        assert_eq!(pointers(&app, "/v1/gears/evaluate", &of(trace, evaluation)).await, [pointer]);
    }
    for (name, value) in [("normal_module_mm", 1e-300), ("normal_pressure_angle_deg", 1e-9), ("tip_diameter_mm", 1e9)] {
        let mut gear = spur();
        gear[name] = json!(value);
        let found = pointers(&app, "/v1/gears/geometry", &json!({"gear": gear})).await;
        assert!(found.contains(&format!("/gear/{name}")), "{found:?}");
    }
    app.stop().await;
}

#[tokio::test]
async fn profile_samples_have_the_pointers_of_the_request() {
    let app = TestApp::start().await;
    for name in ["diameter_mm", "roll_length_mm"] {
        let trace = json!({"tooth": "1", "flank": "left", "kind": "profile", name: [39.0, 40.0, 1e8],
                           "deviation_um": [0.0, 0.0, 0.0]});
        let request =
            json!({"gear": twenty(), "traces": [trace], "evaluation": {"profile_diameter_range_mm": [39.0, 41.0]}});
        assert_eq!(pointers(&app, "/v1/gears/evaluate", &request).await, [format!("/traces/0/{name}/2")]);
    }
    app.stop().await;
}

#[tokio::test]
async fn a_missing_eccentricity_is_explained() {
    let app = TestApp::start().await;
    let readings: Vec<f64> = (0..20).map(|k| 1e-150 * f64::from(k)).collect();
    let answer = taken(&app, "/v1/gears/pitch", &json!({"gear": twenty(), "readings_um": readings})).await;
    let warning = answer["runout"]["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|warning| warning["code"] == "no_eccentricity")
        .unwrap();
    let why = "no eccentricity: squares of these heights underflow in double precision: choose a smaller unit";
    assert_eq!(warning["message"], why);
    app.stop().await;
}

#[tokio::test]
async fn angles_run_with_the_counting() {
    let app = TestApp::start().await;
    let ascending: Vec<f64> = (0..20).map(|k| 18.0 * f64::from(k) + 5.0).collect();
    let descending: Vec<f64> = ascending.iter().map(|a| -a).collect();
    let of = |angles: &[f64]| json!({"gear": twenty(), "right": {"angle_deg": angles}, "counting": "counterclockwise"});
    let answer = taken(&app, "/v1/gears/pitch", &of(&ascending)).await;
    assert!(answer["right"]["cumulative_pitch_um"].as_f64().unwrap() < 1e-6);
    assert_eq!(answer["counting"], "counterclockwise");
    assert_eq!(pointers(&app, "/v1/gears/pitch", &of(&descending)).await, ["/right/angle_deg/1"]);
    app.stop().await;
}

#[tokio::test]
async fn warnings_and_errors_name_fields_of_the_request() {
    let app = TestApp::start().await;
    let mut single = vec![Some(1.0); 20];
    single[4] = Some(5.0);
    let request = json!({"gear": twenty(), "left": {"single_pitch_um": single}});
    let answer = taken(&app, "/v1/gears/pitch", &request).await;
    assert_eq!(answer["left"]["warnings"][0]["code"], "pitches_do_not_close");
    assert_eq!(answer["left"]["warnings"][0]["pointer"], "/left/single_pitch_um");
    single[4] = None;
    let request = json!({"gear": twenty(), "left": {"single_pitch_um": single}});
    let answer = taken(&app, "/v1/gears/pitch", &request).await;
    assert_eq!(answer["left"]["warnings"][0]["pointer"], "/left/single_pitch_um");

    let point = [[0.0, 20.0, 1.0]];
    let path = "/v1/gears/deviations";
    for (request, pointer) in [
        (json!({"gear": twenty(), "points": point, "teeth": [21]}), "/teeth/0"),
        (json!({"gear": twenty(), "points": []}), "/points"),
        (
            json!({"gear": twenty(),
                "grid": {"flank": "left", "roll_length_mm": [6.0, 7.0], "z_mm": [1.0, 2.0],
                    "deviation_um": [[0.0, 1.0], [1.0, 2.0]]},
                   "borders": {"root_percent": 60, "tip_percent": 60}}),
            "/borders/root_percent",
        ),
        (
            json!({"gear": twenty(),
                "grid": {"flank": "left", "roll_length_mm": [6.0, 7.0], "z_mm": [1.0, 2.0],
                    "deviation_um": [[0.0, 1.0], [1.0, 2.0]]},
                   "borders": {"z_range_mm": [3.0, 2.0]}}),
            "/borders/z_range_mm",
        ),
        (
            json!({"gear": twenty(), "points": point,
                "modifications": [{"type": "tip_relief", "amount_um": 5, "start_diameter_mm": 1.0}]}),
            "/modifications/0/start_diameter_mm",
        ),
    ] {
        assert_eq!(pointers(&app, path, &request).await, [pointer], "{request}");
    }
    for tooth in ["0", "21", "21k", "99999999999999999999999"] {
        let trace =
            json!({"tooth": tooth, "flank": "left", "kind": "helix", "z_mm": [0.0, 1.0], "deviation_um": [0.0, 1.0]});
        let request = json!({"gear": twenty(), "traces": [trace], "evaluation": {"helix_range_mm": [0.0, 1.0]}});
        assert_eq!(pointers(&app, "/v1/gears/evaluate", &request).await, ["/traces/0/tooth"], "{tooth}");
    }
    app.stop().await;
}

#[tokio::test]
async fn slopes_over_lengths_that_the_gear_has_not_got_have_no_class() {
    let app = TestApp::start().await;
    let z: Vec<f64> = (0..=10).map(f64::from).collect();
    let trace = json!({"tooth": "1", "flank": "left", "kind": "helix", "z_mm": z, "deviation_um": z});
    for (length, has_class) in [(10.0, true), (11.0, false)] {
        let request = json!({"gear": twenty(), "traces": [trace],
                             "evaluation": {"helix_range_mm": [1.0, 9.0], "helix_reference_length_mm": length}});
        let answer = taken(&app, "/v1/gears/evaluate", &request).await;
        close(answer["traces"][0]["slope_um"].as_f64().unwrap(), length, 1e-9);
        assert_eq!(answer["traces"][0].get("class").is_some(), has_class, "{length}");
        let warned = answer["warnings"].to_string().contains("foreign_reference_length");
        assert_eq!(warned, !has_class);
    }
    app.stop().await;
}

#[tokio::test]
async fn a_gear_without_an_involute_has_no_profile() {
    let app = TestApp::start().await;
    let gear = json!({"teeth": 20, "normal_module_mm": 2.0, "profile_shift_coefficient": 5.0});
    let derived = taken(&app, "/v1/gears/geometry", &json!({"gear": gear})).await;
    assert_eq!(derived["warnings"][0]["code"], "tip_below_form_diameter");
    assert_eq!(pointers(&app, "/v1/gears/profile", &json!({"gear": gear})).await, ["/gear/profile_shift_coefficient"]);
    let few = json!({"gear": {"teeth": 12, "normal_module_mm": 2.0, "helix_angle_deg": 10.0}});
    let answer = taken(&app, "/v1/gears/profile", &few).await;
    let codes: Vec<&str> = answer["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"undercut") && codes.contains(&"hand_assumed"), "{codes:?}");
    assert!(!answer["tooth"].to_string().contains("-0.0,") && !answer["tooth"].to_string().contains("-0,"));
    app.stop().await;
}

#[tokio::test]
async fn traces_refer_to_the_modified_flank() {
    let app = TestApp::start().await;
    let z: Vec<f64> = (0..=20).map(f64::from).collect();
    let roll: Vec<f64> = (0..=20).map(|k| 7.0 + 0.5 * f64::from(k)).collect();
    let helical =
        json!({"teeth": 31, "normal_module_mm": 2.0, "helix_angle_deg": 15.0, "hand": "right", "face_width_mm": 20.0});
    let beta_b = (15f64.to_radians().sin() * 20f64.to_radians().cos()).asin();
    let base = 62.0 / 15f64.to_radians().cos() * ((20f64.to_radians().tan() / 15f64.to_radians().cos()).atan()).cos();
    let diameter = |roll: f64| base.hypot(2.0 * roll);
    // 8 v² of crowning over the width, 6 u/2 of slope over the roll lengths, transverse: what a
    // perfect flank shows, and 4 µm of slope more
    let v = |z: f64| (z - 10.0) / 10.0;
    let u = |l: f64| (l - 12.0) / 5.0;
    for flank in ["left", "right"] {
        let side = if flank == "left" { 1.0 } else { -1.0 };
        let helix: Vec<f64> = z.iter().map(|z| side * (-8.0 * v(*z).powi(2) / beta_b.cos() + 2.0 * v(*z))).collect();
        let profile: Vec<f64> = roll.iter().map(|l| -3.0 * u(*l) / beta_b.cos() + 2.0 * u(*l)).collect();
        let mut request = json!({
            "gear": helical,
            "traces": [
                {"tooth": "1", "flank": flank, "kind": "helix", "z_mm": z, "deviation_um": helix,
                    "section_diameter_mm": diameter(12.0)},
                {"tooth": "1", "flank": flank, "kind": "profile", "roll_length_mm": roll, "deviation_um": profile,
                    "section_z_mm": 10.0}],
            "modifications": [{"type": "helix_crowning", "amount_um": 8.0},
                {"type": "profile_slope", "amount_um": 6.0}],
            "modification_range": {"profile_diameter_range_mm": [diameter(7.0), diameter(17.0)],
                "helix_range_mm": [0.0, 20.0]},
            "evaluation": {"helix_range_mm": [0.0, 20.0],
                "profile_diameter_range_mm": [diameter(7.0), diameter(17.0)]}});
        let answer = taken(&app, "/v1/gears/evaluate", &request).await;
        for trace in answer["traces"].as_array().unwrap() {
            // material that grows with z is a left-hand deviation on right flanks
            let truth = if trace["kind"] == "helix" { side * 4.0 } else { 4.0 };
            close(trace["slope_um"].as_f64().unwrap(), truth, 1e-9);
            assert!(trace["crowning_um"].as_f64().unwrap().abs() < 1e-9, "{trace}");
        }
        request["traces"][1].as_object_mut().unwrap().remove("section_z_mm");
        assert_eq!(pointers(&app, "/v1/gears/evaluate", &request).await, ["/traces/1/section_z_mm"]);
    }
    app.stop().await;
}

#[tokio::test]
async fn deviations_refer_to_the_modified_flank() {
    let app = TestApp::start().await;
    let gear =
        json!({"teeth": 31, "normal_module_mm": 2.0, "helix_angle_deg": 15.0, "hand": "right", "face_width_mm": 20.0});
    let modifications = json!([{"type": "helix_crowning", "amount_um": 8.0},
        {"type": "profile_slope", "amount_um": 6.0}, {"type": "twist", "amount_um": 10.0}]);
    let range = json!({"profile_diameter_range_mm": [61.0, 65.5], "helix_range_mm": [0.0, 20.0]});
    let flank = json!({"gear": gear, "flank": "left", "profile": {"axis": "diameter", "values": [61.5, 63.0, 65.0]},
        "face_width_positions_mm": [1.0, 10.0, 19.0],
                       "modifications": modifications, "modification_range": range});
    let nodes = taken(&app, "/v1/gears/flank", &flank).await;
    let points: Vec<Value> =
        nodes["points"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap().clone()).collect();
    let relief: Vec<f64> = nodes["relief_um"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row.as_array().unwrap())
        .map(|x| x.as_f64().unwrap())
        .collect();
    assert!(relief.iter().any(|x| *x > 5.0));
    let plain = taken(&app, "/v1/gears/deviations", &json!({"gear": gear, "points": points})).await;
    let machined = json!({"gear": gear, "points": points, "modifications": modifications, "modification_range": range});
    let machined = taken(&app, "/v1/gears/deviations", &machined).await;
    for k in 0..9 {
        close(plain["deviation_um"][k].as_f64().unwrap(), -relief[k], 1e-8);
        assert!(machined["deviation_um"][k].as_f64().unwrap().abs() < 1e-8, "{}", machined["deviation_um"]);
    }
    // an instrument's topography counts from the involute
    let rows: Vec<Vec<f64>> = relief.chunks(3).map(|row| row.iter().map(|r| 1.5 - r).collect()).collect();
    let grid = json!({"gear": gear,
        "grid": {"flank": "left", "diameter_mm": [61.5, 63.0, 65.0], "z_mm": [1.0, 10.0, 19.0], "deviation_um": rows},
                      "modifications": modifications, "modification_range": range});
    let answer = taken(&app, "/v1/gears/deviations", &grid).await;
    for k in 0..9 {
        close(answer["deviation_um"][k].as_f64().unwrap(), 1.5, 1e-9);
    }
    app.stop().await;
}
