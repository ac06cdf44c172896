//! Fit requests as JSON or as `multipart/form-data` (part `spec`, part `nodes`), for every endpoint
//! that takes nodes.

use axum::body::Bytes;
use sha2::{Digest, Sha256};

use super::{
    body::{Media, Payload, UNKNOWN, add, foreign, unsupported},
    budget::WithPermit,
    form::{self, Part},
    media_type::{essence, foreign_charset},
};
use crate::api::{
    fits::reader,
    json::request::ReadWhole,
    problem::{Problem, ProblemCode},
};
use flankfit_engine::estimation::{FitSpec, Nodes};

/// Decompresses and reads a fit request in either form, with the permit for what has been read.
/// Processor work.
pub fn read_fit<E: ReadWhole>(payload: Payload, limit: usize) -> Result<WithPermit<(Nodes, FitSpec, E)>, Problem> {
    match payload.media().clone() {
        Media::Json => {
            let (text, permit) = payload.into_bytes(limit)?.into_parts();
            Ok(WithPermit::new(reader::read_fit(&text)?, permit))
        }
        Media::Multipart(content_type) => {
            let ([spec, nodes], permit) = split(payload, limit, &content_type, &FIT)?.into_parts();
            let (spec, nodes) = (required(spec, "spec")?, required(nodes, "nodes")?);
            Ok(WithPermit::new(reader::read_fit_with_csv(&spec.content, &nodes.content)?, permit))
        }
        Media::Other(other) => Err(unsupported(&other, "application/json or multipart/form-data")),
    }
}

/// The digest of a request, by which a repeated one is known. Processor work.
pub fn digest(payload: Payload, limit: usize) -> Result<[u8; 32], Problem> {
    match payload.media().clone() {
        Media::Multipart(content_type) => {
            let (form, _) = payload.unpack(limit)?;
            Ok(digest_of(&parts(&form, &content_type)?))
        }
        Media::Json | Media::Other(_) => payload.digest(limit),
    }
}

/// Of a form only the parts count, for its boundary changes with every sending.
fn digest_of(parts: &[Part]) -> [u8; 32] {
    let mut digest = Sha256::new();
    for part in parts {
        digest.update(part.name.len().to_le_bytes());
        digest.update(part.name.as_bytes());
        digest.update(part.content.len().to_le_bytes());
        add(&mut digest, &part.content);
    }
    digest.finalize().into()
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
pub fn read_file(payload: Payload, limit: usize) -> Result<WithPermit<FileForm>, Problem> {
    let Media::Multipart(content_type) = payload.media().clone() else {
        let other = match payload.media() {
            Media::Other(other) => other.clone(),
            _ => "application/json".to_owned(),
        };
        return Err(unsupported(&other, "multipart/form-data"));
    };
    let ([spec, file], permit) = split(payload, limit, &content_type, &FILE)?.into_parts();
    let file = required(file, "file")?;
    let form = FileForm { file: file.content, name: file.file_name, spec: spec.map(|part| part.content) };
    Ok(WithPermit::new(form, permit))
}

/// A part of a form: its name and the media types that it may have.
type PartSpec = (&'static str, &'static [&'static str]);

const FIT: [PartSpec; 2] = [("spec", &["application/json"]), ("nodes", &["text/csv"])];
/// Files of instruments have no media type of their own: any is taken.
const FILE: [PartSpec; 2] = [("spec", &["application/json"]), ("file", &[])];

fn required(part: Option<Part>, name: &str) -> Result<Part, Problem> {
    part.ok_or_else(|| malformed(&format!("the part `{name}` is missing")))
}

/// Decompresses a form and cuts out the parts that are wanted of it, in their order.
fn split(
    payload: Payload,
    limit: usize,
    content_type: &str,
    wanted: &[PartSpec; 2],
) -> Result<WithPermit<[Option<Part>; 2]>, Problem> {
    let (form, noted) = payload.unpack(limit)?;
    let (form, permit) = form.into_parts();
    let parts = parts(&form, content_type)?;
    if let Some(noted) = noted {
        noted.get_or_init(|| digest_of(&parts));
    }
    let mut found = [None, None];
    for part in parts {
        let Some(place) = wanted.iter().position(|(name, _)| *name == part.name) else {
            let other: String = part.name.chars().take(64).collect();
            let [(a, _), (b, _)] = wanted;
            return Err(malformed(&format!("there is no part `{other}`; the parts are `{a}` and `{b}`")));
        };
        let (name, media) = wanted[place];
        let essence = essence(&part.media);
        // curl knows neither .csv nor .json: the content of such a part is recognised by reading it
        let fits = media.is_empty() || essence == UNKNOWN || media.contains(&essence.as_str());
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
    Ok(WithPermit::new(found, permit))
}

/// All parts of a form that is in memory already.
fn parts(bytes: &Bytes, content_type: &str) -> Result<Vec<Part>, Problem> {
    form::parts(bytes, content_type).map_err(malformed)
}

fn malformed(why: &str) -> Problem {
    Problem::new(ProblemCode::MalformedBody, format!("The form cannot be read: {why}."))
}
