//! Errors as the contract gives them: `application/problem+json` (RFC 9457).
//!
//! `code` is stable and made for programs; `detail` is made for people. What happened inside
//! (`cause`) is logged and never sent.

mod code;

use std::{borrow::Cow, fmt::Display};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::{
    faults::{Fault, Faults, pointer_of},
    json::{error::ReadError, writer::NotFinite},
};
use flankfit_engine::estimation::FitError;

pub use code::ProblemCode;

/// An error. `application/problem+json` (RFC 9457).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Problem {
    /// URI that identifies the kind of problem; ends in `code`.
    #[serde(rename = "type")]
    #[schema(value_type = String, format = "uri", example = "urn:flankfit:problem:invalid_request")]
    pub kind: Cow<'static, str>,
    /// The kind of problem in words; the same for every occurrence.
    #[schema(value_type = String, example = "The request is invalid")]
    pub title: Cow<'static, str>,
    /// The HTTP status.
    #[schema(example = 422)]
    pub status: u16,
    /// Stable name of the kind of problem.
    #[schema(value_type = String, example = "invalid_request")]
    pub code: Cow<'static, str>,
    /// The error and its remedy. For errors in the request: the first one with its pointer, and the
    /// number of further ones.
    pub detail: String,
    /// Every error of the request (at most 100), by its place.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ProblemError>,
    /// Number of errors that are not listed.
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
    /// The internal cause; logged, never sent.
    #[serde(skip)]
    pub cause: Option<String>,
}

/// Asks for the memory that an answer takes, where a short request can ask for a long one.
pub type Room<'a> = &'a mut dyn FnMut(usize) -> Result<(), Problem>;

/// An error, by its place in the request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ProblemError {
    /// JSON Pointer (RFC 6901) into the request.
    #[schema(example = "/nodes/z/3/7")]
    pub pointer: String,
    /// The error at this place and its remedy.
    pub detail: String,
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

    /// Returns true if it is of this kind.
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

    /// Sets the detail to the first error with its pointer, and the number of further ones.
    fn summed_up(mut self) -> Self {
        let Some(first) = self.errors.first() else { return self };
        let place = if first.pointer.is_empty() { String::new() } else { format!("{}: ", first.pointer) };
        let message = first.detail.trim_end_matches('.');
        let (stop, and, the) = if message.ends_with('?') { ("", " And", " The") } else { (".", "; and", "; the") };
        self.detail = match (self.errors.len() - 1, self.unlisted) {
            (0, 0) => format!("{place}{message}{stop}"),
            (1, 0) => format!("{place}{message}{and} 1 more error, see `errors`."),
            (more, 0) => format!("{place}{message}{and} {more} more errors, see `errors`."),
            (more, unlisted) => {
                let all = more + 1 + unlisted;
                format!("{place}{message}{the} first of {all} errors, of which `errors` lists {}.", more + 1)
            }
        };
        self
    }

    /// A fit that was refused; `place` makes pointers into the request of its paths.
    pub fn of_fit(error: FitError, place: impl Fn(&str) -> String) -> Self {
        match error {
            FitError::Invalid(faults) | FitError::ExceedsDouble(faults) => {
                Problem::invalid(Faults::placed(&faults, place))
            }
            FitError::RankDeficient { rank, columns, terms } => Problem {
                errors: vec![ProblemError {
                    pointer: place("model"),
                    detail: format!("linearly dependent terms: {}", terms.join(", ")),
                }],
                ..Problem::new(
                    ProblemCode::RankDeficient,
                    format!(
                        "The nodes determine only {rank} of {columns} coefficients; these terms depend on each other: \
                         {}. Spectral regularisation divides by the smallest eigenvalue, which is 0 here: use \
                         ridge, omit terms, or measure more nodes.",
                        terms.join(", ")
                    ),
                )
            },
            FitError::NotConverged(what) => Problem {
                errors: what
                    .path()
                    .map(|path| ProblemError { pointer: place(path), detail: what.to_string() })
                    .into_iter()
                    .collect(),
                ..Problem::new(ProblemCode::NotConverged, what.to_string())
            },
        }
    }

    /// Moves errors at `place` and below to `asked`, for data that the request named and that
    /// turned out to be wrong.
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
        Problem::new(ProblemCode::Internal, "The server has failed; the error is logged under the request id.")
            .caused_by(cause)
    }

    /// Returns 422 for a number of the answer that leaves the range of doubles, which data of
    /// sensible magnitude never do.
    pub fn not_finite(error: NotFinite) -> Self {
        Problem::invalid(Faults::one("", error.to_string()))
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
        Problem::of_fit(error, pointer_of)
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
    fn the_detail_begins_with_the_first_error() {
        let mut faults = Faults::default();
        let mut said = |pointer: &str, detail: &str| {
            faults.push(pointer, detail);
            Problem::invalid(faults.clone()).detail
        };
        assert_eq!(said("/nodes/z/3/7", "expected a number"), "/nodes/z/3/7: expected a number.");
        assert_eq!(said("/a", "b"), "/nodes/z/3/7: expected a number; and 1 more error, see `errors`.");
        assert_eq!(said("/c", "d"), "/nodes/z/3/7: expected a number; and 2 more errors, see `errors`.");
        (3..120).for_each(|_| drop(said("/e", "f")));
        let many = Problem::invalid(faults.clone());
        let told = "/nodes/z/3/7: expected a number; the first of 120 errors, of which `errors` lists 100.";
        assert_eq!(many.detail, told);
        assert_eq!(Problem::invalid(Faults::one("", "expected an object.")).detail, "expected an object.");
    }

    #[test]
    fn long_input_is_shortened_in_problems() {
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
    fn members_of_a_missing_object_are_not_reported() {
        let mut faults = Faults::default();
        for (pointer, detail) in [("/gear", "missing"), ("/gear/teeth", "missing"), ("/gears", "missing")] {
            faults.push_missing(pointer, detail);
        }
        let pointers: Vec<_> = Problem::invalid(faults).errors.into_iter().map(|error| error.pointer).collect();
        assert_eq!(pointers, ["/gear", "/gears"]);
        let mut faults = Faults::default();
        faults.push_missing("/nodes", "missing; give nodes");
        faults.push("", "expected an object, found an array");
        assert_eq!(Problem::invalid(faults).errors.len(), 1);
    }

    #[test]
    fn internal_causes_are_not_serialized() {
        let text = serde_json::to_string(&Problem::internal("secret path").retry_after(3)).unwrap();
        assert!(!text.contains("secret") && !text.contains("cause") && !text.contains("null"), "{text}");
    }
}
