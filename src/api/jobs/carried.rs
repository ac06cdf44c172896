//! Rows of jobs imported from a file. Every value that is later answered is read here by the reader
//! of its type before any row is stored.

use std::collections::BTreeMap;

use serde::de::{DeserializeOwned, IgnoredAny};

use crate::{
    api::{
        gears::{gear, requirements::RequirementsBody},
        measurand::axes::AxesBody,
    },
    jobs::{
        archive::{Row, Value},
        nodes_codec,
    },
};

/// Numbers are answered as JSON, which clients read as doubles.
const LARGEST: i64 = (1 << 53) - 1;

/// A JSON object of any members.
type Object = BTreeMap<String, IgnoredAny>;

/// Checks every column; the error names the first unreadable one and the cause.
pub fn check(row: &Row) -> Result<(), String> {
    let table = row.table().name;
    for (column, value) in row.table().columns.iter().zip(&row.values) {
        check_value(table, column.name, value, row.value("count"))
            .map_err(|why| format!("`{}` of `{table}` cannot be read: {why}", column.name))?;
    }
    Ok(())
}

fn check_value(table: &str, column: &str, value: &Value, count: Option<&Value>) -> Result<(), String> {
    match (table, column, value) {
        (_, _, Value::Integer(number)) if !(0..=LARGEST).contains(number) => {
            Err(format!("{number} is not between 0 and {LARGEST}"))
        }
        ("job" | "record", "gear", Value::Text(text)) => {
            gear::of_text(text).map(drop).map_err(|problem| problem.cause.unwrap_or(problem.detail))
        }
        ("job", "requirements", Value::Text(text)) => read::<RequirementsBody>(text),
        ("job", "tags", Value::Text(text)) => read::<BTreeMap<String, String>>(text),
        ("iteration" | "stream", "axes", Value::Text(text)) => read::<AxesBody>(text),
        ("fit", "spec" | "result" | "flank_figures", Value::Text(text))
        | ("record", "request" | "result" | "measurand", Value::Text(text))
        | ("stream", "spec", Value::Text(text))
            // empty in a purged job
            if !text.is_empty() =>
        {
            read::<Object>(text)
        }
        ("nodes" | "block", "data", Value::Bytes(bytes)) if !bytes.is_empty() => {
            let nodes = nodes_codec::decode(bytes).map_err(|error| error.to_string())?;
            match count {
                Some(Value::Integer(count)) if i64::try_from(nodes.posted()) == Ok(*count) => Ok(()),
                _ => Err(format!("it holds {} nodes, which `count` does not say", nodes.posted())),
            }
        }
        _ => Ok(()),
    }
}

fn read<T: DeserializeOwned>(text: &str) -> Result<(), String> {
    serde_json::from_str::<T>(text).map(drop).map_err(|error| error.to_string())
}
