//! Traces, bands and nodes about the design of a job.

use reqwest::Method;
use serde_json::{Value, json};

use super::{
    fit_figures::{axes, get, job, posted},
    import::{file, import},
    spur, taken,
};
use crate::{
    harness::{TestApp, send},
    shapes::close,
};

const U: [f64; 5] = [6.0, 7.0, 8.0, 9.0, 10.0];
const V: [f64; 5] = [1.0, 4.25, 7.5, 10.75, 14.0];

fn helical() -> Value {
    let mut gear = spur();
    gear["helix_angle_deg"] = json!(20.0);
    gear.as_object_mut().unwrap().remove("tip_diameter_mm");
    gear.as_object_mut().unwrap().remove("root_diameter_mm");
    gear
}

/// cos β_b of [`helical`]: sin β_b = sin β cos α_n.
fn normal() -> f64 {
    (20f64.to_radians().sin() * 20f64.to_radians().cos()).asin().cos()
}

/// The transverse base radius of [`helical`].
fn base_radius() -> f64 {
    let (beta, alpha) = (20f64.to_radians(), 20f64.to_radians());
    26.0 / beta.cos() * (alpha.tan() / beta.cos()).atan().cos()
}

fn requirements(direction: &str) -> Value {
    let band = |against: &str| json!({"kind": "profile", "against": against, "upper": [[6, 1], [10, 1]], "lower": [[6, -1], [10, -1]]});
    json!({"design": {"profile_crowning_um": 4, "helix_crowning_um": 5}, "direction": direction,
           "tolerance_limits": {"class": 7, "profile_crowning_um": [2, 6], "profile_form_um": [0, 3]},
           "k_bands": [band("design"), band("involute")]})
}

fn nodes() -> Value {
    let z: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| u * v % 3.0).collect()).collect();
    json!({"nodes": {"type": "grid", "u": U, "v": V, "z": z}, "flank": "left", "tooth": "1", "axes": axes(),
           "model": {"type": "polynomial", "degree": 2, "terms": "total"}})
}

/// A profile and a helix with the designed crownings times `share`, transverse, and some waviness.
fn evaluation(share: f64, settings: Value) -> Value {
    let roll: Vec<f64> = (0..=40).map(|k| 6.0 + 0.1 * f64::from(k)).collect();
    let z: Vec<f64> = (0..=52).map(|k| 1.0 + 0.25 * f64::from(k)).collect();
    let of = |places: &[f64], amount: f64, [low, high]: [f64; 2]| -> Vec<f64> {
        let u = |x: f64| (2.0 * x - low - high) / (high - low);
        places.iter().map(|x| 7.0 - share * amount * u(*x).powi(2) + 0.2 * (40.0 * x).sin()).collect()
    };
    let (profile, helix) = (of(&roll, 4.0, [6.0, 10.0]), of(&z, 5.0, [1.0, 14.0]));
    let diameter = |l: f64| 2.0 * base_radius().hypot(l);
    let mut body = json!({
        "traces": [
            {"tooth": "1", "flank": "left", "kind": "profile", "roll_length_mm": roll, "deviation_um": profile,
             "section_z_mm": 7.5},
            {"tooth": "1", "flank": "left", "kind": "helix", "z_mm": z, "deviation_um": helix,
             "section_diameter_mm": diameter(8.0)}],
        "evaluation": {"profile_diameter_range_mm": [diameter(6.0), diameter(10.0)], "helix_range_mm": [1.0, 14.0],
                       "deviation_sign": "material"}});
    body["evaluation"].as_object_mut().unwrap().extend(settings.as_object().unwrap().clone());
    body
}

