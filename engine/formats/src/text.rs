//! Names and remarks in the alphabets that formats allow.

/// A string of ISO 10303-21, quotes included: apostrophe and backslash doubled, everything outside
/// of printable ASCII by its code (`\X2\` four, `\X4\` eight hexadecimal digits for each
/// character).
pub(super) fn step_string(text: &str) -> String {
    #[derive(PartialEq)]
    enum Run {
        Plain,
        Two,
        Four,
    }
    let mut out = String::from("'");
    let mut run = Run::Plain;
    for c in text.chars() {
        let wanted = match c {
            ' '..='~' => Run::Plain,
            '\0'..='\u{ffff}' => Run::Two,
            _ => Run::Four,
        };
        if wanted != run {
            if run != Run::Plain {
                out.push_str("\\X0\\");
            }
            out.push_str(match wanted {
                Run::Plain => "",
                Run::Two => "\\X2\\",
                Run::Four => "\\X4\\",
            });
            run = wanted;
        }
        match (c, &run) {
            ('\'', _) => out.push_str("''"),
            ('\\', _) => out.push_str("\\\\"),
            (_, Run::Plain) => out.push(c),
            (_, Run::Two) => out.push_str(&format!("{:04X}", u32::from(c))),
            (_, Run::Four) => out.push_str(&format!("{:08X}", u32::from(c))),
        }
    }
    out.push_str(if run == Run::Plain { "'" } else { "\\X0\\'" });
    out
}

/// Printable ASCII in one line, for formats that know nothing else; what has no place there becomes
/// `?`, white space a blank.
pub(super) fn ascii(text: &str) -> String {
    let shown = |c: char| match c {
        ' '..='~' => c,
        c if c.is_whitespace() => ' ',
        _ => '?',
    };
    text.chars().map(shown).collect()
}

/// A string of IGES: its length, `H`, and its characters; nothing at all for no text, which is how
/// IGES leaves a field out.
pub(super) fn hollerith(text: &str) -> String {
    let text = ascii(text);
    if text.is_empty() { text } else { format!("{}H{text}", text.len()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_strings_by_the_standard() {
        assert_eq!(step_string(""), "''");
        assert_eq!(step_string("it's a \\"), "'it''s a \\\\'");
        assert_eq!(step_string("Zahn ä€\n"), "'Zahn \\X2\\00E420AC000A\\X0\\'");
        assert_eq!(step_string("é𝄞b"), "'\\X2\\00E9\\X0\\\\X4\\0001D11E\\X0\\b'");
    }

    #[test]
    fn hollerith_counts_the_written_characters() {
        assert_eq!(hollerith("a,b;"), "4Ha,b;");
        assert_eq!(hollerith("Zähne\n"), "6HZ?hne ");
        assert_eq!(hollerith(""), "");
    }
}
