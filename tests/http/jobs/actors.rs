//! The author is returned with each stored resource.

use flankfit::{config::Authentication, jobs::Role};
use reqwest::Method;
use serde_json::{Value, json};

use super::app::{Answer, TestApp, iteration, send};
use crate::{
    access::keys::key_of,
    harness,
    jobs::progress::{result, with_progress},
    shapes::examples,
};

/// A caller with a key of its own.
struct Caller<'a> {
    app: &'a TestApp,
    key: String,
    actor: Value,
}

impl<'a> Caller<'a> {
    async fn of(app: &'a TestApp, role: Role) -> Self {
        let key = key_of(app.server(), "default", role).await;
        let who = send(app.request(Method::GET, "/v1/whoami").bearer_auth(&key)).await.json();
        Caller { app, key, actor: who["actor"].clone() }
    }

    async fn ask(&self, method: Method, path: &str, body: &Value) -> Answer {
        send(self.app.request(method, path).bearer_auth(&self.key).json(body)).await
    }

    async fn get(&self, path: &str) -> Value {
        send(self.app.request(Method::GET, path).bearer_auth(&self.key)).await.expect(200).json()
    }
}

fn refit(lambda_star: f64) -> Value {
    json!({"model": {"type": "polynomial", "degree": [2, 2]}, "reason": "smoother",
        "regularization": {"type": "spectral", "lambda_star": {"criterion": "fixed", "value": lambda_star}}})
}

#[tokio::test]
async fn each_resource_names_its_actor() {
    let settings = |settings: &mut flankfit::config::ServeSettings| settings.auth = Authentication::Required;
    let mut app = TestApp::around(harness::TestApp::start_with(settings).await);
    let (operator, engineer) = (Caller::of(&app, Role::Operator).await, Caller::of(&app, Role::Engineer).await);
    assert_ne!(operator.actor, engineer.actor);
    let job = operator.ask(Method::POST, "/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
    let job = job.header("location").unwrap().to_owned();
    let added = operator.ask(Method::POST, &format!("{job}/iterations"), &iteration()).await.expect(201);
    assert_eq!(added.json()["fits"][0]["by"], operator.actor, "{}", added.text);
    let place = added.header("location").unwrap().to_owned();
    let made = engineer.ask(Method::POST, &format!("{place}/fits"), &refit(1e-3)).await.expect(201).json();
    assert_eq!(made["by"], engineer.actor);
    let watched = engineer.app.request(Method::POST, &format!("{place}/fits")).bearer_auth(&engineer.key);
    result(with_progress(watched).json(&refit(1e-2))).await;
    let choice = json!({"fit_id": made["id"], "reason": "smoother"});
    let chosen = engineer.ask(Method::PUT, &format!("{place}/chosen-fit"), &choice).await.expect(200).json();
    assert_eq!(chosen["fits"][1]["chosen_by"], engineer.actor);
    assert_eq!(chosen["fits"][0].get("chosen_by"), None);
    let decided = engineer.ask(Method::PATCH, &place, &json!({"decision": "accepted"})).await.expect(200).json();
    assert_eq!(decided["decided_by"], engineer.actor);
    let surface = &examples("create_iteration_surface")[0].1;
    let kept = engineer.ask(Method::POST, &format!("{place}/surfaces"), surface).await.expect(201);
    assert_eq!(kept.json()["by"], engineer.actor);

    let by =
        |list: &Value| -> Vec<Value> { list.as_array().unwrap().iter().map(|entry| entry["by"].clone()).collect() };
    let engineers = std::slice::from_ref(&engineer.actor);
    let fits = [&operator.actor, &engineer.actor, &engineer.actor].map(Value::clone);
    assert_eq!(by(&operator.get(&format!("{place}/fits")).await["items"]), fits);
    assert_eq!(operator.get(&format!("{place}/fits/{}", made["id"].as_str().unwrap())).await["by"], engineer.actor);
    assert_eq!(by(&operator.get(&format!("{place}/records")).await["items"]), engineers);
    assert_eq!(operator.get(kept.header("location").unwrap()).await["by"], engineer.actor);
    let traced = operator.get(&format!("{job}/trace")).await["iterations"][0].clone();
    assert_eq!((&traced["instrument"], &traced["operator"]), (&json!("P40"), &json!("J. Doe")));
    assert_eq!(by(&traced["fits"]), fits);
    assert_eq!(by(&traced["choices"]), [operator.actor.clone(), engineer.actor.clone()]);
    assert_eq!(by(&traced["decisions"]), engineers);
    assert_eq!(by(&traced["records"]), engineers);
    drop((operator, engineer));
    app.stop().await;
}

/// Without a required key no author is known.
#[tokio::test]
async fn an_open_server_knows_nobody() {
    let mut app = TestApp::start().await;
    let job = app.job().await;
    let place = app.iteration(&job).await;
    let made = app.post(&format!("{place}/fits"), &refit(1e-3)).await.expect(201);
    let choice = json!({"fit_id": made.json()["id"]});
    let answers = [
        made,
        app.put(&format!("{place}/chosen-fit"), &choice).await.expect(200),
        app.patch(&place, &json!({"decision": "accepted"})).await.expect(200),
        app.post(&format!("{place}/surfaces"), &examples("create_iteration_surface")[0].1).await.expect(201),
        app.get(&format!("{job}/trace")).await.expect(200),
        app.get(&format!("{place}/fits")).await.expect(200),
        app.get(&format!("{place}/records")).await.expect(200),
    ];
    for answer in answers {
        assert!(!answer.text.contains("by\":") && !answer.text.contains("anonymous"), "{}", answer.text);
    }
    app.stop().await;
}
