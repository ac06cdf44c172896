//! Invariants of every response.

use std::{collections::HashSet, fmt};

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use super::{contract::Operation, request::Request, send::Answer};

/// Seconds of wall clock, and of processor time with it, that no request may take.
pub const MOST_SECONDS: f64 = 5.0;
/// Bytes held at once in addition to those at its start.
pub const MOST_BYTES: usize = 300_000_000;

/// Violated invariant: a stable name of its kind, and a message.
pub type Finding = (&'static str, String);

pub fn answer(request: &Request, operation: Option<&Operation>, answer: &Answer, findings: &mut Vec<Finding>) {
    let text = || String::from_utf8_lossy(&answer.body[..answer.body.len().min(600)]).into_owned();
    let head = request.method == "HEAD";
    match answer.status {
        0 if request.broken_head.is_none() && request.by_wire => findings.push(("no_answer", text())),
        0 => {}
        503 => problem(request, operation, answer, findings),
        500.. => findings.push(("server_error", format!("{} {}", answer.status, text()))),
        400.. if head || request.broken_head.is_some() => {}
        400.. => problem(request, operation, answer, findings),
        200..300 if !head => sound(answer, findings),
        _ => {}
    }
}

/// A 4xx (or 503) is a problem whose pointers exist in the request.
fn problem(request: &Request, operation: Option<&Operation>, answer: &Answer, findings: &mut Vec<Finding>) {
    let text = String::from_utf8_lossy(&answer.body);
    let Ok(body) = serde_json::from_slice::<Value>(&answer.body) else {
        // the connection's own refusals of broken heads have no body
        if !(request.by_wire && answer.body.is_empty()) {
            findings.push(("no_problem", format!("{} {text}", answer.status)));
        }
        return;
    };
    if !answer.media.starts_with("application/problem+json") || body["status"] != answer.status {
        findings.push(("no_problem", format!("{} {} {text}", answer.status, answer.media)));
    }
    for key in ["type", "title", "detail", "code", "request_id"] {
        if body[key].as_str().is_none_or(str::is_empty) {
            findings.push(("no_problem", format!("without {key}: {text}")));
        }
    }
    let errors = body["errors"].as_array();
    let many = errors.map_or(0, Vec::len);
    if (answer.status == 422 && body["code"] == "invalid_request" && many == 0) || many > 100 {
        findings.push(("no_problem", format!("{many} errors: {text}")));
    }
    // with a repeated field a pointer may mean either; long bodies have their first error alone,
    // which need not be that one
    let json = request.json.as_ref().filter(|json| !has_repeated_field(json));
    let sent = json.and_then(|json| serde_json::from_slice::<Value>(json).ok());
    let parameters: Vec<&str> = operation.into_iter().flat_map(|o| &o.parameters).map(|p| p.name.as_str()).collect();
    for error in errors.into_iter().flatten() {
        let (Some(pointer), Some(detail)) = (error["pointer"].as_str(), error["detail"].as_str()) else {
            findings.push(("no_problem", format!("an error without pointer or detail: {text}")));
            continue;
        };
        if detail.trim().is_empty() || detail.len() > 2000 || detail.contains("panicked") {
            findings.push(("detail", format!("{pointer}: {detail}")));
        }
        if !(pointer.is_empty() || pointer.starts_with('/')) {
            findings.push(("pointer", format!("`{pointer}` is no JSON Pointer: {detail}")));
        }
        let first = pointer.split('/').nth(1).unwrap_or_default();
        let of_query = parameters.contains(&first) || request.target.contains('?');
        if let Some(sent) = sent.as_ref().filter(|_| !of_query && answer.status == 422)
            && !is_in_request(sent, pointer)
        {
            findings.push(("pointer", format!("`{pointer}` does not stand in the request: {detail}")));
        }
    }
}

/// True if an object of a JSON text has a field twice.
fn has_repeated_field(json: &[u8]) -> bool {
    serde_json::from_slice::<Once>(json).is_err_and(|error| error.is_data())
}

/// Any JSON without a repeated field.
struct Once;

impl<'de> Deserialize<'de> for Once {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Once)
    }
}

impl<'de> Visitor<'de> for Once {
    type Value = Once;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any JSON")
    }

    fn visit_unit<E>(self) -> Result<Once, E> {
        Ok(Once)
    }

    fn visit_bool<E>(self, _: bool) -> Result<Once, E> {
        Ok(Once)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Once, E> {
        Ok(Once)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Once, E> {
        Ok(Once)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Once, E> {
        Ok(Once)
    }

    fn visit_str<E>(self, _: &str) -> Result<Once, E> {
        Ok(Once)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Once, A::Error> {
        while entries.next_element::<Once>()?.is_some() {}
        Ok(Once)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<Once, A::Error> {
        let mut names = HashSet::new();
        while let Some(name) = fields.next_key::<String>()? {
            if !names.insert(name) {
                return Err(A::Error::custom("a field stands twice"));
            }
            fields.next_value::<Once>()?;
        }
        Ok(Once)
    }
}

/// True if a pointer names a place of the request, or a field that an object of it lacks (or one
/// within that).
fn is_in_request(sent: &Value, pointer: &str) -> bool {
    let mut end = pointer.len();
    loop {
        if let Some(found) = sent.pointer(&pointer[..end]) {
            let next = pointer[end..].split('/').nth(1);
            return match (found, next) {
                (_, None) => true,
                (Value::Object(_), Some(_)) => true,
                // one more than there are
                (Value::Array(items), Some(name)) if name.parse::<usize>().is_ok() => name.parse() == Ok(items.len()),
                // a field of what is no object: it is missing there
                (_, Some(name)) => end + 1 + name.len() == pointer.len(),
            };
        }
        let Some(shorter) = pointer[..end].rfind('/') else { return false };
        end = shorter;
    }
}

/// An answer holds no number that is none, and no `null` where a field would be left out.
fn sound(answer: &Answer, findings: &mut Vec<Finding>) {
    let media = answer.media.split(';').next().unwrap_or_default();
    if media == "application/json" {
        match serde_json::from_slice::<Value>(&answer.body) {
            Ok(body) => {
                if let Some(place) = null(&body, String::new()) {
                    findings.push(("null", format!("null stands at {place}")));
                }
            }
            Err(error) => findings.push(("no_json", error.to_string())),
        }
    } else if let Ok(text) = std::str::from_utf8(&answer.body) {
        let word = |word: &str| ["nan", "inf", "-inf", "infinity", "-infinity"].contains(&word.to_lowercase().as_str());
        let separators = |c: char| c.is_whitespace() || [',', ';', '(', ')', '='].contains(&c);
        // names in a file may be any word; measured values are among numbers
        let numbers = |line: &str| line.split(separators).any(|w| w.parse::<f64>().is_ok_and(f64::is_finite));
        if let Some(line) = text.lines().find(|line| line.split(separators).any(word) && numbers(line)) {
            findings.push(("not_finite", format!("{media}: {line}")));
        }
    }
}

/// Returns where a field of an object is `null`. Entries of lists keep the places of their
/// neighbours, and the `request` of a record is as it was sent.
fn null(value: &Value, at: String) -> Option<String> {
    match value {
        Value::Object(fields) => fields.iter().find_map(|(name, value)| {
            let at = format!("{at}/{name}");
            match value {
                Value::Null => Some(at),
                _ if name == "request" => None,
                value => null(value, at),
            }
        }),
        Value::Array(items) => items.iter().enumerate().find_map(|(k, value)| null(value, format!("{at}/{k}"))),
        _ => None,
    }
}
