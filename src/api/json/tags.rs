//! The `type` of the alternatives of a union.

use serde::Deserialize;

use super::{
    cursor::{Cursor, Token},
    slice::Slice,
    value::{read_first, read_value},
};
use crate::api::faults::Faults;

/// Declares the only value of a variant's `type`.
macro_rules! tags {
    ($($name:ident = $value:ident),* $(,)?) => {$(
        /// The variant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $value,
        }
    )*};
}

pub(in crate::api) use tags;

/// The `type` of a union.
#[derive(Deserialize)]
struct Tag<'a> {
    #[serde(rename = "type", borrow)]
    kind: Slice<'a>,
}

/// The `type` of a union; `known` says which there are.
pub fn read_tag(slice: &[u8], pointer: &str, known: &str, faults: &mut Faults) -> Option<String> {
    if let Some(other) = Cursor::new(slice).token().ok().filter(|token| *token != Token::Object) {
        faults.push(pointer, format!("expected an object, found {}", other.name()));
        return None;
    }
    let Slice(kind) = read_first::<Tag<'_>>(slice, pointer, faults)?.kind;
    let detail = match Cursor::new(kind).token() {
        Ok(Token::String) => return read_value(kind, &format!("{pointer}/type"), faults),
        Ok(other) => format!("expected a name in quotes, found {}; {known} offered", other.name()),
        Err(syntax) => syntax.what,
    };
    faults.push(format!("{pointer}/type"), detail);
    None
}

pub fn unknown_type(pointer: &str, got: &str, known: &str, faults: &mut Faults) {
    let got: String = got.chars().take(64).collect();
    faults.push(format!("{pointer}/type"), format!("`{got}` is not offered by this version; {known}"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_that_is_no_name_is_told_the_names() {
        let detail = |text: &str| {
            let mut faults = Faults::default();
            let tag = read_tag(text.as_bytes(), "/model", "a, b and c are", &mut faults);
            let fault = faults.list().first().map(|fault| (fault.pointer.clone(), fault.detail.clone()));
            (tag, fault.unwrap_or_default())
        };
        assert_eq!(detail(r#"{"type":"a","x":{}}"#).0.as_deref(), Some("a"));
        let offered = "; a, b and c are offered";
        for (text, found) in [("1", "a number"), ("[\"a\"]", "an array"), ("true", "a boolean"), ("{}", "an object")] {
            let (tag, fault) = detail(&format!("{{\"type\":{text}}}"));
            assert_eq!(tag, None);
            assert_eq!(fault, ("/model/type".into(), format!("expected a name in quotes, found {found}{offered}")));
        }
        assert_eq!(detail("{}").1, ("/model/type".into(), "missing".into()));
        assert_eq!(detail("3").1, ("/model".into(), "expected an object, found a number".into()));
    }
}
