//! The whole life of a job, with a restart in the middle of it.

use super::app::{TestApp, alone, iteration, nodes, send};
use flankfit::api::jobs::{
    iterations::{IterationBody, IterationFitBody, NewIterationBody},
    job::JobBody,
    trace::TraceBody,
};
use reqwest::{
    Method,
    multipart::{Form, Part},
};
use serde_json::{Value, json};

/// Compares the first iteration in the trace with the responses that made it.
fn check_traced(traced: &Value, first: &Value, second: &Value) {
    assert_eq!(traced["decision"], "remachine");
    assert_eq!(traced["measured_at"], "2026-11-21T08:30:00.000000Z");
    assert_eq!(traced["fits"][0]["id"], first["fits"][0]["id"]);
    assert_eq!(traced["fits"][1]["lambda_star"], 0.001);
    assert_eq!(traced["fits"][1]["criterion"], "fixed");
    assert_eq!(traced["fits"][1]["count"], 2);
    assert_eq!(traced["fits"][1]["reason"], "smoother");
    assert_eq!(traced["fits"][1]["coefficients"], second["result"]["coefficients"]);
    let result = &second["result"];
    assert_eq!(traced["fits"][1]["condition"], result["spectrum"]["condition"]);
    assert_eq!(traced["fits"][1]["regularized_condition"], result["spectrum"]["regularized"]["condition"]);
    assert_eq!(traced["fits"][1]["bias_norm"], result["bias"]["norm"]);
    assert_eq!(traced["fits"][1]["bias_sharp_bound"], result["bias"]["sharp_bound"]);
    assert_eq!(traced["fits"][1]["rms"], result["residuals"]["rms"]);
    assert_eq!(traced["fits"][1]["max_abs"], result["residuals"]["max_abs"]);
    assert_eq!(traced["choices"][0]["fit_id"], first["fits"][0]["id"]);
    assert_eq!(traced["choices"][1]["fit_id"], second["id"]);
    assert_eq!(traced["choices"][1]["reason"], "less noise");
    assert_eq!(traced["decisions"][0]["decision"], "remachine");
}

