//! Default placement of knots.
//!
//! Every vector here is clamped: its ends are the first and the last parameter, each degree + 1
//! times. Parameters are finite and ascend strictly. Source: Piegl and Tiller, The NURBS Book,
//! section 9.2.1 and 9.4.1; de Boor for not-a-knot.

use super::check;
use crate::space::HIGHEST_DEGREE;
use flankfit_numerics::check::Faults;

/// Knots for interpolation by averaging (Eq. 9.8): each inner knot is the mean of `degree`
/// neighbouring parameters, so that the condition of Schoenberg and Whitney holds. As many basis
/// functions as parameters.
///
/// ```
/// use flankfit_geometry::curve::knots::averaging;
///
/// // Five parameters, degree 3: one inner knot, the mean of 1, 2 and 3.
/// let knots = averaging(3, &[0.0, 1.0, 2.0, 3.0, 4.0])?;
/// assert_eq!(knots, [0.0, 0.0, 0.0, 0.0, 2.0, 4.0, 4.0, 4.0, 4.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn averaging(degree: usize, parameters: &[f64]) -> Result<Vec<f64>, Faults> {
    check(degree, parameters, 0)?;
    let inner = (1..parameters.len() - degree).map(|j| mean(&parameters[j..j + degree]));
    Ok(clamped(degree, parameters, inner))
}

/// Knots for least squares with `controls` basis functions (Eqs. 9.68 and 9.69): every span holds
/// about as many parameters, at least one, so that the normal equations are positive definite.
/// `degree < controls ≤` number of parameters.
pub fn averaging_least_squares(degree: usize, parameters: &[f64], controls: usize) -> Result<Vec<f64>, Faults> {
    check(degree, parameters, controls)?;
    check::at_least("control_points", controls, degree + 1)?;
    let share = parameters.len() as f64 / (controls - degree) as f64;
    let inner = (1..controls - degree).map(|j| {
        let place = j as f64 * share;
        let (i, part) = (place.floor() as usize, place.fract());
        (1.0 - part) * parameters[i - 1] + part * parameters[i]
    });
    Ok(clamped(degree, parameters, inner))
}

/// Knots at the parameters themselves but for those next to the ends: for degree 3 the not-a-knot
/// spline. An even degree has its knots midway between parameters.
pub fn not_a_knot(degree: usize, parameters: &[f64]) -> Result<Vec<f64>, Faults> {
    check(degree, parameters, 0)?;
    let n = parameters.len();
    let inner: Vec<f64> = if degree % 2 == 1 {
        let skipped = degree.div_ceil(2);
        parameters[skipped..n - skipped].to_vec()
    } else {
        let skipped = degree / 2;
        (skipped..n - 1 - skipped).map(|i| mean(&parameters[i..i + 2])).collect()
    };
    Ok(clamped(degree, parameters, inner.into_iter()))
}

/// A mean that does not overflow.
fn mean(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let sum: f64 = values.iter().sum();
    let mean = if sum.is_finite() { sum / n } else { values.iter().map(|v| v / n).sum() };
    mean.clamp(values[0], values[values.len() - 1])
}

fn clamped(degree: usize, parameters: &[f64], inner: impl Iterator<Item = f64>) -> Vec<f64> {
    let end = |value| std::iter::repeat_n(value, degree + 1);
    end(parameters[0]).chain(inner).chain(end(parameters[parameters.len() - 1])).collect()
}

/// Refuses degrees that there are not, and fewer parameters than `least` or than the degree asks
/// for.
fn check(degree: usize, parameters: &[f64], least: usize) -> Result<(), Faults> {
    check::degree("method.degree", degree, 1, HIGHEST_DEGREE)?;
    check::nodes_of_degree("method.degree", degree, parameters.len(), least.max(degree + 1))?;
    check::ascending("nodes", parameters)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The NURBS Book, example 9.1: ū = 0, 5/17, 9/17, 14/17, 1 and degree 3 give the inner knot
    /// 28/51.
    #[test]
    fn averages_of_the_book() {
        let parameters = [0.0, 5.0 / 17.0, 9.0 / 17.0, 14.0 / 17.0, 1.0];
        let knots = averaging(3, &parameters).unwrap();
        assert_eq!(knots.len(), 9);
        assert!((knots[4] - 28.0 / 51.0).abs() < 1e-15);
    }

    #[test]
    fn least_squares_knots_follow_the_density() {
        let parameters: Vec<f64> = (0..=8).map(|i| f64::from(i) / 8.0).collect();
        // d = 9/3 = 3, so that α is 0: ū₂ and ū₅
        assert_eq!(averaging_least_squares(2, &parameters, 5).unwrap(), [0., 0., 0., 0.25, 0.625, 1., 1., 1.]);
        assert_eq!(averaging_least_squares(3, &parameters, 4).unwrap(), [0., 0., 0., 0., 1., 1., 1., 1.]);
        assert!(averaging_least_squares(3, &parameters, 10).is_err());
        assert!(averaging_least_squares(3, &parameters, 3).is_err());
    }

    #[test]
    fn not_a_knot_of_odd_and_even_degree() {
        let x = [0.0, 1.0, 3.0, 4.0, 6.0];
        assert_eq!(not_a_knot(3, &x).unwrap(), [0., 0., 0., 0., 3., 6., 6., 6., 6.]);
        assert_eq!(not_a_knot(1, &x).unwrap(), [0., 0., 1., 3., 4., 6., 6.]);
        assert_eq!(not_a_knot(2, &x).unwrap(), [0., 0., 0., 2., 3.5, 6., 6., 6.]);
    }

    #[test]
    fn refused_parameters() {
        assert_eq!(averaging(3, &[0.0, 1.0, 1.0, 2.0]).unwrap_err().list()[0].path, "nodes[2]");
        let message = |refused: Result<Vec<f64>, Faults>| refused.unwrap_err().to_string();
        for degree in [0, 26, usize::MAX] {
            assert!(message(averaging(degree, &[0.0, 1.0])).contains("is not within 1 to"));
            assert!(message(not_a_knot(degree, &[0.0, 1.0])).contains("is not within 1 to"));
            assert!(message(averaging_least_squares(degree, &[0.0, 1.0], 2)).contains("is not within 1 to"));
        }
        assert!(message(averaging(3, &[0.0, 1.0, 2.0])).contains("degree 3 needs at least 4 nodes"));
    }
}
