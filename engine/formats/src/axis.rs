//! Knots and degree along one parameter, on their way into a file.

use flankfit_geometry::BSplineBasis;

/// A knot vector with its degree; valid, since it comes from a checked [`BSplineBasis`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) degree: usize,
    pub(super) knots: Vec<f64>,
}

impl From<&BSplineBasis> for Axis {
    fn from(basis: &BSplineBasis) -> Self {
        Axis { degree: basis.degree(), knots: basis.knots().to_vec() }
    }
}

impl Axis {
    /// Number of control points.
    pub(super) fn size(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    pub(super) fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.size()])
    }

    /// True if the spline begins and ends in its first and last control points.
    pub(super) fn is_clamped(&self) -> bool {
        let (low, high) = self.domain();
        self.knots[0] == low && self.knots[self.knots.len() - 1] == high
    }

    /// The knots within the domain, its ends as often as the order of the spline.
    pub(super) fn clamped(&self) -> Axis {
        self.with_inner(self.degree, 0)
    }

    /// Knots of one degree more for splines that are as smooth as those of this one.
    pub(super) fn raised(&self) -> Axis {
        self.with_inner(self.degree + 1, 1)
    }

    fn with_inner(&self, degree: usize, more: usize) -> Axis {
        let (low, high) = self.domain();
        let inner: Vec<f64> = self.knots.iter().copied().filter(|k| low < *k && *k < high).collect();
        let mut knots = vec![low; degree + 1];
        for run in inner.chunk_by(|a, b| a == b) {
            knots.extend(std::iter::repeat_n(run[0], run.len() + more));
        }
        knots.extend(std::iter::repeat_n(high, degree + 1));
        Axis { degree, knots }
    }

    /// The coordinates that make a spline of the parameter itself: means of `degree` knots
    /// (Greville).
    pub(super) fn greville(&self) -> impl Iterator<Item = f64> {
        let mean = |inner: &[f64]| {
            // about the first knot, so that equal knots come back as they are
            let offsets: f64 = inner.iter().map(|k| k - inner[0]).sum();
            inner[0] + offsets / inner.len() as f64
        };
        self.knots[1..self.knots.len() - 1].windows(self.degree).map(mean)
    }

    /// Each knot once, and its multiplicity.
    pub(super) fn multiplicities(&self) -> (Vec<f64>, Vec<usize>) {
        self.knots.chunk_by(|a, b| a == b).map(|run| (run[0], run.len())).unzip()
    }

    /// First indices of inner knots of multiplicity degree + 1: the spline may jump there.
    pub(super) fn jumps(&self) -> Vec<usize> {
        let p = self.degree;
        (p + 1..self.size()).filter(|&i| self.knots[i] == self.knots[i + p]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_as_multiplicities_greville_points_and_clamped() {
        let axis = Axis { degree: 2, knots: vec![0., 0., 0., 1., 1., 1., 2.5, 3., 3., 3.] };
        assert!(axis.is_clamped() && axis.clamped() == axis);
        assert_eq!(axis.multiplicities(), (vec![0., 1., 2.5, 3.], vec![3, 3, 1, 3]));
        assert_eq!(axis.greville().collect::<Vec<_>>(), [0.0, 0.5, 1.0, 1.0, 1.75, 2.75, 3.0][..]);
        assert_eq!(axis.jumps(), [3]);
        let loose = Axis { degree: 1, knots: vec![0., 1., 2., 3.] };
        assert!(!loose.is_clamped() && loose.jumps().is_empty());
        assert_eq!(loose.clamped().knots, [1., 1., 2., 2.]);
    }
}
