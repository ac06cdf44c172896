//! The rows that the audit and the archive know: tables, columns and keys, declared once. The test
//! `tests/store/conformance/forgery.rs` compares this table with the schema.
//!
//! A row is read and written by these columns, has a line in the archive, a name in the entries of
//! the audit, and a digest.

use std::{borrow::Cow, collections::HashMap, fmt};

use jiff::Timestamp;
use serde::{
    Deserialize, Deserializer,
    de::{MapAccess, Visitor},
};
use serde_json::value::RawValue;
use uuid::Uuid;

use super::{
    audit::{Fields, Sha256Digest, time_text},
    encoded_text::EncodedText,
};

/// Declares the types of columns.
macro_rules! kinds {
    ($($(#[$about:meta])* $Kind:ident($of:ty),)+) => {
        /// Type of a column.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Kind {
            $($(#[$about])* $Kind,)+
        }

        /// A value of a column. A missing one has a type too, which PostgreSQL needs.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Value<'a> {
            $($Kind(Option<$of>),)+
        }

        impl Kind {
            /// Returns the missing value.
            pub fn none(self) -> Value<'static> {
                match self {
                    $(Kind::$Kind => Value::$Kind(None),)+
                }
            }
        }

        impl Value<'_> {
            pub fn kind(&self) -> Kind {
                match self {
                    $(Value::$Kind(_) => Kind::$Kind,)+
                }
            }
        }
    };
}

kinds! {
    Flag(bool),
    Integer(i64),
    Real(f64),
    Text(Cow<'a, str>),
    Bytes(Cow<'a, [u8]>),
    Id(Uuid),
    Time(Timestamp),
    /// A text that is stored compressed where it is long.
    Document(EncodedText),
}

impl Value<'_> {
    /// Returns the value as text: real numbers by the 16 hexadecimal digits of their bits, bytes by
    /// hexadecimal digits; none of a missing value.
    pub fn text(&self) -> Option<Cow<'_, str>> {
        Some(match self {
            Value::Flag(value) => Cow::Borrowed(if (*value)? { "true" } else { "false" }),
            Value::Integer(value) => value.as_ref()?.to_string().into(),
            Value::Real(value) => format!("{:016x}", value.as_ref()?.to_bits()).into(),
            Value::Text(value) => Cow::Borrowed(value.as_deref()?),
            Value::Bytes(value) => to_hex(value.as_deref()?).into(),
            Value::Id(value) => value.as_ref()?.to_string().into(),
            Value::Time(value) => time_text(*value.as_ref()?).into(),
            Value::Document(value) => Cow::Borrowed(&**value.as_ref()?.text()),
        })
    }

    pub fn integer(&self) -> Option<i64> {
        match self {
            Value::Integer(value) => *value,
            _ => None,
        }
    }
}

impl Kind {
    /// Returns the value of a JSON value: a number or a flag, or a text of [`Value::text`].
    fn read(self, json: &str) -> Option<Value<'static>> {
        let text = || serde_json::from_str::<String>(json).ok();
        let digits = |text: &String| text.len() == 16 && text.bytes().all(|digit| digit.is_ascii_hexdigit());
        Some(match self {
            Kind::Flag => Value::Flag(Some(serde_json::from_str(json).ok()?)),
            Kind::Integer => Value::Integer(Some(serde_json::from_str(json).ok()?)),
            Kind::Real => Value::Real(Some(f64::from_bits(u64::from_str_radix(&text().filter(digits)?, 16).ok()?))),
            Kind::Text => Value::Text(Some(text()?.into())),
            Kind::Bytes => Value::Bytes(Some(of_hex(&text()?)?.into())),
            Kind::Id => Value::Id(Some(text()?.parse().ok()?)),
            Kind::Time => Value::Time(Some(text()?.parse().ok()?)),
            Kind::Document => Value::Document(Some(text()?.into())),
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    pub name: &'static str,
    pub kind: Kind,
}

/// How long a row of a table is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Life {
    /// It is inserted once, and stays.
    Stays,
    /// It is changed in place, and counts its changes by a `version`, the last part of its key.
    Changes,
    /// The blocks of a stream are there until it is finished; only the last state is there at all.
    Passes,
}

/// A table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    pub name: &'static str,
    /// Statement's condition for the rows of a job `$1` of a tenant `$2`, or of a tenant `$1`.
    pub of: &'static str,
    /// Number of columns, from the first on, that name a row within its job or tenant.
    pub key: usize,
    pub life: Life,
    pub columns: &'static [Column],
}