/// Figures are about the involute unless the design is requested; bands have a choice of their own.
/// The design's figures are along the direction of the requirements, traces are transverse.
#[tokio::test]
async fn traces_are_read_against_either() {
    let app = TestApp::start().await;
    for (direction, share) in [("transverse", 1.0), ("normal", 1.0 / normal())] {
        let required = requirements(direction);
        let job = job(&app, json!({"name": "w", "gear": helical(), "requirements": required})).await;
        posted(&app, &format!("{job}/iterations"), &nodes()).await;
        let path = format!("{job}/iterations/1/evaluations");
        let plain = posted(&app, &path, &evaluation(share, json!({}))).await.json()["result"].clone();
        let design = evaluation(share, json!({"against": "design"}));
        let design = posted(&app, &path, &design).await.json()["result"].clone();
        for (k, amount) in [4.0, 5.0].into_iter().enumerate() {
            let crowning = |answer: &Value| answer["traces"][k]["crowning_um"].as_f64().unwrap();
            assert!((crowning(&plain) - share * amount).abs() < 0.2, "{plain}");
            assert!(crowning(&design).abs() < 0.2, "{design}");
            // what was subtracted is the design itself
            close(crowning(&plain) - crowning(&design), share * amount, 1e-9);
            let total = |answer: &Value| answer["traces"][k]["total_um"].as_f64().unwrap();
            assert!(total(&plain) > 3.8 && total(&design) < 0.5, "{design}");
        }
        assert_eq!(
            (&plain["evaluation"]["against"], &design["evaluation"]["against"]),
            (&json!("involute"), &json!("design"))
        );
        // limits of a crowning are of the flank
        let (of_flank, of_distance) = (&plain["traces"][0], &design["traces"][0]);
        assert_eq!((of_flank["crowning_within"].clone(), of_distance.get("crowning_within")), (json!(true), None));
        // the form about a line holds the crowning
        assert_eq!((&of_flank["form_within"], &of_distance["form_within"]), (&json!(false), &json!(true)));
        let aside = |answer: &Value| answer["warnings"].to_string().contains("distance from the design");
        assert!(aside(&design) && !aside(&plain), "{design}");
        // the bands are the same for both: ±1 µm about the design, ±1 µm about the involute
        for answer in [&plain, &design] {
            let bands = answer["traces"][0]["k_bands"].as_array().unwrap();
            let within: Vec<&Value> = bands.iter().map(|band| &band["within"]).collect();
            assert_eq!(within, [&json!(true), &json!(false)], "{answer}");
            let room = |k: usize| bands[k]["clearance_um"].as_f64().unwrap();
            assert!((room(0) - room(1) - share * 4.0).abs() < 0.4, "{answer}");
        }
        // no band of helices is about the design
        assert_eq!(plain["traces"][1].get("design_um"), None, "{plain}");
        let line = design["traces"][1]["design_um"].as_array().unwrap();
        let [end, middle] = [0, 26].map(|k: usize| line[k].as_f64().unwrap());
        close(middle - end, share * 5.0, 1e-9);
    }
}

/// A file is read against the design if its spec says so, and the evaluated traces can be posted
/// again.
#[tokio::test]
async fn files_are_read_against_the_design() {
    let app = TestApp::start().await;
    let spec = json!({"evaluation": {"against": "design"}});
    let plain = job(&app, json!({"name": "w", "gear": spur()})).await;
    let refused = import(&app, &plain, file(false), "1.mka", Some(spec.clone())).await;
    assert_eq!(refused.pointers(), ["/spec/evaluation/against"], "{}", refused.text);
    assert_eq!(get(&app, &format!("{plain}/iterations")).await["items"], json!([]));
    let requirements = json!({"design": {"profile_slope_um": 4, "helix_crowning_um": 5}});
    let designed = job(&app, json!({"name": "w", "gear": spur(), "requirements": requirements})).await;
    for (spec, slope, crowning) in [(None, 10.0, 0.0), (Some(spec), 6.0, -5.0)] {
        let made = import(&app, &designed, file(false), "1.mka", spec.clone()).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let number = made.json()["number"].as_u64().unwrap();
        let id = get(&app, &format!("{designed}/iterations/{number}/records")).await["items"][0]["id"].clone();
        let path = format!("{designed}/iterations/{number}/records/{}", id.as_str().unwrap());
        let record = get(&app, &path).await;
        let of = |kind: &str, name: &str| -> f64 {
            let traces = record["result"]["traces"].as_array().unwrap();
            traces.iter().find(|trace| trace["kind"] == kind).unwrap()[name].as_f64().unwrap()
        };
        assert!((of("profile", "slope_um") - slope).abs() < 0.05, "{record}");
        assert!((of("helix", "crowning_um") - crowning).abs() < 0.05, "{record}");
        let mut again = record["request"].clone();
        for name in ["file", "file_sha256", "file_bytes", "spec"] {
            again.as_object_mut().unwrap().remove(name);
        }
        let answer = taken(&app, "/v1/gears/evaluate", &again).await;
        assert_eq!(answer["traces"], record["result"]["traces"]);
    }
}

