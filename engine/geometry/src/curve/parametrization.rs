//! Default parameters of the points of a parametric curve.
//!
//! Parameters run from 0 to 1 and ascend. The choice shapes the curve: with uneven distances the
//! uniform one makes loops, the chord length follows long chords too stiffly, the centripetal one
//! (Lee 1989) lies between the two.

use super::check;
use crate::space::Vector;
use flankfit_numerics::{
    cancel::Asking,
    check::Faults,
    dd::{exponent_of, ldexp},
};

/// Parameter of the points, from 0 to 1: uniform, by distance, or by the square root of the
/// distance (least overshoot in sharp bends).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Parametrization {
    /// By the same amount.
    Uniform,
    /// By the distance of the points.
    ChordLength,
    /// By the square root of the distance of the points.
    Centripetal,
}

impl Parametrization {
    /// One parameter per point, from 0 to 1, ascending.
    ///
    /// Refused: fewer than two points, points not finite, a point equal to the one before
    /// it (or so near, in comparison with the whole, that their parameters are one double).
    ///
    /// ```
    /// use flankfit_geometry::{curve::Parametrization, space::Vector};
    ///
    /// // Two chords of length 5 and 15.
    /// let points = [[0.0, 0.0], [3.0, 4.0], [3.0, 19.0]].map(|[x, y]| Vector::new(x, y, 0.0));
    /// let parameters = Parametrization::ChordLength.parameters(&points)?;
    /// assert_eq!(parameters, [0.0, 0.25, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parameters(self, points: &[Vector]) -> Result<Vec<f64>, Faults> {
        check::at_least("", points.len(), 2)?;
        check::points("", points)?;
        self.along(points).map_err(|index| check::repeated("", index, index - 1, points[index].x))
    }

    /// The parameters of two or more finite points; refused with the index of a point equal
    /// to the one before it.
    pub(crate) fn along(self, points: &[Vector]) -> Result<Vec<f64>, usize> {
        let largest = points.iter().fold(0.0f64, |m, p| m.max(p.amax()));
        // a power of two, exact, so that the distance of huge and of tiny points is a double
        let shift = if largest > 0.0 { -exponent_of(largest) } else { 0 };
        let mut sum = 0.0;
        let mut parameters = vec![0.0];
        for (i, pair) in points.windows(2).enumerate().asking(30) {
            let scaled = |p: &Vector| p.map(|x| ldexp(x, shift));
            let chord = (scaled(&pair[1]) - scaled(&pair[0])).norm();
            if !(chord > 0.0) {
                return Err(i + 1);
            }
            sum += match self {
                Parametrization::Uniform => 1.0,
                Parametrization::ChordLength => chord,
                Parametrization::Centripetal => chord.sqrt(),
            };
            parameters.push(sum);
        }
        for t in &mut parameters {
            *t /= sum;
        }
        if let Some(i) = parameters.windows(2).position(|pair| !(pair[0] < pair[1])) {
            return Err(i + 1);
        }
        Ok(parameters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_three_points() {
        let points = [Vector::new(0.0, 0.0, 0.0), Vector::new(0.0, 9.0, 0.0), Vector::new(0.0, 9.0, 1.0)];
        assert_eq!(Parametrization::Uniform.parameters(&points).unwrap(), [0.0, 0.5, 1.0]);
        assert_eq!(Parametrization::ChordLength.parameters(&points).unwrap(), [0.0, 0.9, 1.0]);
        assert_eq!(Parametrization::Centripetal.parameters(&points).unwrap(), [0.0, 0.75, 1.0]);
        let twice = [points[0], points[1], points[1]];
        let fault = Parametrization::Uniform.parameters(&twice).unwrap_err();
        assert_eq!(fault.list()[0].path, "[2]");
        let far = [points[0], points[1] * 1e307, points[1] * 1e307 + points[2] * 1e295];
        assert!(Parametrization::ChordLength.parameters(&far).is_ok());
        let fault = Parametrization::Uniform.parameters(&[points[0], points[1] * f64::NAN]).unwrap_err();
        assert_eq!(fault.list()[0].path, "[1]");
        assert!(Parametrization::Uniform.parameters(&points[..1]).is_err());
    }
}
