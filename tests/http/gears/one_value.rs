//! A figure has one value: that of the chosen fit, on the page of its iteration and in corrections.

use serde_json::{Value, json};

use super::{
    fit_figures::{axes, get, job, posted},
    spur,
};
use crate::harness::{TestApp, send};

const NAMES: [&str; 5] = ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"];
const U: [f64; 5] = [6.0, 7.5, 9.0, 10.5, 12.0];
const V: [f64; 6] = [1.0, 3.6, 6.2, 8.8, 11.4, 14.0];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// A flank with form of its own; `ridge` shrinks the coefficients of its fit.
fn iteration(tooth: &str, share: f64, turn: f64, ridge: bool) -> Value {
    let height = |u: f64, v: f64| {
        let (x, y) = ((u - 9.0) / 3.0, (v - 7.5) / 6.5);
        share * (6.0 * x - 4.0 * y - 3.0 * x * x) - 2.0 * y * y + x * y + 0.3 * (17.0 * x + 29.0 * y + turn).sin()
    };
    let z: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| height(*u, *v)).collect()).collect();
    let regularization = match ridge {
        true => json!({"type": "ridge", "parameter": {"criterion": "fixed", "value": 0.1}}),
        false => json!({"type": "none"}),
    };
    json!({"nodes": {"type": "grid", "u": U, "v": V, "z": z}, "flank": "left", "tooth": tooth, "axes": axes(),
           "model": {"type": "polynomial", "degree": 2, "basis": "legendre", "terms": "total"},
           "regularization": regularization})
}

fn limits() -> Value {
    json!({"tolerance_limits": {"profile_slope_um": [-3, 3], "profile_crowning_um": [0, 5], "helix_slope_um": [-9, 9]}})
}

fn asked() -> Value {
    json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.3,
           "settings_used": "all",
           "target": "nominal"})
}

/// The figures of an iteration on its page.
async fn page(app: &TestApp, job: &str, number: u32) -> Value {
    get(app, &format!("{job}/iterations/{number}")).await["fits"][0]["figures"].clone()
}

/// The correction and the comparison show the figures of the page, with their errors and decisions,
/// and the fit differs from least squares. The predicted change is that of the nodes.
#[tokio::test]
async fn a_correction_has_the_figures_of_the_chosen_fit() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": spur(), "requirements": limits()})).await;
    posted(&app, &format!("{place}/iterations"), &iteration("1", 1.0, 0.0, true)).await;
    let made = posted(&app, &format!("{place}/iterations/1/correction"), &asked()).await.json()["result"].clone();
    let plain = job(&app, json!({"name": "w", "gear": spur(), "requirements": limits()})).await;
    posted(&app, &format!("{plain}/iterations"), &iteration("1", 1.0, 0.0, false)).await;
    let linear = posted(&app, &format!("{plain}/iterations/1/correction"), &asked()).await.json()["result"].clone();

    let shown = page(&app, &place, 1).await;
    assert_eq!(made["predicted"].get("figures"), None);
    for name in NAMES.map(|name| format!("{name}_um")) {
        let (figure, of_page) = (&made["figures"]["left"][&name], &shown[&name]);
        assert_eq!(figure["before"], of_page["value"], "{name}");
        assert_eq!(figure["std_error"], of_page["std_error"], "{name}");
        for part in ["limits_um", "verdict", "assumptions", "reasons"] {
            assert_eq!(figure["conformity_before"][part], of_page["conformity"][part], "{name}: {part}");
        }
        let change = |figure: &Value| number(&figure["predicted"]) - number(&figure["before"]);
        assert!((change(figure) - change(&linear["figures"]["left"][&name])).abs() < 1e-9, "{name}: {figure}");
    }
    let slope = |made: &Value| number(&made["figures"]["left"]["profile_slope_um"]["before"]);
    // 2 · 6 µm, and less with ridge
    assert!((slope(&linear) - 12.0).abs() < 0.3 && slope(&made) < slope(&linear) - 0.2, "{made}");

    // the next measurement too, and what changed is the difference of both
    posted(&app, &format!("{place}/iterations"), &iteration("1", 0.2, 2.0, true)).await;
    let after = page(&app, &place, 2).await;
    let kept = get(&app, &format!("{place}/iterations/1/correction")).await;
    assert_eq!(kept["answer"].get("figures"), None);
    for name in NAMES {
        let own = format!("{name}_um");
        let changes = &kept["answer"]["figure_changes"][&own];
        for (part, page) in [("before", &shown[&own]), ("measured", &after[&own])] {
            assert_eq!(changes[part]["value_um"], page["value"], "{name} {part}");
            assert_eq!(changes[part]["interval_um"], page["interval"], "{name} {part}");
        }
        let [before, measured, change] =
            ["before", "measured", "change"].map(|part| number(&changes[part]["value_um"]));
        assert!((change - (measured - before)).abs() < 1e-9, "{name}: {changes}");
        assert!((number(&changes["predicted_um"]) - number(&made["figures"]["left"][&own]["predicted"])).abs() < 1e-9);
    }

    // weights of the request are not those of the fit: least squares over the nodes then
    let mut weighted = asked();
    weighted["weight"] = json!(vec![1.0; 30]);
    let weighted = posted(&app, &format!("{place}/iterations/1/correction"), &weighted).await.json()["result"].clone();
    assert!((slope(&weighted) - slope(&linear)).abs() < 1e-9, "{weighted}");
    app.stop().await;
}

