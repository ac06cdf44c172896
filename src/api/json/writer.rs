//! Writes JSON, field by field, into one buffer.
//!
//! Answers are mostly numbers, and one that holds a fit's answer takes it over byte for byte. Serde
//! would need a body for everything that is written, and would read finished JSON again; here
//! numbers go from the domain types to their text at once. The text is the one that serde writes:
//! no white space, shortest numbers that read back as the same double.

use serde::Serialize;
use serde_json::ser::Serializer;

use super::{gather::gathered, null_fields::NullFields};
use flankfit_engine::numerics::cancel::Asking;

/// An answer has a number that JSON cannot hold; its field, or the field that it stands in.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` of the answer leaves the range of double precision: check the request's magnitudes and units")]
pub struct NotFinite(pub String);

/// The text that serde writes of an answer, if every number in it is finite.
pub fn whole(answer: &impl Serialize) -> Result<Vec<u8>, NotFinite> {
    let mut json = Json::with_capacity(1024);
    json.serde(answer);
    json.finish()
}

/// The text that serde writes of a value of the contract. serde_json fails where a key is no string
/// or an `impl Serialize` of one's own says so, and the contract has neither.
pub fn text_of(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("types of the contract can always be written")
}

/// Numbers formatted before the first of them is copied.
const TOGETHER: usize = 8;

/// Bytes of a field's name with quotation marks, comma and colon that are copied at once.
const KEY: usize = 32;

/// Bytes of a short text with quotation marks that are copied at once.
const WORD: usize = 32;

/// The longest text of a double, such as `-2.2250738585072014e-308`.
const LONGEST: usize = 24;

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

    /// The text, which has no numbers but those in finished JSON or of serde.
    pub fn into_bytes(self) -> Vec<u8> {
        self.text
    }

    /// The text, if every number in it was finite.
    pub fn finish(self) -> Result<Vec<u8>, NotFinite> {
        if self.finite { Ok(self.text) } else { Err(NotFinite(self.culprit.unwrap_or_else(|| self.field.to_owned()))) }
    }

    /// The text as of [`Json::finish`], with the warnings of its parts in its own list.
    pub fn finish_gathered(self) -> Result<Vec<u8>, NotFinite> {
        self.finish().map(gathered)
    }

    fn number(&mut self, value: f64) {
        self.finite &= value.is_finite();
        self.text.extend_from_slice(zmij::Buffer::new().format_finite(value).as_bytes());
    }

    /// Numbers with commas between them. `ends` is told where each one ends.
    ///
    /// Several are formatted before they are copied: a copy that follows its number at once waits
    /// for the processor to put the number's pieces together, which takes longer than writing them.
    fn numbers(&mut self, values: &[f64], mut ends: impl FnMut(usize)) {
        for (i, values) in values.chunks(TOGETHER).enumerate().asking(20 * TOGETHER) {
            self.finite &= values.iter().fold(true, |finite, value| finite & value.is_finite());
            let mut buffers: [_; TOGETHER] = std::array::from_fn(|_| zmij::Buffer::new());
            let mut texts = [&b""[..]; TOGETHER];
            for ((text, buffer), value) in texts.iter_mut().zip(&mut buffers).zip(values) {
                *text = buffer.format_finite(*value).as_bytes();
            }
            let mut at = self.text.len();
            self.text.resize(at + TOGETHER * (LONGEST + 1), b',');
            for (j, text) in texts[..values.len()].iter().enumerate() {
                at += usize::from(i + j > 0);
                copy_short(&mut self.text[at..], text);
                at += text.len();
                ends(at);
            }
            self.text.truncate(at);
        }
    }

    fn count(&mut self, value: usize) {
        self.text.extend_from_slice(itoa::Buffer::new().format(value).as_bytes());
    }

    fn string(&mut self, value: &str) {
        // names and sentences hardly ever need an escape
        if has_special(value.as_bytes()) {
            self.serde(&value);
        } else {
            self.quoted(value);
        }
    }

    /// A text that needs no escapes.
    fn quoted(&mut self, value: &str) {
        let mut word = [b'"'; WORD];
        let end = value.len() + 2;
        if end <= WORD {
            copy_short(&mut word[1..], value.as_bytes());
            let end = self.text.len() + end;
            self.text.extend_from_slice(&word);
            self.text.truncate(end);
        } else {
            self.text.push(b'"');
            self.text.extend_from_slice(value.as_bytes());
            self.text.push(b'"');
        }
    }

    fn serde(&mut self, value: &impl Serialize) {
        let mut fields = NullFields::default();
        // Only maps with keys that are not texts cannot be written; there are none.
        let _written = value.serialize(&mut Serializer::with_formatter(&mut self.text, &mut fields));
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
        if let [low, high] = values {
            return self.pair([*low, *high]);
        }
        self.text.push(b'[');
        self.numbers(values, |_| {});
        self.text.push(b']');
    }

    /// Most rows that answers have many of are intervals, too short for what [`Self::numbers`]
    /// does.
    fn pair(&mut self, [low, high]: [f64; 2]) {
        self.finite &= low.is_finite() & high.is_finite();
        let (mut first, mut second) = (zmij::Buffer::new(), zmij::Buffer::new());
        let (first, second) = (first.format_finite(low).as_bytes(), second.format_finite(high).as_bytes());
        let at = self.text.len();
        let end = at + first.len() + second.len() + 3;
        self.text.resize(end, b',');
        let text = &mut self.text[at..];
        text[0] = b'[';
        copy_short(&mut text[1..], first);
        copy_short(&mut text[first.len() + 2..], second);
        text[end - at - 1] = b']';
    }
}

