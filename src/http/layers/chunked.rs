//! Answers that are made as they are sent: each piece by a worker, when the client has taken the
//! one before.
//!
//! No worker waits for a client, however slowly it reads; what the file is made of stays in memory
//! meanwhile and is charged to the budget. The first piece is made before the answer begins, so
//! that a refusal still is a problem of its own.

use std::{
    io,
    sync::{Mutex, PoisonError},
};

use futures_util::{StreamExt, stream};

use super::prelude::*;
use crate::{
    api::shapes::export::Pieces,
    pool::{self, Party, PoolError},
    usecases::budget::Permit,
};

/// Bytes of a piece.
pub const PIECE: usize = 256 << 10;

/// How long a piece waits where the queue for workers is full: what has begun is not refused.
const QUEUE_PAUSE: Duration = Duration::from_millis(50);

/// A file and its permit, between two pieces.
struct Remaining {
    state: AppState,
    file: Arc<Mutex<Pieces>>,
    party: Party,
    _permit: Permit,
}

/// A body of a first piece and what follows it.
pub fn body(state: AppState, first: Vec<u8>, file: Pieces, permit: Permit) -> Body {
    if file.is_done() {
        // of known length, and charged like any other answer
        return Body::from(first);
    }
    let rest = Remaining { state, file: Arc::new(Mutex::new(file)), party: pool::party(), _permit: permit };
    let pieces = stream::unfold((Some(first), rest), |(first, rest)| async move {
        let piece = match first {
            Some(first) => Ok(first),
            None => rest.next().await.transpose()?,
        };
        Some((piece.map(Bytes::from), (None, rest)))
    });
    // an encoder may ask once more after the last piece
    Body::from_stream(pieces.fuse())
}

impl Remaining {
    async fn next(&self) -> Result<Option<Vec<u8>>, io::Error> {
        loop {
            let file = Arc::clone(&self.file);
            let work = move || file.lock().unwrap_or_else(PoisonError::into_inner).next_piece(PIECE);
            match pool::on_behalf_of(self.party.clone(), self.state.pool.run(work)).await {
                Ok(piece) => return Ok(piece),
                Err(PoolError::Full) => tokio::time::sleep(QUEUE_PAUSE).await,
                // the connection ends without the end of the answer, so that no reader takes it for
                // whole
                Err(error) => return Err(io::Error::other(error)),
            }
        }
    }
}
