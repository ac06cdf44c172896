//! The measurement matrix `X` (Eqs. 13–14): which functions, under which names, on which domain.
//!
//! Two bases are kept apart. The *caller's* basis is what coefficients are reported in. The
//! *working* basis is what is computed in: Chebyshev polynomials of the mapped abscissae, B-splines
//! as they are, or the posted columns divided by powers of 2. An upper triangular `T` leads from
//! one to the other, `X = W · T`. A curve is a surface whose second axis carries the single
//! function 1.

use nalgebra::DMatrix;

use super::axis::Axis;
use crate::{result::TermKey, spec::Domain};
use flankfit_geometry::WeightNet;
use flankfit_numerics::{Dd, check::Faults};

/// The largest number of coefficients: the n×n analysis must stay within seconds.
pub(crate) const MOST_COEFFICIENTS: usize = 600;

/// A checked model on checked nodes.
#[derive(Clone)]
pub(crate) struct Design {
    pub basis: Basis,
    /// `(i, j)` of every coefficient, in coefficient order.
    pub terms: Vec<(usize, usize)>,
    pub labels: Vec<String>,
    pub keys: Vec<TermKey>,
    /// Index of the coefficient that multiplies the constant function, if one does.
    pub constant: Option<usize>,
    /// True if the constant lies in the span of the columns; `None` if that is not known
    /// beforehand.
    pub constant_in_span: Option<bool>,
    pub domain: Option<Domain>,
    /// Weights of NURBS: working functions are then `NᵢNⱼ / W`, the caller's `wᵢⱼ` times those.
    pub rational: Option<WeightNet>,
}

/// The working basis.
#[derive(Clone)]
pub(crate) enum Basis {
    Product {
        u: Axis,
        v: Axis,
    },
    /// Posted columns divided by these powers of 2.
    Columns {
        scale: Vec<f64>,
    },
}

impl Design {
    /// n, the number of coefficients.
    pub(crate) fn size(&self) -> usize {
        self.terms.len()
    }

    /// True if coefficients are all products of the two axes' functions.
    pub(crate) fn is_full_product(&self) -> bool {
        match &self.basis {
            // a denominator that is no product of functions of u and v does not separate
            Basis::Product { u, v } => self.terms.len() == u.size() * v.size() && self.rational.is_none(),
            Basis::Columns { .. } => false,
        }
    }

    /// `T`, n×n upper triangular (diagonal for posted columns).
    pub(crate) fn change_of_basis(&self) -> DMatrix<Dd> {
        let n = self.size();
        if let Some(net) = &self.rational {
            let weights = net.weights();
            return DMatrix::from_fn(n, n, |i, j| if i == j { Dd::from(weights[i]) } else { Dd::ZERO });
        }
        match &self.basis {
            Basis::Product { u, v } => {
                let (tu, tv) = (u.change(), v.change());
                DMatrix::from_fn(n, n, |row, column| {
                    let ((i, j), (p, q)) = (self.terms[row], self.terms[column]);
                    if i <= p && j <= q { tu[(i, p)] * tv[(j, q)] } else { Dd::ZERO }
                })
            }
            Basis::Columns { scale } => {
                DMatrix::from_fn(n, n, |i, j| if i == j { Dd::from(scale[i]) } else { Dd::ZERO })
            }
        }
    }
}

pub(super) fn too_many(n: usize, path: &str) -> Result<(), Faults> {
    if n <= MOST_COEFFICIENTS {
        return Ok(());
    }
    let count = (n < usize::MAX).then_some(n);
    Err(Faults::one(
        path,
        format_args!(
            "a fit has at most {MOST_COEFFICIENTS} coefficients, this model has {}: use fewer",
            count.map_or("more".to_owned(), |count| count.to_string())
        ),
    ))
}
