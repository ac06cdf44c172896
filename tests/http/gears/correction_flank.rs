//! Corrections know the flank that was measured, and in what its heights are.

use serde_json::{Value, json};

use super::{
    fit_figures::axes,
    import::{file_of_flank, file_with_zeros, import, job},
    pointers, spur,
};
use crate::{
    harness::{TestApp, send},
    shapes::{close, examples},
};

async fn correct(app: &TestApp, path: &str, body: &Value) -> Value {
    let made = send(app.post(path, body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made.json()["result"].take()
}

fn change(correction: &Value, name: &str) -> f64 {
    let settings = correction["settings"].as_array().unwrap();
    let setting =
        settings.iter().find(|setting| setting["name"] == name).unwrap_or_else(|| panic!("{name}: {correction}"));
    setting["change"].as_f64().unwrap()
}

/// Imports a file whose traces scatter only by their rounding, so that its units must be confirmed;
/// returns the iteration.
async fn imported(app: &TestApp, job: &str, content: Vec<u8>) -> Value {
    let made = import(app, job, content, "1.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let iteration = made.json();
    let path = format!("{job}/iterations/{}", iteration["number"]);
    let patched = send(app.client.patch(app.url(&path)).json(&json!({"accept_units": true}))).await;
    assert_eq!(patched.status, 200, "{}", patched.text);
    iteration
}

/// The file says which flank it is of: nobody has to say it again, and nobody can say otherwise.
#[tokio::test]
async fn an_imported_flank_is_corrected_as_the_flank_that_it_is() {
    let app = TestApp::start().await;
    let mut slopes = Vec::new();
    let mut turns = Vec::new();
    for left in [true, false] {
        let (flank, other) = if left { ("left", "right") } else { ("right", "left") };
        let job = job(&app, Some(spur())).await;
        let iteration = imported(&app, &job, file_of_flank(left, false, |_| true)).await;
        assert_eq!((&iteration["flank"], &iteration["tooth"]), (&json!(flank), &json!("1")));
        let lengths = iteration["axes"]["z"]["trace_lengths"].clone();
        let height =
            json!({"quantity": "deviation", "unit": "um", "positive": "material_out", "trace_lengths": lengths});
        let nodes: u64 = lengths.as_array().unwrap().iter().map(|length| length.as_u64().unwrap()).sum();
        assert_eq!((lengths.as_array().unwrap().len(), iteration["node_count"].as_u64()), (6, Some(nodes)));
        assert_eq!((&iteration["axes"]["u"]["quantity"], &iteration["axes"]["z"]), (&json!("roll_length"), &height));
        let path = format!("{job}/iterations/1/correction");
        let request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
        let made = correct(&app, &path, &request).await;
        let mut said = request.clone();
        said["sensitivity"]["flank"] = json!(flank);
        assert_eq!(correct(&app, &path, &said).await["settings"], made["settings"]);
        let mut wrong = request.clone();
        wrong["sensitivity"]["flank"] = json!(other);
        assert_eq!(pointers(&app, &path, &wrong).await, ["/sensitivity/flank"]);
        let wrong = json!({"sensitivity": {"type": "machine", "machine": "form_grinding", "profile_axis": "diameter"}});
        assert_eq!(pointers(&app, &path, &wrong).await, ["/sensitivity/profile_axis"]);
        // the slope of the material along z, as the nodes hold it: z = a + b u + c v
        let nodes = send(app.get(&format!("{job}/iterations/1/nodes"))).await.json();
        slopes.push(slope(&nodes));
        turns.push(change(&made, "helix_angle"));
    }
    // the same turn of the helix leans the material of the two flanks in opposite ways, so per
    // slope of material it has two signs
    assert!(slopes.iter().all(|slope| slope.abs() > 0.3), "{slopes:?}");
    let [left, right] = [turns[0] / slopes[0], turns[1] / slopes[1]];
    assert!(left * right < 0.0, "{turns:?} {slopes:?}");
    close(left, -right, 1e-3 * left.abs());
    app.stop().await;
}

/// Whatever zeros the traces of a file have: the fit, the correction and its figures are the same;
/// nobody takes their mean for measured.
#[tokio::test]
async fn zeros_of_imported_traces_are_no_deviations() {
    let app = TestApp::start().await;
    let job = job(&app, Some(spur())).await;
    let zero = |k: usize| [4.0, -11.0, 0.5, 7.0, -3.0, 20.0][k];
    let request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
    let (mut coefficients, mut corrections) = (Vec::new(), Vec::new());
    for (number, moved) in [(1, false), (2, true)] {
        let file = file_with_zeros(|_| true, |k| if moved { zero(k) } else { 0.0 });
        let iteration = imported(&app, &job, file).await;
        assert!(iteration["note"].as_str().unwrap().contains("zero"), "{}", iteration["note"]);
        let fit = iteration["fits"][0]["result"]["coefficients"].as_array().unwrap().clone();
        coefficients.push(fit.iter().map(|c| c["least_squares"].as_f64().unwrap()).collect::<Vec<f64>>());
        let path = format!("{job}/iterations/{number}/correction");
        corrections.push(correct(&app, &path, &request).await);
        // with a matrix too there is no datum, and whoever says that there is one is refused
        let lengths = iteration["axes"]["z"]["trace_lengths"].as_array().unwrap();
        let rows: Vec<Value> = lengths
            .iter()
            .enumerate()
            .flat_map(|(t, length)| vec![json!([t as f64]); length.as_u64().unwrap() as usize])
            .collect();
        let level = json!({"sensitivity": {"type": "matrix", "settings": ["level"], "matrix": rows}});
        assert_eq!(pointers(&app, &path, &level).await, ["/absolute"]);
        let mut absolute = request.clone();
        absolute["absolute"] = json!(true);
        assert_eq!(pointers(&app, &path, &absolute).await, ["/absolute"]);
        let mut trace = request.clone();
        trace["trace"] = json!([0, 1]);
        assert_eq!(pointers(&app, &path, &trace).await, ["/trace"]);
    }
    assert!(coefficients[0].iter().zip(&coefficients[1]).all(|(a, b)| (a - b).abs() < 1e-9), "{coefficients:?}");
    let [one, two] = [&corrections[0], &corrections[1]];
    for (a, b) in one["settings"].as_array().unwrap().iter().zip(two["settings"].as_array().unwrap()) {
        assert_eq!(a["undetermined"], b["undetermined"]);
        assert!((a["change"].as_f64().unwrap() - b["change"].as_f64().unwrap()).abs() < 1e-8, "{a} {b}");
    }
    for name in ["profile_slope_um", "helix_slope_um", "twist_um"] {
        let [a, b] = [one, two].map(|made| made["figures"]["left"][name]["before"].as_f64().unwrap());
        assert!((a - b).abs() < 1e-8, "{name}: {a} {b}");
    }
    // 6 µm over 15 mm lie on both helices and profiles
    assert!(change(one, "helix_angle").abs() > 0.5, "{one}");
    // profiles alone say nothing of the helix
    let profiles = file_with_zeros(|trace| trace.profile, zero);
    imported(&app, &job, profiles).await;
    let made = correct(&app, &format!("{job}/iterations/3/correction"), &request).await;
    let undetermined = |name: &str| {
        made["settings"].as_array().unwrap().iter().find(|s| s["name"] == name).unwrap()["undetermined"].clone()
    };
    assert_eq!((undetermined("helix_angle"), undetermined("profile_angle")), (json!(true), json!(false)));
    let figures = &made["figures"]["left"];
    assert!(figures.get("helix_slope_um").is_none() && figures["profile_slope_um"].is_object(), "{figures}");
    app.stop().await;
}

/// Traces are given with the iteration or with the correction, with the same result.
#[tokio::test]
async fn traces_are_given_with_nodes_or_with_the_correction() {
    let app = TestApp::start().await;
    let shape = |u: f64, v: f64| 5.0 * (u - 9.0) / 3.0 - 4.0 * (v - 7.5) / 6.5 + 0.3 * (2.0 * u + v).sin();
    let job = job(&app, Some(spur())).await;
    let axes = json!({"z": {"quantity": "deviation", "unit": "um", "trace_lengths": [5, 5, 5, 5]}});
    measure(&app, &job, with(flank(1.0, shape), Some("left"), None, Some(axes))).await;
    measure(&app, &job, with(flank(1.0, shape), Some("left"), None, None)).await;
    let request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
    let one = correct(&app, &format!("{job}/iterations/1/correction"), &request).await;
    let mut traced = request.clone();
    traced["trace"] = json!((0..20).map(|k| k / 5).collect::<Vec<_>>());
    let two = correct(&app, &format!("{job}/iterations/2/correction"), &traced).await;
    for part in ["settings", "predicted", "figures", "warnings"] {
        assert_eq!(one[part], two[part], "{part}");
    }
    // rows of this grid run along the helix: nothing is known along the profile
    let undetermined: Vec<&str> = one["settings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|setting| setting["undetermined"] == true)
        .map(|setting| setting["name"].as_str().unwrap())
        .collect();
    assert!(undetermined.contains(&"profile_angle") && !undetermined.contains(&"helix_angle"), "{undetermined:?}");
    // of columns that are profiles the lengths cannot speak, the numbers can
    traced["trace"] = json!((0..20).map(|k| k % 5).collect::<Vec<_>>());
    let three = correct(&app, &format!("{job}/iterations/2/correction"), &traced).await;
    assert!(change(&three, "profile_angle") != 0.0 && change(&three, "helix_angle") == 0.0, "{three}");
    // heights of one zero are not compared with traces that have a zero each
    correct(&app, &format!("{job}/iterations/2/correction"), &request).await;
    let axes = json!({"z": {"quantity": "deviation", "unit": "um", "trace_lengths": [5, 5, 5, 5]}});
    measure(&app, &job, with(flank(0.5, shape), Some("left"), None, Some(axes))).await;
    let kept = send(app.get(&format!("{job}/iterations/2/correction"))).await.json();
    assert!(kept["not_compared"].as_str().unwrap().contains("own zeros"), "{kept}");
    let empty = json!({"z": {"quantity": "deviation", "unit": "um", "trace_lengths": [20, 0]}});
    let empty = with(flank(1.0, shape), None, None, Some(empty));
    assert_eq!(pointers(&app, &format!("{job}/iterations"), &empty).await, ["/axes/z/trace_lengths/1"]);
    // blocks of a stream have no traces
    let axes = json!({"z": {"quantity": "deviation", "unit": "um", "trace_lengths": [5]}});
    let mut stream = examples("create_stream")[0].1.clone();
    stream["axes"] = axes;
    assert_eq!(pointers(&app, &format!("{job}/streams"), &stream).await, ["/axes/z/trace_lengths"]);
    app.stop().await;
}

/// The least-squares slope along v of scattered nodes, by its normal equations.
fn slope(nodes: &Value) -> f64 {
    let list = |key: &str| nodes[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<f64>>();
    let (u, v, z) = (list("u"), list("v"), list("z"));
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (mu, mv, mz) = (mean(&u), mean(&v), mean(&z));
    let dot = |a: &[f64], ma: f64, b: &[f64], mb: f64| a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f64>();
    let (uu, uv, vv) = (dot(&u, mu, &u, mu), dot(&u, mu, &v, mv), dot(&v, mv, &v, mv));
    let (uz, vz) = (dot(&u, mu, &z, mz), dot(&v, mv, &z, mz));
    (uu * vz - uv * uz) / (uu * vv - uv * uv)
}

const U: [f64; 4] = [6.0, 8.0, 10.0, 12.0];
const V: [f64; 5] = [1.0, 4.0, 7.5, 11.0, 14.0];

fn flank(scale: f64, of: impl Fn(f64, f64) -> f64) -> Value {
    let rows: Vec<Vec<f64>> = U.iter().map(|u| V.iter().map(|v| scale * of(*u, *v)).collect()).collect();
    json!({"nodes": {"type": "grid", "u": U, "v": V, "z": rows},
        "axes": axes(), "model": {"type": "polynomial", "degree": 2, "terms": "total"}})
}

/// Returns the body with this flank, tooth and axes; axes that are not given stay unchanged.
fn with(mut body: Value, flank: Option<&str>, tooth: Option<&str>, axes: Option<Value>) -> Value {
    for (key, value) in [("flank", flank.map(Value::from)), ("tooth", tooth.map(Value::from)), ("axes", axes)] {
        match value {
            Some(Value::Object(given)) => body[key].as_object_mut().unwrap().extend(given),
            Some(value) => body[key] = value,
            None => {}
        }
    }
    body
}

async fn measure(app: &TestApp, job: &str, body: Value) {
    let made = send(app.post(&format!("{job}/iterations"), body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
}

/// Heights in mm, positive into the material, v in µm: the correction is that of the same flank in
/// µm of material over mm.
#[tokio::test]
async fn units_and_signs_of_the_axes_count() {
    let app = TestApp::start().await;
    let shape = |u: f64, v: f64| 5.0 * (u - 9.0) / 3.0 - 4.0 * (v - 7.5) / 6.5 + 0.3 * (2.0 * u + v).sin();
    let job = job(&app, Some(spur())).await;
    measure(&app, &job, with(flank(1.0, shape), Some("left"), None, None)).await;
    let mut other = flank(-1e-3, shape);
    other["nodes"]["v"] = json!(V.map(|v| 1000.0 * v));
    let axes = json!({
        "u": {"quantity": "roll_length", "unit": "mm"}, "v": {"quantity": "face_width", "unit": "um"},
        "z": {"quantity": "deviation", "unit": "mm", "positive": "material_in"},
    });
    measure(&app, &job, with(other, Some("left"), None, Some(axes))).await;
    let request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
    let one = correct(&app, &format!("{job}/iterations/1/correction"), &request).await;
    let two = correct(&app, &format!("{job}/iterations/2/correction"), &request).await;
    for (a, b) in one["settings"].as_array().unwrap().iter().zip(two["settings"].as_array().unwrap()) {
        let (a, b) = (a["change"].as_f64().unwrap(), b["change"].as_f64().unwrap());
        assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs()), "{a} {b}");
    }
    // what nobody here knows is refused, not guessed
    for (axes, pointer) in [
        (json!({"z": {"quantity": "deviation", "unit": "furlong"}}), "/sensitivity"),
        (json!({"u": {"quantity": "face_width", "unit": "mm"}}), "/sensitivity/machine"),
        (json!({"v": {"quantity": "roll_length", "unit": "mm"}}), "/sensitivity/machine"),
    ] {
        let made = send(
            app.post(&format!("{job}/iterations"), with(flank(1.0, shape), Some("left"), None, Some(axes)).to_string()),
        )
        .await;
        let place = made.headers["location"].to_str().unwrap().to_owned();
        assert_eq!(pointers(&app, &format!("{place}/correction"), &request).await, [pointer]);
    }
    // and so are missing data
    let path = format!("{job}/iterations/6/correction");
    measure(&app, &job, flank(1.0, shape)).await;
    assert_eq!(pointers(&app, &path, &request).await, ["/sensitivity/flank"]);
    let said =
        json!({"sensitivity": {"type": "machine", "machine": "form_grinding", "flank": "left"}, "noise_sigma_um": 0.2});
    assert_eq!(correct(&app, &path, &said).await["settings"], one["settings"]);
    app.stop().await;
}

/// The machine's answer is looked for in the next iteration of the same flank and tooth.
#[tokio::test]
async fn other_flanks_and_teeth_are_passed_over() {
    let app = TestApp::start().await;
    let shape = |u: f64, v: f64| 5.0 * (u - 9.0) / 3.0 - 4.0 * (v - 7.5) / 6.5 + 0.3 * (2.0 * u + v).sin();
    let job = job(&app, Some(spur())).await;
    let request = json!({"sensitivity": {"type": "machine", "machine": "form_grinding"}, "noise_sigma_um": 0.2});
    let path = format!("{job}/iterations/1/correction");
    measure(&app, &job, with(flank(1.0, shape), Some("left"), Some("1"), None)).await;
    correct(&app, &path, &request).await;
    let kept = async || send(app.get(&path)).await.json();
    assert_eq!((kept().await.get("answer"), kept().await.get("not_compared")), (None, None));
    // another flank, another tooth, one of which nobody says what it is: none of them is the answer
    measure(&app, &job, with(flank(3.0, shape), Some("right"), Some("1"), None)).await;
    measure(&app, &job, with(flank(3.0, shape), Some("left"), Some("2"), None)).await;
    measure(&app, &job, with(flank(3.0, shape), None, Some("1"), None)).await;
    let other = kept().await;
    assert_eq!(other.get("answer"), None);
    assert!(other["not_compared"].as_str().unwrap().contains("the left flank of tooth 1"), "{other}");
    measure(&app, &job, with(flank(0.5, shape), Some("left"), Some("1"), None)).await;
    let answer = kept().await["answer"].clone();
    assert_eq!(answer["iteration"], 5, "{answer}");
    // what is kept with an iteration must not be of the other flank alone
    let grid = json!({"grid": {"flank": "right", "roll_length_mm": U, "z_mm": V, "deviation_um": vec![[0.0; 5]; 4]}});
    assert_eq!(pointers(&app, &format!("{job}/iterations/1/deviations"), &grid).await, ["/grid/flank"]);
    let mut traces = examples("create_iteration_evaluation")[0].1.clone();
    for trace in traces["traces"].as_array_mut().unwrap() {
        trace["flank"] = json!("right");
    }
    assert_eq!(pointers(&app, &format!("{job}/iterations/1/evaluations"), &traces).await, ["/traces"]);
    app.stop().await;
}
