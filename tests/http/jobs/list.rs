//! List of jobs: its members, filters, orders and counts.

use serde_json::{Value, json};

use super::app::{TestApp, iteration};

fn names(page: &Value) -> Vec<&str> {
    page["items"].as_array().unwrap().iter().map(|job| job["name"].as_str().unwrap()).collect()
}

async fn found(app: &TestApp, query: &str) -> Value {
    app.get(&format!("/v1/jobs?{query}")).await.expect(200).json()
}

/// Jobs of these bodies; where they are.
async fn posted(app: &TestApp, bodies: &[Value]) -> Vec<String> {
    let mut places = Vec::new();
    for body in bodies {
        places.push(app.post("/v1/jobs", body).await.expect(201).header("location").unwrap().to_owned());
    }
    places
}

#[tokio::test]
async fn a_listed_job_summarises_its_last_iteration() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let alone = app.get(&job).await.json();
    let mut expected = alone.clone();
    assert_eq!(alone["status"], "new");
    expected["iteration_count"] = json!(0);
    expected["changed_at"] = alone["created_at"].clone();
    assert_eq!(found(&app, "").await, json!({"items": [expected]}));

    let mut body = iteration();
    body["measured_at"] = json!("2026-11-20T10:00:00+02:00");
    let new = app.post(&format!("{job}/iterations"), &body).await.expect(201).json();
    let fit = app.get(&format!("{job}/iterations/1")).await.json()["fits"][0].clone();
    expected["status"] = json!("open");
    expected["iteration_count"] = json!(1);
    expected["last_measured_at"] = json!("2026-11-20T08:00:00.000000Z");
    expected["changed_at"] = new["created_at"].clone();
    expected["rms"] = fit["rms"].clone();
    expected["condition"] = fit["condition"].clone();
    assert!(fit["rms"].is_f64() && fit["condition"].is_f64(), "{fit}");
    assert_eq!(found(&app, "status=open").await, json!({"items": [expected]}));

    app.patch(&format!("{job}/iterations/1"), &json!({"decision": "accepted"})).await.expect(200);
    let accepted = found(&app, "").await["items"][0].clone();
    assert!(accepted["changed_at"].as_str() > expected["changed_at"].as_str());
    expected["status"] = json!("accepted");
    expected["decision"] = json!("accepted");
    expected["changed_at"] = accepted["changed_at"].clone();
    assert_eq!(accepted, expected);
    // the job itself has the same status, and another tag by it
    let alone = app.get(&job).await;
    assert_eq!((&alone.json()["status"], alone.header("etag")), (&json!("accepted"), Some("\"1-accepted\"")));
    app.patch_if(&job, "\"1-new\"", &json!({"name": "wheel"})).await.expect(200);
    assert_eq!(found(&app, "status=open").await, json!({"items": []}));

    // the flank is always that of the last one
    for flank in ["right", "left"] {
        body["flank"] = json!(flank);
        app.post(&format!("{job}/iterations"), &body).await.expect(201);
        assert_eq!(found(&app, "").await["items"][0]["flank"], json!(flank));
    }
    body.as_object_mut().unwrap().remove("flank");
    app.post(&format!("{job}/iterations"), &body).await.expect(201);
    assert_eq!(found(&app, "").await["items"][0].get("flank"), None);
    app.stop().await;
}

