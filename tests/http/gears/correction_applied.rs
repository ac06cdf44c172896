//! The changes that were entered on the machine, and the comparison with the next measurement.

use serde_json::{Value, json};

use super::{import::job, spur};
use crate::harness::{Answer, TestApp, send};

const U: [f64; 6] = [6.0, 7.2, 8.4, 9.6, 10.8, 12.0];
const V: [f64; 7] = [1.0, 3.2, 5.4, 7.5, 9.6, 11.8, 14.0];
const NAMES: [&str; 4] = ["profile_angle", "helix_angle", "profile_crowning", "helix_crowning"];

/// Places from −1 to 1.
fn unit(u: f64, v: f64) -> (f64, f64) {
    ((u - 9.0) / 3.0, (v - 7.5) / 6.5)
}

/// Returns the effect of a unit of each setting on a node.
fn effects(u: f64, v: f64) -> [f64; 4] {
    let (u, v) = unit(u, v);
    [u, v, -u * u, -v * v]
}

/// Returns a flank with form deviations that differ between measurements, after the settings were
/// changed by `changed`.
fn flank(turn: f64, changed: [f64; 4]) -> Value {
    let height = |u: f64, v: f64| {
        let (x, y) = unit(u, v);
        let moved: f64 = effects(u, v).iter().zip(changed).map(|(effect, by)| effect * by).sum();
        8.6 * x - 12.2 * y - 3.7 * x * x - 5.5 * y * y + moved + 0.2 * (17.0 * x + 29.0 * y + turn).sin()
    };
    let rows: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| height(*u, *v)).collect()).collect();
    json!({"nodes": {"type": "grid", "u": U, "v": V, "z": rows},
           "model": {"type": "polynomial", "degree": 2, "terms": "total"}, "flank": "left"})
}

fn asked() -> Value {
    let rows: Vec<[f64; 4]> = U.iter().flat_map(|u| V.iter().map(|v| effects(*u, *v))).collect();
    json!({"sensitivity": {"type": "matrix", "settings": NAMES, "units": ["um", "um", "um", "um"], "matrix": rows},
           "noise_sigma_um": 0.2, "absolute": false})
}

async fn post(app: &TestApp, path: &str, body: &Value) -> Answer {
    send(app.post(path, body.to_string())).await
}

