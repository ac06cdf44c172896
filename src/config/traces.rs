//! Settings of the collector of spans.

use std::{collections::HashMap, path::PathBuf};

use clap::Args;

use super::bounds::parse_part;

#[derive(Clone, Debug, PartialEq, Args)]
pub struct TraceSettings {
    /// URL of a collector (OTLP over HTTP, such as http://collector:4318) for spans of requests.
    /// Default: none.
    #[arg(long, env = "FLANKFIT_OTLP_ENDPOINT", value_name = "URL", hide_env_values = true)]
    pub otlp_endpoint: Option<String>,
    /// Share (0 to 1) of the requests whose spans are sent, among those without a decision of the
    /// client (`traceparent`).
    #[arg(long, env = "FLANKFIT_OTLP_SAMPLE", default_value_t = 0.01, value_parser = parse_part)]
    pub otlp_sample: f64,
    /// File (PEM) with the certificate authorities of the collector; default those that browsers
    /// trust.
    #[arg(long, env = "FLANKFIT_OTLP_CA", value_name = "FILE", requires = "otlp_endpoint")]
    pub otlp_ca: Option<PathBuf>,
    /// Headers for the collector, such as its key: NAME=VALUE, comma-separated, values
    /// percent-encoded.
    #[arg(long, env = "OTEL_EXPORTER_OTLP_HEADERS", value_name = "HEADERS", hide_env_values = true)]
    pub otlp_headers: Option<String>,
}

/// The headers are not repeated, since they are secrets, nor is the URL, since it may contain a
/// password.
const HEADERS: &str = "write NAME=VALUE, several separated by commas";
const PLAIN: &str = "write a URL without query, fragment and user; headers go into --otlp-headers";
const URL: &str = "write a URL such as http://collector:4318";

impl TraceSettings {
    /// Headers for the collector; their values are still percent-encoded.
    pub fn headers(&self) -> Result<HashMap<String, String>, &'static str> {
        let all = self.otlp_headers.as_deref().unwrap_or_default().split(',').map(str::trim);
        let read = |header: &str| {
            let (name, value) = header.split_once('=')?;
            (!name.trim().is_empty()).then(|| (name.trim().to_owned(), value.trim().to_owned()))
        };
        all.filter(|header| !header.is_empty()).map(|header| read(header).ok_or(HEADERS)).collect()
    }

    /// Returns the address for spans at the collector: its URL, with `path` unless the URL has one.
    pub fn collector(&self, path: &str) -> Result<Option<String>, &'static str> {
        let Some(url) = self.otlp_endpoint.as_deref() else { return Ok(None) };
        if url.contains(['?', '#', '@']) || url.contains(char::is_whitespace) {
            return Err(PLAIN);
        }
        let named = url.strip_prefix("http://").or_else(|| url.strip_prefix("https://"));
        let (host, below) = named.map(|named| named.split_once('/').unwrap_or((named, ""))).unwrap_or_default();
        match (host, below) {
            ("", _) => Err(URL),
            (_, "") => Ok(Some(url.trim_end_matches('/').to_owned() + path)),
            _ => Ok(Some(url.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn collector(url: &str) -> Result<Option<String>, &'static str> {
        let settings = TraceSettings { otlp_endpoint: Some(url.into()), ..TraceSettings::default() };
        settings.collector("/v1/traces")
    }

    #[test]
    fn headers_are_read_one_by_one() {
        let headers = |text: &str| TraceSettings { otlp_headers: Some(text.into()), ..Default::default() }.headers();
        let two = [("x-key", "a=b"), ("x-plant", "one%20two")].map(|(name, value)| (name.into(), value.into()));
        assert_eq!(headers("x-key=a=b, x-plant = one%20two,"), Ok(HashMap::from(two)));
        assert_eq!(headers(""), Ok(HashMap::new()));
        for wrong in ["x-key", "=secret", "x-key=a,secret"] {
            assert_eq!(headers(wrong), Err(HEADERS), "{wrong}");
        }
    }

    #[test]
    fn spans_go_below_the_collectors_url() {
        assert_eq!(TraceSettings::default().collector("/v1/traces"), Ok(None));
        for (url, at) in [
            ("http://collector:4318", "http://collector:4318/v1/traces"),
            ("http://[::1]:4318/", "http://[::1]:4318/v1/traces"),
            ("https://collector/otlp/v1/traces", "https://collector/otlp/v1/traces"),
        ] {
            assert_eq!(collector(url), Ok(Some(at.to_owned())));
        }
        for wrong in ["", "collector:4317", "grpc://collector", "http://", "http:///v1/traces"] {
            assert_eq!(collector(wrong), Err(URL), "{wrong}");
        }
        for more in ["http://a b", "https://u:p@collector", "https://collector?key=1", "https://collector/#x"] {
            assert_eq!(collector(more), Err(PLAIN), "{more}");
        }
    }
}
