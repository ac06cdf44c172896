//! Spans of requests and of what is done for them, for a collector of traces (OpenTelemetry).
//!
//! A request's span is the child of the one that its client names (`traceparent`), whose sampling
//! decision holds; without one a share of all requests is sampled. Its children are the wait for a
//! worker, computing, reads and writes of the store, and requests that the server makes itself. A
//! span has method, route, status and times: no body, no key, no query and no tenant.
//!
//! What is not sampled has no spans at all: most requests pay for a draw and for the header of
//! their answer. Where no collector is named, asking whether one is costs a load.

use std::sync::OnceLock;

use opentelemetry::{
    Context,
    trace::{SpanContext, SpanKind, TraceContextExt as _, TraceFlags, TraceState},
};
use opentelemetry_sdk::trace::{IdGenerator as _, RandomIdGenerator, Sampler, SamplingDecision, ShouldSample as _};
use tracing::{Span, field, info_span};
use tracing_opentelemetry::OpenTelemetrySpanExt as _;
use ureq::http::{Uri, uri::Authority};

use super::context::{Above, traceparent};

/// Target of the spans' tracing events, which are in no log.
pub const TARGET: &str = "flankfit::trace";

/// Bytes of a host that a span holds (a name in DNS has 253): spans wait in memory, and their size
/// must not be the clients' choice.
const LONGEST_HOST: usize = 255;

/// Sampler of the traces that begin here; empty if no collector is named.
static SAMPLER: OnceLock<Sampler> = OnceLock::new();

/// From now on there are spans, of this part of the traces that begin here.
pub fn begin(sample: f64) {
    let _first = SAMPLER.set(Sampler::TraceIdRatioBased(sample));
}

/// Head of a request, as far as its span records it.
pub struct Head<'a> {
    /// Method; `None` if HTTP does not define it.
    pub method: Option<&'static str>,
    /// Route; `None` if none matches.
    pub route: Option<&'a str>,
    pub scheme: &'static str,
    /// Host that the request names.
    pub host: Option<&'a str>,
    pub id: &'a str,
    pub above: Above<'a>,
}

/// Returns the span of a request, none if it is not sampled, and the `traceparent` of its response,
/// `None` if there are no traces. `head` is called only if there are.
pub fn request_span<'a>(head: impl FnOnce() -> Head<'a>) -> (Span, Option<String>) {
    let Some(sampler) = SAMPLER.get() else { return (Span::none(), None) };
    let head = head();
    let above = head.above.context();
    if let Some(unsampled) = unsampled(sampler, &above) {
        return (Span::none(), traceparent(&unsampled));
    }
    let Head { method, route, scheme, .. } = head;
    let called = method.unwrap_or("HTTP");
    let server = head.host.filter(|host| host.len() <= LONGEST_HOST).and_then(|host| host.parse::<Authority>().ok());
    let span = info_span!(
        target: TARGET,
        parent: None,
        "request",
        otel.name = route.map_or(called.to_owned(), |route| format!("{called} {route}")),
        otel.kind = "server",
        otel.status_code = field::Empty,
        http.request.method = method.unwrap_or("_OTHER"),
        http.route = route,
        http.response.status_code = field::Empty,
        "error.type" = field::Empty,
        url.scheme = scheme,
        server.address = server.as_ref().map(|server| without_brackets(server.host())),
        server.port = server.as_ref().map(|server| port(server.port_u16(), scheme)),
        flankfit.request_id = head.id,
    );
    // a span that has not begun can be given a parent
    let _given = span.set_parent(above);
    let named = traceparent(span.context().span().span_context());
    (span, named)
}

/// Context of a trace that is not sampled; `None` if it is sampled.
fn unsampled(sampler: &Sampler, above: &Context) -> Option<SpanContext> {
    let ids = RandomIdGenerator::default();
    let span = above.span();
    let parent = span.span_context();
    let (trace, state) = if parent.is_valid() {
        if parent.is_sampled() {
            return None;
        }
        (parent.trace_id(), parent.trace_state().clone())
    } else {
        let trace = ids.new_trace_id();
        let drawn = sampler.should_sample(None, trace, "", &SpanKind::Server, &[], &[]);
        if drawn.decision == SamplingDecision::RecordAndSample {
            return None;
        }
        (trace, TraceState::default())
    };
    Some(SpanContext::new(trace, ids.new_span_id(), TraceFlags::default(), false, state))
}

/// Records the status of the response in a request's span: 500 and above is an error.
pub fn responded(span: &Span, status: u16) {
    end(span, status, 500);
}

/// Records the status received in the span of a request that the server made: 400 and above is an
/// error.
pub fn asked(span: &Span, status: u16) {
    end(span, status, 400);
}

/// Records that no response was received.
pub fn asked_in_vain(span: &Span) {
    failed(span, "_OTHER");
}