/// For a gear it is the mean over the fits of the teeth.
#[tokio::test]
async fn a_correction_of_the_gear_has_the_mean_of_the_fits() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": spur(), "requirements": limits()})).await;
    for (tooth, share) in [("1", 1.0), ("27", 0.8)] {
        posted(&app, &format!("{place}/iterations"), &iteration(tooth, share, share, true)).await;
    }
    let made = posted(&app, &format!("{place}/correction"), &asked()).await.json()["result"].clone();
    posted(&app, &format!("{place}/iterations"), &iteration("1", 0.1, 3.0, true)).await;
    let kept = get(&app, &format!("{place}/correction")).await;
    let [one, two, three] = [1, 2, 3].map(|number| page(&app, &place, number));
    let [one, two, three] = [one.await, two.await, three.await];
    for name in NAMES {
        let own = format!("{name}_um");
        let mean = 0.5 * (number(&one[&own]["value"]) + number(&two[&own]["value"]));
        assert!((number(&made["figures"]["left"][&own]["before"]) - mean).abs() < 1e-9, "{name}");
        let changes = &kept["answer"]["flanks"]["left"][&own];
        assert!((number(&changes["before"]["value_um"]) - mean).abs() < 1e-9, "{name}: {changes}");
        assert_eq!(changes["measured"]["value_um"], three[&own]["value"], "{name}");
        // errors of two teeth and of one, not of the difference of both
        let error = number(&made["figures"]["left"][&own]["std_error"]);
        assert!((number(&changes["before"]["std_error_um"]) - error).abs() < 1e-9, "{name}: {changes}");
        assert_eq!(changes["measured"]["std_error_um"], three[&own]["std_error"], "{name}: {changes}");
    }
    app.stop().await;
}

/// Measurements are compared by least squares if a fit has a prior, which may hold the
/// prediction that is tested.
#[tokio::test]
async fn a_prior_does_not_answer_for_the_machine() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": spur()})).await;
    posted(&app, &format!("{place}/iterations"), &iteration("1", 1.0, 0.0, false)).await;
    posted(&app, &format!("{place}/iterations/1/correction"), &asked()).await;
    let mut next = iteration("1", 0.2, 2.0, false);
    next["prior"] = json!({"mean": [0, 0, 0, 0, 0, 0], "std_error": [1, 1, 1, 1, 1, 1]});
    posted(&app, &format!("{place}/iterations"), &next).await;
    let shown = page(&app, &place, 2).await;
    let changes = get(&app, &format!("{place}/iterations/1/correction")).await["answer"]["figure_changes"].clone();

    let plain = job(&app, json!({"name": "w", "gear": spur()})).await;
    posted(&app, &format!("{plain}/iterations"), &iteration("1", 0.2, 2.0, false)).await;
    let least_squares = page(&app, &plain, 1).await;
    for name in NAMES {
        let own = format!("{name}_um");
        let [measured, by_prior, by_nodes] =
            [&changes[&own]["measured"]["value_um"], &shown[&own]["value"], &least_squares[&own]["value"]].map(number);
        assert!((measured - by_nodes).abs() < 1e-9, "{name}: {measured} {by_nodes}");
        assert!((by_prior - by_nodes).abs() > 1e-6, "{name}: {by_prior}");
    }
    app.stop().await;
}

