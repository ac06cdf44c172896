//! haproxy with `deploy/haproxy.cfg` before three servers.

use std::{
    env, fs,
    net::{SocketAddr, TcpListener, TcpStream},
    path::{Path, PathBuf},
    process::{self, Child, Command, Stdio},
    sync::atomic::{AtomicU16, Ordering},
    thread,
    time::{Duration, Instant},
};

use tempfile::TempDir;

pub const REPLICAS: usize = 3;
/// The variables of the configuration that name servers.
const NAMES: [&str; REPLICAS] = ["PLANT_ONE", "PLANT_TWO", "PLANT_THREE"];
/// Ends the proxy when the standard input ends, hence also when this process is killed.
const KEPT: &str = "\"$0\" -db -f \"$1\" </dev/null & proxy=$!; cat; kill $proxy; wait $proxy";

pub struct Proxy {
    pub base: String,
    /// Addresses of the servers.
    pub servers: [SocketAddr; REPLICAS],
    folder: TempDir,
    keeper: Child,
}

impl Proxy {
    /// With so many attempts more for a request that no server has got.
    pub fn start(retries: u32) -> Self {
        let [listen, servers @ ..]: [SocketAddr; 1 + REPLICAS] = std::array::from_fn(|_| free_address());
        let folder = tempfile::tempdir().unwrap();
        let log = fs::File::create(folder.path().join("log")).unwrap();
        let keeper = Command::new("sh")
            .args(["-c", KEPT])
            .args([program(), configuration()])
            .env("PLANT_LISTEN", listen.to_string())
            .envs(NAMES.into_iter().zip(servers.map(|address| address.to_string())))
            .env("PLANT_RETRIES", retries.to_string())
            .stdin(Stdio::piped())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .spawn()
            .unwrap();
        let proxy = Proxy { base: format!("http://{listen}"), servers, folder, keeper };
        let begun = Instant::now();
        while TcpStream::connect(listen).is_err() {
            assert!(begun.elapsed() < Duration::from_secs(20), "{}", proxy.log());
            thread::sleep(Duration::from_millis(20));
        }
        proxy
    }

    /// Log of the proxy: the servers that it considers ready, and since when.
    pub fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap()
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        drop(self.keeper.stdin.take());
        let _ended = self.keeper.wait();
    }
}

/// The configuration of the repository.
pub fn configuration() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy/haproxy.cfg")
}

/// haproxy, which Debian keeps where only root looks for it. (`build.rs` looks in the same places.)
pub fn program() -> PathBuf {
    let path = env::var_os("PATH").unwrap_or_default();
    let mut folders = env::split_paths(&path).chain(["/usr/sbin".into(), "/usr/local/sbin".into()]);
    let found = folders.find_map(|folder: PathBuf| Some(folder.join("haproxy")).filter(|file| file.exists()));
    found.expect("haproxy is installed")
}

/// An address that nobody listens at, and that the system gives to no client: a server must find it
/// free again after it was killed.
pub fn free_address() -> SocketAddr {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    loop {
        let offset = (process::id() as u16 % 1100) * 10 + NEXT.fetch_add(1, Ordering::Relaxed);
        let address = SocketAddr::from(([127, 0, 0, 1], 20_000 + offset % 12_000));
        if TcpListener::bind(address).is_ok() {
            return address;
        }
    }
}

#[test]
#[cfg_attr(without_haproxy, ignore = "haproxy is not installed")]
fn the_configuration_is_one() {
    let checked = Command::new(program()).arg("-c").arg("-f").arg(configuration()).output().unwrap();
    let said = String::from_utf8_lossy(&checked.stderr) + String::from_utf8_lossy(&checked.stdout);
    assert!(checked.status.success() && !said.contains("[WARNING]"), "{said}");
}
