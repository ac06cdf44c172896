//! Writes JSON: responses by serde, and large ones field by field into one buffer.
//!
//! Values at many places go from flat lists to their text without a tree, and stored JSON is taken
//! over byte for byte. The text is the one that serde writes: no white space, shortest numbers that
//! read back as the same double.

use memchr::memmem;
use serde::Serialize;
use serde_json::ser::Serializer;

use super::null_fields::NullFields;
use flankfit_engine::numerics::cancel::Asking;

/// A number of an answer that JSON cannot hold, with its field or the field of its list.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` of the result exceeds the range of double precision: check the magnitudes and units of the request")]
pub struct NotFinite(pub String);

/// The text that serde writes of an answer, if every number in it is finite.
pub fn whole(answer: &impl Serialize) -> Result<Vec<u8>, NotFinite> {
    let mut json = Json::with_capacity(16 << 10);
    json.serde(answer);
    json.finish()
}

/// serde_json fails where a key is no string or an `impl Serialize` of one's own says so, and the
/// contract has neither.
const WRITABLE: &str = "types of the contract can always be written";

/// Returns the text that serde writes of a value of the contract.
pub fn text_of(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect(WRITABLE)
}

/// JSON text being written.
#[derive(Debug)]
pub struct Json {
    text: Vec<u8>,
    finite: bool,
    /// The field that was begun last, and the first that had a number that is not finite.
    field: &'static str,
    culprit: Option<String>,
}

/// An object being written.
pub struct Object<'a> {
    out: &'a mut Json,
    first: bool,
}

impl Json {
    pub fn with_capacity(bytes: usize) -> Self {
        Json { text: Vec::with_capacity(bytes), finite: true, field: "", culprit: None }
    }

    pub fn object(&mut self) -> Object<'_> {
        self.text.push(b'{');
        Object { out: self, first: true }
    }

    /// The text, if every number in it was finite.
    pub fn finish(self) -> Result<Vec<u8>, NotFinite> {
        match self.finite {
            true => Ok(self.text),
            false => Err(NotFinite(self.culprit.unwrap_or_else(|| self.field.to_owned()))),
        }
    }

    fn number(&mut self, value: f64) {
        self.finite &= value.is_finite();
        self.text.extend_from_slice(zmij::Buffer::new().format_finite(value).as_bytes());
    }

    /// Numbers with commas between them.
    fn numbers(&mut self, values: &[f64]) {
        for (i, value) in values.iter().enumerate().asking(20) {
            if i > 0 {
                self.text.push(b',');
            }
            self.number(*value);
        }
    }

    fn serde(&mut self, value: &impl Serialize) {
        let start = self.text.len();
        serde_json::to_writer(&mut self.text, value).expect(WRITABLE);
        if memmem::find(&self.text[start..], b"null").is_none() {
            return;
        }
        let mut fields = NullFields::default();
        let _same = value.serialize(&mut Serializer::with_formatter(std::io::sink(), &mut fields));
        if let Some(culprit) = fields.culprit {
            self.finite = false;
            self.culprit.get_or_insert_with(|| if culprit.is_empty() { self.field.to_owned() } else { culprit });
        }
    }

    fn entries<T>(&mut self, items: impl IntoIterator<Item = T>, mut write: impl FnMut(&mut Self, T)) {
        self.text.push(b'[');
        let mut items = items.into_iter();
        if let Some(first) = items.next() {
            write(self, first);
        }
        for item in items.asking(100) {
            self.text.push(b',');
            write(self, item);
        }
        self.text.push(b']');
    }

    fn values(&mut self, width: usize, flat: &[f64]) {
        if width == 1 {
            self.row(flat);
        } else {
            self.entries(flat.chunks_exact(width), |out, point| out.row(point));
        }
    }

    fn row(&mut self, values: &[f64]) {
        self.text.push(b'[');
        self.numbers(values);
        self.text.push(b']');
    }
}

impl Object<'_> {
    /// A field written by serde.
    pub fn field(&mut self, name: &'static str, value: &impl Serialize) -> &mut Self {
        self.key(name).serde(value);
        self
    }

    pub fn number(&mut self, name: &'static str, value: f64) -> &mut Self {
        self.key(name).number(value);
        self
    }

    pub fn numbers(&mut self, name: &'static str, values: &[f64]) -> &mut Self {
        self.key(name).row(values);
        self
    }

    /// Values of a curve or surface: numbers, or points of `width` coordinates that stand end to
    /// end.
    pub fn values(&mut self, name: &'static str, width: usize, flat: &[f64]) -> &mut Self {
        self.key(name).values(width, flat);
        self
    }

    /// Several lists of such values.
    pub fn lists_of_values(&mut self, name: &'static str, width: usize, lists: &[Vec<f64>]) -> &mut Self {
        self.key(name).entries(lists, |out, flat| out.values(width, flat));
        self
    }

    /// A field that holds an object.
    pub fn object(&mut self, name: &'static str, write: impl FnOnce(&mut Object<'_>)) -> &mut Self {
        let mut object = self.key(name).object();
        write(&mut object);
        object.end();
        self
    }

    /// A field that holds a list of objects.
    pub fn list<T>(
        &mut self,
        name: &'static str,
        items: impl IntoIterator<Item = T>,
        mut write: impl FnMut(&mut Object<'_>, T),
    ) -> &mut Self {
        self.key(name).entries(items, |out, item| {
            let mut object = out.object();
            write(&mut object, item);
            object.end();
        });
        self
    }

    pub fn end(&mut self) {
        self.out.text.push(b'}');
    }

    /// Names are ours and need no escapes.
    fn key(&mut self, name: &'static str) -> &mut Json {
        let out = &mut *self.out;
        if !out.finite {
            out.culprit.get_or_insert_with(|| out.field.to_owned());
        }
        out.field = name;
        if !std::mem::take(&mut self.first) {
            out.text.push(b',');
        }
        out.text.push(b'"');
        out.text.extend_from_slice(name.as_bytes());
        out.text.extend_from_slice(b"\":");
        out
    }
}

#[cfg(test)]
#[path = "writer_tests.rs"]
mod tests;
