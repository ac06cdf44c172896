//! Settings of the audit's seals.

use std::path::PathBuf;

use clap::Args;

#[derive(Clone, Debug, PartialEq, Eq, Args)]
pub struct AuditSettings {
    /// File (PEM, PKCS#8) with the Ed25519 key that signs seals of the audit.
    #[arg(long, env = "FLANKFIT_AUDIT_SIGNING_KEY")]
    pub audit_signing_key: Option<PathBuf>,
    /// File to which seals of the audit are appended, one JSON object per line; keep it where no
    /// administrator of the database can change it.
    #[arg(long, env = "FLANKFIT_AUDIT_SEAL_FILE")]
    pub audit_seal_file: Option<PathBuf>,
    /// Seconds between seals of the audit.
    #[arg(long, env = "FLANKFIT_AUDIT_SEAL_SECONDS", default_value_t = 10,
        value_parser = clap::value_parser!(u32).range(1..=3600))]
    pub audit_seal_seconds: u32,
}
