//! TLS 1.2 and 1.3, with certificate and key from files that are read again when they change.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Arc, PoisonError, RwLock},
    time::Duration,
};

use sha2::{Digest, Sha256};
use tokio::{net::TcpStream, time::timeout};
use tokio_rustls::{
    TlsAcceptor,
    rustls::{
        self, RootCertStore, ServerConfig,
        crypto::aws_lc_rs::default_provider,
        pki_types::{CertificateDer, PrivateKeyDer, pem::PemObject},
        server::{VerifierBuilderError, WebPkiClientVerifier},
    },
    server::TlsStream,
};
use x509_parser::{certificate::X509Certificate, extensions::GeneralName, prelude::FromDer};

use super::peer::PeerNames;
use crate::{
    config::{ClientAuthentication, TlsSettings},
    jobs::{Clock, San},
    telemetry,
};

/// How long a client may take to agree on keys.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// Time between two looks at the files.
const LOOK: Duration = Duration::from_secs(5);

/// Why the files cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    #[error("cannot read {file}: {source}")]
    Read { file: PathBuf, source: io::Error },
    #[error("{file} holds no certificate in PEM form (`-----BEGIN CERTIFICATE-----`)")]
    NoCertificate { file: PathBuf },
    #[error("{file} holds no private key in PEM form (`-----BEGIN PRIVATE KEY-----`)")]
    NoKey { file: PathBuf },
    #[error("the certificate in {certificate} and the key in {key} cannot be used: {source}")]
    Unfit { certificate: PathBuf, key: PathBuf, source: rustls::Error },
    #[error("the authorities in {file} cannot be used: {source}")]
    Authorities { file: PathBuf, source: VerifierBuilderError },
    #[error(
        "--tls-client-auth asks clients for certificates: name the file with their authorities with --tls-client-ca"
    )]
    NoAuthorities,
    #[error("clients are to show certificates, which takes TLS: name the server's own with --tls-cert and --tls-key")]
    NoTls,
    #[error("--tls-client-ca is given, but clients are asked for no certificate: add --tls-client-auth required")]
    AuthoritiesUnused,
}

/// The keys of a listener.
pub struct Tls {
    settings: TlsSettings,
    clock: Arc<dyn Clock>,
    current: RwLock<Loaded>,
}

/// Contents of the files.
struct Loaded {
    acceptor: TlsAcceptor,
    digest: [u8; 32],
    /// When the certificate ends, in seconds since 1970.
    ends: i64,
}

impl Tls {
    /// Reads the files; `None` where none are named.
    pub fn load(settings: &TlsSettings, clock: Arc<dyn Clock>) -> Result<Option<Arc<Self>>, TlsError> {
        let Some(files) = Files::read(settings)? else { return Ok(None) };
        let current = RwLock::new(files.load(settings)?);
        Ok(Some(Arc::new(Tls { settings: settings.clone(), clock, current })))
    }

    /// Agrees on keys with a client, which may take ten seconds.
    pub async fn accept(&self, stream: TcpStream) -> io::Result<TlsStream<TcpStream>> {
        let acceptor = self.current.read().unwrap_or_else(PoisonError::into_inner).acceptor.clone();
        match timeout(HANDSHAKE, acceptor.accept(stream)).await {
            Ok(accepted) => accepted,
            Err(_elapsed) => Err(io::Error::new(io::ErrorKind::TimedOut, "no TLS handshake")),
        }
    }

    /// Takes what changes in the files for connections from then on. Never ends.
    pub async fn follow(&self) {
        self.record_expiry();
        let mut clock = tokio::time::interval(LOOK);
        clock.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        // the first tick is at once
        clock.tick().await;
        loop {
            clock.tick().await;
            match self.reload() {
                Ok(true) => tracing::info!("the certificate was read again"),
                Ok(false) => {}
                Err(error) => {
                    tracing::warn!(%error, "the changed certificate is not used, the one before goes on");
                }
            }
            self.record_expiry();
        }
    }

