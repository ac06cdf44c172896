//! Fit requests as JSON or as `multipart/form-data` (part `spec`, part `nodes`), for every endpoint
//! that takes nodes.

use axum::body::Bytes;
use sha2::{Digest, Sha256};

use super::{
    body::{Media, NUMBER, Payload, UNKNOWN, add, cells, foreign, unsupported},
    form::{self, Part},
    media_type::{essence, foreign_charset},
};
use crate::{
    api::{
        fits::reader,
        json::request::ReadWhole,
        problem::{Problem, ProblemCode},
        tables::{kept::SentMapping, mapping},
    },
    usecases::{budget::WithPermit, import::FileForm},
};
use flankfit_engine::estimation::{FitSpec, Nodes};

/// A fit request, with the mapping that came with its table.
pub type FitForm<E> = (Nodes, FitSpec, E, Option<SentMapping>);

/// Decompresses and reads a fit request in either form, with the permit for what has been read.
/// Processor work.
pub fn read_fit<E: ReadWhole>(payload: Payload, limit: usize) -> Result<WithPermit<FitForm<E>>, Problem> {
    match payload.media().clone() {
        Media::Json => {
            let (text, permit) = payload.into_bytes(limit)?.into_parts();
            let (nodes, spec, extra) = reader::read_fit(&text)?;
            Ok(WithPermit::new((nodes, spec, extra, None), permit))
        }
        Media::Multipart(content_type) => {
            let ([spec, nodes, mapping], permit) = split(payload, limit, &content_type, &FIT)?.into_parts();
            let (spec, nodes) = (required(spec, "spec")?, required(nodes, "nodes")?);
            let (table, mapping) = (nodes.content, mapping.as_ref().map(|part| &*part.content));
            let (nodes, spec, extra) = reader::read_fit_with_table(&spec.content, &table, mapping)?;
            let sent = mapping::read(mapping)?.and_then(|mapping| SentMapping::of(&table, &mapping));
            Ok(WithPermit::new((nodes, spec, extra, sent), permit))
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

/// Digest of a form: only the parts count, since the boundary changes with every request.
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

/// Decompresses and reads a form with a file. Processor work.
pub fn read_file(payload: Payload, limit: usize) -> Result<WithPermit<FileForm>, Problem> {
    let Media::Multipart(content_type) = payload.media().clone() else {
        let other = match payload.media() {
            Media::Other(other) => other.clone(),
            _ => "application/json".to_owned(),
        };
        return Err(unsupported(&other, "multipart/form-data"));
    };
    let ([spec, file, mapping], permit) = split(payload, limit, &content_type, &FILE)?.into_parts();
    let file = required(file, "file")?;
    let mapping = mapping::read(mapping.as_ref().map(|part| &*part.content))?;
    let form = FileForm { file: file.content, name: file.file_name, spec: spec.map(|part| part.content), mapping };
    Ok(WithPermit::new(form, permit))
}

/// Decompresses a file that comes alone or in a form. Processor work.
pub fn read_any_file(payload: Payload, limit: usize) -> Result<WithPermit<FileForm>, Problem> {
    match payload.media() {
        Media::Multipart(_) => read_file(payload, limit),
        // a file of no known type counts as JSON elsewhere
        Media::Json | Media::Other(_) => {
            let (file, mut permit) = payload.into_bytes(limit)?.into_parts();
            permit.grow(cells(&file) * NUMBER)?;
            Ok(WithPermit::new(FileForm { file, name: None, spec: None, mapping: None }, permit))
        }
    }
}

/// A part of a form: its name and the media types that it may have.
type PartSpec = (&'static str, &'static [&'static str]);

/// Files have no media type of their own, and tables have several: any is taken.
const FIT: [PartSpec; 3] = [("spec", &["application/json"]), ("nodes", &[]), ("mapping", &["application/json"])];
const FILE: [PartSpec; 3] = [("spec", &["application/json"]), ("file", &[]), ("mapping", &["application/json"])];

fn required(part: Option<Part>, name: &str) -> Result<Part, Problem> {
    part.ok_or_else(|| malformed(&format!("the part `{name}` is missing")))
}

/// Decompresses a form and cuts out the parts that are wanted of it, in their order.
fn split(
    payload: Payload,
    limit: usize,
    content_type: &str,
    wanted: &[PartSpec; 3],
) -> Result<WithPermit<[Option<Part>; 3]>, Problem> {
    let (form, noted) = payload.unpack(limit)?;
    let (form, permit) = form.into_parts();
    let parts = parts(&form, content_type)?;
    if let Some(noted) = noted {
        noted.get_or_init(|| digest_of(&parts));
    }
    let mut found = [const { None }; 3];
    for part in parts {
        let Some(place) = wanted.iter().position(|(name, _)| *name == part.name) else {
            let other: String = part.name.chars().take(64).collect();
            let [(a, _), (b, _), (c, _)] = wanted;
            return Err(malformed(&format!("there is no part `{other}`; the parts are `{a}`, `{b}` and `{c}`")));
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
            return Err(malformed(&format!("the part `{name}` occurs twice; send it once")));
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
