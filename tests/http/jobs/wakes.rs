//! Events at one server reach the others, with or without notification.

use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::{Value, json};
use sqlx::{Connection as _, PgConnection, postgres::PgListener};
use tokio::time::{sleep, timeout};

use super::{
    app::{iteration, send},
    events::Listener,
    gate::Gate,
    several::Replicas,
    socket,
    streams::block,
};
use crate::postgres::Server;

/// Servers poll every two seconds. Events that arrive sooner came by notification.
const LOOK: Duration = Duration::from_secs(2);

impl Replicas {
    async fn listen(&self, replica: usize, job: &str) -> Listener {
        Listener::of(self.request(replica, Method::GET, &format!("{job}/events")), Some("latest"))
            .await
            .expect("a listener")
    }

    /// The number of a new iteration of a job, which the first server stores.
    async fn stored(&self, job: &str) -> Value {
        let stored = self.post(0, &format!("{job}/iterations"), &iteration()).await.expect(201);
        stored.json()["number"].clone()
    }

    /// Delays until the others are notified of iterations, each posted some time after the one
    /// before.
    async fn delays(&self, job: &str, count: u64, apart: Duration) -> Vec<Duration> {
        let mut listener = self.listen(1, job).await;
        let mut delays = Vec::new();
        for _ in 0..count {
            sleep(apart).await;
            let number = self.stored(job).await;
            let stored = Instant::now();
            let (_, name, event) = listener.next().await.expect("an event");
            delays.push(stored.elapsed());
            assert_eq!((name.as_str(), &event["iteration_number"]), ("iteration", &number), "{event}");
        }
        delays.sort_unstable();
        delays
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn events_are_heard_at_once_at_another_server() {
    let replicas = Replicas::on_postgres(2).await;
    let delays = replicas.delays(&replicas.job().await, 20, Duration::from_millis(50)).await;
    println!("median {:?}, longest {:?}", delays[10], delays[19]);
    // a busy machine may hold some of them up
    assert!(delays[10] < LOOK / 4, "{delays:?}");
    // and both report their delays
    let metrics = replicas.get(0, "/metrics").await.text;
    assert!(metrics.contains("flankfit_wake_delay_seconds_count"), "{metrics}");
}

/// Past a pooler behind which there is nobody, nothing is heard.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn changes_without_notification_are_found_by_polling() {
    let replicas = Replicas::on_postgres_with(2, |settings| {
        settings.postgres.database_direct_url = Some("postgres://nobody@127.0.0.1:1/nowhere".to_owned());
        settings.postgres.migrate = flankfit::config::MigrateMode::Check;
    })
    .await;
    let delays = replicas.delays(&replicas.job().await, 3, Duration::from_millis(500)).await;
    assert!(delays[2] < 3 * LOOK, "{delays:?}");
    // each is posted half a second after a look, in which the one before was found
    assert!(delays[1] > LOOK / 4, "without notification: {delays:?}");
}

/// A server that has lost the connection of its notifications reads everything once it is connected
/// again.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn servers_hear_again_after_their_connections_were_lost() {
    let replicas = Replicas::on_postgres(2).await;
    let job = replicas.job().await;
    let mut own = PgConnection::connect(&replicas.url).await.unwrap();
    for _ in 0..3 {
        let lost: i64 = sqlx::query_scalar(
            "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity
             WHERE datname = current_database() AND pid <> pg_backend_pid()",
        )
        .fetch_one(&mut own)
        .await
        .unwrap();
        assert!(lost >= 2, "{lost} connections");
        let delays = replicas.delays(&job, 5, Duration::from_millis(300)).await;
        assert!(delays[2] < LOOK / 4, "{delays:?}");
    }
}

/// Notifications sent while a server does not listen are not repeated: once it listens again, it
/// reads everything at once.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_server_that_listens_again_polls_everything_at_once() {
    // servers hear by this way alone
    let gate = Gate::to(Server::shared().folder.join(".s.PGSQL.5432")).await;
    let replicas = Replicas::on_postgres_with(2, |settings| {
        let database = settings.database_url.split(['/', '?']).nth(3).expect("a database").to_owned();
        let direct = format!("postgres://owner@127.0.0.1:{}/{database}?sslmode=disable", gate.port);
        settings.postgres.database_direct_url = Some(direct);
    })
    .await;
    let mut notifications = PgListener::connect(&replicas.url).await.unwrap();
    notifications.listen("flankfit").await.unwrap();
    let job = replicas.job().await;
    let mut reader = replicas.listen(1, &job).await;
    let mut delays = Vec::new();
    for _ in 0..3 {
        let other = replicas.job().await;
        let id = other.rsplit('/').next().unwrap().replace('-', "");
        gate.shut().await;
        // found by a look, so the next one is two seconds away
        let number = replicas.stored(&job).await;
        let (_, _, event) = reader.next().await.expect("an event");
        assert_eq!(event["iteration_number"], number, "{event}");
        let number = replicas.stored(&job).await;
        // later events have been notified by now
        replicas.stored(&other).await;
        while !notifications.recv().await.unwrap().payload().contains(&id) {}
        let opened = Instant::now();
        gate.open();
        let (_, _, event) = reader.next().await.expect("an event");
        delays.push(opened.elapsed());
        assert_eq!(event["iteration_number"], number, "{event}");
    }
    // a busy machine may hold some of them up
    assert!(delays.iter().min().is_some_and(|least| *least < LOOK / 2), "{delays:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn sockets_close_wherever_they_are() {
    let replicas = Replicas::on_postgres(3).await;
    for end in [Method::POST, Method::DELETE] {
        let stream = replicas.stream().await;
        replicas.post(1, &format!("{stream}/nodes"), &block(1, 0..30)).await.expect(200);
        let mut sockets =
            [socket::connect(&replicas.bases[1], &stream).await, socket::connect(&replicas.bases[2], &stream).await];
        let path = if end == Method::POST { format!("{stream}/finish") } else { stream };
        let ended = send(replicas.request(0, end, &path).json(&json!({}))).await;
        assert!(ended.status.is_success(), "{}", ended.text);
        for socket in &mut sockets {
            let code = timeout(Duration::from_secs(60), socket::close(socket)).await.expect("the socket closes");
            assert!(code.is_some());
        }
    }
}