async fn kept(app: &TestApp, job: &str) -> Value {
    send(app.get(&format!("{job}/iterations/1/correction?include=nodes"))).await.json()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// Creates a measured and corrected job; returns it with the proposed changes.
async fn corrected(app: &TestApp) -> (String, [f64; 4]) {
    let job = job(app, Some(spur())).await;
    assert_eq!(post(app, &format!("{job}/iterations"), &flank(0.0, [0.0; 4])).await.status, 201);
    let made = post(app, &format!("{job}/iterations/1/correction"), &asked()).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let made = &made.json()["result"];
    let change = [0, 1, 2, 3].map(|j: usize| number(&made["settings"][j]["change"]));
    (job, change)
}

/// The helix crowning was forgotten, then everything: the response says so as far as the noise
/// allows.
#[tokio::test]
async fn a_forgotten_change_is_named_and_a_machine_that_did_nothing_is_found() {
    let app = TestApp::start().await;
    let (job, change) = corrected(&app).await;
    let entered = [change[0], change[1], change[2], 0.0];
    assert_eq!(post(&app, &format!("{job}/iterations"), &flank(2.0, entered)).await.status, 201);
    let answer = kept(&app, &job).await["answer"].take();
    assert_eq!((&answer["verdict"], &answer["not_entered"][0]["setting"]), (&json!("different"), &json!(NAMES[3])));
    assert_eq!(answer["not_entered"].as_array().unwrap().len(), 1);
    assert!(number(&answer["not_entered"][0]["response_ratio"]).abs() < 0.2, "{answer}");
    let sentence = answer["sentence"].as_str().unwrap();
    assert!(sentence.starts_with("The machine responded as if `helix_crowning` had not been changed:"), "{sentence}");
    // the entry of it settles the matter
    let path = format!("{job}/iterations/1/correction/applied");
    assert_eq!(post(&app, &path, &json!({"settings": {"helix_crowning": 0}})).await.status, 201);
    let answer = kept(&app, &job).await["answer"].take();
    assert_eq!((&answer["verdict"], answer.get("not_entered")), (&json!("as_predicted"), None), "{answer}");

    for (sigma, verdict) in [(0.2, "no_response"), (3.0, "no_response"), (9.0, "weaker"), (20.0, "undecided")] {
        let (job, _) = corrected(&app).await;
        let mut asked = asked();
        asked["noise_sigma_um"] = json!(sigma);
        assert_eq!(post(&app, &format!("{job}/iterations/1/correction"), &asked).await.status, 201);
        assert_eq!(post(&app, &format!("{job}/iterations"), &flank(2.0, [0.0; 4])).await.status, 201);
        let answer = kept(&app, &job).await["answer"].take();
        assert_eq!(answer["verdict"], verdict, "{sigma}: {}", answer["sentence"]);
    }
    app.stop().await;
}

/// Only the two angles were entered: the machine's response is judged by these changes, and is
/// correct.
#[tokio::test]
async fn a_machine_is_judged_by_the_entered_changes() {
    let app = TestApp::start().await;
    let (job, change) = corrected(&app).await;
    let entered = [change[0], change[1], 0.0, 0.0];
    assert_eq!(post(&app, &format!("{job}/iterations"), &flank(2.0, entered)).await.status, 201);
    let before = kept(&app, &job).await;
    assert_eq!(before.get("applied"), None);
    assert_ne!(before["answer"]["verdict"], "as_predicted", "{before}");
    let ratio = number(&before["answer"]["response_ratio"]);
    assert!(ratio < 0.96, "without the entry the machine seems weaker: {ratio}");

    let path = format!("{job}/iterations/1/correction/applied");
    let body = json!({"settings": {"profile_crowning": 0, "helix_crowning": 0.0}, "note": "within\ntheir limits"});
    let made = post(&app, &path, &body).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let record = made.json();
    assert_eq!(
        (&record["kind"], &record["method"], &record["request"]["note"]),
        (&json!("applied"), &json!("matrix"), &body["note"])
    );
    assert_eq!((&record["result"]["correction_id"], &record["result"]["iteration"]), (&before["id"], &json!(1)));
    let place = made.header("location").to_owned();
    assert_eq!(send(app.get(&place)).await.json(), record);

    let after = kept(&app, &job).await;
    let applied = &after["applied"];
    assert_eq!(
        (&applied["id"], &applied["created_at"], &applied["note"]),
        (&record["id"], &record["created_at"], &body["note"])
    );
    for (j, setting) in applied["settings"].as_array().unwrap().iter().enumerate() {
        assert_eq!((&setting["name"], &setting["unit"]), (&json!(NAMES[j]), &json!("um")));
        assert_eq!((number(&setting["change"]), number(&setting["proposed"])), (entered[j], change[j]));
    }
    let answer = &after["answer"];
    assert_eq!(answer["verdict"], "as_predicted", "{answer}");
    assert!((number(&answer["response_ratio"]) - 1.0).abs() < 0.01, "{answer}");
    assert!(
        number(&answer["rms_difference_um"]) < 0.3
            && number(&answer["chi_squared"]) < number(&answer["chi_squared_limit"])
    );
    // the correction itself and its prediction stay unchanged
    assert_eq!((&after["result"], &after["request"]), (&before["result"], &before["request"]));
    let nodes = answer["predicted_um"].as_array().unwrap();
    let first = effects(U[0], V[0]);
    let moved: f64 = first.iter().zip(entered).map(|(effect, by)| effect * by).sum();
    let nominal: f64 = first.iter().zip(change).map(|(effect, by)| effect * by).sum();
    let proposed = number(&before["answer"]["predicted_um"][0]);
    let mean = |by: [f64; 4]| {
        let places = U.iter().flat_map(|u| V.iter().map(|v| effects(*u, *v)));
        places.map(|e| e.iter().zip(by).map(|(a, b)| a * b).sum::<f64>()).sum::<f64>() / 42.0
    };
    let expected = proposed + (moved - mean(entered)) - (nominal - mean(change));
    assert!((number(&nodes[0]) - expected).abs() < 1e-9);

    // later entries take precedence, and earlier ones stay in the trace
    let again = json!({"settings": {"profile_crowning": change[2], "helix_crowning": change[3]}});
    assert_eq!(post(&app, &path, &again).await.status, 201);
    let last = kept(&app, &job).await;
    assert_eq!(last["applied"]["settings"][2]["change"], change[2]);
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    let kinds: Vec<&Value> = trace["iterations"][0]["records"].as_array().unwrap().iter().map(|r| &r["kind"]).collect();
    assert_eq!(kinds, ["correction", "applied", "applied"]);
    // an entry equal to the proposal gives the same comparison as none, to the last bit
    assert_eq!(last["answer"].to_string(), before["answer"].to_string());

    // an entry belongs to the correction that was the newest at the time
    assert_eq!(post(&app, &format!("{job}/iterations/1/correction"), &asked()).await.status, 201);
    assert_eq!(kept(&app, &job).await.get("applied"), None);
    app.stop().await;
}

#[tokio::test]
async fn entered_changes_may_come_with_the_next_measurement() {
    let app = TestApp::start().await;
    let (job, change) = corrected(&app).await;
    let place = format!("{job}/iterations");
    let entered = [change[0], change[1], 0.0, 0.0];
    let mut next = flank(2.0, entered);
    next["applied"] = json!({"settings": {"profile_crowning": 0, "twist": 1}});
    let refused = post(&app, &place, &next).await;
    assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec!["/applied/settings/twist".to_owned()]));
    for (applied, pointer) in [
        (json!({"settings": {"profile_crowning": 1e13}}), "/applied/settings/profile_crowning"),
        (json!({"settings": {"profile_crowning": "0"}}), "/applied/settings/profile_crowning"),
        (json!({"settings": []}), "/applied/settings"),
        (json!({"note": "n"}), "/applied/settings"),
        (json!({"settings": {}, "who": "me"}), "/applied/who"),
        (json!({"settings": {}, "note": " "}), "/applied/note"),
    ] {
        next["applied"] = applied;
        let refused = post(&app, &place, &next).await;
        assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec![pointer.to_owned()]), "{}", refused.text);
    }
    // a flank that was not corrected
    next["applied"] = json!({"settings": {"profile_crowning": 0, "helix_crowning": 0}, "note": "rightly"});
    next["flank"] = json!("right");
    let refused = post(&app, &place, &next).await;
    assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec!["/applied".to_owned()]));
    assert!(refused.text.contains("no earlier iteration of the right flank"), "{}", refused.text);
    assert_eq!(send(app.get(&place)).await.json()["items"].as_array().unwrap().len(), 1, "nothing was stored");

    next["flank"] = json!("left");
    let made = post(&app, &place, &next).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let found = kept(&app, &job).await;
    assert_eq!((&found["applied"]["note"], &found["answer"]["verdict"]), (&json!("rightly"), &json!("as_predicted")));
    let records = send(app.get(&format!("{place}/2/records"))).await.json();
    assert_eq!(
        (&records["items"][0]["kind"], &records["items"][0]["id"]),
        (&json!("applied"), &found["applied"]["id"])
    );
    // iteration 2 was measured and not corrected
    next["applied"] = json!({"settings": {}});
    let refused = post(&app, &place, &next).await;
    assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec!["/applied".to_owned()]));
    assert!(refused.text.contains("iteration 2"), "{}", refused.text);
    let missing = post(&app, &format!("{place}/2/correction/applied"), &json!({"settings": {}})).await;
    assert_eq!(missing.status, 404, "{}", missing.text);
    assert!(missing.text.contains("Iteration 2 has no correction"), "{}", missing.text);
    // an entry for iteration 2's own correction does not affect the first one
    assert_eq!(post(&app, &format!("{place}/2/correction"), &asked()).await.status, 201);
    assert_eq!(post(&app, &format!("{place}/2/correction/applied"), &json!({"settings": {}})).await.status, 201);
    assert_eq!(kept(&app, &job).await["applied"], found["applied"]);
    // a later entry at the corrected iteration replaces that of the next
    let later = json!({"settings": {"profile_crowning": 0, "helix_crowning": 0}, "note": "put right"});
    assert_eq!(post(&app, &format!("{place}/1/correction/applied"), &later).await.status, 201);
    assert_eq!(kept(&app, &job).await["applied"]["note"], "put right");
    app.stop().await;
}

