//! Contents of a table's columns: by a mapping, by the names in the header, or by their number; and
//! the nodes or points that they form.

use std::{borrow::Cow, collections::BTreeSet};

use super::{
    ColumnSpec, Layout, Mapping, Meaning, Missing, TableFault, TableNote, Unit,
    head::Head,
    rows::{split, value},
    words::meaning_of,
};
use crate::file_error::FileError;
use flankfit_numerics::words::counted;

/// Nodes or points that columns form, by their numbers from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Roles {
    Surface { along: usize, across: usize, height: usize },
    Curve { along: usize, height: usize },
    Points { at: [usize; 3], direction: Option<[usize; 3]> },
}

/// A grid has at least this share of its crossings in rows of the table: in scattered nodes hardly
/// two have a u or a v in common.
pub(super) const LEAST_SHARE: f64 = 0.8;

/// Columns that are a place along the profile.
const ALONG: [Meaning; 4] = [Meaning::RollLength, Meaning::Diameter, Meaning::RollAngle, Meaning::U];

impl Roles {
    pub(super) fn of(columns: &[ColumnSpec]) -> Result<Self, Missing> {
        let find = |meaning: Meaning| columns.iter().position(|column| column.meaning == meaning);
        let along = ALONG.into_iter().find_map(find);
        let across = find(Meaning::FaceWidth).or_else(|| find(Meaning::V));
        let deviation = find(Meaning::Deviation);
        let [x, y, z] = [Meaning::X, Meaning::Y, Meaning::Z].map(find);
        if let (Some(along), Some(across)) = (along, across) {
            let height = deviation.or(z).ok_or(Missing::Height)?;
            return Ok(Roles::Surface { along, across, height });
        }
        if let (Some(x), Some(y), Some(z)) = (x, y, z) {
            return match [Meaning::I, Meaning::J, Meaning::K].map(find) {
                [Some(i), Some(j), Some(k)] => Ok(Roles::Points { at: [x, y, z], direction: Some([i, j, k]) }),
                [None, None, None] => Ok(Roles::Points { at: [x, y, z], direction: None }),
                _ => Err(Missing::Direction),
            };
        }
        let height = deviation.or(if x.is_some() { y } else { z });
        match (along.or(across).or(x), height) {
            (Some(along), Some(height)) => Ok(Roles::Curve { along, height }),
            (Some(_), None) => Err(Missing::Height),
            (None, Some(_)) => Err(Missing::Place),
            (None, None) => Err(Missing::All),
        }
    }
}

/// The columns of a table, and what was assumed of them.
pub(super) fn of(head: &Head<'_>, mapping: &Mapping) -> Result<(Vec<ColumnSpec>, Vec<TableNote>), FileError> {
    let mut notes = Vec::new();
    let count = if head.matrix { 3 } else { head.width };
    let mut columns = match &mapping.columns {
        Some(given) if given.len() != count => {
            let [given, columns] = [given.len(), count].map(|count| counted(count, "column", "columns"));
            let message = format_args!("the mapping has {given} for {columns} of the table");
            return Err(TableFault::of_mapping("mapping.columns", message).into());
        }
        Some(given) => {
            for (column, spec) in given.iter().enumerate() {
                let repeats = |other: &ColumnSpec| other.meaning == spec.meaning && spec.meaning != Meaning::Ignore;
                if given[..column].iter().any(repeats) {
                    let name = spec.meaning.name();
                    let path = format_args!("mapping.columns[{column}].meaning");
                    let message = format_args!("two columns are `{name}`; make one of them `ignore`");
                    return Err(TableFault::of_mapping(path, message).into());
                }
                if let Some(unit) = spec.unit.filter(|unit| !spec.meaning.takes(*unit)) {
                    let path = format_args!("mapping.columns[{column}].unit");
                    return Err(TableFault::of_mapping(path, foreign_unit(spec.meaning, unit)).into());
                }
            }
            let names = if head.matrix { parts(head).to_vec() } else { head.names.clone().unwrap_or_default() };
            let names = names.into_iter().chain(std::iter::repeat(String::new()));
            given.iter().zip(names).map(|(spec, name)| ColumnSpec { name, ..*spec }).collect()
        }
        None if head.matrix => of_matrix(head, &mut notes),
        None => Guess::new(head).columns(mapping.layout, &mut notes),
    };
    for (number, column) in columns.iter_mut().enumerate() {
        let unknown = column.meaning.usual_unit().and_then(|_| Unit::unknown_in(&column.name, column.meaning));
        if let Some(unit) = unknown.filter(|_| mapping.columns.is_none()) {
            return Err(TableFault::of_table(format_args!(
                "column {} is in `{unit}`, which is not a known unit of it; convert it and send its `unit` in \
                    `mapping`",
                number + 1
            ))
            .into());
        }
        if column.unit.is_none()
            && let Some(unit) = column.meaning.usual_unit()
        {
            column.unit = Some(unit);
            if mapping.columns.is_none() {
                let name = if column.name.is_empty() { column.meaning.name() } else { &column.name };
                notes.push(TableNote::UnitAssumed { name: name.to_owned(), unit });
            }
        }
    }
    Ok((columns, notes))
}

