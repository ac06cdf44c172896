//! Measured nodes, checked.
//!
//! A node set is built only through the constructors here, which look at every number once and name
//! every one that is wrong by its list and index. Inside the crate nothing is checked a second
//! time.

use flankfit_numerics::{
    check::{self, Faults},
    words::{Shown, entries},
};

/// The four forms in which nodes arrive. Lengths are in the caller's own unit.
///
/// ```
/// use flankfit_estimation::Nodes;
///
/// // Two profiles of three nodes each; one node is missing.
/// let grid = Nodes::grid(
///     vec![6.0, 9.0, 12.0],
///     vec![2.0, 8.0],
///     vec![0.1, 0.3, f64::NAN, 0.2, 0.0, 0.4],
///     None,
///     None,
/// )?;
/// assert_eq!(grid.posted(), 6);
///
/// // Every number that is wrong is named.
/// let errors =
///     Nodes::curve(vec![0.0, 1.0, 2.0], vec![0.5, f64::NAN, f64::INFINITY], None).unwrap_err();
/// let paths: Vec<&str> = errors.list().iter().map(|fault| &*fault.path).collect();
/// assert_eq!(paths, ["y[1]", "y[2]"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Nodes {
    /// One boundary curve `y(x)`.
    Curve(Curve),
    /// One surface `z(u, v)` at arbitrary nodes.
    Scattered(Scattered),
    /// One surface on the crossings of two axes; nodes may be missing.
    Grid(Grid),
    /// The measurement matrix itself.
    Matrix(Matrix),
}

/// `y(x)` at `m` abscissae, in any order; repeated abscissae are repeated measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) weight: Option<Vec<f64>>,
}

/// `z(u, v)` at `m` places, in any order.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattered {
    pub(crate) u: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) z: Vec<f64>,
    pub(crate) weight: Option<Vec<f64>>,
}

/// `z` on the grid of two strictly ascending axes, row by row: `z[i * v.len() + j]` at `(u[i],
/// v[j])`. A missing node is NaN in `z` (posted as `null`) or `false` in `valid`.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    pub(crate) u: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) z: Vec<f64>,
    pub(crate) valid: Option<Vec<bool>>,
    pub(crate) weight: Option<Vec<f64>>,
}

/// The measurement matrix, row by row: `x[k * columns + j]`, and the heights `y`.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    pub(crate) x: Vec<f64>,
    pub(crate) columns: usize,
    pub(crate) y: Vec<f64>,
    pub(crate) names: Option<Vec<String>>,
    pub(crate) weight: Option<Vec<f64>>,
}

impl Curve {
    /// The abscissae.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// The heights.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// Weights in the order of the heights, where there are any.
    pub fn weight(&self) -> Option<&[f64]> {
        self.weight.as_deref()
    }
}

impl Scattered {
    /// First coordinate of each node.
    pub fn u(&self) -> &[f64] {
        &self.u
    }

    /// Second coordinate of each node.
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// The heights.
    pub fn z(&self) -> &[f64] {
        &self.z
    }

    /// Weights in the order of the heights, where there are any.
    pub fn weight(&self) -> Option<&[f64]> {
        self.weight.as_deref()
    }
}

impl Grid {
    /// First axis, strictly ascending.
    pub fn u(&self) -> &[f64] {
        &self.u
    }

    /// Second axis, strictly ascending.
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// The heights row by row, NaN where a node is missing.
    pub fn z(&self) -> &[f64] {
        &self.z
    }

    /// Mask of the nodes that count, if one was given.
    pub fn valid(&self) -> Option<&[bool]> {
        self.valid.as_deref()
    }

    /// Weights in the order of the heights, where there are any.
    pub fn weight(&self) -> Option<&[f64]> {
        self.weight.as_deref()
    }
}

impl Matrix {
    /// The entries, row by row.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The heights.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// Names of the columns, where they have any.
    pub fn names(&self) -> Option<&[String]> {
        self.names.as_deref()
    }

    /// Weights in the order of the heights, where there are any.
    pub fn weight(&self) -> Option<&[f64]> {
        self.weight.as_deref()
    }
}

