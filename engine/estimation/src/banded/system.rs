//! Solving `(F + λP) c = XᵀΩz` to the digits that the nodes hold.
//!
//! A Cholesky factor of the matrix, scaled to a unit diagonal, is the preconditioner; corrections
//! `c += (F + λP)⁻¹ (XᵀΩ(z − Xc) − λPc)` take their residuals from the nodes, so what forming F
//! cost in digits comes back. Where doubles cannot factor the matrix, or corrections do not shrink,
//! F and its factor are formed once more in double-double: only what is 0 within that precision is
//! called undetermined.

use std::sync::OnceLock;

use super::{
    cells::Cells,
    passes::{Axes, Normal, Residuals, normal, residuals},
    pieces::Pieces,
};
use flankfit_geometry::BSplineBasis;
use flankfit_numerics::{
    Dd,
    band_cholesky::{Cholesky, SymmetricBand},
    cancel::{self, Asking},
    lanczos::largest_eigenvalue,
};

/// Least pivot (of a unit diagonal) that a factor in doubles may have.
const LEAST_PIVOT: f64 = 1e-10;
/// Pivots below these are rounding, in doubles and in double-double.
const NOTHING: f64 = 1e-13;
const NOTHING_WIDE: f64 = 1e-24;
/// Corrections at most.
const ROUNDS: usize = 8;
/// Products `nodes × functions of a cell` up to which double-double residuals cost next to nothing.
const CHEAP: usize = 4_000_000;
/// Condition of F from which residuals are formed in double-double however many nodes there are.
const DELICATE: f64 = 1e6;

/// The nodes with their sums.
pub(crate) struct System {
    pub cells: Cells,
    bases: [BSplineBasis; 2],
    axes: Axes<f64>,
    pub normal: Normal<f64>,
    wide: OnceLock<(Axes<Dd>, Normal<Dd>)>,
}

/// A penalty and its weight.
#[derive(Clone, Copy)]
pub(crate) struct Penalty<'a> {
    pub lambda: f64,
    pub matrix: &'a SymmetricBand<f64>,
}

/// The factor of F + λP.
pub(crate) struct Factor {
    kind: Kind,
    /// `1/√` of the diagonal.
    scale: Vec<f64>,
    pub condition: Option<f64>,
}

enum Kind {
    Plain(Cholesky<f64>),
    Wide(Cholesky<Dd>),
}

/// A solution, by coordinate.
pub(crate) struct Solved {
    pub coefficients: Vec<Vec<Dd>>,
    pub residuals: Residuals,
    pub factor: Factor,
    pub rounds: usize,
    /// Size of the last correction against the coefficients, both in columns of unit length.
    pub last_correction: f64,
}

/// Reason why there is no solution.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Unsolved {
    /// These coefficients cannot be determined.
    Undetermined(Vec<usize>),
    /// Corrections did not shrink.
    Stagnant,
}

impl System {
    pub(crate) fn new(cells: Cells, bases: [BSplineBasis; 2]) -> Self {
        let axes = Axes { u: Pieces::new(&bases[0]), v: Pieces::new(&bases[1]) };
        let normal = normal(&axes, &cells);
        System { cells, bases, axes, normal, wide: OnceLock::new() }
    }

    /// n.
    pub(crate) fn size(&self) -> usize {
        self.axes.size()
    }

    /// Nodes times functions that are not 0 at each.
    fn entries(&self) -> usize {
        self.cells.count().saturating_mul((self.axes.u.degree + 1) * (self.axes.v.degree + 1))
    }

    fn wide(&self) -> &(Axes<Dd>, Normal<Dd>) {
        self.wide.get_or_init(|| {
            let axes = Axes { u: Pieces::new(&self.bases[0]), v: Pieces::new(&self.bases[1]) };
            let sums = normal(&axes, &self.cells);
            (axes, sums)
        })
    }

    /// The factor in doubles, where they suffice.
    pub(crate) fn plain_factor(&self, penalty: Option<Penalty>) -> Option<Factor> {
        let matrix = match penalty {
            None => self.normal.fisher.clone(),
            Some(Penalty { lambda, matrix }) => self.normal.fisher.plus(lambda, matrix),
        };
        let scale = unit(&matrix)?;
        let scaled = matrix.scaled(&scale);
        let factor = scaled.cholesky(NOTHING);
        let sound = factor.undetermined.is_empty() && factor.least_pivot > LEAST_PIVOT;
        sound.then_some(Factor { kind: Kind::Plain(factor), scale, condition: None })
    }

