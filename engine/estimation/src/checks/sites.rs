//! Sites: the nodes of a small problem, cells of nodes of a large one, and what lies between the
//! columns and a complete model there.
//!
//! With C the orthonormal indicators of the cells (1/√count) the sums `CᵀR` of residuals are, but
//! for the projection, as independent as the errors; the columns at the mean places of the cells
//! take the projection out again. So a cell is a node whose row is `√count` times that of its
//! place.

use crate::{
    data::{Nodes, Sample},
    design::{Along as Slope, Axis, Basis, Design, Row, bounding_box},
    factor::orthonormal_rows,
    problem::LinearProblem,
    spec::Along,
};
use nalgebra::DMatrix;

use flankfit_geometry::{Mapping, polynomial::chebyshev_values};
use flankfit_numerics::{cancel::Asking, matvec};

/// Nodes up to which each is a site.
const MOST: usize = 256;
/// Cells along an axis of a surface at least, and of a curve.
const CELLS: [usize; 2] = [12, 96];
/// Orders of the functions of the smooth process, along both axes together.
const ORDER: usize = 5;
/// Length of the smooth process on [-1, 1].
const LENGTH: f64 = 0.5;
/// Columns of a model whose sites are looked at: the time grows with the cube of their number.
const MOST_COLUMNS: usize = 100;
/// A column is dependent if less than this share of its length is left.
const DEPENDENT: f64 = 1e-6;
/// 1 − h below which a residual says nothing about the variance.
const ALONE: f64 = 1e-6;
/// Degrees of freedom that checks take at least.
const LEAST_FREEDOM: usize = 5;

type Columns = Vec<Vec<f64>>;

/// Sites of a design, and the functions that its residuals are compared with.
pub(crate) struct Sites {
    /// Site of each counted node; `None` where each is its own.
    cell: Option<Vec<u32>>,
    /// Nodes of each site.
    pub count: Vec<f64>,
    /// 1/(1 − h) of the nodes of each site; 0 where h is 1.
    pub share: Vec<f64>,
    /// Orthonormal columns.
    pub q: Columns,
    /// Orthonormal columns of the next order.
    pub next: Columns,
    /// Functions of the smooth process, without their part along the columns.
    pub smooth: Columns,
    /// Their products G.
    pub gram: DMatrix<f64>,
    /// Powers of the coordinates that the variance may depend on.
    pub regressors: Vec<Regressor>,
}

/// A power of a coordinate about its mean over the nodes.
pub(crate) struct Regressor {
    pub along: Along,
    pub square: bool,
    /// Share of the rate of false alarms.
    pub part: f64,
    pub centred: Vec<f64>,
    /// Length over all nodes.
    pub length: f64,
}

/// Residuals seen from sites.
pub(crate) struct Seen {
    /// `Cᵀr` without its part along the columns, and its square.
    pub sums: Vec<f64>,
    pub rss: f64,
    /// `Σ r²` and `Σ r⁴` of each site.
    pub squares: Vec<f64>,
    pub fourths: Vec<f64>,
    /// Number of nodes.
    pub nodes: f64,
}

impl Seen {
    /// Returns the variance that standard errors of so many coefficients are by.
    pub(crate) fn variance(&self, columns: f64) -> f64 {
        self.squares.iter().sum::<f64>() / (self.nodes - columns)
    }
}

