//! Traces, pitches, tolerances and the surface of a flank.

use serde_json::{Value, json};

use super::{pointers, spur, taken};
use crate::{
    harness::{TestApp, send},
    shapes::{close, examples},
};

#[tokio::test]
async fn tolerances_of_the_standard() {
    let app = TestApp::start().await;
    let gear = json!({"teeth": 50, "normal_module_mm": 2.0, "face_width_mm": 20.0});
    let answer = taken(&app, "/v1/gears/tolerances", &json!({"gear": gear, "class": 5})).await;
    for (name, value) in [
        ("single_pitch_um", 5.9),
        ("cumulative_pitch_um", 19.1),
        ("runout_um", 17.19),
        ("profile_slope_um", 4.9),
        ("profile_form_um", 6.1),
        ("profile_total_um", 7.824),
        ("helix_slope_um", 6.0652),
        ("helix_form_um", 6.7125),
        ("helix_total_um", 9.0467),
    ] {
        assert!((answer["unrounded"][name].as_f64().unwrap() - value).abs() < 5e-4, "{name}");
        assert!(answer["rounded"][name].as_f64().unwrap() > 0.0);
    }
    assert_eq!(answer["rounded"]["cumulative_pitch_um"], 19.0);
    let classes = ["0", "12", "256", "-1", "5.5"].map(|class| (class, "/class"));
    for (class, pointer) in classes.into_iter().chain([("5", "/gear/normal_module_mm")]) {
        let class: Value = serde_json::from_str(class).unwrap();
        let outside = json!({"gear": {"teeth": 50, "normal_module_mm": 0.3, "face_width_mm": 20.0}, "class": class});
        assert_eq!(pointers(&app, "/v1/gears/tolerances", &outside).await, [pointer]);
    }
    app.stop().await;
}

fn line(places: &[f64], of: impl Fn(f64) -> f64) -> Vec<f64> {
    places.iter().map(|x| of(*x)).collect()
}

#[tokio::test]
async fn slopes_come_back_with_their_signs() {
    let app = TestApp::start().await;
    let z: Vec<f64> = (0..=30).map(|i| 0.5 * f64::from(i)).collect();
    let roll: Vec<f64> = (0..=40).map(|i| 5.0 + 0.15 * f64::from(i)).collect();
    let base = 52.0 * 20f64.to_radians().cos();
    let diameter = |l: f64| base.hypot(2.0 * l);
    let evaluation =
        json!({"profile_diameter_range_mm": [diameter(6.0), diameter(10.0)], "helix_range_mm": [1.0, 14.0]});
    let rising = |flank: &str| {
        vec![
            json!({"tooth": "1", "flank": flank, "kind": "profile", "roll_length_mm": roll,
                   "deviation_um": line(&roll, |l| 2.5 * (l - 8.0))}),
            json!({"tooth": "1", "flank": flank, "kind": "helix", "z_mm": z, "deviation_um": line(&z, |z| 0.4 * z)}),
        ]
    };
    let traces: Vec<Value> = [rising("left"), rising("right")].concat();
    for (sign, given, right) in
        [("din", "din", 6.0), ("as_given", "material", 6.0), ("vdi", "material", 6.0), ("din", "material", -6.0)]
    {
        let mut settings = evaluation.clone();
        settings["sign"] = json!(sign);
        settings["deviation_sign"] = json!(given);
        let answer =
            taken(&app, "/v1/gears/evaluate", &json!({"gear": spur(), "traces": traces, "evaluation": settings})).await;
        let slopes: Vec<f64> =
            answer["traces"].as_array().unwrap().iter().map(|t| t["slope_um"].as_f64().unwrap()).collect();
        // 2.5 µm/mm over 4 mm of roll, 0.4 µm/mm over the face width of 15 mm
        for (found, truth) in slopes.iter().zip([10.0, 6.0, 10.0, right]) {
            close(*found, truth, 1e-12);
        }
        assert_eq!(answer["evaluation"]["helix_reference_length_mm"], 15.0);
        close(answer["evaluation"]["profile_reference_length_mm"].as_f64().unwrap(), 4.0, 1e-12);
        close(answer["traces"][0]["total_um"].as_f64().unwrap(), 2.5 * 3.9, 1e-9);
        assert!(answer["traces"][0]["form_um"].as_f64().unwrap() < 1e-9);
        assert!(answer["traces"][0]["class"]["slope"].as_u64().is_some(), "{answer}");
    }
    // defaults: what is posted under `din` is DIN's
    let answer =
        taken(&app, "/v1/gears/evaluate", &json!({"gear": spur(), "traces": traces, "evaluation": evaluation})).await;
    assert_eq!(answer["evaluation"]["deviation_sign"], "din");
    close(answer["traces"][3]["slope_um"].as_f64().unwrap(), 6.0, 1e-12);
    app.stop().await;
}

