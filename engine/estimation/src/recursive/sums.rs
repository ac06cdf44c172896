//! Sums over nodes, and their update by a node.

use super::caller_row::CallerRow;
use crate::{
    data::{Form, Sample},
    design::{Boxes, Design, Row},
    diagnostics::correct_digits,
    problem::SummaryStatistics,
    spec::FitSpec,
};
use flankfit_numerics::{Dd, Triangle, cancel::Asking};

/// Sums that are kept of the nodes.
#[derive(Clone)]
pub(super) struct Sums {
    pub form: Form,
    pub design: Design,
    /// Domain of the working functions.
    pub boxes: Boxes,
    pub triangle: Triangle<Dd>,
    /// `Σ w W`, by column.
    pub ones: Vec<Dd>,
    /// Σ w, Σ w z, Σ w z².
    pub moments: [Dd; 3],
    /// max √w |z|, max |z|.
    pub largest: [f64; 2],
    /// For a measurement matrix: the first row, and which columns have not varied since.
    pub first: Vec<f64>,
    pub same: Vec<bool>,
    pub summary: SummaryStatistics,
}

impl Sums {
    /// Before the first node of `form`.
    pub(super) fn new(form: Form, design: Design, boxes: Boxes, sample: &Sample, spec: &FitSpec) -> Self {
        let n = design.size();
        let matrix = matches!(form, Form::Matrix { .. });
        Sums {
            boxes,
            triangle: Triangle::new(n),
            ones: vec![Dd::ZERO; n],
            moments: [Dd::ZERO; 3],
            largest: [0.0; 2],
            first: if matrix { sample.matrix_row(0).to_vec() } else { Vec::new() },
            same: if matrix { vec![true; n] } else { Vec::new() },
            summary: SummaryStatistics {
                count: 0,
                rss: Dd::ZERO,
                rounded_heights: false,
                rounded_places: [0.0; 2],
                bounds: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
                rounded_columns: if matrix { vec![0.0; n] } else { Vec::new() },
                slopes: vec![0.0; if spec.node_uncertainty.is_some() { n } else { 0 }],
            },
            form,
            design,
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.triangle.is_finite()
            && self.ones.iter().chain(&self.moments).all(|x| x.is_finite())
            && self.summary.slopes.iter().all(|x| x.is_finite())
    }

    pub(super) fn add(&mut self, sample: &Sample, forgetting: f64, slopes: bool) {
        let fading = Dd::from(forgetting);
        let root_fading = fading.sqrt();
        let n = self.design.size();
        let mut row = Row::<Dd>::new(&self.design);
        let mut x = vec![Dd::ZERO; n];
        let mut slope = slopes.then(|| CallerRow::new(&self.design));
        for k in (0..sample.count()).asking(10 * n * n) {
            if forgetting < 1.0 {
                self.triangle.scale(root_fading, fading);
                self.ones.iter_mut().chain(&mut self.moments).for_each(|sum| *sum *= fading);
                self.summary.slopes.iter_mut().for_each(|sum| *sum *= forgetting);
            }
            let (weight, z) = (sample.w(k), sample.z(k));
            let root = if weight == 1.0 { Dd::ONE } else { Dd::from(weight).sqrt() };
            row.at(&self.design, sample, k);
            x.fill(Dd::ZERO);
            for (&j, &value) in row.index.iter().zip(&row.values) {
                x[j] = value * root;
                self.ones[j] += value * weight;
            }
            self.triangle.fold(&mut x, root * z);
            let weighted = Dd::product(weight, z);
            self.moments[0] += Dd::from(weight);
            self.moments[1] += weighted;
            self.moments[2] += weighted * z;
            self.largest[0] = self.largest[0].max(root.to_f64() * z.abs());
            self.largest[1] = self.largest[1].max(z.abs());
            if let Some(slope) = &mut slope {
                slope.add_slopes(&self.design, sample, k, &mut self.summary.slopes);
            }
            self.look_at(sample, k, root.to_f64());
        }
        self.summary.rss = self.triangle.rss();
    }

    /// Updates the quantities that the estimate of correct digits and the report need of each node.
    fn look_at(&mut self, sample: &Sample, k: usize, root: f64) {
        let summary = &mut self.summary;
        summary.count += 1;
        summary.rounded_heights |= !correct_digits::exact(sample.z(k));
        let (u, v) = sample.place(k);
        for (axis, at) in [u, v].into_iter().enumerate() {
            let [low, high] = &mut summary.bounds[axis];
            (*low, *high) = (low.min(at), high.max(at));
            if !correct_digits::exact(at) {
                summary.rounded_places[axis] = summary.rounded_places[axis].max(at.abs());
            }
        }
        for (j, &x) in sample.matrix_row(k).iter().enumerate() {
            self.same[j] &= x == self.first[j];
            if !correct_digits::exact(x) {
                summary.rounded_columns[j] = summary.rounded_columns[j].max(root * x.abs());
            }
        }
    }
}
