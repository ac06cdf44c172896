//! Spans on their way to a collector: in batches, by a thread of their own (OTLP over HTTP).
//!
//! What ends a span never waits: where the queue is full, the span is dropped and counted. So is a
//! batch that the collector does not take.

use std::{
    fmt::{self, Debug},
    pin::Pin,
    sync::{
        Arc, Mutex, OnceLock, PoisonError,
        mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel},
    },
    time::{Duration, Instant},
};

use futures_util::FutureExt as _;
use opentelemetry::{Context, KeyValue, trace::TracerProvider as _};
use opentelemetry_http::{Bytes, HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{ExporterBuildError, Protocol, SpanExporter, WithExportConfig as _, WithHttpConfig as _};
use opentelemetry_sdk::{
    Resource,
    error::{OTelSdkError, OTelSdkResult},
    resource::{EnvResourceDetector, TelemetryResourceDetector},
    trace::{
        IdGenerator as _, RandomIdGenerator, Sampler, SdkTracer, SdkTracerProvider, Span, SpanData, SpanExporter as _,
        SpanProcessor,
    },
};

use super::record_dropped_spans;
use crate::{
    config::{EndpointError, HeadersError, TraceSettings},
    outgoing::{self, OutgoingError},
};

/// Spans that wait for the thread, and those that go at once.
const PLACES: usize = 4096;
const BATCH: usize = 512;
/// Time for which spans are gathered after the first one.
const DELAY: Duration = Duration::from_secs(2);
/// Greatest duration of a request to the collector, and bytes of its response that are read.
const PATIENCE: Duration = Duration::from_secs(5);
const ANSWER: u64 = 1 << 16;
/// Time that the end of the program waits for the last spans, and time between two attempts at a
/// full queue.
const LAST: Duration = Duration::from_secs(2);
const FULL: Duration = Duration::from_millis(5);

/// Below the collector's URL.
const PATH: &str = "/v1/traces";

/// Reason why spans cannot be sent.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    #[error("--otlp-ca: {0}")]
    Authorities(#[from] OutgoingError),
    #[error("--otlp-endpoint: {0}")]
    Endpoint(#[from] EndpointError),
    #[error("--otlp-headers: {0}")]
    Headers(#[from] HeadersError),
    #[error("--otlp-endpoint: {0}")]
    Exporter(#[from] ExporterBuildError),
    #[error("the thread that sends spans cannot be started: {0}")]
    Thread(#[from] std::io::Error),
}

/// The provider of this process, for its end.
static PROVIDER: OnceLock<SdkTracerProvider> = OnceLock::new();

/// Starts sending spans; none where the settings name no collector.
pub fn start(settings: &TraceSettings) -> Result<Option<SdkTracer>, TraceError> {
    let Some(endpoint) = settings.collector(PATH)? else { return Ok(None) };
    let why = Why::default();
    let client =
        Client { agent: outgoing::agent(&endpoint, PATIENCE, settings.otlp_ca.clone())?, why: Arc::clone(&why) };
    let mut exporter = SpanExporter::builder()
        .with_http()
        .with_http_client(client)
        .with_protocol(Protocol::HttpBinary)
        .with_timeout(PATIENCE)
        .with_endpoint(endpoint)
        .with_headers(settings.headers()?)
        .build()?;
    let resource = resource();
    exporter.set_resource(&resource);
    // counted from nothing, so that the first drop is seen as a rise
    super::metrics();
    ["queue", "export"].into_iter().for_each(|reason| record_dropped_spans(reason, 0));
    let (sender, waiting) = sync_channel(PLACES);
    std::thread::Builder::new()
        .name("traces".into())
        .spawn(move || Sending { exporter, fails: false, why }.run(&waiting))?;
    let provider = SdkTracerProvider::builder()
        .with_span_processor(Queue(sender))
        // what is not sampled has no span in the first place (`traces`)
        .with_sampler(Sampler::AlwaysOn)
        .with_resource(resource)
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
        let _sent = provider.force_flush();
    }
}

/// Message to the exporting thread.
enum Message {
    Ended(Box<SpanData>),
    /// Export all earlier spans, then confirm.
    Flush(SyncSender<()>),
}

/// Queue of ended spans for the exporting thread.
struct Queue(SyncSender<Message>);

impl Debug for Queue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Queue")
    }
}

impl SpanProcessor for Queue {
    fn on_start(&self, _span: &mut Span, _context: &Context) {}

    fn on_end(&self, span: SpanData) {
        if self.0.try_send(Message::Ended(Box::new(span))).is_err() {
            record_dropped_spans("queue", 1);
        }
    }

    fn force_flush(&self) -> OTelSdkResult {
        self.shutdown_with_timeout(LAST)
    }

    fn shutdown_with_timeout(&self, timeout: Duration) -> OTelSdkResult {
        let late = || Err(OTelSdkError::Timeout(timeout));
        let until = Instant::now() + timeout;
        let (answer, done) = sync_channel(1);
        let mut message = Message::Flush(answer);
        loop {
            match self.0.try_send(message) {
                Ok(()) => break,
                Err(TrySendError::Disconnected(_)) => return late(),
                Err(TrySendError::Full(_)) if Instant::now() >= until => return late(),
                Err(TrySendError::Full(again)) => message = again,
            }
            std::thread::sleep(FULL);
        }
        done.recv_timeout(until.saturating_duration_since(Instant::now())).or_else(|_| late())
    }
}

/// State of the exporting thread.
struct Sending<E> {
    exporter: E,
    /// True if the last batch was not taken.
    fails: bool,
    why: Why,
}

/// Reason why a request to the collector failed: the exporter reports only that one did.
type Why = Arc<Mutex<Option<String>>>;

impl<E: opentelemetry_sdk::trace::SpanExporter> Sending<E> {
    fn run(mut self, waiting: &Receiver<Message>) {
        let mut batch = Vec::new();
        let mut until = Instant::now();
        loop {
            let message = match batch.is_empty() {
                true => waiting.recv().map_err(|_| RecvTimeoutError::Disconnected),
                false => waiting.recv_timeout(until.saturating_duration_since(Instant::now())),
            };
            match message {
                Ok(Message::Ended(span)) => {
                    if batch.is_empty() {
                        until = Instant::now() + DELAY;
                    }
                    batch.push(*span);
                    if batch.len() >= BATCH {
                        self.send(std::mem::take(&mut batch));
                    }
                }
                Ok(Message::Flush(answer)) => {
                    self.send(std::mem::take(&mut batch));
                    let _gone = answer.send(());
                }
                Err(RecvTimeoutError::Timeout) => self.send(std::mem::take(&mut batch)),
                Err(RecvTimeoutError::Disconnected) => return self.send(batch),
            }
        }
    }

    fn send(&mut self, batch: Vec<SpanData>) {
        if batch.is_empty() {
            return;
        }
        let count = batch.len() as u64;
        // the client completes before it returns, so there is nothing to wait for
        let outcome = self.exporter.export(batch).now_or_never();
        let failed = match outcome {
            Some(Ok(())) => None,
            Some(Err(error)) => Some(error.to_string()),
            None => Some("the collector asks to be asked again later".to_owned()),
        };
        let why = self.why.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(error) = failed.as_ref().map(|error| why.as_ref().unwrap_or(error)) {
            record_dropped_spans("export", count);
            if !self.fails {
                tracing::warn!(error, "the collector of traces does not take spans: they are dropped until it does");
            }
        } else if self.fails {
            tracing::info!("the collector of traces takes spans again");
        }
        self.fails = failed.is_some();
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

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use opentelemetry::trace::{Span as _, Tracer as _};

    use super::*;

    /// Notes what it is given, and takes as long as somebody lets it.
    #[derive(Clone)]
    struct Noting(Arc<Mutex<Vec<usize>>>, Arc<Mutex<mpsc::Receiver<()>>>);

    impl Debug for Noting {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("Noting")
        }
    }

    impl opentelemetry_sdk::trace::SpanExporter for Noting {
        async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
            self.0.lock().unwrap().push(batch.len());
            let _let_on = self.1.lock().unwrap().recv();
            Ok(())
        }
    }

    fn provider(queue: Queue) -> SdkTracerProvider {
        SdkTracerProvider::builder().with_span_processor(queue).with_sampler(Sampler::AlwaysOn).build()
    }

    /// Waits until the exporter has a batch.
    fn until_one_goes(noted: &Mutex<Vec<usize>>) {
        let begun = Instant::now();
        while noted.lock().unwrap().is_empty() {
            assert!(begun.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_full_queue_drops_and_holds_up_nobody() {
        super::super::metrics();
        let (noted, (let_on, held)) = (Arc::default(), mpsc::channel());
        let exporter = Noting(Arc::clone(&noted), Arc::new(Mutex::new(held)));
        let (sender, waiting) = sync_channel(10);
        let provider = provider(Queue(sender.clone()));
        let tracer = provider.tracer("test");
        tracer.start("first").end();
        // the wish to flush lies behind the first before anybody looks: so it takes no place later
        let (answer, flushed) = sync_channel(1);
        sender.send(Message::Flush(answer)).unwrap();
        let thread = std::thread::spawn(move || Sending { exporter, fails: false, why: Why::default() }.run(&waiting));
        // the exporter is at work on the first, and is not let on
        until_one_goes(&noted);
        for _ in 0..100 {
            tracer.start("more").end();
        }
        let dropped = super::super::metrics().render();
        assert!(dropped.contains("flankfit_trace_spans_dropped_total{reason=\"queue\"} 90"), "{dropped}");
        drop(let_on);
        flushed.recv().unwrap();
        assert!(Queue(sender.clone()).shutdown_with_timeout(Duration::from_secs(60)).is_ok());
        drop((provider, tracer, sender));
        thread.join().unwrap();
        assert_eq!(*noted.lock().unwrap(), [1, 10]);
    }

    /// The exporter is held until the end no longer waits for it, however slow the machine is.
    #[test]
    fn the_end_waits_for_no_collector() {
        let (noted, (let_on, held)) = (Arc::default(), mpsc::channel());
        let exporter = Noting(Arc::clone(&noted), Arc::new(Mutex::new(held)));
        let (sender, waiting) = sync_channel(1);
        let thread = std::thread::spawn(move || Sending { exporter, fails: false, why: Why::default() }.run(&waiting));
        let (told, outcome) = mpsc::channel();
        let ending = std::thread::spawn({
            let (provider, noted) = (provider(Queue(sender)), Arc::clone(&noted));
            move || {
                provider.tracer("test").start("first").end();
                told.send(provider.force_flush()).unwrap();
                until_one_goes(&noted);
                // the only place is taken now, so that there is none for the wish to flush
                provider.tracer("test").start("second").end();
                told.send(provider.force_flush()).unwrap();
            }
        });
        for _ in 0..2 {
            let flushed = outcome.recv_timeout(Duration::from_secs(60)).expect("the end waits for the exporter");
            assert!(flushed.is_err(), "the exporter has not been let on");
        }
        drop(let_on);
        ending.join().unwrap();
        thread.join().unwrap();
        assert_eq!(*noted.lock().unwrap(), [1, 1]);
    }
}
