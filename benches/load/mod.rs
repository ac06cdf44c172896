//! A load generator: so many keep-alive connections, each sending the same request again as soon as
//! it is answered. It runs on one thread of its own, so that of two cores the server has at least
//! one.

use std::{
    io,
    net::SocketAddr,
    time::{Duration, Instant},
};

use flankfit::{app::App, config::ServeSettings};
use tokio::{net::TcpStream, sync::oneshot};

/// The one of the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// How hard to press and for how long.
#[derive(Clone, Copy)]
pub struct Load {
    pub connections: usize,
    pub warm_up: Duration,
    pub measured: Duration,
}

/// What came back.
pub struct Report {
    /// Requests answered with a 2xx a second.
    pub per_second: f64,
    pub p50: Duration,
    pub p99: Duration,
    /// Answers that were no 2xx.
    pub refused: usize,
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ms = |d: Duration| d.as_secs_f64() * 1e3;
        write!(
            f,
            "{:>9.0} requests/s   p50 {:>7.3} ms   p99 {:>7.3} ms   refused {}",
            self.per_second,
            ms(self.p50),
            ms(self.p99),
            self.refused
        )
    }
}

/// A server of this process, stopped when dropped.
pub struct Server {
    pub address: SocketAddr,
    _stop: oneshot::Sender<()>,
    _runtime: tokio::runtime::Runtime,
}

impl Server {
    pub fn start(database_url: String) -> Self {
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().expect("threads can be made");
        let settings =
            ServeSettings { bind: SocketAddr::from(([127, 0, 0, 1], 0)), database_url, ..ServeSettings::default() };
        let app = runtime.block_on(App::start(settings)).expect("the server starts");
        let address = app.address().expect("it has an address");
        let (stop, stopped) = oneshot::channel();
        runtime.spawn(app.serve(async {
            let _ = stopped.await;
        }));
        Server { address, _stop: stop, _runtime: runtime }
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

/// Presses.
pub fn run(address: SocketAddr, request: &[u8], load: Load) -> Report {
    let request: std::sync::Arc<[u8]> = request.into();
    let runtime = single_thread();
    let outcome = runtime.block_on(async {
        let start = Instant::now() + load.warm_up;
        let end = start + load.measured;
        let mut tasks = Vec::new();
        for _ in 0..load.connections {
            let request = request.clone();
            tasks.push(tokio::spawn(async move {
                let mut connection = Connection::open(address).await?;
                let (mut latencies, mut refused) = (Vec::new(), 0);
                loop {
                    let sent = Instant::now();
                    let (status, _) = connection.exchange(&request).await?;
                    let answered = Instant::now();
                    if answered >= end {
                        return Ok::<_, io::Error>((latencies, refused));
                    }
                    if sent >= start {
                        if (200..300).contains(&status) { latencies.push(answered - sent) } else { refused += 1 }
                    }
                }
            }));
        }
        let (mut latencies, mut refused) = (Vec::new(), 0);
        for task in tasks {
            let (of_one, refused_of_one) = task.await.expect("a connection does not panic")?;
            latencies.extend(of_one);
            refused += refused_of_one;
        }
        Ok::<_, io::Error>((latencies, refused))
    });
    let (mut latencies, refused) = outcome.expect("the server keeps the connections");
    latencies.sort_unstable();
    let quantile = |q: f64| latencies.get((latencies.len() as f64 * q) as usize).copied().unwrap_or_default();
    Report {
        per_second: latencies.len() as f64 / load.measured.as_secs_f64(),
        p50: quantile(0.50),
        p99: quantile(0.99),
        refused,
    }
}

fn single_thread() -> tokio::runtime::Runtime {
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

    /// Sends one request and waits for its whole answer (answers of known length only, as the
    /// service sends them).
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
