//! Request bodies: collected once, limited, decompressed.
//!
//! The limit counts decompressed bytes. Decompressing is processor work and belongs on the pool: a
//! [`Payload`] carries the bytes as they came and is decoded there. Both the bytes as they came and
//! the decompressed ones are charged to the budget, together with the numbers that are read from
//! them.

use std::sync::OnceLock;

use axum::extract::FromRequest;
use http_body_util::BodyExt;
use sha2::{Digest, Sha256};

use super::prelude::*;
use super::{
    content_encoding::{Encoding, PIECE, too_large},
    media_type,
};
use crate::{
    pool::checkpoint,
    usecases::budget::{Permit, WithPermit},
};

/// Media type of the body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Media {
    Json,
    /// With the whole `content-type`, which names the boundary.
    Multipart(String),
    /// Anything else, or nothing at all.
    Other(String),
}

/// A body as it came.
#[derive(Debug)]
pub struct Payload {
    bytes: Bytes,
    /// For the bytes.
    permit: Permit,
    /// How many numbers stand in bytes that are not compressed.
    numbers: usize,
    encoding: Encoding,
    media: Media,
    /// Receives the digest of the unpacked body.
    digest: Option<BodyDigest>,
}

/// The digest of a body, once it has been read.
pub type BodyDigest = Arc<OnceLock<[u8; 32]>>;

impl FromRequest<AppState> for Payload {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &AppState) -> Result<Self, Problem> {
        Payload::collect(request, state, state.settings.body_limit).await
    }
}

impl Payload {
    /// A body of at most `limit` bytes.
    pub async fn collect(request: Request, state: &AppState, limit: usize) -> Result<Self, Problem> {
        let encoding = Encoding::of(request.headers())?;
        let media = media(request.headers())?;
        let settings = &state.settings;
        let mut permit = state.budget.permit();
        let count = if encoding == Encoding::Identity { numbers_of(&media) } else { |_: &[u8]| 0 };
        let whole = collect(request, limit, count, &mut permit);
        let (bytes, numbers) = tokio::time::timeout(settings.body_timeout(), whole).await.map_err(|_elapsed| {
            Problem::new(
                ProblemCode::BodyTimeout,
                format!("The body did not arrive within {} s.", settings.body_timeout),
            )
        })??;
        Ok(Payload { bytes, permit, numbers, encoding, media, digest: None })
    }

    /// The bytes as they came.
    pub fn bytes(&self) -> Bytes {
        self.bytes.clone()
    }

    pub fn media(&self) -> &Media {
        &self.media
    }

    /// Whether this is JSON of at most `most` bytes that came uncompressed.
    pub fn is_plain_json(&self, most: usize) -> bool {
        self.media == Media::Json && self.encoding == Encoding::Identity && self.bytes.len() <= most
    }

    /// Has the digest noted of the body when it is unpacked, so that it is unpacked once.
    pub fn digested(mut self) -> (Self, BodyDigest) {
        let digest = BodyDigest::default();
        self.digest = Some(Arc::clone(&digest));
        (self, digest)
    }

    /// The decompressed bytes, with a permit for what is computed with them, and where their digest
    /// is to be noted. Processor work for compressed bodies.
    pub fn unpack(self, limit: usize) -> Result<(WithPermit<Bytes>, Option<BodyDigest>), Problem> {
        let Payload { bytes, mut permit, numbers, encoding, digest, media } = self;
        let numbers_in = numbers_of(&media);
        if encoding == Encoding::Identity {
            permit.grow(numbers * NUMBER)?;
            return Ok((WithPermit::new(bytes, permit), digest));
        }
        let packed = bytes.len();
        let hint = encoding.unpacked_length(&bytes).map_or(0, |length| length.min(limit as u64) as usize);
        let mut whole = Vec::new();
        reserve(&mut whole, hint)?;
        encoding.pieces(&bytes, limit, |piece| {
            permit.grow(piece.len() + numbers_in(piece) * NUMBER)?;
            if piece.len() > whole.capacity() - whole.len() {
                let more = whole.capacity().min(limit - whole.len()).max(piece.len());
                reserve(&mut whole, more)?;
            }
            whole.extend_from_slice(piece);
            Ok(())
        })?;
        drop(bytes);
        permit.shrink_to(permit.bytes() - packed);
        Ok((WithPermit::new(whole.into(), permit), digest))
    }

    /// The same where the bytes themselves are what counts.
    pub fn into_bytes(self, limit: usize) -> Result<WithPermit<Bytes>, Problem> {
        let (held, digest) = self.unpack(limit)?;
        if let Some(digest) = digest {
            digest.get_or_init(|| {
                let mut sha256 = Sha256::new();
                add(&mut sha256, &held);
                sha256.finalize().into()
            });
        }
        Ok(held)
    }

    /// The decompressed bytes of a body that must be JSON.
    pub fn into_json(self, limit: usize) -> Result<WithPermit<Bytes>, Problem> {
        match &self.media {
            Media::Json => self.into_bytes(limit),
            Media::Multipart(other) | Media::Other(other) => Err(unsupported(other, "application/json")),
        }
    }

    /// The digest of the decompressed bytes, of which no more than a piece is held at a time.
    /// Processor work.
    pub fn digest(self, limit: usize) -> Result<[u8; 32], Problem> {
        let mut digest = Sha256::new();
        self.encoding.pieces(&self.bytes, limit, |piece| {
            digest.update(piece);
            Ok(())
        })?;
        Ok(digest.finalize().into())
    }
}

