//! `flankfit healthcheck`: for containers without a shell or curl.

use std::{net::SocketAddr, path::PathBuf, sync::Arc, time::Duration};

use clap::Args;
use tokio_rustls::rustls::crypto::aws_lc_rs::default_provider;
use ureq::tls::{TlsConfig, TlsProvider};

use super::{CommandError, reachable};
use crate::config::parse_address;

#[derive(Debug, Args)]
pub struct HealthcheckArguments {
    /// Address of the server.
    #[arg(long, env = "FLANKFIT_BIND", default_value = "127.0.0.1:8080", value_parser = parse_address)]
    bind: SocketAddr,
    /// Address of its second listener (--ops-bind), which is then checked instead.
    #[arg(long, env = "FLANKFIT_OPS_BIND", value_parser = parse_address)]
    ops_bind: Option<SocketAddr>,
    /// Certificate of the server; with it the check uses TLS. The certificate itself is not
    /// verified.
    #[arg(long, env = "FLANKFIT_TLS_CERT")]
    tls_cert: Option<PathBuf>,
    /// Seconds to wait for the answer.
    #[arg(long, default_value_t = 3)]
    timeout: u64,
}

pub fn run(arguments: &HealthcheckArguments) -> Result<(), CommandError> {
    let address = reachable(arguments.ops_bind.unwrap_or(arguments.bind));
    let tls = arguments.tls_cert.is_some() && arguments.ops_bind.is_none();
    let agent: ureq::Agent = ureq::Agent::config_builder()
        .timeout_global(Some(Duration::from_secs(arguments.timeout)))
        .proxy(None)
        .tls_config(
            TlsConfig::builder()
                .provider(TlsProvider::Rustls)
                .unversioned_rustls_crypto_provider(Arc::new(default_provider()))
                .disable_verification(true)
                .build(),
        )
        .build()
        .into();
    let scheme = if tls { "https" } else { "http" };
    match agent.get(format!("{scheme}://{address}/healthz")).call() {
        Ok(_) => Ok(()),
        Err(ureq::Error::StatusCode(status)) => Err(format!(
            "the server at {address} answers with status {status}: see \
            its log"
        )
        .into()),
        Err(error) if tls => Err(format!(
            "no server answers at {address} by TLS ({error}): start it with `flankfit serve`; where it asks clients for \
             certificates, give it a listener for operation with --ops-bind"
        )
        .into()),
        Err(error) => Err(format!(
            "no server answers at {address} ({error}): start it with `flankfit serve`, or name its address with --bind \
             or FLANKFIT_BIND"
        )
        .into()),
    }
}
