//! Which field serde writes as `null`.

use std::io;

use serde_json::ser::Formatter;

/// Names the first field that serde writes as `null`: a field that does not exist is left out, so a
/// `null` in its place is a number that is not finite.
pub struct NullFields {
    /// The field that was begun last.
    pub key: String,
    in_key: bool,
    in_field: bool,
    /// The first that is `null`.
    pub culprit: Option<String>,
}

impl Default for NullFields {
    fn default() -> Self {
        NullFields { key: String::new(), in_key: false, in_field: true, culprit: None }
    }
}

impl Formatter for &mut NullFields {
    fn begin_object_key<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.key.clear();
        self.in_key = true;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn write_string_fragment<W: ?Sized + io::Write>(&mut self, writer: &mut W, fragment: &str) -> io::Result<()> {
        if self.in_key {
            self.key.push_str(fragment);
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
            self.culprit.get_or_insert_with(|| self.key.clone());
        }
        writer.write_all(b"null")
    }
}
