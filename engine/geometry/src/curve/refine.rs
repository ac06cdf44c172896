//! The same B-spline curve over other knots: refinement, parts, Bézier pieces, higher degree.
//!
//! Everything is done in double-double and rounded once, so that the curve moves by rounding alone.
//! Rational curves are changed in homogeneous coordinates.

use super::BSplineCurve;
use super::check;
use crate::{
    BSplineBasis,
    polar::{change_knots, raise_degree},
    space::{Dimension, HIGHEST_DEGREE, Vector},
};
use flankfit_numerics::{Dd, cancel, check::Faults};

/// One polynomial or rational piece in the basis of Bernstein.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPiece {
    /// The range of the parameter.
    pub interval: [f64; 2],
    /// Degree + 1 control points.
    pub control_points: Vec<Vector>,
    /// As many weights; all 1 for a polynomial piece.
    pub weights: Vec<f64>,
}

/// (w x, w y, w z, w).
type Homogeneous = [Dd; 4];

impl BSplineCurve {
    fn homogeneous(&self) -> Vec<Homogeneous> {
        let weight = |i: usize| self.weights().map_or(1.0, |w| w[i]);
        let lift = |(i, p): (usize, &Vector)| {
            let w = weight(i);
            [Dd::product(p.x, w), Dd::product(p.y, w), Dd::product(p.z, w), Dd::from(w)]
        };
        self.control_points().iter().enumerate().map(lift).collect()
    }

    /// The curve of homogeneous control points.
    fn of_homogeneous(&self, basis: BSplineBasis, controls: &[Homogeneous]) -> Result<Self, Faults> {
        let (points, weights) = project(controls);
        let weights = self.weights().map(|_| weights);
        BSplineCurve::new(basis, self.dimension_of(), points, weights)
    }

    fn dimension_of(&self) -> Dimension {
        super::Curve::dimension(self)
    }

    fn over(&self, knots: Vec<f64>) -> Result<Self, Faults> {
        let basis = BSplineBasis::new(self.basis().degree(), knots)?;
        let controls = change_knots(self.basis(), &self.homogeneous(), &basis);
        self.of_homogeneous(basis, &controls)
    }

    /// Inserts several knots, in any order, each as often as it is listed.
    pub fn refine(&self, inserted: &[f64]) -> Result<Self, Faults> {
        let (low, high) = self.basis().domain();
        if let Some(&value) = inserted.iter().find(|x| !(low <= **x && **x <= high)) {
            return Err(check::out_of_domain(value, low, high));
        }
        let mut knots = [self.basis().knots(), inserted].concat();
        knots.sort_by(f64::total_cmp);
        self.over(knots)
    }

    /// The same curve with its end knots standing degree + 1 times, so that it starts and ends at
    /// control points.
    pub fn clamp(&self) -> Result<Self, Faults> {
        let [low, high] = <[f64; 2]>::from(self.basis().domain());
        self.restrict(low, high)
    }

    /// The part of the curve over `[low, high]` within the domain, clamped.
    pub fn restrict(&self, low: f64, high: f64) -> Result<Self, Faults> {
        let (first, last) = self.basis().domain();
        for value in [low, high] {
            if !(first <= value && value <= last) {
                return Err(check::out_of_domain(value, first, last));
            }
        }
        let end = |value| std::iter::repeat_n(value, self.basis().degree() + 1);
        let inner = self.basis().knots().iter().copied().filter(|k| low < *k && *k < high);
        self.over(end(low).chain(inner).chain(end(high)).collect())
    }

    /// The same curve of a degree higher by `times`; the end knots become clamped. Refused above
    /// [`HIGHEST_DEGREE`].
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     BSplineBasis,
    ///     curve::BSplineCurve,
    ///     space::{Dimension, Vector},
    /// };
    ///
    /// // A line from 0 to 2 as a parabola has its middle control point half-way.
    /// let height = |y: &f64| Vector::new(*y, 0.0, 0.0);
    /// let heights = |all: &[f64]| all.iter().map(height).collect::<Vec<_>>();
    /// let basis = BSplineBasis::uniform(1, 1, 0.0, 1.0)?;
    /// let line = BSplineCurve::new(basis, Dimension::Graph, heights(&[0.0, 2.0]), None)?;
    /// assert_eq!(line.elevate(1)?.control_points(), heights(&[0.0, 1.0, 2.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn elevate(&self, times: usize) -> Result<Self, Faults> {
        let degree = self.basis().degree();
        let target = degree.saturating_add(times);
        check::degree("degree", target, degree, HIGHEST_DEGREE)?;
        let clamped = self.clamp()?;
        let (mut basis, mut controls) = (clamped.basis().clone(), clamped.homogeneous());
        for degree in degree + 1..=target {
            let mut knots = [basis.knots(), &basis.distinct_knots()].concat();
            knots.sort_by(f64::total_cmp);
            let raised = BSplineBasis::new(degree, knots)?;
            controls = raise_degree(&basis, &controls, &raised);
            basis = raised;
        }
        self.of_homogeneous(basis, &controls)
    }

    /// The Bézier pieces between the distinct knots of the domain.
    pub fn bezier_pieces(&self) -> Result<Vec<BezierPiece>, Faults> {
        let p = self.basis().degree();
        let breaks = self.basis().distinct_knots();
        let controls = self.homogeneous();
        let piece = |pair: &[f64]| {
            cancel::checkpoint();
            let knots = std::iter::repeat_n(pair[0], p + 1).chain(std::iter::repeat_n(pair[1], p + 1)).collect();
            let alone = change_knots(self.basis(), &controls, &BSplineBasis::new(p, knots)?);
            let (control_points, weights) = project(&alone);
            if let Some(index) = control_points.iter().position(|c| !c.iter().all(|x| x.is_finite())) {
                return Err(check::not_finite("control_points", index));
            }
            Ok(BezierPiece { interval: [pair[0], pair[1]], control_points, weights })
        };
        breaks.windows(2).map(piece).collect()
    }
}

