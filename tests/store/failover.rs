//! Failover to a synchronous standby under writers, behind an address that follows the primary:
//! nothing acknowledged is lost, nothing is stored twice, no number is left out, whoever writes
//! sees no error, and the chains hold.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use flankfit::store::PostgresSettings;
use sqlx::{Connection as _, PgConnection};
use tokio::{
    io::copy_bidirectional,
    net::{TcpListener, UnixStream},
    time::sleep,
};

use crate::{
    restarts::Writers,
    restore::{run, verified},
    server::{Server, shell},
};

/// Gives the server a standby for whose disk every commit waits.
const STAND_BY: &str = "$BIN/pg_basebackup -h \"$PWD\" -U owner -D standby -R -X stream -c fast --no-sync && \
    mkdir second && printf \"unix_socket_directories='$PWD/second'\\n\" >>standby/postgresql.conf && \
    $BIN/pg_ctl -D standby -l second/log -w start && \
    printf \"synchronous_standby_names='*'\\n\" >>data/postgresql.conf && $BIN/pg_ctl -D data reload";
const LOSE: &str = "kill -9 $(head -1 data/postmaster.pid)";
const PROMOTE: &str = "$BIN/pg_ctl -D standby -w promote";
const END: &str = "$BIN/pg_ctl -D standby -m immediate -w stop";

/// The standby of a server, which ends before it.
struct Standby<'a>(&'a Server);

impl Drop for Standby<'_> {
    fn drop(&mut self) {
        // where it does not run any more, that is all the same
        let _ended = shell(&self.0.folder, END).status();
    }
}

/// An address that leads to whichever server is the primary.
struct Address {
    port: u16,
    socket: Arc<Mutex<PathBuf>>,
}

impl Address {
    async fn of(socket: PathBuf) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let socket = Arc::new(Mutex::new(socket));
        let current = socket.clone();
        tokio::spawn(async move {
            while let Ok((mut client, _)) = listener.accept().await {
                let socket = current.lock().unwrap().clone();
                tokio::spawn(async move {
                    // where nobody listens, the client is left
                    if let Ok(mut server) = UnixStream::connect(socket).await {
                        let _ended = copy_bidirectional(&mut client, &mut server).await;
                    }
                });
            }
        });
        Address { port, socket }
    }

    fn lead_to(&self, socket: PathBuf) {
        *self.socket.lock().unwrap() = socket;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[cfg_attr(without_postgres, ignore = "there is no PostgreSQL server")]
async fn a_failover_to_a_synchronous_standby_loses_nothing() {
    let server = Server::start();
    let name = server.with_schema().await;
    let _standby = Standby(&server);
    run(&server, STAND_BY);
    let mut own = PgConnection::connect(&server.url(&name)).await.unwrap();
    let asked = Instant::now();
    loop {
        let waited_for: i64 = sqlx::query_scalar("SELECT count(*) FROM pg_stat_replication WHERE sync_state = 'sync'")
            .fetch_one(&mut own)
            .await
            .unwrap();
        if waited_for == 1 {
            break;
        }
        assert!(asked.elapsed() < Duration::from_secs(60), "no commit waits for the standby");
        sleep(Duration::from_millis(50)).await;
    }
    own.close().await.unwrap();

    let address = Address::of(server.folder.join(".s.PGSQL.5432")).await;
    let url = format!("postgres://owner@127.0.0.1:{}/{name}?sslmode=disable", address.port);
    let writers = Writers::start(PostgresSettings::of_url(&url).unwrap()).await;
    writers.go_on().await;
    let lost = Instant::now();
    run(&server, LOSE);
    run(&server, PROMOTE);
    address.lead_to(server.folder.join("second/.s.PGSQL.5432"));
    println!("promoted after {:?}", lost.elapsed());
    writers.go_on().await;
    println!("every job got something more after {:?}", lost.elapsed());
    writers.check().await;
    let said = verified(&url);
    assert!(said.starts_with("intact: "), "{said}");
    // the other server responds
    let mut own = PgConnection::connect(&url).await.unwrap();
    let folder: String = sqlx::query_scalar("SHOW data_directory").fetch_one(&mut own).await.unwrap();
    assert!(folder.ends_with("/standby"), "{folder}");
}