impl Sites {
    /// Makes the sites of a problem; `None` without places, with too few nodes to check, or with so
    /// many columns that it takes longer than the fit.
    pub(crate) fn new(problem: &LinearProblem, sample: &Sample, nodes: &Nodes) -> Option<Self> {
        if problem.design.size() > MOST_COLUMNS {
            return None;
        }
        let Basis::Product { u, v } = &problem.design.basis else { return None };
        let surface = !matches!(nodes, Nodes::Curve(_));
        let (box_u, box_v) = bounding_box(sample);
        let mappings = [Mapping::over(box_u[0], box_u[1]), Mapping::over(box_v[0], box_v[1])];
        let wide = [box_u[1] > box_u[0], surface && box_v[1] > box_v[0]];
        let cells = Cells::new(problem.design, sample, mappings, surface);
        let q = cells.columns(problem, sample);
        let sites = cells.count.len();
        if sites < q.len() + LEAST_FREEDOM {
            return None;
        }
        let mapped: Vec<[f64; 2]> =
            cells.places.iter().map(|place| [0, 1].map(|a| mappings[a].map::<f64>(place[a]))).collect();
        let mut next = Columns::new();
        for mut column in next_columns(problem.design, [u, v], surface, &cells, &mapped) {
            let before = length(&column);
            for _ in 0..2 {
                without(&q, &mut column);
                without(&next, &mut column);
            }
            let after = length(&column);
            if after > DEPENDENT * before {
                column.iter_mut().for_each(|x| *x /= after);
                next.push(column);
            }
        }
        let mut smooth = smooth_columns(wide, &cells, &mapped);
        smooth.iter_mut().for_each(|column| without(&q, column));
        let gram = products(&smooth);
        let share = |site: usize| {
            let rest = 1.0 - q.iter().map(|q| q[site] * q[site]).sum::<f64>() / cells.count[site];
            if rest < ALONE { 0.0 } else { 1.0 / rest }
        };
        let share: Vec<f64> = (0..sites).map(share).collect();
        let regressors = regressors(surface, wide, &cells.count, &share, &mapped);
        Some(Sites { cell: cells.cell, count: cells.count, share, q, next, smooth, gram, regressors })
    }

    /// True if every node is a site.
    pub(crate) fn are_nodes(&self) -> bool {
        self.cell.is_none()
    }

    /// Degrees of freedom of the sums.
    pub(crate) fn freedom(&self) -> f64 {
        (self.count.len() - self.q.len()) as f64
    }

    /// Takes out of the residuals their part along the columns, if every node is a site.
    pub(crate) fn project(&self, residuals: &mut [f64]) {
        if self.are_nodes() {
            without(&self.q, residuals);
        }
    }

    /// Sums the residuals up.
    pub(crate) fn seen(&self, residuals: &[f64]) -> Seen {
        let nodes = residuals.len() as f64;
        let Some(cell) = &self.cell else {
            let squares: Vec<f64> = residuals.iter().map(|r| r * r).collect();
            let fourths = squares.iter().map(|s| s * s).collect();
            return Seen { rss: squares.iter().sum(), sums: residuals.to_vec(), squares, fourths, nodes };
        };
        let mut totals = vec![[0.0; 3]; self.count.len()];
        for (&site, r) in cell.iter().zip(residuals) {
            let (total, square) = (&mut totals[site as usize], r * r);
            total[0] += r;
            total[1] += square;
            total[2] += square * square;
        }
        let mut sums: Vec<f64> = totals.iter().zip(&self.count).map(|(total, count)| total[0] / count.sqrt()).collect();
        without(&self.q, &mut sums);
        Seen {
            rss: matvec::dot(&sums, &sums),
            sums,
            squares: totals.iter().map(|total| total[1]).collect(),
            fourths: totals.iter().map(|total| total[2]).collect(),
            nodes,
        }
    }
}

/// The sites before anything is computed for them.
struct Cells {
    cell: Option<Vec<u32>>,
    count: Vec<f64>,
    /// Mean places.
    places: Vec<[f64; 2]>,
    /// `Σ √w / √count`.
    roots: Vec<f64>,
}

