//! Nodes as CSV: a header `u,v,z[,weight]` (surface, scattered) or `x,y[,weight]` (curve), one node a line.
//!
//! An empty height is a missing node and is left out. Every other cell must hold a finite number with a decimal
//! point (−0 is 0); faults name line and column and point to the node's number among the lines.

use csv::{ByteRecord, ReaderBuilder, Trim};

use crate::estimation::{Faults, Nodes, words::counted};
use crate::numerics::cancel;

const SURFACE: [&str; 3] = ["u", "v", "z"];
const CURVE: [&str; 2] = ["x", "y"];

pub fn read(text: &[u8]) -> Result<Nodes, Faults> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let mut reader = ReaderBuilder::new().trim(Trim::All).flexible(true).from_reader(text);
    let header = match reader.byte_headers() {
        Ok(header) => header.clone(),
        Err(error) => return Err(Faults::one("/nodes", format!("the CSV cannot be read: {error}"))),
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
            Err(error) => {
                faults.push("/nodes", format!("the CSV cannot be read: {error}"));
                break;
            }
        }
        let line = record.position().map_or(0, csv::Position::line);
        read_line(&record, line, node, &names, axes.len() - 1, &mut arrays, &mut faults);
        node += 1;
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let weight = if weighted { arrays.pop() } else { None };
    let mut arrays = arrays.into_iter();
    let mut next = || arrays.next().unwrap_or_default();
    if axes.len() == SURFACE.len() {
        Nodes::scattered(next(), next(), next(), weight)
    } else {
        Nodes::curve(next(), next(), weight)
    }
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
) {
    if record.len() != names.len() {
        faults.push(
            "/nodes",
            format!("line {line}: {}, but the header has {}", counted(record.len(), "cell", "cells"), names.len()),
        );
        return;
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
}
