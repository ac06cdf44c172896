//! Cards of 80 columns.

use flankfit_numerics::cancel::Asking;
use std::fmt::Write as _;

/// One section of a file.
pub(super) struct Cards {
    section: char,
    /// Columns that data may take.
    width: usize,
    count: usize,
    text: String,
}

/// Columns for the parameters of an entity.
const PARAMETER_WIDTH: usize = 64;

impl Cards {
    pub(super) fn new(section: char, width: usize) -> Self {
        Cards { section, width, count: 0, text: String::new() }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn into_text(self) -> String {
        self.text
    }

    /// One card of ASCII no longer than the section's width.
    pub(super) fn add(&mut self, data: &str) {
        self.count += 1;
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{data:<72}{}{:07}", self.section, self.count);
    }

    /// A list of fields, ended by a semicolon, on as many cards as it takes.
    pub(super) fn add_list(&mut self, fields: &[String]) {
        for line in wrapped(fields, self.width).into_iter().asking(200) {
            self.add(&line);
        }
    }

    /// The parameters of the entity whose directory entry begins with card `owner`; returns how
    /// many cards they took.
    pub(super) fn add_parameters(&mut self, fields: &[String], owner: usize) -> usize {
        let lines = wrapped(fields, PARAMETER_WIDTH);
        for line in lines.iter().asking(200) {
            self.add(&format!("{line:<64} {owner:>7}"));
        }
        lines.len()
    }
}

/// Fields separated by commas in lines of at most `width` columns. Only a text longer than a line
/// goes on in the next one.
fn wrapped(fields: &[String], width: usize) -> Vec<String> {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for (i, field) in fields.iter().enumerate().asking(100) {
        let end = if i + 1 == fields.len() { ';' } else { ',' };
        if !line.is_empty() && line.len() + field.len() + 1 > width {
            lines.push(std::mem::take(&mut line));
        }
        for c in field.chars().chain([end]) {
            if line.len() == width {
                lines.push(std::mem::take(&mut line));
            }
            line.push(c);
        }
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_are_80_columns_wide() {
        let mut cards = Cards::new('P', 72);
        let long = format!("100H{}", "x".repeat(100));
        assert_eq!(cards.add_parameters(&["406".into(), "1".into(), long, "0.5".into()], 3), 3);
        let text = cards.into_text();
        assert!(text.lines().all(|line| line.len() == 80 && line[64..].starts_with("       3P000000")));
        assert!(text.starts_with("406,1,  "));
        assert!(text.lines().nth(2).unwrap().starts_with(&format!("{},0.5;  ", "x".repeat(40))));
    }

    #[test]
    fn a_full_line_is_not_followed_by_an_empty_one() {
        let fields: Vec<String> = ["a".repeat(31), "b".repeat(31)].into();
        assert_eq!(wrapped(&fields, 64).len(), 1);
        assert_eq!(wrapped(&fields, 63).len(), 2);
        assert_eq!(wrapped(&["c".repeat(64)], 64), ["c".repeat(64), ";".to_owned()]);
    }
}
