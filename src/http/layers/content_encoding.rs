//! Compressed request bodies (`content-encoding`), unpacked piece by piece.
//!
//! Decompression stops where the limit is reached, so a small body that expands to gigabytes costs
//! no more than the limit.

use std::io::Read;

use super::prelude::*;
use crate::pool::checkpoint;

/// How the body is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Identity,
    Gzip,
    Zstd,
}

impl Encoding {
    /// Reads the header.
    pub fn of(headers: &HeaderMap) -> Result<Self, Problem> {
        let mut values = headers.get_all(header::CONTENT_ENCODING).iter();
        let Some(value) = values.next() else { return Ok(Encoding::Identity) };
        let name = value.to_str().unwrap_or("?").trim().to_ascii_lowercase();
        match name.as_str() {
            _ if values.next().is_some() => Err(unsupported_encoding("several")),
            "" | "identity" => Ok(Encoding::Identity),
            "gzip" | "x-gzip" => Ok(Encoding::Gzip),
            "zstd" => Ok(Encoding::Zstd),
            other => Err(unsupported_encoding(other)),
        }
    }

    /// Hands over the decompressed bytes piece by piece, and stops where they exceed the limit.
    pub fn pieces(
        self,
        bytes: &[u8],
        limit: usize,
        mut take: impl FnMut(&[u8]) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        match self {
            Encoding::Identity => bytes.chunks(PIECE).try_for_each(|piece| {
                checkpoint();
                take(piece)
            }),
            Encoding::Gzip => pieces(flate2::bufread::MultiGzDecoder::new(bytes), limit, "gzip", take),
            Encoding::Zstd => {
                let mut decoder =
                    zstd::stream::read::Decoder::with_buffer(bytes).map_err(|error| broken("zstd", &error))?;
                decoder.window_log_max(WINDOW_LOG).map_err(|error| broken("zstd", &error))?;
                pieces(decoder, limit, "zstd", take)
            }
        }
    }

    /// Returns the length that a compressed body states, which need not be true.
    pub fn unpacked_length(self, bytes: &[u8]) -> Option<u64> {
        match self {
            Encoding::Identity => None,
            Encoding::Gzip => bytes.last_chunk().map(|length| u64::from(u32::from_le_bytes(*length))),
            Encoding::Zstd => zstd::zstd_safe::get_frame_content_size(bytes).ok().flatten(),
        }
    }
}

/// The largest window of zstd as a content encoding (RFC 9659): 8 MiB.
const WINDOW_LOG: u32 = 23;

/// Decompressed bytes that are handed over at a time.
pub const PIECE: usize = 128 << 10;

fn pieces(
    mut decoder: impl Read,
    limit: usize,
    form: &str,
    mut take: impl FnMut(&[u8]) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let mut piece = vec![0; PIECE.min(limit.saturating_add(1))];
    let mut length = 0;
    loop {
        // a bomb is not unpacked for a client that has left
        checkpoint();
        let read = match decoder.read(&mut piece) {
            Ok(0) => return Ok(()),
            Ok(read) => read,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(broken(form, &error)),
        };
        length += read;
        if length > limit {
            return Err(too_large(limit));
        }
        take(&piece[..read])?;
    }
}

pub fn too_large(limit: usize) -> Problem {
    Problem::new(
        ProblemCode::BodyTooLarge,
        format!("The body is larger than {limit} bytes (counted after decompression)."),
    )
}

fn broken(form: &str, error: &std::io::Error) -> Problem {
    Problem::new(ProblemCode::MalformedBody, format!("The {form} stream of the body is broken: {error}."))
}

fn unsupported_encoding(got: &str) -> Problem {
    Problem::new(
        ProblemCode::UnsupportedMediaType,
        format!("The content-encoding `{got}` is not supported; send gzip, zstd or none."),
    )
}
