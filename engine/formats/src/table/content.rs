//! Content of a table: nodes of flanks, or points.

use std::collections::BTreeMap;

use super::{
    ColumnSpec, Crossings, FlankFault, Layout, ListedPoint, Meaning, Missing, Table, TableFault, Unit,
    columns::{LEAST_SHARE, Roles},
    crossings::traces,
    fault::what,
    reader::Cells,
    words::{flank_of, kind_of, words_of},
};
use crate::file_error::FileError;
use flankfit_estimation::Nodes;
use flankfit_gear::{
    Kind, Side,
    evaluation::{Levelled, OwnZeros},
};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{cancel, check::Faults};

/// Most flanks that a table has nodes of: both of a gear with a thousand teeth.
const MOST_FLANKS: usize = 2000;

/// Fewest samples of a trace whose zero is estimated.
const LEAST_SAMPLES: usize = 3;

/// Nodes of one flank of one tooth, or of whatever a table without such columns is of.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeSet {
    /// The tooth, without the letter that some programs put behind its number.
    pub tooth: Option<String>,
    /// The flank.
    pub flank: Option<Side>,
    /// Nodes with a height.
    pub count: usize,
    /// Rows without a height, and crossings of a grid without a row.
    pub missing: usize,
    /// The nodes. Those of traces with separate zeros follow trace by trace, with the zeros
    /// subtracted.
    pub nodes: Result<Nodes, Faults>,
    /// Layout of the nodes.
    pub layout: Layout,
    /// Distances of its traces at their crossings, if the table says which of them are profiles and
    /// helices and they cross. Helix traces that count the other way are turned in `nodes`.
    pub crossings: Option<Crossings>,
    /// Traces, if the table distinguishes them and they do not share one zero: they do not cross,
    /// or differ at crossings.
    pub own_zeros: Option<OwnZeros>,
}

impl Layout {
    /// Layout of the nodes of a table: that of each of its flanks.
    pub fn of(sets: &[NodeSet]) -> Self {
        let mut each = sets.iter().map(|set| set.layout);
        each.next().filter(|first| each.all(|other| other == *first)).unwrap_or(Layout::Scattered)
    }
}

/// Numbers of a surface.
struct Surface {
    u: Vec<f64>,
    v: Vec<f64>,
    z: Vec<f64>,
    weight: Option<Vec<f64>>,
}

/// Refuses a table of nodes where points are wanted, or the other way round.
fn other_content(found: Layout) -> FileError {
    TableFault::of_table(format_args!("the table holds {}", what(found))).into()
}

/// Refuses a word for a flank that is neither left nor right.
fn unknown_flank(line: usize, found: &str) -> FileError {
    let found: String = found.chars().take(40).collect();
    let [left, right] = [Side::Left, Side::Right].map(words_of);
    let fault = TableFault::of_table(format_args!(
        "line {line}: `{found}` is not a flank; write {left} for left and {right} for right"
    ));
    TableFault { flanks: Some(FlankFault::Unknown), ..fault }.into()
}

impl Table {
    /// Rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// True if its columns are those of points.
    pub fn holds_points(&self) -> bool {
        matches!(self.roles, Ok(Roles::Points { .. }))
    }

    /// Layout of its nodes; `None` if its columns or its flanks are not known.
    pub fn layout(&self) -> Option<Layout> {
        if self.holds_points() { Some(Layout::Points) } else { Some(Layout::of(&self.node_sets().ok()?)) }
    }

    /// The numbers of the column with that meaning; NaN where a cell is empty.
    pub fn numbers(&self, meaning: Meaning) -> Option<&[f64]> {
        let column = self.columns.iter().position(|column| column.meaning == meaning)?;
        self.numbers_at(column)
    }

    /// The numbers of a column, by its number from 0; NaN where a cell is empty. Radians are
    /// degrees here.
    pub fn numbers_at(&self, column: usize) -> Option<&[f64]> {
        match self.cells.get(column)? {
            Cells::Numbers(numbers) => Some(numbers),
            Cells::Texts(..) | Cells::Ignored => None,
        }
    }

