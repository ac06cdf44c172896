//! Intervals of gear figures and decisions by ISO 14253-1 over HTTP.

use serde_json::{Value, json};

use super::{pointers, taken};
use crate::{
    harness::{TestApp, send},
    shapes::examples,
};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn holds(figure: &Value) -> bool {
    let value = number(&figure["value"]);
    number(&figure["interval"][0]) < value && value < number(&figure["interval"][1])
}

#[tokio::test]
async fn figures_of_a_surface_have_intervals_and_conform() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    request.as_object_mut().unwrap().remove("tolerance_limits");
    let plain = taken(&app, "/v1/gears/flank-surface", &request).await;
    for name in ["profile_slope_um", "helix_slope_um", "profile_crowning_um", "helix_crowning_um", "twist_um"] {
        let figure = &plain[name];
        assert!(holds(figure) && figure["interval_kind"] == "student", "{name}: {figure}");
        assert!(figure.get("conformity").is_none());
    }
    let slope = number(&plain["profile_slope_um"]["value"]);
    request["tolerance_limits"] = json!({
        "class": 5, "profile_slope_um": [slope - 50.0, slope + 50.0], "twist_um": [900.0, 901.0]
    });
    let surface = taken(&app, "/v1/gears/flank-surface", &request).await;
    let slope = &surface["profile_slope_um"]["conformity"];
    assert_eq!(slope["verdict"], "conforms");
    assert!(number(&slope["probability"][0]) > 0.999);
    assert_eq!(surface["twist_um"]["conformity"]["verdict"], "does_not_conform");
    // f_HβT of class 5
    let helix = &surface["helix_slope_um"]["conformity"]["limits_um"];
    assert!(number(&helix[0]) == -number(&helix[1]) && number(&helix[1]) > 1.0);
    assert!(surface["helix_crowning_um"].get("conformity").is_none());
    // the level is that of the fit
    request["level"] = json!(0.99);
    let wider = taken(&app, "/v1/gears/flank-surface", &request).await;
    assert!(number(&wider["twist_um"]["interval"][1]) > number(&surface["twist_um"]["interval"][1]));
}

/// A limit above any figure is how a client writes that there is none on that side.
#[tokio::test]
async fn a_limit_may_have_one_side() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    for (limits, decision) in [([-1e308, 100.0], "conforms"), ([-1e308, -100.0], "does_not_conform")] {
        request["tolerance_limits"] = json!({"profile_slope_um": limits});
        let found = taken(&app, "/v1/gears/flank-surface", &request).await;
        let conformity = &found["profile_slope_um"]["conformity"];
        assert_eq!(conformity["verdict"], decision, "{conformity}");
        assert!((0.0..=1.0).contains(&number(&conformity["probability"][0])), "{conformity}");
    }
}

/// Limits closer than the uncertainty are none that a figure between them could be said to miss.
#[tokio::test]
async fn a_value_centred_in_narrow_limits_is_undecided() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    request.as_object_mut().unwrap().remove("tolerance_limits");
    let plain = taken(&app, "/v1/gears/flank-surface", &request).await;
    let twist = &plain["twist_um"];
    let (value, half) = (number(&twist["value"]), 0.001 * number(&twist["std_error"]));
    let decided = async |moved: f64| {
        let mut request = request.clone();
        request["tolerance_limits"] = json!({"twist_um": [value + moved - half, value + moved + half]});
        taken(&app, "/v1/gears/flank-surface", &request).await["twist_um"].clone()
    };
    let found = decided(0.0).await;
    assert_eq!(found["within"], true);
    assert!(number(&found["conformity"]["probability"][1]) < 0.01, "{found}");
    assert_eq!(found["conformity"]["verdict"], "undecidable");
    assert_eq!(decided(2e4 * half).await["conformity"]["verdict"], "does_not_conform");
}

