//! Settings of the server, as flags and as environment variables. `flankfit serve --help` lists
//! them all.

use std::{
    net::{SocketAddr, ToSocketAddrs},
    time::Duration,
};

use clap::{Args, ValueEnum};

/// How log lines look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Human-readable lines.
    Pretty,
    /// One JSON object per line.
    Json,
}

#[derive(Clone, Debug, Args)]
pub struct ServeSettings {
    /// Address (or name of this machine) and port to listen on, such as 0.0.0.0:8080 or
    /// localhost:8080; port 0 takes any free one.
    #[arg(long, env = "FLANKFIT_BIND", default_value = "127.0.0.1:8080", value_parser = parse_address)]
    pub bind: SocketAddr,
    /// Database of the gear jobs: sqlite://FILE.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db")]
    pub database_url: String,
    /// Threads that compute fits; 0 means one per processor.
    #[arg(long, env = "FLANKFIT_WORKERS", default_value_t = 0)]
    pub workers: usize,
    /// Longest queue of requests that wait for a worker; beyond it the answer is 503.
    #[arg(long, env = "FLANKFIT_QUEUE", default_value_t = 1024)]
    pub queue: usize,
    /// Largest request body in bytes, counted after decompression.
    #[arg(long, env = "FLANKFIT_BODY_LIMIT", default_value_t = 256 * 1024 * 1024)]
    pub body_limit: usize,
    /// Memory in bytes for all request bodies (as sent, decompressed and parsed) and unsent
    /// responses together. Beyond it requests are refused: 503, or 413 for one that needs more than
    /// this alone.
    #[arg(long, env = "FLANKFIT_BODY_MEMORY", default_value_t = 1 << 30)]
    pub body_memory: usize,
    /// Seconds within which a request body must arrive (else 408).
    #[arg(long, env = "FLANKFIT_BODY_TIMEOUT", default_value_t = 60,
        value_parser = clap::value_parser!(u64).range(1..))]
    pub body_timeout: u64,
    /// Seconds without progress after which a client that does not read its response is
    /// disconnected.
    #[arg(long, env = "FLANKFIT_WRITE_TIMEOUT", default_value_t = 30,
        value_parser = clap::value_parser!(u64).range(1..))]
    pub write_timeout: u64,
    /// Most connections at a time; fewer if the limit on open files is lower. When all are in use,
    /// the longest idle one is closed for a new client; if none is idle, the client waits.
    #[arg(long, env = "FLANKFIT_MAX_CONNECTIONS", default_value_t = 4096)]
    pub max_connections: usize,
    /// Seconds within which a request must be answered (else 503).
    #[arg(long, env = "FLANKFIT_REQUEST_TIMEOUT", default_value_t = 120,
        value_parser = clap::value_parser!(u64).range(1..))]
    pub request_timeout: u64,
    /// Seconds that a shutdown waits for accepted requests.
    #[arg(long, env = "FLANKFIT_SHUTDOWN_GRACE", default_value_t = 30)]
    pub shutdown_grace: u64,
    /// SHA-256 digests (hexadecimal, comma-separated) of the accepted API keys; if empty, no key is
    /// required.
    #[arg(
        long,
        env = "FLANKFIT_API_KEYS_SHA256",
        default_value = "",
        value_parser = parse_digests,
        hide_env_values = true,
        hide_default_value = true
    )]
    pub api_keys_sha256: Digests,
    /// Origins (such as `https://cell.example`, comma-separated) whose web pages may call this
    /// server; if empty, only its own.
    #[arg(
        long,
        env = "FLANKFIT_CORS_ORIGINS",
        default_value = "",
        value_parser = parse_origins,
        hide_default_value = true
    )]
    pub cors_origins: Origins,
    /// Format of the log lines on standard error.
    #[arg(long, env = "FLANKFIT_LOG_FORMAT", value_enum, default_value_t = LogFormat::Pretty)]
    pub log_format: LogFormat,
    /// Log level: error, warn, info, debug, trace, or directives such as `info,sqlx=warn`.
    #[arg(long, env = "FLANKFIT_LOG", default_value = "info")]
    pub log: String,
    /// Serve the interactive documentation at /docs.
    #[arg(long, env = "FLANKFIT_DOCS", default_value_t = true, action = clap::ArgAction::Set)]
    pub docs: bool,
}

/// SHA-256 of an API key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub [u8; 32]);

/// Those of all keys.
pub type Digests = Vec<Digest>;

/// Where a web page comes from, as browsers write it: scheme, host, and the port where it is not
/// that of the scheme.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin(String);

/// Those of all pages that may call.
pub type Origins = Vec<Origin>;

impl Origin {
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Origins separated by commas; an empty text has none.
pub fn parse_origins(text: &str) -> Result<Origins, String> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    text.split(',').map(|origin| parse_origin(origin.trim())).collect()
}

fn parse_origin(text: &str) -> Result<Origin, String> {
    const FORM: &str =
        "write SCHEME://HOST or SCHEME://HOST:PORT, such as https://cell.example or http://localhost:3000";
    let refused = |why: &str| format!("`{text}` is not an origin: {why}; {FORM}");
    let lower = text.to_ascii_lowercase();
    let (scheme, authority) = lower.split_once("://").ok_or_else(|| refused("it has no scheme"))?;
    if !matches!(scheme, "http" | "https") {
        return Err(refused("its scheme is neither http nor https"));
    }
    if authority.contains(['/', '?', '#']) {
        return Err(refused("it has a path"));
    }
    if authority.contains('*') {
        return Err(refused("origins are named, there are no wildcards"));
    }
    let (host, port) = match authority.rsplit_once(':') {
        // the colons of an IPv6 address are its own
        Some((host, port)) if !port.ends_with(']') => {
            let port = port.parse::<u16>().map_err(|_| refused("its port is not a number up to 65535"))?;
            (host, Some(port))
        }
        _ => (authority, None),
    };
    let of_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let address = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    let valid = match address {
        Some(address) => address.parse::<std::net::Ipv6Addr>().is_ok(),
        None => !host.is_empty() && host.chars().all(of_name),
    };
    if !valid {
        return Err(refused("its host is not a name or an address"));
    }
    let usual = if scheme == "https" { 443 } else { 80 };
    let port = port.filter(|port| *port != usual).map_or(String::new(), |port| format!(":{port}"));
    Ok(Origin(format!("{scheme}://{host}{port}")))
}

