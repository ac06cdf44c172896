//! Spans on their way to a collector: in batches, by the thread of the SDK (OTLP over HTTP).
//!
//! The end of a span never waits: the SDK drops spans while its queue is full.

use std::{
    pin::Pin,
    sync::{
        Arc, Mutex, OnceLock, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use opentelemetry::{KeyValue, trace::TracerProvider as _};
use opentelemetry_http::{Bytes, HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{Protocol, WithExportConfig as _, WithHttpConfig as _};
use opentelemetry_sdk::{
    Resource,
    error::OTelSdkResult,
    resource::{EnvResourceDetector, TelemetryResourceDetector},
    trace::{
        BatchConfigBuilder, BatchSpanProcessor, IdGenerator as _, RandomIdGenerator, Sampler, SdkTracer,
        SdkTracerProvider, SpanData, SpanExporter,
    },
};

use super::SPANS_DROPPED;
use crate::{
    config::{StartError, TraceSettings},
    outgoing,
};

/// Spans that wait for the thread, and those of one batch.
const QUEUE: usize = 4096;
const BATCH: usize = 512;
/// Time between two batches.
const DELAY: Duration = Duration::from_secs(2);
/// Greatest duration of a request to the collector, and bytes of its response that are read.
const PATIENCE: Duration = Duration::from_secs(5);
const ANSWER: u64 = 1 << 16;
/// Time that the end of the program waits for the last spans.
const LAST: Duration = Duration::from_secs(2);

/// Below the collector's URL.
const PATH: &str = "/v1/traces";

/// The provider of this process, for its end.
static PROVIDER: OnceLock<SdkTracerProvider> = OnceLock::new();

/// Starts sending spans; none where the settings name no collector.
pub fn start(settings: &TraceSettings) -> Result<Option<SdkTracer>, StartError> {
    let Some(endpoint) = settings.collector(PATH).map_err(|error| format!("--otlp-endpoint: {error}"))? else {
        return Ok(None);
    };
    let why = Why::default();
    let agent = outgoing::agent(&endpoint, PATIENCE, settings.otlp_ca.clone());
    let client = Client { agent: agent.map_err(|error| format!("--otlp-ca: {error}"))?, why: Arc::clone(&why) };
    let exporter = opentelemetry_otlp::SpanExporter::builder()
        .with_http()
        .with_http_client(client)
        .with_protocol(Protocol::HttpBinary)
        .with_timeout(PATIENCE)
        .with_endpoint(endpoint)
        .with_headers(settings.headers().map_err(|error| format!("--otlp-headers: {error}"))?)
        .build()
        .map_err(|error| format!("--otlp-endpoint: {error}"))?;
    // counted from nothing, so that the first drop is seen as a rise
    super::metrics();
    metrics::counter!(SPANS_DROPPED).increment(0);
    let batches = BatchConfigBuilder::default()
        .with_max_queue_size(QUEUE)
        .with_max_export_batch_size(BATCH)
        .with_scheduled_delay(DELAY)
        .build();
    let exporter = Counted { exporter, fails: AtomicBool::new(false), why };
    let provider = SdkTracerProvider::builder()
        .with_span_processor(BatchSpanProcessor::builder(exporter).with_batch_config(batches).build())
        // what is not sampled has no span in the first place (`traces`)
        .with_sampler(Sampler::AlwaysOn)
        .with_resource(resource())
        .build();
    let tracer = provider.tracer("flankfit");
    let _first = PROVIDER.set(provider);
    Ok(Some(tracer))
}

/// Attributes of the process that spans belong to. Each process draws an id, which distinguishes
/// the servers of a plant; the environment overrides them.
fn resource() -> Resource {
    let id = uuid::Builder::from_random_bytes(RandomIdGenerator::default().new_trace_id().to_bytes()).into_uuid();
    let own = [
        KeyValue::new("service.version", env!("CARGO_PKG_VERSION")),
        KeyValue::new("service.instance.id", id.to_string()),
    ];
    let named = std::env::var("OTEL_SERVICE_NAME").ok().filter(|name| !name.is_empty());
    Resource::builder_empty()
        .with_service_name("flankfit")
        .with_attributes(own)
        .with_detectors(&[Box::new(TelemetryResourceDetector), Box::new(EnvResourceDetector::new())])
        .with_attributes(named.map(|name| KeyValue::new("service.name", name)))
        .build()
}

/// Sends what is left when the program ends.
pub fn flush() {
    if let Some(provider) = PROVIDER.get() {
        let _sent = provider.shutdown_with_timeout(LAST);
    }
}

/// Reason why a request to the collector failed: the exporter reports only that one did.
type Why = Arc<Mutex<Option<String>>>;

/// An exporter whose failures are counted, and logged once until it works again.
#[derive(Debug)]
struct Counted<E> {
    exporter: E,
    /// True if the last batch was not taken.
    fails: AtomicBool,
    why: Why,
}

impl<E: SpanExporter> SpanExporter for Counted<E> {
    async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
        let count = batch.len() as u64;
        let outcome = self.exporter.export(batch).await;
        let failed = self.fails.swap(outcome.is_err(), Ordering::Relaxed);
        let why = self.why.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Err(error) = &outcome {
            metrics::counter!(SPANS_DROPPED).increment(count);
            if !failed {
                let error = why.unwrap_or_else(|| error.to_string());
                tracing::warn!(error, "the collector of traces does not take spans: they are dropped until it does");
            }
        } else if failed {
            tracing::info!("the collector of traces takes spans again");
        }
        outcome
    }

    fn set_resource(&mut self, resource: &Resource) {
        self.exporter.set_resource(resource);
    }
}

/// The exporter's way to the collector.
#[derive(Debug)]
struct Client {
    agent: ureq::Agent,
    why: Why,
}

impl Client {
    fn ask(&self, request: Request<Bytes>) -> Result<Response<Bytes>, ureq::Error> {
        let (parts, body) = request.into_parts();
        let request = Request::from_parts(parts, &body[..]);
        // spans go where the setting says, and nowhere from there
        let request = self.agent.configure_request(request).max_redirects(0).build();
        let (parts, mut answer) = self.agent.run(request)?.into_parts();
        let answer = answer.with_config().limit(ANSWER).read_to_vec()?;
        Ok(Response::from_parts(parts, answer.into()))
    }
}

impl HttpClient for Client {
    fn send_bytes<'s, 'f>(
        &'s self,
        request: Request<Bytes>,
    ) -> Pin<Box<dyn Future<Output = Result<Response<Bytes>, HttpError>> + Send + 'f>>
    where
        's: 'f,
        Self: 'f,
    {
        Box::pin(async move {
            let answer = self.ask(request);
            let why = answer.as_ref().err().map(ToString::to_string);
            *self.why.lock().unwrap_or_else(PoisonError::into_inner) = why;
            Ok(answer?)
        })
    }
}
