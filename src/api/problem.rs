//! Errors as the contract gives them: `application/problem+json` (RFC 9457).
//!
//! `code` is stable and made for programs; `detail` is made for people. What happened inside
//! (`cause`) is logged and never sent.

use std::{borrow::Cow, fmt::Display};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{
    faults::{self, Fault, Faults},
    json::{error::ReadError, writer::NotFinite},
};
use flankfit_engine::estimation::{Field, FitError};

/// An error. `application/problem+json` (RFC 9457).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Problem {
    /// URI that identifies the kind of problem; ends in `code`.
    #[serde(rename = "type")]
    #[schema(value_type = String, format = "uri", example = "urn:flankfit:problem:invalid_request")]
    pub kind: Cow<'static, str>,
    /// The kind of problem in words; the same for every occurrence.
    #[schema(value_type = String, example = "The request holds what cannot be accepted")]
    pub title: Cow<'static, str>,
    /// The HTTP status.
    #[schema(example = 422)]
    pub status: u16,
    /// Stable name of the kind of problem.
    #[schema(value_type = String, example = "invalid_request")]
    pub code: Cow<'static, str>,
    /// What is wrong this time and what to do about it. Of faults in the request: the first with
    /// its place, and how many more there are.
    pub detail: String,
    /// Every fault found in the request (the first 100), by its place.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ProblemError>,
    /// Faults beyond those listed.
    #[serde(skip)]
    pub unlisted: usize,
    /// Id of the request, as in the header `x-request-id`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// Seconds for the header `Retry-After`.
    #[serde(skip)]
    pub retry_after: Option<u32>,
    /// The header `WWW-Authenticate`.
    #[serde(skip)]
    pub challenge: Option<&'static str>,
    /// What happened inside; logged, never sent.
    #[serde(skip)]
    pub cause: Option<String>,
}

/// Asks for the memory that an answer takes, where a short request can ask for a long one.
pub type Room<'a> = &'a mut dyn FnMut(usize) -> Result<(), Problem>;

/// One fault, by its place in the request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ProblemError {
    /// JSON Pointer (RFC 6901) into the request.
    #[schema(example = "/nodes/z/3/7")]
    pub pointer: String,
    /// What is wrong there.
    pub detail: String,
}

/// Every kind of problem there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemCode {
    /// 400: the body, its compression or its form cannot be read.
    MalformedBody,
    /// 400: a header or the query cannot be read.
    MalformedRequest,
    /// 401: no API key.
    Unauthorized,
    /// 401: an API key or a token that is not known, or no longer.
    InvalidKey,
    /// 403: the caller may not do this.
    Forbidden,
    /// 403: a web page of another site asks for a change.
    CrossSite,
    /// 404.
    NotFound,
    /// 405.
    MethodNotAllowed,
    /// 406.
    NotAcceptable,
    /// 408: the body did not arrive in time.
    BodyTimeout,
    /// 409: the resource's state does not allow it.
    Conflict,
    /// 409: the first request with this idempotency key still runs.
    IdempotencyKeyInUse,
    /// 409: the operation has not ended.
    OperationRunning,
    /// 410: the operation was cancelled.
    OperationCancelled,
    /// 410: what is asked for was purged.
    Purged,
    /// 412: `If-Match` names another version.
    PreconditionFailed,
    /// 413.
    BodyTooLarge,
    /// 415.
    UnsupportedMediaType,
    /// 421: the request names a host that this server is not.
    UnknownHost,
    /// 422: faults in the request, each with a pointer.
    InvalidRequest,
    /// 422: dependent columns where the method needs independent ones.
    RankDeficient,
    /// 422: an iteration did not end within its limit.
    NotConverged,
    /// 422: the idempotency key was used with another body.
    IdempotencyKeyReused,
    /// 429.
    TooManyRequests,
    /// 500.
    Internal,
    /// 500: an operation whose servers were lost, again and again.
    Interrupted,
    /// 503: the queue of fits is full.
    Overloaded,
    /// 503: no answer within the time limit.
    RequestTimeout,
    /// 503: the store does not answer.
    StoreUnavailable,
    /// 503: the store was lost before it said whether something was stored.
    OutcomeUnknown,
    /// 503: the identity provider has not told its keys yet.
    IssuerUnavailable,
    /// 503: the process is about to end.
    Draining,
}

