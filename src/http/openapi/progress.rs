//! Operations that may take above a second are offered with progress (`Accept:
//! text/event-stream`). The document says so, and what it says is done (`http/operations.rs`).

use utoipa::openapi::{Content, OpenApi as Document, Ref, RefOr, ResponseBuilder, path::Operation};

use crate::http::layers::progress::EVENT_STREAM;

/// Operations that may take above a second and are answered with JSON.
const LONG: &str = "create_fit create_iteration create_iteration_fit import_iteration study_randomization \
    simulate_closed_loop create_surface create_iteration_surface sections_of_surface";

/// Writes the events into the document.
pub fn declare(document: &mut Document) {
    let posts = document.paths.paths.values_mut().filter_map(|item| item.post.as_mut());
    let is_long = |operation: &&mut Operation| LONG.split(' ').any(|id| operation.operation_id.as_deref() == Some(id));
    posts.filter(is_long).for_each(extend);
}

fn extend(operation: &mut Operation) {
    let events = || Content::new(Some(RefOr::Ref(Ref::from_schema_name("Progress"))));
    let described = "As `text/event-stream`: events `progress` (their `data` is a Progress), and finally one `result` \
        (the JSON body of the plain response) or `problem` (a Problem).";
    match operation.responses.responses.get_mut("200") {
        Some(RefOr::T(plain)) => {
            plain.description = format!("{} {described}", plain.description);
            plain.content.insert(EVENT_STREAM.into(), events().into());
        }
        _ => {
            let response = ResponseBuilder::new().description(described).content(EVENT_STREAM, events());
            operation.responses.responses.insert("200".into(), response.build().into());
        }
    }
}