macro_rules! tables {
    ($($table:ident ($key:literal, $life:ident, $of:expr): { $($column:ident: $kind:ident),+ $(,)? })+) => {
        &[$(Table {
            name: stringify!($table),
            of: $of,
            key: $key,
            life: Life::$life,
            columns: &[$(Column { name: stringify!($column), kind: Kind::$kind }),+],
        }),+]
    };
}

const OF_JOB: &str = "job = (SELECT id FROM jobs WHERE id = $1 AND tenant = $2)";
const OF_STREAM: &str =
    "stream IN (SELECT s.id FROM streams s JOIN jobs j ON j.id = s.job WHERE j.id = $1 AND j.tenant = $2)";

/// The tables of a job. In this order rows can be stored: each refers to rows before it.
pub const OF_JOBS: &[Table] = tables! {
    jobs (1, Changes, "id = $1 AND tenant = $2"): {
        version: Integer, name: Text, part_number: Text, serial_number: Text, machine: Text, gear: Text,
        requirements: Text, tags: Text, created_at: Time, updated_at: Time,
    }
    iterations (1, Stays, OF_JOB): {
        number: Integer, id: Id, measured_at: Time, instrument: Text, operator: Text, note: Text, flank: Text,
        tooth: Text, axes: Text, created_at: Time,
    }
    nodes (1, Stays, OF_JOB): { number: Integer, count: Integer, data: Bytes }
    fits (2, Stays, OF_JOB): {
        number: Integer, position: Integer, id: Id, reason: Text, actor: Text, created_at: Time, lambda_star: Real,
        criterion: Text, scheme: Text, count: Integer, condition: Real, regularized_condition: Real, bias_norm: Real,
        bias_sharp_bound: Real, rms: Real, max_abs: Real, flank_figures: Text, spec: Document, coefficients: Document,
        prior: Document, result: Document,
    }
    fit_choices (2, Stays, OF_JOB): {
        number: Integer, position: Integer, fit: Integer, reason: Text, actor: Text, created_at: Time,
    }
    decisions (2, Stays, OF_JOB): {
        number: Integer, position: Integer, decision: Text, concession: Integer, reason: Text, actor: Text,
        created_at: Time,
    }
    records (2, Stays, OF_JOB): {
        number: Integer, position: Integer, id: Id, kind: Text, method: Text, class: Integer, measurand: Text,
        actor: Text, created_at: Time, gear: Text, request: Document, result: Document,
    }
    streams (2, Changes, OF_JOB): {
        id: Id, version: Integer, forgetting_factor: Real, sequence: Integer, node_count: Integer,
        input_sha256: Bytes, flank: Text, tooth: Text, axes: Text, iteration: Integer, created_at: Time,
        updated_at: Time, spec: Document,
    }
    stream_blocks (2, Passes, OF_STREAM): {
        stream: Id, sequence: Integer, sha256: Bytes, count: Integer, created_at: Time, data: Bytes,
    }
    stream_states (2, Passes, OF_STREAM): { stream: Id, sequence: Integer, data: Bytes }
    purges (0, Stays, OF_JOB): { at: Time, reason: Text }
    events (1, Stays, OF_JOB): {
        number: Integer, kind: Text, iteration: Integer, fit: Integer, position: Integer, record: Id, stream: Id,
        state: Text, sequence: Integer, node_count: Integer, created_at: Time,
    }
};

/// The entries of a job, which follow its rows in an archive. (An import is of the database that it
/// came into.)
pub const ENTRIES: &Table = &tables! {
    audit (1, Stays, "job = $1 AND tenant = $2 AND action <> 'job.import'"): {
        id: Id, at: Time, actor: Text, action: Text, subject: Text, request_id: Text, peer: Text, contents: Bytes,
        salt: Bytes, who: Bytes,
    }
}[0];

