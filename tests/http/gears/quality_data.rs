//! Evaluations as files for statistical process control, read back by a reader of their own.

use reqwest::{RequestBuilder, header::HeaderMap};
use serde_json::{Value, json};

use super::{import, qdas_file::File, spur, taken};
use crate::{
    harness::{TestApp, send},
    shapes::examples,
};

const DFQ: &str = "application/x-q-das-dfq";

/// A file in a response, with its head.
async fn file(request: RequestBuilder, status: u16) -> (File, HeaderMap) {
    let answer = request.header("accept", DFQ).send().await.unwrap();
    let (found, headers) = (answer.status().as_u16(), answer.headers().clone());
    let bytes = answer.bytes().await.unwrap();
    assert_eq!(found, status, "{}", String::from_utf8_lossy(&bytes));
    assert_eq!(headers["content-type"], "application/x-q-das-dfq; charset=windows-1252");
    assert_eq!(headers["content-disposition"], "attachment; filename=\"evaluation.dfq\"");
    assert_eq!(headers["vary"].to_str().unwrap().split(',').next(), Some("accept"));
    assert!(!headers.contains_key("etag"));
    (File::read(&bytes), headers)
}

/// The index of the characteristic with this number.
fn numbered(file: &File, number: &str) -> usize {
    let found = (1..=file.declared).find(|k| file.one("K2001", *k) == Some(number));
    found.unwrap_or_else(|| panic!("no {number}"))
}

/// Value of a characteristic as text, and its limits.
fn of(file: &File, number: &str) -> (String, [Option<f64>; 2]) {
    let k = numbered(file, number);
    assert_eq!((file.one("K2142", k), file.one("K2022", k), file.one("K0002", k)), (Some("µm"), Some("3"), Some("0")));
    let limit = |key| file.one(key, k).map(|limit| limit.parse().unwrap());
    (file.one("K0001", k).unwrap().to_owned(), [limit("K2110"), limit("K2111")])
}

fn digits(value: &Value) -> String {
    format!("{:.3}", value.as_f64().unwrap())
}

#[tokio::test]
async fn every_figure_of_an_evaluation_is_a_characteristic() {
    let app = TestApp::start().await;
    let mut request = examples("evaluate_gear")[0].1.clone();
    request["evaluation"]["tolerance_limits"] = json!({"class": 6, "helix_crowning_um": [-2.0, 3.0]});
    let answer = taken(&app, "/v1/gears/evaluate", &request).await;
    let tolerances =
        taken(&app, "/v1/gears/tolerances", &json!({"gear": request["gear"], "class": 6})).await["rounded"].clone();
    let (file, _) = file(app.post("/v1/gears/evaluate", request.to_string()), 200).await;
    assert_eq!(file.one("K1001", 1), Some("Gear z 52 m 1"));
    assert_eq!(file.one("K1002", 1), Some("Gear, 52 teeth, normal module 1 mm"));
    let mut count = 0;
    for trace in answer["traces"].as_array().unwrap() {
        let (kind, greek) = if trace["kind"] == "profile" { ("profile", "alpha") } else { ("helix", "beta") };
        let tolerance = |name: &str| tolerances[format!("{kind}_{name}_um")].as_f64();
        let slope = tolerance("slope").unwrap();
        let crowning = if kind == "helix" { [Some(-2.0), Some(3.0)] } else { [None; 2] };
        for (symbol, field, limits) in [
            (format!("f_H{greek}"), "slope_um", [Some(-slope), Some(slope)]),
            (format!("f_f{greek}"), "form_um", [None, tolerance("form")]),
            (format!("F_{greek}"), "total_um", [None, tolerance("total")]),
            (format!("C_{greek}"), "crowning_um", crowning),
        ] {
            let side = if trace["flank"] == "left" { "L" } else { "R" };
            let number = format!("{}{side}-{symbol}", trace["tooth"].as_str().unwrap());
            assert_eq!(of(&file, &number), (digits(&trace[field]), limits), "{number}");
            let name = file.one("K2002", numbered(&file, &number)).unwrap();
            assert!(name.starts_with(&symbol) && name.contains("flank of tooth"), "{name}");
            count += 1;
        }
    }
    for mean in answer["means"].as_array().unwrap() {
        let greek = if mean["kind"] == "profile" { "alpha" } else { "beta" };
        let side = if mean["flank"] == "left" { "L" } else { "R" };
        for (symbol, field) in [("f_H", "slope_um"), ("f_f", "form_um"), ("F_", "total_um"), ("C_", "crowning_um")] {
            assert_eq!(of(&file, &format!("m{side}-{symbol}{greek}")).0, digits(&mean[field]["mean"]));
            assert_eq!(of(&file, &format!("V{side}-{symbol}{greek}")).0, digits(&mean[field]["variation"]));
            count += 2;
        }
    }
    assert!(count >= 20, "{count}");
    let figures = ["profile_slope_um", "helix_slope_um", "profile_crowning_um", "helix_crowning_um", "twist_um"];
    let surfaces = answer["surfaces"].as_array().unwrap();
    let given = surfaces.iter().flat_map(|surface| figures.iter().filter(|name| surface.get(**name).is_some())).count();
    assert_eq!(file.declared, count + given + answer["twists"].as_array().unwrap().len());
    app.stop().await;
}

