//! From the working basis to the caller's, enclosed.

use nalgebra::DMatrix;

use crate::design::{Axis, Basis, Design};
use flankfit_geometry::{Mapping, polynomial::Family};
use flankfit_numerics::{Ball, Dd, cancel::Asking};

/// `T⁻¹`, upper triangular: of each column the entries that are not 0.
pub(super) type Columns = Vec<Vec<(usize, Ball)>>;

/// `T⁻¹` of a whole design; `None` for B-splines.
pub(super) fn inverse_change(design: &Design) -> Option<Columns> {
    match &design.basis {
        // powers of 2
        Basis::Columns { scale } => {
            Some(scale.iter().enumerate().map(|(j, scale)| vec![(j, Ball::from(1.0 / scale))]).collect())
        }
        Basis::Product { u, v } => {
            let (u, v) = (of_axis(u)?, of_axis(v)?);
            let column = |&(p, q): &(usize, usize)| {
                let before = design.terms.iter().enumerate().take_while(|(_, term)| **term <= (p, q));
                let entry = |(row, &(i, j)): (usize, &(usize, usize))| (row, u[(i, p)] * v[(j, q)]);
                before.filter(|(_, (i, j))| *i <= p && *j <= q).map(entry).filter(|(_, x)| !x.is_zero()).collect()
            };
            Some(design.terms.iter().asking(20 * design.size()).map(column).collect())
        }
    }
}

/// `T⁻¹` of one axis; `None` for B-splines.
pub(super) fn of_axis(axis: &Axis) -> Option<DMatrix<Ball>> {
    match axis {
        Axis::Polynomial { family, mapping, size } => Some(of_chebyshev(*family, *mapping, *size)),
        Axis::Spline(_) => None,
    }
}

/// The polynomials `Tⱼ(t)` of the mapped abscissa in `family`, column by column, by `Tⱼ₊₁ = 2t Tⱼ −
/// Tⱼ₋₁` with `t = offset + gain τ`.
fn of_chebyshev(family: Family, mapping: Mapping, size: usize) -> DMatrix<Ball> {
    let scale = Ball::from(mapping.scale);
    let (offset, gain) = match family {
        Family::Monomial => (-Ball::from(mapping.center) * scale, scale),
        Family::Chebyshev { low, high } | Family::Legendre { low, high } => {
            let half = |x: Dd| Ball::from(x).scale_pow2(0.5);
            ((half(Dd::sum(low, high)) - Ball::from(mapping.center)) * scale, half(Dd::diff(high, low)) * scale)
        }
    };
    let mut t = DMatrix::from_element(size, size, Ball::ZERO);
    t[(0, 0)] = Ball::from(1.0);
    for j in 1..size {
        let mut next = vec![Ball::ZERO; size + 1];
        for i in 0..j {
            let one = t[(i, j - 1)];
            next[i] = next[i] + offset * one;
            let moved = gain * one;
            let k = i as f64;
            // τ times function i
            match family {
                Family::Chebyshev { .. } if i > 0 => {
                    next[i + 1] = next[i + 1] + moved.scale_pow2(0.5);
                    next[i - 1] = next[i - 1] + moved.scale_pow2(0.5);
                }
                Family::Legendre { .. } if i > 0 => {
                    let share = moved.over(2.0 * k + 1.0);
                    next[i + 1] = next[i + 1] + share * Ball::from(k + 1.0);
                    next[i - 1] = next[i - 1] + share * Ball::from(k);
                }
                _ => next[i + 1] = next[i + 1] + moved,
            }
        }
        for i in 0..=j {
            t[(i, j)] = if j == 1 { next[i] } else { next[i].scale_pow2(2.0) - t[(i, j - 2)] };
        }
    }
    t
}
