//! The working functions, and their slopes, at any place of the domain.

use super::{
    axis::Axis,
    measurement_matrix::{Basis, Design},
};
use crate::spec::Domain;
use flankfit_geometry::{BSplineBasis, polynomial::chebyshev_derivatives};
use flankfit_numerics::{Dd, Real};

/// Value or derivative of the working functions at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Along {
    Value,
    /// The derivative by u (by x for a curve).
    U,
    V,
}

impl Axis {
    /// First derivatives of every working function at `x`.
    fn slope_row(&self, x: f64, out: &mut [Dd]) {
        match self {
            Axis::Polynomial { mapping, .. } => {
                chebyshev_derivatives(1, mapping.map::<Dd>(x), out);
                out.iter_mut().for_each(|value| *value = value.mul_f64(mapping.scale));
            }
            Axis::Spline(basis) => {
                out.fill(Dd::ZERO);
                let first = local_slopes(basis, x, out);
                out.rotate_right(first);
            }
        }
    }
}

/// Slopes of the functions that are not 0 at `x` to the front of `out`; which is the first of them.
fn local_slopes(basis: &BSplineBasis, x: f64, out: &mut [Dd]) -> usize {
    basis.derivatives_of(1, x, &mut out[..=basis.degree()])
}

impl Design {
    /// The row of the working matrix of a row of posted columns; of those alone.
    pub(crate) fn row_of(&self, row: &[f64]) -> Vec<Dd> {
        let Basis::Columns { scale } = &self.basis else { return Vec::new() };
        // powers of 2: the quotients are exact
        row.iter().zip(scale).map(|(x, scale)| Dd::from(x / scale)).collect()
    }

    /// The row of the working matrix at a place and its derivatives by u and v.
    pub(crate) fn tangent(&self, place: [f64; 2]) -> [Vec<f64>; 3] {
        [Along::Value, Along::U, Along::V].map(|along| match (along, self.domain) {
            (Along::V, Some(Domain { v: None, .. })) => vec![0.0; self.size()],
            _ => self.row_at(place, along).iter().map(|x| x.to_f64()).collect(),
        })
    }

    /// The row of the working matrix at (u, v), with v unused for a curve; of a product of
    /// functions alone. Every function, zeros included.
    pub(crate) fn row_at(&self, [u, v]: [f64; 2], along: Along) -> Vec<Dd> {
        let Basis::Product { u: axis_u, v: axis_v } = &self.basis else { return Vec::new() };
        let row = |axis: &Axis, x: f64, slope: bool| {
            let mut out = vec![Dd::ZERO; axis.size()];
            if slope {
                axis.slope_row(x, &mut out)
            } else {
                axis.row(x, &mut out)
            }
            out
        };
        let product = |(fu, fv): (&[Dd], &[Dd])| self.terms.iter().map(|&(i, j)| fu[i] * fv[j]).collect::<Vec<Dd>>();
        let (values_u, values_v) = (row(axis_u, u, false), row(axis_v, v, false));
        let plain = product((&values_u, &values_v));
        let sloped = match along {
            Along::Value => None,
            Along::U => Some((row(axis_u, u, true), values_v.clone())),
            Along::V => Some((values_u.clone(), row(axis_v, v, true))),
        };
        let Some(net) = &self.rational else {
            return sloped.map_or(plain, |(fu, fv)| product((&fu, &fv)));
        };
        let whole = net.sum(&values_u, &values_v);
        match sloped {
            None => plain.iter().map(|&x| x / whole).collect(),
            // (N/W)′ = (N′ − N W′/W)/W
            Some((fu, fv)) => {
                let turning = net.sum(&fu, &fv) / whole;
                product((&fu, &fv)).iter().zip(&plain).map(|(&slope, &x)| (slope - x * turning) / whole).collect()
            }
        }
    }
}
