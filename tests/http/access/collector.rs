//! A collector of traces of the tests: takes OTLP over HTTP, and reads the binary form of protocol
//! buffers by itself.

use std::{
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use super::issuer::{head_of, tls};

/// A span as it came.
#[derive(Clone, Debug, Default)]
pub struct Span {
    pub trace: String,
    pub id: String,
    pub parent: String,
    pub name: String,
    pub kind: u64,
    pub begun: u64,
    pub ended: u64,
    pub attributes: Vec<(String, String)>,
    pub events: usize,
    /// 0 unset, 1 good, 2 an error.
    pub status: u64,
}

impl Span {
    pub fn attribute(&self, name: &str) -> &str {
        self.attributes.iter().find(|(key, _)| key == name).map_or("", |(_, value)| value)
    }
}

/// See the module's documentation.
pub struct Collector {
    pub url: String,
    got: Arc<Mutex<Got>>,
}

#[derive(Default)]
struct Got {
    heads: Vec<String>,
    bytes: Vec<u8>,
    spans: Vec<Span>,
    resource: Vec<(String, String)>,
}

impl Collector {
    pub fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        Self::serve(listener, url, |stream| stream)
    }

    /// One that is reached by TLS, and the certificate that it shows (PEM).
    pub fn by_tls() -> (Self, String) {
        let (open, certificate) = tls();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("https://localhost:{}", listener.local_addr().unwrap().port());
        (Self::serve(listener, url, open), certificate)
    }

    fn serve<S: Read + Write + Send + 'static>(
        listener: TcpListener,
        url: String,
        open: impl Fn(TcpStream) -> S + Send + 'static,
    ) -> Self {
        let got = Arc::<Mutex<Got>>::default();
        let shared = got.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten().map(open) {
                let shared = shared.clone();
                std::thread::spawn(move || take(stream, &shared));
            }
        });
        Collector { url, got }
    }

    pub fn spans(&self) -> Vec<Span> {
        self.got.lock().unwrap().spans.clone()
    }

    /// Waits until the spans that came are such.
    pub async fn until(&self, wanted: impl Fn(&[Span]) -> bool) {
        let begun = Instant::now();
        while !wanted(&self.got.lock().unwrap().spans) {
            assert!(begun.elapsed() < Duration::from_secs(60), "{:#?}", self.spans());
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    /// Waits until a span has come. It ends a moment after its answer, and a server that ends has
    /// only two seconds to send what is left: so each is waited for before.
    pub async fn until_got(&self, id: &str) {
        self.until(|spans| spans.iter().any(|span| span.id == id)).await;
    }

    /// Heads and bodies, as they came.
    pub fn bytes(&self) -> Vec<u8> {
        let got = self.got.lock().unwrap();
        [got.heads.concat().as_bytes(), &got.bytes].concat()
    }

    pub fn heads(&self) -> Vec<String> {
        self.got.lock().unwrap().heads.clone()
    }

    /// An attribute of what the spans are of.
    pub fn resource(&self, name: &str) -> String {
        let got = self.got.lock().unwrap();
        got.resource.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone()).unwrap_or_default()
    }
}

/// Takes requests of a connection until it ends.
fn take(mut stream: impl Read + Write, got: &Mutex<Got>) -> std::io::Result<()> {
    loop {
        let head = head_of(&mut stream)?;
        let length = head
            .lines()
            .find_map(|line| line.to_ascii_lowercase().strip_prefix("content-length:")?.trim().parse().ok());
        let mut body = vec![0; length.unwrap_or(0)];
        stream.read_exact(&mut body)?;
        {
            let mut got = got.lock().unwrap();
            got.heads.push(head);
            read(&body, &mut got);
            got.bytes.extend(body);
        }
        stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-type: application/x-protobuf\r\ncontent-length: 0\r\n\r\n")?;
        stream.flush()?;
    }
}

/// A field of a message: its number, and its number or its bytes.
enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let (mut value, mut shift) = (0, 0);
    while let Some((byte, rest)) = bytes.split_first() {
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            break;
        }
    }
    value
}

/// The fields of a message, in their order.
fn fields(mut bytes: &[u8]) -> Vec<(u64, Value<'_>)> {
    let mut found = Vec::new();
    while !bytes.is_empty() {
        let tag = varint(&mut bytes);
        let mut taken = |length: usize| {
            let (first, rest) = bytes.split_at(length);
            bytes = rest;
            first
        };
        let value = match tag & 7 {
            0 => Value::Number(varint(&mut bytes)),
            1 => Value::Number(u64::from_le_bytes(taken(8).try_into().unwrap())),
            5 => Value::Number(u64::from(u32::from_le_bytes(taken(4).try_into().unwrap()))),
            2 => {
                let length = varint(&mut bytes) as usize;
                let (first, rest) = bytes.split_at(length);
                bytes = rest;
                Value::Bytes(first)
            }
            other => panic!("there is no wire type {other}"),
        };
        found.push((tag >> 3, value));
    }
    found
}

/// The messages of one field.
fn within(bytes: &[u8], number: u64) -> Vec<&[u8]> {
    let of = |(field, value)| match value {
        Value::Bytes(bytes) if field == number => Some(bytes),
        _ => None,
    };
    fields(bytes).into_iter().filter_map(of).collect()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Name and value of an attribute.
fn attribute(bytes: &[u8]) -> (String, String) {
    let name = text(within(bytes, 1)[0]);
    let value = fields(within(bytes, 2)[0]).into_iter().next().map(|(kind, value)| match (kind, value) {
        (1, Value::Bytes(bytes)) => text(bytes),
        (2 | 3, Value::Number(number)) => format!("{number} as a number"),
        (4, Value::Number(bits)) => f64::from_bits(bits).to_string(),
        (kind, _) => format!("of kind {kind}"),
    });
    (name, value.unwrap_or_default())
}

/// An `ExportTraceServiceRequest` (opentelemetry-proto, trace/v1).
fn read(body: &[u8], got: &mut Got) {
    for of_resource in within(body, 1) {
        for resource in within(of_resource, 1) {
            got.resource = within(resource, 1).into_iter().map(attribute).collect();
        }
        for of_scope in within(of_resource, 2) {
            got.spans.extend(within(of_scope, 2).into_iter().map(span));
        }
    }
}

fn span(bytes: &[u8]) -> Span {
    let mut span = Span::default();
    for (number, value) in fields(bytes) {
        match (number, value) {
            (1, Value::Bytes(id)) => span.trace = hex(id),
            (2, Value::Bytes(id)) => span.id = hex(id),
            (4, Value::Bytes(id)) => span.parent = hex(id),
            (5, Value::Bytes(name)) => span.name = text(name),
            (6, Value::Number(kind)) => span.kind = kind,
            (7, Value::Number(begun)) => span.begun = begun,
            (8, Value::Number(ended)) => span.ended = ended,
            (9, Value::Bytes(one)) => span.attributes.push(attribute(one)),
            (11, Value::Bytes(_)) => span.events += 1,
            (15, Value::Bytes(status)) => {
                for (number, value) in fields(status) {
                    if let (3, Value::Number(code)) = (number, value) {
                        span.status = code;
                    }
                }
            }
            _ => {}
        }
    }
    span
}
