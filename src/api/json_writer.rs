//! Writes JSON objects that hold finished JSON.
//!
//! A fit's answer is written once and stored as it was written; answers that hold it take it over byte for byte. Serde could
//! only do that after reading the text again.

use serde::Serialize;

/// An object being written.
pub struct Object<'a> {
    out: &'a mut Vec<u8>,
    first: bool,
}

impl<'a> Object<'a> {
    pub fn begin(out: &'a mut Vec<u8>) -> Self {
        out.push(b'{');
        Object { out, first: true }
    }

    /// A field written by serde.
    pub fn field(&mut self, name: &'static str, value: &impl Serialize) -> &mut Self {
        self.key(name);
        // Only maps with keys that are not texts cannot be written; there are none.
        let _written = serde_json::to_writer(&mut *self.out, value);
        self
    }

    /// A field that is left out when it does not exist.
    pub fn maybe(&mut self, name: &'static str, value: Option<impl Serialize>) -> &mut Self {
        match value {
            Some(value) => self.field(name, &value),
            None => self,
        }
    }

    /// A field that holds finished JSON.
    pub fn raw(&mut self, name: &'static str, json: &str) -> &mut Self {
        self.key(name);
        self.out.extend_from_slice(json.as_bytes());
        self
    }

    /// A field that holds a list of objects.
    pub fn list<T>(
        &mut self,
        name: &'static str,
        items: impl IntoIterator<Item = T>,
        mut write: impl FnMut(&mut Object<'_>, T),
    ) -> &mut Self {
        self.key(name);
        self.out.push(b'[');
        for (i, item) in items.into_iter().enumerate() {
            if i > 0 {
                self.out.push(b',');
            }
            let mut object = Object::begin(self.out);
            write(&mut object, item);
            object.end();
        }
        self.out.push(b']');
        self
    }

    pub fn end(&mut self) {
        self.out.push(b'}');
    }

    /// Names are ours and need no escapes.
    fn key(&mut self, name: &'static str) {
        if !std::mem::take(&mut self.first) {
            self.out.push(b',');
        }
        self.out.push(b'"');
        self.out.extend_from_slice(name.as_bytes());
        self.out.extend_from_slice(b"\":");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_what_serde_reads() {
        let mut out = Vec::new();
        Object::begin(&mut out)
            .field("a", &"x\"y")
            .maybe("b", None::<u8>)
            .raw("c", "[1.50]")
            .list("d", [1, 2], |object, n| {
                object.field("n", &n);
            })
            .list("e", [0_u8; 0], |_, _| {})
            .end();
        assert_eq!(String::from_utf8(out).unwrap(), r#"{"a":"x\"y","c":[1.50],"d":[{"n":1},{"n":2}],"e":[]}"#);
    }
}
