//! Responses as JSON text: no white space, shortest numbers that read back as the same double.

use memchr::memmem;
use serde::Serialize;

use super::null_fields::NullFields;

/// A number of an answer that JSON cannot hold, with its field or the field of its list.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` of the result exceeds the range of double precision: check the magnitudes and units of the request")]
pub struct NotFinite(pub String);

/// Returns the text that serde writes of an answer, if every number in it is finite.
pub fn whole(answer: &impl Serialize) -> Result<Vec<u8>, NotFinite> {
    whole_of(16 << 10, answer)
}

/// Returns the same text, of about so many bytes.
pub fn whole_of(bytes: usize, answer: &impl Serialize) -> Result<Vec<u8>, NotFinite> {
    let mut text = Vec::with_capacity(bytes);
    let written = serde_json::to_writer(&mut text, answer);
    if written.is_err() || memmem::find(&text, b"null").is_some() {
        let mut fields = NullFields::default();
        let again = answer.serialize(&mut serde_json::Serializer::with_formatter(std::io::sink(), &mut fields));
        if let Some(culprit) = fields.culprit.or_else(|| again.err().map(|_| fields.key)) {
            return Err(NotFinite(culprit));
        }
    }
    Ok(text)
}

/// Returns the text that serde writes of a value of the contract. serde_json fails where a key is
/// no string or an `impl Serialize` of one's own says so, and the contract has neither.
pub fn text_of(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("types of the contract can always be written")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::shapes::places::Values;

    #[test]
    fn a_number_that_json_cannot_hold_is_named() {
        let body = |x: f64| std::collections::BTreeMap::from([("a", 1.0), ("b", x)]);
        assert_eq!(whole(&body(2.5)).unwrap(), br#"{"a":1.0,"b":2.5}"#);
        assert_eq!(whole(&[None, Some(1.5)]).unwrap(), b"[null,1.5]", "a place of a list may be empty");
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(whole(&[body(1.0), body(wrong)]), Err(NotFinite("b".to_owned())));
            let values = |x| std::collections::BTreeMap::from([("a", Values::from(vec![1.0])), ("b", vec![x].into())]);
            assert_eq!(whole(&values(wrong)), Err(NotFinite("b".to_owned())));
        }
        assert_eq!(whole(&Values { width: 2, flat: vec![1.0, 2.0, 3.0, 4.0] }).unwrap(), b"[[1.0,2.0],[3.0,4.0]]");
    }
}
