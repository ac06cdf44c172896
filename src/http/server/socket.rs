//! The stream of a connection, with limits on how long its other end may keep it waiting.

use std::{
    io,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll, ready},
    time::Duration,
};

use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    time::{Instant, Sleep},
};

use super::connections::{Connection, ConnectionSlot, Phase};

/// How long the head of a request may take: on a new connection from its beginning, later from its
/// first byte.
const HEAD: Duration = Duration::from_secs(10);
/// How long a connection that is being closed goes on taking what its client still sends, so that
/// the client can read its answer.
const LINGER: Duration = Duration::from_secs(2);

/// See the module's documentation.
pub struct Socket<S> {
    stream: S,
    slot: Arc<ConnectionSlot>,
    /// How long nothing may be taken from us.
    write_timeout: Duration,
    /// When reading has waited too long.
    head: Pin<Box<Sleep>>,
    /// When writing has waited too long, or closing; set while it waits.
    deadline: Option<Pin<Box<Sleep>>>,
    /// Whether our side has been closed.
    ended: bool,
}

impl<S> Socket<S> {
    pub fn new(stream: S, slot: Arc<ConnectionSlot>, write_timeout: Duration) -> Self {
        let head = Box::pin(tokio::time::sleep(HEAD));
        Socket { stream, slot, write_timeout, head, deadline: None, ended: false }
    }

    fn connection(&self) -> &Connection {
        self.slot.connection()
    }

    /// The outcome of a write, with the clock running while there is none.
    fn written<T>(&mut self, cx: &mut Context<'_>, outcome: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if outcome.is_ready() {
            if self.deadline.take().is_some() {
                self.connection().set_unsent(false);
            }
            return outcome;
        }
        if self.deadline.is_none() {
            self.connection().set_unsent(true);
        }
        let limit = self.write_timeout;
        let clock = self.deadline.get_or_insert_with(|| Box::pin(tokio::time::sleep(limit)));
        ready!(clock.as_mut().poll(cx));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client does not read")))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Socket<S> {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let outcome = Pin::new(&mut self.stream).poll_read(cx, buffer);
        let phase = self.connection().phase();
        if outcome.is_ready() {
            if buffer.filled().len() > before && matches!(phase, Phase::Fresh | Phase::Idle) {
                if phase == Phase::Idle {
                    self.head.as_mut().reset(Instant::now() + HEAD);
                }
                self.connection().set_phase(Phase::Head);
            }
            return outcome;
        }
        if matches!(phase, Phase::Fresh | Phase::Head) {
            ready!(self.head.as_mut().poll(cx));
            return Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "no request came")));
        }
        Poll::Pending
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin> AsyncWrite for Socket<S> {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.written(cx, outcome)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.stream).poll_write_vectored(cx, parts);
        self.written(cx, outcome)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        if !self.ended {
            ready!(Pin::new(&mut self.stream).poll_shutdown(cx))?;
            self.ended = true;
            self.deadline = None;
        }
        if !self.connection().is_unread() {
            return Poll::Ready(Ok(()));
        }
        // Closed with bytes unread, the system would tell the client to forget what it has not read
        // itself.
        let clock = self.deadline.get_or_insert_with(|| Box::pin(tokio::time::sleep(LINGER)));
        if clock.as_mut().poll(cx).is_ready() {
            return Poll::Ready(Ok(()));
        }
        let mut rest = [0; 16 << 10];
        // a bounded number of reads, for others have their turn
        for _ in 0..16 {
            let mut buffer = ReadBuf::new(&mut rest);
            match ready!(Pin::new(&mut self.stream).poll_read(cx, &mut buffer)) {
                Ok(()) if !buffer.filled().is_empty() => {}
                Ok(()) | Err(_) => return Poll::Ready(Ok(())),
            }
        }
        cx.waker().wake_by_ref();
        Poll::Pending
    }
}
