//! A file of curves: header, traces, and the tables behind them.

use super::{
    super::{
        file_error::{FilePosition, shown},
        note::{Notes, Remark},
        source::{Line, Lines, append_numbers, number},
    },
    FileError, FileKind, Header,
    tables::{Contact, Diameters, PitchTable},
    trace_head::{self, TraceHead},
};
use flankfit_gear::{Kind, Side, tooth};
use flankfit_numerics::cancel;

pub use super::trace_head::Section;

/// Marks an undefined point where the preamble says nothing else.
const UNDEFINED: f64 = -2_147_483.648;

/// Block of the file that a trace belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// Leads of the measured teeth.
    Helix,
    /// Profiles of the measured teeth.
    Profile,
    /// Further traces of one tooth, for the twist.
    Twist,
    /// A grid of traces of one tooth, in older files.
    Topography,
    /// A title of no known meaning; its traces are read all the same.
    Other(String),
    /// No title at all.
    Untitled,
}

impl Block {
    fn of(title: &str) -> Block {
        let small = title.to_lowercase();
        let says = |words: &[&str]| words.iter().any(|word| small.contains(word));
        if says(&["topogra"]) {
            Block::Topography
        } else if says(&["verschr", "twist", "bias"]) {
            Block::Twist
        } else {
            match trace_head::kind_of(title) {
                Some(Kind::Profile) => Block::Profile,
                Some(Kind::Helix) => Block::Helix,
                None => Block::Other(title.trim().into()),
            }
        }
    }
}

/// A trace as it is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Block of the file that the trace belongs to.
    pub block: Block,
    /// `44`, `1k`
    pub tooth: String,
    /// Number within its group, as in `/Profil:3`.
    pub index: Option<u32>,
    /// Flank of the tooth.
    pub side: Side,
    /// Profile or helix.
    pub kind: Kind,
    /// Section that it was measured in.
    pub section: Section,
    /// µm with the sign stored, in the order stored; NaN where undefined.
    pub values: Vec<f64>,
    /// Number of undefined points.
    pub undefined: usize,
    /// Line of its head.
    pub line: usize,
}

/// A file of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Preamble and header lines.
    pub header: Header,
    /// Traces, in the order of the file.
    pub curves: Vec<Curve>,
    /// Pitch and run-out by tooth, one table for each flank.
    pub pitch: Vec<PitchTable>,
    /// Places at which the pitch measurement touched the flanks.
    pub contacts: Vec<Contact>,
    /// Root and tip diameters of the measured teeth.
    pub diameters: Vec<Diameters>,
    /// Remarks about lines that were read in spite of them.
    pub notes: Notes,
}

impl Curves {
    /// Reads the text of a file.
    pub(super) fn parse(text: &str) -> Result<Self, FileError> {
        let mut lines = Lines::new(text);
        let mut notes = Notes::default();
        let header = Header::parse(&mut lines, FileKind::Curves, &mut notes)?;
        let undefined = Undefined::of(&header, &mut notes);
        let file = Curves {
            header,
            curves: Vec::new(),
            pitch: Vec::new(),
            contacts: Vec::new(),
            diameters: Vec::new(),
            notes,
        };
        let mut body = Body { file, undefined, block: Block::Untitled, flank: None, unknown: None };
        while let Some(line) = lines.next() {
            cancel::checkpoint();
            if !line.is_blank() {
                body.take(line, &mut lines)?;
            }
        }
        body.end_unknown();
        Ok(body.file)
    }
}

/// The number that marks an undefined point. Large ones are recognised to the digits with which
/// they were written.
#[derive(Clone, Copy, Debug)]
struct Undefined {
    marker: f64,
}

impl Undefined {
    fn of(header: &Header, notes: &mut Notes) -> Self {
        let setting = header.preamble.iter().find(|setting| setting.key == "UNDEFINED");
        let marker = setting.map_or(Some(UNDEFINED), |setting| number(&setting.value));
        if let (Some(setting), None) = (setting, marker) {
            notes.push(setting.line, Remark::UndefinedMark { mark: setting.value.clone(), taken: UNDEFINED });
        }
        Undefined { marker: marker.unwrap_or(UNDEFINED) }
    }

    /// No flank deviates by two metres: the usual marker is one in every file.
    fn is(self, value: f64) -> bool {
        let meets =
            |marker: f64| value == marker || (marker.abs() > 1e6 && (value - marker).abs() <= 1e-8 * marker.abs());
        meets(self.marker) || meets(UNDEFINED)
    }
}

/// Content read after the header.
struct Body {
    file: Curves,
    undefined: Undefined,
    block: Block,
    /// The flank that a title named last; a table of pitches follows.
    flank: Option<Side>,
    /// First line, text and number of the lines that fit nothing.
    unknown: Option<(usize, String, usize)>,
}

