//! Aligned text tables: headings, a rule, rows. One character is taken to be one column wide, which
//! holds for the Latin and Greek letters and the superscripts printed here.

use std::fmt;

/// Alignment of the cells of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Left,
    Right,
}

/// A table under construction.
#[derive(Clone, Debug)]
pub struct Table {
    headings: Vec<String>,
    aligns: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table whose first `left` columns are text; the others hold numbers and stand to the right.
    pub fn new<const N: usize>(headings: [&str; N], left: usize) -> Self {
        Table {
            headings: headings.iter().map(|heading| (*heading).to_owned()).collect(),
            aligns: (0..N).map(|column| if column < left { Align::Left } else { Align::Right }).collect(),
            rows: Vec::new(),
        }
    }

    /// Makes the last column text, for remarks after the numbers.
    pub fn with_remark(mut self) -> Self {
        if let Some(last) = self.aligns.last_mut() {
            *last = Align::Left;
        }
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
            for ((cell, &width), align) in row.iter().zip(&widths).zip(&self.aligns) {
                text.push_str("  ");
                match align {
                    Align::Left => text.push_str(&format!("{cell:<width$}")),
                    Align::Right => text.push_str(&format!("{cell:>width$}")),
                }
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