/// If few nodes cover the range inside the border, nothing conforms.
#[tokio::test]
async fn an_uncovered_range_is_warned_of() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    let whole = taken(&app, "/v1/gears/flank-surface", &request).await;
    assert_eq!((&whole["warnings"], &whole["profile_slope_um"]["within"]), (&json!([]), &json!(true)));
    request["profile"] = json!([6, 7.5, 9, 10.5, 12]);
    request["border_percent"] = json!({"root": 5, "tip": 5, "toe": 0, "heel": 0});
    let cut = taken(&app, "/v1/gears/flank-surface", &request).await;
    let warning = &cut["warnings"][0];
    assert_eq!((&warning["code"], &warning["pointer"]), (&json!("range_not_covered"), &json!("/border_percent")));
    assert!((number(&warning["params"]["covered"]) - 3.0 / 5.4).abs() < 1e-9, "{warning}");
    for name in ["profile_slope_um", "profile_crowning_um"] {
        assert!(holds(&cut[name]), "{cut}");
        assert!(cut[name].get("conformity").is_none() && cut[name].get("within").is_none(), "{cut}");
    }
    // along z nothing is cut off
    assert_eq!(cut["helix_slope_um"]["conformity"]["verdict"], "conforms");
}

#[tokio::test]
async fn places_outside_the_face_are_refused_or_warned_of() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    request["z_mm"][4] = json!(1e30);
    assert_eq!(pointers(&app, "/v1/gears/flank-surface", &request).await, ["/z_mm/4"]);
    request["z_mm"][4] = json!(100);
    let warning = taken(&app, "/v1/gears/flank-surface", &request).await["warnings"][0].clone();
    assert_eq!((&warning["code"], &warning["pointer"]), (&json!("outside_face_width"), &json!("/z_mm")));
    assert_eq!(warning["message"], "the nodes span 99 mm in z, but the face is 15 mm wide: check the unit");
}

#[tokio::test]
async fn figures_of_traces_have_intervals_and_conform() {
    let app = TestApp::start().await;
    let mut request = examples("evaluate_gear")[0].1.clone();
    request["evaluation"]["tolerance_limits"] = json!({"class": 11, "helix_crowning_um": [-500, 500]});
    let found = taken(&app, "/v1/gears/evaluate", &request).await;
    assert_eq!(found["evaluation"]["level"], 0.95);
    assert_eq!(found["evaluation"]["tolerance_limits"]["class"], 11);
    let mut decided = 0;
    for trace in found["traces"].as_array().unwrap() {
        if let Some(interval) = trace.get("slope_interval_um") {
            let slope = number(&trace["slope_um"]);
            assert!(number(&interval[0]) < slope && slope < number(&interval[1]));
        }
        decided += usize::from(trace.get("slope_conformity").is_some_and(|c| c["verdict"] == "conforms"));
        // the greatest of many deviations has no interval
        assert!(trace.get("form_interval_um").is_none());
    }
    assert!(decided > 0, "{found}");
}

#[tokio::test]
async fn errors_in_limits_have_pointers() {
    let app = TestApp::start().await;
    let surface = async |limits: Value| {
        let mut request = examples("gear_flank_surface")[0].1.clone();
        request["tolerance_limits"] = limits;
        pointers(&app, "/v1/gears/flank-surface", &request).await
    };
    assert_eq!(surface(json!({"class": 0})).await, ["/tolerance_limits/class"]);
    assert_eq!(surface(json!({"twist_um": [2, 1]})).await, ["/tolerance_limits/twist_um"]);
    assert_eq!(surface(json!({"form_um": [0, 1]})).await, ["/tolerance_limits/form_um"]);
    assert_eq!(surface(json!({"twist_um": [2]})).await, ["/tolerance_limits/twist_um"]);
    // null counts as absent
    let mut request = examples("gear_flank_surface")[0].1.clone();
    request["tolerance_limits"] = Value::Null;
    let answer = taken(&app, "/v1/gears/flank-surface", &request).await;
    assert_eq!(answer["profile_slope_um"].get("conformity"), None);
    // of which a surface has no figure
    let of_traces = json!({"profile_form_um": [0, 1], "helix_total_um": [0, 1], "right": {"helix_form_um": [0, 1]}});
    let places = [
        "/tolerance_limits/profile_form_um",
        "/tolerance_limits/helix_total_um",
        "/tolerance_limits/right/helix_form_um",
    ];
    assert_eq!(surface(of_traces).await, places);
    let traces = async |name: &str, value: Value| {
        let mut request = examples("evaluate_gear")[0].1.clone();
        request["evaluation"][name] = value;
        pointers(&app, "/v1/gears/evaluate", &request).await
    };
    assert_eq!(traces("level", json!(0.3)).await, ["/evaluation/level"]);
    let limits = json!({"profile_crowning_um": [3, 3]});
    assert_eq!(traces("tolerance_limits", limits).await, ["/evaluation/tolerance_limits/profile_crowning_um"]);
    assert_eq!(traces("tolerance_limits", json!({"class": 12})).await, ["/evaluation/tolerance_limits/class"]);
}

