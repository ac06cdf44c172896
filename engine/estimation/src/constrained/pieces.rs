//! A derivative along an axis, piece by piece in Bernstein's basis.
//!
//! Between two knots a derivative of a B-spline is a polynomial, and so is one of a polynomial
//! everywhere. A polynomial lies within its Bernstein coefficients, which is what proofs about
//! whole pieces rest on.

use nalgebra::DMatrix;

use crate::design::Axis;
use flankfit_geometry::{BSplineBasis, Mapping, bernstein};
use flankfit_numerics::{Dd, Real};

/// Degree of a polynomial on a piece of its own, about: of more its coefficients outgrow it.
const DEGREE_OF_PIECE: usize = 4;

/// A derivative of the functions of an axis over a range.
pub(super) struct Pieces {
    pub pieces: Vec<Piece>,
}

/// One piece.
pub(super) struct Piece {
    pub range: [f64; 2],
    /// Index of the function of the first column.
    pub first: usize,
    /// Bernstein coefficients of the derivative of each function that is not 0 here.
    pub change: DMatrix<Dd>,
}

impl Pieces {
    /// The derivatives of order `order` of the functions of `axis` over [low, high].
    pub(super) fn new(axis: &Axis, [low, high]: [f64; 2], order: usize) -> Self {
        let between = |breaks: Vec<f64>, piece: &dyn Fn([f64; 2]) -> Piece| Pieces {
            pieces: breaks.windows(2).map(|ends| piece([ends[0], ends[1]])).collect(),
        };
        match axis {
            // the axis that a curve has not got, or a single place
            _ if low >= high => Pieces { pieces: vec![Piece::of_place(axis, low)] },
            Axis::Polynomial { mapping, size, .. } => {
                let count = (size - 1).div_ceil(DEGREE_OF_PIECE).max(1);
                let share = |k: usize| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / count as f64).cos();
                let at = |k: usize| match k {
                    0 => low,
                    k if k == count => high,
                    k => low * (1.0 - share(k)) + high * share(k),
                };
                between((0..=count).map(at).collect(), &|range| Piece::of_polynomials(*mapping, *size, range, order))
            }
            Axis::Spline(basis) => {
                let inner = basis.distinct_knots().into_iter().filter(|knot| low < *knot && *knot < high);
                let breaks = std::iter::once(low).chain(inner).chain([high]).collect();
                between(breaks, &|range| Piece::of_splines(basis, range, order))
            }
        }
    }

    /// The piece that a place lies on, and where on it, from 0 to 1.
    #[cfg(test)]
    pub(super) fn at(&self, x: f64) -> (&Piece, f64) {
        let found = self.pieces.iter().find(|piece| x <= piece.range[1]).unwrap_or(&self.pieces[self.pieces.len() - 1]);
        let [low, high] = found.range;
        (found, if high > low { (x - low) / (high - low) } else { 0.0 })
    }
}

impl Piece {
    fn of_place(axis: &Axis, at: f64) -> Self {
        let mut row = vec![Dd::ZERO; axis.size()];
        axis.row(at, &mut row);
        Piece { range: [at, at], first: 0, change: DMatrix::from_row_slice(1, row.len(), &row) }
    }

    fn of_polynomials(mapping: Mapping, size: usize, range: [f64; 2], order: usize) -> Self {
        let width = Dd::diff(range[1], range[0]);
        let mut change = bernstein::of_chebyshev(mapping, range, size - 1);
        for _ in 0..order.min(size - 1) {
            let degree = change.nrows() - 1;
            let slope = |i: usize, j: usize| (change[(i + 1, j)] - change[(i, j)]).mul_f64(degree as f64) / width;
            change = DMatrix::from_fn(degree, size, slope);
        }
        Piece { range, first: 0, change }
    }

