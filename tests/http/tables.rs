//! Tables of nodes and points: what they are proposed to be, and how they become iterations.

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::harness::{Answer, TestApp, send};

fn example(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/examples/files/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn file(name: &str, bytes: Vec<u8>) -> Form {
    Form::new().part("file", Part::bytes(bytes).file_name(name.to_owned()))
}

async fn read(app: &TestApp, query: &str, form: Form) -> Answer {
    send(app.client.post(app.url(&format!("/v1/nodes/read{query}"))).multipart(form)).await
}

async fn job(app: &TestApp) -> String {
    let example: Value =
        serde_json::from_str(include_str!("../../examples/requests/job.json")).expect("an example of a job");
    let answer = send(app.post("/v1/jobs", example.to_string())).await;
    format!("/v1/jobs/{}", answer.json()["id"].as_str().unwrap())
}

async fn import(app: &TestApp, job: &str, form: Form) -> Answer {
    send(app.client.post(app.url(&format!("{job}/import"))).multipart(form)).await
}

#[tokio::test]
async fn a_table_is_proposed_with_meanings_units_and_words() {
    let app = TestApp::start().await;
    let answer = read(&app, "?include=nodes", file("f.csv", example("flank_german.csv"))).await;
    assert_eq!(answer.status, 200, "{}", answer.text);
    let body = answer.json();
    assert_eq!((&body["separator"], &body["decimal"]), (&json!(";"), &json!(",")));
    assert_eq!((&body["header"], &body["matrix"], &body["layout"]), (&json!(true), &json!(false), &json!("grid")));
    assert_eq!((&body["nodes"], &body["missing"], &body["warnings"]), (&json!(132), &json!(3), &json!([])));
    assert_eq!(body["columns"][0], json!({"name": "Rollweg [mm]", "meaning": "roll_length", "unit": "mm"}));
    assert_eq!(body["columns"][2]["unit"], "um");
    assert_eq!(body["flanks"], json!([{"nodes": 132, "missing": 3}]));
    let words = "roll length 5.97–11.5 mm, face width 0.75–14.2 mm";
    assert!(body["preview"]["text"].as_str().unwrap().contains(words), "{}", body["preview"]);
    assert_eq!(body["preview"]["greatest_deviation_um"], 11.96);
    assert_eq!(
        body["preview"]["ranges"][1],
        json!({"column": 1, "meaning": "face_width", "unit": "mm",
        "min": 0.75, "max": 14.25})
    );
    let grid: Value = serde_json::from_str(include_str!("../../examples/flank_z52.json")).unwrap();
    assert_eq!(body["read"]["u"], grid["nodes"]["u"]);
    assert_eq!(body["read"]["z"][0][1], grid["nodes"]["z"][0][1]);
    assert_eq!(body["read"]["z"][0][0], Value::Null);
    // the same table in other forms, alone as a body too
    for (media, name) in
        [("text/csv", "flank_grid.csv"), ("application/octet-stream", "flank_matrix.csv"), ("text/plain", "points.txt")]
    {
        let request = app.client.post(app.url("/v1/nodes/read")).header("content-type", media).body(example(name));
        let answer = send(request).await;
        assert_eq!(answer.status, 200, "{name}: {}", answer.text);
        let layout = if name == "points.txt" { "points" } else { "grid" };
        assert_eq!(answer.json()["layout"], layout, "{name}");
        assert!(answer.json().get("read").is_none());
    }
}

/// The proposal is a mapping, and can be sent as one.
#[tokio::test]
async fn a_proposal_is_a_mapping() {
    let app = TestApp::start().await;
    for name in ["flank_german.csv", "flank_grid.csv", "flank_matrix.csv", "points.txt"] {
        let first = read(&app, "", file(name, example(name))).await.json();
        let mut mapping = json!({});
        for member in ["separator", "decimal", "header", "matrix", "columns", "layout"] {
            mapping[member] = first[member].clone();
        }
        let again = read(&app, "", file(name, example(name)).text("mapping", mapping.to_string())).await;
        let mut again = again.json();
        assert_eq!(again["proposed_from"], "mapping");
        again["proposed_from"] = json!("file");
        assert_eq!(again, first, "{name}");
        mapping["columns"][2]["unit"] = json!("mm");
        if name != "points.txt" {
            let other = read(&app, "", file(name, example(name)).text("mapping", mapping.to_string())).await.json();
            assert_eq!(other["preview"]["greatest_deviation_um"], 11960.0, "{name}");
        }
    }
}

#[tokio::test]
async fn unreadable_tables_have_one_summary_and_five_places() {
    let app = TestApp::start().await;
    let table = format!("u,v,z\n{}", "5,97;0,75;-10,28\n".repeat(135));
    let mapping = r#"{"separator": ","}"#;
    let refused = read(&app, "", file("a.csv", table.clone().into_bytes()).text("mapping", mapping)).await;
    let pointers = [vec!["/mapping/separator"], vec!["/file"; 5]].concat();
    assert_eq!(refused.pointers(), pointers, "{}", refused.text);
    let sentence = "135 rows have 4 cells for 3 columns; with decimal commas they have 3: send `decimal: \\\",\\\"` and \
                    leave out `separator`";
    assert!(refused.text.contains(sentence), "{}", refused.text);
    let mended = read(&app, "", file("a.csv", table.clone().into_bytes()).text("mapping", r#"{"decimal": ","}"#)).await;
    assert_eq!(mended.json()["separator"], ";");
    // without a word about the separator it is read as it is meant
    let body = read(&app, "", file("a.csv", table.into_bytes())).await.json();
    assert_eq!((&body["separator"], &body["decimal"], &body["header"]), (&json!(";"), &json!(","), &json!(true)));
    assert_eq!(read(&app, "", file("a.csv", b"hello".to_vec())).await.pointers(), ["/file"]);
    let foreign = b"roll length [mm],face width [mm],deviation [mil]\n6,1,0.2\n6,2,0.3\n7,1,0.2\n7,2,0.1\n".to_vec();
    let foreign = read(&app, "", file("a.csv", foreign)).await;
    assert!(foreign.pointers() == ["/file"] && foreign.text.contains("column 3 is in `mil`"), "{}", foreign.text);
    assert_eq!(read(&app, "?include=rows", file("a.csv", b"1,2".to_vec())).await.pointers(), ["/include"]);
    let spec = file("a.csv", b"x,y\n1,2\n".to_vec()).text("spec", "{}");
    assert_eq!(read(&app, "", spec).await.pointers(), ["/spec"]);
    assert_eq!(send(app.post("/v1/nodes/read", "{}")).await.pointers(), ["/file"]);
    let unknown = read(&app, "", file("a.csv", b"rest,roll length,more,even\n1,2,3,4\n".to_vec())).await.json();
    assert!(unknown.get("layout").is_none());
    assert_eq!(unknown["warnings"].as_array().unwrap().last().unwrap()["code"], "columns_unknown");
}

/// A table becomes an iteration with its own units, on its grid, whatever its form.
#[tokio::test]
async fn an_import_takes_tables() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let mut sums = Vec::new();
    for (number, name) in (1..).zip(["flank_grid.csv", "flank_german.csv", "flank_matrix.csv"]) {
        let spec = json!({"flank": "left", "tooth": "1", "instrument": "P40"}).to_string();
        let made = import(&app, &job, file(name, example(name)).text("spec", spec)).await;
        assert_eq!(made.status, 201, "{name}: {}", made.text);
        let stored = send(app.get(&format!("{job}/iterations/{number}"))).await.json();
        assert_eq!(
            (&stored["flank"], &stored["tooth"], &stored["instrument"]),
            (&json!("left"), &json!("1"), &json!("P40"))
        );
        assert_eq!(stored["axes"]["u"], json!({"quantity": "roll_length", "unit": "mm"}), "{name}");
        assert_eq!(stored["axes"]["z"]["unit"], "um");
        let nodes = send(app.get(&format!("{job}/iterations/{number}/nodes"))).await.json();
        assert_eq!((&nodes["type"], nodes["u"].as_array().unwrap().len()), (&json!("grid"), 9), "{name}");
        assert_eq!(nodes["z"][0][0], Value::Null, "{name}: a hole");
        sums.push(nodes);
    }
    assert!(sums.iter().all(|nodes| *nodes == sums[0]));
    // heights in mm by a mapping, which goes with the file
    let columns = json!({"columns": [{"meaning": "roll_length"}, {"meaning": "face_width"},
        {"meaning": "deviation", "unit": "mm"}]});
    let made = import(&app, &job, file("a.csv", example("flank_grid.csv")).text("mapping", columns.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let stored = send(app.get(&format!("{job}/iterations/4"))).await.json();
    assert_eq!(stored["axes"]["z"]["unit"], "mm");
    // points are of the job's gear
    let made = import(&app, &job, file("points.txt", example("points.txt"))).await;
    assert_eq!(made.status, 201, "{}", made.text);
}

#[tokio::test]
async fn of_several_flanks_one_is_imported() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let mut table = "Zahn;Flanke;Rollweg [mm];Breite [mm];Abweichung [µm]\r\n".to_owned();
    for (tooth, flank, rows) in [(1, "links", 5), (1, "rechts", 4), (2, "links", 4)] {
        for u in 0..rows {
            for v in 0..3 {
                table += &format!("{tooth};{flank};{};{v};{},5\r\n", 6 + u, u * v);
            }
        }
    }
    let form = |spec: Value| file("t.csv", table.clone().into_bytes()).text("spec", spec.to_string());
    for (number, spec, tooth, flank) in [
        (1, json!({}), "1", "left"),
        (2, json!({"flank": "right"}), "1", "right"),
        (3, json!({"tooth": "2"}), "2", "left"),
    ] {
        let made = import(&app, &job, form(spec)).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let stored = send(app.get(&format!("{job}/iterations/{number}"))).await.json();
        assert_eq!((&stored["tooth"], &stored["flank"]), (&json!(tooth), &json!(flank)));
    }
    let refused = import(&app, &job, form(json!({"tooth": "7"}))).await;
    assert_eq!(refused.pointers(), ["/spec/tooth"]);
    assert!(refused.text.contains("the left flank of tooth 2"), "{}", refused.text);
    // a fit takes one flank
    let spec = r#"{"model":{"type":"polynomial","degree":[1,1]}}"#;
    let fit = send(
        app.client.post(app.url("/v1/fits")).multipart(Form::new().text("spec", spec).text("nodes", table.clone())),
    );
    let refused = fit.await;
    assert_eq!(refused.pointers(), ["/nodes"]);
    assert!(refused.text.contains("nodes of 3 flanks"), "{}", refused.text);
}

/// A form without axes takes those of its table; what the spec says goes before.
#[tokio::test]
async fn a_form_takes_the_axes_of_its_table() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let spec = json!({"model": {"type": "polynomial", "degree": [2, 2], "basis": "legendre"}, "flank": "left"});
    let own = json!({"u": {"quantity": "diameter", "unit": "mm"}});
    for (number, axes, wanted) in [(1, Value::Null, "roll_length"), (2, own, "diameter")] {
        let mut spec = spec.clone();
        spec["axes"] = axes;
        let form = Form::new()
            .text("spec", spec.to_string())
            .part("nodes", Part::bytes(example("flank_german.csv")).file_name("f.csv"));
        let made = send(app.client.post(app.url(&format!("{job}/iterations"))).multipart(form)).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let stored = send(app.get(&format!("{job}/iterations/{number}"))).await.json();
        assert_eq!(stored["axes"]["u"]["quantity"], wanted);
    }
}

/// Faults of a mapping are pointed at in the mapping, by every endpoint that takes one.
#[tokio::test]
async fn errors_of_a_mapping_have_pointers_into_it() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let spec = r#"{"model":{"type":"polynomial","degree":[1,1]}}"#;
    let grid = b"a,b,c\n1,1,1.5\n1,2,2.5\n2,1,3\n2,2,4\n";
    let u = json!({"meaning": "u"});
    for (mapping, wanted, words) in [
        (json!({"columns": [u]}), "/mapping/columns", "the mapping has 1 column for 3 columns"),
        (json!({"columns": [u, u, {"meaning": "z"}]}), "/mapping/columns/1/meaning", "make one of them `ignore`"),
        (
            json!({"columns": [u, {"meaning": "v"}, {"meaning": "deviation", "unit": "deg"}]}),
            "/mapping/columns/2/unit",
            "send `nm` or `um` or `mm` or `in`",
        ),
        (json!({"columns": [u, {"meaning": "v"}, {"meaning": "ignore"}]}), "/mapping/columns", "has heights"),
        (
            json!({"layout": "scattered", "columns": [u, {"meaning": "ignore"}, {"meaning": "z"}]}),
            "/mapping/layout",
            "curve",
        ),
        (
            json!({"decimal": ",", "columns": [u, {"meaning": "v"}, {"meaning": "z"}]}),
            "/mapping/decimal",
            "send `separator: \\\",\\\"`",
        ),
        (json!({"separator": ":"}), "/mapping/separator", "`;`"),
    ] {
        let own = |part: &'static str| {
            Form::new().part(part, Part::bytes(grid.as_slice()).file_name("a.csv")).text("mapping", mapping.to_string())
        };
        let fit = send(app.client.post(app.url("/v1/fits")).multipart(own("nodes").text("spec", spec))).await;
        // what makes no nodes yet is proposed all the same, with a warning
        let proposed = Some(read(&app, "", own("file")).await).filter(|_| words != "has heights");
        for refused in proposed.into_iter().chain([import(&app, &job, own("file")).await, fit]) {
            assert_eq!(refused.pointers()[0], wanted, "{mapping}: {}", refused.text);
            assert!(refused.text.contains(words), "{mapping}: {}", refused.text);
        }
    }
}

