//! Answers packed while they are made and unpacked while they are sent, so that none is ever whole
//! in memory. What is packed is charged to the budget.

use std::io::{self, BufReader, Cursor, Read as _, Write as _};

use axum::body::{Body, Bytes};
use futures_util::stream;
use http_body_util::BodyExt as _;
use tokio::task::yield_now;
use zstd::stream::{read::Decoder, write::Encoder};

use super::super::budget::{Budget, Permit, WithPermit};
use crate::api::problem::{Problem, ProblemCode};

/// How much time compressing takes for how little room.
const LEVEL: i32 = 3;

/// No value of a store is longer than 10⁹ bytes, with its row.
const LONGEST: u64 = 900_000_000;

/// Bytes that are packed or unpacked at a time, in less than a millisecond.
const PIECE: usize = 64 << 10;

/// How far back what is unpacked refers to what came before, as a power of two: 256 KiB.
const WINDOW_LOG: u32 = 18;
/// What unpacking takes beside: the window, a block and a piece.
const UNPACKING: usize = (1 << WINDOW_LOG) + (256 << 10);

/// What a packer may write at once.
const WRITTEN: usize = 2 * (128 << 10);

/// A body of at most `most` bytes once it is packed. Refused for good is what would have no room
/// beside nothing else; what others hold meanwhile refuses nothing, for the work is done.
pub async fn packed(mut body: Body, budget: &Budget, most: u64) -> Result<WithPermit<Vec<u8>>, Problem> {
    let most = most.min(LONGEST);
    let mut permit = budget.permit();
    let mut encoder = Encoder::new(Vec::new(), LEVEL).map_err(Problem::internal)?;
    encoder.window_log(WINDOW_LOG).map_err(Problem::internal)?;
    while let Some(frame) = body.frame().await {
        let Ok(bytes) = frame.map_err(Problem::internal)?.into_data() else { continue };
        for piece in bytes.chunks(PIECE) {
            make_room(encoder.get_mut());
            charge(&mut permit, encoder.get_ref(), most)?;
            encoder.write_all(piece).map_err(Problem::internal)?;
            yield_now().await;
        }
    }
    let whole = encoder.finish().map_err(Problem::internal)?;
    charge(&mut permit, &whole, most)?;
    Ok(WithPermit::new(whole, permit))
}

/// The same of bytes that are there. Processor work.
pub fn packed_bytes(bytes: &[u8]) -> Result<Vec<u8>, Problem> {
    zstd::bulk::compress(bytes, LEVEL).map_err(Problem::internal)
}

/// An eighth more at a time, where a vector by itself would take twice as much.
fn make_room(packed: &mut Vec<u8>) {
    let length = packed.len();
    if length > WRITTEN && packed.capacity() - length < WRITTEN {
        packed.reserve_exact(WRITTEN.max(length / 8));
    }
}

fn charge(permit: &mut Permit, packed: &Vec<u8>, most: u64) -> Result<(), Problem> {
    if packed.len() as u64 > most {
        let detail = format!("The answer takes more than the {most} bytes that are kept of one; ask for less.");
        return Err(Problem::new(ProblemCode::AnswerTooLarge, detail));
    }
    let more = packed.capacity().saturating_sub(permit.bytes());
    permit.check_total(more).map_err(|_never| {
        let room = permit.room();
        let detail =
            format!("The answer takes more than the {room} bytes that one request may have here; ask for less.");
        Problem::new(ProblemCode::AnswerTooLarge, detail)
    })?;
    permit.force(more);
    Ok(())
}

/// What was packed, unpacked piece by piece as it is sent. Of what is short the length is known.
pub fn unpacked(packed: WithPermit<Vec<u8>>) -> Result<Body, Problem> {
    let (packed, mut permit) = packed.into_parts();
    let decoder = Decoder::new(Cursor::new(packed)).map_err(Problem::internal)?;
    permit.force(UNPACKING);
    let mut rest = Rest { decoder, _permit: permit };
    // what is damaged at its beginning is told before the answer begins
    let first = rest.next().map_err(Problem::internal)?;
    if first.len() < PIECE {
        return Ok(Body::from(first));
    }
    let pieces = stream::try_unfold((Some(first), rest), |(first, mut rest)| async move {
        let piece = match first {
            Some(first) => first,
            None => rest.next()?,
        };
        Ok::<_, io::Error>((!piece.is_empty()).then(|| (Bytes::from(piece), (None, rest))))
    });
    Ok(Body::from_stream(pieces))
}

