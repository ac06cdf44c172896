//! Seals of the audit, made now and then for as long as the server runs: logged, and appended to a
//! file.

use std::{
    fs::{File, OpenOptions},
    io::{self, Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use tokio_rustls::rustls::pki_types::{PrivatePkcs8KeyDer, pem::PemObject};

use crate::{
    api::jobs::{audit::SealBody, seals::line},
    config::{AuditSettings, StartError},
    jobs::{
        JobService,
        audit::{Seal, SigningKey},
    },
    telemetry,
};

/// Longest time between two reports of the age.
const TELL: Duration = Duration::from_secs(5);

/// Time until the next turn if another process is sealing.
const BUSY: Duration = Duration::from_secs(1);

/// Bytes of seals in memory, above which no more are made until their file can be written.
const MOST_UNWRITTEN: usize = 1 << 20;

/// Makes seals.
pub struct SealKeeper {
    key: Option<Arc<SigningKey>>,
    file: Option<PathBuf>,
    every: Duration,
    /// Begin of the last turn that sealed all entries and wrote all seals.
    sealed: Mutex<Instant>,
}

impl SealKeeper {
    /// Reads the key, and makes the file if it is not there.
    pub fn load(settings: &AuditSettings) -> Result<Self, StartError> {
        let key = settings.audit_signing_key.as_deref().map(signing_key).transpose()?;
        let file = settings.audit_seal_file.clone();
        if let Some(file) = &file {
            open(file).map_err(|source| format!("seals cannot be appended to {}: {source}", file.display()))?;
        }
        let every = Duration::from_secs(settings.audit_seal_seconds.into());
        Ok(SealKeeper { key: key.map(Arc::new), file, every, sealed: Mutex::new(Instant::now()) })
    }

    /// Never ends.
    pub async fn run(&self, service: &JobService) {
        tokio::join!(self.seal(service), self.report_age());
    }

    async fn seal(&self, service: &JobService) {
        let (mut unwritten, mut pause) = (String::new(), self.every);
        loop {
            tokio::time::sleep(pause).await;
            pause = self.turn(service, &mut unwritten).await;
        }
    }

    /// Seals the entries that wait, and writes the seals; returns the time until the next turn.
    async fn turn(&self, service: &JobService, unwritten: &mut String) -> Duration {
        let begun = Instant::now();
        if unwritten.len() > MOST_UNWRITTEN && !self.write(unwritten).await {
            return self.every;
        }
        let sealed = match service.seal_audit(self.key.clone()).await {
            Ok(Some(sealed)) => sealed,
            Ok(None) => return BUSY.min(self.every),
            Err(error) => {
                tracing::warn!(%error, "the audit could not be sealed");
                return self.every;
            }
        };
        for reason in &sealed.failed {
            tracing::error!(reason, "a part of the audit is not sealed");
        }
        for seal in &sealed.seals {
            log(seal);
            unwritten.push_str(&line(seal));
        }
        let is_written = self.write(unwritten).await;
        if sealed.more {
            return Duration::ZERO;
        }
        if is_written && sealed.failed.is_empty() {
            *self.sealed() = begun;
        }
        self.every
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

    async fn report_age(&self) {
        metrics::gauge!(telemetry::AUDIT_SEAL_INTERVAL).set(self.every.as_secs_f64());
        loop {
            metrics::gauge!(telemetry::AUDIT_SEAL_AGE).set(self.sealed().elapsed().as_secs_f64());
            tokio::time::sleep(TELL.min(self.every)).await;
        }
    }

    fn sealed(&self) -> MutexGuard<'_, Instant> {
        self.sealed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

const PEM: &str = "-----BEGIN PRIVATE KEY-----";

fn signing_key(file: &Path) -> Result<SigningKey, StartError> {
    let document = PrivatePkcs8KeyDer::from_pem_file(file).map_err(|error| {
        format!("{} holds no private key in PEM form (`{PEM}`) that can be read: {error}", file.display())
    })?;
    SigningKey::from_pkcs8(document.secret_pkcs8_der()).ok_or_else(|| {
        let file = file.display();
        format!("the key in {file} is none of Ed25519; make one with `openssl genpkey -algorithm ed25519`").into()
    })
}

fn log(seal: &Seal) {
    let SealBody { tenant, number, last_entry, sha256, signature, .. } = SealBody::from(seal);
    let signature = signature.unwrap_or_default();
    tracing::info!(tenant, number, last_entry, sha256, signature, "the audit is sealed");
}

/// A new file can be read by its owner alone.
fn open(file: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).append(true).create(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(file)
}

/// Appends lines and syncs them, in place of a line that was cut off before.
fn append(file: &Path, lines: &str) -> io::Result<()> {
    let mut file = open(file)?;
    let (mut end, mut last) = (file.seek(SeekFrom::End(0))?, [0]);
    let whole = end;
    while end > 0 {
        file.seek(SeekFrom::Start(end - 1))?;
        file.read_exact(&mut last)?;
        if last == [b'\n'] {
            break;
        }
        end -= 1;
    }
    if end < whole {
        file.set_len(end)?;
    }
    file.write_all(lines.as_bytes())?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        jobs::{Caller, JobDraft, OrderedIds, SystemClock, Upkeep as _},
        store::{StoreSettings, open_sqlite},
    };

    #[test]
    fn a_line_that_was_cut_off_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("seals");
        append(&file, "one\n").unwrap();
        append(&file, "tw").unwrap();
        append(&file, "three\nfour\n").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "one\nthree\nfour\n");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600);
        }
    }

    /// They wait in the database instead, and are sealed afterwards.
    #[tokio::test]
    async fn no_seals_are_made_while_many_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let settings = StoreSettings::of_file(folder.path().join("jobs.db"));
        let store = Arc::new(open_sqlite(settings, Arc::new(SystemClock)).await.unwrap());
        let service = JobService::new(store.clone(), Arc::new(SystemClock), Arc::new(OrderedIds::new()));
        let jobs = service.of(&Caller::anonymous());
        jobs.create_job(JobDraft { name: "wheel".to_owned(), ..JobDraft::default() }, None).await.unwrap();
        let file = folder.path().join("gone/seals");
        let (every, sealed) = (Duration::from_secs(10), Mutex::new(Instant::now()));
        let keeper = SealKeeper { key: None, file: Some(file.clone()), every, sealed };
        let mut unwritten = "x\n".repeat(MOST_UNWRITTEN);
        assert_eq!(keeper.turn(&service, &mut unwritten).await, every);
        assert_eq!(unwritten.len(), 2 * MOST_UNWRITTEN);
        std::fs::create_dir(file.parent().unwrap()).unwrap();
        keeper.turn(&service, &mut unwritten).await;
        assert_eq!(unwritten, "");
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(text.matches("\"number\":1,").count(), 1);
        store.close().await;
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
