//! JSON or CSV, as the `Accept` header prefers.

use axum::{
    http::{HeaderMap, HeaderValue, header},
    response::Response,
};

use super::fits::json;
use crate::api::problem::{Problem, ProblemCode};

/// A form of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Json,
    Csv,
}

impl Form {
    /// What `Accept` prefers; JSON where it has no preference. `what` begins the sentence of a refusal.
    pub fn wanted(headers: &HeaderMap, what: &str) -> Result<Form, Problem> {
        let mut given = false;
        let (mut json, mut csv) = (0.0_f32, 0.0_f32);
        for range in
            headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok()).flat_map(|v| v.split(','))
        {
            let mut parts = range.split(';').map(str::trim);
            let kind = parts.next().unwrap_or_default().to_ascii_lowercase();
            let weight = parts.find_map(|part| part.strip_prefix("q=")).map_or(Ok(1.0), str::parse).unwrap_or(0.0_f32);
            given = given || !kind.is_empty();
            // A wildcard counts a little less, so that a named type wins over it.
            match kind.as_str() {
                "application/json" => json = json.max(weight),
                "text/csv" => csv = csv.max(weight),
                "*/*" | "application/*" => json = json.max(weight * 0.99),
                "text/*" => csv = csv.max(weight * 0.98),
                _ => {}
            }
        }
        if !given || (json > 0.0 && json >= csv) {
            Ok(Form::Json)
        } else if csv > 0.0 {
            Ok(Form::Csv)
        } else {
            Err(Problem::new(
                ProblemCode::NotAcceptable,
                format!("{what} are given as application/json or as text/csv."),
            ))
        }
    }

    /// A text in this form.
    pub fn response(self, text: Vec<u8>) -> Response {
        let mut response = json(text);
        let headers = response.headers_mut();
        if self == Form::Csv {
            headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("text/csv; charset=utf-8"));
        }
        headers.insert(header::VARY, HeaderValue::from_static("accept"));
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_accept_header_chooses() {
        let of = |accept: Option<&'static str>| {
            let mut headers = HeaderMap::new();
            headers.extend(accept.map(|accept| (header::ACCEPT, HeaderValue::from_static(accept))));
            Form::wanted(&headers, "Nodes").map_err(|problem| problem.status)
        };
        assert_eq!(of(None), Ok(Form::Json));
        assert_eq!(of(Some("*/*")), Ok(Form::Json));
        assert_eq!(of(Some("text/csv")), Ok(Form::Csv));
        assert_eq!(of(Some("text/csv, */*")), Ok(Form::Csv));
        assert_eq!(of(Some("text/csv;q=0.5, application/json")), Ok(Form::Json));
        assert_eq!(of(Some("application/json;q=0.1, text/csv;q=0.9")), Ok(Form::Csv));
        assert_eq!(of(Some("image/png")), Err(406));
        assert_eq!(of(Some("text/csv;q=0")), Err(406));
    }
}
