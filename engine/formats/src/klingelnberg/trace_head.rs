//! The line before the values of a trace.
//!
//! `[title:] Zahn-Nr.: 1k [/Profil:1] links / 480 Werte [/] x= 8.742`. Labels are free; tooth,
//! flank, number of values and the letter of the section (`x` roll length, `d` diameter, `z` place
//! on the face width) are what is read.

use super::{
    super::source::{Line, number},
    FileError,
};
use flankfit_gear::{Kind, Side};

/// Coordinate that is constant along a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// Roll length of a lead's cylinder, mm.
    RollLength(f64),
    /// Diameter of a lead's cylinder, mm.
    Diameter(f64),
    /// Place of a profile on the face width, mm.
    Z(f64),
    /// The head names no section.
    NotGiven,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct TraceHead<'a> {
    /// Before the label of the tooth, as in `Profil: Zahn-Nr.: 1a`.
    pub title: Option<&'a str>,
    pub tooth: &'a str,
    /// Word and number behind the tooth, as in `/Profil:1`.
    pub group: Option<(&'a str, Option<u32>)>,
    pub side: Side,
    pub count: Option<usize>,
    pub section: Section,
}

/// The flank that a word names.
pub(super) fn side_of(word: &str) -> Option<Side> {
    let is = |name: &str| word.eq_ignore_ascii_case(name);
    if is("links") || is("left") || is("linke") {
        Some(Side::Left)
    } else if is("rechts") || is("right") || is("rechte") {
        Some(Side::Right)
    } else {
        None
    }
}

/// The trace that a word names.
pub(super) fn kind_of(title: &str) -> Option<Kind> {
    let title = title.to_lowercase();
    let says = |words: &[&str]| words.iter().any(|word| title.contains(word));
    if says(&["profil", "evolvent", "involut"]) {
        Some(Kind::Profile)
    } else if says(&["flankenlinie", "lead", "helix"]) {
        Some(Kind::Helix)
    } else {
        None
    }
}

/// The last word of a line that names a flank, split off: what is before it and behind it.
fn split_side(text: &str) -> Option<(&str, Side, &str)> {
    let mut found = None;
    for word in text.split_ascii_whitespace() {
        if let Some(side) = side_of(word.trim_end_matches('/')) {
            let start = word.as_ptr() as usize - text.as_ptr() as usize;
            let end = start + word.trim_end_matches('/').len();
            found = Some((&text[..start], side, &text[end..]));
            break;
        }
    }
    found
}

/// A tooth: digits, perhaps with some letters.
pub(super) fn is_tooth(word: &str) -> bool {
    let digits = word.bytes().take_while(u8::is_ascii_digit).count();
    let letters = &word[digits..];
    (1..=9).contains(&digits) && letters.len() <= 3 && letters.bytes().all(|b| b.is_ascii_alphabetic())
}

/// True if a line is the head of a trace, be it a sound one.
pub(super) fn is_trace_head(line: Line) -> bool {
    !matches!(parse(line), Ok(None))
}

/// The head that a line is; `None` for a line that is something else.
pub(super) fn parse(line: Line<'_>) -> Result<Option<TraceHead<'_>>, FileError> {
    if line.is_numeric() || !line.text.contains(':') {
        return Ok(None);
    }
    let Some((before, side, behind)) = split_side(line.text) else { return Ok(None) };
    let (labels, group) = match before.split_once('/') {
        Some((labels, group)) => (labels, Some(group.trim())),
        None => (before, None),
    };
    let Some((labels, tooth)) = labels.rsplit_once(':') else { return Ok(None) };
    let behind = behind.trim();
    let tooth = tooth.trim();
    if !is_tooth(tooth) {
        let means_values = behind.starts_with('/') || behind.contains('=');
        return if means_values { Err(line.expected(tooth, "a tooth such as 12 or 1k")) } else { Ok(None) };
    }
    let title = labels.rsplit_once(':').map(|(title, _)| title.trim());
    let group = match group {
        None => None,
        Some(group) => {
            let (word, index) = group.split_once(':').unwrap_or((group, ""));
            let index = index.trim();
            let number = index.parse().ok();
            if number.is_none() && !index.is_empty() {
                return Err(line.expected(index, "the number of the trace in its group"));
            }
            Some((word.trim(), number))
        }
    };
    let (count, rest) = count_of(line, behind)?;
    Ok(Some(TraceHead { title, tooth, group, side, count, section: section_of(line, rest)? }))
}

/// `/ 480 Werte`: the number and what follows it.
fn count_of<'a>(line: Line<'a>, behind: &'a str) -> Result<(Option<usize>, &'a str), FileError> {
    let text = behind.trim_start_matches('/').trim_start();
    let word = text.split_ascii_whitespace().next().unwrap_or_default();
    let no_count = !behind.starts_with('/') && word.bytes().all(|b| b.is_ascii_alphabetic());
    if word.is_empty() || word.contains('=') || no_count {
        return Ok((None, text));
    }
    let count = word.trim_end_matches('/').parse().map_err(|_| line.expected(word, "the number of values"))?;
    Ok((Some(count), &text[word.len()..]))
}

