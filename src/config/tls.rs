//! Paths of the server's certificate and key, and the policy for client certificates.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// Policy for clients' certificates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ClientAuthentication {
    /// No certificate is requested.
    #[default]
    Off,
    /// A certificate is optional, but must be valid.
    Optional,
    /// A valid certificate is required.
    Required,
}

/// Files are read again when they change.
#[derive(Clone, Debug, Default, PartialEq, Eq, Args)]
pub struct TlsSettings {
    /// File (PEM) with the certificate of this server, followed by the intermediate certificates.
    /// It enables TLS 1.2 and 1.3, and disables plain HTTP.
    #[arg(long = "tls-cert", env = "FLANKFIT_TLS_CERT", requires = "key")]
    pub certificate: Option<PathBuf>,
    /// File with the private key of the certificate (PEM).
    #[arg(long = "tls-key", env = "FLANKFIT_TLS_KEY", requires = "certificate")]
    pub key: Option<PathBuf>,
    /// File (PEM) with the certificate authorities of clients.
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