#[tokio::test]
async fn an_unknown_flank_is_named_with_its_line() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let table = b"Flanke;Rollweg;Breite;Abweichung\nlinks;1;1;1\nlinkss;1;2;2\nlinks;2;1;3\n";
    let words = "line 3: `linkss` is not a flank; write left, l, links, linke, lf for left and right, r, rechts";
    let body = read(&app, "", file("a.csv", table.to_vec())).await.json();
    let warning = body["warnings"].as_array().unwrap().last().unwrap().clone();
    assert_eq!((body.get("layout"), &warning["code"]), (None, &json!("flank_unknown")), "{body}");
    assert!(warning["message"].as_str().unwrap().starts_with(words), "{warning}");
    let refused = import(&app, &job, file("a.csv", table.to_vec())).await;
    assert_eq!(refused.pointers(), ["/file"], "{}", refused.text);
    assert!(refused.text.contains(words), "{}", refused.text);
}

/// The helices of the right flank of a real file count against its profiles (32 µm rms apart at
/// nine crossings, 0.4 µm when turned): an import turns them, and its note says so; a
/// fit of such a table is refused.
#[tokio::test]
async fn helices_are_turned_at_import() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/engine/tests/data/p40/97340-neu_nodes.csv");
    let table = std::fs::read(path).unwrap();
    let body = read(&app, "", file("p40.csv", table.clone())).await.json();
    let turned: Vec<&str> = body["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|warning| warning["code"] == "helices_turned")
        .map(|warning| warning["message"].as_str().unwrap().split(':').next().unwrap())
        .collect();
    assert_eq!(turned, ["the right flank of tooth 1", "the right flank of tooth 12", "the right flank of tooth 22"]);
    // the first sample with a height: 4.729 µm on the left flank, −29.02 µm on the right one
    let printed = |flank: &str| -> f64 {
        let text = std::str::from_utf8(&table).unwrap();
        let line = text.lines().find(|line| line.starts_with(&format!("{flank},1,lead,12,"))).unwrap();
        line.rsplit(',').next().unwrap().parse().unwrap()
    };
    for (number, flank, sign) in [(1, "left", 1.0), (2, "right", -1.0)] {
        let spec = json!({"flank": flank, "tooth": "1"}).to_string();
        let made = import(&app, &job, file("p40.csv", table.clone()).text("spec", spec)).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let nodes = send(app.get(&format!("{job}/iterations/{number}/nodes"))).await.json();
        assert_eq!(nodes["z"][0], sign * printed(flank), "{flank}");
        let stored = send(app.get(&format!("{job}/iterations/{number}"))).await.json();
        assert_eq!(stored["note"].as_str().unwrap().contains("are reversed"), sign < 0.0, "{stored}");
    }
    // a fit has no note to say so
    let spec = json!({"model": {"type": "polynomial", "degree": [2, 2], "basis": "legendre"}}).to_string();
    for (flank, status) in [("left", 200), ("right", 422)] {
        let text = std::str::from_utf8(&table).unwrap();
        let is_of = |line: &&str| {
            let [side, tooth] = [0, 1].map(|k| line.split(',').nth(k).unwrap());
            side == "flank" || (side == flank && ["1", "1f", "1k", "1o", "1u"].contains(&tooth))
        };
        let own = text.lines().filter(is_of).collect::<Vec<_>>().join("\n");
        let form =
            Form::new().text("spec", spec.clone()).part("nodes", Part::bytes(own.into_bytes()).file_name("f.csv"));
        let fitted = send(app.client.post(app.url("/v1/fits")).multipart(form)).await;
        assert_eq!(fitted.status, status, "{}", fitted.text);
        assert!(status == 200 || fitted.text.contains("have the opposite sign"), "{}", fitted.text);
    }
}

