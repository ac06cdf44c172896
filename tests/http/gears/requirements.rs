//! Requirements of a job on its flanks, and evaluations that are compared with them.

use serde_json::{Value, json};

use super::{import::file, pointers, spur, taken};
use crate::{
    harness::{Answer, TestApp, send},
    shapes::examples,
};

/// A job with an iteration: its path.
async fn job(app: &TestApp, gear: &Value, requirements: &Value) -> String {
    let body = json!({"name": "w", "gear": gear, "requirements": requirements});
    let made = send(app.post("/v1/jobs", body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    assert_eq!(&made.json()["requirements"], requirements);
    let path = made.header("location").to_owned();
    let nodes = json!({"nodes": {"type": "curve", "x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 1.0, 1.9, 3.2]},
        "model": {"type": "polynomial", "degree": 1}});
    assert_eq!(send(app.post(&format!("{path}/iterations"), nodes.to_string())).await.status, 201);
    path
}

/// Helices of both flanks, the left one with a slope of 4 µm and a parabola of 3 µm over 12 mm,
/// positive for excess material, with a little noise; the right one of opposite slope.
fn helices(heights: impl Fn(f64) -> f64) -> Value {
    let z: Vec<f64> = (0..=120).map(|k| 1.5 + 0.1 * f64::from(k)).collect();
    let noise = |z: f64| 0.05 * (37.0 * z).sin();
    let trace = |flank: &str, sign: f64| {
        let shape = |z: &f64| sign * 4.0 * (z - 7.5) / 12.0 - 3.0 * ((z - 7.5) / 6.0).powi(2) + noise(*z) + heights(*z);
        json!({"tooth": "1", "flank": flank, "kind": "helix", "z_mm": z,
               "deviation_um": z.iter().map(shape).collect::<Vec<f64>>()})
    };
    json!({"traces": [trace("left", 1.0), trace("right", -1.0)],
           "evaluation": {"helix_range_mm": [1.5, 13.5], "helix_reference_length_mm": 12.0, "sign": "vdi",
                          "deviation_sign": "material"}})
}

async fn evaluated(app: &TestApp, job: &str, body: &Value) -> Answer {
    let kept = send(app.post(&format!("{job}/iterations/1/evaluations"), body.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    kept
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[tokio::test]
async fn evaluations_are_compared_with_requirements_and_keep_them() {
    let app = TestApp::start().await;
    let limits = json!({"class": 5, "helix_crowning_um": [2.0, 4.0], "helix_form_um": [0.0, 0.01],
        "left": {"helix_slope_um": [3.0, 5.0]}, "right": {"helix_slope_um": [3.0, 5.0]}});
    let requirements = json!({"tolerance_limits": limits});
    let job = job(&app, &spur(), &requirements).await;
    let kept = evaluated(&app, &job, &helices(|_| 0.0)).await;
    let result = kept.json()["result"].clone();
    assert_eq!(result["evaluation"]["tolerance_limits"], limits);
    let [left, right] = [&result["traces"][0], &result["traces"][1]];
    assert!((number(&left["slope_um"]) - 4.0).abs() < 0.1 && (number(&right["slope_um"]) + 4.0).abs() < 0.1);
    assert_eq!((&left["slope_within"], &right["slope_within"]), (&json!(true), &json!(false)));
    assert_eq!(left["slope_conformity"]["verdict"], "conforms");
    assert_eq!(right["slope_conformity"]["verdict"], "does_not_conform");
    assert_eq!((&left["crowning_within"], &left["form_within"]), (&json!(true), &json!(false)));
    // the total deviation has that of the class
    let tolerances = taken(&app, "/v1/gears/tolerances", &json!({"gear": spur(), "class": 5})).await;
    assert!(tolerances.to_string().contains("helix_total"), "{tolerances}");
    assert_eq!(left["total_within"], json!(true));

    // later requirements change no stored result
    let patch = json!({"requirements": {"tolerance_limits": {"left": {"helix_slope_um": [-1.0, 1.0]}}}});
    let patched = send(app.client.patch(app.url(&job)).json(&patch)).await;
    assert_eq!(patched.json()["requirements"], patch["requirements"], "{}", patched.text);
    assert_eq!(send(app.get(kept.header("location"))).await.text, kept.text);
    let later = evaluated(&app, &job, &helices(|_| 0.0)).await.json()["result"]["traces"].clone();
    assert_eq!((&later[0]["slope_within"], later[1].get("slope_within")), (&json!(false), None));
    // a request that says it goes before the job
    let mut own = helices(|_| 0.0);
    own["evaluation"]["tolerance_limits"] = json!({"helix_slope_um": [-9.0, 9.0]});
    let own = evaluated(&app, &job, &own).await.json()["result"]["traces"].clone();
    assert_eq!((&own[0]["slope_within"], &own[1]["slope_within"]), (&json!(true), &json!(true)));
    let cleared = send(app.client.patch(app.url(&job)).json(&json!({"clear": ["requirements"]}))).await;
    assert_eq!(cleared.json().get("requirements"), None, "{}", cleared.text);
    let plain = evaluated(&app, &job, &helices(|_| 0.0)).await;
    assert!(!plain.text.contains("within") && !plain.text.contains("tolerance_limits"), "{}", plain.text);
}

/// Range of shifts that bring a trace between two lines, by trying.
fn room(trace: &Value, upper: impl Fn(f64) -> f64, lower: impl Fn(f64) -> f64) -> Option<[f64; 2]> {
    let list = |name: &str| trace[name].as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
    let (z, deviation) = (list("z_mm"), list("deviation_um"));
    let fits = |shift: f64| z.iter().zip(&deviation).all(|(z, d)| lower(*z) <= d + shift && d + shift <= upper(*z));
    let shifts: Vec<f64> = (-2000..=2000).map(|k| 0.01 * f64::from(k)).filter(|shift| fits(*shift)).collect();
    Some([*shifts.first()?, *shifts.last()?])
}

#[tokio::test]
async fn traces_lie_in_a_band_if_some_shift_takes_them_there() {
    let app = TestApp::start().await;
    let band = |low: f64| {
        json!({"kind": "helix", "upper": [[1.5, 1.0], [7.5, 4.0], [13.5, 1.0]],
                                 "lower": [[1.5, low], [13.5, low]]})
    };
    let upper = |z: f64| 4.0 - 0.5 * (z - 7.5).abs();
    let requirements = json!({"k_bands": [band(-4.5), band(-1.0), {"kind": "helix", "flank": "right",
        "upper": [[1.5, 50.0], [13.5, 50.0]], "lower": [[1.5, -50.0], [13.5, -50.0]]}]});
    let job = job(&app, &spur(), &requirements).await;
    let request = helices(|_| 17.0);
    let result = evaluated(&app, &job, &request).await.json()["result"].clone();
    assert_eq!(result["evaluation"]["k_bands"], requirements["k_bands"]);
    let bands = |trace: usize| result["traces"][trace]["k_bands"].as_array().unwrap().clone();
    assert_eq!((bands(0).len(), bands(1).len()), (2, 3), "the last is of right flanks");
    for trace in [0, 1] {
        let found = bands(trace);
        let [first, last] = room(&request["traces"][trace], upper, |_| -4.5).unwrap();
        assert_eq!(found[0]["within"], json!(true));
        assert!((number(&found[0]["clearance_um"]) - (last - first)).abs() < 0.03, "{found:?} {first} {last}");
        assert!((number(&found[0]["shift_um"]) - 0.5 * (first + last)).abs() < 0.03, "{found:?} {first} {last}");
        assert_eq!(room(&request["traces"][trace], upper, |_| -1.0), None);
        assert!(found[1]["within"] == json!(false) && number(&found[1]["clearance_um"]) < 0.0, "{found:?}");
    }
    // a trace that does not reach the ends of the band is not decided
    let mut open = request.clone();
    for trace in open["traces"].as_array_mut().unwrap() {
        for k in 0..15 {
            trace["deviation_um"][k] = Value::Null;
        }
    }
    let result = evaluated(&app, &job, &open).await.json()["result"].clone();
    assert_eq!(result["traces"][0]["k_bands"][0].get("within"), None, "{result}");
    assert_eq!(result["traces"][0]["k_bands"][1]["within"], json!(false));
}

#[tokio::test]
async fn bands_of_profiles_are_over_diameters_too() {
    let app = TestApp::start().await;
    let mut request = examples("evaluate_gear")[0].1.clone();
    let whole = json!({"kind": "profile", "profile_axis": "diameter", "upper": [[50.3, 1], [54.02, 4]],
                       "lower": [[50.3, -4], [54.02, 0]]});
    request["evaluation"]["k_bands"] = json!([whole]);
    let found = taken(&app, "/v1/gears/evaluate", &request).await;
    let first = &found["traces"][0]["k_bands"][0];
    assert_eq!(first["within"], json!(true), "{found}");
    // at the roll length of a diameter of the trace
    let base = 52.0 * 20f64.to_radians().cos();
    let rolls: Vec<f64> = request["traces"][0]["diameter_mm"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| 0.5 * (number(d).powi(2) - base * base).sqrt())
        .collect();
    for nearest in first["nearest_mm"].as_array().unwrap() {
        assert!(rolls.iter().any(|roll| (roll - number(nearest)).abs() < 1e-9), "{nearest} {rolls:?}");
    }
    assert!(found["traces"][2].get("k_bands").is_none(), "a helix has none");
    request["evaluation"]["k_bands"][0]["upper"][0][0] = json!(40.0);
    let refused = pointers(&app, "/v1/gears/evaluate", &request).await;
    assert_eq!(refused, ["/evaluation/k_bands/0/upper/0/0"], "there is no involute");
}

#[tokio::test]
async fn imports_are_held_against_it_too() {
    let app = TestApp::start().await;
    let requirements = json!({"tolerance_limits": {"profile_slope_um": [-1.0, 1.0]}});
    let body = json!({"name": "w", "gear": spur(), "requirements": requirements});
    let path = send(app.post("/v1/jobs", body.to_string())).await.header("location").to_owned();
    let part = reqwest::multipart::Part::bytes(file(false)).file_name("w.mka");
    let form = reqwest::multipart::Form::new().part("file", part);
    let made = send(app.client.post(app.url(&format!("{path}/import"))).multipart(form)).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let records = send(app.get(&format!("{path}/iterations/1/records"))).await.json();
    let record = records["items"][0]["id"].as_str().unwrap().to_owned();
    let kept = send(app.get(&format!("{path}/iterations/1/records/{record}"))).await.json();
    let profiles: Vec<&Value> =
        kept["result"]["traces"].as_array().unwrap().iter().filter(|trace| trace["kind"] == "profile").collect();
    assert!(!profiles.is_empty() && profiles.iter().all(|trace| trace["slope_within"] == json!(false)), "{kept}");
}

/// Requirements that do not suit the gear are left aside, and an evaluation is never refused for
/// them.
#[tokio::test]
async fn requirements_that_do_not_suit_the_gear_are_ignored() {
    let app = TestApp::start().await;
    let mut gear = spur();
    gear.as_object_mut().unwrap().remove("face_width_mm");
    let requirements = json!({"tolerance_limits": {"class": 5, "helix_crowning_um": [2.0, 4.0]}, "k_bands": [
        {"kind": "profile", "profile_axis": "diameter", "upper": [[20.0, 1.0], [54.0, 1.0]],
         "lower": [[20.0, -1.0], [54.0, -1.0]]}]});
    let job = job(&app, &gear, &requirements).await;
    let result = evaluated(&app, &job, &helices(|_| 0.0)).await.json()["result"].clone();
    let aside = |warning: &&Value| warning["code"] == "requirement_left_aside";
    assert_eq!(result["warnings"].as_array().unwrap().iter().filter(aside).count(), 2, "{result}");
    assert_eq!(result["evaluation"]["tolerance_limits"], json!({"helix_crowning_um": [2.0, 4.0]}));
    assert_eq!(result["traces"][0]["crowning_within"], json!(true));
}

#[tokio::test]
async fn figures_of_a_surface_say_whether_they_lie_within() {
    let app = TestApp::start().await;
    let mut request = examples("gear_flank_surface")[0].1.clone();
    request["flank"] = json!("left");
    let within = json!([-1000.0, 1000.0]);
    request["tolerance_limits"] = json!({"profile_slope_um": within, "twist_um": [900.0, 901.0],
        "left": {"twist_um": within}, "right": {"profile_slope_um": [900.0, 901.0]}});
    let surface = taken(&app, "/v1/gears/flank-surface", &request).await;
    assert_eq!((&surface["profile_slope_um"]["within"], &surface["twist_um"]["within"]), (&json!(true), &json!(true)));
    assert_eq!(surface["helix_slope_um"].get("within"), None);
    request["flank"] = json!("right");
    let surface = taken(&app, "/v1/gears/flank-surface", &request).await;
    assert_eq!(
        (&surface["profile_slope_um"]["within"], &surface["twist_um"]["within"]),
        (&json!(false), &json!(false))
    );
}

#[tokio::test]
async fn invalid_requirements_have_pointers() {
    let app = TestApp::start().await;
    let refused = async |requirements: Value| {
        let body = json!({"name": "w", "requirements": requirements});
        pointers(&app, "/v1/jobs", &body).await
    };
    let band = |upper: Value, lower: Value| json!({"k_bands": [{"kind": "helix", "upper": upper, "lower": lower}]});
    let flat = json!([[0.0, -1.0], [9.0, -1.0]]);
    let line = |height: f64| (0..700).map(|k| json!([k, height])).collect::<Vec<Value>>();
    let cases = [
        (json!({"tolerance_limits": {"class": 0}}), "/requirements/tolerance_limits/class"),
        (json!({"tolerance_limits": {"class": 12}}), "/requirements/tolerance_limits/class"),
        (json!({"tolerance_limits": {"twist_um": [2, 1]}}), "/requirements/tolerance_limits/twist_um"),
        (
            json!({"tolerance_limits": {"left": {"helix_total_um": [2, 2]}}}),
            "/requirements/tolerance_limits/left/helix_total_um",
        ),
        (json!({"tolerance_limits": {"left": {"class": 5}}}), "/requirements/tolerance_limits/left/class"),
        (band(json!([[0.0, 1.0]]), flat.clone()), "/requirements/k_bands/0/upper"),
        (band(json!([[0.0, 1.0], [0.0, 2.0]]), flat.clone()), "/requirements/k_bands/0/upper/1/0"),
        (band(json!([[0.0, 1e10], [1.0, 2.0]]), flat.clone()), "/requirements/k_bands/0/upper/0/1"),
        (band(json!([[0.0, 1.0], [9.0, -2.0]]), flat.clone()), "/requirements/k_bands/0/lower"),
        (
            json!({"k_bands": [{"kind": "helix", "profile_axis": "diameter", "upper": [[0, 1], [1, 1]], "lower": [[0, 0],
                [1, 0]]}]}),
            "/requirements/k_bands/0/profile_axis",
        ),
        (
            json!({"k_bands": vec![json!({"kind": "helix", "upper": [[0, 1], [1, 1]], "lower": [[0, 0], [1, 0]]}); 21]}),
            "/requirements/k_bands",
        ),
        (
            // 3 bands of 2 lines of 700 points are more than every response may contain
            json!({"k_bands": vec![json!({"kind": "helix", "upper": line(1.0), "lower": line(-1.0)}); 3]}),
            "/requirements/k_bands",
        ),
        (json!({"pitch_limits": {"class": 12}}), "/requirements/pitch_limits/class"),
        (json!({"pitch_limits": {"runout_um": [3, 3]}}), "/requirements/pitch_limits/runout_um"),
        (
            json!({"pitch_limits": {"left": {"single_pitch_um": [1, -1]}}}),
            "/requirements/pitch_limits/left/single_pitch_um",
        ),
        (json!({"pitch_limits": {"left": {"runout_um": [0, 1]}}}), "/requirements/pitch_limits/left/runout_um"),
        (json!({"klass": 5}), "/requirements/klass"),
    ];
    for (requirements, pointer) in cases {
        assert_eq!(refused(requirements.clone()).await, [pointer], "{requirements}");
    }
    let made = send(app.post("/v1/jobs", json!({"name": "w"}).to_string())).await;
    let patch = json!({"requirements": {}, "clear": ["requirements"]});
    let both = send(app.client.patch(app.url(made.header("location"))).json(&patch)).await;
    assert_eq!(both.pointers(), ["/clear/0"]);
}