    fn wide_factor(&self, penalty: Option<Penalty>) -> Result<Factor, Unsolved> {
        let fisher = &self.wide().1.fisher;
        let matrix = match penalty {
            None => fisher.clone(),
            Some(Penalty { lambda, matrix }) => fisher.plus(Dd::from(lambda), matrix),
        };
        let plain = matrix.to_f64();
        let zeros: Vec<usize> = (0..self.size()).filter(|&j| !(plain.get(j, j) > 0.0)).collect();
        let scale: Vec<f64> =
            (0..self.size()).map(|j| if plain.get(j, j) > 0.0 { 1.0 / plain.get(j, j).sqrt() } else { 1.0 }).collect();
        let factor = matrix.scaled(&scale).cholesky(NOTHING_WIDE);
        if !zeros.is_empty() || !factor.undetermined.is_empty() {
            return Err(Unsolved::Undetermined(factor.undetermined));
        }
        Ok(Factor { kind: Kind::Wide(factor), scale, condition: None })
    }

    /// Condition of F + λP on a unit diagonal, by Lanczos on the matrix and on its inverse.
    fn condition(&self, factor: &Factor, penalty: Option<Penalty>) -> Option<f64> {
        let n = self.size();
        let largest = largest_eigenvalue(n, |x| {
            let moved: Vec<f64> = x.iter().zip(&factor.scale).map(|(x, s)| x * s).collect();
            let mut y = self.normal.fisher.multiply(&moved);
            if let Some(Penalty { lambda, matrix }) = penalty {
                y.iter_mut().zip(matrix.multiply(&moved)).for_each(|(y, p)| *y += lambda * p);
            }
            y.iter_mut().zip(&factor.scale).for_each(|(y, s)| *y *= s);
            y
        })?;
        let inverse = largest_eigenvalue(n, |x| {
            let mut y = x.to_vec();
            factor.solve_scaled(&mut y);
            y
        })?;
        Some(largest * inverse).filter(|c| c.is_finite() && *c > 0.0)
    }

    /// The solution, refined.
    pub(crate) fn solve(&self, penalty: Option<Penalty>) -> Result<Solved, Unsolved> {
        if let Some(factor) = self.plain_factor(penalty)
            && let Ok(solved) = self.refine(factor, penalty)
        {
            return Ok(solved);
        }
        self.refine(self.wide_factor(penalty)?, penalty)
    }

    /// Residuals of coefficients, in the order of the cells.
    pub(crate) fn residuals(&self, c: &[Vec<Dd>]) -> Residuals {
        residuals(&self.axes, &self.cells, c, true)
    }

    fn refine(&self, mut factor: Factor, penalty: Option<Penalty>) -> Result<Solved, Unsolved> {
        factor.condition = self.condition(&factor, penalty);
        let plain = matches!(factor.kind, Kind::Plain(_));
        let delicate = !plain || factor.condition.is_none_or(|c| c > DELICATE) || self.entries() <= CHEAP;
        let mut coefficients: Vec<Vec<Dd>> = match &factor.kind {
            Kind::Plain(_) => self
                .normal
                .rhs
                .iter()
                .map(|rhs| {
                    let mut c = rhs.clone();
                    factor.solve(&mut c);
                    c.into_iter().map(Dd::from).collect()
                })
                .collect(),
            Kind::Wide(_) => self
                .wide()
                .1
                .rhs
                .iter()
                .map(|rhs| {
                    let mut c = rhs.clone();
                    factor.solve_wide(&mut c);
                    c
                })
                .collect(),
        };
        let length = |c: &[Vec<Dd>]| {
            let each = |c: &Vec<Dd>| c.iter().zip(&factor.scale).map(|(x, s)| (x.to_f64() / s).powi(2)).sum::<f64>();
            c.iter().map(each).sum::<f64>().sqrt()
        };
        let enough = if delicate { 1e-15 } else { 1e-13 };
        let mut last = f64::INFINITY;
        for round in 1..=ROUNDS {
            cancel::checkpoint();
            let pass = if delicate {
                let axes = &self.wide_axes();
                residuals(axes, &self.cells, &coefficients, false)
            } else {
                residuals(&self.axes, &self.cells, &coefficients, false)
            };
            let step: Vec<Vec<Dd>> = pass
                .projected
                .iter()
                .zip(&coefficients)
                .map(|(projected, c)| {
                    let mut left = projected.clone();
                    if let Some(Penalty { lambda, matrix }) = penalty {
                        pull(matrix, lambda, c, &mut left);
                    }
                    factor.solve_wide(&mut left);
                    left
                })
                .collect();
            let (moved, size) = (length(&step), length(&coefficients));
            if !moved.is_finite() || !size.is_finite() {
                return Err(Unsolved::Stagnant);
            }
            let relative = if size > 0.0 { moved / size } else { 0.0 };
            let stagnant = moved > 0.25 * last;
            if stagnant && relative > 1e-11 {
                return Err(Unsolved::Stagnant);
            }
            if !stagnant {
                for (c, step) in coefficients.iter_mut().zip(&step) {
                    c.iter_mut().zip(step).for_each(|(c, d)| *c += *d);
                }
            }
            last = moved;
            if stagnant || relative <= enough || round == ROUNDS {
                if relative > 1e-8 {
                    return Err(Unsolved::Stagnant);
                }
                return Ok(Solved { coefficients, residuals: pass, factor, rounds: round, last_correction: relative });
            }
        }
        Err(Unsolved::Stagnant)
    }