/// Checks the iteration at `place` that was just created with the answer `created`, parsed as
/// `first`: it lists its fit by figures, and the fit itself is returned in full, byte for byte.
async fn check_seen(app: &TestApp, place: &str, created: &str, first: &Value) {
    let seen = app.get(place).await.expect(200);
    let body: IterationBody = serde_json::from_str(&seen.text).unwrap();
    assert_eq!(serde_json::to_value(body).unwrap(), seen.json());
    let mut named = seen.json();
    let figures = named["fits"][0].take();
    named["fits"][0] = first["fits"][0].clone();
    // warnings of the fit's result are only in responses that contain the result
    let mut without_result = first.clone();
    let of_result = |warning: &Value| warning["at"].as_str().unwrap().starts_with("/fits/0/result");
    without_result["warnings"].as_array_mut().unwrap().retain(|warning| !of_result(warning));
    assert_ne!(without_result, *first);
    assert_eq!(named, without_result);
    assert_eq!(figures.get("result"), None);
    assert_eq!(figures["rms"], first["fits"][0]["result"]["residuals"]["rms"]);
    let fit = format!("{place}/fits/{}", first["fits"][0]["id"].as_str().unwrap());
    let full = app.get(&fit).await.expect(200);
    assert_eq!(full.json(), alone(first, "/fits/0"));
    let (text, _) = full.text.rsplit_once(r#","warnings":["#).unwrap();
    assert!(created.contains(&format!("{text}}}")), "{}", full.text);
}

#[tokio::test]
async fn a_job_from_creation_to_acceptance() {
    let mut app = TestApp::start().await;
    let gear = json!({"teeth": 52, "normal_module_mm": 1.0, "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 0.0,
        "profile_shift_coefficient": 0.0, "face_width_mm": 20.0, "tool": {"tip_radius_mm": 0.3}});
    let created = app
        .post(
            "/v1/jobs",
            &json!({"name": "wheel", "part_number": "A-1", "machine": "grinder 3", "gear": gear,
            "tags": {"shift": "night"}}),
        )
        .await
        .expect(201);
    let job = created.header("location").unwrap().to_owned();
    let body: JobBody = serde_json::from_str(&created.text).unwrap();
    assert_eq!(job, format!("/v1/jobs/{}", body.id));
    assert_eq!(body.id.get_version_num(), 7);
    assert_eq!(created.json()["gear"], gear);
    assert_eq!(created.header("etag"), Some("\"1-new\""));
    assert_eq!(app.get(&job).await.expect(200).text, created.text);

    // The first iteration: nodes and fit.
    let first = app.post(&format!("{job}/iterations"), &iteration()).await.expect(201);
    assert_eq!(first.header("location"), Some(format!("{job}/iterations/1").as_str()));
    let body: NewIterationBody = serde_json::from_str(&first.text).unwrap();
    assert_eq!((body.posted.measured.number, body.posted.node_count, body.fits.len()), (1, 45, 1));
    assert!(body.fits[0].chosen);
    let created_text = first.text.clone();
    let first = first.json();
    assert_eq!(serde_json::to_value(body).unwrap(), first);
    assert_eq!(first["measured_at"], "2026-11-21T08:30:00.000000Z");
    let place = format!("{job}/iterations/1");
    check_seen(&app, &place, &created_text, &first).await;
    // The stored answer is the one that POST /v1/fits gives.
    let mut plain = iteration();
    for extra in ["measured_at", "instrument", "operator", "note"] {
        plain.as_object_mut().unwrap().remove(extra);
    }
    let computed = app.post("/v1/fits", &plain).await.expect(200);
    let mut computed = computed.json();
    assert_eq!(computed["spec"], first["fits"][0]["spec"]);
    computed.as_object_mut().unwrap().remove("spec");
    assert_eq!(computed, first["fits"][0]["result"]);

    // Another λ*, and the choice of it.
    let request = json!({
        "model": {"type": "polynomial", "degree": [2, 2]},
        "regularization": {"type": "spectral", "count": 2, "lambda_star": {"criterion": "fixed", "value": 0.001}},
        "reason": "smoother",
    });
    let refit = app.post(&format!("{place}/fits"), &request).await.expect(201);
    let body: IterationFitBody = serde_json::from_str(&refit.text).unwrap();
    assert!(!body.chosen);
    assert_eq!(refit.header("etag"), Some("\"2\""));
    let second = refit.json();
    assert_eq!(serde_json::to_value(body).unwrap(), second);
    assert_eq!(second["result"]["regularization"]["criterion"], "fixed");
    let chosen = app
        .put(&format!("{place}/chosen-fit"), &json!({"fit_id": second["id"], "reason": "less noise"}))
        .await
        .expect(200);
    assert_eq!(chosen.json()["fits"][0]["chosen"], false);
    assert_eq!(chosen.json()["fits"][1]["chosen"], true);

    // The decision, and the re-machined flank.
    let decided = app.patch(&place, &json!({"decision": "remachine", "reason": "slope"})).await.expect(200);
    assert_eq!(decided.json()["decision"], "remachine");
    app.restart().await;
    assert_eq!(app.get(&place).await.expect(200).text, decided.text);
    let again = app.iteration(&job).await;
    assert_eq!(again, format!("{job}/iterations/2"));
    app.patch(&again, &json!({"decision": "accepted"})).await.expect(200);

    // The trace has all of it.
    let trace = app.get(&format!("{job}/trace")).await.expect(200);
    let documented: TraceBody = serde_json::from_str(&trace.text).unwrap();
    let trace = trace.json();
    // Every field of the answer is documented.
    assert_eq!(serde_json::to_value(documented).unwrap(), trace);
    assert_eq!(trace["job"]["name"], "wheel");
    check_traced(&trace["iterations"][0], &first, &second);
    assert_eq!(trace["iterations"][1]["decision"], "accepted");
    assert_eq!(trace["iterations"].as_array().unwrap().len(), 2);

    // Replays are identical, also in another process than the one that computed.
    for fit in [&first["fits"][0]["id"], &second["id"]] {
        let replay = app.post(&format!("{place}/fits/{}/replay", fit.as_str().unwrap()), &json!({})).await.expect(200);
        assert_eq!(replay.text, r#"{"identical":true}"#);
    }
    app.stop().await;
}

#[tokio::test]
async fn a_replay_reports_differences_from_another_engine() {
    let mut app = TestApp::start_on_file().await;
    let job = app.job().await;
    // an answer short enough to be stored as text
    let mut short = iteration();
    short["model"]["degree"] = json!([1, 1]);
    let posted = app.post(&format!("{job}/iterations"), &short).await.expect(201);
    let place = posted.header("location").unwrap().to_owned();
    let fit = posted.json()["fits"][0]["id"].as_str().unwrap().to_owned();
    // An older engine's answer, as it would lie in an older database. (Only a test takes the
    // trigger away.)
    app.restart_after(async |database| {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(database);
        let mut own = sqlx::ConnectOptions::connect(&options).await.unwrap();
        let older = r#"UPDATE fits SET result = CAST(json_set(CAST(result AS TEXT), '$.provenance.engine', 'flankfit 0.0.9',
            '$.residuals.rms', json_extract(CAST(result AS TEXT), '$.residuals.rms') * 1.0009765625) AS BLOB)"#;
        sqlx::raw_sql("DROP TRIGGER fits_no_update").execute(&mut own).await.unwrap();
        sqlx::raw_sql(older).execute(&mut own).await.unwrap();
        sqlx::Connection::close(own).await.unwrap();
    })
    .await;
    let replay = app.post(&format!("{place}/fits/{fit}/replay"), &json!({})).await.expect(200).json();
    assert_eq!(replay["identical"], false);
    assert_eq!(replay["stored_engine"], "flankfit 0.0.9");
    assert_eq!(replay["replay_engine"], flankfit::api::ENGINE);
    let difference = replay["max_relative_difference"].as_f64().unwrap();
    assert!((difference - (1.0 - 1.0 / 1.0009765625)).abs() < 1e-6, "{difference}");
    app.stop().await;
}

