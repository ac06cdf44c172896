//! Settings of the server, as flags and as environment variables. `flankfit serve --help` lists
//! them all.

mod address;
mod audit;
mod auth;
mod bounds;
mod digest;
mod host;
mod network;
mod oidc;
mod origin;
mod store;
mod tls;
mod traces;

use std::{net::SocketAddr, num::NonZeroU32, path::PathBuf, time::Duration};

use clap::{Args, Command, FromArgMatches as _, ValueEnum};

pub use address::parse_address;
pub use audit::AuditSettings;
pub use auth::{Authentication, KeysRole};
pub use bounds::within;
pub use digest::{Digest, Digests, parse_digests};
pub use host::{Host, Hosts, parse_hosts};
pub use network::{Networks, parse_networks};
pub use oidc::OidcSettings;
pub use origin::{Origin, Origins, parse_origins};
pub use store::{MigrateMode, PostgresArguments};
pub use tls::{ClientAuthentication, TlsSettings};
pub use traces::TraceSettings;

/// Why something does not start, for a person to read.
pub type StartError = Box<dyn std::error::Error + Send + Sync>;

/// Format of log lines.
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
    /// localhost:8080; port 0 selects a free one.
    #[arg(long, env = "FLANKFIT_BIND", default_value = "127.0.0.1:8080", value_parser = parse_address)]
    pub bind: SocketAddr,
    /// Address and port of a second listener (plain HTTP) for /readyz and /metrics, which the first
    /// one then does not serve (/healthz is on both).
    #[arg(long, env = "FLANKFIT_OPS_BIND", value_parser = parse_address)]
    pub ops_bind: Option<SocketAddr>,
    #[command(flatten)]
    pub tls: TlsSettings,
    /// Networks (such as `10.1.0.0/16`, comma-separated) of proxies whose header `x-forwarded-for`
    /// is trusted.
    #[arg(
        long,
        env = "FLANKFIT_TRUSTED_PROXIES",
        default_value = "",
        value_parser = parse_networks,
        hide_default_value = true
    )]
    pub trusted_proxies: Networks,
    /// Requests per second to /v1/… for each API key, without keys for each client address; more
    /// are answered 429. Default: no limit.
    #[arg(long, env = "FLANKFIT_RATE_LIMIT", value_parser = within(NonZeroU32::MIN..=NonZeroU32::MAX))]
    pub rate_limit: Option<NonZeroU32>,
    /// Requests at once within the rate limit; default the requests of one second.
    #[arg(long, env = "FLANKFIT_RATE_BURST", requires = "rate_limit",
        value_parser = within(NonZeroU32::MIN..=NonZeroU32::MAX))]
    pub rate_burst: Option<NonZeroU32>,
    /// Database of the gear jobs: sqlite://FILE, or postgres://USER@HOST/NAME for several servers.
    #[arg(long, env = "FLANKFIT_DATABASE_URL", default_value = "sqlite://flankfit.db", hide_env_values = true)]
    pub database_url: String,
    #[command(flatten)]
    pub postgres: PostgresArguments,
    /// Threads that compute fits; 0 means one per processor.
    #[arg(long, env = "FLANKFIT_WORKERS", default_value_t = 0, value_parser = within(0..=bounds::MOST_WORKERS))]
    pub workers: usize,
    /// Maximum number of requests of a tenant waiting for a worker; more are answered 503.
    #[arg(long, env = "FLANKFIT_QUEUE", default_value_t = 1024, value_parser = within(1..=bounds::MOST_WAITING))]
    pub queue: usize,
    /// Largest request body in bytes, counted after decompression.
    #[arg(long, env = "FLANKFIT_BODY_LIMIT", default_value_t = 32 << 20,
        value_parser = within(bounds::LEAST_BODY..=bounds::MOST_BYTES))]
    pub body_limit: usize,
    /// Memory in bytes for all request bodies (as sent, decompressed and parsed) and unsent
    /// responses together. Requests that exceed it are answered 503, or 413 if one alone needs
    /// more.
    #[arg(long, env = "FLANKFIT_BODY_MEMORY", default_value_t = 768 << 20,
        value_parser = within(bounds::LEAST_MEMORY..=bounds::MOST_BYTES))]
    pub body_memory: usize,
    /// Seconds within which a request body must arrive, else 408.
    #[arg(long, env = "FLANKFIT_BODY_TIMEOUT", default_value_t = 60, value_parser = within(1..=bounds::DAY))]
    pub body_timeout: u64,
    /// Seconds without progress after which a client that does not read its response is
    /// disconnected.
    #[arg(long, env = "FLANKFIT_WRITE_TIMEOUT", default_value_t = 30, value_parser = within(1..=bounds::DAY))]
    pub write_timeout: u64,
    /// Maximum number of connections; fewer if the limit on open files is lower. When all are in
    /// use, the longest idle one is closed for a new client; if none is idle, the client waits.
    #[arg(long, env = "FLANKFIT_MAX_CONNECTIONS", default_value_t = 4096,
        value_parser = within(1..=bounds::MOST_CONNECTIONS))]
    pub max_connections: usize,
    /// Seconds within which a request must be answered, else 503.
    #[arg(long, env = "FLANKFIT_REQUEST_TIMEOUT", default_value_t = 120, value_parser = within(1..=bounds::DAY))]
    pub request_timeout: u64,
    /// Seconds within which a request with progress (`Accept: text/event-stream`) must be
    /// answered, else its last event is a problem.
    #[arg(long, env = "FLANKFIT_PROGRESS_TIMEOUT", default_value_t = 3600, value_parser = within(1..=bounds::DAY))]
    pub progress_timeout: u64,
    /// Intervals of events, which are no options.
    #[arg(skip)]
    pub pace: Pace,
    /// Seconds between the signal to stop and the end of accepting connections; meanwhile the
    /// server serves requests, reports that it is not ready and closes idle connections.
    #[arg(long, env = "FLANKFIT_DRAIN_DELAY", default_value_t = 0, value_parser = within(0..=bounds::DAY))]
    pub drain_delay: u64,
    /// Seconds that a shutdown waits for accepted requests.
    #[arg(long, env = "FLANKFIT_SHUTDOWN_GRACE", default_value_t = 30, value_parser = within(0..=bounds::DAY))]
    pub shutdown_grace: u64,
    /// Whether requests to /v1/… need a key.
    #[arg(long, env = "FLANKFIT_AUTH", value_enum, default_value_t = Authentication::Auto)]
    pub auth: Authentication,
    /// SHA-256 digests (hexadecimal, comma-separated) of API keys that are accepted in addition to
    /// those of the database.
    #[arg(
        long,
        env = "FLANKFIT_API_KEYS_SHA256",
        default_value = "",
        value_parser = parse_digests,
        hide_env_values = true,
        hide_default_value = true
    )]
    pub api_keys_sha256: Digests,
    /// Role of these keys, in the tenant `default`.
    #[arg(long, env = "FLANKFIT_API_KEYS_ROLE", value_enum, default_value_t = KeysRole::Engineer)]
    pub api_keys_role: KeysRole,
    #[command(flatten)]
    pub oidc: OidcSettings,
    #[command(flatten)]
    pub audit: AuditSettings,
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
    /// Hosts (such as `cell.example` or `cell.example:8080`, comma-separated) that requests may
    /// name, or `*` for any. Default: any, but only those of this machine if the server listens on
    /// the loopback address alone and requires no key.
    #[arg(
        long,
        env = "FLANKFIT_ALLOWED_HOSTS",
        default_value = "",
        value_parser = parse_hosts,
        hide_default_value = true
    )]
    pub allowed_hosts: Hosts,
    /// Format of the log lines on standard error.
    #[arg(long, env = "FLANKFIT_LOG_FORMAT", value_enum, default_value_t = LogFormat::Pretty)]
    pub log_format: LogFormat,
    /// Log level: error, warn, info, debug, trace, or directives such as `info,sqlx=warn`.
    #[arg(long, env = "FLANKFIT_LOG", default_value = "info")]
    pub log: String,
    #[command(flatten)]
    pub traces: TraceSettings,
    /// Serve the interactive documentation at /docs.
    #[arg(long, env = "FLANKFIT_DOCS", default_value_t = true, action = clap::ArgAction::Set)]
    pub docs: bool,
    /// Serve the dashboard at /; without it / leads to /docs.
    #[arg(long, env = "FLANKFIT_DASHBOARD", default_value_t = true, action = clap::ArgAction::Set)]
    pub dashboard: bool,
    /// Folder (such as web/) with the files of the dashboard, instead of those in the program; for
    /// its development.
    #[arg(long, env = "FLANKFIT_DASHBOARD_DIR", value_name = "DIR")]
    pub dashboard_dir: Option<PathBuf>,
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

    pub fn drain_delay(&self) -> Duration {
        Duration::from_secs(self.drain_delay)
    }

    pub fn shutdown_grace(&self) -> Duration {
        Duration::from_secs(self.shutdown_grace)
    }
}

/// Makes the default settings of types those of an empty command line and an empty environment.
macro_rules! defaults {
    ($($Settings:ty),*) => {
        $(impl Default for $Settings {
            fn default() -> Self {
                let command = <$Settings>::augment_args(Command::new("flankfit")).mut_args(|arg| arg.env(None::<&str>));
                let matches = command.try_get_matches_from(["flankfit"]);
                let read = matches.and_then(|matches| <$Settings>::from_arg_matches(&matches));
                read.unwrap_or_else(|error| error.exit())
            }
        })*
    };
}

defaults!(ServeSettings, AuditSettings, OidcSettings, PostgresArguments, TraceSettings);

/// Intervals of server-sent events, which are no options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Time between two looks at the progress of a request. A problem that is found before the
    /// first is returned as that of a plain request.
    pub look: Duration,
    /// Silence after which a comment keeps proxies from closing the connection.
    pub comment: Duration,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { look: Duration::from_secs(1), comment: Duration::from_secs(10) }
    }
}
