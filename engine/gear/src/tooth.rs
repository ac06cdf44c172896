//! Names of teeth, as traces and iterations carry them. This is the only place that reads one.
//!
//! A tooth is called by its number from 1, `12`; what follows the number belongs to the name,
//! and one letter of four says where on the flank a trace lies, `12k`. Names that are no numbers
//! are allowed, since instruments have them (`B`, `master`), and are compared as they stand. A
//! number is written in one way: `01`, `+1` and ` 1` would be further names of tooth 1, `-1` and
//! `1.5` are of no tooth.

use std::fmt;

/// Position of a trace on its flank, as the letter after the tooth's number says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Position {
    /// No letter of the four below: the trace that counts in means.
    #[default]
    Middle,
    /// `f`: a helix near the root.
    Root,
    /// `k`: a helix near the tip.
    Tip,
    /// `u`: a profile at the lower end, of small z.
    Lower,
    /// `o`: a profile at the upper end, of great z.
    Upper,
}

impl Position {
    /// Reads `44`, `1k`, `1u`; names that are not a number with one letter lie in the middle.
    pub fn of(tooth: &str) -> Self {
        Self::split(tooth).1
    }

    /// The number that a tooth's name begins with; `None` for names of another kind.
    pub fn number(tooth: &str) -> Option<u64> {
        let digits = digits(tooth);
        // more digits than a number takes are of no gear either
        (digits > 0).then(|| tooth[..digits].parse().unwrap_or(u64::MAX))
    }

    /// The tooth's own name and the position.
    pub fn split(tooth: &str) -> (&str, Self) {
        let number = tooth.trim_end_matches(['f', 'k', 'u', 'o']);
        let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
        let position = match &tooth[number.len()..] {
            "f" => Position::Root,
            "k" => Position::Tip,
            "u" => Position::Lower,
            "o" => Position::Upper,
            _ => Position::Middle,
        };
        if digits && position != Position::Middle { (number, position) } else { (tooth, Position::Middle) }
    }
}

/// Error in the name of a tooth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NameFault {
    /// Nothing, or blanks only.
    Blank,
    /// Another way to write the name that is held here.
    Spelled(String),
    /// A number that no tooth has: 0, below 0, a fraction.
    NotCounted,
}

impl fmt::Display for NameFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NameFault::Blank => f.write_str("a tooth has a number or a name"),
            NameFault::Spelled(right) => {
                let shown: String = right.chars().take(20).collect();
                write!(f, "write `{shown}` for this tooth")
            }
            NameFault::NotCounted => f.write_str("no tooth has this number; write a whole number from 1, or a name"),
        }
    }
}

/// Refuses a name that is not written as its tooth is known by.
pub fn check_name(name: &str) -> Result<(), NameFault> {
    match canonical(name)? {
        right if right == name => Ok(()),
        right => Err(NameFault::Spelled(right)),
    }
}

/// The name that the tooth is known by: `1` of `01`, ` 1` and `+1`, `1k` of `01k`.
pub fn canonical(name: &str) -> Result<String, NameFault> {
    let text = name.trim();
    if text.is_empty() {
        return Err(NameFault::Blank);
    }
    let (sign, unsigned) = match text.strip_prefix(['+', '-', '−']) {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => (text.chars().next(), rest),
        _ => (None, text),
    };
    let (number, behind) = unsigned.split_at(digits(unsigned));
    if number.is_empty() {
        // `.5`; `inf` is a name
        let fraction = text.contains(|c: char| c.is_ascii_digit()) && text.parse::<f64>().is_ok();
        return if fraction { Err(NameFault::NotCounted) } else { Ok(text.to_owned()) };
    }
    let number = number.trim_start_matches('0');
    // `1.5`, `1,5`, `1e3`
    let fraction = !behind.is_empty() && unsigned.replace(',', ".").parse::<f64>().is_ok();
    if number.is_empty() || fraction || sign.is_some_and(|sign| sign != '+') {
        return Err(NameFault::NotCounted);
    }
    Ok(format!("{number}{behind}"))
}

/// How many digits a text begins with.
fn digits(text: &str) -> usize {
    text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tooth_has_one_name() {
        for name in ["1", "12", "1k", "1a", "44ku", "3 left", "B", "master", "inf", "dedendum side", "#1", "-", "+a"] {
            assert_eq!(check_name(name), Ok(()), "{name}");
        }
        for (name, right) in [
            ("01", "1"),
            (" 1", "1"),
            ("1 ", "1"),
            ("+1", "1"),
            ("+007", "7"),
            ("01k", "1k"),
            ("\u{a0}1", "1"),
            (" B ", "B"),
        ] {
            assert_eq!(check_name(name), Err(NameFault::Spelled(right.to_owned())), "{name}");
            assert_eq!(check_name(right), Ok(()));
        }
        for name in ["-1", "−1", "-1k", "0", "00", "0k", "1.5", "1.0", "1.", ".5", "-.5", "+1.5", "1,5", "1e3", " 1e-3"]
        {
            assert_eq!(check_name(name), Err(NameFault::NotCounted), "{name}");
        }
        assert_eq!((check_name(""), check_name("  ")), (Err(NameFault::Blank), Err(NameFault::Blank)));
    }

    /// Any text is refused as a name, or is read as one that is its own canonical form.
    #[test]
    fn canonical_tooth_names_are_their_own_canonical_form() {
        const LETTERS: [char; 12] = ['0', '1', '9', '.', ',', '+', '-', ' ', 'k', 'e', 'B', '−'];
        for code in 0..12usize.pow(4) {
            let name: String = (0..4).map(|place| LETTERS[code / 12usize.pow(place) % 12]).collect();
            if let Ok(right) = canonical(&name) {
                assert_eq!(canonical(&right), Ok(right.clone()), "{name:?}");
                assert_eq!(check_name(&right), Ok(()), "{name:?}");
                assert_ne!(Position::number(&right), Some(0), "{name:?}");
            }
        }
    }
}
