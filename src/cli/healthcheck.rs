//! `flankfit healthcheck`: for containers without a shell or curl.

use std::{net::SocketAddr, time::Duration};

use clap::Args;

use super::CommandError;
use crate::config::parse_address;

#[derive(Debug, Args)]
pub struct HealthcheckArguments {
    /// The address that the server listens on.
    #[arg(long, env = "FLANKFIT_BIND", default_value = "127.0.0.1:8080", value_parser = parse_address)]
    bind: SocketAddr,
    /// Seconds to wait for the answer.
    #[arg(long, default_value_t = 3)]
    timeout: u64,
}

pub fn run(arguments: &HealthcheckArguments) -> Result<(), CommandError> {
    let mut address = arguments.bind;
    // A server that listens everywhere is asked at home.
    if address.ip().is_unspecified() {
        address.set_ip(if address.is_ipv4() {
            std::net::Ipv4Addr::LOCALHOST.into()
        } else {
            std::net::Ipv6Addr::LOCALHOST.into()
        });
    }
    let agent: ureq::Agent = ureq::Agent::config_builder()
        .timeout_global(Some(Duration::from_secs(arguments.timeout)))
        .proxy(None)
        .build()
        .into();
    match agent.get(format!("http://{address}/healthz")).call() {
        Ok(_) => Ok(()),
        Err(ureq::Error::StatusCode(status)) => Err(format!(
            "the server at {address} answers with status {status}: see \
            its log"
        )
        .into()),
        Err(error) => Err(format!(
            "no server answers at {address} ({error}): start it with `flankfit serve`, or name its address with --bind \
             or FLANKFIT_BIND"
        )
        .into()),
    }
}
