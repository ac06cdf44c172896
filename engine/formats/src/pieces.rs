//! Files that are written piece by piece, so that a large one is never in memory as a whole.
//!
//! A file is a row of sections, each with a number of lines (or records) and what writes one of
//! them. Whatever could be wrong with the shape is found when the sections are put together:
//! writing cannot fail.

use std::{collections::VecDeque, fmt};

use flankfit_numerics::cancel::checkpoint;

/// Writes the line of a number.
type Line = Box<dyn FnMut(usize, &mut Vec<u8>) + Send>;

/// A file, as far as it has not been written yet.
#[derive(Default)]
pub struct Pieces {
    sections: VecDeque<Section>,
    /// The next line of the first section.
    next: usize,
}

struct Section {
    lines: usize,
    line: Line,
}

/// Lines between two looks at whether the file is still wanted.
const LINES: usize = 512;

impl Pieces {
    /// A file without sections.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds what is there already.
    #[must_use]
    pub fn text(self, text: impl Into<Vec<u8>>) -> Self {
        let text = text.into();
        self.lines(1, move |_, out| out.extend_from_slice(&text))
    }

    /// Adds so many lines, which `line` appends one by one, in order.
    #[must_use]
    pub fn lines(mut self, lines: usize, line: impl FnMut(usize, &mut Vec<u8>) + Send + 'static) -> Self {
        self.sections.push_back(Section { lines, line: Box::new(line) });
        self
    }

    /// The next lines, at least `length` bytes unless the file ends before; `None` at its end.
    pub fn next_piece(&mut self, length: usize) -> Option<Vec<u8>> {
        let mut piece = Vec::with_capacity(length + length / 8);
        while let Some(section) = self.sections.front_mut() {
            while self.next < section.lines {
                if piece.len() >= length {
                    return Some(piece);
                }
                if self.next.is_multiple_of(LINES) {
                    checkpoint();
                }
                (section.line)(self.next, &mut piece);
                self.next += 1;
            }
            // what the section holds is given back with it
            self.sections.pop_front();
            self.next = 0;
        }
        (!piece.is_empty()).then_some(piece)
    }

    /// True if nothing is left.
    pub fn is_done(&self) -> bool {
        self.sections.iter().enumerate().all(|(k, section)| section.lines == if k == 0 { self.next } else { 0 })
    }

    /// All of it.
    pub fn whole(mut self) -> Vec<u8> {
        let mut all = Vec::new();
        while let Some(piece) = self.next_piece(1 << 16) {
            all.extend(piece);
        }
        all
    }
}

impl fmt::Debug for Pieces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pieces").field("sections", &self.sections.len()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_the_lines_in_order_and_short() {
        let of = || {
            let line = |i: usize, out: &mut Vec<u8>| out.extend_from_slice(format!("{i},").as_bytes());
            Pieces::new().text("head:").lines(1000, line).lines(0, line).lines(3, line).text("").text("end")
        };
        let whole = String::from_utf8(of().whole()).unwrap();
        let expected: String = (0..1000).chain(0..3).map(|i| format!("{i},")).collect();
        assert_eq!(whole, format!("head:{expected}end"));
        for length in [1, 10, 100] {
            let (mut file, mut all) = (of(), Vec::new());
            while let Some(piece) = file.next_piece(length) {
                assert!(piece.len() < length + 6, "{}", piece.len());
                all.extend(piece);
            }
            assert_eq!(all, whole.as_bytes());
        }
        assert_eq!(Pieces::new().next_piece(10), None);
        let mut file = of();
        assert!(!file.is_done() && Pieces::new().is_done());
        file.next_piece(whole.len());
        assert!(file.is_done());
    }
}