#[tokio::test]
async fn jobs_are_found_and_sorted() {
    let mut app = TestApp::start().await;
    let places = posted(
        &app,
        &[
            json!({"name": "b 50%", "machine": "Wälz 1", "tags": {"shift": "night"}}),
            json!({"name": "C", "part_number": "A-4711", "tags": {"shift": "day"}}),
            json!({"name": "a", "serial_number": "0815", "machine": "Wälz 2"}),
        ],
    )
    .await;
    app.patch(&places[0], &json!({"tags": {"shift": "night", "line": "4"}})).await.expect(200);
    for (query, expected) in [
        ("", &["b 50%", "a", "C"][..]),
        ("sort=changed", &["b 50%", "a", "C"]),
        ("sort=created", &["a", "C", "b 50%"]),
        ("sort=name", &["a", "b 50%", "C"]),
        ("q=w%C3%84lz&sort=name", &["a", "b 50%"]),
        ("q=%25", &["b 50%"]),
        ("q=_", &[]),
        ("q=a-47", &["C"]),
        ("q=081", &["a"]),
        ("q=LINE:4", &["b 50%"]),
        ("machine=W%C3%A4lz%201", &["b 50%"]),
        ("part_number=A-4711", &["C"]),
        ("tag=shift&sort=name", &["b 50%", "C"]),
        ("tag=shift:day", &["C"]),
        ("tag=shift:day&q=4711&status=new", &["C"]),
        ("tag=shift:day&status=open", &[]),
        ("to=2026-01-01T00:00:00Z", &[]),
        ("from=2026-01-01T00:00:00Z&sort=name", &["a", "b 50%", "C"]),
    ] {
        assert_eq!(names(&found(&app, query).await), expected, "{query}");
    }
    for sort in ["changed", "name", "created"] {
        let whole = found(&app, &format!("sort={sort}")).await;
        let (mut seen, mut cursor) = (Vec::new(), String::new());
        loop {
            let page = found(&app, &format!("sort={sort}&limit=1{cursor}")).await;
            seen.push(page["items"][0].clone());
            let Some(next) = page["next_cursor"].as_str() else { break };
            cursor = format!("&cursor={next}");
            let other = if sort == "name" { "created" } else { "name" };
            let mixed = app.get(&format!("/v1/jobs?sort={other}{cursor}")).await;
            assert_eq!(mixed.problem(422, "invalid_request"), ["/cursor"]);
            assert!(mixed.text.contains(&format!("sorted by `{sort}`")), "{}", mixed.text);
        }
        assert_eq!(json!(seen), whole["items"], "{sort}");
    }
    app.stop().await;
}

#[tokio::test]
async fn jobs_are_counted() {
    let mut app = TestApp::start().await;
    let none = app.get("/v1/jobs/summary").await.expect(200).json();
    assert_eq!((&none["total"], &none["by_machine"], &none["by_week"]), (&json!(0), &json!([]), &json!([])));
    let bodies: Vec<Value> = [Some("K300"), Some("K200"), None, Some("K300")]
        .map(|machine| match machine {
            Some(machine) => json!({"name": "w", "machine": machine}),
            None => json!({"name": "w"}),
        })
        .into();
    let places = posted(&app, &bodies).await;
    app.post(&format!("{}/iterations", places[0]), &iteration()).await.expect(201);
    let summary = app.get("/v1/jobs/summary").await.expect(200).json();
    let expected = json!([
        {"status": "new", "count": 3},
        {"status": "open", "count": 1},
        {"status": "remachine", "count": 0},
        {"status": "accepted", "count": 0},
        {"status": "rejected", "count": 0}
    ]);
    assert_eq!(summary["by_status"], expected);
    assert_eq!(summary["by_machine"], json!([{"machine": "K300", "count": 2}, {"machine": "K200", "count": 1}]));
    assert_eq!(
        (&summary["total"], &summary["without_machine"], &summary["earlier"]),
        (&json!(4), &json!(1), &json!(0))
    );
    assert_eq!(summary.get("other_machines"), None);
    let weeks = summary["by_week"].as_array().unwrap();
    let begins: jiff::civil::Date = weeks[0]["begins"].as_str().unwrap().parse().unwrap();
    assert_eq!(begins.weekday(), jiff::civil::Weekday::Monday);
    let week = begins.iso_week_date();
    assert_eq!(weeks[0]["week"], format!("{:04}-W{:02}", week.year(), week.week()));
    assert_eq!(weeks.iter().map(|week| week["count"].as_u64().unwrap()).sum::<u64>(), 4);
    app.stop().await;
}
