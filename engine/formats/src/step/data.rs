//! The data section: instances, numbered as they come.

use flankfit_numerics::cancel::{self, Asking};
use std::fmt::{Display, Formatter, Result, Write as _};

/// The name of an instance, `#12`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Id(usize);

impl Display for Id {
    fn fmt(&self, f: &mut Formatter) -> Result {
        write!(f, "#{}", self.0)
    }
}

/// Instances so far.
#[derive(Default)]
pub(super) struct Data {
    count: usize,
    text: String,
}

/// Lines are broken behind this column. The standard sets no limit, but many readers and people
/// like one.
const COLUMNS: usize = 100;

impl Data {
    /// One more instance, given without number and semicolon.
    pub(super) fn add(&mut self, instance: impl AsRef<str>) -> Id {
        cancel::checkpoint();
        self.count += 1;
        let id = Id(self.count);
        let mut column = self.text.len();
        // Writing to a String cannot fail.
        let _ = write!(self.text, "{id}=");
        column = self.text.len() - column;
        let mut quoted = false;
        for c in instance.as_ref().chars().asking(3) {
            // a doubled apostrophe ends and begins
            quoted ^= c == '\'';
            self.text.push(c);
            column += 1;
            if c == ',' && !quoted && column >= COLUMNS {
                self.text.push('\n');
                column = 0;
            }
        }
        self.text.push_str(";\n");
        id
    }

    /// The whole section, and the end of the file.
    pub(super) fn into_text(self) -> String {
        format!("DATA;\n{}ENDSEC;\nEND-ISO-10303-21;\n", self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_outside_of_strings() {
        let mut data = Data::default();
        let name = format!("A('it''s {}',$,$)", ",".repeat(200));
        assert_eq!(data.add(&name), Id(1));
        assert_eq!(data.add("B()").to_string(), "#2");
        let text = data.into_text();
        assert_eq!(text.lines().count(), 6);
        assert!(text.replace('\n', "").contains(&name));
        assert!(text.contains("',\n$,$);"));
    }
}