/// The tables of a tenant.
pub const OF_TENANTS: &[Table] = tables! {
    tenants (2, Changes, "name = $1"): {
        name: Text, version: Integer, id: Id, description: Text, suspended: Flag, created_at: Time, updated_at: Time,
    }
    api_keys (2, Changes, "tenant = $1"): {
        id: Text, version: Integer, name: Text, role: Text, scopes: Text, sha256: Bytes, san: Text, created_at: Time,
        expires_at: Time, revoked_at: Time, replaced_by: Text,
    }
};

impl Table {
    /// Returns the table of a name.
    pub fn named(name: &str) -> Option<&'static Table> {
        OF_JOBS.iter().chain([ENTRIES]).chain(OF_TENANTS).find(|table| table.name == name)
    }

    /// Returns the names of the columns as a statement has them.
    pub fn list(&self) -> String {
        self.columns.iter().map(|column| column.name).collect::<Vec<_>>().join(", ")
    }

    /// Returns the columns of the key as a statement has them; of a table with at most one row for
    /// a job a column.
    pub fn order(&self) -> String {
        self.columns[..self.key.max(1)].iter().map(|column| column.name).collect::<Vec<_>>().join(", ")
    }

    /// Returns the name of a row in the entries of the audit: `decisions/3/1`.
    pub fn row_name(&self, values: &[Value<'_>]) -> String {
        let key = values[..self.key].iter().map(|value| value.text().unwrap_or_default());
        key.fold(self.name.to_owned(), |name, part| name + "/" + &part)
    }

    /// Returns the digest of a row: of the salt, the name of the table, and name and value of each
    /// column that has a value.
    pub fn digest(&self, salt: &[u8], values: &[Value<'_>]) -> Sha256Digest {
        let start = Fields::default().bytes(salt).text(self.name);
        let columns = self.columns.iter().zip(values);
        columns
            .fold(start, |fields, (column, value)| match value {
                Value::Bytes(Some(bytes)) => fields.text(column.name).bytes(bytes),
                value => match value.text() {
                    Some(text) => fields.text(column.name).text(&text),
                    None => fields,
                },
            })
            .digest()
    }

    /// Returns the place of each column among names in another order and number.
    pub fn places(&self, names: &str) -> Vec<Option<usize>> {
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        self.columns.iter().map(|column| names.iter().position(|name| *name == column.name)).collect()
    }

    /// Returns the values of a row from those at these places.
    pub fn pick<'a>(&self, places: &[Option<usize>], values: &[Value<'a>]) -> Vec<Value<'a>> {
        let value = |(column, place): (&Column, &Option<usize>)| {
            place.map_or(column.kind.none(), |place| values[place].clone())
        };
        self.columns.iter().zip(places).map(value).collect()
    }
}

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub table: &'static Table,
    /// In the order of the columns.
    pub values: Vec<Value<'static>>,
}

/// Why a line is no row: the column, where one is at fault, and the cause.
pub type NoRow = (Option<&'static str>, &'static str);

impl Row {
    /// Returns the value of a column; a missing one of a table that has no such column.
    pub fn value(&self, name: &str) -> &Value<'static> {
        let place = self.table.columns.iter().position(|column| column.name == name);
        place.map_or(&Value::Integer(None), |place| &self.values[place])
    }

    pub fn name(&self) -> String {
        self.table.row_name(&self.values)
    }

    /// Returns the line of the archive, `{"table":{"column":…}}`, in the order of the columns and
    /// without missing values.
    pub fn to_line(&self) -> String {
        let mut line = format!("{{\"{}\":{{", self.table.name);
        let values = self.table.columns.iter().zip(&self.values);
        let texts = values.filter_map(|(column, value)| Some((column, value.text()?)));
        for (k, (column, text)) in texts.enumerate() {
            let is_plain = matches!(column.kind, Kind::Integer | Kind::Flag);
            let text = if is_plain { text } else { serde_json::to_string(&text).unwrap_or_default().into() };
            line += &format!("{}\"{}\":{text}", if k > 0 { "," } else { "" }, column.name);
        }
        line + "}}\n"
    }

    /// Returns the row of a line. Values of no column take no more memory than their text.
    pub fn of_line(line: &str) -> Result<Self, NoRow> {
        const NONE: NoRow = (None, "it is no row of an archive of this version");
        let Members(tables): Members<Members<Box<RawValue>>> = serde_json::from_str(line).map_err(|_| NONE)?;
        let mut tables = tables.into_iter();
        let (Some((name, columns)), None) = (tables.next(), tables.next()) else { return Err(NONE) };
        let table = OF_JOBS.iter().chain([ENTRIES]).find(|table| table.name == name).ok_or(NONE)?;
        let mut values: Vec<Value<'_>> = table.columns.iter().map(|column| column.kind.none()).collect();
        for (name, value) in columns.0 {
            let place = table.columns.iter().position(|column| column.name == name).ok_or(NONE)?;
            let Column { name, kind } = table.columns[place];
            values[place] = kind.read(value.get()).ok_or((Some(name), "it is of another type"))?;
        }
        Ok(Row { table, values })
    }
}

