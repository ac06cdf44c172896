//! Where `null` may stand in a request: among the entries of arrays, for what was not measured, and
//! nowhere else.
//!
//! What each array makes of it is for the reader of that array to say. A field that is `null` is
//! refused here, for all requests alike; were it taken for one that is left out, a caller's mistake
//! would become a default without a word.

use super::{
    cursor::{Cursor, Syntax, Token},
    location::escape,
};
use crate::api::faults::Faults;

/// What is said of it.
const REFUSED: &str = "null is no value of a field; give a value, or leave the field out where it is optional (null \
    marks only what was \
     not measured, within arrays)";

/// A step into a value.
enum Step {
    Field(String),
    Entry(usize),
}

/// Adds a fault for every field that is `null`, if the walk of `cursor` over all of its text met
/// one; the value stands at `at`.
pub fn refuse(cursor: &Cursor, at: &str, faults: &mut Faults) {
    if cursor.met_null_field() {
        // The text has been walked over before, so that nothing can be wrong with it.
        let _ = look(&mut cursor.rewound(), at, &mut Vec::new(), faults);
    }
}

fn look(cursor: &mut Cursor, at: &str, path: &mut Vec<Step>, faults: &mut Faults) -> Result<(), Syntax> {
    match cursor.token()? {
        Token::Object => cursor.object(|cursor, key| {
            path.push(Step::Field(escape(&key)));
            if cursor.token()? == Token::Null {
                faults.settle(pointer(at, path), REFUSED);
            }
            look(cursor, at, path, faults)?;
            path.pop();
            Ok(())
        }),
        Token::Array => cursor.array(|cursor, i| {
            path.push(Step::Entry(i));
            look(cursor, at, path, faults)?;
            path.pop();
            Ok(())
        }),
        _ => cursor.skip_value().map(drop),
    }
}

fn pointer(at: &str, path: &[Step]) -> String {
    let mut text = at.to_owned();
    for step in path {
        match step {
            Step::Field(key) => text.extend(["/", key]),
            Step::Entry(i) => text.push_str(&format!("/{i}")),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pointers(text: &str) -> Vec<String> {
        let mut cursor = Cursor::new(text.as_bytes());
        cursor.skip_value().unwrap();
        let mut faults = Faults::default();
        refuse(&cursor, "", &mut faults);
        faults.list().iter().map(|fault| fault.pointer.clone()).collect()
    }

    #[test]
    fn fields_are_named_and_entries_pass() {
        assert_eq!(pointers(r#"{"a":[1,null],"b":"null","c":{"d":": null"}}"#), [""; 0]);
        let text = r#"{"a":null,"b":[{"c/d": null},[null,{"e":[] ,"f":
            null}]],"g":{"h":[null],"i":1}}"#;
        assert_eq!(pointers(text), ["/a", "/b/0/c~1d", "/b/1/1/f"]);
        assert_eq!(pointers("null"), [""; 0]);
    }
}
