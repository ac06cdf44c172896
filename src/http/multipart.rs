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
            let parts = split(payload.into_bytes(limit)?, &content_type)?;
            Ok(reader::read_fit_with_csv(&parts.spec, &parts.nodes)?)
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
            let parts = split(bytes, content_type)?;
            for part in [parts.spec, parts.nodes] {
                digest.update(part.len().to_le_bytes());
                digest.update(&part);
            }
        }
        Media::Json | Media::Other(_) => digest.update(&bytes),
    }
    Ok((payload, digest.finalize().into()))
}

struct Parts {
    spec: Bytes,
    nodes: Bytes,
}

/// The two parts of a form that is in memory already, so nothing is ever waited for.
fn split(bytes: Bytes, content_type: &str) -> Result<Parts, Problem> {
    let mut work = pin!(split_form(bytes, content_type));
    match work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(parts) => parts,
        Poll::Pending => Err(malformed("it ends before its closing boundary")),
    }
}

async fn split_form(bytes: Bytes, content_type: &str) -> Result<Parts, Problem> {
    let request = Request::builder()
        .method("POST")
        .header(header::CONTENT_TYPE, content_type)
        .body(Body::from(bytes))
        .map_err(|error| malformed(&error.to_string()))?;
    let mut form = Multipart::from_request(request, &()).await.map_err(|error| malformed(&error.body_text()))?;
    let (mut spec, mut nodes) = (None, None);
    while let Some(field) = form.next_field().await.map_err(|error| malformed(&error.body_text()))? {
        let name = field.name().unwrap_or("").to_owned();
        let media = field.content_type().unwrap_or("").to_owned();
        let content = field.bytes().await.map_err(|error| malformed(&error.body_text()))?;
        let (place, wanted) = match name.as_str() {
            "spec" => (&mut spec, "application/json"),
            "nodes" => (&mut nodes, "text/csv"),
            other => {
                let other: String = other.chars().take(64).collect();
                return Err(malformed(&format!("there is no part `{other}`; the parts are `spec` and `nodes`")));
            }
        };
        let essence = media.split(';').next().unwrap_or("").trim();
        if !(essence.is_empty() || essence.eq_ignore_ascii_case(wanted)) {
            return Err(Problem::new(
                ProblemCode::UnsupportedMediaType,
                format!("The part `{name}` is {essence}; send {wanted}."),
            ));
        }
        if place.replace(content).is_some() {
            return Err(malformed(&format!("the part `{name}` stands twice")));
        }
    }
    match (spec, nodes) {
        (Some(spec), Some(nodes)) => Ok(Parts { spec, nodes }),
        (None, _) => Err(malformed("the part `spec` is missing")),
        (_, None) => Err(malformed("the part `nodes` is missing")),
    }
}

fn malformed(why: &str) -> Problem {
    Problem::new(ProblemCode::MalformedBody, format!("The form cannot be read: {why}."))
}
