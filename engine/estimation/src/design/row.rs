//! A row of the working matrix at a node.

use super::measurement_matrix::{Basis, Design};
use crate::data::Sample;
use flankfit_numerics::Real;

/// One row of the working matrix `W`: the columns that are not 0 and their values.
pub(crate) struct Row<T> {
    pub index: Vec<usize>,
    pub values: Vec<T>,
    u: Vec<T>,
    v: Vec<T>,
}

impl<T: Real> Row<T> {
    /// Allocates the rows of `design`.
    pub(crate) fn new(design: &Design) -> Self {
        let zeros = |size: usize| vec![T::of(0.0); size];
        let (u, v) = match &design.basis {
            Basis::Product { u, v } => (zeros(u.size()), zeros(v.size())),
            Basis::Columns { .. } => (Vec::new(), Vec::new()),
        };
        Row { index: Vec::with_capacity(design.size()), values: Vec::with_capacity(design.size()), u, v }
    }

    /// Fills in the row of counted node `k`.
    pub(crate) fn at(&mut self, design: &Design, sample: &Sample, k: usize) {
        self.index.clear();
        self.values.clear();
        if let Some(columns) = sample.white_columns(k) {
            self.index.extend(0..columns.len());
            self.values.extend(columns.iter().map(|&x| T::of_dd(x)));
            return;
        }
        match &design.basis {
            Basis::Columns { scale } => {
                for (j, (x, s)) in sample.matrix_row(k).iter().zip(scale).enumerate() {
                    self.index.push(j);
                    self.values.push(T::of(x / s));
                }
            }
            Basis::Product { u, v } => {
                let (x, y) = sample.place(k);
                u.row(x, &mut self.u);
                v.row(y, &mut self.v);
                let zero = T::of(0.0);
                for (column, &(i, j)) in design.terms.iter().enumerate() {
                    if self.u[i] != zero && self.v[j] != zero {
                        self.index.push(column);
                        self.values.push(self.u[i] * self.v[j]);
                    }
                }
                if let Some(net) = &design.rational {
                    let whole = net.sum(&self.u, &self.v);
                    self.values.iter_mut().for_each(|value| *value = *value / whole);
                }
            }
        }
    }
}