#[tokio::test]
async fn a_figure_that_is_not_known_is_a_placeholder() {
    let app = TestApp::start().await;
    let helix = |tooth: &str, z: Vec<f64>| {
        let deviation: Vec<f64> = z.iter().map(|z| 0.2 * z).collect();
        json!({"tooth": tooth, "flank": "right", "kind": "helix", "z_mm": z, "deviation_um": deviation})
    };
    let whole: Vec<f64> = (0..=30).map(|k| 0.5 * f64::from(k)).collect();
    // the second trace has too few samples; the third is of the same tooth as the first
    let traces = [helix("1", whole.clone()), helix("2", vec![0.0, 5.0, 10.0]), helix("1", whole)];
    let request = json!({"gear": spur(), "traces": traces, "evaluation": {"helix_range_mm": [1.0, 14.0]}});
    let (file, _) = file(app.post("/v1/gears/evaluate", request.to_string()), 200).await;
    let lost = numbered(&file, "2R-f_Hbeta");
    assert_eq!((file.one("K0001", lost), file.one("K0002", lost)), (Some("0.000"), Some("255")));
    assert_eq!(of(&file, "1R-f_Hbeta").0, of(&file, "1R-f_Hbeta~2").0);
    app.stop().await;
}

#[tokio::test]
async fn pitches_are_characteristics() {
    let app = TestApp::start().await;
    let request = &examples("gear_pitch")[0].1;
    let answer = taken(&app, "/v1/gears/pitch", request).await;
    let (file, _) = file(app.post("/v1/gears/pitch", request.to_string()), 200).await;
    for (letter, side) in [("L", "left"), ("R", "right")] {
        let found = &answer[side];
        for (symbol, value) in [
            ("f_p", &found["single_pitch"]["value_um"]),
            ("F_p", &found["cumulative_pitch_um"]),
            ("F_pk", &found["sector_pitch_2013"]["value_um"]),
            ("F_pSk", &found["sector_sum_2013"]["value_um"]),
            ("F_pk_1995", &found["sector_pitch_1995"]["value_um"]),
            ("R_p", &found["single_pitch_range_um"]),
            ("f_u", &found["adjacent_pitch_difference"]["value_um"]),
        ] {
            assert_eq!(of(&file, &format!("{letter}-{symbol}")).0, digits(value));
        }
    }
    assert_eq!(of(&file, "F_r").0, digits(&answer["runout"]["runout_um"]));
    assert_eq!(of(&file, "f_e").0, digits(&answer["runout"]["eccentricity"]["amount_um"]));
    assert_eq!(of(&file, "R_s").0, digits(&answer["tooth_thickness_variation_um"]));
    assert_eq!(file.declared, 17);
    app.stop().await;
}

