//! Cause of a near dependency, the nodes or the basis: condition of the same column space in
//! Legendre's basis over the domain.
//!
//! Raw powers far from 0 are nearly collinear wherever the nodes are. In a basis that is
//! orthonormal over the domain, columns are nearly dependent only if the nodes do not determine
//! some function: one that is not small over the domain is small at all nodes.

use nalgebra::DMatrix;

use crate::{
    design::{Axis, Basis, Design},
    factor::Factor,
    result::{Cause, OrthonormalBasis},
    spec::PolynomialBasis,
};
use flankfit_geometry::polynomial::Family;
use flankfit_numerics::{jacobi, symmetric, triangular};

/// Condition index above which a dependency is called near (Belsley's rule).
pub(super) const NEAR: f64 = 30.0;
/// Eigenvalues below this share of the largest are computed from singular values.
const SMALL: f64 = 1e-8;

/// The columns of a polynomial model in Legendre's basis.
pub(super) struct Legendre {
    /// Condition λₙ/λ₁ of the Fisher information matrix of the unit-length columns; `None` if they
    /// are linearly dependent.
    condition: Option<f64>,
    /// The unit-length columns in Q's coordinates, upper triangular; `None` if they are not needed.
    columns: Option<DMatrix<f64>>,
    /// Phrase that names the caller's basis.
    place: &'static str,
}

impl Legendre {
    /// `None` for a model that is not made of polynomials.
    pub(super) fn new(design: &Design, factor: &Factor) -> Option<Self> {
        let Basis::Product { u, v } = &design.basis else { return None };
        let domain = design.domain.filter(|_| design.rational.is_none())?;
        let (tu, tv) = (change(u, domain.u)?, change(v, domain.v)?);
        let columns = || {
            let change = DMatrix::from_fn(design.size(), design.size(), |row, column| {
                let ((i, j), (p, q)) = (design.terms[row], design.terms[column]);
                if i <= p && j <= q { tu[(i, p)] * tv[(j, q)] } else { 0.0 }
            });
            of_unit_length(triangular::multiply_upper(&factor.r.map(|x| x.to_f64()), &change))
        };
        let axes = factor.separable.as_ref().map(|separable| &separable.axes);
        let (condition, columns) = match axes {
            Some(axes) => {
                let of = |r: &DMatrix<_>, change: &DMatrix<f64>| {
                    let r = r.map(|x: flankfit_numerics::Dd| x.to_f64());
                    condition(&of_unit_length(triangular::multiply_upper(&r, change)))
                };
                let condition = of(&axes.u.r, &tu).zip(of(&axes.v.r, &tv)).map(|(u, v)| u * v);
                let needed = condition.is_none_or(|condition| condition > NEAR * NEAR);
                (condition, needed.then(columns))
            }
            None => {
                let columns = columns();
                (condition(&columns), Some(columns))
            }
        };
        let finite = columns.as_ref().is_none_or(|columns| columns.iter().all(|x| x.is_finite()));
        finite.then(|| Legendre { condition, columns, place: place(u) })
    }

    /// Returns the part of the answer that describes this basis.
    pub(super) fn to_result(&self) -> OrthonormalBasis {
        OrthonormalBasis { kind: PolynomialBasis::Legendre, condition: self.condition }
    }

    /// Returns why the caller's columns nearly cancel along a direction whose image in Q's
    /// coordinates is `image`.
    pub(super) fn cause(&self, image: &[f64]) -> Cause {
        let Some(columns) = self.columns.as_ref().filter(|_| !self.is_well_conditioned()) else { return Cause::Basis };
        let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut coefficients = image.to_vec();
        triangular::solve_upper(columns, &mut coefficients);
        let largest = symmetric::extremes(columns.transpose() * columns).map_or(1.0, |[_, high]| high.sqrt());
        let index = largest * length(&coefficients) / length(image);
        if index <= NEAR { Cause::Basis } else { Cause::Nodes }
    }

    fn is_well_conditioned(&self) -> bool {
        self.condition.is_some_and(|condition| condition <= NEAR * NEAR)
    }

    /// Returns the phrases for a dependency caused by the basis: the basis it occurs in, and the
    /// consequence.
    pub(super) fn consolation(&self) -> (&'static str, &'static str) {
        let follows = match self.is_well_conditioned() {
            true => "): the fitted function and results derived from it are not affected",
            false => "): in Legendre's basis this dependency disappears, others remain",
        };
        (self.place, follows)
    }
}

fn place(axis: &Axis) -> &'static str {
    match axis {
        Axis::Polynomial { family: Family::Monomial, .. } => " as raw powers",
        Axis::Polynomial { .. } | Axis::Spline(_) => " in this basis",
    }
}

/// Returns the change of basis from the working functions of an axis to Legendre's polynomials over
/// `domain`.
fn change(axis: &Axis, domain: Option<[f64; 2]>) -> Option<DMatrix<f64>> {
    let Axis::Polynomial { mapping, size, .. } = axis else { return None };
    let Some([low, high]) = domain.filter(|_| *size > 1) else { return Some(DMatrix::identity(*size, *size)) };
    let family = Family::Legendre { low, high };
    Some(Axis::Polynomial { family, mapping: *mapping, size: *size }.change().map(|x| x.to_f64()))
}

fn of_unit_length(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in columns.column_iter_mut() {
        let length = column.norm();
        if length > 0.0 {
            column /= length;
        }
    }
    columns
}

fn condition(columns: &DMatrix<f64>) -> Option<f64> {
    let [low, high] = symmetric::extremes(columns.transpose() * columns)?;
    if low > SMALL * high {
        return Some(high / low);
    }
    let sigma = jacobi::svd(columns.clone())?.sigma;
    let (low, high) = (*sigma.first()?, *sigma.last()?);
    (low > f64::EPSILON * columns.ncols() as f64 * high).then(|| (high / low).powi(2))
}