impl Nodes {
    /// A curve `y(x)`; refuses empty or unequal arrays, numbers that are not finite and negative
    /// weights.
    pub fn curve(x: Vec<f64>, y: Vec<f64>, weight: Option<Vec<f64>>) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        if x.is_empty() {
            faults.push("x", "there are no nodes");
        }
        check_length(&mut faults, "y", y.len(), x.len(), "x");
        check_finite(&mut faults, "x", &x);
        check_finite(&mut faults, "y", &y);
        check_weight(&mut faults, &weight, x.len(), "x");
        faults.into_result(Nodes::Curve(Curve { x, y, weight }))
    }

    /// Scattered nodes `z(u, v)`; the same checks as for a curve.
    pub fn scattered(u: Vec<f64>, v: Vec<f64>, z: Vec<f64>, weight: Option<Vec<f64>>) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        if u.is_empty() {
            faults.push("u", "there are no nodes");
        }
        check_length(&mut faults, "v", v.len(), u.len(), "u");
        check_length(&mut faults, "z", z.len(), u.len(), "u");
        check_finite(&mut faults, "u", &u);
        check_finite(&mut faults, "v", &v);
        check_finite(&mut faults, "z", &z);
        check_weight(&mut faults, &weight, u.len(), "u");
        faults.into_result(Nodes::Scattered(Scattered { u, v, z, weight }))
    }

    /// A grid whose rows have been laid end to end. `z` must hold `u.len() * v.len()` numbers, NaN
    /// where a node is missing; the axes must ascend strictly. (Ragged rows are the reader's to
    /// refuse: it still sees them.)
    pub fn grid(
        u: Vec<f64>,
        v: Vec<f64>,
        z: Vec<f64>,
        valid: Option<Vec<bool>>,
        weight: Option<Vec<f64>>,
    ) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let count = u.len() * v.len();
        for (name, axis) in [("u", &u), ("v", &v)] {
            if axis.is_empty() {
                faults.push(format_args!("{name}"), "the axis has no positions");
            }
            check_finite(&mut faults, name, axis);
            for (i, pair) in axis.windows(2).enumerate() {
                if pair[1] <= pair[0] && pair[0].is_finite() {
                    faults.push(format_args!("{name}[{}]", i + 1), check::not_ascending(pair[1], pair[0]));
                }
            }
        }
        check_length(&mut faults, "z", z.len(), count, "u times v");
        let cell = |list, i: usize| format!("{list}[{}][{}]", i / v.len().max(1), i % v.len().max(1));
        for (i, value) in z.iter().enumerate() {
            if value.is_infinite() {
                faults.push(cell("z", i), check::not_finite());
            }
        }
        if let Some(valid) = &valid {
            check_length(&mut faults, "valid", valid.len(), count, "u times v");
        }
        if let Some(weight) = &weight {
            check_length(&mut faults, "weight", weight.len(), count, "u times v");
            for (i, w) in weight.iter().enumerate() {
                if let Some(why) = weight_fault(*w) {
                    faults.push(cell("weight", i), why);
                }
            }
        }
        faults.into_result(Nodes::Grid(Grid { u, v, z, valid, weight }))
    }

    /// A measurement matrix of `columns` columns, laid row by row, with optional column names.
    pub fn matrix(
        x: Vec<f64>,
        columns: usize,
        y: Vec<f64>,
        names: Option<Vec<String>>,
        weight: Option<Vec<f64>>,
    ) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        if columns == 0 || x.is_empty() {
            faults.push("x", "the matrix is empty");
        }
        let rows = x.len().checked_div(columns).unwrap_or(0);
        check_length(&mut faults, "y", y.len(), rows, "the rows of x");
        for (i, value) in x.iter().enumerate() {
            if !value.is_finite() {
                faults.push(format_args!("x[{}][{}]", i / columns.max(1), i % columns.max(1)), check::not_finite());
            }
        }
        check_finite(&mut faults, "y", &y);
        if let Some(names) = &names {
            check_length(&mut faults, "names", names.len(), columns, "the columns of x");
            for (i, name) in names.iter().enumerate() {
                if name.is_empty() {
                    faults.push(format_args!("names[{i}]"), "a column name is empty");
                }
                if names[..i].contains(name) {
                    faults.push(format_args!("names[{i}]"), format_args!("the name `{name}` occurs twice"));
                }
            }
        }
        check_weight(&mut faults, &weight, rows, "the rows of x");
        faults.into_result(Nodes::Matrix(Matrix { x, columns, y, names, weight }))
    }

    /// Replaces each `u` of scattered nodes and grids by `f(u)`, which must be finite and strictly
    /// increasing; curves and matrices are returned as they are.
    pub fn try_map_u<E>(mut self, f: impl FnMut(f64) -> Result<f64, E>) -> Result<Self, E> {
        let u = match &mut self {
            Self::Grid(grid) => &mut grid.u,
            Self::Scattered(scattered) => &mut scattered.u,
            Self::Curve(_) | Self::Matrix(_) => return Ok(self),
        };
        *u = u.iter().copied().map(f).collect::<Result<_, E>>()?;
        Ok(self)
    }

    /// The name of the list that the heights are.
    pub fn heights(&self) -> &'static str {
        match self {
            Nodes::Curve(_) | Nodes::Matrix(_) => "y",
            Nodes::Scattered(_) | Nodes::Grid(_) => "z",
        }
    }

    /// Number of posted nodes, missing ones included.
    pub fn posted(&self) -> usize {
        match self {
            Nodes::Curve(c) => c.y.len(),
            Nodes::Scattered(s) => s.z.len(),
            Nodes::Grid(g) => g.z.len(),
            Nodes::Matrix(m) => m.y.len(),
        }
    }
}

impl Grid {
    /// True if node `i` (row by row) is there: not NaN, not marked invalid, not of weight 0.
    pub(crate) fn counts(&self, i: usize) -> bool {
        !self.z[i].is_nan()
            && self.valid.as_ref().is_none_or(|valid| valid[i])
            && self.weight.as_ref().is_none_or(|weight| weight[i] > 0.0)
    }
}

fn check_length(faults: &mut Faults, list: &str, given: usize, wanted: usize, of: &str) {
    if given != wanted {
        faults.push(format_args!("{list}"), format_args!("{}, but {wanted} would match {of}", entries(given)));
    }
}

fn check_finite(faults: &mut Faults, list: &str, values: &[f64]) {
    for (i, value) in values.iter().enumerate() {
        if !value.is_finite() {
            faults.push(format_args!("{list}[{i}]"), check::not_finite());
        }
    }
}

fn check_weight(faults: &mut Faults, weight: &Option<Vec<f64>>, want: usize, of: &str) {
    let Some(weight) = weight else { return };
    check_length(faults, "weight", weight.len(), want, of);
    for (i, w) in weight.iter().enumerate() {
        if let Some(why) = weight_fault(*w) {
            faults.push(format_args!("weight[{i}]"), why);
        }
    }
}

fn weight_fault(w: f64) -> Option<String> {
    if !w.is_finite() {
        Some(check::not_finite())
    } else if w < 0.0 {
        Some(negative_weight(w))
    } else {
        None
    }
}

/// A weight below 0.
pub(crate) fn negative_weight(w: f64) -> String {
    format!("the weight {} is negative; 0 leaves a node out", Shown(w))
}
