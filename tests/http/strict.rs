//! Unknown fields are refused, and `null` counts as absent, in every field of every example.

use flankfit::{api::examples::REQUEST_EXAMPLES, http::openapi::openapi_json};
use reqwest::Method;
use serde_json::{Value, json};

use crate::harness::{Answer, TestApp, send};

/// A job with an iteration and an open stream, and where requests of every operation go.
struct Places {
    document: Value,
    job: String,
    stream: String,
    key: String,
}

impl Places {
    async fn make(app: &TestApp) -> Self {
        let example = |name: &str| REQUEST_EXAMPLES.iter().find(|example| example.name == name).unwrap().text;
        let job = send(app.post("/v1/jobs", example("job"))).await.header("location").to_owned();
        let iterations = format!("{job}/iterations");
        assert_eq!(send(app.post(&iterations, example("iteration"))).await.status, 201);
        for (place, name) in [
            (format!("{iterations}/1/correction"), "iteration_correction"),
            (format!("{job}/correction"), "gear_correction"),
        ] {
            let correction = send(app.post(&place, example(name))).await;
            assert_eq!(correction.status, 201, "{}", correction.text);
        }
        let stream = send(app.post(&format!("{job}/streams"), example("stream"))).await;
        assert_eq!(stream.status, 201, "{}", stream.text);
        let id = |place: &str| place.rsplit('/').next().unwrap().to_owned();
        let document = serde_json::from_str(openapi_json()).unwrap();
        let key = send(app.post("/v1/keys", example("key"))).await;
        let (stream, key) = (id(stream.header("location")), id(key.header("location")));
        Places { document, job: id(&job), stream, key }
    }

    /// Method and path of an operation.
    fn of(&self, operation_id: &str) -> (Method, String) {
        for (path, item) in self.document["paths"].as_object().unwrap() {
            for (method, operation) in item.as_object().unwrap() {
                if operation["operationId"] == operation_id {
                    let path = path.replace("{job_id}", &self.job).replace("{number}", "1");
                    let path = path.replace("{stream_id}", &self.stream).replace("{key_id}", &self.key);
                    return (method.to_uppercase().parse().unwrap(), path);
                }
            }
        }
        panic!("{operation_id}");
    }
}

/// The pointer of every object of a value.
fn objects(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(fields) => {
            found.push(at.to_owned());
            for (key, value) in fields {
                objects(value, &format!("{at}/{key}"), found);
            }
        }
        Value::Array(entries) => {
            for (i, value) in entries.iter().enumerate() {
                objects(value, &format!("{at}/{i}"), found);
            }
        }
        _ => {}
    }
}

async fn sent(app: &TestApp, (method, path): &(Method, String), body: &Value) -> Answer {
    let request = app.client.request(method.clone(), app.url(path)).header("content-type", "application/json");
    send(request.body(body.to_string())).await
}

/// Returns the verdict on a request: status and errors. Accepted requests may return a file.
fn verdict(answer: &Answer) -> (u16, Vec<Value>) {
    let status = answer.status.as_u16();
    if status < 300 {
        return (status, Vec::new());
    }
    (status, answer.json()["errors"].as_array().cloned().unwrap_or_default())
}

#[tokio::test]
async fn a_field_that_is_null_is_absent() {
    // each variant is sent to its own server: a tenant can be created, and a key rotated, only once
    let (app, other) = (TestApp::start().await, TestApp::start().await);
    let (places, other_places) = (Places::make(&app).await, Places::make(&other).await);
    let (mut taken, mut refused) = (0, 0);
    for example in REQUEST_EXAMPLES {
        let (place, other_place) = (places.of(example.operation_id), other_places.of(example.operation_id));
        let whole: Value = serde_json::from_str(example.text).unwrap();
        let mut found = Vec::new();
        objects(&whole, "", &mut found);
        for object in found {
            let keys: Vec<String> = whole.pointer(&object).unwrap().as_object().unwrap().keys().cloned().collect();
            for key in keys {
                let mut body = whole.clone();
                body.pointer_mut(&object).unwrap()[&key] = Value::Null;
                let null = verdict(&sent(&app, &place, &body).await);
                body.pointer_mut(&object).unwrap().as_object_mut().unwrap().remove(&key);
                let absent = verdict(&sent(&other, &other_place, &body).await);
                // a required field of a union's variant that is null is refused at the variant
                assert_eq!(null.0, absent.0, "{} {object}/{key}: {null:?} {absent:?}", example.name);
                *if null.0 < 300 { &mut taken } else { &mut refused } += 1;
            }
        }
    }
    // required fields count as missing
    assert!(taken > 150 && refused > 150, "{taken} {refused}");
    app.stop().await;
    other.stop().await;
}

/// Objects whose member names are not fields of the interface: the caller's own names, or a
/// machine's settings.
const MAPS: [&str; 5] = [
    "job/tags",
    "iteration_correction/limits",
    "applied_changes/settings",
    "gear_correction/limits",
    "gear_applied_changes/settings",
];

