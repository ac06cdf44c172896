//! The object `nodes`: arrays as they stood, then a checked node set.

use serde::de::DeserializeOwned;
use utoipa::ToSchema;

use crate::api::{
    faults::Faults,
    json::{
        cursor::{Cursor, Syntax, Token},
        location::escape,
        members::ReadInPassing,
        numbers::Numbers,
        text::control_character,
        value::read_value,
        wording::no_such_field,
    },
};
use flankfit_engine::{
    estimation::Nodes,
    numerics::check,
    words::{counted, entries},
};

/// The fields of all four types, before the type is known (it may come last).
#[derive(Default)]
pub struct RawNodes<'a> {
    kind: Option<&'a [u8]>,
    x: Option<Numbers>,
    y: Option<Numbers>,
    u: Option<Numbers>,
    v: Option<Numbers>,
    z: Option<Numbers>,
    weight: Option<Numbers>,
    valid: Option<&'a [u8]>,
    names: Option<&'a [u8]>,
    /// Keys that no type has, keys that stand twice, and a value that is no object.
    faults: Faults,
}

impl<'a> ReadInPassing<'a> for RawNodes<'a> {
    fn read(cursor: &mut Cursor<'a>) -> Result<Self, Syntax> {
        let mut raw = RawNodes::default();
        match cursor.token()? {
            Token::Object => {}
            other => {
                raw.faults.push("/nodes", format!("expected an object, found {}", other.name()));
                cursor.skip_value()?;
                return Ok(raw);
            }
        }
        cursor.object(|cursor, key| raw.read_field(cursor, &key))?;
        Ok(raw)
    }
}

impl<'a> RawNodes<'a> {
    /// The node set of a request that must have one.
    pub fn required(raw: Option<Self>, faults: &mut Faults) -> Option<Nodes> {
        let Some(raw) = raw else {
            faults.push_missing("/nodes", "required");
            return None;
        };
        raw.check().map_err(|found| faults.append(found)).ok()
    }

    fn read_field(&mut self, cursor: &mut Cursor<'a>, key: &str) -> Result<(), Syntax> {
        const KNOWN: [&str; 9] = ["type", "x", "y", "u", "v", "z", "weight", "valid", "names"];
        if cursor.token()? == Token::Null && KNOWN.contains(&key) {
            return cursor.skip_value().map(drop);
        }
        let twice = match key {
            "x" => self.x.replace(Numbers::read(cursor)?).is_some(),
            "y" => self.y.replace(Numbers::read(cursor)?).is_some(),
            "u" => self.u.replace(Numbers::read(cursor)?).is_some(),
            "v" => self.v.replace(Numbers::read(cursor)?).is_some(),
            "z" => self.z.replace(Numbers::read(cursor)?).is_some(),
            "weight" => self.weight.replace(Numbers::read(cursor)?).is_some(),
            "type" => self.kind.replace(cursor.skip_value()?).is_some(),
            "valid" => self.valid.replace(cursor.skip_value()?).is_some(),
            "names" => self.names.replace(cursor.skip_value()?).is_some(),
            other => {
                self.faults.push_with(format!("/nodes/{}", escape(other)), || no_such_field(other, &KNOWN));
                cursor.skip_value()?;
                false
            }
        };
        if twice {
            self.faults.push(format!("/nodes/{key}"), "the field occurs twice; give it once");
        }
        Ok(())
    }

