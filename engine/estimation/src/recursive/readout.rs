//! From what is kept to what a fit goes on with: design, heights, factor.

use nalgebra::DMatrix;

use super::{caller_row::CallerRow, sums::Sums};
use crate::{
    data::{Form, Heights, Sample},
    design::{Basis, Design, of_columns},
    diagnostics::columns_within_range,
    error::FitError,
    factor::{Factor, scaled_condition},
    result::Arithmetic,
    spec::{Domain, FitSpec},
};
use flankfit_numerics::{Dd, Real, check::Faults, triangular};

impl Sums {
    /// Returns the sums with weights that fade by `forgetting` scaled to add up to the effective
    /// number of nodes, that number and the scale.
    pub(super) fn faded(&self, forgetting: f64) -> (Self, [f64; 2]) {
        let (mut sums, count) = (self.clone(), self.summary.count as f64);
        if forgetting == 1.0 {
            return (sums, [count, 1.0]);
        }
        let sum = |ratio: f64| -libm::expm1(count * libm::log(ratio)) / (1.0 - ratio);
        let scale = sum(forgetting) / sum(forgetting * forgetting);
        let (effective, squared) = (sum(forgetting) * scale, Dd::from(scale));
        sums.triangle.scale(squared.sqrt(), squared);
        sums.ones.iter_mut().chain(&mut sums.moments).for_each(|sum| *sum *= squared);
        sums.summary.slopes.iter_mut().for_each(|sum| *sum *= scale);
        sums.summary.rss = sums.triangle.rss();
        // with fewer than coefficients there are no degrees of freedom
        sums.summary.count = (effective.round() as usize).max(self.design.size());
        (sums, [effective, scale])
    }

    /// Returns the design completed by properties of the nodes.
    pub(super) fn caller_design(&self, spec: &FitSpec) -> Design {
        match &self.form {
            Form::Matrix { names, .. } => {
                let Basis::Columns { scale } = &self.design.basis else { return self.design.clone() };
                let constants: Vec<usize> =
                    (0..scale.len()).filter(|&j| self.same[j] && self.first[j] != 0.0).collect();
                of_columns(scale.clone(), &constants, names.as_deref())
            }
            form => {
                let given = spec.domain.unwrap_or_default();
                let [u, v] = self.summary.bounds;
                let v = (*form == Form::Surface).then(|| given.v.unwrap_or(v));
                Design { domain: Some(Domain { u: Some(given.u.unwrap_or(u)), v }), ..self.design.clone() }
            }
        }
    }

    pub(super) fn heights(&self) -> Heights {
        let [weight, sum, squares] = self.moments;
        Heights {
            weight: weight.to_f64(),
            about_mean: (squares - sum * sum / weight).to_f64().max(0.0),
            about_zero: squares.to_f64(),
            largest: self.largest[0],
            largest_plain: self.largest[1],
        }
    }

    /// True if a look at the nodes alone shows that the caller's columns stay within range. O(n) a
    /// node.
    pub(super) fn are_plain(&self, sample: &Sample) -> bool {
        let mut row = CallerRow::new(&self.design);
        (0..sample.count()).all(|k| row.is_plain(&self.design, sample, k))
    }

    /// Checks that every later fit can take the caller's columns; a block that spoils them is
    /// refused, since it could not be taken back.
    pub(super) fn columns_within_range(&self) -> Result<(), Faults> {
        let change = finite_change(&self.design)?;
        columns_within_range(&self.design, &triangular::multiply_upper(&self.triangle.r(), &change))
    }

    pub(super) fn factor(&self, design: &Design, heights: &Heights) -> Result<Factor, FitError> {
        let r = self.triangle.r();
        let qty = self.triangle.qty().to_vec();
        let change = finite_change(design).map_err(FitError::ExceedsDouble)?;
        // rounding of so many updates adds up like a random walk
        let rounded = (self.summary.count as f64).sqrt();
        let rss = self.triangle.rss().to_f64();
        let (working, relative_error) = match scaled_condition(&r) {
            Some((_, condition)) => {
                let mut working = qty.clone();
                triangular::solve_upper(&r, &mut working);
                let ratio = if heights.about_zero > 0.0 { (rss / heights.about_zero).sqrt() } else { 0.0 };
                let error = 4.0 * Dd::EPSILON * rounded * condition * (1.0 + condition * ratio);
                (Some(working), error.clamp(1e-30, 1.0))
            }
            None => (None, f64::EPSILON),
        };
        Ok(Factor {
            r,
            change,
            qty,
            working,
            ones: Some(self.ones.iter().map(|x| x.to_f64()).collect()),
            arithmetic: Arithmetic::DoubleDouble,
            relative_error,
            rss,
            max_abs: None,
            separable: None,
            rounded,
        })
    }
}

/// The change to the caller's basis, where doubles hold it.
fn finite_change(design: &Design) -> Result<DMatrix<Dd>, Faults> {
    let change = design.change_of_basis();
    if change.iter().all(|x| x.is_finite()) {
        return Ok(change);
    }
    Err(Faults::one("nodes", "powers of these numbers exceed the range of double precision"))
}