    /// Whether the files had changed.
    fn reload(&self) -> Result<bool, TlsError> {
        let Some(files) = Files::read(&self.settings)? else { return Ok(false) };
        if files.digest() == self.current.read().unwrap_or_else(PoisonError::into_inner).digest {
            return Ok(false);
        }
        let loaded = files.load(&self.settings)?;
        *self.current.write().unwrap_or_else(PoisonError::into_inner) = loaded;
        Ok(true)
    }

    fn record_expiry(&self) {
        let ends = self.current.read().unwrap_or_else(PoisonError::into_inner).ends;
        metrics::gauge!(telemetry::TLS_EXPIRY).set((ends - self.clock.now().as_second()) as f64);
    }
}

/// The names in the certificate that a client has shown, hosts and URIs in their order.
pub fn names_of(stream: &TlsStream<TcpStream>) -> Option<PeerNames> {
    let shown = stream.get_ref().1.peer_certificates()?.first()?;
    let (_, certificate) = X509Certificate::from_der(shown).ok()?;
    let names = certificate.subject_alternative_name().ok().flatten()?;
    let names = names.value.general_names.iter().filter_map(|name| match name {
        GeneralName::DNSName(name) | GeneralName::URI(name) => San::named(name),
        _ => None,
    });
    Some(PeerNames(names.collect()))
}

/// The texts of the files.
struct Files<'a> {
    certificate: (&'a Path, Vec<u8>),
    key: (&'a Path, Vec<u8>),
    authorities: Option<(&'a Path, Vec<u8>)>,
}

impl<'a> Files<'a> {
    fn read(settings: &'a TlsSettings) -> Result<Option<Self>, TlsError> {
        let read = |file: &'a Path| match fs::read(file) {
            Ok(text) => Ok((file, text)),
            Err(source) => Err(TlsError::Read { file: file.into(), source }),
        };
        let authorities = settings.client_authorities.as_deref();
        let (Some(certificate), Some(key)) = (&settings.certificate, &settings.key) else {
            // who asks for certificates of clients does not want to serve everybody plainly
            return match (authorities, settings.client_authentication) {
                (None, ClientAuthentication::Off) => Ok(None),
                _ => Err(TlsError::NoTls),
            };
        };
        match (authorities, settings.client_authentication) {
            (Some(_), ClientAuthentication::Off) => return Err(TlsError::AuthoritiesUnused),
            (None, ClientAuthentication::Optional | ClientAuthentication::Required) => {
                return Err(TlsError::NoAuthorities);
            }
            _ => {}
        }
        let authorities = authorities.map(read).transpose()?;
        Ok(Some(Files { certificate: read(certificate)?, key: read(key)?, authorities }))
    }

    fn digest(&self) -> [u8; 32] {
        let mut digest = Sha256::new();
        for (_, text) in [&self.certificate, &self.key].into_iter().chain(&self.authorities) {
            digest.update(text.len().to_le_bytes());
            digest.update(text);
        }
        digest.finalize().into()
    }

    fn load(&self, settings: &TlsSettings) -> Result<Loaded, TlsError> {
        let chain = certificates(self.certificate.0, &self.certificate.1)?;
        let key = PrivateKeyDer::from_pem_slice(&self.key.1);
        let key = key.map_err(|_| TlsError::NoKey { file: self.key.0.into() })?;
        let unfit = |source| TlsError::Unfit { certificate: self.certificate.0.into(), key: self.key.0.into(), source };
        let ends = chain.first().and_then(|first| X509Certificate::from_der(first).ok());
        let ends = ends.map_or(0, |(_, certificate)| certificate.validity().not_after.timestamp());

        let provider = Arc::new(default_provider());
        let builder = ServerConfig::builder_with_provider(Arc::clone(&provider));
        let builder = builder.with_safe_default_protocol_versions().map_err(unfit)?;
        let builder = match &self.authorities {
            None => builder.with_no_client_auth(),
            Some((file, text)) => {
                let mut roots = RootCertStore::empty();
                roots.add_parsable_certificates(certificates(file, text)?);
                let mut verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider);
                if settings.client_authentication == ClientAuthentication::Optional {
                    verifier = verifier.allow_unauthenticated();
                }
                let verifier = verifier.build();
                builder.with_client_cert_verifier(
                    verifier.map_err(|source| TlsError::Authorities { file: (*file).into(), source })?,
                )
            }
        };
        let mut config = builder.with_single_cert(chain, key).map_err(unfit)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Loaded { acceptor: TlsAcceptor::from(Arc::new(config)), digest: self.digest(), ends })
    }
}