#[tokio::test]
async fn nodes_come_back_as_json_and_as_csv() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let place = app.iteration(&job).await;
    let answer = app.get(&format!("{place}/nodes")).await.expect(200);
    assert_eq!(answer.header("content-type"), Some("application/json"));
    assert_eq!(answer.json(), nodes());
    let table =
        send(app.request(Method::GET, &format!("{place}/nodes")).header("accept", "text/csv")).await.expect(200);
    assert_eq!(table.header("content-type"), Some("text/csv; charset=utf-8"));
    let lines: Vec<&str> = table.text.lines().collect();
    assert_eq!((lines.len(), lines[0], lines[1 + 3 * 5 + 2]), (46, "u,v,z", "31.5,10.0,"));
    let other = send(app.request(Method::GET, &format!("{place}/nodes")).header("accept", "image/png")).await;
    other.problem(406, "not_acceptable");

    // And the table goes in as a form: it is a grid again, in which the missing node stays missing.
    let mut spec = iteration();
    spec.as_object_mut().unwrap().remove("nodes");
    let form = Form::new()
        .part("spec", Part::text(spec.to_string()).mime_str("application/json").unwrap())
        .part("nodes", Part::text(table.text).mime_str("text/csv").unwrap());
    let added = send(app.request(Method::POST, &format!("{job}/iterations")).multipart(form)).await.expect(201).json();
    assert_eq!((&added["number"], &added["node_count"]), (&json!(2), &json!(45)));
    assert_eq!(added["operator"], "J. Doe");
    assert_eq!(app.get(&format!("{job}/iterations/2/nodes")).await.expect(200).json(), nodes());
    let (grid, again) = (app.get(&place).await.json(), added);
    let value = |fit: &Value| fit["result"]["coefficients"][0]["value"].as_f64().unwrap();
    let grid = app.get(&format!("{place}/fits/{}", grid["fits"][0]["id"].as_str().unwrap())).await.expect(200).json();
    assert!((value(&grid) / value(&again["fits"][0]) - 1.0).abs() < 1e-6);
    app.stop().await;
}

#[tokio::test]
async fn jobs_are_listed_newest_first_in_pages() {
    let mut app = TestApp::start().await;
    let mut created = Vec::new();
    for _ in 0..7 {
        created.insert(0, app.job().await);
    }
    let mut seen = Vec::new();
    let mut path = "/v1/jobs?limit=3".to_owned();
    loop {
        let page = app.get(&path).await.expect(200).json();
        seen.extend(
            page["items"].as_array().unwrap().iter().map(|job| format!("/v1/jobs/{}", job["id"].as_str().unwrap())),
        );
        let Some(next) = page["next_cursor"].as_str() else { break };
        path = format!("/v1/jobs?limit=3&cursor={next}");
    }
    assert_eq!(seen, created);
    app.stop().await;
}
