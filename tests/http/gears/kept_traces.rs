//! Parts of a file that an import keeps: its digest and all traces, from which the evaluation
//! follows again and testers' sheets are drawn.

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::{
    import::{file, file_of_flank, file_of_tooth, import, job},
    klingelnberg_file::{Gear, Lines, Style, Trace},
    spur, taken,
};
use crate::{
    harness::{TestApp, send},
    shapes::{close, examples, numbers},
};

/// The first record of the first iteration.
async fn record(app: &TestApp, job: &str) -> Value {
    let records = send(app.get(&format!("{job}/iterations/1/records"))).await.json();
    let id = records["items"][0]["id"].as_str().unwrap().to_owned();
    send(app.get(&format!("{job}/iterations/1/records/{id}"))).await.json()
}

/// The request of a record without what says of which file it is.
fn again(record: &Value) -> Value {
    let mut request = record["request"].clone();
    for name in ["file", "file_sha256", "file_bytes", "spec"] {
        assert!(request.as_object_mut().unwrap().remove(name).is_some(), "{name}");
    }
    request
}

#[tokio::test]
async fn the_request_of_an_import_is_whole() {
    let app = TestApp::start().await;
    // both flanks in one file
    let mut traces = Vec::new();
    for left in [true, false] {
        for (profile, section) in [(true, 7.5), (false, 8.889)] {
            let sign = if left { -1.0 } else { 1.0 };
            let values = (0..60).map(|k| (k != 31).then(|| sign * 0.1 * f64::from(k))).collect();
            traces.push(Trace { tooth: "3".into(), left, profile, index: 1, section, values });
        }
    }
    let mut lines = Lines::new(&Style::default(), "MK");
    lines.gear(&Gear::spur(), false).traces(&traces);
    let tool = json!({"tip_radius_mm": 0.3, "addendum_factor": 1.3});
    let mut own = spur();
    own["tool"] = tool.clone();
    let spec = json!({"evaluation": {"profile_mean": "parabola", "tolerance_limits": {"class": 7}}});
    for (gear, content, spec, count) in [
        (None, lines.bytes(), None, 4),
        (Some(own), lines.bytes(), Some(spec), 4),
        (None, file(true), None, 6),
        (None, file_of_flank(false, false, |_| true), None, 6),
        (Some(spur()), file_of_tooth("01"), None, 6),
    ] {
        let place = job(&app, gear.clone()).await;
        let made = import(&app, &place, content.clone(), "part 7.mka", spec.clone()).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let kept = record(&app, &place).await;
        let digest: String = Sha256::digest(&content).iter().map(|byte| format!("{byte:02x}")).collect();
        let request = &kept["request"];
        assert_eq!((&request["file"], &request["file_sha256"]), (&json!("part 7.mka"), &json!(digest)));
        assert_eq!(request["file_bytes"], content.len());
        assert_eq!(request["spec"], spec.unwrap_or(json!({})));
        assert_eq!(request["gear"].get("tool").is_some(), gear.is_some_and(|gear| gear.get("tool").is_some()));
        assert_eq!(request["traces"].as_array().unwrap().len(), count);
        let answer = taken(&app, "/v1/gears/evaluate", &again(&kept)).await;
        for part in ["traces", "means", "twists", "surfaces", "evaluation"] {
            assert_eq!(answer[part], kept["result"][part], "{part}");
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn traces_keep_their_samples_and_signs() {
    let app = TestApp::start().await;
    let place = job(&app, None).await;
    assert_eq!(import(&app, &place, file(true), "1.mka", None).await.status, 201);
    let kept = record(&app, &place).await;
    let traces = kept["request"]["traces"].as_array().unwrap();
    // as the tester holds them, three digits behind the point, minus the material of a left flank
    let profile = &traces[3];
    assert_eq!((&profile["kind"], &profile["section_z_mm"]), (&json!("profile"), &json!(1.0)));
    let deviation = profile["deviation_um"].as_array().unwrap();
    assert_eq!((deviation.len(), deviation.iter().filter(|d| d.is_null()).count()), (60, 4));
    let at = numbers(&profile["roll_length_mm"]);
    let base = 52.0 * 20f64.to_radians().cos();
    let roll = |d: f64| 0.5 * (d * d - base * base).sqrt();
    for (l, d) in at.iter().zip(deviation).filter_map(|(l, d)| Some((l, d.as_f64()?))) {
        close(d, 10.0 * (l - roll(50.3)) / (roll(54.022) - roll(50.3)) + 6.0 / 15.0, 1e-3);
    }
    app.stop().await;
}

#[tokio::test]
async fn sheets_are_drawn_from_stored_traces() {
    let app = TestApp::start().await;
    let place = job(&app, Some(spur())).await;
    assert_eq!(import(&app, &place, file(false), "1.mka", None).await.status, 201);
    let imported = record(&app, &place).await;
    let posted = taken(&app, "/v1/gears/evaluate", &examples("evaluate_gear")[0].1).await;
    let request = &examples("evaluate_gear")[0].1;
    for (traces, samples) in
        [(&imported["result"]["traces"], &imported["request"]["traces"]), (&posted["traces"], &request["traces"])]
    {
        for (trace, given) in traces.as_array().unwrap().iter().zip(samples.as_array().unwrap()) {
            let [low, high] = numbers(&trace["range_mm"])[..] else { panic!("{trace}") };
            let line = numbers(&trace["mean_line_um"]);
            let parabola = numbers(&trace["mean_parabola_um"]);
            // least squares over the range, sample by sample, with what a sheet has: weights of the
            // samples differ a little from one another, so the figures agree but for a few percent
            let at = ["roll_length_mm", "z_mm", "diameter_mm"].into_iter().find_map(|name| given.get(name)).unwrap();
            let gear_base = 0.5 * 52.0 * 20f64.to_radians().cos();
            let place = |x: &f64| {
                if given.get("diameter_mm").is_some() { (0.25 * x * x - gear_base * gear_base).sqrt() } else { *x }
            };
            let at: Vec<f64> = numbers(at).iter().map(place).collect();
            let heights = given["deviation_um"].as_array().unwrap();
            let within: Vec<(f64, f64)> = at
                .iter()
                .zip(heights)
                .filter(|(x, _)| (low - 1e-6..=high + 1e-6).contains(*x))
                .filter_map(|(x, d)| Some(((2.0 * x - low - high) / (high - low), d.as_f64()?)))
                .collect();
            assert!(within.len() > 5, "{trace}");
            let n = within.len() as f64;
            let mean = |of: &dyn Fn(f64, f64) -> f64| within.iter().map(|(u, d)| of(*u, *d)).sum::<f64>() / n;
            let (u, d) = (mean(&|u, _| u), mean(&|_, d| d));
            let slope = mean(&|x, y| (x - u) * (y - d)) / mean(&|x, _| (x - u) * (x - u));
            let spread = heights.iter().filter_map(Value::as_f64).fold(0.0_f64, |most, d| most.max(d.abs()));
            for (height, end) in line.iter().zip([-1.0, 1.0]) {
                assert!((height - (d + slope * (end - u))).abs() < 0.1 * spread, "{height} {trace}");
            }
            let crowning = trace["crowning_um"].as_f64().unwrap().abs();
            close((parabola[1] - 0.5 * (parabola[0] + parabola[2])).abs(), crowning, 1e-9);
        }
    }
    app.stop().await;
}

#[tokio::test]
async fn a_list_of_points_is_kept_by_its_digest() {
    let app = TestApp::start().await;
    let nominal = json!({"gear": spur(), "flank": "left", "tooth": 1,
        "profile": {"axis": "diameter", "values": [51.0, 52.0, 53.0]}, "face_width_positions_mm": [2.0, 7.0, 12.0]});
    let csv = send(app.post("/v1/gears/flank", nominal.to_string()).header("accept", "text/csv")).await.text;
    let place = job(&app, Some(spur())).await;
    assert_eq!(import(&app, &place, csv.clone().into_bytes(), "p.csv", None).await.status, 201);
    let request = record(&app, &place).await["request"].clone();
    let digest: String = Sha256::digest(csv.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    let whole = json!({"file": "p.csv", "file_sha256": digest, "file_bytes": csv.len(), "spec": {}});
    assert_eq!(request, whole);
    app.stop().await;
}
