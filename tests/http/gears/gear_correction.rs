//! Corrections of the gear: means over teeth, both flanks by one set of settings, and the next
//! round.

use serde_json::{Value, json};

use super::{fit_figures::axes, import::job, pointers, spur};
use crate::harness::{Answer, TestApp, send};

const U: [f64; 4] = [6.0, 8.0, 10.0, 12.0];
const V: [f64; 5] = [1.0, 4.0, 7.5, 11.0, 14.0];

/// Deviations of a tooth by place.
type Shape<'a> = &'a dyn Fn(f64, f64) -> f64;

/// Coordinates from −1 to 1.
fn unit(u: f64, v: f64) -> [f64; 2] {
    [(u - 9.0) / 3.0, (v - 7.5) / 6.5]
}

/// A profile angle and a helix angle that are off, with what a tooth has of its own and a form that
/// no two teeth have in common.
fn shape(flank: &str, own: f64, turn: f64) -> impl Fn(f64, f64) -> f64 {
    let side = if flank == "left" { 1.0 } else { -1.0 };
    move |u, v| {
        let [x, y] = unit(u, v);
        6.0 * x + side * (9.0 + own) * y + 0.2 * (17.0 * x + 29.0 * y + turn).sin()
    }
}

fn grid(rows: &[f64], columns: &[f64], of: Shape<'_>) -> Value {
    let z: Vec<Vec<f64>> = rows.iter().map(|u| columns.iter().map(|v| of(*u, *v)).collect()).collect();
    json!({"type": "grid", "u": rows, "v": columns, "z": z})
}

fn iteration(flank: &str, tooth: &str, of: Shape<'_>) -> Value {
    json!({"nodes": grid(&U, &V, of), "axes": axes(), "flank": flank, "tooth": tooth,
        "model": {"type": "polynomial", "degree": 2, "terms": "total"}})
}

async fn post(app: &TestApp, path: &str, body: &Value) -> Answer {
    send(app.post(path, body.to_string())).await
}

async fn made(app: &TestApp, path: &str, body: &Value) -> Value {
    let answer = post(app, path, body).await;
    assert_eq!(answer.status, 201, "{path}: {}", answer.text);
    answer.json()
}

/// The result of a correction.
async fn corrected(app: &TestApp, path: &str, body: &Value) -> Value {
    made(app, path, body).await["result"].take()
}

async fn measure(app: &TestApp, job: &str, flank: &str, tooth: &str, of: Shape<'_>) {
    made(app, &format!("{job}/iterations"), &iteration(flank, tooth, of)).await;
}

/// A job with two teeth on both flanks, whose helices differ by what the numbers say.
async fn two_teeth(app: &TestApp, own: [f64; 2]) -> String {
    let job = job(app, Some(spur())).await;
    for (flank, turn) in [("left", 0.0), ("right", 1.0)] {
        for (tooth, own) in own.into_iter().enumerate() {
            let name = (26 * tooth + 1).to_string();
            measure(app, &job, flank, &name, &shape(flank, own, turn + 2.0 * tooth as f64)).await;
        }
    }
    job
}

fn asked() -> Value {
    json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2})
}