#[tokio::test]
async fn records_keep_intervals_and_decisions() {
    let app = TestApp::start().await;
    let mut record = examples("create_iteration_evaluation")[0].1.clone();
    let gear = examples("evaluate_gear")[0].1["gear"].clone();
    let job = send(app.post("/v1/jobs", json!({"name": "w", "gear": gear}).to_string())).await.json();
    let place = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let nodes = json!({"nodes": {"type": "curve", "x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 1.0, 1.9, 3.2]},
        "model": {"type": "polynomial", "degree": 1}});
    assert_eq!(send(app.post(&place, nodes.to_string())).await.status, 201);
    record["evaluation"]["tolerance_limits"] = json!({"profile_slope_um": [-500, 500], "helix_slope_um": [-500, 500]});
    let kept = send(app.post(&format!("{place}/1/evaluations"), record.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    assert!(kept.text.contains("\"conforms\"") && kept.text.contains("slope_interval_um"), "{}", kept.text);
    assert_eq!(send(app.get(kept.header("location"))).await.text, kept.text);
}

/// A tip relief in the nodes that a surface of second order cannot follow.
#[tokio::test]
async fn a_verdict_reports_violated_assumptions() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    let profile: Vec<f64> = (0..11).map(|i| 6.0 + 0.6 * f64::from(i)).collect();
    let z: Vec<f64> = (0..9).map(|j| 1.0 + 1.6 * f64::from(j)).collect();
    (request["profile"], request["z_mm"]) = (json!(profile), json!(z));
    request["tolerance_limits"] = json!({"profile_slope_um": [-60.0, 60.0]});
    request["border_percent"] = json!({"root": 0, "tip": 0, "toe": 0, "heel": 0});
    let mut conformity = async |relief: f64| {
        let height = |i: usize, j: usize| {
            let noise = 0.4 * f64::sin(12.9898 * i as f64 + 78.233 * j as f64 + 3.0 * (i * j) as f64);
            noise - relief * f64::max(0.0, (i as f64 - 7.0) / 3.0).powi(2)
        };
        let rows = (0..11).map(|i| (0..9).map(|j| height(i, j)).collect::<Vec<f64>>());
        request["deviation_um"] = json!(rows.collect::<Vec<_>>());
        let found = taken(&app, "/v1/gears/flank-surface", &request).await;
        (found["profile_slope_um"]["conformity"].clone(), found["warnings"].clone())
    };
    let (clean, _) = conformity(0.0).await;
    assert_eq!((&clean["assumptions"], &clean["reasons"]), (&json!("ok"), &json!([])), "{clean}");
    let (relieved, warnings) = conformity(12.0).await;
    assert_eq!((&relieved["verdict"], &relieved["assumptions"]), (&json!("conforms"), &json!("doubtful")));
    let reasons = relieved["reasons"].as_array().unwrap();
    assert!(reasons.contains(&json!("lack_of_fit")), "{relieved}");
    let codes: Vec<&Value> = warnings.as_array().unwrap().iter().map(|warning| &warning["code"]).collect();
    assert!(reasons.iter().all(|reason| codes.contains(&reason)), "{reasons:?} {codes:?}");
}
