//! Logs, metrics and traces. They are global to the process and set up once, however many servers
//! run in it (tests run many).

mod context;
mod export;
mod lines;
mod traces;

use std::{io::IsTerminal, sync::OnceLock, time::Duration};

use metrics::Label;
use metrics_exporter_prometheus::{Matcher, PrometheusBuilder, PrometheusHandle};
use tracing_subscriber::{
    EnvFilter, Layer, Registry, filter::Targets, layer::SubscriberExt as _, util::SubscriberInitExt as _,
};

use crate::config::{LogFormat, StartError, TraceSettings};

pub use context::{Above, TRACEPARENT, TRACESTATE, names};
pub use export::flush as flush_traces;
pub use lines::flush as flush_logs;
pub use traces::{
    Head, asked, asked_in_vain, asking_span, compute_span, failed, here, queue_span, request_span, responded,
    store_span,
};

/// Declares the metrics: kind, name, unit and description.
macro_rules! series {
    ($($kind:ident $NAME:ident = $name:literal, $($unit:ident,)? $about:literal;)+) => {
        $(#[doc = $about] pub const $NAME: &str = $name;)+

        fn describe() {
            $(series!(@ $kind $NAME, $(metrics::Unit::$unit,)? $about);)+
        }
    };
    (@ counter $($of:tt)+) => { metrics::describe_counter!($($of)+) };
    (@ gauge $($of:tt)+) => { metrics::describe_gauge!($($of)+) };
    (@ histogram $($of:tt)+) => { metrics::describe_histogram!($($of)+) };
}

series! {
    counter REQUESTS = "flankfit_http_requests_total", "Requests answered, by method, route and status";
    histogram REQUEST_SECONDS = "flankfit_http_request_duration_seconds", Seconds, "Time to answer a request";
    histogram FIT_SECONDS = "flankfit_fit_duration_seconds", Seconds,
        "Time to read, compute and write one fit, by class of node count";
    gauge QUEUE_DEPTH = "flankfit_fit_queue_depth", "Fits waiting for a worker";
    gauge BUSY_WORKERS = "flankfit_fit_workers_busy", "Workers at work";
    histogram CANCELLED_SECONDS = "flankfit_cancelled_work_seconds", Seconds,
        "Time spent on work that was cancelled, by reason; work that had not begun counts with 0";
    histogram STORE_SECONDS = "flankfit_store_duration_seconds", Seconds, "Time of one operation of the store";
    counter STORE_RETRIES = "flankfit_store_retries_total", "Transactions of the store that were tried again";
    gauge STORE_UP = "flankfit_store_up", "1 where the store answers and can be written";
    gauge CLOCK_SKEW = "flankfit_clock_skew_seconds", Seconds, "The database's clock before ours";
    histogram WAKE_DELAY = "flankfit_wake_delay_seconds", Seconds, "Time until other servers hear of an event";
    counter STREAM_CATCH_UPS = "flankfit_stream_catch_ups_total", "Times that a stream in memory was behind the store";
    histogram BLOCK_SECONDS = "flankfit_stream_block_duration_seconds", Seconds,
        "Time to add a block to a stream, estimate and store it";
    gauge LISTENERS = "flankfit_open_connections", "Event streams and WebSockets that are open, by kind";
    counter SHED = "flankfit_shed_total", "Requests and connections turned away for others' sake, by reason";
    counter AUTHENTICATIONS = "flankfit_auth_total", "Requests to /v1 by what their API key is";
    gauge DRAINING = "flankfit_draining", "1 from the signal to stop on";
    gauge TLS_EXPIRY = "flankfit_tls_expiry_seconds", Seconds, "Time until the server's certificate ends";
    gauge AUDIT_SEAL_AGE = "flankfit_audit_seal_age_seconds", Seconds,
        "Time since the last turn that sealed all entries of the audit and wrote all seals";
    gauge AUDIT_SEAL_INTERVAL = "flankfit_audit_seal_interval_seconds", Seconds, "Time between seals, as it is set";
    counter SPANS_DROPPED = "flankfit_trace_spans_dropped_total", "Spans that the collector did not take";
    gauge IDENTITY_PROVIDER_UP = "flankfit_identity_provider_up",
        "1 if the last request for the identity provider's keys succeeded";
    gauge BODY_MEMORY = "flankfit_body_memory_bytes", Bytes, "Bytes of bodies and unsent answers that are held";
    gauge CONNECTIONS = "flankfit_connections", "Connections that are open";
}

const SECONDS_BUCKETS: [f64; 16] =
    [5e-5, 1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3, 5e-3, 1e-2, 2.5e-2, 5e-2, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0];

/// Starts logging to standard error, panics included, and sending spans where the settings name a
/// collector. A second call changes nothing.
pub fn init(format: LogFormat, directives: &str, settings: &TraceSettings) -> Result<(), StartError> {
    let filter = EnvFilter::builder().parse(directives);
    let filter = filter.map_err(|error| format!("the log directives cannot be read: {error}"))?;
    let writer =
        lines::start().map_err(|error| format!("the thread that writes the log cannot be started: {error}"))?;
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
        describe();
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

/// Notes whether the keys of the identity provider could be loaded.
pub fn record_identity_provider(up: bool) {
    metrics::gauge!(IDENTITY_PROVIDER_UP).set(f64::from(up));
}

/// Notes that somebody was turned away.
pub fn record_shed(reason: &'static str) {
    metrics::counter!(SHED, "reason" => reason).increment(1);
}

/// Notes the response to a request.
pub fn record_answer(method: &'static str, route: &str, status: u16, elapsed: Duration) {
    let labels = vec![
        Label::new("method", method),
        Label::new("path", route.to_owned()),
        Label::new("status", status.to_string()),
    ];
    metrics::counter!(REQUESTS, labels.clone()).increment(1);
    metrics::histogram!(REQUEST_SECONDS, labels).record(elapsed.as_secs_f64());
}

/// Notes what the key of a request was.
pub fn record_authentication(outcome: &'static str) {
    metrics::counter!(AUTHENTICATIONS, "outcome" => outcome).increment(1);
}

/// Notes how long a fit of `nodes` nodes took.
pub fn record_fit(nodes: usize, elapsed: Duration) {
    metrics::histogram!(FIT_SECONDS, "size" => size_class(nodes)).record(elapsed.as_secs_f64());
}

fn size_class(nodes: usize) -> &'static str {
    match nodes {
        0..=100 => "le_100",
        101..=1_000 => "le_1000",
        1_001..=10_000 => "le_10000",
        10_001..=100_000 => "le_100000",
        100_001..=1_000_000 => "le_1000000",
        _ => "gt_1000000",
    }
}
