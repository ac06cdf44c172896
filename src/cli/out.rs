//! Standard output, whose reader may leave before the end (`flankfit openapi | head`).

use std::{
    error::Error,
    io::{self, StdoutLock, Write},
};

/// Standard output.
pub struct Out(StdoutLock<'static>);

/// The reader has closed the pipe: no failure, and nothing is to be said of it.
#[derive(Debug, thiserror::Error)]
#[error("the reader of standard output has left")]
struct ReaderLeft;

pub fn out() -> Out {
    Out(io::stdout().lock())
}

/// Whether an error says only that nobody reads the output any more. (A pipe to a server that broke
/// is another matter.)
pub fn reader_left(error: &(dyn Error + 'static)) -> bool {
    let inner = error.downcast_ref::<io::Error>().and_then(io::Error::get_ref);
    inner.is_some_and(|inner| inner.is::<ReaderLeft>()) || error.source().is_some_and(reader_left)
}

fn told(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => io::Error::new(io::ErrorKind::BrokenPipe, ReaderLeft),
        _ => error,
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(told)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(told)
    }
}
