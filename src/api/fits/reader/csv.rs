//! Nodes as CSV: a header `u,v,z[,weight]` (surface, scattered) or `x,y[,weight]` (curve), one node
//! a line.
//!
//! An empty height is a missing node and is left out. Every other cell must hold a finite number
//! with a decimal point (−0 is 0); faults name line and column and point to the node's number among
//! the lines. NaN and Infinity are refused as in JSON: with them the table is none that can be
//! read, whatever else it holds.

use csv::{ByteRecord, ReaderBuilder, Trim};

use crate::api::{faults::Faults, json::error::ReadError};
use flankfit_engine::{estimation::Nodes, fault::words::counted, numerics::cancel};

const SURFACE: [&str; 3] = ["u", "v", "z"];
const CURVE: [&str; 2] = ["x", "y"];

/// A number that is none, by its place.
struct NoNumber {
    line: u64,
    column: usize,
}

pub fn read(text: &[u8]) -> Result<Nodes, ReadError> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let mut reader = ReaderBuilder::new().trim(Trim::All).flexible(true).from_reader(text);
    let header = match reader.byte_headers() {
        Ok(header) => header.clone(),
        Err(error) => return Err(unreadable(&error)),
    };
    let names: Vec<String> = header.iter().map(|name| String::from_utf8_lossy(name).into_owned()).collect();
    let (axes, weighted) = columns(&names)?;

    let mut arrays = vec![Vec::new(); names.len()];
    let mut faults = Faults::default();
    let mut record = ByteRecord::new();
    let mut node = 0;
    loop {
        cancel::checkpoint();
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => return Err(unreadable(&error)),
        }
        let line = record.position().map_or(0, csv::Position::line);
        let read = read_line(&record, line, node, &names, axes.len() - 1, &mut arrays, &mut faults);
        if let Err(NoNumber { line, column }) = read {
            let detail = format!(
                "Line {line}, column {column}: NaN and Infinity are no numbers of a table; leave the height \
                 empty where a node is missing."
            );
            return Err(ReadError::Malformed { detail });
        }
        node += 1;
    }
    faults.into_result(())?;
    let weight = if weighted { arrays.pop() } else { None };
    let mut arrays = arrays.into_iter();
    let mut next = || arrays.next().unwrap_or_default();
    Ok(if axes.len() == SURFACE.len() {
        Nodes::scattered(next(), next(), next(), weight)?
    } else {
        Nodes::curve(next(), next(), weight)?
    })
}

fn unreadable(error: &csv::Error) -> ReadError {
    ReadError::Malformed { detail: format!("The table of nodes cannot be read: {error}.") }
}

/// Which of the two forms the header has, and whether there are weights.
fn columns(names: &[String]) -> Result<(&'static [&'static str], bool), Faults> {
    for axes in [SURFACE.as_slice(), CURVE.as_slice()] {
        if let Some(rest) = names.strip_prefix_of(axes) {
            match rest {
                [] => return Ok((axes, false)),
                [name] if name == "weight" => return Ok((axes, true)),
                _ => {}
            }
        }
    }
    let mut got = names.join(",");
    if got.len() > 64 {
        got = got.chars().take(64).collect::<String>() + "…";
    }
    Err(Faults::one(
        "/nodes",
        format!("line 1: the header is `{got}`; it is u,v,z or x,y, then weight if there are weights"),
    ))
}

trait StripPrefix {
    fn strip_prefix_of(&self, prefix: &[&str]) -> Option<&[String]>;
}

impl StripPrefix for [String] {
    fn strip_prefix_of(&self, prefix: &[&str]) -> Option<&[String]> {
        let (head, rest) = self.split_at_checked(prefix.len())?;
        head.iter().zip(prefix).all(|(a, b)| a == b).then_some(rest)
    }
}

fn read_line(
    record: &ByteRecord,
    line: u64,
    node: usize,
    names: &[String],
    height: usize,
    arrays: &mut [Vec<f64>],
    faults: &mut Faults,
) -> Result<(), NoNumber> {
    if record.len() != names.len() {
        faults.push(
            "/nodes",
            format!("line {line}: {}, but the header has {}", counted(record.len(), "cell", "cells"), names.len()),
        );
        return Ok(());
    }
    let missing = record[height].is_empty();
    for (column, (cell, name)) in record.iter().zip(names).enumerate() {
        if missing && column == height {
            continue;
        }
        match fast_float2::parse::<f64, _>(cell) {
            Ok(value) if value.is_finite() => {
                if !missing {
                    arrays[column].push(value + 0.0);
                }
            }
            _ if is_no_number(cell) => return Err(NoNumber { line, column: column + 1 }),
            _ => {
                let mut text = String::from_utf8_lossy(cell).into_owned();
                if text.len() > 32 {
                    text = text.chars().take(32).collect::<String>() + "…";
                }
                faults.push(
                    format!("/nodes/{name}/{node}"),
                    format!("line {line}, column {} ({name}): `{text}` is not a finite number", column + 1),
                );
            }
        }
    }
    Ok(())
}

/// Whether a cell is one of the words for what is no number.
fn is_no_number(cell: &[u8]) -> bool {
    let word = cell.strip_prefix(b"-").or(cell.strip_prefix(b"+")).unwrap_or(cell);
    ["nan", "inf", "infinity"].iter().any(|known| word.eq_ignore_ascii_case(known.as_bytes()))
}