impl Cells {
    fn new(design: &Design, sample: &Sample, mappings: [Mapping; 2], surface: bool) -> Self {
        let nodes = sample.count();
        let place = |k: usize| {
            let (u, v) = sample.place(k);
            [u, v]
        };
        if nodes <= MOST {
            return Cells {
                cell: None,
                count: vec![1.0; nodes],
                places: (0..nodes).map(place).collect(),
                roots: (0..nodes).map(|k| sample.w(k).sqrt()).collect(),
            };
        }
        // twice as many cells as coefficients
        let side =
            if surface { CELLS[0].max((2 * design.size()).isqrt() + 1) } else { CELLS[1].max(2 * design.size()) };
        let along = |a: usize, x: f64| ((0.5 * (mappings[a].map::<f64>(x) + 1.0) * side as f64) as usize).min(side - 1);
        let mut number = vec![u32::MAX; if surface { side * side } else { side }];
        let mut sums: Vec<[f64; 4]> = Vec::new();
        let mut cell = Vec::with_capacity(nodes);
        for k in (0..nodes).asking(20) {
            let [u, v] = place(k);
            let at = along(0, u) + if surface { side * along(1, v) } else { 0 };
            if number[at] == u32::MAX {
                number[at] = sums.len() as u32;
                sums.push([0.0; 4]);
            }
            let sum = &mut sums[number[at] as usize];
            for (sum, x) in sum.iter_mut().zip([1.0, u, v, sample.w(k).sqrt()]) {
                *sum += x;
            }
            cell.push(number[at]);
        }
        Cells {
            cell: Some(cell),
            count: sums.iter().map(|sum| sum[0]).collect(),
            places: sums.iter().map(|sum| [sum[1] / sum[0], sum[2] / sum[0]]).collect(),
            roots: sums.iter().map(|sum| sum[3] / sum[0].sqrt()).collect(),
        }
    }

    /// An orthonormal basis of the columns.
    fn columns(&self, problem: &LinearProblem, sample: &Sample) -> Columns {
        let (design, n) = (problem.design, problem.design.size());
        let mut columns = vec![vec![0.0; self.count.len()]; n];
        let Some(cell) = &self.cell else {
            let rows = orthonormal_rows(design, problem.factor, sample);
            for (k, row) in rows.chunks_exact(n).enumerate() {
                columns.iter_mut().zip(row).for_each(|(column, x)| column[k] = *x);
            }
            return columns;
        };
        if sample.is_white() {
            let mut row = Row::<f64>::new(design);
            for (k, &site) in cell.iter().enumerate().asking(n) {
                row.at(design, sample, k);
                let root = self.count[site as usize].sqrt();
                columns.iter_mut().zip(&row.values).for_each(|(column, x)| column[site as usize] += x / root);
            }
        } else {
            for (site, (place, root)) in self.places.iter().zip(&self.roots).enumerate().asking(20 * n) {
                let row = design.row_at(*place, Slope::Value);
                columns.iter_mut().zip(row).for_each(|(column, x)| column[site] = root * x.to_f64());
            }
        }
        let mut q = Columns::new();
        for mut column in columns.into_iter().asking(4 * n * self.count.len()) {
            let before = length(&column);
            without(&q, &mut column);
            without(&q, &mut column);
            let after = length(&column);
            if after > DEPENDENT * before {
                column.iter_mut().for_each(|x| *x /= after);
                q.push(column);
            }
        }
        q
    }
}

/// Products of functions of u and v that follow those of the design: the next one along u with
/// those of v, and along v with those of u; and the one after the next along each axis alone,
/// without which a shape that is alike at both ends has no part along them.
fn next_columns(design: &Design, axes: [&Axis; 2], surface: bool, cells: &Cells, mapped: &[[f64; 2]]) -> Columns {
    let size = axes.map(Axis::size);
    // terms ascend
    let has = |term: &(usize, usize)| design.terms.binary_search(term).is_ok();
    let mut terms: Vec<(usize, usize)> = design
        .terms
        .iter()
        .flat_map(|&(i, j)| [Some((i + 1, j)), surface.then_some((i, j + 1))].into_iter().flatten())
        .filter(|term| !has(term))
        .collect();
    terms.sort_unstable();
    terms.dedup();
    let alone = if surface { 2 } else { 1 };
    let mut columns = vec![Vec::with_capacity(cells.count.len()); terms.len() + alone];
    let mut values = size.map(|size| vec![0.0; size + 1]);
    for ((place, mapped), root) in cells.places.iter().zip(mapped).zip(&cells.roots) {
        for a in 0..2 {
            let (within, next) = values[a].split_at_mut(size[a]);
            axes[a].row(place[a], within);
            let after;
            [next[0], after] = next_functions(axes[a], mapped[a]);
            if a < alone {
                columns[terms.len() + a].push(root * after);
            }
        }
        for (column, &(i, j)) in columns.iter_mut().zip(&terms) {
            column.push(root * values[0][i] * values[1][j]);
        }
    }
    columns
}