#[tokio::test]
async fn wrong_entries_are_refused_at_their_places() {
    let app = TestApp::start().await;
    let (job, _) = corrected(&app).await;
    let path = format!("{job}/iterations/1/correction/applied");
    for (body, pointers) in [
        (json!({"settings": {"profil_angle": 1.0, "a/b": 2.0}}), vec!["/settings/a~1b", "/settings/profil_angle"]),
        (json!({"settings": {"helix_angle": -2e12}}), vec!["/settings/helix_angle"]),
        (json!({}), vec!["/settings"]),
    ] {
        let refused = post(&app, &path, &body).await;
        assert_eq!(
            (refused.status.as_u16(), refused.pointers()),
            (422, pointers.iter().map(ToString::to_string).collect())
        );
    }
    let refused = post(&app, &path, &json!({"settings": {"profil_angle": 1.0}})).await;
    assert!(refused.text.contains("it has `profile_angle`, `helix_angle`, `profile_crowning`"), "{}", refused.text);
    let absent = post(&app, &format!("{job}/iterations/7/correction/applied"), &json!({"settings": {}})).await;
    assert_eq!(absent.status, 404, "{}", absent.text);
    // the same key and body make one entry
    let once =
        async || send(app.post(&path, json!({"settings": {}}).to_string()).header("idempotency-key", "k")).await.json();
    let first = once().await;
    assert_eq!(once().await, first);
    let records = send(app.get(&format!("{job}/iterations/1/records"))).await.json();
    assert_eq!(records["items"].as_array().unwrap().len(), 2);
    app.stop().await;
}
