//! Logs, metrics and traces. They are global to the process and set up once, however many servers
//! run in it (tests run many).

mod answered;
mod context;
mod export;
mod lines;
mod series;
mod traces;

use std::{io::IsTerminal, sync::OnceLock, time::Duration};

use metrics_exporter_prometheus::{Matcher, PrometheusBuilder, PrometheusHandle};
use tracing_subscriber::{
    EnvFilter, Layer, Registry, filter::Targets, layer::SubscriberExt as _, util::SubscriberInitExt as _,
};

use crate::config::{LogFormat, TraceSettings};

pub use answered::{record_answer, record_authentication, record_fit};
pub use context::{Above, TRACEPARENT, TRACESTATE, names};
pub use export::{TraceError, flush as flush_traces};
pub use lines::flush as flush_logs;
pub use traces::{
    Head, asked, asked_in_vain, asking_span, compute_span, failed, here, queue_span, request_span, responded,
    store_span,
};

/// Seconds from a request's head to its answer's head. Labels: `method`, `path` (the route, not the
/// URL), `status`.
pub const REQUEST_SECONDS: &str = "flankfit_http_request_duration_seconds";
/// Requests answered. Same labels.
pub const REQUESTS: &str = "flankfit_http_requests_total";
/// Seconds of one fit (reading, computing, writing the answer). Label: `size` (the node count's
/// class).
pub const FIT_SECONDS: &str = "flankfit_fit_duration_seconds";
/// Fits waiting for a worker.
pub const QUEUE_DEPTH: &str = "flankfit_fit_queue_depth";
/// Workers at work.
pub const BUSY_WORKERS: &str = "flankfit_fit_workers_busy";
/// Seconds that a worker spent on work that was then cancelled. Label: `reason` (`abandoned`: the
/// client left or its time was over; `stopped`: the server stopped).
pub const CANCELLED_SECONDS: &str = "flankfit_cancelled_work_seconds";
/// Seconds from asking the store to its answer. Label: `operation`.
pub const STORE_SECONDS: &str = "flankfit_store_duration_seconds";
/// Transactions of the store that were tried again.
pub const STORE_RETRIES: &str = "flankfit_store_retries_total";

/// 1 if the store responds and can be written, as of the last check.
pub const STORE_UP: &str = "flankfit_store_up";
/// Seconds by which the clock of the database is before that of this process.
pub const CLOCK_SKEW: &str = "flankfit_clock_skew_seconds";
/// Seconds from telling other processes of an event until they hear it.
pub const WAKE_DELAY: &str = "flankfit_wake_delay_seconds";
/// Times that a stream in memory was behind the store.
pub const STREAM_CATCH_UPS: &str = "flankfit_stream_catch_ups_total";

/// Seconds of one block of a stream, from its nodes to its stored answer.
pub const BLOCK_SECONDS: &str = "flankfit_stream_block_duration_seconds";
/// Connections that stay open. Label: `kind` (`events`, `websocket`).
pub const LISTENERS: &str = "flankfit_open_connections";

/// Requests and connections that were turned away for others' sake. Label: `reason` (`queue`,
/// `body_memory`, `idle_connection`, `rate_limit`, `refusals`).
pub const SHED: &str = "flankfit_shed_total";
/// Requests to the versioned interface by what their key is. Label: `outcome` (`ok`, `none` where
/// none is asked for, `missing`, `invalid`, `unavailable` where nobody could be asked; once more as
/// `forbidden` what a good key has no scope for).
pub const AUTHENTICATIONS: &str = "flankfit_auth_total";
/// 1 from the signal to stop on.
pub const DRAINING: &str = "flankfit_draining";
/// Seconds until the server's certificate ends.
pub const TLS_EXPIRY: &str = "flankfit_tls_expiry_seconds";
/// Seconds since the last turn that sealed all entries of the audit and wrote all seals.
pub const AUDIT_SEAL_AGE: &str = "flankfit_audit_seal_age_seconds";
/// Seconds between two turns of sealing, as they are set.
pub const AUDIT_SEAL_INTERVAL: &str = "flankfit_audit_seal_interval_seconds";
/// Spans of batches that the collector did not take.
pub const SPANS_DROPPED: &str = "flankfit_trace_spans_dropped_total";
/// 1 if the last request for the identity provider's keys succeeded.
pub const IDENTITY_PROVIDER_UP: &str = "flankfit_identity_provider_up";
/// Bytes of bodies and responses in memory.
pub const BODY_MEMORY: &str = "flankfit_body_memory_bytes";
/// Connections that are open.
pub const CONNECTIONS: &str = "flankfit_connections";

