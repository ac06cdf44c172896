//! REXS as JSON (`.rexsj`): the same components, attributes and relations under names of their own.

use super::{
    super::{
        file_error::{FileError, shown},
        source::{number, place_in},
    },
    base64::Code,
    document::{Attribute, Component, DEEPEST, Document, Relation, Value},
};
use flankfit_numerics::cancel;

/// A value with the place where it begins.
struct Item<'a> {
    offset: usize,
    value: Json<'a>,
}

/// A value of a JSON text. Numbers are kept as written.
enum Json<'a> {
    Null,
    Text(String),
    /// A number, `true` or `false`.
    Word(&'a str),
    List(Vec<Item<'a>>),
    Object(Vec<(String, Item<'a>)>),
}

impl<'a> Item<'a> {
    fn get(&self, name: &str) -> Option<&Item<'a>> {
        let Json::Object(members) = &self.value else { return None };
        members.iter().find(|(key, _)| key == name).map(|(_, item)| item)
    }

    fn list(&self, name: &str) -> &[Item<'a>] {
        match self.get(name).map(|item| &item.value) {
            Some(Json::List(items)) => items,
            _ => &[],
        }
    }

    /// Returns the text of a member; an id may be a number.
    fn text(&self, name: &str) -> Option<String> {
        match &self.get(name)?.value {
            Json::Text(text) => Some(text.clone()),
            Json::Word(word) => Some((*word).to_owned()),
            _ => None,
        }
    }
}

/// Reads a model.
pub(super) fn parse(text: &str) -> Result<Document, FileError> {
    let mut parser = Parser { text, at: 0 };
    let whole = parser.value(0)?;
    parser.blank();
    if parser.at < text.len() {
        return Err(parser.expected("the end of the file"));
    }
    let fault = |offset: usize, expected: &'static str, found: &str| FileError::Expected {
        place: place_in(text, offset),
        expected,
        found: shown(found),
    };
    let model = whole.get("model").ok_or_else(|| FileError::Unsupported {
        place: place_in(text, whole.offset),
        what: "a JSON file without a `model`; of JSON files only REXS is read".into(),
    })?;
    let mut document = Document::default();
    let version = model.text("version").unwrap_or_default();
    document.set_version(&version, place_in(text, model.offset))?;
    for relation in model.list("relations") {
        let parts = relation.list("refs").iter();
        let parts = parts.map(|part| (part.text("role").unwrap_or_default(), part.text("id").unwrap_or_default()));
        document.push(Relation { kind: relation.text("type").unwrap_or_default(), parts: parts.collect() });
    }
    for item in model.list("components") {
        cancel::checkpoint();
        let kind = item.text("type").unwrap_or_default();
        if !Component::is_kept(&kind) {
            continue;
        }
        let id = item.text("id").ok_or_else(|| fault(item.offset, "a component with an id", &kind))?;
        let mut attributes = Vec::new();
        for attribute in item.list("attributes") {
            let id = attribute.text("id").unwrap_or_default();
            if let Some(value) = Attribute::is_kept(&id).then(|| value_of(attribute)) {
                let value = value.map_err(|expected| fault(attribute.offset, expected, &id))?;
                let unit = attribute.text("unit").unwrap_or_default();
                attributes.extend(value.map(|value| Attribute { id, unit, value, offset: attribute.offset }));
            }
        }
        document.components.push(Component { id, kind, name: item.text("name"), attributes, offset: item.offset });
    }
    Ok(document)
}

/// Returns the value of an attribute, whose key is the name of its type; `None` if it is null.
fn value_of(attribute: &Item) -> Result<Option<Value>, &'static str> {
    let Json::Object(members) = &attribute.value else { return Err("an attribute") };
    let Some((kind, item)) = members.iter().find(|(name, _)| name != "id" && name != "unit") else { return Ok(None) };
    const NUMBERS: &str = "a list of numbers";
    let number = |item: &Item| match &item.value {
        Json::Word(word) => number(word).ok_or(NUMBERS),
        Json::Null => Ok(f64::NAN),
        Json::Text(text) if text.eq_ignore_ascii_case("nan") => Ok(f64::NAN),
        _ => Err(NUMBERS),
    };
    Ok(Some(match &item.value {
        Json::Null => return Ok(None),
        Json::Text(text) => Value::Text(text.clone()),
        Json::Word(word) => Value::Text((*word).to_owned()),
        Json::List(rows) if kind.ends_with("_matrix") => {
            let mut values = Vec::new();
            let mut width = None;
            for row in rows {
                let Json::List(cells) = &row.value else { return Err("rows of a matrix") };
                if *width.get_or_insert(cells.len()) != cells.len() {
                    return Err("rows of the same number of columns");
                }
                for cell in cells {
                    values.push(number(cell)?);
                }
            }
            Value::Matrix { columns: width.unwrap_or_default(), values }
        }
        Json::List(items) => Value::Array(items.iter().map(number).collect::<Result<_, _>>()?),
        Json::Object(_) => {
            let code = item.text("code").and_then(|code| Code::named(&code));
            let code = code.ok_or("the code int32, float32 or float64")?;
            let text = item.text("value").unwrap_or_default();
            let values = code.numbers(&text).ok_or("numbers of that code in base64")?;
            match item.text("columns").and_then(|columns| columns.parse::<usize>().ok()) {
                None => Value::Array(values),
                Some(columns) if columns > 0 && values.len().is_multiple_of(columns) => {
                    Value::Matrix { columns, values }
                }
                Some(_) => return Err("whole rows of as many columns as the matrix says"),
            }
        }
    }))
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn blank(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start_matches([' ', '\t', '\r', '\n']).len();
    }

    fn expected(&self, expected: &'static str) -> FileError {
        let found = self.rest().lines().next().unwrap_or_default();
        FileError::Expected { place: place_in(self.text, self.at), expected, found: shown(found) }
    }

    /// Consumes a sign if it comes next, after white space.
    fn takes(&mut self, sign: char) -> bool {
        self.blank();
        let here = self.rest().starts_with(sign);
        self.at += if here { sign.len_utf8() } else { 0 };
        here
    }

    fn value(&mut self, depth: usize) -> Result<Item<'a>, FileError> {
        cancel::checkpoint();
        self.blank();
        let offset = self.at;
        if depth > DEEPEST {
            let place = place_in(self.text, offset);
            return Err(FileError::TooMany { place, what: "values within one another", most: DEEPEST });
        }
        let value = match self.rest().bytes().next() {
            Some(b'{') => self.object(depth)?,
            Some(b'[') => self.array(depth)?,
            Some(b'"') => Json::Text(self.string()?),
            _ => {
                let word = self.rest();
                let end = word.find([',', '}', ']', ' ', '\t', '\r', '\n']).unwrap_or(word.len());
                let word = &word[..end];
                let known = matches!(word, "null" | "true" | "false") || number(word).is_some();
                if !known {
                    return Err(self.expected("a value"));
                }
                self.at += end;
                if word == "null" { Json::Null } else { Json::Word(word) }
            }
        };
        Ok(Item { offset, value })
    }

    fn object(&mut self, depth: usize) -> Result<Json<'a>, FileError> {
        self.at += 1;
        let mut members = Vec::new();
        if self.takes('}') {
            return Ok(Json::Object(members));
        }
        loop {
            self.blank();
            if !self.rest().starts_with('"') {
                return Err(self.expected("a name in quotes"));
            }
            let name = self.string()?;
            if !self.takes(':') {
                return Err(self.expected("a colon"));
            }
            members.push((name, self.value(depth + 1)?));
            if self.takes('}') {
                return Ok(Json::Object(members));
            }
            if !self.takes(',') {
                return Err(self.expected("a comma or the end of the object"));
            }
        }
    }

    fn array(&mut self, depth: usize) -> Result<Json<'a>, FileError> {
        self.at += 1;
        let mut items = Vec::new();
        if self.takes(']') {
            return Ok(Json::List(items));
        }
        loop {
            items.push(self.value(depth + 1)?);
            if self.takes(']') {
                return Ok(Json::List(items));
            }
            if !self.takes(',') {
                return Err(self.expected("a comma or the end of the list"));
            }
        }
    }

    /// Reads a quoted string that begins here.
    fn string(&mut self) -> Result<String, FileError> {
        let start = self.at;
        self.at += 1;
        let mut out = String::new();
        loop {
            let rest = self.rest();
            let Some(end) = rest.find(['"', '\\']) else {
                self.at = start;
                return Err(self.expected("a text that ends"));
            };
            out.push_str(&rest[..end]);
            self.at += end + 1;
            if rest[end..].starts_with('"') {
                return Ok(out);
            }
            let escape = self.rest().chars().next().unwrap_or_default();
            self.at += escape.len_utf8().min(self.rest().len());
            out.push(match escape {
                '"' | '\\' | '/' => escape,
                'b' => '\u{8}',
                'f' => '\u{c}',
                'n' => '\n',
                'r' => '\r',
                't' => '\t',
                'u' => self.escaped()?,
                _ => return Err(self.expected("an escape of JSON")),
            });
        }
    }

    /// Reads the character of `\uXXXX`, or of a surrogate pair.
    fn escaped(&mut self) -> Result<char, FileError> {
        let mut unit = || {
            let digits = self.rest().get(..4).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()));
            let value = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
            let value = value.ok_or_else(|| self.expected("four hexadecimal digits"))?;
            self.at += 4;
            Ok::<u32, FileError>(value)
        };
        let high = unit()?;
        if !(0xD800..0xDC00).contains(&high) {
            return Ok(char::from_u32(high).unwrap_or(char::REPLACEMENT_CHARACTER));
        }
        if !self.rest().starts_with("\\u") {
            return Ok(char::REPLACEMENT_CHARACTER);
        }
        self.at += 2;
        let low = self.rest().get(..4).and_then(|digits| u32::from_str_radix(digits, 16).ok());
        self.at += self.rest().chars().take(4).map(char::len_utf8).sum::<usize>();
        let low = low.filter(|low| (0xDC00..0xE000).contains(low));
        let pair = low.and_then(|low| char::from_u32(0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00)));
        Ok(pair.unwrap_or(char::REPLACEMENT_CHARACTER))
    }
}
