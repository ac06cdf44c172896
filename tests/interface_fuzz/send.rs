//! A request on its way: through the router, or over a connection as bytes.

use std::{net::SocketAddr, time::Duration};

use axum::{
    body::Body,
    http::{self, HeaderName, HeaderValue, Method, Uri},
};
use tokio::{
    io::{AsyncReadExt as _, AsyncWriteExt as _},
    net::TcpStream,
};

use super::{fixture::Service, memory, request::Request, spool::Spool};

/// An answer; status 0 where the connection ended without one.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub media: String,
    pub tag: Option<String>,
    pub body: Vec<u8>,
    /// The most memory that was held until all of it had come.
    pub peak: usize,
}

/// Bytes of a head that are looked at.
const HEAD: usize = 2000;
/// Time for which a connection is read after the last byte.
const SILENCE: Duration = Duration::from_secs(8);

pub async fn send(service: &Service, request: &Request) -> Option<Answer> {
    if request.by_wire {
        return Some(by_wire(service.address, request).await);
    }
    // what http's types refuse cannot reach the router; it goes by wire or nowhere
    let method = Method::from_bytes(request.method.as_bytes()).ok()?;
    let uri: Uri = request.target.parse().ok()?;
    let mut built = http::Request::builder().method(method).uri(uri).header("host", "localhost");
    for (name, value) in &request.headers {
        let (name, value) = (HeaderName::from_bytes(name.as_bytes()).ok()?, HeaderValue::from_bytes(value).ok()?);
        built = built.header(name, value);
    }
    let (status, headers, body) = service.spool(built.body(Body::from(request.body.clone())).ok()?).await;
    let (peak, body) = (memory::peak(), body.into_bytes());
    let text = |name: &str| headers.get(name).map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned());
    let (media, tag) = (text("content-type").unwrap_or_default(), text("etag"));
    let body = unpacked(text("content-encoding").as_deref(), body);
    Some(Answer { status, media, tag, body, peak })
}

/// The bytes of a request with its head.
pub fn wire(request: &Request) -> Vec<u8> {
    let mut bytes = format!("{} {} HTTP/1.1\r\n", request.method, request.target).into_bytes();
    let mut line = |name: &[u8], value: &[u8]| {
        bytes.extend_from_slice(name);
        bytes.extend_from_slice(b": ");
        bytes.extend_from_slice(value);
        bytes.extend_from_slice(b"\r\n");
    };
    line(b"host", b"localhost");
    line(b"connection", b"close");
    line(b"content-length", request.body.len().to_string().as_bytes());
    request.headers.iter().for_each(|(name, value)| line(name.as_bytes(), value));
    if let Some(broken) = &request.broken_head {
        bytes.extend_from_slice(broken);
        bytes.extend_from_slice(b"\r\n");
    }
    bytes.extend_from_slice(b"\r\n");
    bytes.extend_from_slice(&request.body);
    bytes
}

async fn by_wire(address: SocketAddr, request: &Request) -> Answer {
    let mut got = Spool::default();
    // the part by which an answer without an end is known
    let mut head = Vec::new();
    if let Ok(mut stream) = TcpStream::connect(address).await {
        // a server may answer and close before it has read everything
        let _refused = stream.write_all(&wire(request)).await;
        if request.broken_head.is_some() {
            // a client that announces more must not wait for it; a client that closes its half
            // otherwise has left
            let _closed = stream.shutdown().await;
        }
        let mut buffer = vec![0; 1 << 16];
        loop {
            let wait = if endless(&head) { Duration::from_millis(20) } else { SILENCE };
            match tokio::time::timeout(wait, stream.read(&mut buffer)).await {
                Ok(Ok(count)) if count > 0 => {
                    got.put(&buffer[..count]);
                    head.extend_from_slice(&buffer[..count.min(HEAD - head.len())]);
                }
                _ => break,
            }
        }
    }
    let peak = memory::peak();
    parsed(&got.into_bytes(), peak)
}

fn endless(head: &[u8]) -> bool {
    let has = |needle: &[u8]| head.windows(needle.len()).any(|window| window == needle);
    has(b"text/event-stream") || has(b"101 Switching")
}

fn parsed(got: &[u8], peak: usize) -> Answer {
    let split = got.windows(4).position(|window| window == b"\r\n\r\n").unwrap_or(got.len());
    let head = String::from_utf8_lossy(&got[..split]).into_owned();
    let mut body = got.get(split + 4..).unwrap_or_default().to_vec();
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    let of = |wanted: &str| {
        let mut lines = head.lines().filter_map(|line| line.split_once(": "));
        lines.find(|(name, _)| name.eq_ignore_ascii_case(wanted)).map(|(_, value)| value.to_owned())
    };
    if status == 100 {
        return parsed(&body, peak);
    }
    if of("transfer-encoding").is_some() {
        body = joined(&body);
    }
    let body = unpacked(of("content-encoding").as_deref(), body);
    Answer { status, media: of("content-type").unwrap_or_default(), tag: of("etag"), body, peak }
}

/// The chunks of a body.
fn joined(mut rest: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    while let Some(end) = rest.windows(2).position(|window| window == b"\r\n") {
        let size = std::str::from_utf8(&rest[..end]).ok().and_then(|size| usize::from_str_radix(size.trim(), 16).ok());
        let Some(chunk) = size.filter(|size| *size > 0).and_then(|size| rest.get(end + 2..end + 2 + size)) else {
            break;
        };
        body.extend_from_slice(chunk);
        rest = rest.get(end + 4 + chunk.len()..).unwrap_or_default();
    }
    body
}

fn unpacked(encoding: Option<&str>, body: Vec<u8>) -> Vec<u8> {
    let mut out = Vec::new();
    let done = match encoding {
        Some("gzip") => std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&body[..]), &mut out).is_ok(),
        Some("zstd") => zstd::stream::copy_decode(&body[..], &mut out).is_ok(),
        _ => return body,
    };
    if done { out } else { b"the answer cannot be unpacked".to_vec() }
}