fn certificates(file: &Path, text: &[u8]) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let all: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text).collect();
    all.ok().filter(|all| !all.is_empty()).ok_or_else(|| TlsError::NoCertificate { file: file.into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::SystemClock;

    fn load(settings: &TlsSettings) -> Result<Option<Arc<Tls>>, TlsError> {
        Tls::load(settings, Arc::new(SystemClock))
    }

    struct Written {
        directory: tempfile::TempDir,
        settings: TlsSettings,
    }

    fn pair() -> (String, String) {
        let made = rcgen::generate_simple_self_signed(["cell.example".to_owned()]).unwrap();
        (made.cert.pem(), made.signing_key.serialize_pem())
    }

    impl Written {
        fn new((certificate, key): (String, String)) -> Self {
            let directory = tempfile::tempdir().unwrap();
            let file = |name: &str| Some(directory.path().join(name));
            let settings =
                TlsSettings { certificate: file("cert.pem"), key: file("key.pem"), ..TlsSettings::default() };
            let written = Written { directory, settings };
            written.write("cert.pem", &certificate);
            written.write("key.pem", &key);
            written
        }

        fn write(&self, name: &str, text: &str) {
            fs::write(self.directory.path().join(name), text).unwrap();
        }

        fn refused(&self) -> String {
            load(&self.settings).err().unwrap().to_string()
        }
    }

    #[test]
    fn a_key_pair_is_loaded_and_absent_settings_mean_no_tls() {
        assert!(load(&TlsSettings::default()).unwrap().is_none());
        let tls = load(&Written::new(pair()).settings).unwrap().unwrap();
        assert!(tls.current.read().unwrap().ends > 1_700_000_000);
    }

    #[test]
    fn unusable_certificates_and_keys_are_named() {
        let written = Written::new(pair());
        written.write("key.pem", &pair().1);
        assert!(written.refused().contains("cannot be used"), "{}", written.refused());
        written.write("key.pem", "nothing");
        assert!(written.refused().ends_with("(`-----BEGIN PRIVATE KEY-----`)"));
        written.write("cert.pem", "nothing");
        assert!(written.refused().contains("holds no certificate"));
        fs::remove_file(written.directory.path().join("cert.pem")).unwrap();
        assert!(written.refused().contains("cannot read"));
    }

    #[test]
    fn client_certificates_need_authorities() {
        let mut written = Written::new(pair());
        written.settings.client_authentication = ClientAuthentication::Required;
        assert!(written.refused().contains("--tls-client-ca"));
        written.settings.client_authorities = written.settings.certificate.clone();
        assert!(load(&written.settings).is_ok());
        written.settings.client_authentication = ClientAuthentication::Off;
        assert!(written.refused().contains("--tls-client-auth required"));
    }

    #[test]
    fn client_certificates_need_tls() {
        for client_authentication in [ClientAuthentication::Optional, ClientAuthentication::Required] {
            let settings = TlsSettings { client_authentication, ..TlsSettings::default() };
            let refused = load(&settings).err().unwrap().to_string();
            assert!(refused.contains("--tls-cert"), "{client_authentication:?}: {refused}");
        }
        let settings = TlsSettings { client_authorities: Some("ca.pem".into()), ..TlsSettings::default() };
        assert!(load(&settings).err().unwrap().to_string().contains("--tls-cert"));
    }

    #[test]
    fn files_are_read_again_when_they_change_and_fit() {
        let written = Written::new(pair());
        let tls = load(&written.settings).unwrap().unwrap();
        assert!(!tls.reload().unwrap());
        let (certificate, key) = pair();
        written.write("cert.pem", &certificate);
        assert!(tls.reload().is_err(), "half of the pair");
        written.write("key.pem", &key);
        assert!(tls.reload().unwrap());
        assert!(!tls.reload().unwrap());
    }
}
