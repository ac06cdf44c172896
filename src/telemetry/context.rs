//! Headers that name spans to others, by W3C Trace Context: in requests that come, and in those
//! that the server makes itself.

use opentelemetry::{
    Context,
    propagation::{Extractor, Injector, TextMapPropagator as _},
    trace::SpanContext,
};
use opentelemetry_sdk::propagation::TraceContextPropagator;
use tracing::Span;
use tracing_opentelemetry::OpenTelemetrySpanExt as _;

/// The headers of a trace (W3C Trace Context).
pub const TRACEPARENT: &str = "traceparent";
pub const TRACESTATE: &str = "tracestate";

/// Bytes of other tracers' states that go on: spans wait in memory, and how long they are must not
/// be the clients' choice.
const LONGEST_STATE: usize = 512;

/// Trace context that a request carries for the span above it.
pub struct Above<'a> {
    /// Value of the header; `None` if there are several, since it is not known which one holds.
    pub traceparent: Option<&'a str>,
    /// The states of other tracers, of however many headers.
    pub tracestate: Option<String>,
}

impl Above<'_> {
    /// The span above; none where the headers do not name one as they should.
    pub fn context(&self) -> Context {
        match self.traceparent {
            Some(_) => TraceContextPropagator::new().extract_with_context(&Context::new(), self),
            None => Context::new(),
        }
    }
}

impl Extractor for Above<'_> {
    fn get(&self, key: &str) -> Option<&str> {
        match key {
            TRACEPARENT => self.traceparent.filter(|named| is_traceparent(named)),
            TRACESTATE => self.tracestate.as_deref().filter(|states| states.len() <= LONGEST_STATE),
            _ => None,
        }
    }

    fn keys(&self) -> Vec<&str> {
        vec![TRACEPARENT, TRACESTATE]
    }
}

/// True if the text has the form of W3C Trace Context: version, trace, span and flags in lower-case
/// hexadecimal digits; versions after the first may continue.
fn is_traceparent(text: &str) -> bool {
    let is_hex = |byte: &u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
    let Some((known, more)) = text.as_bytes().split_at_checked(55) else { return false };
    let fields: Vec<&[u8]> = known.split(|byte| *byte == b'-').collect();
    fields.iter().map(|field| field.len()).eq([2, 32, 16, 2])
        && fields.iter().all(|field| field.iter().all(is_hex))
        && (more.is_empty() || (fields[0] != b"00" && more[0] == b'-'))
}

/// Headers by their names.
pub type Headers = Vec<(String, String)>;

struct Written(Headers);

impl Injector for Written {
    fn set(&mut self, key: &str, value: String) {
        if !value.is_empty() {
            self.0.push((key.to_owned(), value));
        }
    }
}

/// The headers that name a span to others; none where there is none.
pub fn names(span: &Span) -> Headers {
    let mut written = Written(Vec::new());
    if !span.is_disabled() {
        TraceContextPropagator::new().inject_context(&span.context(), &mut written);
    }
    written.0
}

/// Value of `traceparent` for a span.
pub fn traceparent(of: &SpanContext) -> Option<String> {
    of.is_valid().then(|| format!("00-{}-{}-{:02x}", of.trace_id(), of.span_id(), of.trace_flags()))
}

#[cfg(test)]
mod tests {
    use opentelemetry::trace::TraceContextExt as _;

    use super::*;

    /// Parent of a request with these headers: trace id, sampling flag and trace state.
    fn above(traceparent: &str, tracestate: Option<&str>) -> Option<(String, bool, String)> {
        let named = Above { traceparent: Some(traceparent), tracestate: tracestate.map(str::to_owned) };
        let context = named.context();
        let span = context.span();
        let of = span.span_context();
        let states = of.trace_state().header();
        of.is_valid().then(|| (of.trace_id().to_string(), of.is_sampled(), states))
    }

    /// W3C Trace Context, 3.2.2: others begin a new trace.
    #[test]
    fn a_traceparent_is_read_by_its_definition() {
        const TRACE: &str = "4bf92f3577b34da6a3ce929d0e0e4736";
        const SPAN: &str = "00f067aa0ba902b7";
        let none = String::new();
        for (flags, sampled) in [("00", false), ("01", true), ("02", false), ("ff", true)] {
            let text = format!("00-{TRACE}-{SPAN}-{flags}");
            assert_eq!(above(&text, None), Some((TRACE.into(), sampled, none.clone())), "{text}");
        }
        for later in ["cc-T-S-01", "cc-T-S-01-what-follows", "01-T-S-01-"] {
            let text = later.replace('T', TRACE).replace('S', SPAN);
            assert_eq!(above(&text, None), Some((TRACE.into(), true, none.clone())), "{text}");
        }
        for wrong in [
            "",
            "00",
            "00-T-S",
            "00-T-S-1",
            "00-T-S-01-",
            "00-T-S-01-more",
            "cc-T-S-01.more",
            "ff-T-S-01",
            "0-T-S-01",
            "+0-T-S-01",
            "00-1-S-01",
            "00-T-1-01",
            "00-T+S-01",
            "00-T-S-0A",
            "00-T-S-0é",
            "00-00000000000000000000000000000000-S-01",
            "00-T-0000000000000000-01",
            "00-4BF92F3577B34DA6A3CE929D0E0E4736-S-01",
            "00-+bf92f3577b34da6a3ce929d0e0e4736-S-01",
            "00-T-00F067AA0BA902B7-01",
        ] {
            let text = wrong.replace('T', TRACE).replace('S', SPAN);
            assert_eq!(above(&text, Some("a=1")), None, "{text}");
        }
        let text = format!("00-{TRACE}-{SPAN}-01");
        for (states, kept) in [("a=1,b=2", "a=1,b=2"), ("nonsense", "")] {
            assert_eq!(above(&text, Some(states)), Some((TRACE.into(), true, kept.into())), "{states}");
        }
        let states =
            |count: usize| (0..count).map(|n| format!("k{n}={}", "1".repeat(120))).collect::<Vec<_>>().join(",");
        assert!(states(4).len() <= LONGEST_STATE && states(5).len() > LONGEST_STATE);
        assert_eq!(above(&text, Some(&states(4))), Some((TRACE.into(), true, states(4))));
        assert_eq!(above(&text, Some(&states(5))), Some((TRACE.into(), true, none)));
    }
}