impl Object<'_> {
    /// A field written by serde.
    pub fn field(&mut self, name: &'static str, value: &impl Serialize) -> &mut Self {
        self.key(name).serde(value);
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
        self.key(name).text.extend_from_slice(json.as_bytes());
        self
    }

    /// A field that holds JSON text, where there is some.
    pub fn maybe_raw(&mut self, name: &'static str, json: Option<&str>) -> &mut Self {
        match json {
            Some(json) => self.raw(name, json),
            None => self,
        }
    }

    pub fn number(&mut self, name: &'static str, value: f64) -> &mut Self {
        self.key(name).number(value);
        self
    }

    pub fn maybe_number(&mut self, name: &'static str, value: Option<f64>) -> &mut Self {
        match value {
            Some(value) => self.number(name, value),
            None => self,
        }
    }

    pub fn numbers(&mut self, name: &'static str, values: &[f64]) -> &mut Self {
        self.key(name).row(values);
        self
    }

    /// Numbers, with null where one does not exist.
    pub fn numbers_or_null(&mut self, name: &'static str, values: &[Option<f64>]) -> &mut Self {
        self.key(name).entries(values, |out, value| match value {
            Some(value) => out.number(*value),
            None => out.text.extend_from_slice(b"null"),
        });
        self
    }

    /// Rows of numbers.
    pub fn rows(&mut self, name: &'static str, rows: &[Vec<f64>]) -> &mut Self {
        self.key(name).entries(rows, |out, row| out.row(row));
        self
    }

    /// Intervals `[low, high]`.
    pub fn pairs(&mut self, name: &'static str, pairs: &[[f64; 2]]) -> &mut Self {
        self.key(name).entries(pairs, |out, pair| out.row(pair));
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

    /// Rows of a symmetric matrix: what stands below the diagonal is copied from above it, which is
    /// cheaper than writing numbers again. (Rows that do not mirror each other bit by bit are
    /// written like any others.)
    pub fn symmetric_rows(&mut self, name: &'static str, rows: &[Vec<f64>]) -> &mut Self {
        let n = rows.len();
        let mirrored =
            |i: usize, row: &[f64]| row[..i].iter().zip(rows).all(|(x, twin)| twin[i].to_bits() == x.to_bits());
        if !(rows.iter().all(|row| row.len() == n) && rows.iter().enumerate().all(|(i, row)| mirrored(i, row))) {
            return self.rows(name, rows);
        }
        // Where the numbers on and above the diagonal end, by row and column.
        let mut ends = Vec::with_capacity(n * n);
        self.key(name).entries(rows.iter().enumerate(), |out, (i, row)| {
            out.text.push(b'[');
            for j in 0..i {
                // Behind the one before it and a comma.
                let (before, end) = (ends[j * n + i - 1], ends[j * n + i]);
                out.text.extend_from_within(before + 1..end);
                out.text.push(b',');
            }
            ends.resize(i * n + i, 0);
            out.numbers(&row[i..], |end| ends.push(end));
            out.text.push(b']');
        });
        self
    }

    pub fn count(&mut self, name: &'static str, value: usize) -> &mut Self {
        self.key(name).count(value);
        self
    }

    pub fn counts(&mut self, name: &'static str, values: &[usize]) -> &mut Self {
        self.key(name).entries(values, |out, value| out.count(*value));
        self
    }

    pub fn string(&mut self, name: &'static str, value: &str) -> &mut Self {
        self.key(name).string(value);
        self
    }

    /// One of the contract's words, which need no escapes.
    pub fn word(&mut self, name: &'static str, value: &'static str) -> &mut Self {
        self.key(name).quoted(value);
        self
    }

    pub fn strings(&mut self, name: &'static str, values: &[String]) -> &mut Self {
        self.key(name).entries(values, |out, value| out.string(value));
        self
    }

    /// A field that holds an object.
    pub fn object(&mut self, name: &'static str, write: impl FnOnce(&mut Object<'_>)) -> &mut Self {
        let mut object = self.key(name).object();
        write(&mut object);
        object.end();
        self
    }

    /// A field that holds an object whose text may be known; where it is not, it is written, and
    /// answered if every number in it is finite.
    pub fn known_object(
        &mut self,
        name: &'static str,
        known: Option<&[u8]>,
        write: impl FnOnce(&mut Object<'_>),
    ) -> Option<&[u8]> {
        let out = self.key(name);
        if let Some(text) = known {
            out.text.extend_from_slice(text);
            return None;
        }
        let begin = out.text.len();
        let mut object = out.object();
        write(&mut object);
        object.end();
        out.finite.then(|| &out.text[begin..])
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
    #[inline]
    fn key(&mut self, name: &'static str) -> &mut Json {
        let out = &mut *self.out;
        if !out.finite {
            out.culprit.get_or_insert_with(|| out.field.to_owned());
        }
        out.field = name;
        // before the quotation mark: a comma, or nothing
        let before = usize::from(!std::mem::take(&mut self.first));
        let after = before + 1 + name.len();
        let mut key = [b','; KEY];
        if after + 2 <= KEY {
            key[before] = b'"';
            copy_short(&mut key[before + 1..], name.as_bytes());
            key[after] = b'"';
            key[after + 1] = b':';
            let end = out.text.len() + after + 2;
            out.text.extend_from_slice(&key);
            out.text.truncate(end);
        } else {
            out.text.extend_from_slice(&key[..before]);
            out.text.push(b'"');
            out.text.extend_from_slice(name.as_bytes());
            out.text.extend_from_slice(b"\":");
        }
        out
    }
}

/// Whether JSON escapes one of these bytes. Eight are looked at together, the last filled up
/// with letters.
fn has_special(text: &[u8]) -> bool {
    const ONES: u64 = u64::from_ne_bytes([1; 8]);
    const HIGH: u64 = u64::from_ne_bytes([0x80; 8]);
    // the highest bit of each byte that is less than `than`, at most 128, and perhaps of ones above
    // such a byte
    let less = |eight: u64, than: u8| eight.wrapping_sub(ONES * u64::from(than)) & !eight & HIGH;
    let equal = |eight: u64, byte: u8| less(eight ^ (ONES * u64::from(byte)), 1);
    let special = |eight: u64| (less(eight, b' ') | equal(eight, b'"') | equal(eight, b'\\')) != 0;
    let (eights, rest) = text.as_chunks::<8>();
    let mut last = [b'a'; 8];
    copy_short(&mut last, rest);
    eights.iter().fold(special(u64::from_ne_bytes(last)), |found, eight| found | special(u64::from_ne_bytes(*eight)))
}

/// Copies the text of a number or a name to the beginning of `to`: two pieces of a fixed size that
/// may overlap, for a copy of any length is a call.
#[inline]
fn copy_short(to: &mut [u8], text: &[u8]) {
    let to = &mut to[..text.len()];
    if !(copy_ends::<16>(to, text) || copy_ends::<8>(to, text) || copy_ends::<4>(to, text)) {
        to.iter_mut().zip(text).for_each(|(to, byte)| *to = *byte);
    }
}

/// Copies texts of N to 2 N bytes; false where there are less (and wrong where there are more).
#[inline(always)]
fn copy_ends<const N: usize>(to: &mut [u8], text: &[u8]) -> bool {
    let (Some(first), Some(last)) = (text.first_chunk::<N>(), text.last_chunk::<N>()) else { return false };
    let tail = to.len() - N;
    to[..N].copy_from_slice(first);
    to[tail..].copy_from_slice(last);
    true
}

#[cfg(test)]
#[path = "writer_tests.rs"]
mod tests;
