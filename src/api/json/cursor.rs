//! A position in a JSON text, and the strict grammar of RFC 8259 from there on.

use std::borrow::Cow;

use flankfit_engine::numerics::cancel;

/// Deepest nesting that is followed.
const DEEPEST: usize = 32;

/// Text that is not JSON: where, and what was wrong there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Syntax {
    pub at: usize,
    pub what: String,
}

/// Kind of the value at the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Token {
    Object,
    Array,
    String,
    Number,
    True,
    False,
    Null,
}

impl Token {
    /// For messages: `expected a number, found …`.
    pub fn name(self) -> &'static str {
        match self {
            Token::Object => "an object",
            Token::Array => "an array",
            Token::String => "a string",
            Token::Number => "a number",
            Token::True | Token::False => "a boolean",
            Token::Null => "null",
        }
    }
}

#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    text: &'a [u8],
    pub at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Cursor { text, at: 0 }
    }

    pub fn fault<T>(&self, what: impl Into<String>) -> Result<T, Syntax> {
        Err(Syntax { at: self.at, what: what.into() })
    }

    #[inline]
    pub fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// Bytes up to the next `]`.
    pub fn to_bracket(&self) -> usize {
        let rest = &self.text[self.at..];
        memchr::memchr(b']', rest).unwrap_or(rest.len())
    }

    /// Bytes up to the end of the text.
    pub fn to_end(&self) -> usize {
        self.text.len() - self.at
    }

    #[inline]
    pub fn skip_space(&mut self) {
        while let Some(b' ' | b'\n' | b'\r' | b'\t') = self.peek() {
            cancel::every(1, self.at);
            self.at += 1;
        }
    }

    /// Takes `byte` if it comes next (white space before it skipped).
    #[inline]
    pub fn takes(&mut self, byte: u8) -> bool {
        self.skip_space();
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    /// Takes `byte`, or reports the token found instead.
    pub fn expect(&mut self, byte: u8, place: &str) -> Result<(), Syntax> {
        if self.takes(byte) { Ok(()) } else { self.unexpected(&format!("`{}` {place}", char::from(byte))) }
    }

    /// The fault of finding something other than `wanted`.
    #[cold]
    pub fn unexpected<T>(&self, wanted: &str) -> Result<T, Syntax> {
        match self.peek() {
            None => self.fault(format!("the text ends where {wanted} is expected")),
            Some(byte) if byte.is_ascii_graphic() => {
                self.fault(format!("`{}` found where {wanted} is expected", char::from(byte)))
            }
            Some(byte) => self.fault(format!("the byte 0x{byte:02x} found where {wanted} is expected")),
        }
    }

    /// Which value begins here (white space before it skipped).
    pub fn token(&mut self) -> Result<Token, Syntax> {
        self.skip_space();
        match self.peek() {
            Some(b'{') => Ok(Token::Object),
            Some(b'[') => Ok(Token::Array),
            Some(b'"') => Ok(Token::String),
            Some(b'-' | b'0'..=b'9') => Ok(Token::Number),
            Some(b't') if self.word("true") => Ok(Token::True),
            Some(b'f') if self.word("false") => Ok(Token::False),
            Some(b'n') if self.word("null") => Ok(Token::Null),
            _ => self.not_a_value(),
        }
    }

    #[cold]
    fn not_a_value<T>(&self) -> Result<T, Syntax> {
        let rest = &self.text[self.at..];
        let unsigned = rest.strip_prefix(b"-").or(rest.strip_prefix(b"+")).unwrap_or(rest);
        let word = unsigned.iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
        let word = String::from_utf8_lossy(&unsigned[..word.min(16)]).to_ascii_lowercase();
        if matches!(word.as_str(), "nan" | "inf" | "infinity") {
            return self.fault(
                "NaN and Infinity are not JSON; to mark a node as missing, write null (or `valid`: false) in a grid, \
                 and omit the node from curves, scattered nodes and matrices",
            );
        }
        self.unexpected("a value")
    }

    fn word(&self, word: &str) -> bool {
        let rest = &self.text[self.at..];
        rest.starts_with(word.as_bytes()) && !rest.get(word.len()).is_some_and(u8::is_ascii_alphanumeric)
    }

    /// A number, correctly rounded; infinite above the range of double. −0 is read as 0, so that
    /// requests with the same digest have the same answer to the last sign.
    #[inline]
    pub fn number(&mut self) -> Result<f64, Syntax> {
        let rest = &self.text[self.at..];
        let digit = |i: usize| rest.get(i).is_some_and(u8::is_ascii_digit);
        let begin = usize::from(rest.first() == Some(&b'-'));
        if !digit(begin) {
            return self.not_a_value();
        }
        if rest[begin] == b'0' && digit(begin + 1) {
            return self.fault("a number begins with a superfluous 0");
        }
        let point = (begin..rest.len()).find(|i| !digit(*i)).filter(|i| rest[*i] == b'.');
        if let Some(point) = point.filter(|point| !digit(point + 1)) {
            self.at += point + 1;
            return self.unexpected("a digit after the decimal point");
        }
        // The parser is laxer than JSON only in what has just been looked at; an exponent without
        // digits it leaves in the text, where the next look finds it.
        match fast_float2::parse_partial::<f64, _>(rest) {
            Ok((value, length)) => {
                self.at += length;
                Ok(value + 0.0)
            }
            Err(_) => self.unexpected("a number"),
        }
    }

    /// A number, and how it is written.
    pub fn number_and_text(&mut self) -> Result<(f64, &'a [u8]), Syntax> {
        let begin = self.at;
        let value = self.number()?;
        Ok((value, &self.text[begin..self.at]))
    }

    /// A string; only one with escapes is copied.
    pub fn string(&mut self) -> Result<Cow<'a, str>, Syntax> {
        let begin = self.at + 1;
        let mut escapes = false;
        self.at = begin;
        loop {
            cancel::every(1, self.at);
            match self.peek() {
                None => return self.fault("the text ends inside a string"),
                Some(b'"') => break,
                Some(b'\\') => {
                    escapes = true;
                    self.at += 1;
                    match self.peek() {
                        Some(b'"' | b'\\' | b'/' | b'b' | b'f' | b'n' | b'r' | b't') => self.at += 1,
                        Some(b'u') => {
                            let digits = self.text.get(self.at + 1..self.at + 5);
                            if !digits.is_some_and(|digits| digits.iter().all(u8::is_ascii_hexdigit)) {
                                return self.fault("\\u is not followed by four hexadecimal digits");
                            }
                            self.at += 5;
                        }
                        _ => return self.fault("a string has an unknown escape"),
                    }
                }
                Some(0..0x20) => return self.fault("a string holds a control character"),
                Some(_) => self.at += 1,
            }
        }
        let inside = &self.text[begin..self.at];
        let Ok(plain) = std::str::from_utf8(inside) else {
            return Err(Syntax { at: begin, what: "a string is not UTF-8".into() });
        };
        self.at += 1;
        if !escapes {
            return Ok(Cow::Borrowed(plain));
        }
        serde_json::from_slice::<String>(&self.text[begin - 1..self.at])
            .map(Cow::Owned)
            .map_err(|_| Syntax { at: begin, what: "a string holds half a surrogate pair".into() })
    }

    /// Passes over one value, looking at its grammar.
    pub fn skip_value(&mut self) -> Result<&'a [u8], Syntax> {
        self.skip_space();
        let begin = self.at;
        self.skip_nested(0)?;
        Ok(&self.text[begin..self.at])
    }

    fn skip_nested(&mut self, depth: usize) -> Result<(), Syntax> {
        if depth > DEEPEST {
            return self.fault(format!("values are nested more than {DEEPEST} deep"));
        }
        match self.token()? {
            Token::Number => self.number().map(drop),
            Token::String => self.string().map(drop),
            Token::True | Token::Null => {
                self.at += 4;
                Ok(())
            }
            Token::False => {
                self.at += 5;
                Ok(())
            }
            Token::Array => self.array(|cursor, _| cursor.skip_nested(depth + 1)),
            Token::Object => self.object(|cursor, _| cursor.skip_nested(depth + 1)),
        }
    }

    /// Walks an array that begins here; `entry` takes each value.
    pub fn array(&mut self, mut entry: impl FnMut(&mut Self, usize) -> Result<(), Syntax>) -> Result<(), Syntax> {
        self.expect(b'[', "at the beginning of an array")?;
        if self.takes(b']') {
            return Ok(());
        }
        for i in 0.. {
            cancel::every(20, i);
            self.skip_space();
            entry(self, i)?;
            if self.takes(b']') {
                break;
            }
            self.expect(b',', "or `]` after an array's entry")?;
        }
        Ok(())
    }

    /// Walks an object that begins here; `entry` takes each value.
    pub fn object(
        &mut self,
        mut entry: impl FnMut(&mut Self, Cow<'a, str>) -> Result<(), Syntax>,
    ) -> Result<(), Syntax> {
        self.expect(b'{', "at the beginning of an object")?;
        if self.takes(b'}') {
            return Ok(());
        }
        loop {
            self.skip_space();
            if self.peek() != Some(b'"') {
                return self.unexpected("a key in quotes");
            }
            cancel::checkpoint();
            let key = self.string()?;
            self.expect(b':', "after a key")?;
            self.skip_space();
            entry(self, key)?;
            if self.takes(b'}') {
                return Ok(());
            }
            self.expect(b',', "or `}` after a value")?;
        }
    }

    /// Returns a cursor at the first member of this name of the well-formed object that begins
    /// here.
    pub fn member(&self, name: &str) -> Option<Self> {
        let mut found = None;
        // an error ends the walk
        let _ended = self.clone().object(|cursor, key| {
            if key == name {
                found = Some(cursor.clone());
                return cursor.fault("found");
            }
            cursor.skip_value().map(drop)
        });
        found
    }

    /// Nothing but white space may follow.
    pub fn end(&mut self) -> Result<(), Syntax> {
        self.skip_space();
        if self.at == self.text.len() { Ok(()) } else { self.fault("more text follows the request") }
    }
}

