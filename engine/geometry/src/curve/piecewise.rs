//! Curves of polynomial pieces between breaks, each written in powers of the distance from its left
//! break.

use super::{Curve, CurveJet, check};
use crate::space::{Dimension, HIGHEST_DEGREE, Vector};
use flankfit_numerics::check::Faults;

/// `f(t) = Σ cₖ (t − bᵢ)ᵏ` for `bᵢ ≤ t < bᵢ₊₁`; the last piece is closed on the right.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewisePolynomial {
    dimension: Dimension,
    breaks: Vec<f64>,
    degree: usize,
    /// Piece by piece, degree + 1 coefficients each, from the lowest power.
    coefficients: Vec<Vector>,
}

impl PiecewisePolynomial {
    /// Checks that the breaks ascend and that there are degree + 1 finite coefficients for every
    /// piece between them.
    pub fn new(
        dimension: Dimension,
        breaks: Vec<f64>,
        degree: usize,
        coefficients: Vec<Vector>,
    ) -> Result<Self, Faults> {
        check::degree("method.degree", degree, 0, HIGHEST_DEGREE)?;
        check::at_least("breaks", breaks.len(), 2)?;
        check::ascending("breaks", &breaks)?;
        let wanted = (breaks.len() - 1) * (degree + 1);
        check::count("coefficients", coefficients.len(), wanted)?;
        match coefficients.iter().position(|c| !c.iter().all(|x| x.is_finite())) {
            Some(index) => Err(check::not_representable(index)),
            None => Ok(PiecewisePolynomial { dimension, breaks, degree, coefficients }),
        }
    }

    /// The degree of the pieces.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The coefficients of piece `i`, from the lowest power.
    pub fn piece(&self, i: usize) -> &[Vector] {
        &self.coefficients[i * (self.degree + 1)..(i + 1) * (self.degree + 1)]
    }

    /// Coefficients of all pieces, one after the other.
    pub fn coefficients(&self) -> &[Vector] {
        &self.coefficients
    }

    /// Places at which pieces begin and end, both ends included.
    pub fn places(&self) -> &[f64] {
        &self.breaks
    }

    /// The coefficients that count at `t`, and the distance of `t` from their break.
    fn at(&self, t: f64) -> (&[Vector], f64) {
        let pieces = self.breaks.len() - 1;
        let i = self.breaks[1..pieces].partition_point(|b| *b <= t);
        (self.piece(i), t - self.breaks[i])
    }
}

impl Curve for PiecewisePolynomial {
    fn dimension(&self) -> Dimension {
        self.dimension
    }

    fn domain(&self) -> [f64; 2] {
        [self.breaks[0], self.breaks[self.breaks.len() - 1]]
    }

    fn jet(&self, t: f64) -> CurveJet {
        let (coefficients, s) = self.at(t);
        let [mut value, mut first, mut second, mut third] = [Vector::zeros(); 4];
        for c in coefficients.iter().rev() {
            third = third * s + second;
            second = second * s + first;
            first = first * s + value;
            value = value * s + c;
        }
        [value, first, second * 2.0, third * 6.0]
    }

    fn breaks(&self) -> Vec<f64> {
        self.breaks.clone()
    }

    fn value(&self, t: f64) -> Vector {
        let (coefficients, s) = self.at(t);
        coefficients.iter().rev().fold(Vector::zeros(), |value, c| value * s + c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(breaks: &[f64], degree: usize, c: &[f64]) -> Result<PiecewisePolynomial, Faults> {
        let coefficients = c.iter().map(|c| Vector::new(*c, 0.0, 0.0)).collect();
        PiecewisePolynomial::new(Dimension::Graph, breaks.to_vec(), degree, coefficients)
    }

    #[test]
    fn the_right_piece_counts_at_a_break() {
        let curve = curve(&[0.0, 1.0, 3.0], 4, &[1., 0., 0., 0., 1., 5., 1., -2., 3., 0.]).unwrap();
        assert_eq!(curve.jet(0.5).map(|v| v.x), [1.0625, 0.5, 3.0, 12.0]);
        assert_eq!(curve.jet(1.0).map(|v| v.x), [5.0, 1.0, -4.0, 18.0]);
        assert_eq!(curve.value(3.0).x, 5.0 + 2.0 - 8.0 + 24.0);
    }

    #[test]
    fn invalid_input_is_refused() {
        assert_eq!(curve(&[0.0, 1.0, 1.0], 0, &[1.0, 2.0]).unwrap_err().list()[0].path, "breaks[2]");
        let message = |breaks: &[f64], degree, c: &[f64]| curve(breaks, degree, c).unwrap_err().to_string();
        assert!(message(&[0.0, 1.0], 1, &[1.0]).contains("where 2 are needed"));
        assert_eq!(curve(&[0.0, 1.0], 1, &[1.0, f64::NAN]), Err(check::not_representable(1)));
        assert!(message(&[0.0, 1.0], 26, &[0.0; 27]).contains("degree 26 is not within"));
        assert!(message(&[0.0], 0, &[]).contains("too few"));
    }
}