impl ProblemCode {
    /// Every code.
    pub const ALL: [ProblemCode; 32] = [
        Self::MalformedBody,
        Self::MalformedRequest,
        Self::Unauthorized,
        Self::InvalidKey,
        Self::Forbidden,
        Self::CrossSite,
        Self::NotFound,
        Self::MethodNotAllowed,
        Self::NotAcceptable,
        Self::BodyTimeout,
        Self::Conflict,
        Self::IdempotencyKeyInUse,
        Self::OperationRunning,
        Self::OperationCancelled,
        Self::Purged,
        Self::PreconditionFailed,
        Self::BodyTooLarge,
        Self::UnsupportedMediaType,
        Self::UnknownHost,
        Self::InvalidRequest,
        Self::RankDeficient,
        Self::NotConverged,
        Self::IdempotencyKeyReused,
        Self::TooManyRequests,
        Self::Internal,
        Self::Interrupted,
        Self::Overloaded,
        Self::RequestTimeout,
        Self::StoreUnavailable,
        Self::OutcomeUnknown,
        Self::IssuerUnavailable,
        Self::Draining,
    ];

    /// Status, the URI whose last part is the code, and the title.
    const fn parts(self) -> (u16, &'static str, &'static str) {
        match self {
            Self::MalformedBody => (400, "urn:flankfit:problem:malformed_body", "The request body cannot be read"),
            Self::MalformedRequest => (400, "urn:flankfit:problem:malformed_request", "The request cannot be read"),
            Self::Unauthorized => (401, "urn:flankfit:problem:unauthorized", "An API key or a token is needed"),
            Self::InvalidKey => (401, "urn:flankfit:problem:invalid_key", "The API key or token cannot be used"),
            Self::Forbidden => (403, "urn:flankfit:problem:forbidden", "The caller may not do this"),
            Self::CrossSite => (403, "urn:flankfit:problem:cross_site", "A web page of another site may not do this"),
            Self::NotFound => (404, "urn:flankfit:problem:not_found", "There is nothing here"),
            Self::MethodNotAllowed => {
                (405, "urn:flankfit:problem:method_not_allowed", "The method is not offered here")
            }
            Self::NotAcceptable => (406, "urn:flankfit:problem:not_acceptable", "The wanted form is not offered here"),
            Self::BodyTimeout => (408, "urn:flankfit:problem:body_timeout", "The request body took too long"),
            Self::Conflict => (409, "urn:flankfit:problem:conflict", "The resource's state does not allow this"),
            Self::IdempotencyKeyInUse => (
                409,
                "urn:flankfit:problem:idempotency_key_in_use",
                "The first request with this idempotency key is still running",
            ),
            Self::OperationRunning => {
                (409, "urn:flankfit:problem:operation_running", "The operation has not ended yet")
            }
            Self::OperationCancelled => {
                (410, "urn:flankfit:problem:operation_cancelled", "The operation was cancelled")
            }
            Self::Purged => (410, "urn:flankfit:problem:purged", "What is asked for was purged"),
            Self::PreconditionFailed => {
                (412, "urn:flankfit:problem:precondition_failed", "The resource has changed meanwhile")
            }
            Self::BodyTooLarge => (413, "urn:flankfit:problem:body_too_large", "The request body is too large"),
            Self::UnsupportedMediaType => {
                (415, "urn:flankfit:problem:unsupported_media_type", "The media type is not supported")
            }
            Self::UnknownHost => (421, "urn:flankfit:problem:unknown_host", "The request is for another host"),
            Self::InvalidRequest => {
                (422, "urn:flankfit:problem:invalid_request", "The request holds what cannot be accepted")
            }
            Self::RankDeficient => (422, "urn:flankfit:problem:rank_deficient", "The columns are linearly dependent"),
            Self::NotConverged => (422, "urn:flankfit:problem:not_converged", "The computation did not converge"),
            Self::IdempotencyKeyReused => (
                422,
                "urn:flankfit:problem:idempotency_key_reused",
                "The idempotency key was used with another request",
            ),
            Self::TooManyRequests => (429, "urn:flankfit:problem:too_many_requests", "Too many requests"),
            Self::Internal => (500, "urn:flankfit:problem:internal", "Something went wrong inside the service"),
            Self::Interrupted => {
                (500, "urn:flankfit:problem:interrupted", "The operation was interrupted again and again")
            }
            Self::Overloaded => (503, "urn:flankfit:problem:overloaded", "The service is busy"),
            Self::RequestTimeout => (503, "urn:flankfit:problem:request_timeout", "The answer took too long"),
            Self::StoreUnavailable => (503, "urn:flankfit:problem:store_unavailable", "The store does not answer"),
            Self::OutcomeUnknown => {
                (503, "urn:flankfit:problem:outcome_unknown", "It is not known whether something was stored")
            }
            Self::IssuerUnavailable => {
                (503, "urn:flankfit:problem:issuer_unavailable", "The identity provider does not answer")
            }
            Self::Draining => (503, "urn:flankfit:problem:draining", "The process is about to end"),
        }
    }

