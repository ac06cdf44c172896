//! A load generator: so many keep-alive connections, each sending the same request again after each
//! response. It runs on the thread of the bench alone, so that of two cores the server has at least
//! one.

use std::{io, net::SocketAddr};

use flankfit::{app::App, config::ServeSettings};
use tokio::{net::TcpStream, runtime::Runtime, sync::oneshot, task::JoinSet};

/// A server of this process, stopped when dropped.
pub struct Server {
    pub address: SocketAddr,
    _stop: oneshot::Sender<()>,
    _runtime: Runtime,
    _database: tempfile::TempDir,
}

impl Server {
    /// With an empty database on the disk that `folder` lies on.
    pub fn start(folder: &str) -> Self {
        let database = tempfile::tempdir_in(folder).expect("a folder for the database");
        let database_url = format!("sqlite://{}", database.path().join("bench.db").display());
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().expect("threads can be made");
        let settings =
            ServeSettings { bind: SocketAddr::from(([127, 0, 0, 1], 0)), database_url, ..ServeSettings::default() };
        let app = runtime.block_on(App::start(settings)).expect("the server starts");
        let address = app.address().expect("it has an address");
        let (stop, stopped) = oneshot::channel();
        runtime.spawn(app.serve(async {
            let _ = stopped.await;
        }));
        Server { address, _stop: stop, _runtime: runtime, _database: database }
    }
}

/// An HTTP/1.1 POST of a JSON body.
pub fn post(path: &str, body: &str) -> Vec<u8> {
    format!(
        "POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    )
    .into_bytes()
}

/// Sends one request and returns status and body.
pub fn once(address: SocketAddr, request: &[u8]) -> (u16, Vec<u8>) {
    let exchange = async {
        let mut connection = Connection::open(address).await?;
        let (status, body) = connection.exchange(request).await?;
        Ok::<_, io::Error>((status, body.to_vec()))
    };
    single_thread().block_on(exchange).expect("the server answers")
}

/// Connections that stay open from round to round.
pub struct Press {
    runtime: Runtime,
    connections: Vec<Connection>,
}

impl Press {
    pub fn new(address: SocketAddr, connections: usize) -> Self {
        let runtime = single_thread();
        let open = || runtime.block_on(Connection::open(address)).expect("the server takes connections");
        let connections = (0..connections).map(|_| open()).collect();
        Press { runtime, connections }
    }

    /// Sends the request so many times over all connections at once, and waits for the responses,
    /// each of them a 2xx.
    pub fn round(&mut self, request: &[u8], requests: usize) {
        let of_each = requests / self.connections.len();
        let mut at_work = JoinSet::new();
        for mut connection in self.connections.drain(..) {
            let request = request.to_vec();
            at_work.spawn_on(
                async move {
                    for _ in 0..of_each {
                        let (status, _) = connection.exchange(&request).await.expect("the server answers");
                        assert!((200..300).contains(&status), "refused with {status}");
                    }
                    connection
                },
                self.runtime.handle(),
            );
        }
        self.connections = self.runtime.block_on(at_work.join_all());
    }
}

fn single_thread() -> Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime can be made")
}

struct Connection {
    stream: TcpStream,
    buffer: Vec<u8>,
}

impl Connection {
    async fn open(address: SocketAddr) -> io::Result<Self> {
        let stream = TcpStream::connect(address).await?;
        stream.set_nodelay(true)?;
        Ok(Connection { stream, buffer: Vec::with_capacity(1 << 16) })
    }

    /// Sends one request and waits for its whole response (of known length only, as the service
    /// sends them).
    async fn exchange(&mut self, request: &[u8]) -> io::Result<(u16, &[u8])> {
        let mut sent = 0;
        while sent < request.len() {
            self.stream.writable().await?;
            match self.stream.try_write(&request[sent..]) {
                Ok(n) => sent += n,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
        self.buffer.clear();
        loop {
            if let Some((status, head, length)) = head(&self.buffer)?
                && self.buffer.len() >= head + length
            {
                return Ok((status, &self.buffer[head..head + length]));
            }
            self.stream.readable().await?;
            match self.stream.try_read_buf(&mut self.buffer) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// Status, length of the head and length of the body, once the head is complete.
fn head(bytes: &[u8]) -> io::Result<Option<(u16, usize, usize)>> {
    let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") else { return Ok(None) };
    let text = std::str::from_utf8(&bytes[..end]).map_err(io::Error::other)?;
    let status = text.get(9..12).and_then(|status| status.parse().ok()).ok_or(io::ErrorKind::InvalidData)?;
    let length = text
        .lines()
        .filter_map(|line| line.split_once(':'))
        .find(|(name, _)| name.eq_ignore_ascii_case("content-length"))
        .and_then(|(_, value)| value.trim().parse().ok())
        .ok_or_else(|| io::Error::other("an answer without content-length"))?;
    Ok(Some((status, end + 4, length)))
}
