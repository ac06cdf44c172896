//! Lists of points as CSV: `id,x,y,z[,i,j,k]`, mm and directions.
//!
//! A header is optional; with one, columns are found by their names (`id x y z i j k`, in any
//! order), without one by their number: 3 (x y z), 4 (id first), 6 (with i j k) or 7. The separator
//! is a tab, a semicolon or a comma, whichever comes first in that order on the first line. Numbers
//! have a point, or all of them a comma where that is not the separator. Lines that begin with `#`
//! are remarks. Fields may stand in double quotes.

use std::{borrow::Cow, fmt::Write as _};

use super::{
    fault::ExportFault,
    file_error::FileError,
    number::real,
    source::{Line, Lines, decode, number},
};
use crate::geometry::space::Vector;
use crate::numerics::cancel::Asking;

/// A point of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPoint {
    /// Identifier of the point, where the list has one.
    pub id: Option<String>,
    /// mm.
    pub point: Vector,
    /// i, j, k as given, not zero and not normalised.
    pub direction: Option<Vector>,
    /// Line in its file, from 1; 0 for a point that comes from elsewhere.
    pub line: usize,
}

/// Names of the columns, in the order in which they are written.
const NAMES: [&str; 7] = ["id", "x", "y", "z", "i", "j", "k"];

/// Reads a list of points.
///
/// ```
/// use flankfit_engine::formats::points;
///
/// // Decimal commas and semicolons, as a German spreadsheet writes them.
/// let list = points::read("id;x;y;z\nP1;1,5;-2;0,25\n".as_bytes())?;
/// assert_eq!(list[0].id.as_deref(), Some("P1"));
/// assert_eq!((list[0].point.x, list[0].point.z), (1.5, 0.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Vec<ListedPoint>, FileError> {
    parse(&decode(bytes)?)
}

/// Whether a text's first line looks like one of a list: by a header with x, y, z, or by numbers in
/// a count that a list can have.
pub(super) fn looks_like_points(text: &str) -> bool {
    let Some(line) = data_lines(text).next() else { return false };
    let separator = separator_of(line.text);
    let Ok(fields) = split(line, separator) else { return false };
    if Columns::named(&fields).is_some_and(|columns| columns.is_ok()) {
        return true;
    }
    let coordinates = match fields.len() {
        3 | 6 => &fields[..],
        4 | 7 => &fields[1..],
        _ => return false,
    };
    coordinates.iter().all(|field| number(&field.text.replace(',', ".")).is_some())
}

pub(super) fn parse(text: &str) -> Result<Vec<ListedPoint>, FileError> {
    let mut lines = data_lines(text).peekable();
    let Some(first) = lines.peek().copied() else { return Err(FileError::Empty) };
    let separator = separator_of(first.text);
    let fields = split(first, separator)?;
    let columns = match Columns::named(&fields) {
        Some(columns) => {
            lines.next();
            columns.map_err(|(field, expected)| first.expected(field, expected))?
        }
        None => Columns::counted(fields.len())
            .ok_or_else(|| first.expected(first.text, "3, 4, 6 or 7 columns (id, x, y, z, i, j, k)"))?,
    };
    let mut marks = Marks { separator, seen: None };
    let mut points = Vec::new();
    for line in lines.asking(1000) {
        points.push(point_of(line, &columns, &mut marks)?);
    }
    Ok(points)
}

/// Lines that are neither blank nor remarks.
fn data_lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    Lines::new(text).filter(|line| !line.is_blank() && !line.text.trim_start().starts_with('#'))
}

fn separator_of(line: &str) -> char {
    ['\t', ';', ','].into_iter().find(|c| line.contains(*c)).unwrap_or(',')
}

/// A field with the part of the line that it is.
#[derive(Clone, Debug)]
struct Field<'a> {
    text: Cow<'a, str>,
    part: &'a str,
}

/// The fields of a line, without blanks and quotes around them.
fn split(line: Line<'_>, separator: char) -> Result<Vec<Field<'_>>, FileError> {
    let mut fields = Vec::new();
    let mut rest = line.text;
    loop {
        let start = rest.trim_start_matches(' ');
        if start.starts_with('"') {
            let (text, behind) = quoted(start).ok_or_else(|| line.expected(start, "a closing quote"))?;
            let part = &start[..start.len() - behind.len()];
            fields.push(Field { text: text.into(), part });
            let behind = behind.trim_start_matches(' ');
            if behind.is_empty() {
                return Ok(fields);
            }
            rest = behind
                .strip_prefix(separator)
                .ok_or_else(|| line.expected(behind, "the separator after a closing quote"))?;
            continue;
        }
        let (field, behind) = match rest.split_once(separator) {
            Some((field, behind)) => (field, Some(behind)),
            None => (rest, None),
        };
        let part = if field.trim().is_empty() { field } else { field.trim() };
        fields.push(Field { text: field.trim().into(), part });
        match behind {
            Some(behind) => rest = behind,
            None => return Ok(fields),
        }
    }
}

/// A quoted field and what follows it; two quotes are one.
fn quoted(text: &str) -> Option<(String, &str)> {
    let mut out = String::new();
    let mut rest = text.strip_prefix('"')?;
    loop {
        let (piece, behind) = rest.split_once('"')?;
        out.push_str(piece);
        match behind.strip_prefix('"') {
            Some(more) => {
                out.push('"');
                rest = more;
            }
            None => return Some((out, behind)),
        }
    }
}

/// Where each of [`NAMES`] stands.
#[derive(Debug)]
struct Columns {
    at: [Option<usize>; 7],
    count: usize,
}

impl Columns {
    /// By a header: `None` if the line is none, since it has a number where a name would be.
    fn named<'a>(fields: &[Field<'a>]) -> Option<Result<Self, (&'a str, &'static str)>> {
        let is_name = |field: &Field| NAMES.iter().any(|name| field.text.eq_ignore_ascii_case(name));
        if !fields.iter().any(is_name) || fields.iter().any(|field| number(&field.text).is_some()) {
            return None;
        }
        let mut at = [None; 7];
        for (column, field) in fields.iter().enumerate() {
            let Some(name) = NAMES.iter().position(|name| field.text.eq_ignore_ascii_case(name)) else {
                return Some(Err((field.part, "one of the columns id, x, y, z, i, j, k")));
            };
            if at[name].replace(column).is_some() {
                return Some(Err((field.part, "each column once")));
            }
        }
        let last = fields.last().map_or("", |field| field.part);
        if at[1..4].contains(&None) {
            return Some(Err((last, "the columns x, y and z")));
        }
        if at[4..].iter().any(Option::is_some) && at[4..].contains(&None) {
            return Some(Err((last, "all of the columns i, j and k, or none")));
        }
        Some(Ok(Columns { at, count: fields.len() }))
    }

    fn counted(count: usize) -> Option<Self> {
        let from = |first: usize, last: usize| {
            let mut at = [None; 7];
            for (column, name) in (first..=last).enumerate() {
                at[name] = Some(column);
            }
            Some(Columns { at, count })
        };
        match count {
            3 => from(1, 3),
            4 => from(0, 3),
            6 => from(1, 6),
            7 => from(0, 6),
            _ => None,
        }
    }
}

