//! Where certificate and key of the server are, and what is asked of clients.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Whether clients show a certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ClientAuthentication {
    /// None is asked for.
    #[default]
    Off,
    /// One that is shown must be good.
    Optional,
    /// Only clients with a good one are served.
    Required,
}

/// Files are read again when they change.
#[derive(Clone, Debug, Default, PartialEq, Eq, Args)]
pub struct TlsSettings {
    /// File with the certificate of this server (PEM), those that lead to its issuer behind it.
    /// With it the server speaks TLS 1.2 and 1.3 alone.
    #[arg(long = "tls-cert", env = "FLANKFIT_TLS_CERT", requires = "key")]
    pub certificate: Option<PathBuf>,
    /// File with the private key of the certificate (PEM).
    #[arg(long = "tls-key", env = "FLANKFIT_TLS_KEY", requires = "certificate")]
    pub key: Option<PathBuf>,
    /// File with the certificates of the authorities (PEM) that clients' certificates must come
    /// from.
    #[arg(long = "tls-client-ca", env = "FLANKFIT_TLS_CLIENT_CA", requires = "certificate")]
    pub client_authorities: Option<PathBuf>,
    /// Whether clients show a certificate.
    #[arg(
        long = "tls-client-auth",
        env = "FLANKFIT_TLS_CLIENT_AUTH",
        value_enum,
        default_value_t = ClientAuthentication::Off
    )]
    pub client_authentication: ClientAuthentication,
}
