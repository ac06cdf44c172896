//! Fit requests as JSON or as `multipart/form-data` (part `spec`, part `nodes`), for every endpoint that takes nodes.

use axum::body::Bytes;
use sha2::{Digest, Sha256};

use super::{
    body::{Media, Payload, foreign, unsupported},
    form::{self, Part},
    media_type::{essence, foreign_charset},
};
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
            for part in parts(&bytes, content_type)? {
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

fn needed(part: Option<Part>, name: &str) -> Result<Part, Problem> {
    part.ok_or_else(|| malformed(&format!("the part `{name}` is missing")))
}

/// The parts wanted of a form, in their order.
fn split(bytes: Bytes, content_type: &str, wanted: &[Wanted; 2]) -> Result<[Option<Part>; 2], Problem> {
    let mut found = [None, None];
    for part in parts(&bytes, content_type)? {
        let Some(place) = wanted.iter().position(|(name, _)| *name == part.name) else {
            let other: String = part.name.chars().take(64).collect();
            let [(a, _), (b, _)] = wanted;
            return Err(malformed(&format!("there is no part `{other}`; the parts are `{a}` and `{b}`")));
        };
        let (name, media) = wanted[place];
        let essence = essence(&part.media);
        let fits = media.is_empty() || media.contains(&essence.as_str());
        if !(essence.is_empty() || fits) {
            return Err(Problem::new(
                ProblemCode::UnsupportedMediaType,
                format!("The part `{name}` is {essence}; send {}.", media.join(" or ")),
            ));
        }
        if let Some(charset) = foreign_charset(&part.media).filter(|_| !media.is_empty()) {
            return Err(foreign(&charset));
        }
        if found[place].replace(part).is_some() {
            return Err(malformed(&format!("the part `{name}` stands twice")));
        }
    }
    Ok(found)
}

/// All parts of a form that is in memory already.
fn parts(bytes: &Bytes, content_type: &str) -> Result<Vec<Part>, Problem> {
    form::parts(bytes, content_type).map_err(malformed)
}

fn malformed(why: &str) -> Problem {
    Problem::new(ProblemCode::MalformedBody, format!("The form cannot be read: {why}."))
}