#[tokio::test]
async fn every_field_that_is_not_known_is_refused() {
    let app = TestApp::start().await;
    let places = Places::make(&app).await;
    for example in REQUEST_EXAMPLES {
        let place = places.of(example.operation_id);
        let whole: Value = serde_json::from_str(example.text).unwrap();
        let mut found = Vec::new();
        objects(&whole, "", &mut found);
        for object in found {
            let mut body = whole.clone();
            // an entry of a map that is null counts as absent, whatever its name
            let is_map = MAPS.contains(&&*format!("{}{object}", example.name));
            for value in [json!(1), Value::Null].into_iter().take(if is_map { 1 } else { 2 }) {
                body.pointer_mut(&object).unwrap()["no_such_field"] = value;
                let answer = sent(&app, &place, &body).await;
                let pointer = format!("{object}/no_such_field");
                assert!(answer.pointers().contains(&pointer), "{} {pointer}: {}", example.name, answer.text);
            }
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn null_changes_nothing_and_clear_clears() {
    let app = TestApp::start().await;
    let job =
        send(app.post("/v1/jobs", r#"{"name":"w","machine":"m","gear":{"teeth":20,"normal_module_mm":1}}"#)).await;
    let place = (Method::PATCH, job.header("location").to_owned());
    let same = sent(&app, &place, &json!({"gear": null, "machine": null, "part_number": "p"})).await.json();
    assert_eq!(
        (&same["gear"]["teeth"], &same["machine"], &same["part_number"]),
        (&20.into(), &"m".into(), &"p".into())
    );
    let refused = sent(&app, &place, &json!({"gear": {"teeth": 20, "normal_module_mm": 2}, "clear": ["gear"]})).await;
    assert_eq!(refused.pointers(), ["/clear/0"]);
    // every entry that cannot be, and what else is wrong
    let body = json!({"machine": "n", "serial_number": "s",
        "gear": {"teeth": 20, "normal_module_mm": 1, "hand": "right", "helix_angle_deg": -5},
                      "clear": ["machine", "serial_number", "part_number", "machine"]});
    let refused = sent(&app, &place, &body).await;
    let mut pointers = refused.pointers();
    pointers.sort_unstable();
    assert_eq!(pointers, ["/clear/0", "/clear/1", "/clear/3", "/gear/hand"]);
    assert!(refused.text.contains("`machine` is given a value at the same time"), "{}", refused.text);
    let cleared = sent(&app, &place, &json!({"clear": ["gear", "machine"]})).await;
    assert_eq!((cleared.json().get("gear"), cleared.json().get("machine")), (None, None));
    app.stop().await;
}

#[tokio::test]
async fn heights_that_were_not_measured_pass() {
    let app = TestApp::start().await;
    let grid = json!({"nodes": {"type": "grid", "u": [0, 1, 2], "v": [0, 1], "z": [[1, 2], [null, 4], [5, 6]]},
                      "model": {"type": "polynomial", "degree": 1}});
    assert_eq!(app.fit(&grid.to_string()).await.status, 200);
    app.stop().await;
}

/// An error within the first of two fields of a name does not hide that there are two.
#[tokio::test]
async fn repeated_fields_are_reported_with_other_errors() {
    let app = TestApp::start().await;
    let trace = r#"{"flank":"left","kind":"helix","tooth":1,"z_mm":[1,2,3],"deviation_um":[]}"#;
    let gear = r#""gear":{"teeth":20,"normal_module_mm":2,"face_width_mm":20}"#;
    let body = format!(r#"{{{gear},"traces":[{trace}],"traces":[]}}"#);
    let answer = send(app.post("/v1/gears/evaluate", body)).await;
    assert_eq!(answer.pointers(), ["/traces/0/tooth", "/traces", "/evaluation"]);
    assert!(answer.text.contains("occurs twice"), "{}", answer.text);
    app.stop().await;
}

/// Every wrong entry of an array is named, by its index.
#[tokio::test]
async fn every_entry_is_named() {
    let app = TestApp::start().await;
    let fit = |more: &str| {
        let nodes = r#"{"type":"curve","x":[0,1,2],"y":[1,2,4]}"#;
        format!(r#"{{"nodes":{nodes},"model":{{"type":"polynomial","degree":1}},{more}}}"#)
    };
    let include = fit(r#""include":["residual","residuals",5,"matrix_b","all"]"#);
    assert_eq!(app.fit(&include).await.pointers(), ["/include/0", "/include/2", "/include/4"]);
    let job = send(app.post("/v1/jobs", r#"{"name":"w"}"#)).await.header("location").to_owned();
    let said = fit(r#""operator":7,"note":"","measured_at":"today","flank":"up","axes":{"x":{"unit":1},"w":{}}"#);
    let mut pointers = send(app.post(&format!("{job}/iterations"), said)).await.pointers();
    pointers.sort_unstable();
    let axes = ["/axes/w", "/axes/x/quantity", "/axes/x/unit"];
    assert_eq!(pointers, [&axes[..], &["/flank", "/measured_at", "/note", "/operator"]].concat());
    let surface = r#"{"surface":{"type":"bezier","control_points":[[[0,0,0],[0,1,0]],[[1,0,0],[1,1,1]]]},"at":[[0,0]],
                      "include":["area","all","normals",1]}"#;
    let pointers = send(app.post("/v1/surfaces/evaluate", surface)).await.pointers();
    assert!(pointers.contains(&"/include/1".into()) && pointers.contains(&"/include/3".into()), "{pointers:?}");
    app.stop().await;
}

/// A field that is not known in a part does not hide what else is wrong there.
#[tokio::test]
async fn a_misspelt_field_does_not_hide_other_errors() {
    let app = TestApp::start().await;
    let curve = r#"{"points":{"x":[0,1,"2"],"y":[0,null,1],"z":[1]},"method":{"type":"newton"},"regularisation":1}"#;
    let mut pointers = send(app.post("/v1/curves", curve)).await.pointers();
    pointers.sort_unstable();
    assert_eq!(pointers, ["/points/x/2", "/points/y/1", "/points/z", "/regularisation"]);
    app.stop().await;
}

/// Two entries of one name in a map are refused.
#[tokio::test]
async fn a_key_of_a_map_occurs_once() {
    let app = TestApp::start().await;
    let answer = send(app.post("/v1/jobs", r#"{"name": "a", "tags": {"a": "1", "a": "2"}}"#)).await;
    assert!(answer.text.contains("occurs twice"), "{}", answer.text);
    assert_eq!(answer.pointers(), ["/tags/a"]);
    let example = include_str!("../../examples/requests/iteration_correction.json");
    let limits = r#""limits": {"twice": {"min": -1}, "twice": {"min": -20},"#;
    let job = send(app.post("/v1/jobs", r#"{"name": "a"}"#)).await.json();
    let iterations = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let made = send(app.post(&iterations, include_str!("../../examples/requests/iteration.json"))).await;
    assert_eq!(made.status, 201);
    let path = format!("{iterations}/1/correction");
    let answer = send(app.post(&path, example.replacen(r#""limits": {"#, limits, 1))).await;
    assert!(answer.text.contains("occurs twice"), "{}", answer.text);
    app.stop().await;
}

/// Every error of a body is found once, whatever else is wrong around it.
#[tokio::test]
async fn every_error_is_found_once() {
    let app = TestApp::start().await;
    let motion = |text: &str| format!(r#"{{"tool":{{"points":[]}},"motion":{text},"radius_range_mm":[1,2]}}"#);
    let many: String = (0..500).map(|i| format!(r#","k{i}":1"#)).collect();
    let long = format!(r#"{{"name":1,"gear":2,"machine":"{}"}}"#, "x".repeat(100_000));
    let job = |text: &str| ("/v1/jobs", text.to_owned());
    for ((path, body), expected) in [
        (
            job(r#"{"gear":{},"tags":{"a":1,"b":"x","c":2}}"#),
            &["gear/normal_module_mm", "gear/teeth", "name", "tags/a", "tags/c"][..],
        ),
        (job(r#"{"name":"w","name":"v","gear":7}"#), &["gear", "name"]),
        // the first of two may be wrong by itself
        (job(r#"{"name":5,"name":"v","gear":7}"#), &["gear", "name", "name"]),
        (job(r#"{"gear":{"teeth":0,"teeth":20,"normal_module_mm":1}}"#), &["gear/teeth", "gear/teeth", "name"]),
        (
            job(r#"{"name":1,"tags":{"a":[1]},"gear":{"teeth":[]}}"#),
            &["gear/normal_module_mm", "gear/teeth", "name", "tags/a"],
        ),
        (job(&long), &["gear", "machine", "name"]),
        (("/v1/gears/envelope", motion("{}")), &["motion/type"]),
        // fields of a union of which nobody knows which one it is are not called unknown
        (("/v1/gears/envelope", motion(r#"{"pitch_radius_mm":26,"internal":true}"#)), &["motion/type"]),
        (("/v1/gears/envelope", motion(r#"{"type":"worm","pitch_radius_mm":26}"#)), &["motion/type"]),
        (("/v1/gears/envelope", motion(r#"{"type":["rack"],"pitch_radius_mm":26}"#)), &["motion/type"]),
        (("/v1/gears/envelope", motion(r#"{"type":"rack"}"#)), &["motion/pitch_radius_mm"]),
        (("/v1/gears/envelope", motion(r#"["rack",26]"#)), &["motion"]),
    ] {
        let mut found = send(app.post(path, body.clone())).await.pointers();
        found.sort_unstable();
        assert_eq!(found, expected.iter().map(|name| format!("/{name}")).collect::<Vec<_>>(), "{body}");
    }
    assert_eq!(send(app.post("/v1/jobs", format!(r#"{{"name":1{many}}}"#))).await.pointers().len(), 100);
    app.stop().await;
}
