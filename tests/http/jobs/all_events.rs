//! Server-sent events of all jobs of a tenant.

use std::time::Duration;

use reqwest::Method;
use serde_json::{Value, json};
use tokio::time::timeout;

use super::{
    app::{TestApp, send},
    events::Listener,
};
use flankfit::jobs::{Caller, JobDraft, Tenant};

type Entry = (String, String, Value);

async fn open(app: &TestApp, last: Option<&str>) -> Listener {
    Listener::of(app.request(Method::GET, "/v1/events"), last).await.expect("a listener")
}

async fn some(listener: &mut Listener, count: usize) -> Vec<Entry> {
    let mut found = Vec::new();
    while found.len() < count {
        found.push(listener.entry().await.expect("an event"));
    }
    found
}

fn id_of(job: &str) -> Value {
    json!(job.rsplit('/').next().unwrap())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn events_of_all_jobs_arrive_once_and_in_order() {
    let mut app = TestApp::start().await;
    let earlier = app.job().await;
    let mut listener = open(&app, None).await;
    let (one, two) = (app.job().await, app.job().await);
    let place = app.iteration(&one).await;
    app.patch(&earlier, &json!({"name": "another name"})).await.expect(200);
    app.patch(&place, &json!({"decision": "rejected"})).await.expect(200);
    app.delete(&two).await.expect(204);

    let all = some(&mut listener, 6).await;
    let seen: Vec<(&str, &Value, Option<&str>)> =
        all.iter().map(|(_, name, data)| (name.as_str(), &data["job_id"], data["job_state"].as_str())).collect();
    let (one, two, earlier) = (id_of(&one), id_of(&two), id_of(&earlier));
    assert_eq!(
        seen,
        [
            ("job", &one, Some("created")),
            ("job", &two, Some("created")),
            ("iteration", &one, None),
            ("job", &earlier, Some("changed")),
            ("decision", &one, None),
            ("job", &two, Some("deleted")),
        ]
    );
    assert_eq!((&all[4].2["decision"], &all[4].2["number"]), (&json!("rejected"), &json!(2)));

    // on from anywhere, after a restart too
    app.restart().await;
    for (k, (id, ..)) in all.iter().enumerate().take(5) {
        let mut again = open(&app, Some(id)).await;
        assert_eq!(some(&mut again, 5 - k).await, all[k + 1..]);
    }
    // an id that is not of this database, which is said, and `latest`: from now on
    for (last, resets) in [("9223372036854775806-9223372036854775806", true), ("latest", false)] {
        let mut late = open(&app, Some(last)).await;
        if resets {
            let (id, name, data) = late.entry().await.unwrap();
            assert_eq!((name.as_str(), &data["number"], data.get("job_id")), ("reset", &json!(0), None));
            // who goes on from there has missed nothing more
            late = open(&app, Some(&id)).await;
        }
        // an id is read before anything is sent
        let next = app.job().await;
        assert_eq!(late.entry().await.unwrap().2["job_id"], id_of(&next), "{last}");
    }
    app.stop().await;
    while listener.entry().await.is_some() {}
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn events_resume_after_a_long_break() {
    let mut app = TestApp::start_on_file().await;
    let mut listener = open(&app, None).await;
    app.job().await;
    app.job().await;
    let [(first, ..), (second, ..)]: [Entry; 2] = some(&mut listener, 2).await.try_into().unwrap();
    // as if these events were old
    app.restart_after(async |database| {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(database);
        let mut own = sqlx::ConnectOptions::connect(&options).await.unwrap();
        let note =
            "INSERT INTO told_until (at, changed_by) SELECT '2026-01-02T03:04:05.000006Z', max(changed_by) FROM told";
        sqlx::raw_sql(note).execute(&mut own).await.unwrap();
        sqlx::Connection::close(own).await.unwrap();
    })
    .await;
    assert_eq!(open(&app, Some(&first)).await.entry().await.unwrap().0, second);
    let third = app.job().await;
    app.state().jobs.forget_old_events().await.unwrap();
    assert_eq!(open(&app, Some(&second)).await.entry().await.unwrap().2["job_id"], id_of(&third));
    let mut late = open(&app, Some(&first)).await;
    assert_eq!(late.entry().await.unwrap().1, "reset");
    let next = app.job().await;
    assert_eq!(late.entry().await.unwrap().2["job_id"], id_of(&next));
    app.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_tenant_hears_nothing_of_it() {
    let mut app = TestApp::start().await;
    let mut listener = open(&app, None).await;
    let others = Caller { tenant: Tenant::named("other").unwrap(), actor: "them".into(), origin: Default::default() };
    let others = app.state().jobs.of(&others);
    let mut bell = others.listen_to_all();
    bell.borrow_and_update();
    let draft = JobDraft { name: "theirs".to_owned(), ..JobDraft::default() };
    others.create_job(draft, None).await.unwrap();
    assert!(bell.has_changed().unwrap());
    bell.borrow_and_update();
    let own = app.job().await;
    assert!(!bell.has_changed().unwrap(), "the bell of a tenant rings for it alone");
    assert_eq!(listener.entry().await.unwrap().2["job_id"], id_of(&own));
    assert!(timeout(Duration::from_millis(1500), listener.entry()).await.is_err(), "there is no further event");
    app.stop().await;
}

#[tokio::test]
async fn ids_of_another_form_are_refused() {
    let mut app = TestApp::start().await;
    for odd in ["7", "x", "7-", "-7", "1-2-3", "+1-2"] {
        let header = app.request(Method::GET, "/v1/events").header("Last-Event-ID", odd);
        send(header).await.problem(400, "malformed_request");
        let query = app.get(&format!("/v1/events?last_event_id={}", odd.replace('+', "%2B"))).await;
        assert_eq!(query.problem(422, "invalid_request"), ["/last_event_id"], "{odd}");
    }
    app.stop().await;
}