    /// The node set, or every fault.
    pub fn check(mut self) -> Result<Nodes, Faults> {
        let mut faults = std::mem::take(&mut self.faults);
        let Some(kind) = self.kind else {
            if faults.is_empty() {
                faults.push_missing("/nodes/type", "missing; it is curve, scattered, grid or matrix");
            }
            return Err(faults);
        };
        let Some(kind) = read_value::<String>(kind, "/nodes/type", &mut faults) else { return Err(faults) };
        let known: &[&str] = match kind.as_str() {
            "curve" => &["x", "y", "weight"],
            "scattered" => &["u", "v", "z", "weight"],
            "grid" => &["u", "v", "z", "valid", "weight"],
            "matrix" => &["x", "y", "names", "weight"],
            other => {
                faults.push("/nodes/type", format!("`{other}` is unknown; it is curve, scattered, grid or matrix"));
                return Err(faults);
            }
        };
        self.refuse_others(&kind, known, &mut faults);
        match kind.as_str() {
            "curve" => {
                let x = flat(self.x, "x", &mut faults);
                let y = flat(self.y, "y", &mut faults);
                let weight = self.weight.and_then(|w| flat(Some(w), "weight", &mut faults));
                let (Some(x), Some(y)) = (x, y) else { return Err(faults) };
                finish(faults, || Nodes::curve(x, y, weight))
            }
            "scattered" => {
                let u = flat(self.u, "u", &mut faults);
                let v = flat(self.v, "v", &mut faults);
                let z = flat(self.z, "z", &mut faults);
                let weight = self.weight.and_then(|w| flat(Some(w), "weight", &mut faults));
                let (Some(u), Some(v), Some(z)) = (u, v, z) else { return Err(faults) };
                finish(faults, || Nodes::scattered(u, v, z, weight))
            }
            "grid" => self.grid(faults),
            _ => self.matrix(faults),
        }
    }

    /// Fields that belong to other types.
    fn refuse_others(&self, kind: &str, known: &[&str], faults: &mut Faults) {
        let there = [
            ("x", self.x.is_some()),
            ("y", self.y.is_some()),
            ("u", self.u.is_some()),
            ("v", self.v.is_some()),
            ("z", self.z.is_some()),
            ("weight", self.weight.is_some()),
            ("valid", self.valid.is_some()),
            ("names", self.names.is_some()),
        ];
        for (key, _) in there.into_iter().filter(|(key, there)| *there && !known.contains(key)) {
            faults.push(format!("/nodes/{key}"), format!("nodes of type {kind} have no such field"));
        }
    }

    fn grid(self, mut faults: Faults) -> Result<Nodes, Faults> {
        let u = flat(self.u, "u", &mut faults);
        let v = flat(self.v, "v", &mut faults);
        let (Some(u), Some(v)) = (u, v) else { return Err(faults) };
        let shape = Some((u.len(), v.len()));
        let Some(z) = required(self.z, "z", &mut faults) else { return Err(faults) };
        let z = rows(z, "z", shape, true, &mut faults);
        let weight = self.weight.map(|weight| rows(weight, "weight", shape, false, &mut faults));
        let valid: Option<Vec<Vec<bool>>> = part(self.valid, "valid", &mut faults);
        if let Some(valid) = &valid {
            check_shape("valid", &valid.iter().map(Vec::len).collect::<Vec<_>>(), shape, &mut faults);
        }
        match (z, weight) {
            (Some((z, _)), None) => finish(faults, || Nodes::grid(u, v, z, valid.map(|v| v.concat()), None)),
            (Some((z, _)), Some(Some((weight, _)))) => {
                finish(faults, || Nodes::grid(u, v, z, valid.map(|v| v.concat()), Some(weight)))
            }
            _ => Err(faults),
        }
    }

    fn matrix(self, mut faults: Faults) -> Result<Nodes, Faults> {
        let x = required(self.x, "x", &mut faults);
        let y = flat(self.y, "y", &mut faults);
        let weight = self.weight.and_then(|weight| flat(Some(weight), "weight", &mut faults));
        let names: Option<Vec<String>> = part(self.names, "names", &mut faults);
        for (i, name) in names.iter().flatten().enumerate() {
            if let Some(refusal) = control_character(name, false) {
                faults.push(format!("/nodes/names/{i}"), refusal);
            }
        }
        let (Some(x), Some(y)) = (x, y) else { return Err(faults) };
        let Some((x, columns)) = rows(x, "x", None, false, &mut faults) else { return Err(faults) };
        finish(faults, || Nodes::matrix(x, columns, y, names, weight))
    }
}