/// Adds bytes to a digest.
pub fn add(digest: &mut Sha256, bytes: &[u8]) {
    for piece in bytes.chunks(PIECE) {
        checkpoint();
        digest.update(piece);
    }
}

/// Bytes of a number during a computation: its value, its weight, its place in the matrix's rows,
/// its residual.
pub const NUMBER: usize = 4 * size_of::<f64>();

/// How many numbers are in a text, roughly: one begins after each comma.
fn numbers(text: &[u8]) -> usize {
    memchr::memchr_iter(b',', text).count()
}

/// How many cells are in a text that may be a table, roughly: one begins behind each separator, and
/// behind each run of blanks.
pub fn cells(text: &[u8]) -> usize {
    let mut before = b' ';
    let mut count = 0;
    for byte in text {
        let blank = before.is_ascii_whitespace() && !byte.is_ascii_whitespace();
        count += usize::from(blank || matches!(byte, b',' | b';' | b'\t'));
        before = *byte;
    }
    count
}

/// Returns the function that counts the numbers of a body.
fn numbers_of(media: &Media) -> fn(&[u8]) -> usize {
    match media {
        Media::Json => numbers,
        Media::Multipart(_) | Media::Other(_) => cells,
    }
}

/// 415 for a media type that is not among `wanted`.
pub fn unsupported(got: &str, wanted: &str) -> Problem {
    let curl = match media_type::essence(got).as_str() {
        "application/x-www-form-urlencoded" => {
            " (the default of curl; use -H 'content-type: application/json' for JSON, and a form for a table or a \
             file, as -F nodes=@nodes.csv or -F file=@curves.mka)"
        }
        _ => "",
    };
    let got = if got.is_empty() { "no content-type".to_owned() } else { format!("content-type `{got}`") };
    Problem::new(ProblemCode::UnsupportedMediaType, format!("The request has {got}; send {wanted}{curl}."))
}

/// 415 for a text in another character set than UTF-8.
pub fn foreign(charset: &str) -> Problem {
    let charset: String = charset.chars().take(64).collect();
    Problem::new(ProblemCode::UnsupportedMediaType, format!("The charset `{charset}` is not supported; send UTF-8."))
}

/// The bytes of a body, with a permit for each chunk before the next one is asked for, and how much
/// they hold of what `count` counts.
async fn collect(
    request: Request,
    limit: usize,
    count: impl Fn(&[u8]) -> usize,
    permit: &mut Permit,
) -> Result<(Bytes, usize), Problem> {
    let declared = request
        .headers()
        .get(header::CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.parse::<u64>().ok());
    if declared.is_some_and(|length| length > limit as u64) {
        return Err(too_large(limit));
    }
    // What is declared must fit now, but is taken only as it comes: a client that declares and does
    // not send holds nothing.
    let declared = declared.map(|length| length as usize);
    permit.check(declared.unwrap_or(0))?;
    let mut body: Body = request.into_body();
    let Some(first) = next_chunk(&mut body).await? else { return Ok((Bytes::new(), 0)) };
    if first.len() > limit {
        return Err(too_large(limit));
    }
    permit.grow(first.len())?;
    let mut numbers = count(&first);
    // Small bodies come in one piece and are not copied.
    if declared == Some(first.len()) {
        return Ok((first, numbers));
    }
    let mut whole = Vec::new();
    // Room that is not written to costs nothing: that of the declared length is taken at once, so
    // that a big body is neither copied nor held twice while it grows.
    reserve(&mut whole, declared.unwrap_or(0).max(first.len()))?;
    whole.extend_from_slice(&first);
    drop(first);
    while let Some(chunk) = next_chunk(&mut body).await? {
        let length = whole.len() + chunk.len();
        if length > limit {
            return Err(too_large(limit));
        }
        permit.grow(chunk.len())?;
        numbers += count(&chunk);
        permit.check_total(numbers * NUMBER)?;
        if length > whole.capacity() {
            let room = (2 * whole.capacity()).min(limit).max(length);
            let more = room - whole.len();
            reserve(&mut whole, more)?;
        }
        whole.extend_from_slice(&chunk);
    }
    Ok((whole.into(), numbers))
}

fn reserve(bytes: &mut Vec<u8>, more: usize) -> Result<(), Problem> {
    bytes.try_reserve_exact(more).map_err(|error| {
        Problem::new(ProblemCode::Overloaded, "There is no memory for the body at the moment.")
            .caused_by(error)
            .retry_after(5)
    })
}

async fn next_chunk(body: &mut Body) -> Result<Option<Bytes>, Problem> {
    while let Some(frame) = body.frame().await {
        let frame = frame.map_err(|error| {
            Problem::new(ProblemCode::MalformedBody, "The body ended before it was complete.").caused_by(error)
        })?;
        if let Ok(data) = frame.into_data() {
            return Ok(Some(data));
        }
    }
    Ok(None)
}

/// Media type that programs send for bytes of unknown content. (A page of another site cannot send
/// it without a preflight.)
pub const UNKNOWN: &str = "application/octet-stream";

fn media(headers: &HeaderMap) -> Result<Media, Problem> {
    let text = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or("");
    let essence = media_type::essence(text);
    if essence == "application/json" || (essence.starts_with("application/") && essence.ends_with("+json")) {
        match media_type::foreign_charset(text) {
            Some(charset) => Err(foreign(&charset)),
            None => Ok(Media::Json),
        }
    } else if essence == "multipart/form-data" {
        Ok(Media::Multipart(text.to_owned()))
    } else if essence == UNKNOWN {
        // treated as the most common type
        Ok(Media::Json)
    } else {
        Ok(Media::Other(text.to_owned()))
    }
}
