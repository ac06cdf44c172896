//! Aligned text tables: headings, a rule, rows. One character is taken to be one column wide, which
//! holds for the Latin and Greek letters and the superscripts printed here.

use std::fmt;

/// A table under construction.
#[derive(Clone, Debug)]
pub struct Table {
    headings: Vec<String>,
    /// Number of columns of text, from the first on; the others hold numbers.
    left: usize,
    /// Whether the last column is text, too.
    remark: bool,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table whose first `left` columns are text; the others hold numbers and stand to the right.
    pub fn new<const N: usize>(headings: [&str; N], left: usize) -> Self {
        Table {
            headings: headings.iter().map(|heading| (*heading).to_owned()).collect(),
            left,
            remark: false,
            rows: Vec::new(),
        }
    }

    /// Makes the last column text, for remarks after the numbers.
    pub fn with_remark(mut self) -> Self {
        self.remark = true;
        self
    }

    /// Adds a row; cells after the last heading are dropped, absent ones stay empty.
    pub fn row<I: IntoIterator<Item = String>>(&mut self, cells: I) {
        let mut row: Vec<String> = cells.into_iter().take(self.headings.len()).collect();
        row.resize(self.headings.len(), String::new());
        self.rows.push(row);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut widths = vec![0; self.headings.len()];
        for row in std::iter::once(&self.headings).chain(&self.rows) {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = (*width).max(cell.chars().count());
            }
        }
        let line = |row: &[String]| {
            let mut text = String::from(" ");
            for (k, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                text.push_str(&match k < self.left || (self.remark && k + 1 == row.len()) {
                    true => format!("  {cell:<width$}"),
                    false => format!("  {cell:>width$}"),
                });
            }
            text.truncate(text.trim_end().len());
            text
        };
        writeln!(f, "{}", line(&self.headings))?;
        writeln!(f, "{}", line(&widths.iter().map(|&width| "─".repeat(width)).collect::<Vec<_>>()))?;
        for row in &self.rows {
            writeln!(f, "{}", line(row))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(["λ*", "value", "remark"], 1).with_remark();
        table.row(["a".into(), "1".into(), "first".into()]);
        table.row(["bcd".into(), "−12.5".into()]);
        assert_eq!(
            table.to_string(),
            "   λ*   value  remark\n   ───  ─────  ──────\n   a        1  first\n   bcd  −12.5\n"
        );
    }
}
