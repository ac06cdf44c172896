//! Rows as lines of text.

use jiff::Timestamp;
use serde_json::{Map, Value as Json};
use uuid::Uuid;

use super::table::{Kind, TABLES, Table};
use crate::jobs::audit::time_text;

/// What stands in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Null,
    Integer(i64),
    Real(f64),
    /// A text or a document.
    Text(String),
    Bytes(Vec<u8>),
    Id(Uuid),
    Time(Timestamp),
}

/// A row of one of the tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its place in [`TABLES`].
    pub table: usize,
    /// As many as the table has columns.
    pub values: Vec<Value>,
}

impl Row {
    pub fn table(&self) -> &'static Table {
        &TABLES[self.table]
    }

    /// What stands in a column, if the table has it.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.table().columns.iter().zip(&self.values).find(|(column, _)| column.name == name).map(|(_, value)| value)
    }

    /// Whether it lacks the content that a purge removes.
    pub fn is_emptied(&self) -> bool {
        let purged = ["nodes", "fit", "record", "stream", "block"].contains(&self.table().name);
        let is_empty = |value: &Value| match value {
            Value::Bytes(bytes) => bytes.is_empty(),
            Value::Text(text) => text.is_empty(),
            _ => false,
        };
        let mut columns = self.table().columns.iter().zip(&self.values);
        purged && columns.any(|(column, value)| matches!(column.kind, Kind::Document | Kind::Bytes) && is_empty(value))
    }

    /// `{"table":{"column":…}}`, without columns that hold nothing.
    pub fn to_line(&self) -> String {
        let mut line = format!("{{\"{}\":{{", self.table().name);
        let mut first = true;
        for (column, value) in self.table().columns.iter().zip(&self.values) {
            let text = match value {
                Value::Null => continue,
                Value::Integer(number) => number.to_string(),
                Value::Real(number) => format!("\"{:016x}\"", number.to_bits()),
                Value::Text(text) => Json::from(text.as_str()).to_string(),
                Value::Bytes(bytes) => format!("\"{}\"", to_hex(bytes)),
                Value::Id(id) => format!("\"{id}\""),
                Value::Time(time) => format!("\"{}\"", time_text(*time)),
            };
            line.push_str(if std::mem::take(&mut first) { "\"" } else { ",\"" });
            line.push_str(column.name);
            line.push_str("\":");
            line.push_str(&text);
        }
        line.push_str("}}\n");
        line
    }

    /// The row of [`Row::to_line`]; `None` of what is none.
    pub fn of_line(line: &str) -> Option<Self> {
        let Json::Object(row) = serde_json::from_str(line).ok()? else { return None };
        let mut named = row.into_iter();
        let (name, columns) = named.next()?;
        let table = TABLES.iter().position(|table| table.name == name)?;
        let Json::Object(mut columns) = columns else { return None };
        let read = |column: &super::Column| read(column.kind, columns.remove(column.name));
        let values = TABLES[table].columns.iter().map(read).collect::<Option<Vec<_>>>()?;
        (named.next().is_none() && Map::is_empty(&columns)).then_some(Row { table, values })
    }
}

fn read(kind: Kind, value: Option<Json>) -> Option<Value> {
    let text = match (kind, value) {
        (_, None) => return Some(Value::Null),
        (Kind::Integer, Some(number)) => return number.as_i64().map(Value::Integer),
        (_, Some(Json::String(text))) => text,
        _ => return None,
    };
    match kind {
        Kind::Integer => None,
        Kind::Real if text.len() == 16 => {
            u64::from_str_radix(&text, 16).ok().map(|bits| Value::Real(f64::from_bits(bits)))
        }
        Kind::Real => None,
        Kind::Text | Kind::Document => Some(Value::Text(text)),
        Kind::Bytes => of_hex(&text).map(Value::Bytes),
        Kind::Id => text.parse().ok().map(Value::Id),
        Kind::Time => text.parse().ok().map(Value::Time),
    }
}

/// Bytes in hexadecimal digits.
pub fn to_hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]).map(|digit| char::from(DIGITS[usize::from(digit)])).collect()
}

fn of_hex(text: &str) -> Option<Vec<u8>> {
    let digit = |digit: u8| char::from(digit).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
    let (pairs, rest) = text.as_bytes().as_chunks::<2>();
    let bytes = pairs.iter().map(|[high, low]| Some(digit(*high)? << 4 | digit(*low)?)).collect();
    rest.is_empty().then_some(bytes).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_comes_back_from_its_line_bit_for_bit() {
        let id = Uuid::from_u128(7);
        let time: Timestamp = "2026-11-21T08:00:00.000001Z".parse().unwrap();
        let of = |kind| match kind {
            Kind::Integer => Value::Integer(i64::MAX),
            Kind::Real => Value::Real(-0.0),
            Kind::Text | Kind::Document => Value::Text("\"\\\u{0}\u{1f600}\n".to_owned()),
            Kind::Bytes => Value::Bytes(vec![0, 255, 16]),
            Kind::Id => Value::Id(id),
            Kind::Time => Value::Time(time),
        };
        for (table, Table { columns, .. }) in TABLES.iter().enumerate() {
            let full = Row { table, values: columns.iter().map(|column| of(column.kind)).collect() };
            let empty = Row { table, values: vec![Value::Null; columns.len()] };
            for row in [full, empty] {
                let line = row.to_line();
                assert_eq!(line.matches('\n').count(), 1);
                assert_eq!(Row::of_line(&line).unwrap().to_line(), line);
                assert_eq!(Row::of_line(&line), Some(row));
            }
        }
    }

    #[test]
    fn what_is_no_row_is_none() {
        for line in [
            "",
            "{}",
            "[]",
            r#"{"job":1}"#,
            r#"{"state":{"sequence":"1"}}"#,
            r#"{"state":{"data":"0"}}"#,
            r#"{"state":{"data":"0g"}}"#,
            r#"{"state":{"other":1}}"#,
            r#"{"other":{}}"#,
            r#"{"state":{},"job":{}}"#,
            r#"{"stream":{"forgetting_factor":"1"}}"#,
            r#"{"state":{"sequence":null}}"#,
        ] {
            assert_eq!(Row::of_line(line), None, "{line}");
        }
    }
}