/// Points and weights; a point of weight 0, which draws nothing, is put at the origin.
fn project(controls: &[Homogeneous]) -> (Vec<Vector>, Vec<f64>) {
    let point = |c: &Homogeneous| {
        let w = c[3];
        let [x, y, z] = [c[0], c[1], c[2]].map(|x| if w.hi == 0.0 { 0.0 } else { (x / w).to_f64() });
        Vector::new(x, y, z)
    };
    controls.iter().map(|c| (point(c), c[3].to_f64())).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;

    /// The whole unit circle with a seam, as one rational quadratic of nine control points.
    fn circle() -> BSplineCurve {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.]).unwrap();
        let corners = [[1., 0.], [1., 1.], [0., 1.], [-1., 1.], [-1., 0.], [-1., -1.], [0., -1.], [1., -1.], [1., 0.]];
        let points = corners.map(|[x, y]| Vector::new(x, y, 0.0)).to_vec();
        let weights = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { 0.5f64.sqrt() }).collect();
        BSplineCurve::new(basis, Dimension::Plane, points, Some(weights)).unwrap()
    }

    fn assert_same(one: &BSplineCurve, other: &BSplineCurve, low: f64, high: f64) {
        for k in 0..=40 {
            let t = low + (high - low) * f64::from(k) / 40.0;
            assert!((one.value(t) - other.value(t)).amax() < 2e-15, "{t}");
        }
    }

    #[test]
    fn a_circle_stays_a_circle() {
        let circle = circle();
        assert_same(&circle, &circle.refine(&[0.3, 0.3]).unwrap(), 0.0, 4.0);
        assert_same(&circle, &circle.refine(&[3.5, 0.1, 2.5, 2.5]).unwrap(), 0.0, 4.0);
        let cubic = circle.elevate(1).unwrap();
        assert_eq!((cubic.basis().degree(), cubic.control_points().len()), (3, 13));
        assert_same(&circle, &cubic, 0.0, 4.0);
        assert_same(&circle, &circle.elevate(4).unwrap(), 0.0, 4.0);
        let [left, right] = [[0.0, 1.25], [1.25, 4.0]].map(|[low, high]| circle.restrict(low, high).unwrap());
        assert_same(&circle, &left, 0.0, 1.25);
        assert_same(&circle, &right, 1.25, 4.0);
        let pieces = circle.bezier_pieces().unwrap();
        assert_eq!(pieces.len(), 4);
        assert_eq!(pieces[2].control_points[1], Vector::new(-1.0, -1.0, 0.0));
    }

    #[test]
    fn an_unclamped_curve_is_clamped() {
        let basis = BSplineBasis::new(3, (0..9).map(f64::from).collect()).unwrap();
        let points = [1.0, -2.0, 0.5, 4.0, 3.0].map(|y| Vector::new(y, 0.0, 0.0)).to_vec();
        let curve = BSplineCurve::new(basis, Dimension::Graph, points, None).unwrap();
        let clamped = curve.clamp().unwrap();
        assert_eq!(clamped.basis().knots(), [3., 3., 3., 3., 4., 5., 5., 5., 5.]);
        assert_same(&curve, &clamped, 3.0, 5.0);
        assert_eq!(clamped.control_points()[0], curve.value(3.0));
        assert_same(&curve, &curve.elevate(2).unwrap(), 3.0, 5.0);
        assert_same(&curve, &curve.refine(&[4.5]).unwrap(), 3.0, 5.0);
    }

    #[test]
    fn invalid_input_is_refused() {
        let circle = circle();
        let message = |refused: Result<BSplineCurve, Faults>| refused.unwrap_err().to_string();
        assert!(message(circle.refine(&[4.5])).contains("not within the domain"));
        assert!(message(circle.refine(&[f64::NAN])).contains("not within the domain"));
        assert!(message(circle.refine(&[1.0, 1.0])).contains("more than degree + 1"));
        assert!(message(circle.elevate(24)).contains("degree 26 is not within 2"));
        assert!(circle.restrict(0.0, 0.0).is_err());
    }
}