    /// The HTTP status.
    pub const fn status(self) -> u16 {
        self.parts().0
    }

    /// What a client is told that is not let in (RFC 6750, 3).
    const fn challenge(self) -> Option<&'static str> {
        match self {
            Self::Unauthorized => Some("Bearer"),
            Self::InvalidKey => Some("Bearer error=\"invalid_token\""),
            _ => None,
        }
    }

    /// The stable name.
    pub fn name(self) -> &'static str {
        let uri = self.parts().1;
        uri.rsplit(':').next().unwrap_or(uri)
    }
}

impl Problem {
    pub fn new(code: ProblemCode, detail: impl Into<String>) -> Self {
        let (status, uri, title) = code.parts();
        Problem {
            kind: uri.into(),
            title: title.into(),
            status,
            code: code.name().into(),
            detail: detail.into(),
            errors: Vec::new(),
            unlisted: 0,
            request_id: None,
            retry_after: None,
            challenge: code.challenge(),
            cause: None,
        }
    }

    /// Whether it is of this kind.
    pub fn is(&self, code: ProblemCode) -> bool {
        self.code == code.name()
    }

    /// 422 with every fault by its place.
    pub fn invalid(faults: impl Into<Faults>) -> Self {
        let faults = faults.into();
        let list = faults.list();
        // What is missing within something that is not there, or is no object, is not said again.
        let follows = |fault: &Fault| {
            let within = |other: &Fault| {
                let rest = fault.pointer.strip_prefix(other.pointer.as_str());
                rest.is_some_and(|rest| rest.starts_with('/'))
            };
            fault.missing && list.iter().any(within)
        };
        let told = list.iter().filter(|fault| !follows(fault));
        let errors: Vec<ProblemError> = told
            .map(|fault| ProblemError {
                pointer: short_pointer(&fault.pointer).to_owned(),
                detail: shortened(&fault.detail),
            })
            .collect();
        let unlisted = faults.count() - list.len();
        Problem { errors, unlisted, ..Problem::new(ProblemCode::InvalidRequest, "") }.summed_up()
    }

