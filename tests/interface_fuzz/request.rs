//! One request: an operation, its path and query, its headers and its body, all drawn.

use std::io::Write as _;

use super::{
    contract::{Contract, Operation, Parameter},
    fixture::Stored,
    forms::{self, Files},
    mutate::{self, Stock},
    node::Node,
    rng::Rng,
};

/// An unpacked bomb; more would only take longer.
const BOMB: usize = 24 << 20;

#[derive(Clone, Debug)]
pub struct Request {
    pub operation: String,
    pub method: String,
    pub target: String,
    pub headers: Vec<(String, Vec<u8>)>,
    pub body: Vec<u8>,
    /// The body before it was compressed, where it is meant to be JSON.
    pub json: Option<Vec<u8>>,
    /// Over a connection of its own; else handed to the router.
    pub by_wire: bool,
    /// Bytes put into the head as they are; only by wire.
    pub broken_head: Option<Vec<u8>>,
}

/// Sources of requests.
pub struct Maker<'a> {
    pub contract: &'a Contract,
    /// Each operation that is drawn, as often as it is to be, with one of its bodies.
    pub draws: &'a [(Operation, Option<Node>)],
    pub bodies: &'a [Node],
    pub files: &'a Files,
}

impl Maker<'_> {
    pub fn make(&self, stored: &Stored, rng: &mut Rng) -> Request {
        // one draw for every operation, so that dear examples of one do not push out others
        let (operation, body) = &self.draws[rng.below(self.draws.len())];
        let stock = Stock { contract: self.contract, bodies: self.bodies };
        let mut headers: Vec<(String, Vec<u8>)> = Vec::new();
        let mut json = None;
        let mut bytes = Vec::new();
        let form = operation.bodies.iter().find(|(media, _)| media == "multipart/form-data");
        let wants_form = form.filter(|_| body.is_none() || rng.percent(20));
        if let Some((_, schema)) = wants_form {
            let spec = body.as_ref().map(|body| mutate::mutated(&without_nodes(body), &stock, rng));
            let (media, form) = forms::form(self.contract, operation, schema, spec, self.files, rng);
            headers.push(("content-type".into(), media.into_bytes()));
            bytes = form;
        } else if let Some(body) = body {
            let mut body = mutate::mutated(body, &stock, rng);
            stored.put_ids(&mut body, rng);
            bytes = body.written();
            if rng.percent(7) {
                mutate::bytes(&mut bytes, rng);
            }
            json = Some(bytes.clone());
            headers.push(("content-type".into(), b"application/json".to_vec()));
        } else if rng.percent(3) {
            bytes = b"{\"unasked\":1}".to_vec();
        }
        if !bytes.is_empty() && rng.percent(6) {
            self.wrong_media(&mut headers, rng);
        }
        if !bytes.is_empty() && rng.percent(12) {
            compress(&mut bytes, &mut headers, &mut json, rng);
        }
        for parameter in operation.parameters.iter().filter(|p| p.place == "header") {
            if rng.percent(60) {
                headers.push((parameter.name.to_lowercase(), header(&parameter.name, stored, rng)));
            }
        }
        while rng.percent(15) {
            headers.push(any_header(stored, rng));
        }
        let by_wire = rng.percent(8);
        let broken_head = (by_wire && rng.percent(25)).then(|| broken(rng));
        let method = if rng.percent(1) {
            rng.one(["GET", "HEAD", "OPTIONS", "POST", "PUT", "TRACE", "BREW"]).to_owned()
        } else {
            operation.method.clone()
        };
        let target = target(operation, stored, rng);
        Request { operation: operation.id.clone(), method, target, headers, body: bytes, json, by_wire, broken_head }
    }

    fn wrong_media(&self, headers: &mut Vec<(String, Vec<u8>)>, rng: &mut Rng) {
        headers.retain(|(name, _)| name != "content-type");
        let media = rng.one([
            "application/json; charset=utf-8",
            "application/json; charset=UTF-16",
            "application/json;charset=\"latin1\"",
            "APPLICATION/JSON",
            "text/json",
            "application/problem+json",
            "text/plain",
            "text/csv",
            "multipart/form-data",
            "multipart/form-data; boundary=",
            "multipart/form-data; boundary=x",
            "application/x-www-form-urlencoded",
            "*/*",
            "",
            "a/b; c=\"",
        ]);
        if rng.percent(85) {
            headers.push(("content-type".into(), media.as_bytes().to_vec()));
        }
    }
}