/// The message of a unit that does not belong to the meaning of its column.
fn foreign_unit(meaning: Meaning, unit: Unit) -> String {
    let units = Unit::ALL.iter().filter(|(unit, _)| meaning.takes(*unit));
    let units: Vec<String> = units.map(|(_, name)| format!("`{name}`")).collect();
    let instead = if units.is_empty() { "it has no unit".into() } else { format!("send {}", units.join(" or ")) };
    format!("`{}` is not in `{}`; {instead}", meaning.name(), unit.name())
}

fn unit_of(header: &str, meaning: Meaning) -> Option<Unit> {
    Unit::of_header(header).filter(|unit| meaning.takes(*unit))
}

/// The names in the corner of a matrix: `u \ v`.
fn parts(head: &Head<'_>) -> [String; 3] {
    let corner = head.names.as_ref().and_then(|names| names.first()).map_or("", |corner| corner);
    let mut parts = corner.split(['\\', '/', '|']).map(|part| part.trim().to_owned());
    [(); 3].map(|()| parts.next().unwrap_or_default())
}

/// First column, first row and heights of a matrix, by its corner.
fn of_matrix(head: &Head<'_>, notes: &mut Vec<TableNote>) -> Vec<ColumnSpec> {
    let names = parts(head);
    let along = meaning_of(&names[0]).filter(|meaning| ALONG.contains(meaning));
    let across = meaning_of(&names[1]).filter(|meaning| *meaning == Meaning::FaceWidth);
    let of_flank = along.is_some_and(|along| along != Meaning::U) || across.is_some();
    let meanings = if of_flank {
        let along = along.filter(|along| *along != Meaning::U);
        [along.unwrap_or(Meaning::RollLength), Meaning::FaceWidth, Meaning::Deviation]
    } else {
        [Meaning::U, Meaning::V, Meaning::Z]
    };
    if meaning_of(&names[0]).is_none() {
        notes.push(TableNote::MeaningAssumed { meanings: meanings.to_vec() });
    }
    let each = names.into_iter().zip(meanings);
    each.map(|(name, meaning)| ColumnSpec { unit: unit_of(&name, meaning), name, meaning }).collect()
}

/// Columns as far as their meaning is known.
struct Guess {
    names: Vec<String>,
    units: Vec<Option<Unit>>,
    meanings: Vec<Option<Meaning>>,
    named: bool,
    /// The first rows, column by column; `None` where a cell is no number.
    sample: Vec<Vec<Option<f64>>>,
    /// Columns most of whose cells are numbers, or empty.
    numeric: Vec<bool>,
}

impl Guess {
    fn new(head: &Head<'_>) -> Self {
        let width = head.width;
        let named = head.names.is_some();
        let mut names = head.names.clone().unwrap_or_default();
        names.resize(width, String::new());
        let mut sample = vec![Vec::new(); width];
        let mut texts = vec![0_usize; width];
        let mut cells: Vec<Cow<'_, str>> = Vec::new();
        for row in head.sample.iter().filter(|row| row.line >= head.first_line && !head.is_header(row.text)) {
            split(row.text, head.separator, &mut cells);
            if !head.fit(&mut cells) {
                continue;
            }
            for (column, cell) in cells.iter().enumerate() {
                let number = value(cell, head.decimal);
                texts[column] += usize::from(number.is_none() && !cell.is_empty());
                sample[column].push(number);
            }
        }
        let below = |k: usize| head.units.as_ref().and_then(|units| *units.get(k)?);
        let units = (0..width).map(|k| Unit::of_header(&names[k]).or_else(|| below(k))).collect();
        // a cell that is none among numbers is a fault of it, not of its column
        let numbers = sample.iter().map(|column: &Vec<Option<f64>>| column.iter().flatten().count());
        let numeric = numbers.zip(texts).map(|(numbers, texts)| texts == 0 || numbers > texts).collect();
        let meanings = names.iter().map(|name| meaning_of(name)).collect();
        Guess { names, units, meanings, named, sample, numeric }
    }

    fn position(&self, meaning: Meaning) -> Option<usize> {
        self.meanings.iter().position(|own| *own == Some(meaning))
    }

    fn has(&self, meaning: Meaning) -> bool {
        self.position(meaning).is_some()
    }

