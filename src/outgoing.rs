//! Requests that the server itself makes of others: by TLS with aws-lc-rs, within limits of time.

use std::{fs, net::IpAddr, path::PathBuf, sync::Arc, time::Duration};

use tokio_rustls::rustls::crypto::aws_lc_rs::default_provider;
use ureq::{
    Agent,
    http::Uri,
    tls::{PemItem, RootCerts, TlsConfig, TlsProvider, parse_pem},
};

/// How long a connection may take to be there.
const CONNECT: Duration = Duration::from_secs(5);

/// An agent for requests to `url` that end within `limit`. Servers are believed by the authorities
/// of `file`; without one by those that browsers believe.
pub fn agent(url: &str, limit: Duration, file: Option<PathBuf>) -> Result<Agent, String> {
    let tls = TlsConfig::builder()
        .provider(TlsProvider::Rustls)
        .unversioned_rustls_crypto_provider(Arc::new(default_provider()))
        .root_certs(file.map_or(Ok(RootCerts::WebPki), authorities)?)
        .build();
    let config = Agent::config_builder()
        .timeout_global(Some(limit))
        .timeout_connect(Some(CONNECT.min(limit)))
        .http_status_as_error(false)
        .max_redirects(3)
        .tls_config(tls);
    // What is on this machine is asked without a proxy, whatever the environment says.
    let config = if is_here(url) { config.proxy(None) } else { config };
    Ok(config.build().into())
}

/// Whether a URL leads to the machine itself.
pub fn is_here(url: &str) -> bool {
    let Ok(url) = url.parse::<Uri>() else { return false };
    if url.scheme().is_none() {
        return false;
    }
    let host = url.host().unwrap_or_default().trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

fn authorities(file: PathBuf) -> Result<RootCerts, String> {
    let text = match fs::read(&file) {
        Ok(text) => text,
        Err(source) => return Err(format!("cannot read {}: {source}", file.display())),
    };
    let certificates: Vec<_> = parse_pem(&text)
        .filter_map(|item| match item {
            Ok(PemItem::Certificate(certificate)) => Some(certificate),
            _ => None,
        })
        .collect();
    if certificates.is_empty() {
        let file = file.display();
        return Err(format!("{file} holds no certificate in PEM form (`-----BEGIN CERTIFICATE-----`)"));
    }
    Ok(RootCerts::Specific(Arc::new(certificates)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_is_known_by_its_names() {
        for here in ["http://127.0.0.1:1/x", "http://localhost", "http://[::1]:8080/"] {
            assert!(is_here(here), "{here}");
        }
        for there in ["https://id.example", "http://127.0.0.1.example/", "http://localhost.example", "", "127.0.0.1"] {
            assert!(!is_here(there), "{there}");
        }
    }
}
