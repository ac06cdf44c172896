//! Standard output, whose reader may close the pipe early (`flankfit openapi | head`).

use std::{
    error::Error,
    io::{self, StdoutLock, Write},
};

/// Standard output.
pub struct Out(StdoutLock<'static>);

/// The reader has closed the pipe: this is not a failure and is not reported.
#[derive(Debug, thiserror::Error)]
#[error("standard output was closed")]
struct ReaderLeft;

pub fn out() -> Out {
    Out(io::stdout().lock())
}

/// Whether an error only means that the reader of standard output has closed the pipe. (A broken
/// connection to a server does not count.)
pub fn reader_left(error: &(dyn Error + 'static)) -> bool {
    let inner = error.downcast_ref::<io::Error>().and_then(io::Error::get_ref);
    inner.is_some_and(|inner| inner.is::<ReaderLeft>()) || error.source().is_some_and(reader_left)
}

fn to_reader_left(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => io::Error::new(io::ErrorKind::BrokenPipe, ReaderLeft),
        _ => error,
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(to_reader_left)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(to_reader_left)
    }
}