/// A request that needs a design is refused with its place if there is none.
#[tokio::test]
async fn a_design_that_is_missing_is_named() {
    let app = TestApp::start().await;
    let place = job(&app, json!({"name": "w", "gear": helical()})).await;
    posted(&app, &format!("{place}/iterations"), &nodes()).await;
    let path = format!("{place}/iterations/1/evaluations");
    let band = json!({"kind": "helix", "against": "design", "upper": [[1, 1], [14, 1]], "lower": [[1, -1], [14, -1]]});
    for (settings, pointer) in [
        (json!({"against": "design"}), "/evaluation/against"),
        (json!({"k_bands": [band]}), "/evaluation/k_bands/0/against"),
    ] {
        let refused = send(app.post(&path, evaluation(1.0, settings.clone()).to_string())).await;
        assert_eq!(refused.pointers(), [pointer], "{}", refused.text);
        let mut alone = evaluation(1.0, settings);
        alone["gear"] = helical();
        let refused = send(app.post("/v1/gears/evaluate", alone.to_string())).await;
        assert_eq!(refused.pointers(), [pointer], "{}", refused.text);
        // the request's own modifications are a design
        alone["modifications"] = json!([{"type": "helix_crowning", "amount_um": 5.0}]);
        let answer = send(app.post("/v1/gears/evaluate", alone.to_string())).await;
        assert_eq!(answer.status, 200, "{}", answer.text);
    }
    let patch = json!({"requirements": {"k_bands": [band]}});
    let refused = send(app.client.request(Method::PATCH, app.url(&place)).json(&patch)).await;
    assert_eq!(refused.pointers(), ["/requirements/k_bands/0/against"], "{}", refused.text);
    // a section that is not known
    let patch = json!({"requirements": requirements("normal")});
    assert_eq!(send(app.client.request(Method::PATCH, app.url(&place)).json(&patch)).await.status, 200);
    let unplaced = |settings: Value| {
        let mut body = evaluation(1.0, settings);
        body["traces"][0].as_object_mut().unwrap().remove("section_z_mm");
        body
    };
    let refused = send(app.post(&path, unplaced(json!({"against": "design"})).to_string())).await;
    assert_eq!(refused.pointers(), ["/traces/0/section_z_mm"], "{}", refused.text);
    // the job's own band is left aside, and the other one holds
    let kept = posted(&app, &path, &unplaced(json!({}))).await.json()["result"].clone();
    assert!(kept["warnings"].to_string().contains("bands about the design"), "{kept}");
    assert_eq!(kept["traces"][0]["k_bands"].as_array().unwrap().len(), 1, "{kept}");
    // deviations in mm, however near the design they would be in µm
    let mut small = evaluation(1.0, json!({"against": "design"}));
    for trace in small["traces"].as_array_mut().unwrap() {
        for value in trace["deviation_um"].as_array_mut().unwrap() {
            *value = json!(value.as_f64().unwrap() / 1000.0);
        }
    }
    let small = posted(&app, &path, &small).await.json()["result"].clone();
    assert!(small["warnings"].to_string().contains("implausible_unit"), "{small}");
    assert_eq!(small["traces"][0].get("class"), None, "{small}");
}

/// The design at the nodes of a measurement: −4 u² − 5 v² over what they span.
#[tokio::test]
async fn the_design_at_the_nodes() {
    let app = TestApp::start().await;
    for (direction, share) in [("normal", 1.0), ("transverse", normal())] {
        let job = job(&app, json!({"name": "w", "gear": helical(), "requirements": requirements(direction)})).await;
        posted(&app, &format!("{job}/iterations"), &nodes()).await;
        let design = get(&app, &format!("{job}/iterations/1/design")).await;
        let found: Vec<f64> = design["deviation_um"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let wanted = U
            .iter()
            .flat_map(|u| V.iter().map(move |v| -4.0 * ((u - 8.0) / 2.0).powi(2) - 5.0 * ((v - 7.5) / 6.5).powi(2)));
        for (found, wanted) in found.iter().zip(wanted) {
            close(*found, share * wanted, 1e-9);
        }
        assert_eq!(found.len(), 25);
    }
    let without = async |job_body: Value, iteration: Value, words: &str| {
        let job = job(&app, job_body).await;
        posted(&app, &format!("{job}/iterations"), &iteration).await;
        let refused = send(app.get(&format!("{job}/iterations/1/design"))).await;
        refused.problem(409, "conflict");
        assert!(refused.text.contains(words), "{words}: {}", refused.text);
    };
    without(json!({"name": "w", "gear": helical()}), nodes(), "`design`").await;
    without(json!({"name": "w", "requirements": {"design": {}}}), nodes(), "`gear`").await;
    let mut unnamed = nodes();
    unnamed.as_object_mut().unwrap().remove("flank");
    without(json!({"name": "w", "gear": helical(), "requirements": {"design": {}}}), unnamed, "`flank`").await;
    let missing = send(app.get("/v1/jobs/00000000-0000-7000-8000-000000000000/iterations/1/design")).await;
    assert_eq!(missing.status, 404, "{}", missing.text);
}
