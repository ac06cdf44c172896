//! Targets of corrections, the settings that are changed, and the CSV for the control.

use reqwest::Method;
use serde_json::{Value, json};

use super::{pointers, spur};
use crate::{
    harness::{Answer, TestApp, send},
    shapes::close,
};

const ROWS: usize = 7;
const COLUMNS: usize = 9;

/// Roll lengths and z of the nodes.
fn axes() -> (Vec<f64>, Vec<f64>) {
    ((0..ROWS).map(|i| 6.0 + i as f64).collect(), (0..COLUMNS).map(|j| 0.5 + 1.75 * j as f64).collect())
}

/// Returns a left flank with these slopes and crownings, µm, and some roughness.
fn flank([profile, helix, profile_crowning, helix_crowning]: [f64; 4]) -> Value {
    let (rolls, z) = axes();
    let value = |i: usize, j: usize| {
        let (u, v) = ((i as f64 - 3.0) / 3.0, (j as f64 - 4.0) / 4.0);
        let rough = 0.25 * (7.3 * i as f64 + 3.1 * (j * j) as f64).sin();
        0.5 * (profile * u + helix * v) - profile_crowning * u * u - helix_crowning * v * v + rough + 5.0
    };
    let rows: Vec<Vec<f64>> = (0..ROWS).map(|i| (0..COLUMNS).map(|j| value(i, j)).collect()).collect();
    json!({"nodes": {"type": "grid", "u": rolls, "v": z, "z": rows}, "flank": "left",
        "model": {"type": "polynomial", "degree": 2, "terms": "total"},
        "axes": {"u": {"quantity": "roll_length", "unit": "mm"}, "v": {"quantity": "face_width", "unit": "mm"},
            "z": {"quantity": "deviation", "unit": "um"}}})
}

/// Creates a job with these requirements and one measured flank; returns the path of its
/// correction.
async fn measured(app: &TestApp, requirements: &Value, figures: [f64; 4]) -> String {
    let mut job = json!({"name": "w", "part_number": "97340", "serial_number": "0017", "gear": spur()});
    if !requirements.is_null() {
        job["requirements"] = requirements.clone();
    }
    let made = send(app.post("/v1/jobs", job.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let place = format!("/v1/jobs/{}/iterations", made.json()["id"].as_str().unwrap());
    let made = send(app.post(&place, flank(figures).to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    format!("{place}/1/correction")
}

async fn correct(app: &TestApp, path: &str, more: Value) -> Value {
    let mut request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}});
    request.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    let made = send(app.post(path, request.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made.json()["result"].take()
}

fn setting<'a>(correction: &'a Value, name: &str) -> &'a Value {
    correction["settings"].as_array().unwrap().iter().find(|setting| setting["name"] == name).unwrap()
}

fn figure<'a>(correction: &'a Value, name: &str) -> &'a Value {
    &correction["figures"]["left"][name]
}

fn warned(correction: &Value, code: &str) -> bool {
    correction["warnings"].as_array().unwrap().iter().any(|warning| warning["code"] == code)
}

fn limits() -> Value {
    json!({"tolerance_limits": {"profile_slope_um": [-4, 4], "helix_slope_um": [-4, 4],
        "profile_crowning_um": [2, 6], "helix_crowning_um": [4, 9]}})
}