/// Which mark separates decimals, settled by the first number that has one.
struct Marks {
    separator: char,
    seen: Option<char>,
}

impl Marks {
    fn number(&mut self, line: Line, field: &Field) -> Result<f64, FileError> {
        let text = &field.text;
        let comma = self.separator != ',' && text.contains(',');
        let mark = if comma { Some(',') } else { text.contains('.').then_some('.') };
        if let Some(mark) = mark
            && *self.seen.get_or_insert(mark) != mark
        {
            return Err(line.expected(field.part, "the decimal mark that the numbers before it have"));
        }
        let value = if comma && !text.contains('.') { number(&text.replacen(',', ".", 1)) } else { number(text) };
        value.ok_or_else(|| line.expected(field.part, "a number"))
    }
}

fn point_of(line: Line, columns: &Columns, marks: &mut Marks) -> Result<ListedPoint, FileError> {
    let fields = split(line, marks.separator)?;
    if fields.len() != columns.count {
        let part = fields.get(columns.count).map_or("", |field| field.part);
        return Err(line.expected(
            if part.is_empty() { &line.text[line.text.len()..] } else { part },
            "as many columns as the first line has",
        ));
    }
    let field = |name: usize| columns.at[name].and_then(|column| fields.get(column));
    let mut vector = |names: [usize; 3]| -> Result<Option<Vector>, FileError> {
        let [Some(a), Some(b), Some(c)] = names.map(field) else { return Ok(None) };
        if names[0] == 4 && [a, b, c].iter().all(|field| field.text.is_empty()) {
            return Ok(None);
        }
        Ok(Some(Vector::new(marks.number(line, a)?, marks.number(line, b)?, marks.number(line, c)?)))
    };
    let point = vector([1, 2, 3])?.ok_or_else(|| line.expected(line.text, "x, y and z"))?;
    let direction = vector([4, 5, 6])?;
    if direction.is_some_and(|direction| direction == Vector::zeros()) {
        return Err(line.expected(field(4).map_or(line.text, |field| field.part), "a direction that is not zero"));
    }
    let id = field(0).map(|field| field.text.to_string()).filter(|id| !id.is_empty());
    Ok(ListedPoint { id, point, direction, line: line.number })
}

/// Writes a list, with the columns that any of its points needs. Numbers come back to the last bit.
///
/// ```
/// use flankfit_engine::formats::points;
///
/// let list = points::read(b"x,y,z\n1,2,3\n")?;
/// assert_eq!(points::write(&list)?, "x,y,z\n1.0,2.0,3.0\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(points: &[ListedPoint]) -> Result<String, ExportFault> {
    let with_id = points.iter().any(|point| point.id.is_some());
    let with_direction = points.iter().any(|point| point.direction.is_some());
    let names = &NAMES[usize::from(!with_id)..if with_direction { 7 } else { 4 }];
    let mut out = names.join(",");
    out.push('\n');
    for (index, listed) in points.iter().enumerate() {
        if with_id {
            out.push_str(&field(listed.id.as_deref().unwrap_or_default()));
            out.push(',');
        }
        let finite = |vector: &Vector| vector.iter().all(|x| x.is_finite());
        if !finite(&listed.point) || !listed.direction.as_ref().is_none_or(finite) {
            return Err(ExportFault::NodeRange { index });
        }
        let [x, y, z] = [listed.point.x, listed.point.y, listed.point.z].map(real);
        // writing to a string cannot fail
        let _ = write!(out, "{x},{y},{z}");
        if with_direction {
            match &listed.direction {
                Some(direction) => {
                    let [i, j, k] = [direction.x, direction.y, direction.z].map(real);
                    let _ = write!(out, ",{i},{j},{k}");
                }
                None => out.push_str(",,,"),
            }
        }
        out.push('\n');
    }
    Ok(out)
}

/// A field of a CSV line, in quotes where it needs them; a name has one line.
pub(super) fn field(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let plain = !text.contains([',', ';', '"', '\t']) && !text.starts_with(['#', ' ']) && !text.ends_with(' ');
    if plain { text } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}