/// u in millimetres of roll length and of diameter and in degrees of roll.
#[tokio::test]
async fn figures_are_the_same_over_diameters_and_roll_lengths() {
    let app = TestApp::start().await;
    let base = 26.0 * 20f64.to_radians().cos();
    let mut found = Vec::new();
    for (quantity, unit, of) in [
        ("roll_length", "mm", (|roll: f64, _: f64| roll) as fn(f64, f64) -> f64),
        ("diameter", "mm", |roll, base| 2.0 * roll.hypot(base)),
        ("diameter", "in", |roll, base| 2.0 * roll.hypot(base) / 25.4),
        ("roll_length", "deg", |roll, base| (roll / base).to_degrees()),
    ] {
        let place = job(&app, json!({"name": "w", "gear": spur(), "requirements": limits()})).await;
        let mut body = iteration("1", 1.0, 0.0, true);
        body["nodes"]["u"] = json!(U.map(|roll| of(roll, base)));
        body["axes"]["u"] = json!({"quantity": quantity, "unit": unit});
        let made = posted(&app, &format!("{place}/iterations"), &body).await.json();
        found.push(made["fits"][0]["figures"].clone());
        // the fit itself is of the axes that it was posted with
        let replay = made["fits"][0]["id"].as_str().unwrap();
        let replay = send(app.post(&format!("{place}/iterations/1/fits/{replay}/replay"), "{}")).await;
        assert_eq!(replay.json(), json!({"identical": true}));
    }
    for other in &found[1..] {
        for name in NAMES.map(|name| format!("{name}_um")) {
            for part in ["value", "std_error", "least_squares"] {
                let [a, b] = [other, &found[0]].map(|figures| number(&figures[&name][part]));
                assert!((a - b).abs() < 1e-6, "{name} {part}: {a} {b}");
            }
            let conformity = |figures: &Value| figures[&name]["conformity"]["verdict"].clone();
            assert_eq!(conformity(other), conformity(&found[0]), "{name}");
        }
        assert_eq!(other["warnings"], json!([]));
    }
    app.stop().await;
}

