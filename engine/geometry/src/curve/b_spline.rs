//! B-spline curves and their rational form, NURBS (Eqs. 6 and 9 of the paper).
//!
//! One type for both: a NURBS is a B-spline of (w a, w) divided by its last coordinate. Without
//! weights nothing is divided.

use super::{Curve, CurveJet};
use crate::{
    BSplineBasis,
    space::{Dimension, HIGHEST_DEGREE, Vector, check_controls, degree_too_high, no_weight},
};
use flankfit_numerics::check::Faults;

/// `f(t) = Σ wᵢ aᵢ Nᵢ(t) / Σ wⱼ Nⱼ(t)`, or `Σ aᵢ Nᵢ(t)` without weights.
#[derive(Clone, Debug, PartialEq)]
pub struct BSplineCurve {
    basis: BSplineBasis,
    dimension: Dimension,
    control_points: Vec<Vector>,
    weights: Option<Vec<f64>>,
}

impl BSplineCurve {
    /// Checks that points and weights match the basis; weights are ≥ 0, and somewhere above 0 on
    /// every span.
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     BSplineBasis,
    ///     curve::{BSplineCurve, Curve},
    ///     space::{Dimension, Vector},
    /// };
    ///
    /// // A quarter of the unit circle: degree 2, the middle weight cos 45°.
    /// let corner = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vector::new(x, y, 0.0));
    /// let weights = vec![1.0, 0.5_f64.sqrt(), 1.0];
    /// let basis = BSplineBasis::uniform(2, 1, 0.0, 1.0)?;
    /// let quarter = BSplineCurve::new(basis, Dimension::Plane, corner.into(), Some(weights))?;
    /// assert!((quarter.value(0.3).norm() - 1.0).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        basis: BSplineBasis,
        dimension: Dimension,
        control_points: Vec<Vector>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, Faults> {
        if basis.degree() > HIGHEST_DEGREE {
            return Err(degree_too_high("degree", basis.degree()));
        }
        check_controls(&control_points, weights.as_deref(), basis.size(), |index| format!("[{index}]"))?;
        if let Some(weights) = &weights {
            weighted_everywhere(&basis, weights)?;
        }
        Ok(BSplineCurve { basis, dimension, control_points, weights })
    }

    /// Knots and degree.
    pub fn basis(&self) -> &BSplineBasis {
        &self.basis
    }

    /// The control polygon.
    pub fn control_points(&self) -> &[Vector] {
        &self.control_points
    }

    /// One weight per control point, for a rational curve.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }
}

/// Refuses weights that vanish together at a place where the basis has no other function: the
/// denominator would be 0.
fn weighted_everywhere(basis: &BSplineBasis, weights: &[f64]) -> Result<(), Faults> {
    let mut values = vec![0.0; basis.degree() + 1];
    // fewest functions are above 0 at the ends of spans
    for place in basis.distinct_knots() {
        let first = basis.values(place, &mut values);
        let sum: f64 = values.iter().zip(&weights[first..]).map(|(n, w)| n * w).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(no_weight(place));
        }
    }
    Ok(())
}

impl Curve for BSplineCurve {
    fn dimension(&self) -> Dimension {
        self.dimension
    }

    fn domain(&self) -> [f64; 2] {
        self.basis.domain().into()
    }

    fn jet(&self, t: f64) -> CurveJet {
        let mut numerator = [Vector::zeros(); 4];
        let mut denominator = [0.0; 4];
        let mut values = [0.0; HIGHEST_DEGREE + 1];
        let values = &mut values[..=self.basis.degree()];
        for order in 0..4 {
            let first = self.basis.derivatives_of(order, t, values);
            for (i, n) in values.iter().enumerate() {
                let weighted = self.weights.as_ref().map_or(*n, |w| w[first + i] * n);
                numerator[order] += self.control_points[first + i] * weighted;
                denominator[order] += weighted;
            }
        }
        if self.weights.is_none() { numerator } else { quotient(&numerator, &denominator) }
    }

    fn breaks(&self) -> Vec<f64> {
        self.basis.distinct_knots()
    }

    fn value(&self, t: f64) -> Vector {
        let mut values = [0.0; HIGHEST_DEGREE + 1];
        let values = &mut values[..=self.basis.degree()];
        let first = self.basis.values(t, values);
        let points = values.iter().zip(&self.control_points[first..]);
        let Some(weights) = &self.weights else {
            return points.fold(Vector::zeros(), |sum, (n, p)| sum + p * *n);
        };
        let weighted = points.zip(&weights[first..]);
        let (point, weight) =
            weighted.fold((Vector::zeros(), 0.0), |(sum, total), ((n, p), w)| (sum + p * (w * n), total + w * n));
        point / weight
    }
}

/// Derivatives of P / w by Leibniz' rule: `(P/w)⁽ᵏ⁾ = (P⁽ᵏ⁾ − Σ binomial(k, i) w⁽ⁱ⁾ (P/w)⁽ᵏ⁻ⁱ⁾) /
/// w`.
fn quotient(p: &CurveJet, w: &[f64; 4]) -> CurveJet {
    let mut jet = [Vector::zeros(); 4];
    jet[0] = p[0] / w[0];
    jet[1] = (p[1] - jet[0] * w[1]) / w[0];
    jet[2] = (p[2] - jet[1] * (2.0 * w[1]) - jet[0] * w[2]) / w[0];
    jet[3] = (p[3] - jet[2] * (3.0 * w[1]) - jet[1] * (3.0 * w[2]) - jet[0] * w[3]) / w[0];
    jet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of the unit circle: x² + y² = 1 and derivatives at right angles, to rounding.
    #[test]
    fn a_quarter_of_a_circle() {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 1.]).unwrap();
        let points = [[1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| Vector::new(x, y, 0.0)).to_vec();
        let arc = BSplineCurve::new(basis, Dimension::Plane, points, Some(vec![1.0, 0.5f64.sqrt(), 1.0])).unwrap();
        for k in 0..=16 {
            let [p, d, dd, ddd] = arc.jet(f64::from(k) / 16.0);
            assert!((p.norm() - 1.0).abs() < 4e-16);
            assert!(p.dot(&d).abs() < 1e-15);
            // the second and third derivative of p·p = 1
            assert!((p.dot(&dd) + d.dot(&d)).abs() < 1e-14);
            assert!((p.dot(&ddd) + 3.0 * d.dot(&dd)).abs() < 1e-13);
        }
    }

    #[test]
    fn refused_controls() {
        let basis = BSplineBasis::new(1, vec![0., 0., 1., 2., 2.]).unwrap();
        let points = vec![Vector::zeros(); 3];
        let new =
            |points: &[Vector], weights| BSplineCurve::new(basis.clone(), Dimension::Plane, points.to_vec(), weights);
        let message = |refused: Result<BSplineCurve, Faults>| refused.unwrap_err().to_string();
        assert_eq!(message(new(&points[1..], None)), "control_points: 2 control points; knots and degree need 3");
        let negative = new(&points, Some(vec![1.0, -1.0, 1.0]));
        assert_eq!(message(negative), "weights[1]: weight 1 (-1) is not a finite number ≥ 0");
        assert_eq!(message(new(&points, Some(vec![1.0; 2]))), "weights: 2 weights for 3 control points");
        assert!(
            message(new(&points, Some(vec![1.0, 0.0, 1.0]))).starts_with("weights: the weights around parameter 1 ")
        );
        let bad = [points[0], Vector::new(0.0, f64::NAN, 0.0), points[2]];
        assert_eq!(message(new(&bad, None)), "control_points[1]: control point 1 is not finite");
    }
}