/// Builds the nodes. The errors of reading come first; errors of the check about the NaN in place
/// of a refused value are dropped.
fn finish(mut faults: Faults, build: impl FnOnce() -> Result<Nodes, check::Faults>) -> Result<Nodes, Faults> {
    if faults.count() >= Faults::MOST {
        return Err(faults);
    }
    match build() {
        Ok(nodes) => faults.into_result(nodes),
        Err(found) => {
            let found = Faults::of_engine("/nodes", &found);
            for fault in found.list() {
                if !faults.list().iter().any(|known| known.pointer == fault.pointer) {
                    faults.push(fault.pointer.as_str(), fault.detail.as_str());
                }
            }
            for _ in found.list().len()..found.count() {
                faults.push("", "");
            }
            Err(faults)
        }
    }
}

fn required(numbers: Option<Numbers>, key: &str, faults: &mut Faults) -> Option<Numbers> {
    if numbers.is_none() {
        faults.push_missing(format!("/nodes/{key}"), "required");
    }
    numbers
}

/// A plain array of numbers.
fn flat(numbers: Option<Numbers>, key: &str, faults: &mut Faults) -> Option<Vec<f64>> {
    let numbers = required(numbers, key, faults)?;
    let pointer = format!("/nodes/{key}");
    if numbers.rows.is_some() {
        faults.push(pointer, "expected an array of numbers, found an array of arrays");
        return None;
    }
    numbers.report(&pointer, false, faults);
    (!numbers.no_array).then_some(numbers.values)
}

/// Rows of equal length, end to end, and that length. Without a `shape` the first row gives it.
fn rows(
    numbers: Numbers,
    key: &str,
    shape: Option<(usize, usize)>,
    null_is_missing: bool,
    faults: &mut Faults,
) -> Option<(Vec<f64>, usize)> {
    let pointer = format!("/nodes/{key}");
    if numbers.rows.is_none() && numbers.arrays > 0 {
        // what is wrong is the entry that made the others look like none
        faults.push(format!("{pointer}/0"), "expected a row of numbers, as others here are");
        return None;
    }
    numbers.report(&pointer, null_is_missing, faults);
    if numbers.no_array {
        return None;
    }
    let lengths = match &numbers.rows {
        Some(lengths) => lengths.as_slice(),
        None if numbers.values.is_empty() => &[],
        None => {
            faults.push(pointer, "expected an array of rows, found an array of numbers");
            return None;
        }
    };
    let columns = shape.map_or(lengths.first().copied().unwrap_or(0), |(_, columns)| columns);
    check_shape(key, lengths, shape, faults).then_some((numbers.values, columns))
}

fn check_shape(key: &str, lengths: &[usize], shape: Option<(usize, usize)>, faults: &mut Faults) -> bool {
    let mut fits = true;
    let (columns, whose) = match shape {
        Some((count, columns)) => {
            if lengths.len() != count {
                faults.push(
                    format!("/nodes/{key}"),
                    format!(
                        "{}, but u has {}",
                        counted(lengths.len(), "row", "rows"),
                        counted(count, "position", "positions")
                    ),
                );
                fits = false;
            }
            (columns, format!("v has {}", counted(columns, "position", "positions")))
        }
        None => {
            let columns = lengths.first().copied().unwrap_or(0);
            (columns, format!("the first row has {columns}"))
        }
    };
    for (i, length) in lengths.iter().enumerate().filter(|(_, length)| **length != columns) {
        fits = false;
        // what is no row at all has been said
        let place = format!("/nodes/{key}/{i}");
        if *length > 0 || faults.list().iter().all(|fault| fault.pointer != place) {
            faults.push(place, format!("{}, but {whose}", entries(*length)));
        }
    }
    fits
}

fn part<T: DeserializeOwned + ToSchema>(slice: Option<&[u8]>, key: &str, faults: &mut Faults) -> Option<T> {
    read_value(slice?, &format!("/nodes/{key}"), faults)
}
