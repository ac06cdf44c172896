//! Designs and errors that the checks of residuals are tried on.

use super::random::Random;
use flankfit_engine::estimation::{
    FitError, FitSpec, Nodes,
    spec::{Degree, Model, PolynomialBasis, Regularization, Terms},
};

/// A grid, perhaps with holes, and a polynomial.
pub struct Checked {
    pub name: &'static str,
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    /// False where a node is missing.
    pub counts: Vec<bool>,
    pub spec: FitSpec,
}

fn axis(count: usize, low: f64, high: f64) -> Vec<f64> {
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

impl Checked {
    fn new(name: &'static str, u: Vec<f64>, v: Vec<f64>, degree: (usize, usize), basis: PolynomialBasis) -> Self {
        let model = Model::Polynomial { degree: Degree::Each(degree.0, degree.1), basis, terms: Terms::Tensor };
        let counts = vec![true; u.len() * v.len()];
        let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
        Checked { name, u, v, counts, spec }
    }

    /// A: 9 × 5; B: 15 × 9; C: A without 11 nodes, a corner of six among them; D: 15 × 9, cubic.
    pub fn all() -> [Self; 4] {
        let a = || Self::new("A", axis(9, 5.2, 11.8), axis(5, 0.5, 14.5), (2, 2), PolynomialBasis::Monomial);
        let b = Self::new("B", axis(15, 30.4, 49.6), axis(9, 1.0, 39.0), (3, 2), PolynomialBasis::Legendre);
        let d = Self::new("D", axis(15, 5.0, 12.0), axis(9, 0.4, 14.6), (3, 3), PolynomialBasis::Monomial);
        let mut c = Checked { name: "C", ..a() };
        for missing in [0, 1, 5, 6, 10, 11, 18, 24, 32, 37, 43] {
            c.counts[missing] = false;
        }
        [a(), b, c, d]
    }

    /// 5 × 5 nodes, the six terms of a flank surface.
    pub fn second_order() -> Self {
        let axis = || axis(5, -1.0, 1.0);
        let mut design = Self::new("5 × 5", axis(), axis(), (2, 2), PolynomialBasis::Monomial);
        let (basis, terms) = (PolynomialBasis::Monomial, Terms::Total);
        design.spec.model = Model::Polynomial { degree: Degree::Both(2), basis, terms };
        design
    }

    /// Heights `height(row, column)` where nodes are.
    pub fn nodes(&self, mut height: impl FnMut(usize, usize) -> f64) -> Result<Nodes, FitError> {
        let width = self.v.len();
        let z = (0..self.counts.len()).map(|k| {
            let z = height(k / width, k % width);
            if self.counts[k] { z } else { f64::NAN }
        });
        Ok(Nodes::grid(self.u.clone(), self.v.clone(), z.collect(), None, None)?)
    }

    pub fn white(&self, random: &mut Random) -> Result<Nodes, FitError> {
        self.nodes(|_, _| random.normal())
    }

    /// ρ between neighbours along u, or along v.
    pub fn correlated(&self, random: &mut Random, rho: f64, along_u: bool) -> Result<Nodes, FitError> {
        let (rows, columns) = (self.u.len(), self.v.len());
        let (lines, count) = if along_u { (columns, rows) } else { (rows, columns) };
        let errors: Vec<Vec<f64>> = (0..lines).map(|_| random.autoregression(count, rho)).collect();
        self.nodes(|i, j| if along_u { errors[j][i] } else { errors[i][j] })
    }

    /// ρ between neighbours along u and another along v.
    pub fn correlated_both(&self, random: &mut Random, [along_u, along_v]: [f64; 2]) -> Result<Nodes, FitError> {
        let rows: Vec<Vec<f64>> = (0..self.u.len()).map(|_| random.autoregression(self.v.len(), along_v)).collect();
        let mut errors = rows.clone();
        for i in 1..rows.len() {
            for (j, own) in rows[i].iter().enumerate() {
                errors[i][j] = along_u * errors[i - 1][j] + (1.0 - along_u * along_u).sqrt() * own;
            }
        }
        self.nodes(|i, j| errors[i][j])
    }

    /// σ times `factor` on the first and last row.
    pub fn rough_borders(&self, random: &mut Random, factor: f64) -> Result<Nodes, FitError> {
        let last = self.u.len() - 1;
        self.nodes(|i, _| random.normal() * if i == 0 || i == last { factor } else { 1.0 })
    }

    /// Relief of `tip` at the ends of u and `end` at the ends of v, in σ, over the outer fifth.
    pub fn relieved(&self, random: &mut Random, tip: f64, end: f64) -> Result<Nodes, FitError> {
        let part = |axis: &[f64], x: f64| {
            let (low, high) = (axis[0], axis[axis.len() - 1]);
            let t = (2.0 * x - low - high).abs() / (high - low);
            ((t - 0.6) / 0.4).max(0.0).powi(2)
        };
        self.nodes(|i, j| random.normal() - tip * part(&self.u, self.u[i]) - end * part(&self.v, self.v[j]))
    }

    /// A tenth of the nodes in the corner of the last rows and columns off by 15 σ.
    pub fn cornered(&self, random: &mut Random) -> Result<Nodes, FitError> {
        let (rows, columns) = (self.u.len(), self.v.len());
        let side = (0.1 * (rows * columns) as f64).sqrt().round() as usize;
        self.nodes(|i, j| random.normal() + if i + side >= rows && j + side >= columns { 15.0 } else { 0.0 })
    }
}