fn without_nodes(body: &Node) -> Node {
    match body {
        Node::Object(fields) => Node::Object(fields.iter().filter(|(name, _)| name != "nodes").cloned().collect()),
        other => other.clone(),
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    let written = out.write_all(bytes).and_then(|()| out.finish());
    written.expect("compression in memory")
}

fn zstd_of(bytes: &[u8]) -> Vec<u8> {
    zstd::encode_all(bytes, 1).expect("compression in memory")
}

fn compress(bytes: &mut Vec<u8>, headers: &mut Vec<(String, Vec<u8>)>, json: &mut Option<Vec<u8>>, rng: &mut Rng) {
    let name = rng.one(["gzip", "zstd"]);
    if rng.percent(1) {
        // blanks in front of a body are JSON; so much of them is nearly nothing to send
        let mut bomb = vec![b' '; rng.one([1 << 20, BOMB])];
        bomb.extend_from_slice(bytes);
        *bytes = bomb;
    }
    let encoding = match rng.below(10) {
        0..5 => {
            *bytes = if name == "gzip" { gzip(bytes) } else { zstd_of(bytes) };
            name
        }
        5 => {
            *bytes = zstd_of(&gzip(bytes));
            "gzip, zstd"
        }
        6 => {
            *bytes = gzip(bytes);
            mutate::bytes(bytes, rng);
            *json = None;
            "gzip"
        }
        7 => {
            *bytes = zstd_of(bytes);
            mutate::bytes(bytes, rng);
            *json = None;
            "zstd"
        }
        _ => rng.one(["gzip", "zstd", "br", "identity", "GZIP", "gzip,gzip,gzip,gzip", "", "deflate"]),
    };
    headers.push(("content-encoding".into(), encoding.as_bytes().to_vec()));
}

fn header(name: &str, stored: &Stored, rng: &mut Rng) -> Vec<u8> {
    match name.to_lowercase().as_str() {
        "idempotency-key" => format!("key-{}", rng.below(12)).into_bytes(),
        "if-match" | "if-none-match" => stored.tag(rng).into_bytes(),
        _ => rng.one(["0", "1", "-1", "latest", "18446744073709551616", "", "x"]).as_bytes().to_vec(),
    }
}

fn any_header(stored: &Stored, rng: &mut Rng) -> (String, Vec<u8>) {
    let name = rng.one([
        "accept",
        "accept-encoding",
        "idempotency-key",
        "if-match",
        "if-none-match",
        "last-event-id",
        "x-request-id",
        "origin",
        "authorization",
        "x-api-key",
        "range",
        "expect",
        "x-forwarded-for",
    ]);
    let value: Vec<u8> = match (name, rng.below(4)) {
        ("accept", 0..3) => rng
            .one([
                "application/json",
                "text/csv",
                "*/*",
                "text/html",
                "application/json;q=0, */*",
                "text/csv;q=0.5,*/*;q=0.1",
                "text/event-stream",
                "a",
                "",
            ])
            .as_bytes()
            .to_vec(),
        ("accept-encoding", 0..3) => rng.one(["gzip", "zstd", "br", "gzip;q=0, *", "identity;q=0"]).as_bytes().to_vec(),
        ("idempotency-key", 0) => format!("key-{}", rng.below(12)).into_bytes(),
        ("if-match" | "if-none-match", 0..3) => stored.tag(rng).into_bytes(),
        ("range", 0..3) => b"bytes=0-18446744073709551615".to_vec(),
        (_, 1) => b"x".repeat(rng.one([1, 200, 255, 256, 4000])),
        (_, 2) => b"\xc3\xa9\xff \t".to_vec(),
        _ => rng.one(["", "0", "*", "a, b", "\"x\"", "W/\"1\"", "null", "https://example.org"]).as_bytes().to_vec(),
    };
    (name.to_owned(), value)
}

/// Lines that no client of good will sends.
fn broken(rng: &mut Rng) -> Vec<u8> {
    rng.one([
        &b"no colon here"[..],
        b": no name",
        b"bad name: x",
        b"content-length: 5",
        b"content-length: 99999999999999999999",
        b"content-length: -1",
        b"transfer-encoding: chunked",
        b"transfer-encoding: gzip, chunked",
        b"host: a\r\nhost: b",
        b"x: \x00\x01",
        b"x: a\r\n folded",
        b"expect: 100-continue",
        b"upgrade: websocket\r\nconnection: upgrade\r\nsec-websocket-version: 13\r\nsec-websocket-key: \
            dGhlIHNhbXBsZSBub25jZQ==",
        b"connection: close, close, x",
    ])
    .to_vec()
}

fn target(operation: &Operation, stored: &Stored, rng: &mut Rng) -> String {
    let mut target = String::new();
    let owner = stored.draw(rng);
    for part in operation.path.split_inclusive('/') {
        let (name, slash) = part.strip_suffix('/').map_or((part, ""), |name| (name, "/"));
        match name.strip_prefix('{').and_then(|name| name.strip_suffix('}')) {
            Some(name) => target.push_str(&owner.segment(name, rng)),
            None => target.push_str(name),
        }
        target.push_str(slash);
    }
    if rng.percent(1) {
        target.push_str(rng.one(["/", "//", "/..", "%2e%2e", "%", "?", "#", "é"]));
    }
    let mut query: Vec<String> = Vec::new();
    for Parameter { name, schema, .. } in operation.parameters.iter().filter(|p| p.place == "query") {
        if rng.percent(50) {
            query.push(format!("{name}={}", query_value(schema, rng)));
        }
    }
    if rng.percent(2) {
        query.push(
            rng.one([
                "limit=1",
                "unknown=1",
                "include=all",
                "limit=1&limit=1",
                "%ff=1",
                "=",
                "&&",
                "a[]=1",
                "cursor=%00",
            ])
            .to_owned(),
        );
    }
    if !query.is_empty() {
        target.push('?');
        target.push_str(&query.join("&"));
    }
    target
}

fn query_value(schema: &serde_json::Value, rng: &mut Rng) -> String {
    let known = schema["enum"].as_array().or(schema["items"]["enum"].as_array());
    if let Some(one) = known.and_then(|all| rng.pick(all)).and_then(|one| one.as_str()).filter(|_| rng.percent(80)) {
        return one.to_owned();
    }
    rng.one([
        "0",
        "1",
        "2",
        "100",
        "101",
        "-1",
        "1.5",
        "18446744073709551615",
        "18446744073709551616",
        "",
        "a",
        "%00",
        "%ff",
        "NaN",
        "+",
        "1e3",
        "AAAA",
        "MDE5MGIwZGU",
        "%F0%9F%98%80",
        "all",
        "nodes,result",
        "\"",
    ])
    .replace('"', "%22")
}