/// Line and column (from 1, in characters) of a byte.
pub fn line_and_column(text: &[u8], at: usize) -> (usize, usize) {
    let before = &text[..at.min(text.len())];
    let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
    let begin = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |i| i + 1);
    // Bytes that continue a character are not counted.
    let column = before[begin..].iter().filter(|&&byte| byte & 0xC0 != 0x80).count() + 1;
    (line, column)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn whole(text: &str) -> Result<(), Syntax> {
        let mut cursor = Cursor::new(text.as_bytes());
        cursor.skip_value()?;
        cursor.end()
    }

    #[test]
    fn the_grammar_is_that_of_json() {
        for good in
            ["0", "-0", "1e5", "1E+05", "0.5", "-12.25e-3", "[]", "{}", "[1,[2]]", r#"{"a":"\u00b5\n"}"#, " true "]
        {
            assert_eq!(whole(good), Ok(()), "{good}");
        }
        let numbers = "+1 01 -01 1. .5 -.5 1.e5 1e 1e+ 0x10 --1 - 1_000 1f 0b1 1..2 1.2.3 1e5.5";
        let others =
            "[1,] [,1] {a:1} {\"a\":1,} 'a' \"\\x\" \"\\ud800\" \"\u{1}\" tru nulll NaN nan -Infinity inf [1 { \"";
        for bad in numbers.split(' ').chain(others.split(' ')).chain(["", "1 2", r#"{"a" 1}"#, "\u{feff}1"]) {
            assert!(whole(bad).is_err(), "{bad}");
        }
        assert!(whole(&"[".repeat(100_000)).is_err());
    }

    #[test]
    fn missing_nodes_are_explained() {
        for text in ["NaN", "nan", "-Infinity", "Infinity", "-inf", "+Infinity"] {
            let fault = whole(text).unwrap_err();
            assert!(fault.what.contains("missing") && fault.what.contains("null"), "{text}: {}", fault.what);
        }
    }

    #[test]
    fn places_are_counted_in_lines_and_characters() {
        assert_eq!(line_and_column(b"ab", 1), (1, 2));
        assert_eq!(line_and_column("a\nµx".as_bytes(), 4), (2, 2));
        assert_eq!(line_and_column(b"", 9), (1, 1));
    }

    #[test]
    fn ties_and_long_numbers_are_rounded_to_nearest() {
        let half = "1.00000000000000011102230246251565404236316680908203125";
        let long = format!("0.{}1e400", "0".repeat(399));
        for (text, value) in [
            ("9007199254740993", 9_007_199_254_740_992.0),
            ("9007199254740995", 9_007_199_254_740_996.0),
            (half, 1.0),
            (&format!("{half}1"), 1.0 + f64::EPSILON),
            ("2.2250738585072011e-308", 2.225_073_858_507_201e-308),
            (&long, 1.0),
        ] {
            assert_eq!(Cursor::new(text.as_bytes()).number().unwrap(), value, "{text}");
        }
    }

    proptest! {
        #[test]
        fn numbers_come_back_bit_by_bit(bits in any::<u64>(), integer in any::<i64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite() && bits != (-0.0_f64).to_bits());
            for (text, value) in [
                (serde_json::to_string(&value).unwrap(), value),
                (format!("{value:.25e}"), value),
                (format!("{value:?}"), value),
                (format!("{integer}"), integer as f64),
            ] {
                let mut cursor = Cursor::new(text.as_bytes());
                prop_assert_eq!(cursor.number().unwrap().to_bits(), value.to_bits(), "{}", text);
                prop_assert_eq!(cursor.at, text.len());
            }
        }

        #[test]
        fn the_parser_accepts_what_serde_accepts(text in r#"[-+0-9.eE]{1,8}|[\[\]{},:"a1 \\-]{1,10}"#) {
            let mine = whole(&text).is_ok();
            let serde = serde_json::from_str::<serde_json::Value>(&text);
            // serde stops at a number above the range of double, which is well-formed here.
            prop_assume!(!serde.as_ref().is_err_and(|error| error.to_string().starts_with("number out of range")));
            prop_assert_eq!(mine, serde.is_ok(), "{}", text);
        }
    }
}
