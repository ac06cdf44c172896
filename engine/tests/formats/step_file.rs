//! A reader of ISO 10303-21: instances, simple and complex, and their parameters.

use std::collections::BTreeMap;

#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Reference(usize),
    Integer(i64),
    Real(f64),
    Text(String),
    Enumeration(String),
    List(Vec<Value>),
    Typed(String, Vec<Value>),
    Omitted,
    Derived,
}

impl Value {
    pub fn reference(&self) -> usize {
        match self {
            Value::Reference(id) => *id,
            other => panic!("{other:?} is not a reference"),
        }
    }

    pub fn integer(&self) -> usize {
        match self {
            Value::Integer(n) => usize::try_from(*n).expect("a count"),
            other => panic!("{other:?} is not an integer"),
        }
    }

    pub fn real(&self) -> f64 {
        match self {
            Value::Real(x) => *x,
            other => panic!("{other:?} is not a real"),
        }
    }

    pub fn list(&self) -> &[Value] {
        match self {
            Value::List(items) => items,
            other => panic!("{other:?} is not a list"),
        }
    }

    pub fn reals(&self) -> Vec<f64> {
        self.list().iter().map(Value::real).collect()
    }
}

/// Keywords with their parameters; one of them but for complex instances.
pub type Instance = Vec<(String, Vec<Value>)>;

#[derive(Debug)]
pub struct File {
    pub header: Instance,
    pub data: BTreeMap<usize, Instance>,
}

impl File {
    /// The parameters of all instances that have this keyword, in the order of the file.
    pub fn all(&self, keyword: &str) -> Vec<&[Value]> {
        let of = |instance: &'_ Instance| instance.iter().position(|(name, _)| name == keyword);
        self.data.values().filter_map(|i| of(i).map(|k| i[k].1.as_slice())).collect()
    }

    /// The parameters that the instance has under this keyword.
    pub fn part(&self, id: usize, keyword: &str) -> Option<&[Value]> {
        self.data[&id].iter().find(|(name, _)| name == keyword).map(|(_, values)| values.as_slice())
    }

    fn check(&self, value: &Value) {
        match value {
            Value::Reference(id) => assert!(self.data.contains_key(id), "#{id} is not there"),
            Value::List(items) | Value::Typed(_, items) => items.iter().for_each(|item| self.check(item)),
            _ => {}
        }
    }
}

pub fn read(text: &str) -> File {
    assert!(text.is_ascii());
    let text: String = text.chars().filter(|c| *c != '\n').collect();
    let mut reader = Reader { text: text.as_bytes(), at: 0 };
    reader.expect("ISO-10303-21;HEADER;");
    let mut header = Vec::new();
    while !reader.takes("ENDSEC;") {
        header.push(reader.record());
        reader.expect(";");
    }
    reader.expect("DATA;");
    let mut data = BTreeMap::new();
    while !reader.takes("ENDSEC;") {
        reader.expect("#");
        let id = reader.digits();
        reader.expect("=");
        let mut instance = Vec::new();
        if reader.takes("(") {
            while !reader.takes(")") {
                instance.push(reader.record());
            }
            let names: Vec<&String> = instance.iter().map(|(name, _)| name).collect();
            assert!(names.is_sorted(), "parts of a complex instance in alphabetical order: {names:?}");
        } else {
            instance.push(reader.record());
        }
        reader.expect(";");
        assert!(data.insert(id, instance).is_none(), "#{id} twice");
    }
    reader.expect("END-ISO-10303-21;");
    assert_eq!(reader.at, text.len());
    let file = File { header, data };
    for value in file.data.values().flatten().flat_map(|(_, values)| values) {
        file.check(value);
    }
    file
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn peek(&self) -> char {
        char::from(self.text[self.at])
    }

    fn takes(&mut self, word: &str) -> bool {
        let found = self.text[self.at..].starts_with(word.as_bytes());
        self.at += if found { word.len() } else { 0 };
        found
    }

    fn expect(&mut self, word: &str) {
        let rest = String::from_utf8_lossy(&self.text[self.at..(self.at + 60).min(self.text.len())]).into_owned();
        assert!(self.takes(word), "{word:?} expected at {rest:?}");
    }

    fn while_in(&mut self, wanted: impl Fn(char) -> bool) -> String {
        let start = self.at;
        while wanted(self.peek()) {
            self.at += 1;
        }
        String::from_utf8_lossy(&self.text[start..self.at]).into_owned()
    }

    fn digits(&mut self) -> usize {
        self.while_in(|c| c.is_ascii_digit()).parse().expect("digits")
    }

    fn record(&mut self) -> (String, Vec<Value>) {
        let name = self.while_in(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
        assert!(!name.is_empty());
        (name, self.list())
    }

    fn list(&mut self) -> Vec<Value> {
        self.expect("(");
        let mut items = Vec::new();
        if self.takes(")") {
            return items;
        }
        loop {
            items.push(self.value());
            if self.takes(")") {
                return items;
            }
            self.expect(",");
        }
    }

    fn value(&mut self) -> Value {
        match self.peek() {
            '(' => Value::List(self.list()),
            '#' => {
                self.expect("#");
                Value::Reference(self.digits())
            }
            '$' => {
                self.expect("$");
                Value::Omitted
            }
            '*' => {
                self.expect("*");
                Value::Derived
            }
            '.' => {
                self.expect(".");
                let name = self.while_in(|c| c.is_ascii_uppercase() || c == '_');
                self.expect(".");
                Value::Enumeration(name)
            }
            '\'' => self.text(),
            c if c.is_ascii_uppercase() => {
                let (name, values) = self.record();
                Value::Typed(name, values)
            }
            _ => self.number(),
        }
    }

    fn number(&mut self) -> Value {
        let word = self.while_in(|c| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'E'));
        let Some(point) = word.find('.') else { return Value::Integer(word.parse().expect("an integer")) };
        // digits before the point are obligatory, E may only follow it
        assert!(word[..point].ends_with(|c: char| c.is_ascii_digit()) && !word[..point].contains('E'), "{word}");
        Value::Real(word.parse().expect("a real"))
    }

    fn text(&mut self) -> Value {
        self.expect("'");
        let mut text = String::new();
        loop {
            if self.takes("''") {
                text.push('\'');
            } else if self.takes("'") {
                return Value::Text(text);
            } else if self.takes("\\\\") {
                text.push('\\');
            } else if self.takes("\\X2\\") || self.takes("\\X4\\") {
                let width = if self.text[self.at - 2] == b'2' { 4 } else { 8 };
                while !self.takes("\\X0\\") {
                    let code = std::str::from_utf8(&self.text[self.at..self.at + width]).expect("ASCII");
                    text.extend(char::from_u32(u32::from_str_radix(code, 16).expect("a code")));
                    self.at += width;
                }
            } else {
                assert!(self.peek() != '\\' && (' '..='~').contains(&self.peek()));
                text.push(self.peek());
                self.at += 1;
            }
        }
    }
}
