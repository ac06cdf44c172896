//! The caller's columns at a node, in double precision: how they slope there, and whether they are
//! far from the ends of the range.

use crate::{
    data::Sample,
    design::{Axis, Basis, Design, add_slopes},
};

/// Values and derivatives of the caller's functions on either axis.
pub(super) struct CallerRow {
    u: [Vec<f64>; 2],
    v: [Vec<f64>; 2],
}

impl CallerRow {
    /// Allocates the functions of `design`.
    pub(super) fn new(design: &Design) -> Self {
        let zeros = |axis: &Axis| [vec![0.0; axis.size()], vec![0.0; axis.size()]];
        match &design.basis {
            Basis::Product { u, v } => CallerRow { u: zeros(u), v: zeros(v) },
            Basis::Columns { .. } => CallerRow { u: Default::default(), v: Default::default() },
        }
    }

    fn at(&mut self, u: &Axis, v: &Axis, (x, y): (f64, f64)) {
        let ([fu, du], [fv, dv]) = (&mut self.u, &mut self.v);
        u.caller_row(x, fu, du);
        v.caller_row(y, fv, dv);
    }

    /// Adds `w ((∂x/∂u)² + (∂x/∂v)²)` of every column (w for entries that are posted themselves).
    pub(super) fn add_slopes(&mut self, design: &Design, sample: &Sample, k: usize, sums: &mut [f64]) {
        let weight = sample.w(k);
        let Basis::Product { u, v } = &design.basis else {
            sums.iter_mut().for_each(|sum| *sum += weight);
            return;
        };
        self.at(u, v, sample.place(k));
        let ([fu, du], [fv, dv]) = (&self.u, &self.v);
        add_slopes(design, weight, [fu, du], [fv, dv], sums);
    }

    /// True if every column is 0 at node `k` or far from where squares leave the range of double
    /// precision: so far that no number of such nodes gets there.
    pub(super) fn is_plain(&mut self, design: &Design, sample: &Sample, k: usize) -> bool {
        const PLAIN: std::ops::Range<f64> = 1e-130..1e130;
        let root = sample.w(k).sqrt();
        let plain = |x: f64| x == 0.0 || PLAIN.contains(&(root * x.abs()));
        match &design.basis {
            Basis::Columns { .. } => sample.matrix_row(k).iter().all(|&x| plain(x)),
            Basis::Product { u, v } => {
                self.at(u, v, sample.place(k));
                let ([fu, _], [fv, _]) = (&self.u, &self.v);
                design.terms.iter().all(|&(i, j)| plain(fu[i] * fv[j]))
            }
        }
    }
}