impl Body {
    fn take(&mut self, line: Line, lines: &mut Lines) -> Result<(), FileError> {
        if let Some(head) = trace_head::parse(line)? {
            self.end_unknown();
            return self.take_trace(&head, line, lines);
        }
        let text = line.text.trim();
        if line.is_numeric() {
            self.add_unknown(line);
        } else if PitchTable::is_head(line) {
            self.end_unknown();
            let mut table = PitchTable::parse(line, self.flank.take(), lines)?;
            table.values_mut().filter(|value| self.undefined.is(**value)).for_each(|value| *value = f64::NAN);
            self.file.pitch.push(table);
        } else if Contact::is_head(line) {
            self.end_unknown();
            Contact::parse(lines, &mut self.file.contacts)?;
        } else if let Some(table) = Diameters::parse(line, lines)? {
            self.end_unknown();
            self.file.diameters.push(table);
        } else if let Some(side) = flank_title(text) {
            self.end_unknown();
            self.flank = Some(side);
        } else if let Some(title) = text.strip_suffix(':').filter(|title| is_title(title)) {
            self.end_unknown();
            self.block = Block::of(title);
        } else {
            self.add_unknown(line);
        }
        Ok(())
    }

    fn take_trace(&mut self, head: &TraceHead, line: Line, lines: &mut Lines) -> Result<(), FileError> {
        let block = head.title.map_or_else(|| self.block.clone(), Block::of);
        let kind = kind_of(head, &block, line)?;
        let values = self.values(head, line, lines)?;
        let undefined = values.iter().filter(|value| value.is_nan()).count();
        self.file.curves.push(Curve {
            block,
            // a file may write `01`
            tooth: tooth::canonical(head.tooth).unwrap_or_else(|_| head.tooth.to_owned()),
            index: head.group.and_then(|(_, index)| index),
            side: head.side,
            kind,
            section: head.section,
            values,
            undefined,
            line: line.number,
        });
        Ok(())
    }

    /// The values behind a head: as many as it announces, or up to the next text if it announces
    /// none.
    fn values(&mut self, head: &TraceHead, line: Line, lines: &mut Lines) -> Result<Vec<f64>, FileError> {
        if head.count.is_none() {
            self.file.notes.push(line.number, Remark::CountNotGiven(head.tooth.to_string()));
        }
        // a value takes at least a digit and a separator, whatever the head promises
        let most = lines.bytes_left() / 2 + 1;
        let mut values = Vec::with_capacity(head.count.unwrap_or(0).min(most));
        let count = |place: FilePosition, found: usize| FileError::ValueCount {
            place,
            trace: format!("tooth {} on line {}", head.tooth, line.number),
            announced: head.count.unwrap_or(found),
            found,
        };
        while let Some(next) = lines.peek() {
            if next.is_blank() {
                lines.next();
                continue;
            }
            if !next.is_numeric() {
                break;
            }
            let start = values.len();
            if head.count.is_some_and(|count| count == start) {
                return Err(count(
                    next.place(next.text.trim_start()),
                    start + next.text.split_ascii_whitespace().count(),
                ));
            }
            append_numbers(next.text, &mut values).map_err(|piece| next.expected(piece, "a number"))?;
            for value in &mut values[start..] {
                if self.undefined.is(*value) {
                    *value = f64::NAN;
                }
            }
            lines.next();
            if let Some(announced) = head.count
                && values.len() > announced
            {
                let first_extra = next.text.split_ascii_whitespace().nth(announced - start).unwrap_or(next.text);
                return Err(count(next.place(first_extra), values.len()));
            }
        }
        if head.count.is_some_and(|announced| values.len() < announced) {
            let place = lines.peek().map_or(lines.place(), |next| next.place(next.text));
            return Err(count(place, values.len()));
        }
        Ok(values)
    }

    fn add_unknown(&mut self, line: Line) {
        match &mut self.unknown {
            Some((_, _, count)) => *count += 1,
            None => self.unknown = Some((line.number, shown(line.text), 1)),
        }
    }

    fn end_unknown(&mut self) {
        if let Some((first, text, count)) = self.unknown.take() {
            self.file.notes.push(first, Remark::UnknownBlock { first: text, following: count - 1 });
        }
    }
}

/// The letter of the section decides; words must not contradict it.
fn kind_of(head: &TraceHead, block: &Block, line: Line) -> Result<Kind, FileError> {
    let by_letter = match head.section {
        Section::RollLength(_) | Section::Diameter(_) => Some(Kind::Helix),
        Section::Z(_) => Some(Kind::Profile),
        Section::NotGiven => None,
    };
    let by_block = match block {
        Block::Helix => Some(Kind::Helix),
        Block::Profile => Some(Kind::Profile),
        _ => None,
    };
    let by_word = head.group.and_then(|(word, _)| trace_head::kind_of(word)).or(by_block);
    match (by_letter, by_word) {
        (Some(letter), Some(word)) if letter != word => Err(line.expected(
            line.text,
            match word {
                Kind::Profile => "z= of a profile",
                Kind::Helix => "x= or d= of a lead",
            },
        )),
        (Some(kind), _) | (None, Some(kind)) => Ok(kind),
        (None, None) => Err(line.expected(line.text, "x=, d= or z= of a trace")),
    }
}

/// A title is a few words and no more.
fn is_title(text: &str) -> bool {
    text.bytes().next().is_some_and(|b| !b.is_ascii_digit()) && !text.contains([':', '=']) && text.chars().count() <= 40
}

/// `linke Zahnflanke`, `left tooth flank:`
fn flank_title(text: &str) -> Option<Side> {
    let text = text.trim_end_matches(':');
    let words = text.split_ascii_whitespace().count();
    if text.contains([':', '=', '/']) || words > 4 {
        return None;
    }
    text.split_ascii_whitespace().find_map(trace_head::side_of)
}
