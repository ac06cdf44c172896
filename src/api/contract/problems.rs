//! Examples of problems by their status.

use serde_json::Value;

use crate::api::{
    faults::Faults,
    problem::{Problem, ProblemCode},
};

/// The problem that is shown under a status.
pub fn example(status: &str) -> Option<Value> {
    use ProblemCode as Code;
    let (code, detail) = match status {
        "400" => (Code::MalformedBody, "Line 1, column 14: `]` found where a value is expected."),
        "401" => (Code::Unauthorized, "Send the key as `Authorization: Bearer …` or as `x-api-key`."),
        "403" => (Code::Forbidden, "This needs the scope `decide`; this caller has `read`, `compute`."),
        "404" => (Code::NotFound, "There is no job 01938f6e-4d2c-7a10-9c3b-5f7e2a8d1c04."),
        "405" => (Code::MethodNotAllowed, "This resource offers GET, PATCH and DELETE."),
        "406" => (Code::NotAcceptable, "The response is available as application/json or text/csv."),
        "408" => (Code::BodyTimeout, "The body did not arrive within 30 s."),
        "409" => (Code::Conflict, "The job has iterations, which cannot be deleted."),
        "410" => (Code::Purged, "The job was purged; its data are in its archive only."),
        "412" => (
            Code::PreconditionFailed,
            "The resource has changed; its version is 3 now. Get it again, review the \
            changes, and repeat the request with its new ETag.",
        ),
        "413" => (Code::BodyTooLarge, "The body has more than 33554432 bytes."),
        "415" => (Code::UnsupportedMediaType, "The media type is text/plain; send application/json."),
        "421" => (Code::UnknownHost, "The header `Host` names a host that this server does not serve."),
        "422" => {
            let faults = Faults::one("/nodes/z/3/7", "expected a number, found the string \"n/a\"");
            return shown(Problem::invalid(faults));
        }
        "429" => {
            (Code::TooManyRequests, "This caller makes more requests than the server allows; try again after 1 s.")
        }
        "500" => return shown(Problem::internal("")),
        "503" => (Code::Overloaded, "The queue of fits is full; try again after 1 s."),
        _ => return None,
    };
    shown(Problem::new(code, detail))
}

fn shown(problem: Problem) -> Option<Value> {
    let request_id = Some("01938f6e-4d2c-7a10-9c3b-5f7e2a8d1c05".to_owned());
    serde_json::to_value(Problem { request_id, ..problem }).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_shows_its_own() {
        for code in ProblemCode::ALL {
            let status = code.status();
            assert_eq!(example(&status.to_string()).map(|shown| shown["status"].clone()), Some(status.into()));
        }
        assert_eq!(example("200"), None);
    }
}