/// Deviations of 0.006 µm were meant in mm; nothing has a class or conforms until that is settled.
#[tokio::test]
async fn traces_in_an_implausible_unit_are_not_judged() {
    let app = TestApp::start().await;
    let z: Vec<f64> = (0..=30).map(|i| 0.5 * f64::from(i)).collect();
    let helix = |of: &dyn Fn(f64) -> f64| json!({"tooth": "1", "flank": "left", "kind": "helix", "z_mm": z, "deviation_um": line(&z, of)});
    let settings = |accept: Option<bool>| {
        let limits = json!({"helix_slope_um": [-9.0, 9.0], "class": 7});
        let mut settings = json!({"helix_range_mm": [0.0, 15.0], "tolerance_limits": limits});
        if let Some(accept) = accept {
            settings["accept_units"] = json!(accept);
        }
        settings
    };
    let evaluate = async |traces: Value, accept| {
        let request = json!({"gear": spur(), "traces": traces, "evaluation": settings(accept)});
        let answer = taken(&app, "/v1/gears/evaluate", &request).await;
        let warning = answer["warnings"].as_array().unwrap().iter().find(|w| w["code"] == "implausible_unit").cloned();
        let first = &answer["traces"][0];
        assert!(first["slope_um"].is_f64());
        let judged = [first.get("class"), first.get("slope_within"), answer.get("class")].map(|there| there.is_some());
        (warning, judged)
    };
    let in_mm = helix(&|z| 0.4e-3 * z);
    let (warning, judged) = evaluate(json!([in_mm]), None).await;
    let warning = warning.unwrap();
    let message = warning["message"].as_str().unwrap();
    assert!(message.contains("(in mm? then 6 µm)") && message.contains("`evaluation.accept_units: true`"), "{message}");
    assert_eq!((&warning["params"]["unit"], judged), (&json!("mm"), [false; 3]));
    assert_eq!(evaluate(json!([in_mm]), Some(true)).await, (None, [true; 3]));
    let in_nm = helix(&|z| 400.0 * z);
    assert!(
        evaluate(json!([in_nm]), None).await.0.unwrap()["message"].as_str().unwrap().contains("(in nm? then 6 µm)")
    );
    // one good flank next to others shows that the unit is right; traces of zeros are nominal
    for others in [json!([in_mm, helix(&|z| 0.4 * z)]), json!([helix(&|_| 0.0)])] {
        assert_eq!(evaluate(others, None).await, (None, [true; 3]));
    }
    app.stop().await;
}