/// Nodes that cover a part of the ranges that the drawing gives: no crowning conforms by them, and
/// a helix slope by its extended interval only.
#[tokio::test]
async fn ranges_that_are_not_covered_are_named() {
    let app = TestApp::start().await;
    let diameter = |roll: f64| 2.0 * roll.hypot(26.0 * 20f64.to_radians().cos());
    let mut requirements = limits();
    requirements["tolerance_limits"]["helix_crowning_um"] = json!([-9, 9]);
    requirements["design"] = json!({"profile_diameter_range_mm": [diameter(6.0), diameter(12.0)],
                                    "helix_range_mm": [1.0, 14.0]});
    let place = job(&app, json!({"name": "w", "gear": spur(), "requirements": requirements})).await;
    let whole = posted(&app, &format!("{place}/iterations"), &iteration("1", 0.4, 0.0, false)).await.json();
    assert_eq!(whole["fits"][0]["figures"]["warnings"], json!([]));
    let mut part = iteration("2", 0.4, 0.0, false);
    // roll lengths 6 to 9 of 6 to 12 mm, z from 1 to 6.2 of 15 mm
    part["nodes"]["u"] = json!(&U[..3]);
    part["nodes"]["v"] = json!(&V[..3]);
    let rows: Vec<Value> = part["nodes"]["z"].as_array().unwrap()[..3].to_vec();
    part["nodes"]["z"] = rows.iter().map(|row| json!(row.as_array().unwrap()[..3])).collect();
    let made = posted(&app, &format!("{place}/iterations"), &part).await.json();
    let figures = &made["fits"][0]["figures"];
    let warned: Vec<(&Value, &Value, &Value)> = figures["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|one| one["code"] == "range_not_covered")
        .map(|one| (&one["params"]["figures"], &one["params"]["reached_mm"], &one["params"]["range_mm"]))
        .collect();
    let near = |found: &Value, want: [f64; 2]| {
        assert!((0..2).all(|end| (number(&found[end]) - want[end]).abs() < 1e-9), "{found}");
    };
    let [profile, helix, slope] = warned[..] else { panic!("{figures}") };
    assert_eq!(profile.0, &json!(["profile_slope_um", "profile_crowning_um"]));
    near(profile.1, [6.0, 9.0]);
    near(profile.2, [6.0, 12.0]);
    assert_eq!(helix, (&json!(["helix_crowning_um"]), &json!([1.0, 6.2]), &json!([1.0, 14.0])));
    assert_eq!(slope, (&json!(["helix_slope_um"]), &json!([1.0, 6.2]), &json!([0.0, 15.0])));
    for name in ["profile_slope_um", "profile_crowning_um", "helix_crowning_um"] {
        assert!(figures[name]["value"].is_f64(), "{figures}");
        assert!(figures[name].get("within").is_none() && figures[name].get("conformity").is_none(), "{figures}");
    }
    // 15 / 5.2 times the interval over the nodes
    let extended = &figures["helix_slope_um"];
    assert!(extended["conformity"]["verdict"].is_string(), "{figures}");
    let [low, high] = [0, 1].map(|end| number(&extended["interval"][end]));
    assert!(high - low > 15.0 / 5.2 * 0.3, "{extended}");

    // the correction decides as the page does, and says why
    let made = posted(&app, &format!("{place}/iterations/2/correction"), &asked()).await.json()["result"].clone();
    let codes: Vec<&Value> = made["warnings"].as_array().unwrap().iter().map(|one| &one["code"]).collect();
    assert_eq!(codes.iter().filter(|code| **code == "range_not_covered").count(), 3, "{}", made["warnings"]);
    let crowning = &made["figures"]["left"]["profile_crowning_um"];
    assert!(crowning.get("conformity_before").is_none() && crowning.get("limits").is_none(), "{crowning}");
    app.stop().await;
}

/// A measurement in a wrong unit is no answer of the machine.
#[tokio::test]
async fn implausible_measurements_are_not_compared() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": spur()})).await;
    posted(&app, &format!("{place}/iterations"), &iteration("1", 1.0, 0.0, false)).await;
    posted(&app, &format!("{place}/iterations/1/correction"), &asked()).await;
    posted(&app, &format!("{place}/correction"), &asked()).await;
    let mut inches = iteration("1", 0.2, 1.0, false);
    inches["nodes"]["v"] = json!(V.map(|v| v / 25.4));
    let made = posted(&app, &format!("{place}/iterations"), &inches).await.json();
    let warning = &made["fits"][0]["figures"]["warnings"][0];
    assert_eq!((&warning["code"], &warning["params"]["unit"]), (&json!("implausible_unit"), &json!("in")));
    for path in [format!("{place}/iterations/1/correction"), format!("{place}/correction")] {
        let kept = get(&app, &path).await;
        assert_eq!(kept.get("answer"), None, "{kept}");
        let why = kept["not_compared"].as_str().unwrap();
        assert!(why.starts_with("iteration 2: along the axis") && why.contains("? then 1 to 14 mm)"), "{why}");
    }
    let patch = json!({"axes": {"v": {"quantity": "face_width", "unit": "in"}}});
    assert_eq!(send(app.client.patch(app.url(&format!("{place}/iterations/2"))).json(&patch)).await.status, 200);
    for path in [format!("{place}/iterations/1/correction"), format!("{place}/correction")] {
        assert!(get(&app, &path).await["answer"]["verdict"].is_string());
    }
    // the roll lengths of the flank said to be minutes of arc
    let mut angles = iteration("2", 0.2, 1.0, false);
    angles["axes"]["u"]["unit"] = json!("arcmin");
    let made = posted(&app, &format!("{place}/iterations"), &angles).await.json();
    assert_eq!(made["fits"][0]["figures"]["warnings"][0]["code"], "implausible_unit", "{made}");
    app.stop().await;
}

/// The next measurement on another grid is not compared, and both grids are named.
#[tokio::test]
async fn other_nodes_are_not_compared() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": spur()})).await;
    let mut body = iteration("1", 1.0, 0.0, false);
    posted(&app, &format!("{place}/iterations"), &body).await;
    posted(&app, &format!("{place}/iterations/1/correction"), &asked()).await;
    body["nodes"]["u"].as_array_mut().unwrap().pop();
    body["nodes"]["z"].as_array_mut().unwrap().pop();
    posted(&app, &format!("{place}/iterations"), &body).await;
    let kept = get(&app, &format!("{place}/iterations/1/correction")).await;
    let why = kept["not_compared"].as_str().unwrap();
    assert!(why.contains("4 × 6 nodes") && why.contains("5 × 6 nodes"), "{why}");
    app.stop().await;
}

