//! Rows of jobs imported from an archive. Every value that is later returned is read here by the
//! reader of its type before any row is stored.

use std::collections::BTreeMap;

use serde::de::{DeserializeOwned, IgnoredAny};

use crate::{
    api::{
        fits::reader::read_stored,
        gears::{gear, requirements::RequirementsBody},
        jobs::amendments::KnownMeasurandBody,
        measurand::axes::AxesBody,
        problem::Problem,
    },
    jobs::{
        EncodedResult, Figures,
        audit::Contents,
        is_state, nodes_codec,
        rows::{Row, Value},
    },
};

/// Numbers are returned as JSON, which clients read as doubles.
const LARGEST: i64 = (1 << 53) - 1;

/// A JSON object of any members.
type Object = BTreeMap<String, IgnoredAny>;

/// Checks every column; the error names the first unreadable one and the cause.
pub fn check(row: &Row) -> Result<(), String> {
    for (column, value) in row.table.columns.iter().zip(&row.values) {
        check_value(row, column.name, value).map_err(|why| format!("`{}`: {why}", column.name))?;
    }
    Ok(())
}

fn check_value(row: &Row, column: &str, value: &Value<'_>) -> Result<(), String> {
    if let Value::Integer(Some(number)) = value {
        let is_count = (0..=LARGEST).contains(number);
        return is_count.then_some(()).ok_or_else(|| format!("{number} is not between 0 and {LARGEST}"));
    }
    if let Value::Bytes(Some(bytes)) = value {
        return check_bytes(row, column, bytes);
    }
    // documents are empty in a purged job
    let Some(text) = value.text().filter(|text| !text.is_empty()) else { return Ok(()) };
    let text = &*text;
    match (row.table.name, column) {
        ("jobs" | "records", "gear") => gear::of_text(text).map(drop).map_err(cause),
        ("jobs", "requirements") => read::<RequirementsBody>(text),
        ("jobs", "tags") => read::<BTreeMap<String, String>>(text),
        ("iterations" | "streams", "axes") => read::<AxesBody>(text),
        ("fits" | "streams", "spec") => read_stored(text).map(drop).map_err(|error| cause(error.into())),
        ("fits", "criterion") => known(Figures::criterion_named(text)),
        ("fits", "scheme") => known(Figures::scheme_named(text)),
        ("fits", "result") => check_result(row, text),
        ("fits", "flank_figures") | ("records", "request" | "result") => read::<Object>(text),
        ("records", "measurand") => read::<KnownMeasurandBody>(text),
        _ => Ok(()),
    }
}

fn check_bytes(row: &Row, column: &str, bytes: &[u8]) -> Result<(), String> {
    match (row.table.name, column) {
        ("nodes" | "stream_blocks", "data") if !bytes.is_empty() => {
            let nodes = nodes_codec::decode(bytes).map_err(|error| error.to_string())?;
            match row.value("count").integer() {
                Some(count) if i64::try_from(nodes.posted()) == Ok(count) => Ok(()),
                _ => Err(format!("it has {} nodes, not as many as `count` says", nodes.posted())),
            }
        }
        ("stream_states", "data") => known(is_state(bytes).then_some(())),
        ("audit", "contents") => known(Contents::read(bytes)),
        _ => Ok(()),
    }
}

/// Checks a result, and that what is stored of it once more is the same.
fn check_result(row: &Row, text: &str) -> Result<(), String> {
    read::<Object>(text)?;
    let kept = EncodedResult::from(text);
    let same = [("coefficients", &kept.kept_parts().coefficients), ("prior", &kept.kept_parts().prior)]
        .into_iter()
        .find(|(name, kept)| row.value(name).text().as_deref() != kept.as_deref());
    same.map_or(Ok(()), |(name, _)| Err(format!("`{name}` differs from the result")))
}

fn cause(problem: Problem) -> String {
    let first = problem.errors.first().map(|error| format!("{}: {}", error.pointer, error.detail));
    problem.cause.or(first).unwrap_or(problem.detail)
}

fn known<T>(value: Option<T>) -> Result<(), String> {
    value.map(drop).ok_or_else(|| "it is not one that is known".to_owned())
}

fn read<T: DeserializeOwned>(text: &str) -> Result<(), String> {
    serde_json::from_str::<T>(text).map(drop).map_err(|error| error.to_string())
}