    fn wide_axes(&self) -> Axes<Dd> {
        Axes { u: Pieces::new(&self.bases[0]), v: Pieces::new(&self.bases[1]) }
    }
}

/// `left −= λ P c`, in double-double.
fn pull(matrix: &SymmetricBand<f64>, lambda: f64, c: &[Dd], left: &mut [Dd]) {
    let w = matrix.width();
    for i in (0..c.len()).asking(20 * (w + 1)) {
        let mut sum = Dd::ZERO;
        for j in i.saturating_sub(w)..(i + w + 1).min(c.len()) {
            let entry = matrix.get(i, j);
            if entry != 0.0 {
                sum += c[j] * entry;
            }
        }
        left[i] -= sum * lambda;
    }
}

fn unit(matrix: &SymmetricBand<f64>) -> Option<Vec<f64>> {
    (0..matrix.size())
        .map(|j| {
            let diagonal = matrix.get(j, j);
            (diagonal > 0.0 && diagonal.is_finite()).then(|| 1.0 / diagonal.sqrt())
        })
        .collect()
}

impl Factor {
    /// True if doubles sufficed.
    pub(crate) fn is_plain(&self) -> bool {
        matches!(self.kind, Kind::Plain(_))
    }

    fn solve_scaled(&self, b: &mut [f64]) {
        match &self.kind {
            Kind::Plain(factor) => factor.solve(b),
            Kind::Wide(factor) => {
                let mut wide: Vec<Dd> = b.iter().map(|&x| Dd::from(x)).collect();
                factor.solve(&mut wide);
                b.iter_mut().zip(wide).for_each(|(b, x)| *b = x.to_f64());
            }
        }
    }

    /// Solves with the unscaled matrix.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        b.iter_mut().zip(&self.scale).for_each(|(b, s)| *b *= s);
        self.solve_scaled(b);
        b.iter_mut().zip(&self.scale).for_each(|(b, s)| *b *= s);
    }

    fn solve_wide(&self, b: &mut [Dd]) {
        b.iter_mut().zip(&self.scale).for_each(|(b, s)| *b *= *s);
        match &self.kind {
            Kind::Plain(factor) => {
                let mut plain: Vec<f64> = b.iter().map(|x| x.to_f64()).collect();
                factor.solve(&mut plain);
                b.iter_mut().zip(plain).for_each(|(b, x)| *b = Dd::from(x));
            }
            Kind::Wide(factor) => factor.solve(b),
        }
        b.iter_mut().zip(&self.scale).for_each(|(b, s)| *b *= *s);
    }

    /// The band of `(F + λP)⁻¹`.
    pub(crate) fn inverse_band(&self) -> SymmetricBand<f64> {
        let scaled = match &self.kind {
            Kind::Plain(factor) => factor.inverse_band(),
            Kind::Wide(factor) => factor.inverse_band().to_f64(),
        };
        scaled.scaled(&self.scale)
    }
}