#[tokio::test]
async fn errors_in_traces_have_pointers() {
    let app = TestApp::start().await;
    let request =
        |trace: Value, evaluation: Value| json!({"gear": spur(), "traces": [trace], "evaluation": evaluation});
    let whole = json!({"helix_range_mm": [1.0, 14.0]});
    let helix = |extra: Value| {
        let mut trace = json!({"tooth": "1", "flank": "left", "kind": "helix", "z_mm": [0.0, 5.0, 10.0],
            "deviation_um": [0.0, 1.0, 2.0]});
        trace.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        trace
    };
    for (trace, evaluation, pointer) in [
        (helix(json!({})), json!({}), "/evaluation/helix_range_mm"),
        (helix(json!({"deviation_um": [0.0, 1.0]})), whole.clone(), "/traces/0/deviation_um"),
        (helix(json!({"valid": [true]})), whole.clone(), "/traces/0/valid"),
        (helix(json!({"section_z_mm": 3.0})), whole.clone(), "/traces/0/section_z_mm"),
        (helix(json!({"kind": "profile"})), json!({"profile_diameter_range_mm": [50.3, 54.0]}), "/traces/0"),
        (helix(json!({})), json!({"helix_range_mm": [14.0, 1.0]}), "/evaluation/helix_range_mm"),
        (helix(json!({})), json!({"helix_range_mm": [1.0, 14.0], "sign": "iso"}), "/evaluation/sign"),
    ] {
        assert_eq!(pointers(&app, "/v1/gears/evaluate", &request(trace, evaluation)).await, [pointer]);
    }
    // sound, but too short: the others would be evaluated
    let answer = taken(&app, "/v1/gears/evaluate", &request(helix(json!({})), whole)).await;
    assert_eq!(answer["traces"][0].get("slope_um"), None);
    assert_eq!(answer["warnings"][0]["code"], "too_few_samples");
    app.stop().await;
}

#[tokio::test]
async fn pitches_of_an_eccentric_gear() {
    let app = TestApp::start().await;
    let teeth = 24;
    let at = |k: i32| std::f64::consts::TAU * f64::from(k) / f64::from(teeth);
    let index: Vec<f64> = (0..teeth).map(|k| 10.0 * at(k).sin()).collect();
    let request = json!({"gear": {"teeth": teeth, "normal_module_mm": 2.0, "face_width_mm": 10.0},
                         "left": {"index_deviation_um": index}, "right": {"index_deviation_um": index}, "sector": 6,
                         "counting": "clockwise"});
    let answer = taken(&app, "/v1/gears/pitch", &request).await;
    close(answer["left"]["cumulative_pitch_um"].as_f64().unwrap(), 20.0, 1e-12);
    // the greatest step of 10 sin over one pitch, and over a quarter
    close(
        answer["left"]["single_pitch"]["value_um"].as_f64().unwrap().abs(),
        20.0 * (std::f64::consts::PI / 24.0).sin() * (std::f64::consts::PI / 24.0).cos(),
        0.02,
    );
    close(answer["left"]["sector_pitch_1995"]["value_um"].as_f64().unwrap().abs(), 10.0 * 2f64.sqrt(), 1e-2);
    // a quarter of the waves from 0 up to the crest
    close(answer["left"]["sector_sum_2013"]["value_um"].as_f64().unwrap().abs(), 10.0, 1e-12);
    // deviations 0, 3, −4, 2, 0 …: the range over four flanks is 3 − (−4); over three pitches it is
    // −4 − 0 at most, and 2 − 0 between teeth 1, 4, 7 …
    let mut index = vec![0.0; 24];
    index[1..4].copy_from_slice(&[3.0, -4.0, 2.0]);
    let request = json!({"gear": {"teeth": teeth, "normal_module_mm": 2.0},
                         "left": {"index_deviation_um": index}, "sector": 3});
    let found = &taken(&app, "/v1/gears/pitch", &request).await["left"];
    assert_eq!(found["sector_pitch_2013"], json!({"value_um": 7.0, "tooth": 3}));
    assert_eq!(found["sector_sum_2013"], json!({"value_um": 2.0, "tooth": 4}));
    assert_eq!(found["sector_pitch_1995"], json!({"value_um": -4.0, "tooth": 3}));
    assert!(found["class"].as_object().unwrap().keys().all(|name| !name.contains("sector")));
    assert_eq!(answer["left"]["k"], 6);
    assert!(answer["left"]["class"]["cumulative_pitch"].as_u64().is_some() && answer["runout"]["derived"] == true);
    // pitches without a run-out
    let mut gaps = vec![Value::from(0.0); index.len()];
    gaps[0] = Value::Null;
    let request = json!({"gear": {"teeth": teeth, "normal_module_mm": 2.0},
                         "left": {"single_pitch_um": gaps}, "right": {"single_pitch_um": gaps},
                         "counting": "clockwise"});
    let answer = taken(&app, "/v1/gears/pitch", &request).await;
    assert_eq!((answer.get("runout"), &answer["warnings"][0]["code"]), (None, &json!("no_runout")));
    assert_eq!(answer["left"]["single_pitch"]["value_um"], 0.0);
    let short = json!({"gear": {"teeth": 24, "normal_module_mm": 2.0}, "left": {"index_deviation_um": [0.0, 1.0]}});
    assert_eq!(pointers(&app, "/v1/gears/pitch", &short).await, ["/left/index_deviation_um"]);
    app.stop().await;
}

