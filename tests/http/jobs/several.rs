//! Several servers on one store: services with a memory of their own on one SQLite store, or whole
//! servers on one PostgreSQL database, as in a plant.

use std::sync::Arc;

use flankfit::{
    config::ServeSettings,
    http::{self, AppState},
    jobs::{JobService, OrderedIds, SystemClock},
    store::{StoreSettings, open_sqlite},
};
use reqwest::{Client, Method, RequestBuilder};
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::net::TcpListener;

use super::{
    app::{Answer, send},
    streams::spec,
};
use crate::{harness, postgres::Server};

pub struct Replicas {
    pub client: Client,
    pub bases: Vec<String>,
    pub states: Vec<AppState>,
    /// The database on the server of the tests, where it is one.
    pub url: String,
    _apps: Vec<harness::TestApp>,
    _directory: TempDir,
}

impl Replicas {
    pub async fn on_sqlite(count: usize) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let settings = StoreSettings::of_file(directory.path().join("jobs.db"));
        let store = Arc::new(open_sqlite(settings, Arc::new(SystemClock)).await.unwrap());
        let (mut bases, mut states) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let jobs = JobService::new(store.clone(), Arc::new(SystemClock), Arc::new(OrderedIds::new()));
            let settings = ServeSettings { workers: 2, ..ServeSettings::default() };
            let state = AppState::new(settings, jobs, None).await.unwrap();
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            bases.push(format!("http://{}", listener.local_addr().unwrap()));
            states.push(state.clone());
            tokio::spawn(async move { axum::serve(listener, http::router(state)).await });
        }
        Replicas { client: client(), bases, states, url: String::new(), _apps: Vec::new(), _directory: directory }
    }

    pub async fn on_postgres(count: usize) -> Self {
        Self::on_postgres_with(count, |_| {}).await
    }

    /// The same with other settings.
    pub async fn on_postgres_with(count: usize, change: impl Fn(&mut ServeSettings)) -> Self {
        let url = Server::shared().database().await;
        let mut apps = Vec::new();
        for _ in 0..count {
            let settings = |settings: &mut ServeSettings| {
                settings.database_url.clone_from(&url);
                (settings.postgres.store_writers, settings.postgres.database_readers) = (2, 4);
                change(settings);
            };
            apps.push(harness::TestApp::start_with(settings).await);
        }
        Replicas {
            client: client(),
            bases: apps.iter().map(|app| format!("http://{}", app.address)).collect(),
            states: apps.iter().map(|app| app.state.clone()).collect(),
            url,
            _apps: apps,
            _directory: tempfile::tempdir().unwrap(),
        }
    }

    pub fn request(&self, replica: usize, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, format!("{}{path}", self.bases[replica]))
    }

    pub async fn post(&self, replica: usize, path: &str, body: &Value) -> Answer {
        send(self.request(replica, Method::POST, path).json(body)).await
    }

    pub fn keyed(&self, replica: usize, path: &str, key: &str, body: &Value) -> RequestBuilder {
        self.request(replica, Method::POST, path).header("Idempotency-Key", key).json(body)
    }

    pub async fn get(&self, replica: usize, path: &str) -> Answer {
        send(self.request(replica, Method::GET, path)).await
    }

    /// A new job's path.
    pub async fn job(&self) -> String {
        let job = self.post(0, "/v1/jobs", &json!({"name": "wheel"})).await.expect(201);
        job.header("location").unwrap().to_owned()
    }

    /// A new stream's path.
    pub async fn stream(&self) -> String {
        let streams = format!("{}/streams", self.job().await);
        self.post(0, &streams, &spec()).await.expect(201).header("location").unwrap().to_owned()
    }
}

fn client() -> Client {
    Client::builder().no_proxy().no_gzip().build().unwrap()
}
