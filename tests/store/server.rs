//! PostgreSQL servers for the tests of this process: made by `initdb` in short temporary folders,
//! on Unix sockets alone, as another user when the tests run as root. They end with the process.

use std::{
    env, fs, mem,
    os::unix::fs::{MetadataExt as _, chown},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        Mutex, OnceLock,
        atomic::{AtomicU32, Ordering},
    },
};

use flankfit::store::{PostgresSettings, migrate};
use sqlx::{AssertSqlSafe, Connection, PgConnection};
use tokio::sync::OnceCell;

/// The user `nobody`, as which a server runs where it must not run as root.
const NOBODY: u32 = 65534;

const BEGIN: &str = "$BIN/initdb -D data -A trust -U owner -E UTF8 --no-locale --no-sync >log && \
    printf \"listen_addresses=''\nunix_socket_directories='$PWD'\nmax_connections=300\nfsync=off\n\
    max_wal_size=128MB\n\" >>data/postgresql.conf && $BIN/pg_ctl -D data -l log -w start";
const END: &str = "cat; $BIN/pg_ctl -D data -m immediate -w stop; rm -rf \"$PWD\"";

pub struct Server {
    pub folder: PathBuf,
    databases: AtomicU32,
    /// Databases that no test needs any more; some hundreds of them would fill a small disk.
    done: Mutex<Vec<String>>,
    /// The name of a database with the schema.
    template: OnceCell<String>,
    /// Stops the server and removes the folder when its standard input ends, hence also when this
    /// process is killed.
    _keeper: Child,
}

impl Server {
    /// The server of most tests, started at its first use.
    pub fn shared() -> &'static Server {
        static SERVER: OnceLock<Server> = OnceLock::new();
        SERVER.get_or_init(Server::start)
    }

    /// A server of its own.
    pub fn start() -> Self {
        let folder = tempfile::Builder::new().prefix("ff").tempdir().unwrap().keep();
        if is_root() {
            chown(&folder, Some(NOBODY), Some(NOBODY)).unwrap();
        }
        let begun = shell(&folder, BEGIN).status().unwrap();
        assert!(begun.success(), "{}", fs::read_to_string(folder.join("log")).unwrap_or_default());
        let keeper = shell(&folder, END).stdin(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        Server {
            folder,
            databases: AtomicU32::new(0),
            done: Mutex::default(),
            template: OnceCell::new(),
            _keeper: keeper,
        }
    }

    /// The URL of a new database with the schema.
    pub async fn database(&self) -> String {
        self.url(&self.with_schema().await)
    }

    /// The name of one.
    pub async fn with_schema(&self) -> String {
        let template = self
            .template
            .get_or_init(|| async {
                let name = self.copy_of("template1").await;
                migrate(&PostgresSettings::of_url(&self.url(&name)).unwrap()).await.unwrap();
                name
            })
            .await;
        self.copy_of(template).await
    }

    /// The URL of a database of the server.
    pub fn url(&self, name: &str) -> String {
        format!("postgres://owner@localhost/{name}?host={}", self.folder.display())
    }

    /// Has the next new database take the place of the one of this URL.
    pub fn done_with(&self, url: &str) {
        let name = url.split(['/', '?']).nth(3).expect("a URL of `url`");
        self.done.lock().unwrap().push(name.to_owned());
    }

    /// The name of a new database that is as another one.
    pub async fn copy_of(&self, template: &str) -> String {
        let name = format!("d{}", self.databases.fetch_add(1, Ordering::Relaxed));
        let done = mem::take(&mut *self.done.lock().unwrap());
        let mut db = PgConnection::connect(&self.url("postgres")).await.unwrap();
        for name in done {
            // whoever is connected still is cut off; where he comes back at once, it stays
            let drop = format!("DROP DATABASE {name} WITH (FORCE)");
            let _dropped = sqlx::query(AssertSqlSafe(drop)).execute(&mut db).await;
        }
        let create = format!("CREATE DATABASE {name} TEMPLATE {template}");
        sqlx::query(AssertSqlSafe(create)).execute(&mut db).await.unwrap();
        db.close().await.unwrap();
        name
    }
}

/// A command of the user that servers run as, in the folder of one; BIN names its programs.
pub fn shell(folder: &Path, script: &str) -> Command {
    let mut command = match is_root() {
        true => Command::new("setpriv"),
        false => Command::new("env"),
    };
    if is_root() {
        command.args([format!("--reuid={NOBODY}"), format!("--regid={NOBODY}"), "--clear-groups".to_owned()]);
    }
    let programs = programs().expect("PostgreSQL is installed, or FLANKFIT_POSTGRES_BIN names its programs");
    command.args(["sh", "-c", script]).current_dir(folder).env("BIN", programs);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command
}

fn is_root() -> bool {
    fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0)
}

/// Folder of PostgreSQL's programs. (`build.rs` looks in the same places.)
fn programs() -> Option<PathBuf> {
    if let Some(named) = env::var_os("FLANKFIT_POSTGRES_BIN") {
        return Some(named.into());
    }
    let installed =
        fs::read_dir("/usr/lib/postgresql").into_iter().flatten().flatten().map(|entry| entry.path().join("bin"));
    let path = env::var_os("PATH").unwrap_or_default();
    let mut folders: Vec<PathBuf> = env::split_paths(&path).chain(installed).collect();
    folders.retain(|folder: &PathBuf| has_server(folder));
    folders.pop()
}

fn has_server(folder: &Path) -> bool {
    folder.join("initdb").exists() && folder.join("postgres").exists()
}