    /// The texts of the column with that meaning, row by row.
    pub fn texts<'a>(&'a self, meaning: Meaning) -> Option<impl Fn(usize) -> &'a str + 'a> {
        let column = self.columns.iter().position(|column| column.meaning == meaning)?;
        match &self.cells[column] {
            Cells::Texts(of_rows, texts) => Some(|row: usize| {
                of_rows.get(row).and_then(|number| texts.get(*number as usize)).map_or("", String::as_str)
            }),
            Cells::Numbers(_) | Cells::Ignored => None,
        }
    }

    /// Error for columns that form neither nodes nor points.
    fn incomplete(&self, missing: Missing) -> FileError {
        let each = self.columns.iter().zip(1..);
        let name = |(column, k): (&ColumnSpec, i32)| {
            if column.name.is_empty() { format!("`{k}`") } else { format!("`{}`", column.name) }
        };
        let names: Vec<String> = each.take(12).map(name).collect();
        let message = format!("the columns are {}: {missing}; name them as `columns` of `mapping`", names.join(", "));
        let fault = TableFault::of_table(message);
        TableFault { path: self.mapped.then(|| "mapping.columns".to_owned()), ..fault }.into()
    }

    /// The points of a list, in mm.
    pub fn points(&self) -> Result<Vec<ListedPoint>, FileError> {
        let (at, direction) = match self.roles.map_err(|missing| self.incomplete(missing))? {
            Roles::Points { at, direction } => (at, direction),
            Roles::Surface { .. } | Roles::Curve { .. } => {
                return Err(other_content(self.layout().unwrap_or(Layout::Scattered)));
            }
        };
        let ids = self.texts(Meaning::Id);
        let vector = |columns: [usize; 3], row: usize| {
            let x = |column: usize| self.numbers_at(column).map_or(f64::NAN, |numbers| numbers[row]);
            Vector::from(columns.map(x))
        };
        let factors = at.map(|column| self.columns[column].unit.and_then(Unit::millimetres).unwrap_or(1.0));
        (0..self.rows())
            .map(|row| {
                cancel::every(10, row);
                let direction = direction.map(|columns| vector(columns, row)).filter(|d| !d.iter().all(|x| x.is_nan()));
                if direction == Some(Vector::zeros()) {
                    let message =
                        format_args!("line {}: i, j, k are all zero, which is not a direction", self.lines[row]);
                    return Err(TableFault::of_table(message).into());
                }
                let id = ids.as_ref().map(|id| id(row)).filter(|id| !id.is_empty()).map(str::to_owned);
                let point = vector(at, row).component_mul(&Vector::from(factors));
                Ok(ListedPoint { id, point, direction, line: self.lines[row] })
            })
            .collect()
    }

    /// The nodes, for each flank of each tooth; those with the most of them first.
    pub fn node_sets(&self) -> Result<Vec<NodeSet>, FileError> {
        let roles = self.roles.map_err(|missing| self.incomplete(missing))?;
        if let Roles::Points { .. } = roles {
            return Err(other_content(Layout::Points));
        }
        let (teeth, flanks) = (self.texts(Meaning::Tooth), self.texts(Meaning::Flank));
        let mut groups: BTreeMap<(Option<&str>, Option<Side>), Vec<usize>> = BTreeMap::new();
        for row in 0..self.rows() {
            cancel::every(10, row);
            let tooth = teeth.as_ref().map(|tooth| number_of(tooth(row)));
            let unknown = |found: &str| unknown_flank(self.lines[row], found);
            let side =
                flanks.as_ref().map(|flank| flank_of(flank(row)).ok_or_else(|| unknown(flank(row)))).transpose()?;
            groups.entry((tooth.filter(|tooth| !tooth.is_empty()), side)).or_default().push(row);
            if groups.len() > MOST_FLANKS {
                let fault = TableFault::of_table(format_args!(
                    "the table has nodes of more than {MOST_FLANKS} flanks: split it, or map fewer columns"
                ));
                return Err(TableFault { flanks: Some(FlankFault::TooMany), ..fault }.into());
            }
        }
        if groups.is_empty() {
            groups.insert((None, None), Vec::new());
        }
        // the sign is a convention of the instrument, the same on all teeth of a side
        let mut of_sides: BTreeMap<Option<Side>, Vec<Crossings>> = BTreeMap::new();
        for ((_, flank), rows) in &groups {
            of_sides.entry(*flank).or_default().extend(self.crossings(roles, rows));
        }
        let each = groups.into_iter().map(|((tooth, flank), rows)| {
            let crossings = Crossings::pooled(&of_sides[&flank]);
            let (nodes, layout, count, own_zeros) = self.nodes_of(roles, &rows, crossings.as_ref());
            let places = match &nodes {
                Ok(Nodes::Grid(grid)) => grid.z().len(),
                _ => rows.len(),
            };
            let (tooth, missing) = (tooth.map(str::to_owned), places - count);
            NodeSet { tooth, flank, count, missing, nodes, layout, crossings, own_zeros }
        });
        let mut sets: Vec<NodeSet> = each.collect();
        sets.sort_by_key(|set| std::cmp::Reverse(set.count));
        Ok(sets)
    }

    /// Returns the kind of trace of a row, profile or helix, if the table has it.
    fn kinds(&self) -> Option<impl Fn(usize) -> Option<Kind> + '_> {
        let trace = self.texts(Meaning::Trace)?;
        Some(move |row| kind_of(trace(row)))
    }

    fn crossings(&self, roles: Roles, rows: &[usize]) -> Option<Crossings> {
        let (Roles::Surface { along, across, height }, Some(kind)) = (roles, self.kinds()) else { return None };
        let [along, across, height] = [self.numbers_at(along)?, self.numbers_at(across)?, self.numbers_at(height)?];
        let weight = self.numbers(Meaning::Weight);
        let counts = |row: &usize| weight.is_none_or(|weight| weight[*row] != 0.0);
        let sample = |row: &usize| Some((kind(*row)?, [along[*row], across[*row], height[*row]]));
        Crossings::of(&rows.iter().filter(|row| counts(row)).filter_map(sample).collect::<Vec<_>>())
    }

    fn nodes_of(
        &self,
        roles: Roles,
        rows: &[usize],
        crossings: Option<&Crossings>,
    ) -> (Result<Nodes, Faults>, Layout, usize, Option<OwnZeros>) {
        let take = |column: usize| -> Vec<f64> {
            self.numbers_at(column).map_or(Vec::new(), |numbers| rows.iter().map(|row| numbers[*row]).collect())
        };
        let weight = self.columns.iter().position(|column| column.meaning == Meaning::Weight).map(take);
        match roles {
            Roles::Surface { along, across, height } => {
                let mut z = take(height);
                let turned = crossings.is_some_and(Crossings::helices_are_turned);
                if let Some(kind) = self.kinds().filter(|_| turned) {
                    let helices = z.iter_mut().zip(rows).filter(|(_, row)| kind(**row) == Some(Kind::Helix));
                    helices.for_each(|(z, _)| *z = 0.0 - *z);
                }
                let mut surface = Surface { u: take(along), v: take(across), z, weight };
                let count = surface.z.iter().filter(|z| !z.is_nan()).count();
                // who says that it is a grid says that it has one zero
                if self.given_layout != Some(Layout::Grid)
                    && !crossings.is_some_and(Crossings::share_zero)
                    && let Some(kind) = self.kinds()
                    && let Some(zeros) = surface.subtract_zeros(|k| kind(rows[k]))
                {
                    return (surface.scattered(), Layout::Scattered, count, Some(zeros));
                }
                let grid = if self.given_layout == Some(Layout::Scattered) { None } else { surface.grid() };
                match grid {
                    Some(grid) => (grid, Layout::Grid, count, None),
                    None => (surface.scattered(), Layout::Scattered, count, None),
                }
            }
            Roles::Curve { along, height } | Roles::Points { at: [along, height, _], .. } => {
                let (x, y) = (take(along), take(height));
                let count = y.iter().filter(|y| !y.is_nan()).count();
                let kept = |list: &[f64]| of_nodes(list, &y);
                let nodes = Nodes::curve(kept(&x), kept(&y), weight.map(|weight| kept(&weight)));
                (nodes, Layout::Curve, count, None)
            }
        }
    }
}