    /// The first fault with its place, and how many more there are: what a log needs.
    fn summed_up(mut self) -> Self {
        let Some(first) = self.errors.first() else { return self };
        let place = if first.pointer.is_empty() { String::new() } else { format!("{}: ", first.pointer) };
        let told = first.detail.trim_end_matches('.');
        let stop = if told.ends_with('?') { "" } else { "." };
        self.detail = match (self.errors.len() - 1, self.unlisted) {
            (0, 0) => format!("{place}{told}{stop}"),
            (1, 0) => format!("{place}{told}; and 1 fault more, see `errors`."),
            (more, 0) => format!("{place}{told}; and {more} faults more, see `errors`."),
            (more, unlisted) => {
                let all = more + 1 + unlisted;
                format!("{place}{told}; the first of {all} faults, of which `errors` lists {}.", more + 1)
            }
        };
        self
    }

    /// A fit that was refused; `place` says where in the request its fields stand.
    pub fn of_fit(error: FitError, place: impl Fn(&Field) -> String) -> Self {
        match error {
            FitError::Invalid(faults) => Problem::invalid(Faults::by(&faults, place)),
            FitError::RankDeficient { rank, columns, terms } => Problem {
                errors: vec![ProblemError {
                    pointer: place(&Field::Model),
                    detail: format!("linearly dependent terms: {}", terms.join(", ")),
                }],
                ..Problem::new(
                    ProblemCode::RankDeficient,
                    format!(
                        "The nodes determine only {rank} of {columns} coefficients; these terms depend on each other: \
                         {}. \
                         Spectral regularisation divides by the smallest eigenvalue, which is 0 here: ask for ridge, \
                         leave terms out, or measure more nodes.",
                        terms.join(", ")
                    ),
                )
            },
            FitError::NotConverged(what) => Problem {
                errors: what
                    .field()
                    .map(|field| ProblemError { pointer: place(&field), detail: what.to_string() })
                    .into_iter()
                    .collect(),
                ..Problem::new(ProblemCode::NotConverged, what.to_string())
            },
        }
    }

    /// The same with faults at `place` and below it said to be at `asked`: where what the request
    /// names was looked up, and what was found is at fault.
    pub fn moved(mut self, place: &str, asked: &str) -> Self {
        for error in self.errors.iter_mut().filter(|error| error.pointer.starts_with(place)) {
            error.pointer = asked.to_owned();
        }
        self.errors.dedup();
        if self.is(ProblemCode::InvalidRequest) { self.summed_up() } else { self }
    }

    /// 403: the caller lacks a scope.
    pub fn lacking_scope(detail: impl Into<String>) -> Self {
        let challenge = Some("Bearer error=\"insufficient_scope\"");
        Problem { challenge, ..Problem::new(ProblemCode::Forbidden, detail) }
    }

    /// 500: the cause goes to the log, nothing of it to the client.
    pub fn internal(cause: impl Display) -> Self {
        Problem::new(ProblemCode::Internal, "The fault is on this side; it has been logged under the request id.")
            .caused_by(cause)
    }

    /// 422: a number of the answer is beyond doubles, which data of sensible magnitude never lead
    /// to.
    pub fn not_finite(fault: NotFinite) -> Self {
        Problem::invalid(Faults::one("", fault.to_string()))
    }

    /// Keeps what happened inside for the log.
    pub fn caused_by(mut self, cause: impl Display) -> Self {
        self.cause = Some(cause.to_string());
        self
    }

    /// Tells the client when to try again.
    pub fn retry_after(mut self, seconds: u32) -> Self {
        self.retry_after = Some(seconds);
        self
    }
}

/// Bytes of a detail and of a pointer that are sent; what a request says is not said again at any
/// length.
const LONGEST: usize = 600;

fn shortened(detail: &str) -> String {
    if detail.len() <= LONGEST {
        return detail.to_owned();
    }
    let half = LONGEST / 2 - 2;
    let (begin, end) = (detail.floor_char_boundary(half), detail.ceil_char_boundary(detail.len() - half));
    format!("{}…{}", &detail[..begin], &detail[end..])
}