/// What is not sent yet.
struct Rest {
    decoder: Decoder<'static, BufReader<Cursor<Vec<u8>>>>,
    _permit: Permit,
}

impl Rest {
    /// The next piece; shorter than [`PIECE`] at the end.
    fn next(&mut self) -> io::Result<Vec<u8>> {
        let mut piece = Vec::with_capacity(PIECE);
        self.decoder.by_ref().take(PIECE as u64).read_to_end(&mut piece)?;
        Ok(piece)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that do not pack to nothing.
    fn bytes(length: usize) -> Vec<u8> {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 56) as u8
        };
        (0..length).map(|_| next()).collect()
    }

    async fn back(packed: WithPermit<Vec<u8>>) -> Vec<u8> {
        unpacked(packed).unwrap().collect().await.unwrap().to_bytes().into()
    }

    #[tokio::test]
    async fn what_is_packed_comes_back_and_is_charged_meanwhile() {
        let budget = Budget::new(4 << 20);
        for length in [0, 1, PIECE - 1, PIECE, PIECE + 1, 5 * PIECE, 1_000_000] {
            let whole = bytes(length);
            let packed = packed(Body::from(whole.clone()), &budget, u64::MAX).await.unwrap();
            assert!(budget.held() >= length && budget.held() < 3 * length + 100, "{} of {length}", budget.held());
            assert!(back(packed).await == whole, "{length}");
            assert_eq!(budget.held(), 0);
        }
    }

    #[tokio::test]
    async fn what_packs_well_is_never_whole_in_memory() {
        let budget = Budget::new(1 << 20);
        let zeros = stream::iter((0..64).map(|_| Ok::<_, io::Error>(Bytes::from(vec![0; 1 << 20]))));
        let packed = packed(Body::from_stream(zeros), &budget, u64::MAX).await.unwrap();
        assert!(budget.held() < 64 << 10, "{}", budget.held());
        let mut body = unpacked(packed).unwrap();
        let mut length = 0;
        while let Some(frame) = body.frame().await {
            let frame = frame.unwrap().into_data().unwrap();
            assert!(frame.len() <= PIECE);
            length += frame.len();
        }
        assert_eq!(length, 64 << 20);
    }

    #[tokio::test]
    async fn what_is_packed_takes_hardly_more_than_its_length() {
        let budget = Budget::new(4 << 20);
        let whole = bytes(3_300_000);
        let packed = packed(Body::from(whole), &budget, u64::MAX).await.unwrap();
        assert!(budget.held() < 3_900_000, "{}", budget.held());
        let body = unpacked(packed).unwrap();
        assert!(budget.held() > 3_300_000 + (1 << WINDOW_LOG), "{}", budget.held());
        drop(body);
        assert_eq!(budget.held(), 0);
    }

    #[tokio::test]
    async fn what_is_too_long_is_given_up_as_soon_as_that_is_seen() {
        let budget = Budget::new(1 << 20);
        let whole = bytes(3 << 20);
        let pieces = || whole.chunks(1 << 16).map(|piece| Ok::<_, io::Error>(piece.to_vec())).collect::<Vec<_>>();
        let many = || Body::from_stream(stream::iter(pieces()));
        for most in [u64::MAX, 100_000] {
            let refused = packed(many(), &budget, most).await.unwrap_err();
            assert_eq!((refused.status, &*refused.code), (413, "answer_too_large"));
            assert_eq!(budget.held(), 0);
        }
        // others hold all there is, which does not lose what is done
        let _others = budget.take(900_000).unwrap();
        assert!(packed(Body::from(bytes(300_000)), &budget, u64::MAX).await.is_ok());
    }

    #[tokio::test]
    async fn what_is_damaged_is_told() {
        let budget = Budget::new(4 << 20);
        let packed = || async { packed(Body::from(bytes(1_000_000)), &budget, u64::MAX).await.unwrap().into_parts() };
        let (mut damaged, permit) = packed().await;
        damaged.truncate(500_000);
        let sent = unpacked(WithPermit::new(damaged, permit)).unwrap().collect().await;
        assert!(sent.is_err(), "nobody takes it for whole");
        let (_, permit) = packed().await;
        assert_eq!(unpacked(WithPermit::new(b"no frame".to_vec(), permit)).unwrap_err().status, 500);
    }
}