/// The mapping of an import, or of an iteration made of a table, is proposed for the next table of
/// the same form and instrument, and for no other.
#[tokio::test]
async fn a_mapping_is_remembered() {
    let app = TestApp::start().await;
    let job = job(&app).await;
    let table = |rows: &str| format!("Tiefe;Ort;Rest\n{rows}").into_bytes();
    let first = table("5,5;1;7\n5,5;2;8\n6;1;9\n6;2;10\n7;1;7\n7;2;9\n");
    let next = table("5,5;1;0\n5,5;3;1\n6;1;2\n6;3;4\n");
    let columns = json!([{"meaning": "roll_length", "unit": "mm"}, {"meaning": "face_width", "unit": "mm"},
        {"meaning": "deviation", "unit": "nm"}]);
    let mapping = json!({"columns": columns}).to_string();
    let proposed = async |query: &str, content: &[u8]| read(&app, query, file("a.csv", content.to_vec())).await.json();
    let before = proposed("?instrument=P40", &next).await;
    assert_eq!((&before["proposed_from"], &before["columns"][2]["meaning"]), (&json!("file"), &json!("z")));
    let form = |instrument: Option<&str>| {
        let spec = instrument.map_or(json!({}), |name| json!({"instrument": name}));
        file("a.csv", first.clone()).text("mapping", mapping.clone()).text("spec", spec.to_string())
    };
    let made = import(&app, &job, form(Some("P40"))).await;
    assert_eq!(made.status, 201, "{}", made.text);
    let kept = proposed("?instrument=P40", &next).await;
    assert_eq!(kept["proposed_from"], "kept");
    assert_eq!(kept["columns"][2], json!({"name": "Rest", "meaning": "deviation", "unit": "nm"}));
    assert_eq!(kept["preview"]["greatest_deviation_um"], 0.004);
    // another instrument, none, another form, and one that cannot be read so
    for (query, content) in [
        ("?instrument=P41", next.clone()),
        ("", next.clone()),
        ("?instrument=P40", String::from_utf8(next.clone()).unwrap().replace("Ort", "Platz").into_bytes()),
        ("?instrument=P40", table("5,5;1;0\n5,5;3;links\n5,5;4;links\n6;3;rechts\n6;1;rechts\n")),
    ] {
        assert_eq!(proposed(query, &content).await["proposed_from"], "file", "{query}");
    }
    // what the request says goes before
    let sent = read(&app, "?instrument=P40", file("a.csv", next.clone()).text("mapping", "{}")).await.json();
    assert_eq!((&sent["proposed_from"], &sent["columns"]), (&json!("mapping"), &before["columns"]));
    // an iteration of a form keeps its mapping too, without an instrument for tables without one
    let spec = json!({"model": {"type": "polynomial", "degree": [1, 1]}}).to_string();
    let form = Form::new()
        .text("spec", spec)
        .text("mapping", mapping.clone())
        .part("nodes", Part::bytes(first.clone()).file_name("a.csv"));
    let made = send(app.client.post(app.url(&format!("{job}/iterations"))).multipart(form)).await;
    assert_eq!(made.status, 201, "{}", made.text);
    assert_eq!(proposed("", &next).await["proposed_from"], "kept");
    let refused = read(&app, "?instrument=", file("a.csv", next)).await;
    assert_eq!(refused.pointers(), ["/instrument"], "{}", refused.text);
}