/// The entries of nodes that have a height.
fn of_nodes(list: &[f64], heights: &[f64]) -> Vec<f64> {
    list.iter().zip(heights).filter(|(_, height)| !height.is_nan()).map(|(x, _)| *x).collect()
}

/// The number at the beginning of a tooth's name, which may have a letter for the trace; else the
/// name. The word "tooth" before it is left out.
fn number_of(tooth: &str) -> &str {
    let words = tooth.split_once(char::is_whitespace);
    let tooth = match words {
        Some((word, name)) if ["tooth", "zahn"].contains(&word.to_lowercase().as_str()) => name.trim_start(),
        _ => tooth,
    };
    let digits = tooth.find(|c: char| !c.is_ascii_digit()).unwrap_or(tooth.len());
    if digits > 0 { &tooth[..digits] } else { tooth }
}

impl Surface {
    /// Sorts the nodes by traces and subtracts the zero of each; `None` of a single trace, of rows
    /// that are neither of a profile nor of a helix, and of traces with fewer than
    /// [`LEAST_SAMPLES`]. Missing heights are left out.
    fn subtract_zeros(&mut self, kind: impl Fn(usize) -> Option<Kind>) -> Option<OwnZeros> {
        let sample = |k: usize| Some((kind(k)?, [self.u[k], self.v[k], self.z[k]]));
        let traces = traces(&(0..self.z.len()).map(sample).collect::<Option<Vec<_>>>()?);
        if traces.len() < 2 || traces.values().any(|trace| trace.len() < LEAST_SAMPLES) {
            return None;
        }
        let lengths = traces.values().map(Vec::len).collect();
        let order = traces.into_values().flatten();
        let weights = self.weight.take();
        let (places, weight): (Vec<[f64; 3]>, Vec<f64>) = order
            .map(|k| ([self.u[k], self.v[k], self.z[k]], weights.as_ref().map_or(1.0, |weights| weights[k])))
            .unzip();
        let Levelled { places, zeros } = Levelled::of_places(&places, &weight, lengths);
        self.weight = weights.map(|_| weight);
        [self.u, self.v, self.z] = [0, 1, 2].map(|c| places.iter().map(|place| place[c]).collect());
        Some(zeros)
    }

