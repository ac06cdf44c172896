//! Files out and in again: nodes of a flank as CSV, corrections as CSV, gears of files, models, and
//! files that contradict the job.

use std::process::Command;

use serde_json::{Value, json};

use super::{
    fit_figures::axes,
    import::{file, import, job},
    rexs_file::{Attribute, Model, array, matrix},
    spur, taken,
};
use crate::{
    harness::{TestApp, send},
    shapes::{close, examples},
};

#[tokio::test]
async fn nodes_of_a_flank_go_out_as_points_and_come_back_without_deviation() {
    let app = TestApp::start().await;
    let gear =
        json!({"teeth": 31, "normal_module_mm": 2.0, "helix_angle_deg": 15.0, "hand": "left", "face_width_mm": 20.0});
    let request = json!({"gear": gear, "flank": "right", "tooth": 3,
        "profile": {"axis": "diameter", "values": [62.5, 64.0, 65.5, 67.0]},
                         "face_width_positions_mm": [1.0, 7.0, 13.0, 19.0]});
    let csv = send(app.post("/v1/gears/flank", request.to_string()).header("accept", "text/csv")).await;
    assert_eq!((csv.status.as_u16(), csv.header("content-type")), (200, "text/csv; charset=utf-8"), "{}", csv.text);
    let lines: Vec<&str> = csv.text.lines().collect();
    assert_eq!((lines[0], lines.len()), ("id,x,y,z,i,j,k", 17));
    let json = taken(&app, "/v1/gears/flank", &request).await;
    let numbers: Vec<f64> = lines[6].split(',').skip(1).map(|x| x.parse().unwrap()).collect();
    assert!(lines[6].starts_with("2.2,"));
    for c in 0..3 {
        assert_eq!(Some(numbers[c]), json["points"][1][1][c].as_f64());
        assert_eq!(Some(numbers[3 + c]), json["normals"][1][1][c].as_f64());
    }
    let refused = send(app.post("/v1/gears/flank", request.to_string()).header("accept", "image/png")).await;
    refused.problem(406, "not_acceptable");

    let place = job(&app, Some(gear)).await;
    let made = import(&app, &place, csv.text.clone().into_bytes(), "flank.csv", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    assert!(made.json()["note"].as_str().unwrap().contains("right flank of tooth 3"), "{}", made.json()["note"]);
    for c in made.json()["fits"][0]["result"]["coefficients"].as_array().unwrap() {
        assert!(c["least_squares"].as_f64().unwrap().abs() < 1e-6, "{c}");
    }
    let records = send(app.get(&format!("{place}/iterations/1/records"))).await.json();
    assert_eq!(records["items"][0]["kind"], "deviations");
    let id = records["items"][0]["id"].as_str().unwrap();
    let kept = send(app.get(&format!("{place}/iterations/1/records/{id}"))).await.json();
    assert_eq!((&kept["result"]["count"], &kept["result"]["tooth"][0]), (&json!(16), &json!(3)));
    app.stop().await;
}

#[tokio::test]
async fn a_correction_goes_out_under_the_names_of_the_standard() {
    let app = TestApp::start().await;
    let place = format!("{}/iterations", job(&app, Some(spur())).await);
    let (u, v) = ([6.0, 8.0, 10.0, 12.0], [1.0, 4.0, 7.5, 11.0, 14.0]);
    let rows: Vec<Vec<f64>> = u.iter().map(|u| v.iter().map(|v| 3.0 * u - 2.0 * v).collect()).collect();
    let nodes = json!({"nodes": {"type": "grid", "u": u, "v": v, "z": rows}, "flank": "left", "axes": axes(),
        "model": {"type": "polynomial", "degree": 2, "terms": "total"}});
    assert_eq!(send(app.post(&place, nodes.to_string())).await.status, 201);
    let mut request = examples("create_iteration_correction")[0].1.clone();
    request["limits"] = json!({"profile_angle": {"min": -1.0, "max": 1.0}});
    let kept = send(app.post(&format!("{place}/1/correction"), request.to_string())).await;
    assert_eq!(kept.status, 201, "{}", kept.text);
    let csv = send(app.get(&format!("{place}/1/correction")).header("accept", "text/csv")).await;
    assert_eq!((csv.status.as_u16(), csv.header("content-type")), (200, "text/csv; charset=utf-8"), "{}", csv.text);
    let lines: Vec<Vec<&str>> = csv.text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 8);
    assert_eq!(
        lines[0][..4],
        ["Identifier", "CharacteristicIdentifier", "CorrectionValueRelative", "CorrectionValueAbsolute"]
    );
    for (line, setting) in lines[1..].iter().zip(kept.json()["result"]["settings"].as_array().unwrap()) {
        assert_eq!(line[0], setting["name"].as_str().unwrap());
        // rounded to the second digit of its standard error
        let error = setting["std_error"].as_f64().unwrap_or(0.0);
        let change = line[2].parse::<f64>().unwrap();
        assert!((change - setting["change"].as_f64().unwrap()).abs() <= 0.05 * error, "{line:?} {setting}");
        let (sign, id) = if setting["unit"] == "arcmin" { ("′", "4470321") } else { ("µm", "13384") };
        assert_eq!((line[6], line[7]), (sign, id));
    }
    assert_eq!((lines[1][4], lines[1][5], lines[2][4]), ("1.0", "-1.0", ""));
    // a name of blanks would be no identifier
    let blank = json!({"sensitivity": {"type": "matrix", "settings": [" "], "matrix": vec![[1.0]; 20]}});
    let refused = send(app.post(&format!("{place}/1/correction"), blank.to_string())).await;
    assert_eq!(refused.pointers(), ["/sensitivity/settings/0"], "{}", refused.text);
    let refused = send(app.get(&format!("{place}/1/correction")).header("accept", "image/png")).await;
    refused.problem(406, "not_acceptable");
    app.stop().await;
}