/// The same nodes by another estimator, `turn` another scatter.
fn by_student(turn: f64) -> Value {
    let mut body = iteration("1", 0.1, turn, false);
    body["estimator"] = json!({"type": "maximum_likelihood", "distribution": "student", "shape": 1});
    body
}

/// A relief that a surface of second order cannot follow.
fn relieved() -> Value {
    let mut body = iteration("1", 0.1, 0.0, false);
    let fine = |range: [f64; 2]| -> Vec<f64> {
        (0..9).map(|k| range[0] + (range[1] - range[0]) * f64::from(k) / 8.0).collect()
    };
    let (u, v) = (fine([6.0, 12.0]), fine([1.0, 14.0]));
    let height =
        |i: usize, j: usize| 0.4 * (13.0 * i as f64 + 78.0 * j as f64).sin() - 10.0 * (i as f64 - 6.0).max(0.0);
    let z: Vec<Vec<f64>> = (0..9).map(|i| (0..9).map(|j| height(i, j)).collect()).collect();
    body["nodes"] = json!({"type": "grid", "u": u, "v": v, "z": z});
    body
}

/// A fit keeps the reasons to doubt it, though the job had no limits when it was made.
#[tokio::test]
async fn doubts_of_a_fit_without_limits_reach_a_correction_with_limits() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": spur()})).await;
    posted(&app, &format!("{place}/iterations"), &relieved()).await;
    let shown = page(&app, &place, 1).await;
    assert!(shown["reasons"].as_array().unwrap().contains(&json!("lack_of_fit")), "{shown}");
    assert_eq!(shown["profile_slope_um"].get("conformity"), None);
    let patch = json!({"requirements": limits()});
    assert_eq!(send(app.client.patch(app.url(&place)).json(&patch)).await.status, 200);
    let made = posted(&app, &format!("{place}/iterations/1/correction"), &asked()).await.json()["result"].clone();
    let conformity = &made["figures"]["left"]["helix_slope_um"]["conformity_before"];
    assert_eq!((&conformity["assumptions"], &conformity["reasons"]), (&json!("doubtful"), &shown["reasons"]), "{made}");
}

/// Weights that leave too few nodes for standard errors leave a figure within its limits
/// undecidable, on its page, in a correction and in the list of jobs.
#[tokio::test]
async fn refused_intervals_leave_conformity_undecidable() {
    let app = TestApp::start().await;
    let wide = json!({"tolerance_limits": {"helix_slope_um": [-90, 90]}});
    let place = job(&app, json!({"name": "w", "gear": spur(), "requirements": wide})).await;
    let mut number = 0;
    let figures = loop {
        number += 1;
        let made = posted(&app, &format!("{place}/iterations"), &by_student(f64::from(number))).await.json();
        let fit = &made["fits"][0];
        let figures = fit["figures"].clone();
        if fit["result"]["warnings"].to_string().contains("too_few_nodes") {
            break figures;
        }
        assert_eq!(figures["helix_slope_um"]["conformity"]["verdict"], "conforms", "{figures}");
        assert!(number < 60);
    };
    let undecidable = json!({"limits_um": [-90.0, 90.0], "probability": [0.0, 1.0], "verdict": "undecidable",
        "assumptions": "doubtful", "reasons": figures["reasons"]});
    let helix = &figures["helix_slope_um"];
    assert!(figures["reasons"].as_array().unwrap().contains(&json!("too_few_nodes")), "{figures}");
    assert_eq!((helix.get("interval"), &helix["within"]), (None, &json!(true)));
    assert_eq!(helix["conformity"], undecidable);
    let listed = get(&app, "/v1/jobs").await["items"][0]["figures"].clone();
    assert_eq!((&listed["verdict"], &listed["assumptions"]), (&json!("undecidable"), &json!("doubtful")), "{listed}");
    let corrected = posted(&app, &format!("{place}/iterations/{number}/correction"), &asked()).await.json();
    let before = &corrected["result"]["figures"]["left"]["helix_slope_um"]["conformity_before"];
    assert_eq!(before, &undecidable);
}