/// A crowning of 3.7 µm within 2…6 µm conforms to the drawing and stays; the angles are corrected.
#[tokio::test]
async fn figures_within_their_limits_stay() {
    let app = TestApp::start().await;
    let path = measured(&app, &limits(), [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({})).await;
    assert_eq!((&made["target"], &made["settings_used"]), (&json!({"kind": "limits"}), &json!("needed")));
    assert_eq!(made["keep_within"], 0.7);
    for (name, figure_name, value) in
        [("profile_crowning", "profile_crowning_um", 3.7), ("helix_crowning", "helix_crowning_um", 5.5)]
    {
        let of = setting(&made, name);
        assert_eq!((&of["change"], of.get("std_error")), (&json!(0.0), None), "{of}");
        assert!(["within_limits", "not_distinguishable"].contains(&of["unchanged"].as_str().unwrap()), "{of}");
        let of = figure(&made, figure_name);
        close(of["predicted"].as_f64().unwrap(), value, 0.3);
        assert_eq!(
            (&of["conformity_before"]["verdict"], &of["conformity_predicted"]["verdict"]),
            (&json!("conforms"), &json!("conforms"))
        );
    }
    close(figure(&made, "profile_crowning_um")["target"].as_f64().unwrap(), 4.0, 1e-9);
    for (name, figure_name) in [("profile_angle", "profile_slope_um"), ("helix_angle", "helix_slope_um")] {
        assert!(
            setting(&made, name)["change"].as_f64().unwrap() != 0.0 && setting(&made, name).get("unchanged").is_none()
        );
        let of = figure(&made, figure_name);
        assert_eq!(of["conformity_before"]["verdict"], "does_not_conform", "{of}");
        assert_eq!(of["conformity_predicted"]["verdict"], "conforms", "{of}");
        assert!(of["std_error"].as_f64().unwrap() > 0.0 && of["predicted"].as_f64().unwrap().abs() < 0.5, "{of}");
    }
    assert!(!warned(&made, "predicted_outside_limits") && !warned(&made, "target_removes_crowning"));
    // the same in the stored correction, with its values at the nodes
    let kept = send(app.get(&format!("{path}?include=nodes"))).await.json();
    assert_eq!(kept["result"]["figures"], made["figures"]);
    let nodes = ROWS * COLUMNS;
    let list = |of: &Value| of["deviation_um"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let [wanted, predicted]: [Vec<f64>; 2] = [list(&kept["result"]["target"]), list(&kept["result"]["predicted"])];
    assert_eq!(wanted.len(), nodes);
    // distance from the target, minus its mean if there is no datum
    assert_eq!(made["absolute"], false);
    let left: Vec<f64> = predicted.iter().zip(&wanted).map(|(p, t)| p - t).collect();
    let mean = left.iter().sum::<f64>() / nodes as f64;
    let square: f64 = left.iter().map(|x| (x - mean).powi(2)).sum();
    close((square / nodes as f64).sqrt(), kept["result"]["predicted"]["rms_um"].as_f64().unwrap(), 1e-9);
    // with all settings, the middle of the limits is reached
    let all = correct(&app, &path, json!({"settings_used": "all"})).await;
    assert!(all.get("keep_within").is_none() && setting(&all, "helix_crowning").get("unchanged").is_none());
    close(figure(&all, "helix_crowning_um")["predicted"].as_f64().unwrap(), 6.5, 0.1);
    // a narrower share of the limits is one more reason to correct
    let strict = correct(&app, &path, json!({"keep_within": 0.05})).await;
    assert!(setting(&strict, "helix_crowning")["change"].as_f64().unwrap() > 0.5, "{strict}");
    app.stop().await;
}

/// A class bounds slopes about 0; a crowning that has no limits is left as measured.
#[tokio::test]
async fn slopes_of_a_class_are_aimed_at_zero() {
    let app = TestApp::start().await;
    let required = json!({"tolerance_limits": {"class": 5, "profile_crowning_um": [2, 6]}});
    let path = measured(&app, &required, [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({"settings_used": "all"})).await;
    assert_eq!(made["target"], json!({"kind": "limits"}));
    for (name, target) in [("profile_slope_um", 0.0), ("helix_slope_um", 0.0), ("profile_crowning_um", 4.0)] {
        close(figure(&made, name)["target"].as_f64().unwrap(), target, 1e-9);
    }
    let left = figure(&made, "helix_crowning_um");
    assert_eq!((&left["target"], left.get("limits_um")), (&left["before"], None), "{left}");
    app.stop().await;
}

/// The next measurement is compared with the prediction, whatever the job requires by then.
#[tokio::test]
async fn a_kept_target_does_not_change_with_the_job() {
    let app = TestApp::start().await;
    let path = measured(&app, &limits(), [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({})).await;
    let after = |name: &str| figure(&made, name)["predicted"].as_f64().unwrap();
    let next = ["profile_slope_um", "helix_slope_um", "profile_crowning_um", "helix_crowning_um"].map(after);
    let place = path.strip_suffix("/1/correction").unwrap();
    assert_eq!(send(app.post(place, flank(next).to_string())).await.status, 201);
    let compared = async || send(app.get(&path)).await.json()["answer"].clone();
    let before = compared().await;
    assert_eq!(before["verdict"], "as_predicted", "{before}");
    let job = place.strip_suffix("/iterations").unwrap();
    let requirements = json!({"requirements": {"design": {"profile_crowning_um": 20}}});
    let patched = send(app.client.request(Method::PATCH, app.url(job)).json(&requirements)).await;
    assert_eq!(patched.status, 200, "{}", patched.text);
    assert_eq!(compared().await, before);
    app.stop().await;
}

/// The design of a job is the default target; its own range and reliefs are taken into account.
#[tokio::test]
async fn a_design_is_the_target_of_its_job() {
    let app = TestApp::start().await;
    let design = json!({"design": {"profile_crowning_um": 4, "helix_slope_um": 2, "left": {"helix_crowning_um": 6},
        "right": {"helix_crowning_um": 3}}});
    let path = measured(&app, &design, [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({"include": ["nodes"]})).await;
    assert_eq!((&made["target"]["kind"], &made["settings_used"]), (&json!("design"), &json!("all")));
    for (name, value) in [("profile_crowning_um", 4.0), ("helix_slope_um", 2.0), ("helix_crowning_um", 6.0)] {
        close(figure(&made, name)["target"].as_f64().unwrap(), value, 1e-9);
        close(figure(&made, name)["predicted"].as_f64().unwrap(), value, 0.3);
        assert!(figure(&made, name).get("limits").is_none());
    }
    close(figure(&made, "profile_slope_um")["target"].as_f64().unwrap(), 0.0, 1e-9);
    // −C u² of the profile and −C v² of the helix add up at a corner; the nodes cover 14 of the 15
    // mm of face width that the slope refers to
    let wanted = made["target"]["deviation_um"].as_array().unwrap();
    close(wanted[0].as_f64().unwrap(), -4.0 - 6.0 - 14.0 / 15.0, 1e-9);
    // a slope with its own range is not converted, and its figure refers to the face width
    let own = json!({"design": {"helix_slope_um": 2, "helix_range_mm": [0.5, 14.5]}});
    let path = measured(&app, &own, [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({"include": ["nodes"]})).await;
    close(made["target"]["deviation_um"][0].as_f64().unwrap(), -1.0, 1e-9);
    close(figure(&made, "helix_slope_um")["target"].as_f64().unwrap(), 2.0 * 15.0 / 14.0, 1e-9);
    // a design together with limits, and either one as the target
    let both = json!({"design": {"profile_crowning_um": 4}, "tolerance_limits": {"profile_crowning_um": [2, 8]}});
    let path = measured(&app, &both, [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({})).await;
    assert_eq!((&made["target"]["kind"], &made["settings_used"]), (&json!("design"), &json!("needed")));
    let made = correct(&app, &path, json!({"target": "limits"})).await;
    close(figure(&made, "profile_crowning_um")["target"].as_f64().unwrap(), 5.0, 1e-9);
    // over half of its range a crowning has a quarter of its amount
    let (rolls, _) = axes();
    let base = 26.0 * 20f64.to_radians().cos();
    let diameter = |roll: f64| 2.0 * base.hypot(roll);
    let (low, high) = (rolls[0] - 3.0, rolls[ROWS - 1] + 3.0);
    let wide = json!({"design": {"profile_crowning_um": 4, "profile_diameter_range_mm": [diameter(low), diameter(high)],
        "modifications": [{"type": "end_relief", "end": "II", "amount_um": 5, "length_mm": 3}]}});
    let path = measured(&app, &wide, [0.0, 0.0, 1.0, 0.0]).await;
    let made = correct(&app, &path, json!({"include": ["nodes"]})).await;
    close(figure(&made, "profile_crowning_um")["target"].as_f64().unwrap(), 1.0, 1e-6);
    let wanted = made["target"]["deviation_um"].as_array().unwrap();
    let middle = 3 * COLUMNS;
    close(wanted[middle + COLUMNS - 1].as_f64().unwrap(), -5.0, 1e-6);
    close(wanted[middle].as_f64().unwrap(), 0.0, 1e-6);
    app.stop().await;
}

/// Without a design and limits the target is the unmodified flank, with a warning.
#[tokio::test]
async fn a_crowning_without_target_is_not_removed_silently() {
    let app = TestApp::start().await;
    let path = measured(&app, &Value::Null, [7.0, -9.0, 3.7, 5.5]).await;
    let made = correct(&app, &path, json!({})).await;
    assert_eq!((&made["target"], &made["settings_used"]), (&json!({"kind": "nominal"}), &json!("all")));
    let warnings = made["warnings"].as_array().unwrap();
    let warning = warnings.iter().find(|warning| warning["code"] == "target_removes_crowning").unwrap();
    assert_eq!(warning["params"]["figures"], json!(["profile_crowning_um", "helix_crowning_um"]), "{warning}");
    close(figure(&made, "profile_crowning_um")["predicted"].as_f64().unwrap(), 0.0, 0.2);
    let said = correct(&app, &path, json!({"target": "nominal"})).await;
    assert!(!warned(&said, "target_removes_crowning"));
    let needed = correct(&app, &path, json!({"settings_used": "needed", "target": "nominal"})).await;
    let left: Vec<&Value> =
        needed["settings"].as_array().unwrap().iter().filter(|s| s.get("unchanged").is_some()).collect();
    assert!(left.iter().all(|setting| setting["unchanged"] == "not_distinguishable"), "{left:?}");
    // target given node by node, equal to the flank: no change
    let (_, z) = axes();
    let own: Vec<f64> = flank([7.0, -9.0, 3.7, 5.5])["nodes"]["z"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<f64>>())
        .collect();
    assert_eq!(own.len(), ROWS * z.len());
    let still = correct(&app, &path, json!({"target": {"deviation_um": own}, "noise_sigma_um": 0.2})).await;
    assert_eq!(still["target"], json!({"kind": "given"}));
    assert!(still["settings"].as_array().unwrap().iter().all(|s| s["change"].as_f64().unwrap().abs() < 1e-9));
    let refused = async |body: Value| {
        let mut request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}});
        request.as_object_mut().unwrap().extend(body.as_object().unwrap().clone());
        pointers(&app, &path, &request).await
    };
    for (body, pointer) in [
        (json!({"target": "design"}), "/target"),
        (json!({"target": "limits"}), "/target"),
        (json!({"target": "zero"}), "/target"),
        (json!({"target": {"deviation_um": [1.0]}}), "/target/deviation_um"),
        (json!({"target": {"deviation_um": [1.0], "node": 1}}), "/target/node"),
        (json!({"target_um": [1.0]}), "/target_um"),
        (json!({"settings_used": "some"}), "/settings_used"),
        (json!({"settings_used": "all", "keep_within": 0.5}), "/keep_within"),
        (json!({"settings_used": "needed", "keep_within": 1.5}), "/keep_within"),
    ] {
        assert_eq!(refused(body.clone()).await, [pointer], "{body}");
    }
    let matrix = vec![[1.0]; ROWS * COLUMNS];
    let matrix = json!({"sensitivity": {"type": "matrix", "settings": ["a"], "matrix": matrix}, "target": "limits"});
    assert_eq!(pointers(&app, &path, &matrix).await, ["/target"]);
    app.stop().await;
}

#[tokio::test]
async fn a_design_that_is_none_is_refused() {
    let app = TestApp::start().await;
    let refused = async |design: Value| {
        let job = json!({"name": "w", "gear": spur(), "requirements": {"design": design}});
        pointers(&app, "/v1/jobs", &job).await
    };
    for (design, pointer) in [
        (json!({"profile_crowning_um": 5000}), "/requirements/design/profile_crowning_um"),
        (json!({"left": {"twist_um": -5000}}), "/requirements/design/left/twist_um"),
        (json!({"crowning": 5}), "/requirements/design/crowning"),
        (json!({"helix_range_mm": [3, 3]}), "/requirements/design/helix_range_mm"),
        (json!({"profile_diameter_range_mm": [10, 53]}), "/requirements/design/profile_diameter_range_mm"),
        (
            json!({"modifications": [{"type": "tip_relief", "amount_um": 5, "start_diameter_mm": 90}]}),
            "/requirements/design/modifications/0/start_diameter_mm",
        ),
    ] {
        assert_eq!(refused(design.clone()).await, [pointer], "{design}");
    }
    let design = json!({"profile_crowning_um": 4.0, "modifications": [{"type": "twist", "amount_um": 2.0}]});
    let job = json!({"name": "w", "gear": spur(), "requirements": {"design": design}});
    let made = send(app.post("/v1/jobs", job.to_string())).await;
    assert_eq!((made.status.as_u16(), &made.json()["requirements"]["design"]), (201, &design), "{}", made.text);
    app.stop().await;
}

/// The CSV for the control has rounded changes, their sense in words and the part they are for; it
/// is refused if figures would lie outside their limits.
#[tokio::test]
async fn the_control_gets_words_and_no_figure_outside_its_limits() {
    let app = TestApp::start().await;
    let csv = async |path: &str| -> Answer { send(app.get(path).header("accept", "text/csv")).await };
    let path = measured(&app, &limits(), [7.0, -9.0, 3.7, 5.5]).await;
    correct(&app, &path, json!({"limits": {"helix_angle": {"increment": 0.1}}})).await;
    let text = csv(&path).await;
    assert_eq!(text.status, 200, "{}", text.text);
    let job = path.split('/').nth(3).unwrap();
    let lines: Vec<&str> = text.text.lines().collect();
    assert!(lines[0].ends_with("Description,ProgramName,Flank,Job,Iterations,PartNumber,SerialNumber,Date"));
    let line = |name: &str| *lines.iter().find(|line| line.starts_with(name)).unwrap();
    let about = format!("the left flank,{job},1,97340,0017,");
    assert!(lines[1..].iter().all(|line| line.contains(&about)), "{}", text.text);
    assert!(line("helix_angle").contains("′: towards the right hand"), "{}", line("helix_angle"));
    assert!(line("profile_crowning").contains("profile crowning: leave ("), "{}", line("profile_crowning"));
    for line in &lines[1..] {
        let change = line.split(',').nth(2).unwrap();
        assert!(change.len() <= 8, "{change}");
    }
    // stopped at its limit, one figure stays out
    let stopped = correct(&app, &path, json!({"limits": {"helix_angle": {"min": -1, "max": 1}}})).await;
    let warnings = stopped["warnings"].as_array().unwrap();
    let warning = warnings.iter().find(|warning| warning["code"] == "predicted_outside_limits").unwrap();
    assert_eq!(warning["params"]["figures"], json!(["helix_slope_um"]), "{warning}");
    assert!(warning["message"].as_str().unwrap().contains("`helix_angle` at its limit"), "{warning}");
    csv(&path).await.problem(409, "predicted_outside_limits");
    assert_eq!(csv(&format!("{path}?outside_limits=allowed")).await.status, 200);
    let refused = csv(&format!("{path}?outside_limits=yes")).await.problem(422, "invalid_request");
    assert_eq!(refused["errors"][0]["pointer"], "/outside_limits", "{refused}");
    // and with a target that lies outside the limits itself
    let nominal = correct(&app, &path, json!({"target": "nominal", "settings_used": "all"})).await;
    let message = nominal["warnings"].to_string();
    assert!(message.contains("the target has 0.0 µm"), "{message}");
    csv(&path).await.problem(409, "predicted_outside_limits");
    app.stop().await;
}