/// A model of one gear, with deviations of 2 µm per mm of z on its left flank.
fn model() -> Vec<u8> {
    let attribute = |id: &'static str, unit: &'static str, value: String| -> Attribute { (id, unit, value) };
    let (diameters, z) = ([50.5, 51.5, 52.5, 53.5], [1.0, 5.0, 9.0, 13.0]);
    let amounts: Vec<f64> = diameters.iter().flat_map(|_| z.iter().map(|z| 2e-3 * z)).collect();
    let mut model = Model::default();
    let gear = [
        attribute("number_of_teeth", "none", "52".into()),
        attribute("normal_module", "mm", "1.0".into()),
        attribute("normal_pressure_angle", "deg", "20".into()),
        attribute("helix_angle", "deg", "0".into()),
        attribute("addendum_modification_coefficient", "none", "0.011".into()),
        attribute("face_width", "mm", "15".into()),
    ];
    let left = [
        attribute("topographical_deviation_amounts", "mm", matrix(4, &amounts)),
        attribute("diameters_of_topographical_deviation", "mm", array(&diameters)),
        attribute("coordinates_of_topographical_deviation", "mm", array(&z)),
    ];
    model.component(7, "cylindrical_gear", "wheel", &gear);
    model.component(8, "cylindrical_gear_flank", "left", &left);
    model.component(9, "cylindrical_gear_flank", "right", &[]).flanks(7, 8, 9);
    model.component(10, "cylindrical_gear", "pinion", &gear[..2]);
    model.text("1.4").into_bytes()
}