fn setting<'a>(correction: &'a Value, name: &str) -> &'a Value {
    let settings = correction["settings"].as_array().unwrap();
    settings.iter().find(|setting| setting["name"] == name).unwrap_or_else(|| panic!("{name}: {correction}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

fn codes(correction: &Value) -> Vec<&str> {
    correction["warnings"].as_array().unwrap().iter().map(|warning| warning["code"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn both_flanks_are_corrected_by_the_mean_over_their_teeth() {
    let app = TestApp::start().await;
    let job = two_teeth(&app, [2.0, -2.0]).await;
    let patch = json!({"requirements": {"tolerance_limits": {"helix_slope_um": [-8, 8]}}});
    assert_eq!(send(app.client.patch(app.url(&job)).json(&patch)).await.status, 200);
    let path = format!("{job}/correction");
    assert_eq!(send(app.get(&path)).await.status, 404);
    let mut body = asked();
    body["include"] = json!(["nodes"]);
    body["settings_used"] = json!("all");
    let answer = post(&app, &path, &body).await;
    assert_eq!(answer.status, 201, "{}", answer.text);
    let (posted, place) = (answer.json(), answer.header("location").to_owned());
    let correction = &posted["result"];
    assert!(place.starts_with(&format!("{job}/iterations/4/records/")), "{place}");
    assert_eq!((&correction["iterations"], &correction["flanks"]), (&json!([1, 2, 3, 4]), &json!(["left", "right"])));
    let left = &correction["teeth"]["left"];
    assert_eq!((&left["iterations"], &left["teeth"]), (&json!([2, 1]), &json!(["27", "1"])));
    // helices of 9 ± 2 µm over the nodes: s is 2 √2 times the root mean square of y
    let y = V.map(|v| unit(0.0, v)[1]);
    let rms = (y.map(|y| y * y).iter().sum::<f64>() / 5.0).sqrt();
    let spread = number(&left["spread_um"]);
    assert!((spread / (8f64.sqrt() * rms) - 1.0).abs() < 0.05, "{spread} {rms}");
    assert!((number(&left["std_error_um"]) - spread / 2f64.sqrt()).abs() < 1e-9, "{left}");
    assert_eq!(correction["settings"].as_array().unwrap().len(), 7, "both flanks have the same settings");
    assert_eq!(codes(correction).iter().filter(|code| code.contains("tooth") || code.contains("flank_not")).count(), 0);
    let predicted = &correction["predicted"];
    assert!(number(&predicted["rms_um"]) < 0.1 * number(&predicted["rms_before_um"]), "{predicted}");
    assert_eq!(predicted["deviation_um"].as_array().unwrap().len(), 40);
    for side in ["left", "right"] {
        let figure = &correction["figures"][side]["helix_slope_um"];
        assert_eq!(figure["limits"], json!([-8.0, 8.0]));
        assert!(figure["conformity_before"].is_object() && figure["conformity_predicted"].is_object(), "{figure}");
        assert!(number(&figure["predicted"]).abs() < 1.0 && number(&figure["before"]).abs() > 15.0, "{figure}");
    }

    // the same teeth without what each has of its own: the same changes, known better
    let alike = two_teeth(&app, [0.0, 0.0]).await;
    let other = corrected(&app, &format!("{alike}/correction"), &asked()).await;
    let [one, two] = [correction, &other].map(|made| setting(made, "helix_angle"));
    assert!((number(&one["change"]) / number(&two["change"]) - 1.0).abs() < 1e-3, "{one} {two}");
    assert!(number(&one["std_error"]) > 5.0 * number(&two["std_error"]), "{one} {two}");
    // as for one flank alone
    let single = corrected(&app, &format!("{alike}/iterations/1/correction"), &asked()).await;
    assert!((number(&setting(&single, "helix_angle")["change"]) / number(&two["change"]) - 1.0).abs() < 0.02);

    // kept with the last iteration, and found there and in the trace
    let kept = send(app.get(&format!("{path}?include=nodes"))).await.json();
    assert_eq!(kept, posted, "one shape");
    assert_eq!((&kept["request"], kept.get("answer"), kept.get("not_compared")), (&body, None, None));
    let record = send(app.get(&place)).await.json();
    assert_eq!((&record["kind"], &record["id"]), (&json!("gear_correction"), &posted["id"]));
    assert_eq!(record["result"]["target"].get("deviation_um"), None, "only when included");
    let trace = send(app.get(&format!("{job}/trace"))).await.json();
    assert_eq!(trace["iterations"][3]["records"][0]["kind"], "gear_correction");
    // once more, before anything was measured: for the same iterations
    let again = made(&app, &path, &asked()).await;
    assert_eq!(again["result"]["iterations"], json!([1, 2, 3, 4]));
    assert_eq!(send(app.get(&path)).await.json()["id"], again["id"]);
    app.stop().await;
}

#[tokio::test]
async fn teeth_are_chosen_and_one_is_a_warning() {
    let app = TestApp::start().await;
    let job = two_teeth(&app, [1.0, -1.0]).await;
    let path = format!("{job}/correction");
    let mut body = asked();
    body["teeth"] = json!(["27"]);
    let one = corrected(&app, &path, &body).await;
    assert_eq!((&one["iterations"], codes(&one).contains(&"one_tooth")), (&json!([2, 4]), true));
    assert_eq!(one["teeth"]["left"].get("spread_um"), None);
    assert!(one["warnings"].to_string().contains("the spread between teeth is not known"), "{}", one["warnings"]);
    let both = corrected(&app, &path, &asked()).await;
    assert!(!codes(&both).contains(&"one_tooth"));
    for (teeth, pointer) in [(json!(["1", "9"]), "/teeth/1"), (json!([]), "/teeth"), (json!("1"), "/teeth")] {
        body["teeth"] = teeth;
        assert_eq!(pointers(&app, &path, &body).await, [pointer]);
    }
    body["teeth"] = json!(["9"]);
    assert!(post(&app, &path, &body).await.text.contains("measured were `1`, `27`"));
    assert_eq!(pointers(&app, &format!("{job}/iterations/1/correction"), &body).await, ["/teeth"]);
    body["teeth"] = Value::Null;
    assert_eq!(corrected(&app, &path, &body).await["iterations"], json!([1, 2, 3, 4]), "null counts as absent");
    // the newest iteration of a tooth counts, and one flank alone is said
    let other = job_of_left_teeth(&app).await;
    let left = corrected(&app, &format!("{other}/correction"), &asked()).await;
    assert_eq!((&left["iterations"], &left["flanks"]), (&json!([2, 3, 4]), &json!(["left"])));
    assert!(codes(&left).contains(&"flank_not_measured"), "{}", left["warnings"]);
    app.stop().await;
}

/// Three teeth of a left flank, the first of them measured twice, the last on another grid.
async fn job_of_left_teeth(app: &TestApp) -> String {
    let job = job(app, Some(spur())).await;
    measure(app, &job, "left", "1", &|_, _| 50.0 * f64::from(u8::MAX)).await;
    for tooth in ["1", "2"] {
        measure(app, &job, "left", tooth, &shape("left", 0.0, 0.0)).await;
    }
    let mut other = iteration("left", "3", &shape("left", 0.0, 0.0));
    other["nodes"] = grid(&[6.5, 8.5, 10.0, 11.5], &[2.0, 5.0, 9.0, 13.0], &shape("left", 0.0, 0.0));
    made(app, &format!("{job}/iterations"), &other).await;
    job
}

#[tokio::test]
async fn settings_of_one_flank_are_named_by_it() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    for (flank, slope) in [("left", 8.0), ("right", -5.0)] {
        for tooth in ["1", "2"] {
            let of = move |u: f64, v: f64| slope * unit(u, v)[0] + 0.2 * (5.0 * u + 3.0 * v).sin();
            measure(&app, &job, flank, tooth, &of).await;
        }
    }
    let mut body = asked();
    body["sensitivity"]["by_flank"] = json!(["profile_angle", "profile_crowning"]);
    body["limits"] = json!({"profile_angle_left": {"max": 100}, "infeed": {"fixed": true}});
    let path = format!("{job}/correction");
    let correction = corrected(&app, &path, &body).await;
    let names: Vec<&str> =
        correction["settings"].as_array().unwrap().iter().map(|setting| setting["name"].as_str().unwrap()).collect();
    let first = ["profile_angle_left", "profile_angle_right", "helix_angle", "profile_crowning_left"];
    assert_eq!((names.len(), &names[..4]), (9, &first[..]));
    let [left, right] =
        ["profile_angle_left", "profile_angle_right"].map(|name| number(&setting(&correction, name)["change"]));
    assert!((left / right + 1.6).abs() < 0.1, "{left} {right}");
    body["sensitivity"]["by_flank"] = json!(["profile_angle", "angle"]);
    assert_eq!(pointers(&app, &path, &body).await, ["/sensitivity/by_flank/1"]);
    // on one flank alone such a setting leaves the other as it is
    body["sensitivity"]["by_flank"] = json!(["profile_angle"]);
    let one = corrected(&app, &format!("{job}/iterations/1/correction"), &body).await;
    let figure = &one["other_flank"]["figures"]["profile_slope_um"];
    assert!(number(&setting(&one, "profile_angle_left")["change"]).abs() > 5.0, "{one}");
    assert!((number(&figure["before"]) - number(&figure["predicted"])).abs() < 0.5, "{figure}");
    app.stop().await;
}

/// The next round, in which the machine did the share `came` of what was proposed.
async fn next_round(app: &TestApp, job: &str, correction: &Value, came: f64) {
    let before = send(app.get(&format!("{job}/iterations/1/nodes"))).await.json();
    assert!(before["z"].is_array(), "{before}");
    let predicted = correction["predicted"]["deviation_um"].as_array().unwrap();
    for (k, (flank, turn)) in [("left", 0.0), ("right", 1.0)].into_iter().enumerate() {
        let of_teeth = [0.0, 2.0].map(|more| shape(flank, 0.0, turn + more));
        for (tooth, name) in ["1", "27"].into_iter().enumerate() {
            let moved = |u: f64, v: f64| {
                let row = U.iter().position(|x| *x == u).unwrap();
                let column = V.iter().position(|x| *x == v).unwrap();
                let mean = 0.5 * (of_teeth[0](u, v) + of_teeth[1](u, v));
                let after = number(&predicted[20 * k + 5 * row + column]);
                shape(flank, 0.0, turn + 2.0 * tooth as f64 + 0.3)(u, v) + came * (after - mean)
            };
            measure(app, job, flank, name, &moved).await;
        }
    }
}

#[tokio::test]
async fn the_next_iterations_are_compared_with_the_entered_changes() {
    let app = TestApp::start().await;
    let job = two_teeth(&app, [0.0, 0.0]).await;
    let path = format!("{job}/correction");
    let applied = format!("{path}/applied");
    assert_eq!(post(&app, &applied, &json!({"settings": {}})).await.status, 404);
    let mut body = asked();
    body["include"] = json!(["nodes"]);
    let posted = made(&app, &path, &body).await;
    let correction = &posted["result"];
    next_round(&app, &job, correction, 0.5).await;
    let kept = send(app.get(&path)).await.json();
    let answer = &kept["answer"];
    assert_eq!((&answer["iteration"], &answer["iterations"]), (&json!(8), &json!([5, 6, 7, 8])), "{kept}");
    assert_eq!(answer["verdict"], "weaker", "{answer}");
    assert!((number(&answer["response_ratio"]) - 0.5).abs() < 0.05, "{answer}");
    assert_eq!((answer.get("figures"), answer.get("figure_changes")), (None, None));

    // half of everything had been entered: the machine did what was entered
    let settings = correction["settings"].as_array().unwrap();
    let half =
        settings.iter().map(|one| (one["name"].as_str().unwrap().to_owned(), json!(0.5 * number(&one["change"]))));
    let entered = json!({"settings": Value::Object(half.collect()), "note": "half of it"});
    let wrong = json!({"settings": {"helix": 1.0}});
    assert_eq!(pointers(&app, &applied, &wrong).await, ["/settings/helix"]);
    let record = made(&app, &applied, &entered).await;
    assert_eq!((&record["kind"], &record["result"]["correction_id"]), (&json!("applied"), &posted["id"]));
    let kept = send(app.get(&format!("{path}?include=nodes"))).await.json();
    assert_eq!((&kept["applied"]["note"], &kept["answer"]["verdict"]), (&json!("half of it"), &json!("as_predicted")));
    assert!((number(&kept["answer"]["response_ratio"]) - 1.0).abs() < 0.1, "{}", kept["answer"]);
    assert_eq!(kept["answer"]["predicted_um"].as_array().unwrap().len(), 40);
    for side in ["left", "right"] {
        let change = &kept["answer"]["flanks"][side]["helix_slope_um"];
        let [low, high] = [0, 1].map(|end: usize| number(&change["difference"]["interval_um"][end]));
        assert!(low <= 0.0 && 0.0 <= high, "{change}");
        assert!(number(&change["change"]["value_um"]).abs() > 5.0, "{change}");
    }
    // a second correction is made for the second round, and comes with the next measurement
    let second = made(&app, &path, &asked()).await;
    assert_eq!(second["result"]["iterations"], json!([5, 6, 7, 8]));
    let mut third = iteration("left", "1", &shape("left", 0.0, 0.0));
    third["applied"] = json!({"settings": {"helix_angle": 0}, "note": "with the measurement"});
    made(&app, &format!("{job}/iterations"), &third).await;
    let kept = send(app.get(&path)).await.json();
    assert_eq!((&kept["id"], &kept["applied"]["note"]), (&second["id"], &json!("with the measurement")));
    assert_eq!(kept["answer"]["iterations"], json!([9]), "{kept}");
    app.stop().await;
}

#[tokio::test]
async fn invalid_corrections_are_refused() {
    let app = TestApp::start().await;
    let empty = job(&app, Some(spur())).await;
    let path = format!("{empty}/correction");
    assert_eq!(pointers(&app, &path, &asked()).await, [""]);
    let mut plain = iteration("left", "1", &shape("left", 0.0, 0.0));
    plain.as_object_mut().unwrap().remove("flank");
    made(&app, &format!("{empty}/iterations"), &plain).await;
    let refused = post(&app, &path, &asked()).await;
    assert!(refused.text.contains("has a flank: send `flank` by `PATCH`"), "{}", refused.text);
    // without axes, and without a gear
    let mut blank = iteration("left", "1", &shape("left", 0.0, 0.0));
    blank.as_object_mut().unwrap().remove("axes");
    made(&app, &format!("{empty}/iterations"), &blank).await;
    assert_eq!(pointers(&app, &path, &asked()).await, ["/sensitivity/machine"]);
    assert!(post(&app, &path, &asked()).await.text.contains("iteration 2: quantity and unit of `u`, `v`, `z`"));
    let bare = job(&app, None).await;
    measure(&app, &bare, "left", "1", &shape("left", 0.0, 0.0)).await;
    let refused = post(&app, &format!("{bare}/correction"), &asked()).await;
    assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec!["/sensitivity/machine".to_owned()]));
    assert!(refused.text.contains("the job has no gear"), "{}", refused.text);
    // units
    let job = two_teeth(&app, [0.0, 0.0]).await;
    measure(&app, &job, "right", "30", &|u, v| 1e-4 * shape("right", 0.0, 0.0)(u, v)).await;
    let path = format!("{job}/correction");
    let refused = post(&app, &path, &asked()).await;
    assert_eq!(
        (refused.status.as_u16(), &refused.json()["code"]),
        (409, &json!("implausible_unit")),
        "{}",
        refused.text
    );
    assert!(refused.json()["detail"].as_str().unwrap().starts_with("Iteration 5: "), "{}", refused.text);
    let mut chosen = asked();
    chosen["teeth"] = json!(["1", "27"]);
    // what belongs to one flank, what nobody knows, and a tooth whose nodes are no surface
    let mut wrong = chosen.clone();
    wrong["sensitivity"]["flank"] = json!("left");
    assert_eq!(pointers(&app, &path, &wrong).await, ["/sensitivity/flank"]);
    wrong = chosen.clone();
    wrong["tooth"] = json!("1");
    assert_eq!(pointers(&app, &path, &wrong).await, ["/tooth"]);
    let mut line = iteration("left", "3", &shape("left", 0.0, 0.0));
    line["nodes"] = grid(&[6.5, 8.5, 10.0, 11.5], &[2.0, 5.0], &shape("left", 0.0, 0.0));
    line["model"] = json!({"type": "polynomial", "degree": 1});
    made(&app, &format!("{job}/iterations"), &line).await;
    chosen["teeth"] = json!(["1", "3", "27"]);
    let refused = post(&app, &path, &chosen).await;
    assert_eq!(refused.pointers(), ["/teeth"], "{}", refused.text);
    assert!(refused.text.contains("iteration 6 has its nodes at other places"), "{}", refused.text);
    chosen["teeth"] = json!(["1", "27"]);
    made(&app, &path, &chosen).await;
    // a tooth that is measured after a correction begins the next round
    measure(&app, &job, "left", "4", &shape("left", 0.0, 0.0)).await;
    assert_eq!(pointers(&app, &path, &chosen).await, ["/teeth/0", "/teeth/1"]);
    app.stop().await;
}

#[tokio::test]
async fn a_control_gets_the_correction_of_the_gear() {
    let app = TestApp::start().await;
    let job = two_teeth(&app, [0.0, 0.0]).await;
    let path = format!("{job}/correction");
    made(&app, &path, &asked()).await;
    let csv = async |path: &str| send(app.client.get(app.url(path)).header("accept", "text/csv")).await;
    let written = csv(&path).await;
    assert_eq!(written.status, 200, "{}", written.text);
    assert!(written.text.contains("both flanks") && written.text.contains("1 2 3 4"), "{}", written.text);
    assert!(written.text.contains("towards the"), "{}", written.text);
    let limits = json!({"requirements": {"tolerance_limits": {"profile_crowning_um": [30, 40]}}});
    assert_eq!(send(app.client.patch(app.url(&job)).json(&limits)).await.status, 200);
    let mut body = asked();
    body["target"] = json!("nominal");
    let outside = corrected(&app, &path, &body).await;
    assert!(codes(&outside).contains(&"predicted_outside_limits"), "{}", outside["warnings"]);
    let refused = csv(&path).await;
    assert_eq!((refused.status.as_u16(), &refused.json()["code"]), (409, &json!("predicted_outside_limits")));
    assert_eq!(csv(&format!("{path}?outside_limits=allowed")).await.status, 200);
    app.stop().await;
}

#[tokio::test]
async fn a_matrix_has_a_row_for_each_node_of_both_flanks() {
    let app = TestApp::start().await;
    let job = two_teeth(&app, [1.0, -1.0]).await;
    let effects = |side: f64| {
        U.iter().flat_map(move |u| V.map(|v| unit(*u, v)).map(|[x, y]| json!([x, side * y]))).collect::<Vec<_>>()
    };
    let matrix: Vec<Value> = [1.0, -1.0].into_iter().flat_map(effects).collect();
    let body = json!({"sensitivity": {"type": "matrix", "settings": ["profile", "helix"], "matrix": matrix}});
    let path = format!("{job}/correction");
    let correction = corrected(&app, &path, &body).await;
    let change = |name: &str| number(&setting(&correction, name)["change"]);
    assert!((change("profile") + 6.0).abs() < 0.2 && (change("helix") + 9.0).abs() < 0.2, "{correction}");
    // s of the helix is √2 µm, over two teeth and both flanks
    let error = number(&setting(&correction, "helix")["std_error"]);
    assert!((0.3..1.2).contains(&error), "{error}");
    let mut short = body.clone();
    short["sensitivity"]["matrix"].as_array_mut().unwrap().pop();
    assert_eq!(pointers(&app, &path, &short).await, ["/sensitivity/matrix"]);
    app.stop().await;
}

#[tokio::test]
async fn a_correction_of_one_flank_predicts_the_other() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    let patch = json!({"requirements": {"tolerance_limits": {"helix_slope_um": [-8, 8]}}});
    assert_eq!(send(app.client.patch(app.url(&job)).json(&patch)).await.status, 200);
    measure(&app, &job, "left", "1", &shape("left", 0.0, 0.0)).await;
    let path = format!("{job}/iterations/1/correction");
    let alone = corrected(&app, &path, &asked()).await;
    assert_eq!((&alone["iterations"], &alone["flanks"]), (&json!([1]), &json!(["left"])));
    let other = &alone["other_flank"];
    assert_eq!((&other["flank"], other.get("iteration"), other.get("figures")), (&json!("right"), None, None));
    assert!(other["not_predicted"].as_str().unwrap().contains("it was not measured"), "{other}");
    measure(&app, &job, "right", "1", &shape("right", 0.0, 0.0)).await;
    let both = corrected(&app, &path, &asked()).await;
    let other = &both["other_flank"];
    assert_eq!((&other["iteration"], other.get("not_predicted")), (&json!(2), None));
    let figure = &other["figures"]["helix_slope_um"];
    assert_eq!(
        (&figure["limits"], &figure["conformity_before"]["verdict"]),
        (&json!([-8.0, 8.0]), &json!("does_not_conform"))
    );
    // the helix angle acts on both, and the right flank has the same error
    assert_eq!(figure["conformity_predicted"]["verdict"], "conforms", "{figure}");
    // a helix error that only the right flank has
    measure(&app, &job, "right", "1", &|u, v| 0.3 * (u + v).sin()).await;
    let worse = corrected(&app, &path, &asked()).await;
    let figure = &worse["other_flank"]["figures"]["helix_slope_um"];
    assert_eq!(
        (&worse["other_flank"]["iteration"], &figure["conformity_predicted"]["verdict"]),
        (&json!(3), &json!("does_not_conform"))
    );
    app.stop().await;
}
