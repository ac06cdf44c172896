//! The header `Accept`: acceptable media types, and the choice between JSON and another form.

use super::prelude::*;
use crate::{
    api::gears::quality_data::{self, Charset},
    http::endpoints::fits::json,
};

/// A form of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Json,
    Csv,
    /// Quality data.
    Dfq,
}

/// How much a client wants a media type.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Preference {
    /// From 0, not at all, to 1.
    pub quality: f32,
    /// How exactly it was named: 0 by `*/*`, 1 by `text/*`, 2 by its name.
    exactness: u8,
}

/// How much `Accept` wants a media type: by the range that names it most exactly (RFC 9110,
/// 12.5.1). Without the header all is wanted.
pub fn preference(headers: &HeaderMap, media: &str) -> Preference {
    let mut given = false;
    let mut best: Option<Preference> = None;
    let values = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok());
    for range in values.flat_map(|value| value.split(',')) {
        let mut parts = range.split(';').map(str::trim);
        let kind = parts.next().unwrap_or_default().to_ascii_lowercase();
        given = given || !kind.is_empty();
        let exactness = match kind.strip_suffix("/*") {
            _ if kind == media => 2,
            Some("*") => 0,
            Some(all) if media.split('/').next() == Some(all) => 1,
            _ => continue,
        };
        let quality = parts.find_map(|part| part.strip_prefix("q=").or(part.strip_prefix("Q=")));
        let quality = quality.map_or(Ok(1.0), str::parse).unwrap_or(0.0_f32);
        let this = Preference { quality, exactness };
        let better =
            |best: Preference| exactness > best.exactness || (exactness == best.exactness && quality > best.quality);
        if best.is_none_or(better) {
            best = Some(this);
        }
    }
    let none = Preference { quality: if given { 0.0 } else { 1.0 }, exactness: 0 };
    best.unwrap_or(none)
}

impl Format {
    fn media(self) -> &'static str {
        match self {
            Format::Json => "application/json",
            Format::Csv => "text/csv",
            Format::Dfq => quality_data::MEDIA_TYPE,
        }
    }

    /// Returns the one of JSON and another form that `Accept` prefers; JSON where it has no
    /// preference, and of two that it prefers alike the one it names more exactly. `what` begins
    /// the sentence of a refusal.
    pub fn negotiated(headers: &HeaderMap, other: Format, what: &str) -> Result<Format, Problem> {
        let [json, beside] = [Format::Json, other].map(|format| preference(headers, format.media()));
        if json.quality > 0.0 && json >= beside {
            Ok(Format::Json)
        } else if beside.quality > 0.0 {
            Ok(other)
        } else {
            let detail = format!("{what} are given as application/json or as {}.", other.media());
            Err(Problem::new(ProblemCode::NotAcceptable, detail))
        }
    }

    /// A text in this form.
    pub fn response(self, text: Vec<u8>) -> Response {
        let charset = Charset::of(&text).name();
        let mut response = json(text);
        let headers = response.headers_mut();
        match self {
            Format::Json => {}
            Format::Csv => {
                headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("text/csv; charset=utf-8"));
            }
            Format::Dfq => {
                if let Ok(media) = HeaderValue::from_str(&format!("{}; charset={charset}", self.media())) {
                    headers.insert(header::CONTENT_TYPE, media);
                }
                let file = HeaderValue::from_static("attachment; filename=\"evaluation.dfq\"");
                headers.insert(header::CONTENT_DISPOSITION, file);
            }
        }
        chosen(headers);
        response
    }
}

/// Says that the form of an answer was chosen by `Accept`.
pub fn chosen(headers: &mut HeaderMap) {
    headers.insert(header::VARY, HeaderValue::from_static("accept"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_accept_header_chooses() {
        let of = |accept: Option<&'static str>| {
            let mut headers = HeaderMap::new();
            headers.extend(accept.map(|accept| (header::ACCEPT, HeaderValue::from_static(accept))));
            Format::negotiated(&headers, Format::Csv, "Nodes").map_err(|problem| problem.status)
        };
        assert_eq!(of(None), Ok(Format::Json));
        assert_eq!(of(Some("*/*")), Ok(Format::Json));
        assert_eq!(of(Some("text/csv")), Ok(Format::Csv));
        assert_eq!(of(Some("text/csv, */*")), Ok(Format::Csv));
        assert_eq!(of(Some("text/csv;q=0.5, application/json")), Ok(Format::Json));
        assert_eq!(of(Some("application/json;q=0.1, text/csv;q=0.9")), Ok(Format::Csv));
        assert_eq!(of(Some("image/png")), Err(406));
        assert_eq!(of(Some("text/csv;q=0")), Err(406));
        assert_eq!(
            of(Some("application/json;q=0, */*")),
            Ok(Format::Csv),
            "what is named is not what a wildcard brings"
        );
        assert_eq!(of(Some("text/csv;q=0.2, */*;q=0.9")), Ok(Format::Json));
    }
}