#[tokio::test]
async fn injected_slope_crowning_and_twist_come_back() {
    let app = TestApp::start().await;
    let (u, v): (Vec<f64>, Vec<f64>) =
        ((0..7).map(|i| 6.0 + f64::from(i)).collect(), (0..9).map(|j| 1.0 + 1.5 * f64::from(j)).collect());
    let place = |x: f64, low: f64, high: f64| (2.0 * x - low - high) / (high - low);
    let rows: Vec<Vec<f64>> = u
        .iter()
        .map(|a| {
            let each = v.iter().map(|b| {
                let (s, t) = (place(*a, 6.0, 12.0), place(*b, 1.0, 13.0));
                1.0 + 5.0 * s - 3.0 * t - 10.0 * s * s - 7.0 * t * t + 2.5 * s * t
            });
            each.collect()
        })
        .collect();
    let request = json!({"gear": spur(), "flank": "left", "profile": u, "z_mm": v, "deviation_um": rows});
    let answer = taken(&app, "/v1/gears/flank-surface", &request).await;
    for (name, truth) in [
        ("mean_um", 1.0),
        ("profile_slope_um", 10.0),
        // over 12 mm of nodes it is -6, over 15 mm of face width:
        ("helix_slope_um", -7.5),
        ("profile_crowning_um", 10.0),
        ("helix_crowning_um", 7.0),
        ("twist_um", 10.0),
    ] {
        assert!((answer[name]["value"].as_f64().unwrap() - truth).abs() < 1e-6, "{name} {}", answer[name]);
    }
    assert!(answer["form"]["peak_to_valley_um"].as_f64().unwrap() < 1e-9);
    assert_eq!(answer["nodes"], json!({"posted": 63, "missing": 0, "trimmed": 0, "used": 63}));
    // the same flank over its roll angles
    let base = 26.0 * 20f64.to_radians().cos();
    let mut turned = request.clone();
    turned["profile"] = json!(u.iter().map(|l| (l / base).to_degrees()).collect::<Vec<_>>());
    turned["profile_axis"] = json!("roll_angle");
    let by_angle = taken(&app, "/v1/gears/flank-surface", &turned).await;
    close(by_angle["profile_slope_um"]["value"].as_f64().unwrap(), 10.0, 1e-12);
    close(by_angle["roll_length_range_mm"][1].as_f64().unwrap(), 12.0, 1e-12);
    // errors among the deviations have their index
    for (deviations, pointer, said) in [
        (json!([1.0, "x", 2.0]), "/deviation_um/1", "expected a number, found a string"),
        (json!([null, [1.0]]), "/deviation_um/1", "expected a number, found an array"),
        (json!([[1.0, true]]), "/deviation_um/0/1", "expected a number, found a boolean"),
        (json!([[1.0], 2.0]), "/deviation_um/1", "expected a row of numbers, found a number"),
        (json!({}), "/deviation_um", "expected an array of numbers, found an object"),
    ] {
        let mut wrong = request.clone();
        wrong["deviation_um"] = deviations;
        let answer = send(app.post("/v1/gears/flank-surface", wrong.to_string())).await;
        let errors = answer.problem(422, "invalid_request")["errors"].clone();
        assert_eq!(errors, json!([{"pointer": pointer, "detail": said}]));
    }
    app.stop().await;
}

