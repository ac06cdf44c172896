//! TLS 1.2 and 1.3, with certificate and key from files that are read again when they change.

use std::{
    fs, io,
    path::Path,
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
        server::WebPkiClientVerifier,
    },
    server::TlsStream,
};
use x509_parser::{certificate::X509Certificate, extensions::GeneralName, prelude::FromDer};

use super::peer::PeerNames;
use crate::{
    config::{ClientAuthentication, StartError, TlsSettings},
    jobs::{Clock, San},
    telemetry,
};

/// How long a client may take to agree on keys.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// Time between two looks at the files.
const LOOK: Duration = Duration::from_secs(5);

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
    pub fn load(settings: &TlsSettings, clock: Arc<dyn Clock>) -> Result<Option<Arc<Self>>, StartError> {
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
    fn reload(&self) -> Result<bool, StartError> {
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
    fn read(settings: &'a TlsSettings) -> Result<Option<Self>, StartError> {
        let read = |file: &'a Path| match fs::read(file) {
            Ok(text) => Ok((file, text)),
            Err(error) => Err(format!("cannot read {}: {error}", file.display())),
        };
        let authorities = settings.client_authorities.as_deref();
        let (Some(certificate), Some(key)) = (&settings.certificate, &settings.key) else {
            // who asks for certificates of clients does not want to serve everybody plainly
            return match (authorities, settings.client_authentication) {
                (None, ClientAuthentication::Off) => Ok(None),
                _ => Err("clients are to show certificates, which takes TLS: name the server's own with --tls-cert and --tls-key".into()),
            };
        };
        match (authorities, settings.client_authentication) {
            (Some(_), ClientAuthentication::Off) => return Err(
                "--tls-client-ca is given, but clients are asked for no certificate: add --tls-client-auth required"
                    .into(),
            ),
            (None, ClientAuthentication::Optional | ClientAuthentication::Required) => {
                return Err(
                    "--tls-client-auth asks clients for certificates: name the file with their authorities with \
                            --tls-client-ca"
                        .into(),
                );
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

    fn load(&self, settings: &TlsSettings) -> Result<Loaded, StartError> {
        let chain = certificates(self.certificate.0, &self.certificate.1)?;
        let key = PrivateKeyDer::from_pem_slice(&self.key.1);
        let (certificate_file, key_file) = (self.certificate.0.display(), self.key.0.display());
        let key =
            key.map_err(|_| format!("{key_file} holds no private key in PEM form (`-----BEGIN PRIVATE KEY-----`)"))?;
        let unfit = |error: rustls::Error| {
            format!("the certificate in {certificate_file} and the key in {key_file} cannot be used: {error}")
        };
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
                let unfit = |error| format!("the authorities in {} cannot be used: {error}", file.display());
                builder.with_client_cert_verifier(verifier.build().map_err(unfit)?)
            }
        };
        let mut config = builder.with_single_cert(chain, key).map_err(unfit)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Loaded { acceptor: TlsAcceptor::from(Arc::new(config)), digest: self.digest(), ends })
    }
}

fn certificates(file: &Path, text: &[u8]) -> Result<Vec<CertificateDer<'static>>, StartError> {
    let all: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text).collect();
    all.ok().filter(|all| !all.is_empty()).ok_or_else(|| {
        format!("{} holds no certificate in PEM form (`-----BEGIN CERTIFICATE-----`)", file.display()).into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::SystemClock;

    fn load(settings: &TlsSettings) -> Result<Option<Arc<Tls>>, StartError> {
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
}