/// Traces of a cross, or of three profiles and three helices, as a table, each moved by a zero of
/// its own: f_Hα 9 µm, C_α 3 µm, f_Hβ −6 µm.
fn traces(each: usize, zero: f64) -> Vec<u8> {
    let of = |u: f64, v: f64| {
        let (x, y) = ((u - 9.0) / 3.0, (v - 7.5) / 6.5);
        4.5 * x - 3.0 * x * x - 3.0 * y + 0.2 * (7.0 * u + 3.0 * v).sin()
    };
    let sections = |low: f64, high: f64| -> Vec<f64> {
        if each == 1 { vec![0.5 * (low + high)] } else { vec![low, 0.5 * (low + high), high] }
    };
    let mut text = "flank;tooth;trace;roll_length [mm];face_width [mm];deviation [um]\n".to_owned();
    for (k, v) in sections(1.0, 14.0).into_iter().enumerate() {
        for u in (0..=30).map(|i| 6.0 + 0.2 * f64::from(i)) {
            text += &format!("left;1;profile;{u:.3};{v:.3};{:.4}\n", of(u, v) + zero * (2.0 + k as f64));
        }
    }
    for (k, u) in sections(6.0, 12.0).into_iter().enumerate() {
        for v in (0..=26).map(|i| 1.0 + 0.5 * f64::from(i)) {
            text += &format!("left;1;helix;{u:.3};{v:.3};{:.4}\n", of(u, v) - zero * (1.0 + 3.0 * k as f64));
        }
    }
    text.into_bytes()
}