/// Section of a trace, `x= 8.742`, anywhere in the rest of a head.
fn section_of<'a>(line: Line<'a>, rest: &'a str) -> Result<Section, FileError> {
    let Some((letter, value)) = rest.split_once('=') else { return Ok(Section::NotGiven) };
    let letter = letter.trim_end();
    let start = letter
        .rfind(|c: char| !c.is_alphanumeric())
        .map_or(0, |at| at + letter[at..].chars().next().map_or(1, char::len_utf8));
    let letter = &letter[start..];
    let value = value.trim_start();
    let word = value.split_ascii_whitespace().next().unwrap_or(value);
    let value = number(word).ok_or_else(|| line.expected(word, "the place of the section, a number"))?;
    match letter {
        "x" | "X" => Ok(Section::RollLength(value)),
        "d" | "D" => Ok(Section::Diameter(value)),
        "z" | "Z" => Ok(Section::Z(value)),
        _ => Err(line.expected(letter, "x=, d= or z=")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::file_error::FilePosition;
    use super::*;

    fn head(text: &str) -> Option<TraceHead<'_>> {
        parse(Line { number: 1, text }).unwrap()
    }

    #[test]
    fn every_shape_of_a_head() {
        let plain = head("Zahn-Nr.: 44 links / 480  Werte  x= 8.742").unwrap();
        assert_eq!((plain.title, plain.tooth, plain.group, plain.side), (None, "44", None, Side::Left));
        assert_eq!((plain.count, plain.section), (Some(480), Section::RollLength(8.742)));
        let twist = head("Verschränkung: Zahn-Nr.: 1o /Profil:3 links / 480  Werte  z= 14").unwrap();
        assert_eq!((twist.title, twist.tooth, twist.group), (Some("Verschränkung"), "1o", Some(("Profil", Some(3)))));
        let old = head("TOPOGRAFIE: Zahn-Nr.: 26 /Profil:1 rechts / 480 Werte  / z= .5").unwrap();
        assert_eq!((old.side, old.count, old.section), (Side::Right, Some(480), Section::Z(0.5)));
        let one_line = head("Flankenlinie:  Zahn-Nr.: 1a rechts / 915 Werte / d= 47.82").unwrap();
        assert_eq!((one_line.title, one_line.section), (Some("Flankenlinie"), Section::Diameter(47.82)));
        let english = head("Lead: Tooth no.: 3 Left / 12 values d=51").unwrap();
        assert_eq!((english.tooth, english.side, english.count), ("3", Side::Left, Some(12)));
        let bare = head("Zahn-Nr.: 1 rechts").unwrap();
        assert_eq!((bare.count, bare.section), (None, Section::NotGiven));
    }

    #[test]
    fn other_lines_are_none_and_broken_heads_have_a_place() {
        for text in
            ["Flankenlinie:", "linke Zahnflanke", "Zahn-Nr. fp Fp Fr", "10111 : fHb links 1 : -2.9", "", "Teilung: "]
        {
            assert_eq!(head(text), None, "{text}");
        }
        for (text, column) in [
            ("Zahn-Nr.: ? links / 480 Werte x= 1", 11),
            ("Zahn-Nr.: 1 links / 4b0 Werte x= 1", 21),
            ("Zahn-Nr.: 1 links / 480 Werte q= 1", 31),
            ("Zahn-Nr.: 1 links / 480 Werte x= eins", 34),
            ("Zahn-Nr.: 1 links / 99999999999999999999 Werte x= 1", 21),
            ("T: Zahn-Nr.: 1 /Profil:a links / 480 Werte z= 1", 24),
        ] {
            let fault = parse(Line { number: 3, text }).unwrap_err();
            assert_eq!(fault.place(), Some(FilePosition { line: 3, column }), "{text}: {fault}");
        }
    }
}
