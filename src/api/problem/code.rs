//! The kinds of problems: status, stable name and title of each.

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
    /// 409: the units of an iteration are implausible and were neither corrected nor accepted.
    ImplausibleUnit,
    /// 409: a first key without the role `admin` would lock everybody out.
    FirstKeyMustBeAdmin,
    /// 409: the first request with this idempotency key still runs.
    IdempotencyKeyInUse,
    /// 409: the CSV for the control of a correction whose predicted figures lie outside their
    /// limits.
    PredictedOutsideLimits,
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
    /// 422: errors in the request, each with a pointer.
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
    /// 503: the queue of fits is full.
    Overloaded,
    /// 503: no answer within the time limit.
    RequestTimeout,
    /// 503: the store does not answer.
    StoreUnavailable,
    /// 503: the store was lost before it said whether something was stored.
    OutcomeUnknown,
    /// 503: the identity provider has not sent its keys yet.
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
        Self::ImplausibleUnit,
        Self::FirstKeyMustBeAdmin,
        Self::IdempotencyKeyInUse,
        Self::PredictedOutsideLimits,
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
        Self::Overloaded,
        Self::RequestTimeout,
        Self::StoreUnavailable,
        Self::OutcomeUnknown,
        Self::IssuerUnavailable,
        Self::Draining,
    ];

    /// Status, the URI whose last part is the code, and the title.
    pub(super) const fn parts(self) -> (u16, &'static str, &'static str) {
        match self {
            Self::MalformedBody => (400, "urn:flankfit:problem:malformed_body", "The request body cannot be read"),
            Self::MalformedRequest => (400, "urn:flankfit:problem:malformed_request", "The request cannot be read"),
            Self::Unauthorized => (401, "urn:flankfit:problem:unauthorized", "An API key or a token is needed"),
            Self::InvalidKey => (401, "urn:flankfit:problem:invalid_key", "The API key or token cannot be used"),
            Self::Forbidden => (403, "urn:flankfit:problem:forbidden", "The caller may not do this"),
            Self::CrossSite => (403, "urn:flankfit:problem:cross_site", "A web page of another site may not do this"),
            Self::NotFound => (404, "urn:flankfit:problem:not_found", "Not found"),
            Self::MethodNotAllowed => {
                (405, "urn:flankfit:problem:method_not_allowed", "The method is not available here")
            }
            Self::NotAcceptable => {
                (406, "urn:flankfit:problem:not_acceptable", "The requested media type is not available")
            }
            Self::BodyTimeout => (408, "urn:flankfit:problem:body_timeout", "The request body took too long"),
            Self::Conflict => (409, "urn:flankfit:problem:conflict", "The resource's state does not allow this"),
            Self::ImplausibleUnit => {
                (409, "urn:flankfit:problem:implausible_unit", "The units of the iteration are implausible")
            }
            Self::FirstKeyMustBeAdmin => {
                (409, "urn:flankfit:problem:first_key_must_be_admin", "The first key must be an administrator's")
            }
            Self::IdempotencyKeyInUse => (
                409,
                "urn:flankfit:problem:idempotency_key_in_use",
                "The first request with this idempotency key is still running",
            ),
            Self::PredictedOutsideLimits => (
                409,
                "urn:flankfit:problem:predicted_outside_limits",
                "Figures would lie outside their limits after the correction",
            ),
            Self::Purged => (410, "urn:flankfit:problem:purged", "The requested data were purged"),
            Self::PreconditionFailed => {
                (412, "urn:flankfit:problem:precondition_failed", "The resource has changed meanwhile")
            }
            Self::BodyTooLarge => (413, "urn:flankfit:problem:body_too_large", "The request body is too large"),
            Self::UnsupportedMediaType => {
                (415, "urn:flankfit:problem:unsupported_media_type", "The media type is not supported")
            }
            Self::UnknownHost => (421, "urn:flankfit:problem:unknown_host", "The request is for another host"),
            Self::InvalidRequest => (422, "urn:flankfit:problem:invalid_request", "The request is invalid"),
            Self::RankDeficient => (422, "urn:flankfit:problem:rank_deficient", "The columns are linearly dependent"),
            Self::NotConverged => (422, "urn:flankfit:problem:not_converged", "The computation did not converge"),
            Self::IdempotencyKeyReused => (
                422,
                "urn:flankfit:problem:idempotency_key_reused",
                "The idempotency key was used with another request",
            ),
            Self::TooManyRequests => (429, "urn:flankfit:problem:too_many_requests", "Too many requests"),
            Self::Internal => (500, "urn:flankfit:problem:internal", "Internal error"),
            Self::Overloaded => (503, "urn:flankfit:problem:overloaded", "The service is busy"),
            Self::RequestTimeout => (503, "urn:flankfit:problem:request_timeout", "The response took too long"),
            Self::StoreUnavailable => (503, "urn:flankfit:problem:store_unavailable", "The store does not respond"),
            Self::OutcomeUnknown => {
                (503, "urn:flankfit:problem:outcome_unknown", "It is not known whether something was stored")
            }
            Self::IssuerUnavailable => {
                (503, "urn:flankfit:problem:issuer_unavailable", "The identity provider does not respond")
            }
            Self::Draining => (503, "urn:flankfit:problem:draining", "The process is shutting down"),
        }
    }

    /// The HTTP status.
    pub const fn status(self) -> u16 {
        self.parts().0
    }

    /// Returns the challenge for a client without valid credentials (RFC 6750, 3).
    pub(super) const fn challenge(self) -> Option<&'static str> {
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