const SECONDS_BUCKETS: [f64; 16] =
    [5e-5, 1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3, 5e-3, 1e-2, 2.5e-2, 5e-2, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0];

/// Why logging did not start.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    #[error("the log directives cannot be read: {0}")]
    Directives(#[from] tracing_subscriber::filter::ParseError),
    #[error("the thread that writes the log cannot be started: {0}")]
    Thread(#[from] std::io::Error),
    #[error(transparent)]
    Traces(#[from] TraceError),
}

/// Starts logging to standard error, panics included, and sending spans where the settings name a
/// collector. A second call changes nothing.
pub fn init(format: LogFormat, directives: &str, settings: &TraceSettings) -> Result<(), LogError> {
    let filter = EnvFilter::builder().parse(directives)?;
    let writer = lines::start()?;
    let ansi = std::io::stderr().is_terminal();
    // An error here means that a subscriber is already there, which is the wanted state.
    let _already = match export::start(settings)? {
        None => {
            let builder = tracing_subscriber::fmt().with_env_filter(filter).with_writer(writer).with_ansi(ansi);
            match format {
                LogFormat::Pretty => builder.try_init(),
                LogFormat::Json => builder.json().flatten_event(true).try_init(),
            }
        }
        Some(tracer) => {
            let lines = tracing_subscriber::fmt::layer().with_writer(writer).with_ansi(ansi);
            let lines: Box<dyn Layer<Registry> + Send + Sync> = match format {
                LogFormat::Pretty => lines.boxed(),
                LogFormat::Json => lines.json().flatten_event(true).boxed(),
            };
            // lines are for the log alone, and spans for the collector
            let of_log = filter.add_directive(format!("{}=off", traces::TARGET).parse()?);
            let of_collector = Targets::new().with_target(traces::TARGET, tracing::Level::INFO);
            let spans = tracing_opentelemetry::layer()
                .with_tracer(tracer)
                .with_location(false)
                .with_threads(false)
                .with_target(false)
                .with_tracked_inactivity(false)
                .with_context_activation(false);
            traces::begin(settings.otlp_sample);
            let both = tracing_subscriber::registry().with(lines.with_filter(of_log));
            both.with(spans.with_filter(of_collector)).try_init().map_err(Into::into)
        }
    };
    std::panic::set_hook(Box::new(|panic| {
        let backtrace = std::backtrace::Backtrace::capture();
        tracing::error!(%panic, %backtrace, "a thread panicked");
    }));
    Ok(())
}

/// The metrics recorder of this process, installed at the first call.
pub fn metrics() -> &'static PrometheusHandle {
    static HANDLE: OnceLock<PrometheusHandle> = OnceLock::new();
    HANDLE.get_or_init(|| {
        let builder = [REQUEST_SECONDS, FIT_SECONDS, CANCELLED_SECONDS, STORE_SECONDS, BLOCK_SECONDS, WAKE_DELAY]
            .into_iter()
            .fold(PrometheusBuilder::new(), |builder, name| {
                // Only an empty list of buckets is refused.
                builder
                    .set_buckets_for_metric(Matcher::Full(name.into()), &SECONDS_BUCKETS)
                    .unwrap_or_else(|_| PrometheusBuilder::new())
            });
        let recorder = builder.build_recorder();
        let handle = recorder.handle();
        let _already = metrics::set_global_recorder(recorder);
        metrics::describe_counter!(REQUESTS, "Requests answered, by method, route and status");
        metrics::describe_histogram!(REQUEST_SECONDS, metrics::Unit::Seconds, "Time to answer a request");
        metrics::describe_histogram!(
            FIT_SECONDS,
            metrics::Unit::Seconds,
            "Time to read, compute and write one fit, by class of node count"
        );
        metrics::describe_histogram!(
            CANCELLED_SECONDS,
            metrics::Unit::Seconds,
            "Time spent on work that was cancelled, by reason; work that had not begun counts with 0"
        );
        metrics::describe_gauge!(QUEUE_DEPTH, "Fits waiting for a worker");
        metrics::describe_gauge!(BUSY_WORKERS, "Workers at work");
        metrics::describe_histogram!(
            BLOCK_SECONDS,
            metrics::Unit::Seconds,
            "Time to add a block to a stream, estimate and store it"
        );
        metrics::describe_gauge!(LISTENERS, "Event streams and WebSockets that are open, by kind");
        metrics::describe_counter!(SHED, "Requests and connections turned away for others' sake, by reason");
        metrics::describe_counter!(AUTHENTICATIONS, "Requests to /v1 by what their API key is");
        metrics::describe_gauge!(DRAINING, "1 from the signal to stop on");
        metrics::describe_gauge!(TLS_EXPIRY, metrics::Unit::Seconds, "Time until the server's certificate ends");
        metrics::describe_gauge!(
            AUDIT_SEAL_AGE,
            metrics::Unit::Seconds,
            "Time since the last turn that sealed all entries of the audit and wrote all seals"
        );
        metrics::describe_gauge!(AUDIT_SEAL_INTERVAL, metrics::Unit::Seconds, "Time between seals, as it is set");
        metrics::describe_counter!(SPANS_DROPPED, "Spans that the collector did not take");
        metrics::describe_gauge!(
            IDENTITY_PROVIDER_UP,
            "1 if the last request for the identity provider's keys \
            succeeded"
        );
        metrics::describe_gauge!(BODY_MEMORY, metrics::Unit::Bytes, "Bytes of bodies and unsent answers that are held");
        metrics::describe_gauge!(CONNECTIONS, "Connections that are open");
        metrics::describe_counter!(STORE_RETRIES, "Transactions of the store that were tried again");
        metrics::describe_gauge!(STORE_UP, "1 where the store answers and can be written");
        metrics::describe_gauge!(CLOCK_SKEW, metrics::Unit::Seconds, "The database's clock before ours");
        metrics::describe_histogram!(WAKE_DELAY, metrics::Unit::Seconds, "Time until other servers hear of an event");
        metrics::describe_counter!(STREAM_CATCH_UPS, "Times that a stream in memory was behind the store");
        metrics::describe_histogram!(STORE_SECONDS, metrics::Unit::Seconds, "Time of one operation of the store");
        handle
    })
}

/// Drains the histograms' buffers from time to time, whether or not somebody reads the metrics.
/// Never ends.
pub async fn upkeep() {
    let mut clock = tokio::time::interval(Duration::from_secs(5));
    loop {
        clock.tick().await;
        metrics().run_upkeep();
    }
}

/// Notes that work was cancelled, and how long it had run.
pub fn record_cancelled(reason: &'static str, elapsed: Duration) {
    metrics::histogram!(CANCELLED_SECONDS, "reason" => reason).record(elapsed.as_secs_f64());
}

/// Notes that a stream in memory was behind the store.
pub fn record_catch_up() {
    metrics::counter!(STREAM_CATCH_UPS).increment(1);
}

/// Notes the time since the audit was sealed.
pub fn record_seal_age(age: Duration) {
    metrics::gauge!(AUDIT_SEAL_AGE).set(age.as_secs_f64());
}

/// Notes how often the audit is sealed.
pub fn record_seal_interval(interval: Duration) {
    metrics::gauge!(AUDIT_SEAL_INTERVAL).set(interval.as_secs_f64());
}

/// Records whether the store responds and can be written.
pub fn record_store_up(up: bool) {
    metrics::gauge!(STORE_UP).set(f64::from(up));
}

/// Notes that spans were dropped.
fn record_dropped_spans(count: u64) {
    metrics::counter!(SPANS_DROPPED).increment(count);
}

/// Records whether the keys of the identity provider could be loaded.
pub fn record_identity_provider(up: bool) {
    metrics::gauge!(IDENTITY_PROVIDER_UP).set(f64::from(up));
}

/// Notes that somebody was turned away.
pub fn record_shed(reason: &'static str) {
    metrics::counter!(SHED, "reason" => reason).increment(1);
}