#[tokio::test]
async fn a_model_gives_its_gears_and_its_topographies() {
    let app = TestApp::start().await;
    let form = |content: Vec<u8>| {
        let part = reqwest::multipart::Part::bytes(content).file_name("m.rexs");
        app.client.post(app.url("/v1/gears/read")).multipart(reqwest::multipart::Form::new().part("file", part))
    };
    let read = send(form(model())).await;
    assert_eq!(read.status, 200, "{}", read.text);
    let body = read.json();
    assert_eq!((&body["format"], body["gears"].as_array().unwrap().len()), (&json!("rexs"), 2));
    let [wheel, pinion] = [&body["gears"][0], &body["gears"][1]];
    assert_eq!(
        (&wheel["id"], &wheel["name"], &wheel["topographies"]),
        (&json!("7"), &json!("wheel"), &json!(["left"]))
    );
    assert_eq!(wheel["gear"]["normal_pressure_angle_deg"], 20.0);
    assert_eq!((pinion.get("gear"), wheel.get("known")), (None, None));
    assert_eq!(pinion["known"], json!({"teeth": 52, "normal_module_mm": 1.0, "internal": false}));
    assert!(pinion["missing"].as_array().unwrap().contains(&json!("helix_angle_deg")), "{pinion}");
    // what was read is what a job takes
    let place = job(&app, Some(wheel["gear"].clone())).await;
    let ambiguous = import(&app, &place, model(), "m.rexs", None).await;
    assert_eq!(ambiguous.pointers(), ["/spec/component"], "{}", ambiguous.text);
    let made = import(&app, &place, model(), "m.rexs", Some(json!({"component": "7"}))).await;
    assert_eq!(made.status, 201, "{}", made.text);
    assert_eq!(made.json()["node_count"], 16);
    // forms have no limit of their own
    let mut long = model();
    long.extend(format!("<!--{}-->", " x".repeat(3 << 19)).into_bytes());
    assert_eq!(send(form(long.clone())).await.json()["gears"], body["gears"]);
    let made = import(&app, &place, long, "m.rexs", Some(json!({"component": "7"}))).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let fit = &made.json()["fits"][0]["result"];
    let v = fit["coefficients"].as_array().unwrap().iter().find(|c| c["term"] == "v").unwrap().clone();
    close(v["least_squares"].as_f64().unwrap(), 2.0, 1e-9);
    let nothing = import(&app, &place, model(), "m.rexs", Some(json!({"component": "10"}))).await;
    assert_eq!(nothing.pointers(), ["/file"]);
    // a tester's file describes its gear too; points do not
    let of_curves = send(form(file(false))).await.json();
    assert_eq!((&of_curves["format"], &of_curves["gears"][0]["gear"]["teeth"]), (&json!("curves"), &json!(52)));
    assert_eq!(send(form(b"x,y,z\n1,2,3\n".to_vec())).await.pointers(), ["/file"]);
    assert_eq!(send(form(b"<model".to_vec())).await.pointers(), ["/file"]);
    app.stop().await;
}

#[tokio::test]
async fn files_of_another_gear_are_refused_and_differences_warned_of() {
    let app = TestApp::start().await;
    let with = |name: &str, value: Value| {
        let mut gear = spur();
        gear[name] = value;
        gear
    };
    let other = job(&app, Some(with("teeth", json!(51)))).await;
    let refused = import(&app, &other, file(false), "1.mka", None).await;
    assert_eq!((refused.status.as_u16(), refused.pointers()), (422, vec!["/file".to_owned()]), "{}", refused.text);
    assert!(refused.text.contains("52") && refused.text.contains("51"), "{}", refused.text);
    assert_eq!(send(app.get(&format!("{other}/iterations/1"))).await.status, 404);
    // with a given gear it is imported all the same
    let asked = import(&app, &other, file(false), "1.mka", Some(json!({"gear": with("teeth", json!(51))}))).await;
    assert_eq!(asked.status, 201, "{}", asked.text);
    let shifted = job(&app, Some(with("profile_shift_coefficient", json!(0.2)))).await;
    let made = import(&app, &shifted, file(false), "1.mka", None).await;
    assert_eq!(made.status, 201, "{}", made.text);
    for (place, name) in [(&other, "teeth"), (&shifted, "profile_shift_coefficient")] {
        let records = send(app.get(&format!("{place}/iterations/1/records"))).await.json();
        let id = records["items"][0]["id"].as_str().unwrap();
        let kept = send(app.get(&format!("{place}/iterations/1/records/{id}"))).await.json();
        let warnings = kept["result"]["warnings"].as_array().unwrap();
        let warned =
            warnings.iter().any(|w| w["code"] == "gear_differs" && w["message"].as_str().unwrap().contains(name));
        assert!(warned, "{warnings:?}");
    }
    // the job's own gear takes precedence
    let own = job(&app, Some(spur())).await;
    assert_eq!(import(&app, &own, file(false), "1.mka", None).await.status, 201);
    let records = send(app.get(&format!("{own}/iterations/1/records"))).await.json();
    let id = records["items"][0]["id"].as_str().unwrap();
    let kept = send(app.get(&format!("{own}/iterations/1/records/{id}"))).await.json();
    assert!(!kept["result"]["warnings"].to_string().contains("gear_differs"), "{}", kept["result"]["warnings"]);
    app.stop().await;
}