/// The Chebyshev polynomials of the two degrees after that of an axis.
fn next_functions(axis: &Axis, t: f64) -> [f64; 2] {
    let degree = match axis {
        Axis::Polynomial { size, .. } => *size,
        Axis::Spline(basis) => basis.degree() + 1,
    };
    let mut values = vec![0.0; degree + 2];
    chebyshev_values(t, &mut values);
    [values[degree], values[degree + 1]]
}

/// The first functions whose products sum to the squared exponential `exp(−|x − y|²/2ℓ²)`: of each
/// axis `exp(−x²/2ℓ²) (x/ℓ)ᵏ/√k!`.
fn smooth_columns(wide: [bool; 2], cells: &Cells, mapped: &[[f64; 2]]) -> Columns {
    let orders = wide.map(|wide| if wide { ORDER } else { 0 });
    let terms: Vec<(usize, usize)> =
        (0..=orders[0]).flat_map(|i| (0..=orders[1].min(ORDER - i)).map(move |j| (i, j))).collect();
    let mut columns = vec![Vec::with_capacity(mapped.len()); terms.len()];
    for (place, root) in mapped.iter().zip(&cells.roots) {
        let values = place.map(|x| {
            let x = x / LENGTH;
            let mut values = [libm::exp(-0.5 * x * x); ORDER + 1];
            for k in 1..=ORDER {
                values[k] = values[k - 1] * x / (k as f64).sqrt();
            }
            values
        });
        for (column, &(i, j)) in columns.iter_mut().zip(&terms) {
            column.push(root * values[0][i] * values[1][j]);
        }
    }
    columns
}

/// Products of columns with each other.
fn products(columns: &Columns) -> DMatrix<f64> {
    let n = columns.len();
    let mut gram = DMatrix::zeros(n, n);
    for (i, a) in columns.iter().enumerate() {
        for (k, b) in columns[..=i].iter().enumerate() {
            gram[(i, k)] = matvec::dot(a, b);
            gram[(k, i)] = gram[(i, k)];
        }
    }
    gram
}

fn regressors(surface: bool, wide: [bool; 2], count: &[f64], share: &[f64], mapped: &[[f64; 2]]) -> Vec<Regressor> {
    let counted = |site: usize| if share[site] > 0.0 { count[site] } else { 0.0 };
    let axes = wide.iter().filter(|wide| **wide).count() as f64;
    let whole: f64 = (0..count.len()).map(counted).sum();
    let of = |a: usize, square: bool| {
        let mut centred: Vec<f64> =
            mapped.iter().map(|place| if square { place[a] * place[a] } else { place[a] }).collect();
        let mean = centred.iter().enumerate().map(|(site, x)| counted(site) * x).sum::<f64>() / whole;
        centred.iter_mut().for_each(|x| *x -= mean);
        let length = centred.iter().enumerate().map(|(site, x)| counted(site) * x * x).sum::<f64>().sqrt();
        let along = match (surface, a) {
            (false, _) => Along::Order,
            (true, 0) => Along::U,
            (true, _) => Along::V,
        };
        Regressor { along, square, part: if square { 0.8 } else { 0.2 } / axes, centred, length }
    };
    let all = [0, 1].into_iter().filter(|a| wide[*a]).flat_map(|a| [of(a, true), of(a, false)]);
    all.filter(|one| one.length > 1e-6 * whole.sqrt()).collect()
}

/// Takes the parts along orthonormal columns out of a vector.
fn without(q: &Columns, x: &mut [f64]) {
    for q in q {
        matvec::add(-matvec::dot(q, x), q, x);
    }
}

fn length(x: &[f64]) -> f64 {
    matvec::dot(x, x).sqrt()
}