/// An address with a port, or a name with one. Of a name's addresses the first of IPv4 is taken,
/// else the first.
pub fn parse_address(text: &str) -> Result<SocketAddr, String> {
    const FORM: &str = "write ADDRESS:PORT, such as 127.0.0.1:8080, [::1]:8080 or localhost:8080";
    let found = text.to_socket_addrs().map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidInput => FORM.to_owned(),
        _ => format!("the name is not known here ({error}); {FORM}"),
    })?;
    let found: Vec<SocketAddr> = found.collect();
    found.iter().find(|address| address.is_ipv4()).or(found.first()).copied().ok_or_else(|| FORM.to_owned())
}

/// Digests separated by commas; an empty text has none, as in `FLANKFIT_API_KEYS_SHA256=`.
fn parse_digests(text: &str) -> Result<Digests, String> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    text.split(',').map(parse_digest).collect()
}

fn parse_digest(text: &str) -> Result<Digest, String> {
    let text = text.trim();
    let mut digest = [0_u8; 32];
    if text.len() != 64 || !text.is_ascii() {
        return Err("a SHA-256 digest has 64 hexadecimal digits".into());
    }
    for (byte, pair) in digest.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
        let pair = std::str::from_utf8(pair).map_err(|error| error.to_string())?;
        *byte = u8::from_str_radix(pair, 16).map_err(|error| error.to_string())?;
    }
    Ok(Digest(digest))
}

impl ServeSettings {
    /// The number of fit workers after `0` has been replaced by the number of processors.
    pub fn worker_count(&self) -> usize {
        match self.workers {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        }
    }

    pub fn body_timeout(&self) -> Duration {
        Duration::from_secs(self.body_timeout)
    }

    pub fn write_timeout(&self) -> Duration {
        Duration::from_secs(self.write_timeout)
    }

    pub fn request_timeout(&self) -> Duration {
        Duration::from_secs(self.request_timeout)
    }

    pub fn shutdown_grace(&self) -> Duration {
        Duration::from_secs(self.shutdown_grace)
    }
}

impl Default for ServeSettings {
    /// What an empty command line and an empty environment give.
    fn default() -> Self {
        ServeSettings {
            bind: SocketAddr::from(([127, 0, 0, 1], 8080)),
            database_url: "sqlite://flankfit.db".into(),
            workers: 0,
            queue: 1024,
            body_limit: 256 * 1024 * 1024,
            body_memory: 1 << 30,
            body_timeout: 60,
            write_timeout: 30,
            max_connections: 4096,
            request_timeout: 120,
            shutdown_grace: 30,
            api_keys_sha256: Vec::new(),
            cors_origins: Vec::new(),
            log_format: LogFormat::Pretty,
            log: "info".into(),
            docs: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_are_read_strictly() {
        let text = "00ff".to_owned() + &"0".repeat(60);
        assert_eq!(parse_digest(&text).map(|d| d.0[1]), Ok(255));
        assert!(parse_digest("00").is_err());
        assert!(parse_digest(&"g".repeat(64)).is_err());
        assert_eq!(parse_digests(&format!("{text}, {text}")).map(|digests| digests.len()), Ok(2));
        assert_eq!(parse_digests(" "), Ok(Vec::new()));
        assert!(parse_digests(&format!("{text},")).is_err());
    }

    #[test]
    fn origins_are_those_that_browsers_send() {
        let of =
            |text: &str| parse_origins(text).map(|all| all.into_iter().map(|Origin(text)| text).collect::<Vec<_>>());
        assert_eq!(of(" "), Ok(vec![]));
        assert_eq!(
            of("https://Cell.example:443, http://localhost:3000,http://[::1]:80"),
            Ok(vec!["https://cell.example".into(), "http://localhost:3000".into(), "http://[::1]".into()])
        );
        for (text, why) in [
            ("*", "no scheme"),
            ("null", "no scheme"),
            ("cell.example", "no scheme"),
            ("ftp://cell.example", "neither http nor https"),
            ("https://cell.example/", "a path"),
            ("https://*.example", "no wildcards"),
            ("https://cell.example:x", "not a number"),
            ("https://", "not a name"),
            ("https://a b", "not a name"),
            ("https://a@b", "not a name"),
            ("https://cell.example,", "no scheme"),
        ] {
            assert!(of(text).unwrap_err().contains(why), "{text}");
        }
    }

    #[test]
    fn names_are_addresses_too() {
        assert_eq!(parse_address("[::1]:80").map(|address| address.port()), Ok(80));
        assert!(
            parse_address("localhost:8080").is_ok_and(|address| address.ip().is_loopback() && address.port() == 8080)
        );
        for wrong in ["", "8080", "127.0.0.1", "localhost:", "localhost:99999"] {
            assert!(parse_address(wrong).unwrap_err().contains("ADDRESS:PORT"), "{wrong}");
        }
    }
}