    /// Builds the pieces from Taylor's coefficients at the left end: Bernstein coefficient i of a
    /// polynomial of degree d is `Σₖ C(i, k) (d − k)!/d! hᵏ f⁽ᵏ⁾`, k up to i.
    fn of_splines(basis: &BSplineBasis, range: [f64; 2], order: usize) -> Self {
        let p = basis.degree();
        let degree = p - order.min(p);
        let width = Dd::diff(range[1], range[0]);
        let mut taylor = DMatrix::from_element(degree + 1, p + 1, Dd::ZERO);
        let mut first = 0;
        let mut factor = Dd::ONE;
        for k in 0..=degree {
            let mut row = vec![Dd::ZERO; p + 1];
            first = basis.derivatives_of(order + k, range[0], &mut row);
            if k > 0 {
                factor = factor * width / (degree + 1 - k) as f64;
            }
            row.iter().enumerate().for_each(|(j, value)| taylor[(k, j)] = *value * factor);
        }
        let change = DMatrix::from_fn(degree + 1, p + 1, |i, j| {
            let mut binomial = 1.0;
            (0..=i).fold(Dd::ZERO, |sum, k| {
                let term = taylor[(k, j)].mul_f64(binomial);
                binomial = binomial * (i - k) as f64 / (k + 1) as f64;
                sum + term
            })
        });
        Piece { range, first, change }
    }

    /// The derivative of each function at `share` of the way through the piece.
    pub(super) fn row(&self, share: f64) -> Vec<Dd> {
        let weights = bernstein_values(self.change.nrows() - 1, share);
        let column = |j: usize| weights.iter().enumerate().fold(Dd::ZERO, |sum, (i, w)| sum + self.change[(i, j)] * *w);
        (0..self.change.ncols()).map(column).collect()
    }

    /// The place at `share` of the way through.
    pub(super) fn place(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        if share >= 1.0 { high } else { low + share * (high - low) }
    }
}

/// Bernstein's polynomials of a degree at t.
pub(super) fn bernstein_values(degree: usize, t: f64) -> Vec<f64> {
    let mut values = vec![1.0];
    for d in 1..=degree {
        values.push(0.0);
        for i in (0..=d).rev() {
            let left = if i < d { (1.0 - t) * values[i] } else { 0.0 };
            values[i] = left + if i > 0 { t * values[i - 1] } else { 0.0 };
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_geometry::polynomial::{Family, chebyshev_derivatives};

    #[test]
    fn polynomials_have_their_derivatives() {
        let mapping = Mapping::over(30.0, 34.0);
        let axis = Axis::Polynomial { family: Family::Monomial, mapping, size: 10 };
        for order in 0..=2 {
            let found = Pieces::new(&axis, [30.5, 33.25], order);
            assert_eq!(found.pieces.len(), 3);
            for x in [30.5, 31.0, 32.2, 33.25] {
                let (piece, share) = found.at(x);
                let mut expected = vec![0.0; 10];
                chebyshev_derivatives(order, mapping.map::<f64>(x), &mut expected);
                for (found, expected) in piece.row(share).iter().zip(expected) {
                    let expected = expected * mapping.scale.powi(order as i32);
                    assert!((found.to_f64() - expected).abs() < 1e-11 * expected.abs().max(1.0), "{order} {x}");
                }
            }
        }
    }

    #[test]
    fn splines_have_their_derivatives() {
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.5, 4.0, 4.0, 4.0, 4.0];
        let basis = BSplineBasis::new(3, knots).unwrap();
        let axis = Axis::Spline(basis.clone());
        for order in 0..=2 {
            let found = Pieces::new(&axis, [0.25, 4.0], order);
            assert_eq!(found.pieces.iter().map(|piece| piece.range[0]).collect::<Vec<_>>(), [0.25, 1.0, 2.5]);
            for x in [0.25, 0.7, 1.7, 2.4, 3.9, 4.0] {
                let (piece, share) = found.at(x);
                let mut expected = vec![0.0; 4];
                assert_eq!(basis.derivatives_of(order, x, &mut expected), piece.first);
                for (found, expected) in piece.row(share).iter().zip(expected) {
                    assert!((found.to_f64() - expected).abs() < 1e-13, "{order} {x}");
                }
            }
        }
    }
}