#[test]
fn the_program_reads_models_and_points() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_flankfit")).arg("evaluate").args(arguments).output().unwrap();
        (output.status.success(), String::from_utf8([output.stdout, output.stderr].concat()).unwrap())
    };
    let rexs = write("m.rexs", &model());
    let (done, text) = run(&[&rexs]);
    assert!(done && text.contains("wheel") && text.contains("helix_angle_deg"), "{text}");
    let (done, text) = run(&[&rexs, "--component", "7"]);
    // 2 µm per mm at 1 to 13 mm: 14 µm in the middle
    assert!(done && text.contains("14.00") && text.contains("26.00"), "{text}");
    let (done, json) = run(&[&rexs, "--component", "7", "--json"]);
    let body: Value = serde_json::from_str(json.lines().next().unwrap()).unwrap();
    assert!(done && body["count"] == 16, "{json}");
    let (done, text) = run(&[&rexs, "--component", "12"]);
    assert!(!done && text.contains('7'), "{text}");
    let gear = write("gear.json", spur().to_string().as_bytes());
    let base = 26.0 * 20f64.to_radians().cos();
    let half = (std::f64::consts::FRAC_PI_2 + 2.0 * 0.011 * 20f64.to_radians().tan()) / 52.0;
    // the left flank's point on the reference circle, and 5 µm out along the base tangent
    let angle = std::f64::consts::FRAC_PI_2 + half;
    let (x, y) = (26.0 * angle.cos(), 26.0 * angle.sin());
    assert!(base < 26.0 && x < 0.0);
    let csv = write("p.csv", format!("id,x,y,z\na,{x},{y},5\nb,{x},{y},6\n").as_bytes());
    let (done, text) = run(&[&csv, "--gear", &gear]);
    assert!(done && text.contains("left") && text.contains("0.00"), "{text}");
    let (done, text) = run(&[&csv]);
    assert!(!done && text.contains("gear"), "{text}");
}

/// A helix of a model that rises by 2 µm for each mm of z becomes nodes and an evaluation.
#[tokio::test]
async fn measured_traces_of_a_model_are_imported() {
    let app = TestApp::start().await;
    let z: Vec<f64> = (0..30).map(|k| 0.5 * f64::from(k)).collect();
    let amounts: Vec<f64> = z.iter().map(|z| 2e-3 * z).collect();
    let mut model = Model::default();
    let gear: [Attribute; 6] = [
        ("number_of_teeth", "none", "52".into()),
        ("normal_module", "mm", "1.0".into()),
        ("normal_pressure_angle", "deg", "20".into()),
        ("helix_angle_reference_diameter", "deg", "0".into()),
        ("addendum_modification_coefficient", "none", "0.011".into()),
        ("face_width", "mm", "15".into()),
    ];
    let helix: [Attribute; 3] = [
        ("helix_deviation_amounts", "mm", array(&amounts)),
        ("coordinates_of_helix_deviation", "mm", array(&z)),
        ("diameter_of_helix_deviation", "mm", "51.898".into()),
    ];
    model.component(7, "cylindrical_gear", "wheel", &gear);
    model.component(8, "cylindrical_gear_flank", "left", &[]);
    model.component(9, "cylindrical_gear_flank", "right", &[]).flanks(7, 8, 9);
    model.component(11, "helix_deviation", "", &helix).reference(8, 11);
    let text = model.text("2.0.0").into_bytes();
    let part = reqwest::multipart::Part::bytes(text.clone()).file_name("m.rexs");
    let form = reqwest::multipart::Form::new().part("file", part);
    let read = send(app.client.post(app.url("/v1/gears/read")).multipart(form)).await.json();
    assert_eq!((&read["traces"][0]["kind"], &read["traces"][0]["samples"]), (&json!("helix"), &json!(30)));
    let place = job(&app, Some(read["gears"][0]["gear"].clone())).await;
    let spec = json!({"evaluation": {"helix_range_mm": [1.0, 14.0], "helix_reference": "evaluation_range"}});
    let made = import(&app, &place, text, "m.rexs", Some(spec)).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let records = send(app.get(&format!("{place}/iterations/1/records"))).await.json();
    let kept = records["items"].as_array().unwrap().iter().find(|item| item["kind"] == "evaluation").unwrap();
    let kept = send(app.get(&format!("{place}/iterations/1/records/{}", kept["id"].as_str().unwrap()))).await.json();
    let slope = kept["result"]["traces"][0]["slope_um"].as_f64().unwrap();
    assert!((slope.abs() - 26.0).abs() < 1e-9, "{slope}");
    app.stop().await;
}
