//! The box of the working basis, which grows with the nodes where the caller gives no domain.
//!
//! Its half-width is a power of 2 that at least doubles, so it grows seldom; R goes over to the new
//! basis by the triangular matrix that leads from one to the other.

use nalgebra::DMatrix;

use super::{opening::met_at, sums::Sums};
use crate::{
    estimation::{
        data::{Form, Sample},
        design::{Axis, Basis, bounding_box, power_of_two, product_on},
        error::Faults,
        spec::{FitSpec, Model},
    },
    geometry::{
        Mapping,
        polynomial::{self, Family},
    },
    numerics::{Dd, triangular},
};

impl Sums {
    /// Lets the working box grow where nodes fall outside of it and the caller fixed no domain;
    /// says whether it did.
    pub fn make_room(&mut self, sample: &Sample, spec: &FitSpec) -> Result<bool, Faults> {
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
            return Err(Faults::one("/nodes", "these abscissae leave the range of double precision"));
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
        self.design = met_at(product_on(surface, &spec.model, new, new), "/nodes/type")?;
        Ok(true)
    }
}

/// A box around `[low, high]` with some room whose half-width is a power of 2 and whose centre is a
/// multiple of an eighth of it, so that mapping it to [-1, 1] is exact.
pub fn roomy([low, high]: [f64; 2]) -> [f64; 2] {
    /// Half-width around a lone 0.
    const LONE: f64 = 1.0 / 1_048_576.0;
    /// Narrowest half-width against the distance from 0.
    const NARROW: f64 = 1.0 / (1u64 << 40) as f64;
    let far = low.abs().max(high.abs());
    let half = (0.5 * high - 0.5 * low).max(far * NARROW);
    let wanted = 1.25 * if half > 0.0 { half } else { LONE };
    let below = power_of_two(wanted);
    let half = if below < wanted { 2.0 * below } else { below };
    let step = 0.125 * half;
    let center = ((0.5 * low + 0.5 * high) / step).round() * step;
    [center - half, center + half]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_have_room_and_map_exactly() {
        for [low, high] in [[0.0, 0.0], [30.0, 34.0], [-1e-9, 1e-9], [1e9, 1e9], [1e300, 1e300], [0.1, 0.3]] {
            let [a, b] = roomy([low, high]);
            assert!(a <= low && high <= b && a < b, "{low} {high}: {a} {b}");
            let map = Mapping::over(a, b);
            assert_eq!((map.map::<f64>(a), map.map::<f64>(b)), (-1.0, 1.0));
            assert_eq!(map.scale, power_of_two(map.scale));
        }
    }
}