/// Traces that do not meet where they cross have a zero each: an import says so and leaves figures
/// to their evaluation, as with a tester's file, and a fit of the table is refused. The surface
/// that is stored has the slopes and crownings all the same.
#[tokio::test]
async fn traces_with_zeros_of_their_own() {
    let app = TestApp::start().await;
    let gear = json!({"teeth": 52, "normal_module_mm": 1.0, "face_width_mm": 15.0});
    let made = send(app.post("/v1/jobs", json!({"name": "w", "gear": gear}).to_string())).await.json();
    let job = format!("/v1/jobs/{}", made["id"].as_str().unwrap());
    let codes = |figures: &Value| -> Vec<String> {
        let all = figures["warnings"].as_array().cloned().unwrap_or_default();
        all.iter().map(|warning| warning["code"].as_str().unwrap().to_owned()).collect()
    };
    let model = json!({"model": {"type": "polynomial", "degree": 2, "terms": "total"}}).to_string();
    let fit = async |table: Vec<u8>| {
        let form = Form::new().text("spec", model.clone());
        let form = form.part("nodes", Part::bytes(table).file_name("f.csv"));
        send(app.client.post(app.url("/v1/fits")).multipart(form)).await
    };
    for (each, lengths) in [(1, vec![31, 27]), (3, vec![31, 31, 31, 27, 27, 27])] {
        let table = traces(each, 4.0);
        let proposal = read(&app, "?include=nodes", file("f.csv", table.clone())).await.json();
        assert_eq!(codes(&proposal), ["sign_assumed", "own_zeros_assumed"], "{proposal}");
        let made = import(&app, &job, file("f.csv", table.clone())).await;
        assert_eq!(made.status, 201, "{}", made.text);
        let made = made.json();
        let note = made["note"].as_str().unwrap();
        assert!(note.contains("the zeros of its traces are chosen"), "{note}");
        let mut given: Vec<u64> =
            made["axes"]["z"]["trace_lengths"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
        assert_eq!(made["axes"], proposal["axes"]);
        given.sort_unstable_by(|a, b| b.cmp(a));
        assert_eq!(given, lengths);
        let figures = &made["fits"][0]["figures"];
        // a cross with its zeros subtracted determines a plane
        let why = if each == 1 { "not_second_order" } else { "traces_with_own_zeros" };
        assert_eq!((codes(figures), figures.get("profile_slope_um")), (vec![why.into()], None));
        let refused = fit(table.clone()).await;
        assert_eq!(refused.pointers(), ["/nodes"], "{}", refused.text);
        assert!(refused.text.contains("its own zero"), "{}", refused.text);
        // the nodes that the proposal returns are those that are stored
        let number = made["number"].as_u64().unwrap();
        let stored = send(app.get(&format!("{job}/iterations/{number}/nodes"))).await.json();
        assert_eq!(stored["z"], proposal["read"]["z"]);
        if each == 1 {
            continue;
        }
        // the surface through the levelled traces: 9 µm over 6 mm at the middle, −3 µm over 3² mm²
        let coefficients = &made["fits"][0]["result"]["coefficients"];
        let value = |name: &str| -> f64 {
            let found = coefficients.as_array().unwrap().iter().find(|one| one["term"] == name);
            found.unwrap_or_else(|| panic!("{name}: {coefficients}"))["least_squares"].as_f64().unwrap()
        };
        assert!((value("u^2") + 3.0 / 9.0).abs() < 0.02, "{coefficients}");
        let slope = value("u") + 18.0 * value("u^2") + 7.5 * value("u*v");
        assert!((slope - 1.5).abs() < 0.03, "{slope}: {coefficients}");
        // who knows better says so
        let columns = proposal["columns"].as_array().unwrap().iter().map(|column| {
            let mut column = column.clone();
            if column["meaning"] == "trace" {
                column = json!({"meaning": "ignore"});
            }
            column.as_object_mut().unwrap().remove("name");
            column
        });
        let mapping = json!({"columns": columns.collect::<Vec<_>>()}).to_string();
        let common = import(&app, &job, file("f.csv", table).text("mapping", mapping)).await.json();
        assert!(common["fits"][0]["figures"]["profile_slope_um"].is_object(), "{common}");
    }
    let common = import(&app, &job, file("f.csv", traces(3, 0.0))).await.json();
    let slope = common["fits"][0]["figures"]["profile_slope_um"]["value"].as_f64().unwrap();
    assert!((slope - 9.0).abs() < 0.3, "{common}");
    assert_eq!(fit(traces(3, 0.0)).await.status, 200);
}