/// Records the kind of error with which a span ends.
pub fn failed(span: &Span, kind: &str) {
    span.record("otel.status_code", "ERROR");
    span.record("error.type", kind);
}

fn end(span: &Span, status: u16, errors_from: u16) {
    if span.is_disabled() {
        return;
    }
    span.record("http.response.status_code", i64::from(status));
    if status >= errors_from {
        failed(span, &status.to_string());
    }
}

/// The span that is being worked in; none where there is none of these.
pub fn here() -> Span {
    if SAMPLER.get().is_none() {
        return Span::none();
    }
    let current = Span::current();
    if current.metadata().is_some_and(|of| of.target() == TARGET) { current } else { Span::none() }
}

/// From being put into the queue until a worker begins.
pub fn queue_span(parent: &Span) -> Span {
    below(parent, || info_span!(target: TARGET, parent: parent, "queue", otel.kind = "internal"))
}

/// Span of a computation, below the span of its request.
pub fn compute_span(parent: &Span) -> Span {
    below(parent, || info_span!(target: TARGET, parent: parent, "compute", otel.kind = "internal"))
}

/// An operation of the store on this kind of database. `operation` is a type with the operation's
/// name.
pub fn store_span(system: &'static str, operation: &'static str) -> Span {
    let parent = here();
    below(&parent, || {
        let name = operation.rsplit("::").next().unwrap_or(operation).trim_end_matches('>');
        info_span!(
            target: TARGET,
            parent: &parent,
            "store",
            otel.name = name,
            otel.kind = "client",
            otel.status_code = field::Empty,
            "error.type" = field::Empty,
            db.system.name = system,
            db.operation.name = name,
        )
    })
}

/// Span of a request that the server makes, without the URL's query.
pub fn asking_span(method: &'static str, url: &str) -> Span {
    let parent = here();
    below(&parent, || {
        let url = url.parse::<Uri>().unwrap_or_default();
        let (host, scheme) = (url.host().unwrap_or_default(), url.scheme_str().unwrap_or_default());
        let port = port(url.port_u16(), scheme);
        info_span!(
            target: TARGET,
            parent: &parent,
            "request",
            otel.name = method,
            otel.kind = "client",
            otel.status_code = field::Empty,
            http.request.method = method,
            http.response.status_code = field::Empty,
            "error.type" = field::Empty,
            url.full = format!("{scheme}://{host}:{port}{}", url.path()),
            server.address = without_brackets(host),
            server.port = port,
        )
    })
}

/// Begins a span below `parent`; without a parent there is none.
fn below(parent: &Span, begin: impl FnOnce() -> Span) -> Span {
    if parent.is_disabled() { Span::none() } else { begin() }
}

/// An address of IPv6 has brackets within a URL only.
fn without_brackets(host: &str) -> &str {
    host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host)
}

fn port(named: Option<u16>, scheme: &str) -> i64 {
    i64::from(named.unwrap_or(if scheme == "https" { 443 } else { 80 }))
}

#[cfg(test)]
mod tests {
    use opentelemetry::trace::{SpanId, TraceId};

    use super::{super::context::names, *};

    fn below_parent(flags: TraceFlags) -> Context {
        let parent = SpanContext::new(TraceId::from(7), SpanId::from(9), flags, true, TraceState::default());
        Context::new().with_remote_span_context(parent)
    }

    #[test]
    fn the_parent_decides_and_else_a_draw() {
        for sample in [0.0, 0.5, 1.0] {
            let sampler = Sampler::TraceIdRatioBased(sample);
            assert_eq!(unsampled(&sampler, &below_parent(TraceFlags::SAMPLED)), None);
            let on = unsampled(&sampler, &below_parent(TraceFlags::default())).unwrap();
            assert!(on.trace_id() == TraceId::from(7) && on.span_id() != SpanId::from(9) && !on.is_sampled());
            let named = traceparent(&on).unwrap();
            assert_eq!(named, format!("00-{:032x}-{}-00", 7, on.span_id()));
            let drawn = (0..4000).filter(|_| unsampled(&sampler, &Context::new()).is_none()).count();
            // seven standard deviations
            assert!((drawn as f64 - 4000.0 * sample).abs() <= 7.0 * (4000.0 * sample * (1.0 - sample)).sqrt());
        }
    }

    #[test]
    fn nothing_begins_without_a_collector() {
        // no test of this program begins sending
        let (span, named) = request_span(|| unreachable!("nobody asks for the head"));
        assert!(span.is_disabled() && named.is_none() && names(&span).is_empty());
        assert!(here().is_disabled());
        assert!(store_span("sqlite", "a::Asked<b::InsertJob>").is_disabled());
    }

    #[test]
    fn addresses_have_no_brackets() {
        assert_eq!((without_brackets("[::1]"), without_brackets("a.example")), ("::1", "a.example"));
    }
}