/// Members of an object, none of which may occur twice.
struct Members<T>(HashMap<String, T>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Members<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Members(HashMap::new()))
    }
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for Members<T> {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object without repeated members")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<Self, A::Error> {
        while let Some((name, value)) = map.next_entry()? {
            if self.0.insert(name, value).is_some() {
                return Err(serde::de::Error::custom("a member occurs twice"));
            }
        }
        Ok(self)
    }
}

/// Returns bytes in hexadecimal digits.
pub fn to_hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]).map(|digit| char::from(DIGITS[usize::from(digit)])).collect()
}

/// Returns the bytes of hexadecimal digits.
pub fn of_hex(text: &str) -> Option<Vec<u8>> {
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
        let of = |kind| match kind {
            Kind::Flag => Value::Flag(Some(true)),
            Kind::Integer => Value::Integer(Some(i64::MAX)),
            Kind::Real => Value::Real(Some(-0.0)),
            Kind::Text => Value::Text(Some("\"\\\u{0}\u{1f600}\n".into())),
            Kind::Document => Value::Document(Some("\"\\\u{0}\u{1f600}\n".into())),
            Kind::Bytes => Value::Bytes(Some(vec![0, 255, 16].into())),
            Kind::Id => Value::Id(Some(Uuid::from_u128(7))),
            Kind::Time => Value::Time(Some("2026-11-21T08:00:00.000001Z".parse().unwrap())),
        };
        for table in OF_JOBS.iter().chain([ENTRIES]) {
            let full = Row { table, values: table.columns.iter().map(|column| of(column.kind)).collect() };
            let empty = Row { table, values: table.columns.iter().map(|column| column.kind.none()).collect() };
            for row in [full, empty] {
                let line = row.to_line();
                assert_eq!(line.matches('\n').count(), 1);
                let back = Row::of_line(&line).unwrap();
                assert_eq!(back.to_line(), line);
                assert_eq!(back.table.digest(&[7], &back.values), row.table.digest(&[7], &row.values));
            }
        }
    }

    #[test]
    fn a_line_that_is_no_row_is_refused_with_its_column() {
        let state = |rest: &str| format!(r#"{{"stream_states":{{{rest}}}}}"#);
        for (line, column) in [
            (String::new(), None),
            ("[]".to_owned(), None),
            (r#"{"other":{}}"#.to_owned(), None),
            (state(r#""other":1"#), None),
            (state(r#""sequence":"1""#), Some("sequence")),
            (state(r#""sequence":null"#), Some("sequence")),
            (state(r#""sequence":[1]"#), Some("sequence")),
            (state("") + "]", None),
            (state(r#""sequence":1,"sequence":2"#), None),
            (r#"{"streams":{},"streams":{}}"#.to_owned(), None),
            (r#"{"stream_states":{},"streams":{}}"#.to_owned(), None),
            (state(r#""data":"0""#), Some("data")),
            (state(r#""data":"0g""#), Some("data")),
            (r#"{"streams":{"forgetting_factor":"1"}}"#.to_owned(), Some("forgetting_factor")),
        ] {
            assert_eq!(Row::of_line(&line).unwrap_err().0, column, "{line}");
        }
    }
}
