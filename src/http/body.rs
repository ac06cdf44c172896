//! Request bodies: collected once, limited, decompressed.
//!
//! The limit counts decompressed bytes, and decompression stops where it is reached, so a small body that
//! expands to gigabytes costs no more than the limit. Decompressing is processor work and belongs on the
//! pool: a [`Payload`] carries the bytes as they came and is decoded there.

use std::io::Read;

use axum::{
    body::{Body, Bytes},
    extract::{FromRequest, Request},
    http::{HeaderMap, header},
};
use http_body_util::BodyExt;

use super::{media_type, state::AppState};
use crate::api::problem::{Problem, ProblemCode};

/// Room that is taken for a body of declared length before it comes.
const MOST_AHEAD: usize = 64 << 20;

/// How the body is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Identity,
    Gzip,
    Zstd,
}

/// What the body says it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Media {
    Json,
    /// With the whole `content-type`, which names the boundary.
    Multipart(String),
    /// Anything else, or nothing at all.
    Other(String),
}

/// A body as it came.
#[derive(Clone, Debug)]
pub struct Payload {
    bytes: Bytes,
    encoding: Encoding,
    media: Media,
}

impl FromRequest<AppState> for Payload {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &AppState) -> Result<Self, Problem> {
        let encoding = encoding(request.headers())?;
        let media = media(request.headers())?;
        let settings = &state.settings;
        let bytes = tokio::time::timeout(settings.body_timeout(), collect(request, settings.body_limit))
            .await
            .map_err(|_elapsed| {
                Problem::new(
                    ProblemCode::BodyTimeout,
                    format!("The body did not arrive within {} s.", settings.body_timeout),
                )
            })??;
        Ok(Payload { bytes, encoding, media })
    }
}

impl Payload {
    pub fn media(&self) -> &Media {
        &self.media
    }

    /// Whether this is JSON of at most `most` bytes that came uncompressed.
    pub fn is_plain_json(&self, most: usize) -> bool {
        self.media == Media::Json && self.encoding == Encoding::Identity && self.bytes.len() <= most
    }

    /// The decompressed bytes. Processor work for compressed bodies.
    pub fn into_bytes(self, limit: usize) -> Result<Bytes, Problem> {
        match self.encoding {
            Encoding::Identity => Ok(self.bytes),
            Encoding::Gzip => decompress(flate2::bufread::MultiGzDecoder::new(&self.bytes[..]), limit, "gzip"),
            Encoding::Zstd => {
                let decoder = zstd::stream::read::Decoder::with_buffer(&self.bytes[..])
                    .map_err(|error| broken("zstd", &error))?;
                decompress(decoder, limit, "zstd")
            }
        }
    }

    /// The same body, decompressed. Processor work for compressed ones.
    pub fn decompressed(self, limit: usize) -> Result<Self, Problem> {
        let media = self.media.clone();
        Ok(Payload { bytes: self.into_bytes(limit)?, encoding: Encoding::Identity, media })
    }

    /// The decompressed bytes of a body that must be JSON.
    pub fn into_json(self, limit: usize) -> Result<Bytes, Problem> {
        match &self.media {
            Media::Json => self.into_bytes(limit),
            Media::Multipart(other) | Media::Other(other) => Err(unsupported(other, "application/json")),
        }
    }
}

/// 415 for a media type that is not among `wanted`.
pub fn unsupported(got: &str, wanted: &str) -> Problem {
    let got = if got.is_empty() { "no content-type".to_owned() } else { format!("content-type `{got}`") };
    Problem::new(ProblemCode::UnsupportedMediaType, format!("The request has {got}; send {wanted}."))
}

/// 415 for a text in another character set than UTF-8.
pub fn foreign(charset: &str) -> Problem {
    let charset: String = charset.chars().take(64).collect();
    Problem::new(
        ProblemCode::UnsupportedMediaType,
        format!("The charset `{charset}` is not supported; send UTF-8, which needs no charset."),
    )
}

fn too_large(limit: usize) -> Problem {
    Problem::new(
        ProblemCode::BodyTooLarge,
        format!("The body is larger than {limit} bytes (counted after decompression)."),
    )
}

fn broken(form: &str, error: &std::io::Error) -> Problem {
    Problem::new(ProblemCode::MalformedBody, format!("The {form} stream of the body is broken: {error}."))
}

async fn collect(request: Request, limit: usize) -> Result<Bytes, Problem> {
    let declared = request
        .headers()
        .get(header::CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.parse::<u64>().ok());
    if declared.is_some_and(|length| length > limit as u64) {
        return Err(too_large(limit));
    }
    let mut body: Body = request.into_body();
    let Some(first) = next_chunk(&mut body).await? else { return Ok(Bytes::new()) };
    if first.len() > limit {
        return Err(too_large(limit));
    }
    // Small bodies come in one piece and are not copied.
    if declared == Some(first.len() as u64) {
        return Ok(first);
    }
    let mut whole = Vec::new();
    // A declared length is only a promise, but room that is not written to costs nothing: up to a bound it is taken at
    // once, so that a big body is neither copied nor held twice while it grows.
    let ahead = declared.map_or(0, |length| (length as usize).min(MOST_AHEAD)).max(first.len());
    reserve(&mut whole, ahead)?;
    whole.extend_from_slice(&first);
    drop(first);
    while let Some(chunk) = next_chunk(&mut body).await? {
        let length = whole.len() + chunk.len();
        if length > limit {
            return Err(too_large(limit));
        }
        if length > whole.capacity() {
            let room = (2 * whole.capacity()).min(declared.map_or(limit, |declared| declared as usize)).max(length);
            let more = room - whole.len();
            reserve(&mut whole, more)?;
        }
        whole.extend_from_slice(&chunk);
    }
    Ok(whole.into())
}

fn reserve(bytes: &mut Vec<u8>, more: usize) -> Result<(), Problem> {
    bytes.try_reserve_exact(more).map_err(|error| {
        Problem::new(ProblemCode::Overloaded, "There is no room for the body at the moment.")
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

fn decompress(decoder: impl Read, limit: usize, form: &str) -> Result<Bytes, Problem> {
    let mut whole = Vec::new();
    decoder.take(limit as u64 + 1).read_to_end(&mut whole).map_err(|error| broken(form, &error))?;
    if whole.len() > limit {
        return Err(too_large(limit));
    }
    Ok(whole.into())
}

fn encoding(headers: &HeaderMap) -> Result<Encoding, Problem> {
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

fn unsupported_encoding(got: &str) -> Problem {
    Problem::new(
        ProblemCode::UnsupportedMediaType,
        format!("The content-encoding `{got}` is not supported; send gzip, zstd or none."),
    )
}

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
    } else {
        Ok(Media::Other(text.to_owned()))
    }
}