    fn columns(mut self, layout: Option<Layout>, notes: &mut Vec<TableNote>) -> Vec<ColumnSpec> {
        self.settle_names();
        self.settle_others(layout, notes);
        let each = self.names.into_iter().zip(self.meanings).zip(self.units);
        let columns: Vec<ColumnSpec> = each
            .map(|((name, meaning), unit)| {
                let meaning = meaning.unwrap_or(Meaning::Ignore);
                ColumnSpec { name, meaning, unit: unit.filter(|unit| meaning.takes(*unit)) }
            })
            .collect();
        let ignored = columns.iter().filter(|column| column.meaning == Meaning::Ignore && !column.name.is_empty());
        notes.extend(ignored.take(20).map(|column| TableNote::ColumnIgnored { name: column.name.clone() }));
        columns
    }

    /// Chooses one of several columns with the same meaning, and decides what `z` is.
    fn settle_names(&mut self) {
        // a deviation as DIN counts it goes before one as the instrument printed it
        let din = |name: &String| name.to_lowercase().contains("din");
        let preferred = (0..self.names.len())
            .find(|k| self.meanings[*k] == Some(Meaning::Deviation) && din(&self.names[*k]))
            .or_else(|| self.position(Meaning::Deviation));
        for k in 0..self.names.len() {
            let Some(meaning) = self.meanings[k] else { continue };
            let first = self.position(meaning);
            let wanted = if meaning == Meaning::Deviation { preferred } else { first };
            if wanted != Some(k) {
                self.meanings[k] = Some(Meaning::Ignore);
            }
        }
        let along: Vec<usize> = ALONG.into_iter().filter_map(|meaning| self.position(meaning)).collect();
        for other in along.iter().skip(1) {
            self.meanings[*other] = Some(Meaning::Ignore);
        }
        // with a deviation, z is a place
        if let (Some(z), true) = (self.position(Meaning::Z), self.has(Meaning::Deviation))
            && !(self.has(Meaning::X) && self.has(Meaning::Y))
        {
            let free = !self.has(Meaning::FaceWidth) && !self.has(Meaning::V);
            self.meanings[z] = Some(if free { Meaning::FaceWidth } else { Meaning::Ignore });
        }
    }

    /// Assigns columns without a known name: the heights next to two places, or all by their
    /// number.
    fn settle_others(&mut self, layout: Option<Layout>, notes: &mut Vec<TableNote>) {
        let free: Vec<usize> =
            (0..self.names.len()).filter(|k| self.meanings[*k].is_none() && self.numeric[*k]).collect();
        let is_named = |meaning: &Option<Meaning>| meaning.is_some_and(Meaning::is_number);
        let assumed: Vec<(usize, Meaning)> = if self.meanings.iter().any(is_named) {
            let along = ALONG.into_iter().any(|meaning| self.has(meaning));
            let across = self.has(Meaning::FaceWidth) || self.has(Meaning::V);
            let height = self.has(Meaning::Deviation) || self.has(Meaning::Z) || self.has(Meaning::Y);
            match free[..] {
                [only] if along && across && !height => vec![(only, Meaning::Deviation)],
                [only] if self.has(Meaning::X) && !height && !across => vec![(only, Meaning::Y)],
                _ => Vec::new(),
            }
        } else {
            self.by_number(&free, layout)
        };
        if assumed.is_empty() {
            return;
        }
        for (column, meaning) in &assumed {
            self.meanings[*column] = Some(*meaning);
        }
        notes.push(TableNote::MeaningAssumed { meanings: assumed.into_iter().map(|(_, meaning)| meaning).collect() });
    }

    fn by_number(&self, free: &[usize], layout: Option<Layout>) -> Vec<(usize, Meaning)> {
        use Meaning::{I, Id, J, K, U, V, X, Y, Z};
        let points = [X, Y, Z, I, J, K];
        let all = self.names.len();
        // a name of any kind before the coordinates
        let rest = (1..all).all(|k| self.numeric[k] && self.meanings[k].is_none());
        let with_id = rest && !self.named && matches!(all, 4 | 7);
        let meanings: &[Meaning] = match free.len() {
            _ if with_id => {
                let coordinates = (1..all).zip(points).collect::<Vec<_>>();
                return [vec![(0, Id)], coordinates].concat();
            }
            2 => &[X, Y],
            3 => {
                let nodes = match layout {
                    Some(Layout::Points) => false,
                    Some(_) => true,
                    None => self.named || self.is_grid(free[0], free[1]),
                };
                if nodes { &[U, V, Z] } else { &points[..3] }
            }
            6 => &points,
            _ => return Vec::new(),
        };
        free.iter().copied().zip(meanings.iter().copied()).collect()
    }

    /// True if the first rows repeat the places of two columns as those of a grid do.
    fn is_grid(&self, u: usize, v: usize) -> bool {
        let distinct = |column: usize| {
            let bits: BTreeSet<u64> = self.sample[column].iter().flatten().map(|x| x.to_bits()).collect();
            bits.len()
        };
        let (rows, u, v) = (self.sample[u].len(), distinct(u), distinct(v));
        u >= 2 && v >= 2 && rows >= 4 && rows as f64 >= LEAST_SHARE * (u * v) as f64
    }
}