    fn scattered(self) -> Result<Nodes, Faults> {
        let Surface { u, v, z, weight } = self;
        let kept = |list: &[f64]| of_nodes(list, &z);
        Nodes::scattered(kept(&u), kept(&v), kept(&z), weight.map(|weight| kept(&weight)))
    }

    /// Nodes as a grid, if they are on the crossings of a few u and v and none of them twice. A
    /// crossing that the table leaves out is a missing node.
    fn grid(&self) -> Option<Result<Nodes, Faults>> {
        let (us, vs) = (ascending(&self.u), ascending(&self.v));
        let crossings = us.len().checked_mul(vs.len())?;
        if us.len() < 2 || vs.len() < 2 || (self.z.len() as f64) < LEAST_SHARE * crossings as f64 {
            return None;
        }
        let mut z = vec![f64::NAN; crossings];
        let mut weight = self.weight.as_ref().map(|_| vec![1.0; crossings]);
        let mut taken = vec![false; crossings];
        for k in 0..self.z.len() {
            cancel::every(20, k);
            let row = us.binary_search_by(|u| u.total_cmp(&self.u[k])).ok()?;
            let column = vs.binary_search_by(|v| v.total_cmp(&self.v[k])).ok()?;
            let at = row * vs.len() + column;
            if std::mem::replace(&mut taken[at], true) {
                return None;
            }
            z[at] = self.z[k];
            if let (Some(weight), Some(own)) = (&mut weight, &self.weight)
                && !own[k].is_nan()
            {
                weight[at] = own[k];
            }
        }
        Some(Nodes::grid(us, vs, z, None, weight))
    }
}

/// The distinct numbers of a list, ascending.
fn ascending(list: &[f64]) -> Vec<f64> {
    let mut sorted = list.to_vec();
    sorted.sort_unstable_by(cancel::comparing(f64::total_cmp));
    sorted.dedup();
    sorted
}
