//! Which field serde writes as `null`.

use std::io;

use serde_json::ser::Formatter;

/// Looks at what serde writes: a field that does not exist is left out, so a `null` in its place is
/// a number that is not finite.
pub struct NullFields {
    /// The field that was begun last, where the culprit is to be named.
    key: Option<String>,
    in_key: bool,
    in_field: bool,
    /// The first that is `null`.
    pub culprit: Option<String>,
}

impl NullFields {
    /// Finds whether a field is `null`; its name only if `named`, which takes longer.
    pub fn new(named: bool) -> Self {
        NullFields { key: named.then(String::new), in_key: false, in_field: true, culprit: None }
    }
}

impl Formatter for &mut NullFields {
    fn begin_object_key<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if let Some(key) = &mut self.key {
            key.clear();
            self.in_key = true;
        }
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn write_string_fragment<W: ?Sized + io::Write>(&mut self, writer: &mut W, fragment: &str) -> io::Result<()> {
        if self.in_key
            && let Some(key) = &mut self.key
        {
            key.push_str(fragment);
        }
        writer.write_all(fragment.as_bytes())
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.in_key = false;
        self.in_field = true;
        writer.write_all(b":")
    }

    /// A list has a `null` where nothing was measured.
    fn begin_array_value<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.in_field = false;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn write_null<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.in_field {
            self.culprit.get_or_insert_with(|| self.key.clone().unwrap_or_default());
        }
        writer.write_all(b"null")
    }
}
