//! The box of the working basis, which grows with the nodes where the caller gives no domain.
//!
//! Its half-width is a power of 2 that at least doubles, so it grows seldom; R goes over to the new
//! basis by the triangular matrix that leads from one to the other.

use nalgebra::DMatrix;

use super::{boxes::roomy, opening::met_at, sums::Sums};
use crate::{
    data::{Form, Sample},
    design::{Axis, Basis, bounding_box, product_on},
    spec::{FitSpec, Model},
};
use flankfit_geometry::{
    Mapping,
    polynomial::{self, Family},
};
use flankfit_numerics::{Dd, check::Faults, triangular};

impl Sums {
    /// Lets the working box grow where nodes fall outside of it and the caller fixed no domain;
    /// says whether it did.
    pub(super) fn make_room(&mut self, sample: &Sample, spec: &FitSpec) -> Result<bool, Faults> {
        let Model::Polynomial { .. } = &spec.model else { return Ok(false) };
        let domain = spec.domain.unwrap_or_default();
        let (u, v) = bounding_box(sample);
        let old = self.boxes;
        let grown = |own: [f64; 2], of: [f64; 2], fixed: bool| {
            if fixed || (own[0] <= of[0] && of[1] <= own[1]) {
                own
            } else {
                roomy([own[0].min(of[0]), own[1].max(of[1])])
            }
        };
        let surface = self.form == Form::Surface;
        let new = (grown(old.0, u, domain.u.is_some()), grown(old.1, v, domain.v.is_some() || !surface));
        if new == old {
            return Ok(false);
        }
        if ![new.0, new.1].as_flattened().iter().all(|x| x.is_finite()) {
            return Err(Faults::one("nodes", "these abscissae exceed the range of double precision"));
        }
        let Basis::Product { u: axis_u, v: axis_v } = &self.design.basis else { return Ok(false) };
        let (tu, tv) = (rebased(axis_u, old.0, new.0), rebased(axis_v, old.1, new.1));
        let n = self.design.size();
        let terms = &self.design.terms;
        let change = DMatrix::from_fn(n, n, |row, column| {
            let ((i, j), (p, q)) = (terms[row], terms[column]);
            if i <= p && j <= q { tu[(i, p)] * tv[(j, q)] } else { Dd::ZERO }
        });
        self.triangle.set_r(&triangular::multiply_upper(&self.triangle.r(), &change));
        self.ones = (0..n).map(|j| (0..=j).fold(Dd::ZERO, |sum, i| sum + change[(i, j)] * self.ones[i])).collect();
        self.boxes = new;
        self.design = met_at(product_on(surface, &spec.model, new, new), "nodes.type")?;
        Ok(true)
    }
}

/// Chebyshev polynomials on the box `new` in those on `old`.
fn rebased(axis: &Axis, old: [f64; 2], new: [f64; 2]) -> DMatrix<Dd> {
    let n = axis.size();
    if old == new {
        return DMatrix::from_fn(n, n, |i, j| if i == j { Dd::ONE } else { Dd::ZERO });
    }
    let family = Family::Chebyshev { low: new[0], high: new[1] };
    polynomial::change_of_basis(family, Mapping::over(old[0], old[1]), n)
}
