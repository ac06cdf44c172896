//! Seals of the audit, made now and then for as long as the server runs: logged, and appended to a
//! file.

use std::{
    fs::{File, OpenOptions},
    io::{self, Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use jiff::SignedDuration;
use tokio_rustls::rustls::pki_types::{PrivatePkcs8KeyDer, pem::PemObject};

use super::seal_age::SealAge;
use crate::{
    api::jobs::{audit::SealBody, seals::line},
    config::AuditSettings,
    jobs::{
        JobService,
        audit::{SigningKey, WholeSeal},
    },
    telemetry,
};

/// Longest time between two times that the age is told.
const TELL: Duration = Duration::from_secs(5);

/// Why seals cannot be made as they are wanted.
#[derive(Debug, thiserror::Error)]
pub enum SealError {
    #[error("{file} holds no private key in PEM form (`-----BEGIN PRIVATE KEY-----`) that can be read: {reason}")]
    NoKey { file: PathBuf, reason: String },
    #[error("the key in {file} is none of Ed25519; make one with `openssl genpkey -algorithm ed25519`")]
    OtherKey { file: PathBuf },
    #[error("seals cannot be appended to {file}: {source}")]
    File { file: PathBuf, source: io::Error },
}

/// Makes seals.
pub struct SealKeeper {
    key: Option<Arc<SigningKey>>,
    file: Option<PathBuf>,
    every: Duration,
    age: Mutex<SealAge>,
}

impl SealKeeper {
    /// Reads the key, and makes the file if it is not there.
    pub fn load(settings: &AuditSettings) -> Result<Self, SealError> {
        let key = settings.audit_signing_key.as_deref().map(signing_key).transpose()?;
        let file = settings.audit_seal_file.clone();
        if let Some(file) = &file {
            open(file).map_err(|source| SealError::File { file: file.clone(), source })?;
        }
        let every = Duration::from_secs(settings.audit_seal_seconds.into());
        Ok(SealKeeper { key: key.map(Arc::new), file, every, age: Mutex::new(SealAge::begin(Instant::now())) })
    }

    /// Never ends.
    pub async fn run(&self, service: &JobService) {
        tokio::join!(self.seal(service), self.tell_age());
    }

    async fn seal(&self, service: &JobService) {
        // those of servers that share a database come a little sooner or later
        let unless_within = SignedDuration::try_from(self.every * 9 / 10).unwrap_or_default();
        let mut unwritten = String::new();
        loop {
            tokio::time::sleep(self.every).await;
            self.age().turn();
            let sealed = match service.seal_audit(self.key.clone(), unless_within).await {
                Ok(made) => {
                    made.iter().flatten().for_each(log);
                    unwritten.extend(made.iter().flatten().map(line));
                    if !unwritten.is_empty() {
                        self.age().made();
                    }
                    true
                }
                Err(error) => {
                    tracing::warn!(%error, "the audit could not be sealed");
                    false
                }
            };
            if self.write(&mut unwritten).await {
                self.age().written();
            }
            if sealed {
                self.look(service).await;
            }
        }
    }

    /// Finds out what is in no seal yet.
    async fn look(&self, service: &JobService) {
        let begun = Instant::now();
        match service.unsealed().await {
            Ok(told) => self.age().looked(told, begun),
            Err(error) => tracing::warn!(%error, "it is not known whether all of the audit is sealed"),
        }
    }

    /// Appends what is not written yet; whether all is. What cannot be written is tried again with
    /// the next seals.
    async fn write(&self, unwritten: &mut String) -> bool {
        let Some(file) = self.file.clone().filter(|_| !unwritten.is_empty()) else {
            unwritten.clear();
            return true;
        };
        let lines = unwritten.clone();
        let writing = tokio::task::spawn_blocking(move || append(&file, &lines)).await;
        match writing.unwrap_or_else(|lost| Err(io::Error::other(lost))) {
            Ok(()) => unwritten.clear(),
            Err(error) => tracing::error!(%error, "seals of the audit could not be appended to their file"),
        }
        unwritten.is_empty()
    }

    async fn tell_age(&self) {
        telemetry::record_seal_interval(self.every);
        loop {
            telemetry::record_seal_age(self.age().at(Instant::now()));
            tokio::time::sleep(TELL.min(self.every)).await;
        }
    }

    fn age(&self) -> MutexGuard<'_, SealAge> {
        self.age.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn signing_key(file: &Path) -> Result<SigningKey, SealError> {
    let document = PrivatePkcs8KeyDer::from_pem_file(file)
        .map_err(|error| SealError::NoKey { file: file.to_owned(), reason: error.to_string() })?;
    SigningKey::from_pkcs8(document.secret_pkcs8_der()).ok_or_else(|| SealError::OtherKey { file: file.to_owned() })
}

fn log(made: &WholeSeal) {
    let SealBody { tenant, number, heads, root, sha256, signature, .. } = SealBody::from(&made.seal);
    let signature = signature.unwrap_or_default();
    tracing::info!(tenant, number, heads, root, sha256, signature, "the audit is sealed");
}

/// A new file can be read by its owner alone.
fn open(file: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).append(true).create(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(file)
}

/// Appends lines and syncs them. A line that was cut off before stays one of its own.
fn append(file: &Path, lines: &str) -> io::Result<()> {
    let mut file = open(file)?;
    let mut last = [b'\n'];
    if file.seek(SeekFrom::End(0))? > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    let gap = if last == [b'\n'] { "" } else { "\n" };
    file.write_all(format!("{gap}{lines}").as_bytes())?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_was_cut_off_spoils_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("seals");
        append(&file, "one\n").unwrap();
        append(&file, "tw").unwrap();
        append(&file, "three\nfour\n").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "one\ntw\nthree\nfour\n");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        }
    }

    #[test]
    fn keys_that_sign_no_seals_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("key.pem");
        let load = || SealKeeper::load(&AuditSettings { audit_signing_key: Some(file.clone()), ..Default::default() });
        let refusal = || load().err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refusal().contains("key.pem holds no private key"), "{}", refusal());
        let ecdsa = rcgen::KeyPair::generate_for(&rcgen::PKCS_ECDSA_P256_SHA256).unwrap();
        std::fs::write(&file, ecdsa.serialize_pem()).unwrap();
        assert!(refusal().contains("openssl genpkey -algorithm ed25519"), "{}", refusal());
        let ed25519 = rcgen::KeyPair::generate_for(&rcgen::PKCS_ED25519).unwrap();
        std::fs::write(&file, ed25519.serialize_pem()).unwrap();
        assert_eq!(refusal(), "");
    }
}
