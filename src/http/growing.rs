//! A file that is sent while it is still written.
//!
//! Who writes is never held up by a client: what was written waits in memory as long as it is
//! short, and then in a file without a name. Who reads follows at its own pace. Where writing ends
//! before its end, so does the answer: its connection breaks, and no reader takes it for whole.

use std::{
    fs::File,
    io::{self, Read as _, Seek as _, SeekFrom, Write},
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use axum::body::{Body, Bytes};
use futures_util::{StreamExt as _, stream};
use tokio::{sync::Notify, task::JoinHandle, time::timeout};

use super::chunked::PIECE;

/// More is not held in memory.
const IN_MEMORY: usize = 1 << 20;

/// What was written so far. Clones are of the same.
#[derive(Clone)]
pub struct Growing(Arc<Shared>);

struct Shared {
    /// Where the file is made.
    folder: PathBuf,
    state: Mutex<State>,
    more: Notify,
}

#[derive(Default)]
struct State {
    /// All of it, while it is short.
    memory: Vec<u8>,
    file: Option<File>,
    length: u64,
    /// How writing has ended.
    ended: Option<Result<(), String>>,
}

impl Growing {
    pub fn new(folder: PathBuf) -> Self {
        Growing(Arc::new(Shared { folder, state: Mutex::default(), more: Notify::new() }))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn end(&self, how: Result<(), String>) {
        self.lock().ended.get_or_insert(how);
        self.0.more.notify_waiters();
    }

    /// A piece from a place on, empty where nothing follows yet; waits for the disk.
    fn piece(&self, from: u64) -> io::Result<Vec<u8>> {
        let mut state = self.lock();
        let length = state.length.saturating_sub(from).min(PIECE as u64) as usize;
        let mut piece = vec![0; length];
        match &mut state.file {
            None => piece.copy_from_slice(&state.memory[from as usize..from as usize + length]),
            Some(file) => {
                file.seek(SeekFrom::Start(from))?;
                file.read_exact(&mut piece)?;
            }
        }
        Ok(piece)
    }

    /// Takes a piece; waits for the disk.
    fn take(&self, piece: &[u8]) -> io::Result<()> {
        let mut state = self.lock();
        if state.file.is_none() && state.memory.len() + piece.len() > IN_MEMORY {
            let mut file = tempfile::tempfile_in(&self.0.folder)?;
            file.write_all(&state.memory)?;
            state.memory = Vec::new();
            state.file = Some(file);
        }
        let end = state.length;
        match &mut state.file {
            None => state.memory.extend_from_slice(piece),
            Some(file) => {
                file.seek(SeekFrom::Start(end))?;
                file.write_all(piece)?;
            }
        }
        state.length += piece.len() as u64;
        Ok(())
    }

    /// All of it, where it is in memory.
    fn take_short(&self) -> Option<Vec<u8>> {
        let mut state = self.lock();
        state.file.is_none().then(|| std::mem::take(&mut state.memory))
    }

    /// What follows a place once it is there; nothing at the end.
    async fn next(&self, from: u64) -> io::Result<Option<Vec<u8>>> {
        loop {
            let told = self.0.more.notified();
            let ended = {
                let state = self.lock();
                if state.length > from { None } else { Some(state.ended.clone()) }
            };
            match ended {
                None => {
                    let own = self.clone();
                    let piece = tokio::task::spawn_blocking(move || own.piece(from)).await;
                    return piece.map_err(io::Error::other)?.map(Some);
                }
                Some(Some(Ok(()))) => return Ok(None),
                Some(Some(Err(why))) => return Err(io::Error::other(why)),
                Some(None) => told.await,
            }
        }
    }
}

impl Write for Growing {
    fn write(&mut self, piece: &[u8]) -> io::Result<usize> {
        // the file has no name, so its folder is told
        let told = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", self.0.folder.display()));
        self.take(piece).map_err(told)?;
        self.0.more.notify_waiters();
        Ok(piece.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Ends the writing when the reader is gone.
struct Writing<T>(JoinHandle<T>);

impl<T> Drop for Writing<T> {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// A body, with what its writing has come to; nothing of one that is still being written.
pub struct Sent<T> {
    pub body: Body,
    pub written: Option<T>,
}

/// Waits for what is written, for as long as that; after it the answer begins with what there is.
pub async fn send<T, E>(
    growing: Growing,
    write: impl Future<Output = Result<T, E>> + Send + 'static,
    patience: Duration,
) -> Result<Sent<T>, E>
where
    T: Send + 'static,
    E: std::fmt::Display + From<io::Error> + Send + 'static,
{
    let told = growing.clone();
    let mut writing = Writing(tokio::spawn(async move {
        let written = write.await;
        told.end(written.as_ref().map(|_| ()).map_err(ToString::to_string));
        written
    }));
    let written = match timeout(patience, &mut writing.0).await {
        Ok(Ok(written)) => Some(written?),
        Ok(Err(lost)) => return Err(io::Error::other(lost).into()),
        Err(_elapsed) => None,
    };
    if written.is_some()
        && let Some(bytes) = growing.take_short()
    {
        return Ok(Sent { body: Body::from(bytes), written });
    }
    let pieces = stream::try_unfold((growing, writing, 0), |(growing, writing, from)| async move {
        let broken = |error: &io::Error| tracing::warn!(%error, "an answer broke off before its end");
        let Some(piece) = growing.next(from).await.inspect_err(broken)? else { return Ok::<_, io::Error>(None) };
        let from = from + piece.len() as u64;
        Ok(Some((Bytes::from(piece), (growing, writing, from))))
    });
    Ok(Sent { body: Body::from_stream(pieces.fuse()), written })
}

#[cfg(test)]
mod tests {
    use axum::body::to_bytes;

    use super::*;

    const QUICK: Duration = Duration::from_secs(60);
    const AT_ONCE: Duration = Duration::from_millis(1);

    fn growing() -> (Growing, Growing) {
        let growing = Growing::new(std::env::temp_dir());
        (growing.clone(), growing)
    }

    fn noise(length: usize) -> Vec<u8> {
        (0..length as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
    }

    #[tokio::test]
    async fn what_is_written_in_time_is_sent_with_what_came_of_it() {
        for length in [0, 1000, IN_MEMORY, IN_MEMORY + 1, 3 * IN_MEMORY + 7] {
            let ((sent, mut to), bytes) = (growing(), noise(length));
            let expected = bytes.clone();
            let write = async move {
                bytes.chunks(100_000).try_for_each(|piece| to.write_all(piece))?;
                Ok::<_, io::Error>(bytes.len())
            };
            let Sent { body, written } = send(sent, write, QUICK).await.unwrap();
            assert_eq!(written, Some(length));
            assert_eq!(to_bytes(body, usize::MAX).await.unwrap(), expected, "{length}");
        }
    }

    #[tokio::test]
    async fn what_takes_longer_is_sent_as_it_is_written() {
        let ((sent, mut to), bytes) = (growing(), noise(2 * IN_MEMORY));
        let (pieces, mut coming) = tokio::sync::mpsc::channel::<Vec<u8>>(1);
        let write = async move {
            while let Some(piece) = coming.recv().await {
                to.write_all(&piece)?;
            }
            Ok::<_, io::Error>(())
        };
        let Sent { body, written } = send(sent, write, AT_ONCE).await.unwrap();
        assert_eq!(written, None);
        // it is read while it grows: from memory, and over into the file
        let mut read = body.into_data_stream();
        for piece in bytes.chunks(300_000) {
            pieces.send(piece.to_vec()).await.unwrap();
            let mut got = Vec::new();
            while got.len() < piece.len() {
                got.extend(read.next().await.unwrap().unwrap());
            }
            assert!(got == piece);
        }
        drop(pieces);
        assert!(read.next().await.is_none());
    }

    #[tokio::test]
    async fn an_answer_that_is_not_whole_breaks_off() {
        let (sent, mut to) = growing();
        let (fail, failing) = tokio::sync::oneshot::channel::<()>();
        let write = async move {
            to.write_all(b"begun")?;
            // not before it is sent, however long the machine pauses
            let _gone = failing.await;
            Err::<(), _>(io::Error::other("the store is away"))
        };
        let Sent { body, .. } = send(sent, write, AT_ONCE).await.unwrap();
        fail.send(()).unwrap();
        assert!(to_bytes(body, 100).await.is_err());
        // before that it is a refusal
        let refused = send(growing().0, async { Err::<(), _>(io::Error::other("no")) }, QUICK).await;
        assert!(refused.is_err_and(|why| why.to_string() == "no"));
    }

    #[test]
    fn a_folder_that_takes_no_file_is_named() {
        let folder = tempfile::tempdir().unwrap().path().join("gone");
        let mut growing = Growing::new(folder.clone());
        growing.write_all(&noise(IN_MEMORY)).unwrap();
        let error = growing.write_all(b"more").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(error.to_string().starts_with(&format!("{}: ", folder.display())), "{error}");
    }

    #[tokio::test]
    async fn nobody_writes_for_a_client_that_has_left() {
        let (left, mut gone) = tokio::sync::mpsc::channel::<()>(1);
        let write = async move {
            let _held = left;
            std::future::pending::<Result<(), io::Error>>().await
        };
        let Sent { body, .. } = send(growing().0, write, AT_ONCE).await.unwrap();
        assert!(timeout(Duration::from_millis(50), gone.recv()).await.is_err(), "it is written");
        drop(body);
        assert_eq!(timeout(QUICK, gone.recv()).await.unwrap(), None);
    }
}