#[tokio::test]
async fn traces_with_sections_determine_the_surface_of_their_flank() {
    let app = TestApp::start().await;
    let base = 52.0 * 20f64.to_radians().cos();
    let diameter = |l: f64| base.hypot(2.0 * l);
    let z: Vec<f64> = (0..=30).map(|i| 0.5 * f64::from(i)).collect();
    let roll: Vec<f64> = (0..=40).map(|i| 5.0 + 0.15 * f64::from(i)).collect();
    // material over u on roll lengths 6 to 10 and v on z 1 to 14: all six terms; outside the ranges
    // a heap that must not count
    let material = |l: f64, z: f64| {
        let (u, v) = ((l - 8.0) / 2.0, (z - 7.5) / 6.5);
        let beyond = if u.abs() > 1.01 || v.abs() > 1.01 { 1000.0 } else { 0.0 };
        1.0 + 5.0 * u - 3.0 * v - 4.0 * u * u + 2.5 * u * v - 7.0 * v * v + beyond
    };
    for (flank, turned) in [("left", 1.0), ("right", -1.0)] {
        let profile = |tooth: &str, at: f64| {
            json!({"tooth": tooth, "flank": flank, "kind": "profile", "roll_length_mm": roll, "section_z_mm": at,
                   "deviation_um": line(&roll, |l| material(l, at))})
        };
        let helix = |tooth: &str, at: f64| {
            json!({"tooth": tooth, "flank": flank, "kind": "helix", "z_mm": z, "section_diameter_mm": diameter(at),
                   "deviation_um": line(&z, |z| turned * material(at, z))})
        };
        let evaluation =
            json!({"profile_diameter_range_mm": [diameter(6.0), diameter(10.0)], "helix_range_mm": [1.0, 14.0]});
        let traces =
            json!([profile("4u", 2.0), profile("4", 7.5), helix("4", 8.0), profile("9", 7.5), helix("9", 8.0)]);
        let request = json!({"gear": spur(), "traces": traces, "evaluation": evaluation});
        let answer = taken(&app, "/v1/gears/evaluate", &request).await;
        let surfaces = answer["surfaces"].as_array().unwrap();
        // tooth 9 has a plain cross: slopes and crownings, no twist
        assert_eq!(surfaces.len(), 2, "{surfaces:?}");
        let cross = &surfaces[1];
        assert_eq!((&cross["tooth"], cross.get("twist_um"), cross.get("mean_um")), (&json!("9"), None, None));
        assert!((cross["profile_slope_um"]["value"].as_f64().unwrap() - 10.0).abs() < 1e-6, "{cross}");
        assert!((cross["helix_crowning_um"]["value"].as_f64().unwrap() - 7.0).abs() < 1e-6, "{cross}");
        assert_eq!(answer["warnings"][0]["code"], "figures_not_determined");
        let says = answer["warnings"][0]["message"].as_str().unwrap();
        assert!(says.contains("twist_um") && says.contains(&format!("tooth 9 {flank}")), "{says}");
        assert_eq!(answer["evaluation"]["traces_share_zero"], false);
        let found = &surfaces[0];
        assert_eq!(found.get("mean_um"), None);
        close(found["z_range_mm"][1].as_f64().unwrap(), 14.0, 1e-12);
        assert_eq!((&found["tooth"], &found["flank"], &found["traces"]), (&json!("4"), &json!(flank), &json!(3)));
        for (name, truth) in [
            ("profile_slope_um", 10.0),
            // over the face width of 15 mm
            ("helix_slope_um", turned * -6.0 * 15.0 / 13.0),
            ("profile_crowning_um", 4.0),
            ("helix_crowning_um", 7.0),
            ("twist_um", turned * 10.0),
        ] {
            assert!((found[name]["value"].as_f64().unwrap() - truth).abs() < 1e-6, "{name} {}", found[name]);
        }
        assert!(found["peak_to_valley_um"].as_f64().unwrap() < 1e-9);
        assert_eq!(found["samples"], 2 * 27 + 27);
        // traces as a machine zeroes them, each by itself: the same figures
        let mut zeroed = request.clone();
        for (k, trace) in zeroed["traces"].as_array_mut().unwrap().iter_mut().enumerate() {
            for deviation in trace["deviation_um"].as_array_mut().unwrap() {
                *deviation = json!(deviation.as_f64().unwrap() + 40.0 * (k as f64 - 1.3));
            }
        }
        let again = taken(&app, "/v1/gears/evaluate", &zeroed).await;
        for name in ["profile_slope_um", "helix_slope_um", "profile_crowning_um", "helix_crowning_um", "twist_um"] {
            let [a, b] = [found, &again["surfaces"][0]].map(|surface| surface[name]["value"].as_f64().unwrap());
            assert!((a - b).abs() < 1e-9, "{name}: {a} {b}");
        }
        // one zero for all: the mean is determined
        let mut shared = request.clone();
        shared["evaluation"]["traces_share_zero"] = json!(true);
        let answer = taken(&app, "/v1/gears/evaluate", &shared).await;
        assert!((answer["surfaces"][0]["mean_um"]["value"].as_f64().unwrap() - 1.0).abs() < 1e-6);
        // as given: the signs of the traces themselves
        let mut as_given = request.clone();
        as_given["evaluation"]["sign"] = json!("as_given");
        as_given["evaluation"]["deviation_sign"] = json!("din");
        let answer = taken(&app, "/v1/gears/evaluate", &as_given).await;
        let slope = answer["surfaces"][0]["helix_slope_um"]["value"].as_f64().unwrap();
        assert_eq!(slope.signum(), answer["traces"][2]["slope_um"].as_f64().unwrap().signum());
        // third traces that determine nothing more: undefined, out of the range, the same place
        // once more
        let mut nothing = helix("4k", 9.5);
        nothing["deviation_um"] = json!(vec![Value::Null; z.len()]);
        for third in [nothing, helix("4k", 12.0), profile("4o", 14.8), helix("4k", 8.0001)] {
            let traces = json!([profile("4", 7.5), helix("4", 8.0), third]);
            let request = json!({"gear": spur(), "traces": traces, "evaluation": request["evaluation"]});
            let answer = taken(&app, "/v1/gears/evaluate", &request).await;
            assert_eq!(
                (answer["surfaces"].as_array().unwrap().len(), answer["surfaces"][0].get("twist_um")),
                (1, None)
            );
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn evaluations_are_kept_with_an_iteration_and_take_the_gear_of_the_job() {
    let app = TestApp::start().await;
    let job = send(app.post("/v1/jobs", json!({"name": "w", "gear": spur()}).to_string())).await.json();
    let place = format!("/v1/jobs/{}/iterations", job["id"].as_str().unwrap());
    let nodes = json!({"nodes": {"type": "curve", "x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 1.0, 1.9, 3.2]},
        "model": {"type": "polynomial", "degree": 1}});
    assert_eq!(send(app.post(&place, nodes.to_string())).await.status, 201);
    for (operation, path, kind) in [
        ("create_iteration_evaluation", "evaluations", "evaluation"),
        ("create_iteration_deviations", "deviations", "deviations"),
    ] {
        let kept = send(app.post(&format!("{place}/1/{path}"), examples(operation)[0].1.to_string())).await;
        assert_eq!(kept.status, 201, "{}", kept.text);
        let body = kept.json();
        assert_eq!(body["kind"], kind);
        let again = send(app.get(kept.header("location"))).await;
        assert_eq!(again.text, kept.text);
        assert_eq!(again.header("etag"), kept.header("etag"));
    }
    let trace = send(app.get(&format!("/v1/jobs/{}/trace", job["id"].as_str().unwrap()))).await.json();
    let kinds: Vec<_> =
        trace["iterations"][0]["records"].as_array().unwrap().iter().map(|r| r["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["evaluation", "deviations"]);
    // a job without a gear needs one
    let bare = send(app.post("/v1/jobs", json!({"name": "w"}).to_string())).await.json();
    let place = format!("/v1/jobs/{}/iterations", bare["id"].as_str().unwrap());
    assert_eq!(send(app.post(&place, nodes.to_string())).await.status, 201);
    let example = &examples("create_iteration_evaluation")[0].1;
    assert_eq!(pointers(&app, &format!("{place}/1/evaluations"), example).await, ["/gear"]);
    app.stop().await;
}

#[tokio::test]
async fn holes_and_dust_are_warned_of() {
    let app = TestApp::start().await;
    let z: Vec<f64> = (0..200).map(|k| 15.0 * f64::from(k) / 199.0).collect();
    // errors without correlation: the sine of a square runs through all frequencies
    let clean: Vec<f64> = z.iter().map(|z| 4.0 * (2.0 * z).sin() + 0.2 * (97.0 * z * z).sin()).collect();
    let asked = |deviation: Value, extra: Value| {
        let mut evaluation = json!({"helix_range_mm": [0.5, 14.5]});
        evaluation.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        let trace = json!({"tooth": "1", "flank": "left", "kind": "helix", "z_mm": z, "deviation_um": deviation});
        json!({"gear": spur(), "traces": [trace], "evaluation": evaluation})
    };
    let codes = |answer: &Value| -> Vec<String> {
        answer["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap().to_owned()).collect()
    };
    let whole = taken(&app, "/v1/gears/evaluate", &asked(json!(clean), json!({}))).await;
    assert_eq!(codes(&whole), Vec::<String>::new());
    assert_eq!(whole["evaluation"]["outliers"], "keep");
    assert!(whole["traces"][0]["class"]["form"].is_u64() && whole["traces"][0].get("outliers").is_none());
    // 119 of 200 samples undefined
    let mut holed = json!(clean);
    (40..159).for_each(|k| holed[k] = Value::Null);
    let answer = taken(&app, "/v1/gears/evaluate", &asked(holed, json!({}))).await;
    assert_eq!(codes(&answer), ["undefined_samples", "hole_in_trace"]);
    assert!(answer["traces"][0].get("class").is_none() && answer.get("class").is_none(), "{answer}");
    assert!(answer["traces"][0].get("slope_um").is_none() && answer["means"] == json!([]), "{answer}");
    // a fifth of a crowned trace: the slope is that of the whole
    let crowned: Vec<f64> = z.iter().zip(&clean).map(|(z, d)| 0.05 * d - 0.4 * (z - 7.5).powi(2)).collect();
    let of_whole = taken(&app, "/v1/gears/evaluate", &asked(json!(crowned), json!({}))).await;
    let mut holed = json!(crowned);
    (15..50).for_each(|k| holed[k] = Value::Null);
    let answer = taken(&app, "/v1/gears/evaluate", &asked(holed, json!({}))).await;
    assert_eq!(codes(&answer)[..2], ["undefined_samples", "hole_in_trace"]);
    let number = |answer: &Value, name: &str| answer["traces"][0][name].as_f64().unwrap();
    let error = number(&answer, "slope_std_error_um");
    close(number(&answer, "slope_um"), number(&of_whole, "slope_um"), 3.0 * error + 0.1);
    assert!(error < 0.5 && answer["traces"][0]["class"].get("form").is_none(), "{error}");
    // dust of 40 µm
    let mut dusty = clean.clone();
    dusty[100..103].iter_mut().for_each(|d| *d += 40.0);
    let kept = taken(&app, "/v1/gears/evaluate", &asked(json!(dusty), json!({}))).await;
    assert_eq!(codes(&kept), ["outliers_suspected"]);
    let outliers = &kept["traces"][0]["outliers"];
    close(outliers["places"][0]["from_mm"].as_f64().unwrap(), z[100], 1e-12);
    assert_eq!(outliers["places"][0]["samples"], 3);
    assert!(kept["traces"][0]["form_um"].as_f64().unwrap() > 35.0);
    let without = outliers["without"]["form_um"].as_f64().unwrap();
    assert!((without - whole["traces"][0]["form_um"].as_f64().unwrap()).abs() < 0.5);
    let excluded = taken(&app, "/v1/gears/evaluate", &asked(json!(dusty), json!({"outliers": "exclude"}))).await;
    close(excluded["traces"][0]["form_um"].as_f64().unwrap(), without, 1e-12);
    assert_eq!(excluded["traces"][0]["samples"]["excluded"], 3);
    let wrong = asked(json!(dusty), json!({"outliers": "remove"}));
    assert_eq!(pointers(&app, "/v1/gears/evaluate", &wrong).await, ["/evaluation/outliers"]);
    app.stop().await;
}
