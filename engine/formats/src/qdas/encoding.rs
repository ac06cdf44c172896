//! The characters of a file: Windows-1252, which every reader takes for granted, where it has them
//! all, else UTF-8 behind a byte order mark.

/// Encoding of a file's characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Charset {
    /// The code page of Western Europe.
    Windows1252,
    /// Behind a byte order mark.
    Utf8,
}

/// First bytes of a file in UTF-8.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Characters of Windows-1252 from 0x80 to 0x9F; U+FFFD where it has none.
const UPPER: [char; 32] = [
    '€', '\u{fffd}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{fffd}', 'Ž', '\u{fffd}', '\u{fffd}',
    '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{fffd}', 'ž', 'Ÿ',
];

impl Charset {
    /// Its registered name.
    pub fn name(self) -> &'static str {
        match self {
            Charset::Windows1252 => "windows-1252",
            Charset::Utf8 => "utf-8",
        }
    }

    /// Encoding of bytes that [`encode`] made.
    pub fn of(bytes: &[u8]) -> Self {
        if bytes.starts_with(BYTE_ORDER_MARK) { Charset::Utf8 } else { Charset::Windows1252 }
    }
}

/// The bytes of a text.
pub fn encode(text: &str) -> Vec<u8> {
    let bytes: Option<Vec<u8>> = text.chars().map(byte).collect();
    match bytes {
        // those letters in a row would be taken for the mark
        Some(bytes) if Charset::of(&bytes) == Charset::Windows1252 => bytes,
        _ => [BYTE_ORDER_MARK, text.as_bytes()].concat(),
    }
}

fn byte(c: char) -> Option<u8> {
    match c {
        '\0'..='\u{7f}' | '\u{a0}'..='\u{ff}' => u8::try_from(u32::from(c)).ok(),
        // no character of a text, though its place is free
        '\u{fffd}' => None,
        _ => UPPER.iter().position(|upper| *upper == c).and_then(|at| u8::try_from(0x80 + at).ok()),
    }
}
