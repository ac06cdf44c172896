//! Fit requests as JSON or as `multipart/form-data` (part `spec`, part `nodes`), for every endpoint that takes nodes.

use std::{
    pin::pin,
    task::{Context, Poll, Waker},
};

use axum::{
    body::{Body, Bytes},
    extract::{FromRequest, Multipart, Request},
    http::header,
};
use sha2::{Digest, Sha256};

use super::body::{Media, Payload, unsupported};
use crate::{
    api::{
        problem::{Problem, ProblemCode},
        reader::{self, Extra},
    },
    estimation::{FitSpec, Nodes},
};

/// Decompresses and reads a fit request in either form. Processor work.
pub fn read_fit<E: Extra>(payload: Payload, limit: usize) -> Result<(Nodes, FitSpec, E), Problem> {
    match payload.media().clone() {
        Media::Json => Ok(reader::read_fit(&payload.into_bytes(limit)?)?),
        Media::Multipart(content_type) => {
            let [spec, nodes] = split(payload.into_bytes(limit)?, &content_type, &FIT)?;
            let (spec, nodes) = (needed(spec, "spec")?, needed(nodes, "nodes")?);
            Ok(reader::read_fit_with_csv(&spec.content, &nodes.content)?)
        }
        Media::Other(other) => Err(unsupported(&other, "application/json or multipart/form-data")),
    }
}

/// Decompresses a request and takes its digest, by which a repeated request is known: of a form only the parts count, for its
/// boundary changes with every sending. Processor work.
pub fn digest(payload: Payload, limit: usize) -> Result<(Payload, [u8; 32]), Problem> {
    let payload = payload.decompressed(limit)?;
    let bytes = payload.clone().into_bytes(limit)?;
    let mut digest = Sha256::new();
    match payload.media() {
        Media::Multipart(content_type) => {
            for part in parts(bytes, content_type)? {
                digest.update(part.name.len().to_le_bytes());
                digest.update(part.name.as_bytes());
                digest.update(part.content.len().to_le_bytes());
                digest.update(&part.content);
            }
        }
        Media::Json | Media::Other(_) => digest.update(&bytes),
    }
    Ok((payload, digest.finalize().into()))
}

/// A file with what is said of it.
pub struct FileForm {
    pub file: Bytes,
    /// As the caller calls it.
    pub name: Option<String>,
    /// JSON.
    pub spec: Option<Bytes>,
}

/// Decompresses and reads a form with a file. Processor work.
pub fn read_file(payload: Payload, limit: usize) -> Result<FileForm, Problem> {
    let Media::Multipart(content_type) = payload.media().clone() else {
        let other = match payload.media() {
            Media::Other(other) => other.clone(),
            _ => "application/json".to_owned(),
        };
        return Err(unsupported(&other, "multipart/form-data"));
    };
    let [spec, file] = split(payload.into_bytes(limit)?, &content_type, &FILE)?;
    let file = needed(file, "file")?;
    Ok(FileForm { file: file.content, name: file.file_name, spec: spec.map(|part| part.content) })
}

/// A part of a form: its name and the media types that it may have.
type Wanted = (&'static str, &'static [&'static str]);

const FIT: [Wanted; 2] = [("spec", &["application/json"]), ("nodes", &["text/csv"])];
/// Files of instruments have no media type of their own: any is taken.
const FILE: [Wanted; 2] = [("spec", &["application/json"]), ("file", &[])];

struct Part {
    name: String,
    media: String,
    file_name: Option<String>,
    content: Bytes,
}

fn needed(part: Option<Part>, name: &str) -> Result<Part, Problem> {
    part.ok_or_else(|| malformed(&format!("the part `{name}` is missing")))
}

/// The parts wanted of a form, in their order.
fn split(bytes: Bytes, content_type: &str, wanted: &[Wanted; 2]) -> Result<[Option<Part>; 2], Problem> {
    let mut found = [None, None];
    for part in parts(bytes, content_type)? {
        let Some(place) = wanted.iter().position(|(name, _)| *name == part.name) else {
            let other: String = part.name.chars().take(64).collect();
            let [(a, _), (b, _)] = wanted;
            return Err(malformed(&format!("there is no part `{other}`; the parts are `{a}` and `{b}`")));
        };
        let (name, media) = wanted[place];
        let essence = part.media.split(';').next().unwrap_or("").trim();
        let fits = media.is_empty() || media.iter().any(|wanted| essence.eq_ignore_ascii_case(wanted));
        if !(essence.is_empty() || fits) {
            return Err(Problem::new(
                ProblemCode::UnsupportedMediaType,
                format!("The part `{name}` is {essence}; send {}.", media.join(" or ")),
            ));
        }
        if found[place].replace(part).is_some() {
            return Err(malformed(&format!("the part `{name}` stands twice")));
        }
    }
    Ok(found)
}

/// All parts of a form that is in memory already, so nothing is ever waited for.
fn parts(bytes: Bytes, content_type: &str) -> Result<Vec<Part>, Problem> {
    let mut work = pin!(collect(bytes, content_type));
    match work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(parts) => parts,
        Poll::Pending => Err(malformed("it ends before its closing boundary")),
    }
}

/// Most parts that are read of a form.
const MOST_PARTS: usize = 16;

async fn collect(bytes: Bytes, content_type: &str) -> Result<Vec<Part>, Problem> {
    let request = Request::builder()
        .method("POST")
        .header(header::CONTENT_TYPE, content_type)
        .body(Body::from(bytes))
        .map_err(|error| malformed(&error.to_string()))?;
    let mut form = Multipart::from_request(request, &()).await.map_err(|error| malformed(&error.body_text()))?;
    let mut parts = Vec::new();
    while let Some(field) = form.next_field().await.map_err(|error| malformed(&error.body_text()))? {
        if parts.len() == MOST_PARTS {
            return Err(malformed("it has more than two parts"));
        }
        parts.push(Part {
            name: field.name().unwrap_or("").to_owned(),
            media: field.content_type().unwrap_or("").to_owned(),
            file_name: field.file_name().map(str::to_owned),
            content: field.bytes().await.map_err(|error| malformed(&error.body_text()))?,
        });
    }
    Ok(parts)
}

fn malformed(why: &str) -> Problem {
    Problem::new(ProblemCode::MalformedBody, format!("The form cannot be read: {why}."))
}
