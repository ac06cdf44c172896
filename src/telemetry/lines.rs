//! Log lines on standard error, written in batches by a thread of their own.
//!
//! A system call for every line costs more than everything else that is done around a small
//! request. Lines are gathered here and written some milliseconds later; [`flush`] writes what is
//! left when the program ends.

use std::{
    io::{self, Write},
    sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError},
    time::Duration,
};

use tracing_subscriber::fmt::MakeWriter;

/// Time for which lines are gathered after the first one.
const FLUSH_DELAY: Duration = Duration::from_millis(20);

/// Bytes that are kept without a reader; later lines are dropped rather than held up.
const CAPACITY: usize = 16 << 20;

#[derive(Default)]
struct Buffer {
    state: Mutex<Lines>,
    first: Condvar,
}

#[derive(Default)]
struct Lines {
    text: Vec<u8>,
    dropped: usize,
}

fn buffer() -> &'static Buffer {
    static BUFFER: OnceLock<Buffer> = OnceLock::new();
    BUFFER.get_or_init(Buffer::default)
}

impl Buffer {
    fn lock(&self) -> MutexGuard<'_, Lines> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Starts the writing thread and gives what subscribers write to.
pub fn start() -> io::Result<Writer> {
    std::thread::Builder::new().name("log".into()).spawn(|| {
        loop {
            let lines = buffer().lock();
            drop(buffer().first.wait_while(lines, |lines| lines.text.is_empty()));
            std::thread::sleep(FLUSH_DELAY);
            flush();
        }
    })?;
    Ok(Writer)
}

/// Writes what has been gathered so far.
pub fn flush() {
    // Standard error is locked first, so that lines keep their order whoever flushes.
    let mut out = io::stderr().lock();
    let Lines { mut text, dropped } = std::mem::take(&mut *buffer().lock());
    if dropped > 0 {
        text.extend_from_slice(format!("{dropped} log lines were dropped: standard error was not read\n").as_bytes());
    }
    // Nobody is left to learn that the log cannot be written.
    let _written = out.write_all(&text).and_then(|()| out.flush());
}

/// Hands lines over.
#[derive(Clone, Copy, Debug)]
pub struct Writer;

impl Write for Writer {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let mut lines = buffer().lock();
        let first = lines.text.is_empty();
        if lines.text.len() + line.len() > CAPACITY {
            lines.dropped += 1;
        } else {
            lines.text.extend_from_slice(line);
        }
        drop(lines);
        if first {
            buffer().first.notify_one();
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for Writer {
    type Writer = Writer;

    fn make_writer(&self) -> Writer {
        *self
    }
}
