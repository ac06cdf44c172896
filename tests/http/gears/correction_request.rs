//! Requests of stored records: without null members, and in short form without long lists.

use serde_json::{Value, json};

use super::correction::{flank, job, sensitivity};
use crate::{
    harness::{TestApp, send},
    shapes::examples,
};

/// Text of the member `request`, which `result` follows.
fn request_text(answer: &str) -> &str {
    let begin = answer.find(r#""request":"#).unwrap() + r#""request":"#.len();
    &answer[begin..answer.find(r#","result":"#).unwrap()]
}

async fn measured(app: &TestApp) -> String {
    let place = job(app).await;
    let nodes = flank(|u, v| 8.0 * (u - 9.0) / 3.0 - 5.0 * (v - 7.5) / 6.5);
    assert_eq!(send(app.post(&place, nodes.to_string())).await.status, 201);
    format!("{place}/1")
}

#[tokio::test]
async fn stored_requests_have_no_null_members() {
    let app = TestApp::start().await;
    let path = measured(&app).await;
    let text = r#"{ "sensitivity": {"type":"machine", "machine":"form_grinding", "flank":"left"}, "target":null,
        "limits" : {"infeed":null, "helix_angle": {"min":-20.0,"max":null}}, "noise_sigma_um":0.20,"trace": null }"#;
    let rest = r#"{ "sensitivity": {"type":"machine", "machine":"form_grinding", "flank":"left"},
        "limits" : { "helix_angle": {"min":-20.0}}, "noise_sigma_um":0.20 }"#;
    let kept = send(app.post(&format!("{path}/correction"), text)).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    assert_eq!(request_text(&kept.text), rest);
    for query in ["", "?include=nodes"] {
        let stored = send(app.get(&format!("{path}/correction{query}"))).await;
        assert_eq!(request_text(&stored.text), rest, "{query}");
    }
    // likewise other records, whose lists keep their nulls
    for (operation, route, part, name) in [
        ("create_iteration_pitch", "pitch", "", "pitch_limits"),
        ("create_iteration_evaluation", "evaluations", "/evaluation", "level"),
        ("create_iteration_curve", "curves", "", "regularization"),
    ] {
        let request = examples(operation)[0].1.clone();
        let mut posted = request.clone();
        posted.pointer_mut(part).unwrap()[name] = Value::Null;
        let kept = send(app.post(&format!("{path}/{route}"), posted.to_string())).await;
        assert_eq!(kept.status, 201, "{}", kept.text);
        assert_eq!(kept.json()["request"], request);
    }
    app.stop().await;
}

#[tokio::test]
async fn the_short_form_keeps_the_text_of_the_rest() {
    let app = TestApp::start().await;
    let path = measured(&app).await;
    let (matrix, ones) = (sensitivity()["matrix"].to_string(), json!(vec![1.0; 20]).to_string());
    let text = format!(
        r#"{{"noise_sigma_um": 0.20, "weight": {ones}, "target": {{"deviation_um": {ones}}},
        "sensitivity":{{ "type":"matrix","matrix":{matrix}, "settings":["b","a"] }}, "limits": {{"b": {{"min":-9.50}}}} }}"#
    );
    let short = r#"{"noise_sigma_um": 0.20,
        "sensitivity":{ "type":"matrix", "settings":["b","a"] }, "limits": {"b": {"min":-9.50}} }"#;
    let kept = send(app.post(&format!("{path}/correction"), text.clone())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    assert_eq!(request_text(&kept.text), short);
    assert_eq!(request_text(&send(app.get(&format!("{path}/correction"))).await.text), short);
    let whole = send(app.get(&format!("{path}/correction?include=nodes"))).await;
    assert_eq!(request_text(&whole.text), text);
    // a request without such lists is the same with and without them
    let by_name = r#"{"target": "nominal",
        "sensitivity": {"type":"machine", "machine":"form_grinding", "flank":"left"}}"#;
    assert_eq!(send(app.post(&format!("{path}/correction"), by_name)).await.status, 201);
    for query in ["", "?include=nodes"] {
        assert_eq!(request_text(&send(app.get(&format!("{path}/correction{query}"))).await.text), by_name);
    }
    app.stop().await;
}