#[tokio::test]
async fn a_stored_evaluation_names_its_part_and_measurement() {
    let app = TestApp::start().await;
    let job = json!({"name": "Sonnenrad – groß", "part_number": "47-11", "serial_number": "S12", "machine": "RZ 260",
        "gear": spur(), "tags": {"batch": "B¤ 7"}});
    let job = send(app.post("/v1/jobs", job.to_string())).await.json()["id"].as_str().unwrap().to_owned();
    let place = format!("/v1/jobs/{job}/iterations");
    let nodes = json!({"nodes": {"type": "curve", "x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 1.0, 1.9, 3.2]},
        "model": {"type": "polynomial", "degree": 1}, "measured_at": "2026-03-04T05:06:07Z", "instrument": "P 40",
        "operator": "Müller"});
    assert_eq!(send(app.post(&place, nodes.to_string())).await.status, 201);
    let text = examples("create_iteration_evaluation")[0].1.to_string();
    let post = || app.post(&format!("{place}/1/evaluations"), text.clone()).header("idempotency-key", "once");
    let (made, head) = file(post(), 201).await;
    let kept = head["location"].to_str().unwrap().to_owned();
    let record = send(app.get(&kept)).await;
    assert_eq!(record.header("vary").split(',').next(), Some("accept"));
    let record = record.json();
    let remark = format!("job {job}, iteration 1, record {}", record["id"].as_str().unwrap());
    let says = |file: &File| {
        for (key, content) in [
            ("K1001", "47-11"),
            ("K1002", "Sonnenrad – groß"),
            ("K1082", "RZ 260"),
            ("K1202", "P 40"),
            ("K1222", "Müller"),
            ("K0004", "04.03.2026/05:06:07"),
            ("K0006", "B  7"),
            ("K0009", &remark),
            ("K0014", "S12"),
        ] {
            assert_eq!(file.one(key, 1), Some(content), "{key}");
        }
        assert_eq!(of(file, "1L-f_Hbeta").0, digits(&record["result"]["traces"][0]["slope_um"]));
    };
    says(&made);
    let (again, head) = file(post(), 201).await;
    says(&again);
    assert_eq!([&head["location"], &head["idempotency-replayed"]], [kept.as_str(), "true"]);
    says(&file(app.get(&kept), 200).await.0);
    // a name that Windows-1252 has no letters for
    let patch = app.client.patch(app.url(&format!("/v1/jobs/{job}"))).header("content-type", "application/json");
    assert_eq!(send(patch.body(json!({"name": "太阳轮"}).to_string())).await.status, 200);
    let answer = app.get(&kept).header("accept", DFQ).send().await.unwrap();
    assert_eq!(answer.headers()["content-type"], "application/x-q-das-dfq; charset=utf-8");
    assert_eq!(File::read(&answer.bytes().await.unwrap()).one("K1002", 1), Some("太阳轮"));
    app.stop().await;
}

#[tokio::test]
async fn records_of_other_kinds_have_no_such_form() {
    let app = TestApp::start().await;
    let job = import::job(&app, Some(spur())).await;
    let made = import::import(&app, &job, import::file(false), "1.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let records = send(app.get(&format!("{job}/iterations/1/records"))).await.json();
    let place = |id: &Value| format!("{job}/iterations/1/records/{}", id.as_str().unwrap());
    let (imported, _) = file(app.get(&place(&records["items"][0]["id"])), 200).await;
    let slope: f64 = of(&imported, "1L-f_Halpha").0.parse().unwrap();
    assert!((slope - 10.0).abs() < 2e-3, "{slope}");
    let curve = examples("create_curve")[0].1.to_string();
    let kept = send(app.post(&format!("{job}/iterations/1/curves"), curve)).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let at = kept.header("location").to_owned();
    let refused = send(app.get(&at).header("accept", DFQ)).await;
    let detail = refused.problem(406, "not_acceptable")["detail"].as_str().unwrap().to_owned();
    assert!(detail.contains("curve") && detail.contains(DFQ), "{detail}");
    let either = send(app.get(&at).header("accept", format!("{DFQ}, application/json;q=0.1"))).await;
    assert_eq!((either.status.as_u16(), either.header("content-type")), (200, "application/json"));
    app.stop().await;
}
