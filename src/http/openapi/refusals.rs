//! Responses of the layers below a handler.

use utoipa::openapi::{
    Content, HeaderBuilder, ObjectBuilder, Ref, RefOr, Response, ResponseBuilder,
    path::{Operation, Parameter},
    schema::Type,
};

use crate::api::contract;

/// Names, statuses and descriptions of the responses that many operations share
/// (`components/responses`).
const SHARED: [(&str, &str, &str); 18] = [
    ("Unreadable", "400", "The body or its compression cannot be read; `detail` has the place."),
    ("Unauthorized", "401", "No API key or token was sent, or one that cannot be used."),
    (
        "Forbidden",
        "403",
        "The caller lacks the scope that `detail` names, or the request comes from a web page of another site.",
    ),
    ("NotFound", "404", "There is no such resource."),
    ("NotAcceptable", "406", "None of the media types in the header `Accept` is available."),
    ("BodyTimeout", "408", "The body did not arrive in time."),
    ("KeyInUse", "409", "The first request with this idempotency key is still running."),
    ("Purged", "410", "The job was purged; `detail` has time and reason."),
    ("Changed", "412", "The resource has changed meanwhile."),
    ("BodyTooLarge", "413", "The body is too large (counted after decompression)."),
    ("UnsupportedMediaType", "415", "The media type or the compression is not supported."),
    ("Misdirected", "421", "The header `Host` names a host that this server does not serve."),
    ("Invalid", "422", "The request is invalid; `errors` points to every error."),
    ("InvalidPage", "422", "The limit or the cursor is invalid."),
    ("InvalidQuery", "422", "The query has an unknown or a repeated parameter."),
    ("TooManyRequests", "429", "The caller makes too many requests; try again after `Retry-After` seconds."),
    ("Internal", "500", "The server has failed; nothing was stored."),
    ("Unavailable", "503", "Busy, or no response in time; try again after `Retry-After` seconds."),
];

/// Refers to what the layers below a handler may answer, where the handler has not said more about
/// it.
pub fn declare(path: &str, operation: &mut Operation) {
    let versioned = path.starts_with("/v1/");
    let (keyed, listed) = (has_parameter(operation, "Idempotency-Key"), has_parameter(operation, "cursor"));
    let body = operation.request_body.is_some();
    let good = operation.responses.responses.iter().filter(|(status, _)| status.starts_with('2'));
    let represented = good.into_iter().any(|(_, r)| matches!(r, RefOr::T(response) if !response.content.is_empty()));
    let (purged, conditional) = (holds_what_is_purged(path, operation), has_parameter(operation, "If-Match"));
    let may_be = |name: &str| match name {
        "Unreadable" | "BodyTimeout" | "BodyTooLarge" | "UnsupportedMediaType" | "Invalid" => versioned && body,
        "Unauthorized" | "Forbidden" | "TooManyRequests" => versioned,
        "NotFound" => versioned && path.contains('{'),
        "NotAcceptable" => represented,
        "KeyInUse" => keyed,
        "Purged" => purged,
        "Changed" => conditional,
        "InvalidPage" => listed,
        _ => true,
    };
    for (name, status, _) in SHARED.into_iter().filter(|(name, _, _)| may_be(name)) {
        let reference = || RefOr::Ref(Ref::from_response_name(name));
        operation.responses.responses.entry(status.into()).or_insert_with(reference);
    }
}

/// Returns the shared responses by their names.
pub fn shared() -> impl Iterator<Item = (String, RefOr<Response>)> {
    SHARED.into_iter().map(|(name, status, description)| {
        let response = ResponseBuilder::new().description(description);
        let mut response = response.content("application/problem+json", problem(status));
        if matches!(status, "429" | "503") {
            let seconds = ObjectBuilder::new().schema_type(Type::Integer);
            let header = HeaderBuilder::new().schema(Some(seconds)).description(Some("Seconds to wait.")).build();
            response = response.header("Retry-After", header);
        }
        let mut response = response.build();
        request_id(&mut response);
        (name.to_owned(), response.into())
    })
}

/// Adds the header with the id of the request.
pub fn request_id(response: &mut Response) {
    let header = super::text_header("Id of the request: the caller's own, or a new UUIDv7.");
    response.headers.insert("x-request-id".into(), header);
}

/// Whether an operation needs what a purge takes away, or writes to a job.
fn holds_what_is_purged(path: &str, operation: &Operation) -> bool {
    const OF_WHAT_STAYS: [&str; 4] = ["get_iteration", "list_iteration_fits", "list_iteration_records", "get_job"];
    const OF_JOBS: [&str; 3] = ["update_job", "delete_job", "import_iteration"];
    let id = operation.operation_id.as_deref().unwrap_or_default();
    const PLACES: [&str; 4] = [
        "/v1/jobs/{job_id}/iterations",
        "/v1/jobs/{job_id}/correction",
        "/v1/jobs/{job_id}/streams",
        "/v1/streams/{stream_id}",
    ];
    let within = PLACES.iter().any(|place| path.starts_with(place));
    OF_JOBS.contains(&id) || within && !OF_WHAT_STAYS.contains(&id)
}

/// Whether an operation has a parameter of this name.
pub fn has_parameter(operation: &Operation, name: &str) -> bool {
    let is_it = |parameter: &RefOr<Parameter>| matches!(parameter, RefOr::T(one) if one.name == name);
    operation.parameters.iter().flatten().any(is_it)
}

/// Declares that a refusal of a handler has a problem of its status as its body.
pub fn have_problems(operation: &mut Operation) {
    for (status, response) in &mut operation.responses.responses {
        if let RefOr::T(response) = response
            && status.starts_with(['4', '5'])
        {
            response.content.insert("application/problem+json".into(), problem(status).into());
        }
    }
}

fn problem(status: &str) -> Content {
    let mut content = Content::new(Some(RefOr::Ref(Ref::from_schema_name("Problem"))));
    content.example = contract::problem_example(status);
    content
}
