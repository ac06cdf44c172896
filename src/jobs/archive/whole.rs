//! The archive of one job: a file of one section, the same bytes for as long as nothing changes.

use std::{
    io::{self, Write},
    sync::{Arc, Weak},
};

use sha2::{Digest as _, Sha256};
use tokio::runtime::Handle;

use super::{
    Holdings,
    carry::export_seen,
    error::ArchiveError,
    file::ArchiveWriter,
    row::{Row, Value},
    section::Key,
};
use crate::jobs::purge::Seen;

/// Takes notice of a row.
fn see(seen: &mut Seen, row: &Row) {
    match (row.table().name, row.value("number"), row.value("sha256")) {
        ("event", Some(Value::Integer(number)), _) => seen.last_event = number.unsigned_abs(),
        ("audit", _, Some(Value::Bytes(sha256))) => seen.head = sha256.as_slice().try_into().ok(),
        _ => {}
    }
}

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Archived {
    /// SHA-256 of the file.
    pub sha256: [u8; 32],
    pub bytes: u64,
    pub seen: Seen,
}

/// Digests what is written, for as long as somebody waits for it.
struct Digesting<W> {
    to: W,
    digest: Sha256,
    bytes: u64,
    wanted: Weak<()>,
}

impl<W: Write> Write for Digesting<W> {
    fn write(&mut self, piece: &[u8]) -> io::Result<usize> {
        if self.wanted.strong_count() == 0 {
            return Err(io::Error::other("the client has disconnected"));
        }
        let written = self.to.write(piece)?;
        self.digest.update(&piece[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// Writes the archive of a job, on a thread that may wait for a disk, and stops when nobody waits
/// for it any more. None of a job that there is not and never was.
pub async fn archive<W: Write + Send + 'static>(
    of: Arc<dyn Holdings>,
    key: Key,
    to: W,
) -> Result<Option<(W, Archived)>, ArchiveError> {
    let waiting = Arc::new(());
    let wanted = Arc::downgrade(&waiting);
    let runtime = Handle::current();
    let writing = tokio::task::spawn_blocking(move || {
        runtime.block_on(async {
            let digesting = Digesting { to, digest: Sha256::new(), bytes: 0, wanted };
            let mut file = ArchiveWriter::begin(digesting)?;
            let mut seen = Seen::default();
            if !export_seen(&*of, &key, &mut file, |row| see(&mut seen, row)).await? {
                return Ok(None);
            }
            let Digesting { to, digest, bytes, .. } = file.finish()?;
            Ok(Some((to, Archived { sha256: digest.finalize().into(), bytes, seen })))
        })
    });
    let written = writing.await.unwrap_or_else(|lost| Err(io::Error::other(lost).into()));
    drop(waiting);
    written
}