/// A pointer that ends at the last whole name that is not too long.
fn short_pointer(pointer: &str) -> &str {
    match pointer.char_indices().take_while(|(at, _)| *at <= LONGEST).filter(|(_, c)| *c == '/').last() {
        Some((slash, _)) if pointer.len() > LONGEST => &pointer[..slash],
        _ => pointer,
    }
}

impl From<FitError> for Problem {
    fn from(error: FitError) -> Self {
        Problem::of_fit(error, faults::Field::pointer)
    }
}

impl From<ReadError> for Problem {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Malformed { detail } => Problem::new(ProblemCode::MalformedBody, detail),
            ReadError::Invalid(faults) => Problem::invalid(faults),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_distinct_and_in_the_uri() {
        let mut names: Vec<_> = ProblemCode::ALL.iter().map(|code| code.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), ProblemCode::ALL.len());
        let problem = Problem::new(ProblemCode::Conflict, "x");
        assert_eq!((problem.status, problem.code.as_ref()), (409, "conflict"));
        assert!(problem.kind.ends_with(problem.code.as_ref()));
    }

    #[test]
    fn the_first_fault_stands_in_the_detail() {
        let mut faults = Faults::default();
        let mut said = |pointer: &str, detail: &str| {
            faults.push(pointer, detail);
            Problem::invalid(faults.clone()).detail
        };
        assert_eq!(said("/nodes/z/3/7", "expected a number"), "/nodes/z/3/7: expected a number.");
        assert_eq!(said("/a", "b"), "/nodes/z/3/7: expected a number; and 1 fault more, see `errors`.");
        assert_eq!(said("/c", "d"), "/nodes/z/3/7: expected a number; and 2 faults more, see `errors`.");
        (3..120).for_each(|_| drop(said("/e", "f")));
        let many = Problem::invalid(faults.clone());
        let told = "/nodes/z/3/7: expected a number; the first of 120 faults, of which `errors` lists 100.";
        assert_eq!(many.detail, told);
        assert_eq!(Problem::invalid(Faults::one("", "expected an object.")).detail, "expected an object.");
    }

    #[test]
    fn what_a_request_says_is_not_said_again_at_length() {
        let mut faults = Faults::default();
        faults.push("/type", format!("`{}é` is not known; expected `a` or `b`", "x".repeat(50_000)));
        faults.push(format!("/a/{}", "é".repeat(5_000)), "there is no such field");
        faults.push(format!("/{}", "a/".repeat(5_000)), "deep");
        let problem = Problem::invalid(faults);
        let [long, field, deep] = &problem.errors[..] else { panic!("{problem:?}") };
        assert!(long.detail.len() <= LONGEST && long.detail.ends_with("expected `a` or `b`"), "{}", long.detail);
        assert_eq!(field.pointer, "/a");
        assert!(deep.pointer.len() <= LONGEST && deep.pointer.ends_with("/a"), "{}", deep.pointer);
    }

    #[test]
    fn what_is_missing_in_what_is_missing_is_not_said() {
        let mut faults = Faults::default();
        for (pointer, detail) in [("/gear", "missing"), ("/gear/teeth", "missing"), ("/gears", "missing")] {
            faults.push_missing(pointer, detail);
        }
        let told: Vec<_> = Problem::invalid(faults).errors.into_iter().map(|error| error.pointer).collect();
        assert_eq!(told, ["/gear", "/gears"]);
        let mut faults = Faults::default();
        faults.push_missing("/nodes", "missing; give nodes");
        faults.push("", "expected an object, found an array");
        assert_eq!(Problem::invalid(faults).errors.len(), 1);
    }

    #[test]
    fn what_happened_inside_is_not_written() {
        let text = serde_json::to_string(&Problem::internal("secret path").retry_after(3)).unwrap();
        assert!(!text.contains("secret") && !text.contains("cause") && !text.contains("null"), "{text}");
    }
}
