//! Files of a Klingelnberg P40 over HTTP: the printed values are returned.

use serde_json::{Value, json};

use super::import::{import, job};
use crate::harness::{TestApp, send};

#[track_caller]
fn near(found: &Value, printed: f64, within: f64) {
    let found = found.as_f64().unwrap();
    assert!((found - printed).abs() <= within, "{found}, printed {printed}");
}

fn file(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/engine/tests/data/p40/curves");
    std::fs::read(format!("{folder}/{name}")).unwrap()
}

/// Results of the records of the only iteration of a job, by kind.
async fn record(app: &TestApp, job: &str, kind: &str) -> Value {
    let items = send(app.get(&format!("{job}/iterations/1/records"))).await.json()["items"].clone();
    let found = items.as_array().unwrap().iter().find(|item| item["kind"] == kind).unwrap().clone();
    let id = found["id"].as_str().unwrap();
    send(app.get(&format!("{job}/iterations/1/records/{id}"))).await.json()["result"].clone()
}

/// Pinion 95911-neu: f_Ko, R_p, R_s, W_k and M_dK as printed, the lengths by the places of contact,
/// which lie up to 2.1 and 4.8 µm below (docs/reference/gear-files.md).
#[tokio::test]
async fn tip_relief_thickness_and_ranges_of_pitch_come_from_a_file() {
    let app = TestApp::start().await;
    // a job without a gear: the file's is taken
    let job = job(&app, None).await;
    let made = import(&app, &job, file("95911-neu.mka"), "95911-neu.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let evaluation = record(&app, &job, "evaluation").await;
    let codes: Vec<&str> =
        evaluation["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect();
    assert!(codes.contains(&"gear_missing"), "{codes:?}");
    assert!(made.json()["note"].as_str().unwrap().contains("gear_missing"), "{}", made.text);
    assert_eq!(evaluation["evaluation"]["tip_relief_diameter_range_mm"], json!([51.946, 52.88]));
    let trace = |flank: &str, tooth: &str| {
        let is = |trace: &&Value| trace["kind"] == "profile" && trace["flank"] == flank && trace["tooth"] == tooth;
        evaluation["traces"].as_array().unwrap().iter().find(is).unwrap()["tip_relief_um"].clone()
    };
    for (flank, tooth, printed) in [("left", "1", -23.2), ("left", "18", -22.8), ("right", "35", -23.7)] {
        near(&trace(flank, tooth), printed, 0.051);
    }
    let means = evaluation["means"].as_array().unwrap();
    let mean = |kind: &str| means.iter().find(|mean| mean["kind"] == kind && mean["flank"] == "left").unwrap();
    near(&mean("profile")["tip_relief_um"]["mean"], -23.1, 0.06);
    assert!(mean("helix").get("tip_relief_um").is_none());
    let pitch = record(&app, &job, "pitch").await;
    near(&pitch["left"]["single_pitch_range_um"], 1.8, 0.1);
    near(&pitch["right"]["single_pitch_range_um"], 1.9, 0.1);
    near(&pitch["tooth_thickness_variation_um"], 7.7, 0.051);
    let thickness = &pitch["tooth_thickness"];
    assert_eq!((&thickness["span_teeth"], &thickness["ball_diameter_mm"]), (&json!(6), &json!(1.5)));
    for (name, printed, below) in
        [("span_mm", [16.826, 16.825, 16.827], 0.0022), ("over_balls_mm", [52.174, 52.173, 52.175], 0.0049)]
    {
        for (statistic, printed) in ["mean", "least", "greatest"].into_iter().zip(printed) {
            let found = thickness[name][statistic].as_f64().unwrap();
            assert!(found < printed + 0.0006 && found > printed - below, "{name} {statistic} {found} {printed}");
        }
    }
    app.stop().await;
}

/// Wheel 97360, measured again after 18 days: a burr at the start of a lead.
#[tokio::test]
async fn a_burr_is_named_with_the_figures_without_it() {
    let app = TestApp::start().await;
    let job = job(&app, None).await;
    let made = import(&app, &job, file("97360.mka"), "97360.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let evaluation = record(&app, &job, "evaluation").await;
    let burrs = |trace: &Value| -> Vec<Value> {
        let places = trace["outliers"]["places"].as_array().cloned().unwrap_or_default();
        places.into_iter().filter(|place| place["burr"] == true).collect()
    };
    let traces = evaluation["traces"].as_array().unwrap();
    let (at, found) = traces
        .iter()
        .enumerate()
        .find(|(_, trace)| trace["tooth"] == "1k" && trace["flank"] == "right" && trace["kind"] == "helix")
        .unwrap();
    let [burr] = &burrs(found)[..] else { panic!("{found}") };
    assert!(burr["from_mm"].as_f64().unwrap() < 0.5 && burr["to_mm"].as_f64().unwrap() < 2.0, "{burr}");
    assert!(burr["height_um"].as_f64().unwrap() > 25.0, "{burr}");
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(number(&found["outliers"]["without"]["total_um"]) <= number(&found["total_um"]), "{found}");
    let warning = evaluation["warnings"].as_array().unwrap().iter().find(|warning| {
        warning["code"] == "outliers_suspected" && warning["message"].as_str().unwrap().contains("a burr at the end")
    });
    let warning = warning.unwrap_or_else(|| panic!("{}", evaluation["warnings"]));
    assert!(warning["params"]["places"].as_array().unwrap().iter().any(|place| place["burr"] == true), "{warning}");
    let others = traces.iter().enumerate().filter(|(k, trace)| *k != at && !burrs(trace).is_empty());
    assert_eq!(others.count(), 0);
    app.stop().await;
}
