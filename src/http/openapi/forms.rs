//! Forms (`multipart/form-data`): which media types their parts have.

use std::collections::BTreeMap;

use utoipa::openapi::{OpenApi as Document, RefOr, encoding::EncodingBuilder, path::Operation, schema::Schema};

/// The parts of every form, by the name of its schema.
pub fn parts(document: &Document) -> BTreeMap<String, Vec<String>> {
    let schemas = document.components.iter().flat_map(|components| &components.schemas);
    let parts = schemas.filter_map(|(name, schema)| match schema {
        RefOr::T(Schema::Object(object)) => Some((name.clone(), object.properties.keys().cloned().collect())),
        _ => None,
    });
    parts.collect()
}

/// Which media types the parts of a form have.
pub fn declare_media_types(operation: &mut Operation, forms: &BTreeMap<String, Vec<String>>) {
    let Some(RefOr::T(body)) = &mut operation.request_body else { return };
    let Some(RefOr::T(content)) = body.content.get_mut("multipart/form-data") else { return };
    let Some(RefOr::Ref(form)) = &content.schema else { return };
    let Some(parts) = form.ref_location.rsplit('/').next().and_then(|name| forms.get(name)) else { return };
    let media = [
        ("spec", "application/json"),
        ("mapping", "application/json"),
        ("nodes", "text/csv, text/plain, application/octet-stream"),
        ("file", "application/octet-stream"),
    ];
    for (part, media) in media {
        if parts.contains(&part.to_owned()) {
            let encoding = EncodingBuilder::new().content_type(Some(media)).build();
            content.encoding.insert(part.into(), encoding);
        }
    }
}
