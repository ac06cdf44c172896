//! The same B-spline surface over other knots: insertion, a part of the domain, higher degree.
//!
//! Every line of control points along an axis is a curve, changed by polar forms in double-double
//! and rounded once; rational surfaces in homogeneous coordinates.

use super::{BSplineSurface, Surface, check};
use crate::{
    BSplineBasis,
    polar::{change_knots, raise_degree},
    space::{HIGHEST_DEGREE, Vector},
};
use flankfit_numerics::{Dd, cancel, check::Faults};

/// (w x, w y, w z, w).
type Homogeneous = [Dd; 4];

impl BSplineSurface {
    /// Inserts knots along an axis (0 for u), in any order, each as often as it is listed; the
    /// surface stays. Refused outside of the domain and where a knot would stand more than degree +
    /// 1 times.
    pub fn refine(&self, axis: usize, inserted: &[f64]) -> Result<Self, Faults> {
        let (low, high) = self.bases()[axis].domain();
        if let Some((index, &value)) = inserted.iter().enumerate().find(|(_, x)| !(low <= **x && **x <= high)) {
            return Err(check::out_of_domain(axis, index, value, [low, high]));
        }
        let mut knots = [self.bases()[axis].knots(), inserted].concat();
        knots.sort_by(f64::total_cmp);
        self.over(axis, knots)
    }

    /// The part between `low` and `high` along an axis, clamped there.
    pub fn restrict(&self, axis: usize, low: f64, high: f64) -> Result<Self, Faults> {
        let basis = &self.bases()[axis];
        let (first, last) = basis.domain();
        for (index, value) in [low, high].into_iter().enumerate() {
            if !(first <= value && value <= last) {
                return Err(check::out_of_domain(axis, index, value, [first, last]));
            }
        }
        let end = |value| std::iter::repeat_n(value, basis.degree() + 1);
        let inner = basis.knots().iter().copied().filter(|k| low < *k && *k < high);
        self.over(axis, end(low).chain(inner).chain(end(high)).collect())
    }

    /// The same surface of a degree higher by `times` along an axis, clamped there. Refused above
    /// [`HIGHEST_DEGREE`].
    pub fn elevate(&self, axis: usize, times: usize) -> Result<Self, Faults> {
        let (low, high) = self.bases()[axis].domain();
        let mut surface = self.restrict(axis, low, high)?;
        let target = self.bases()[axis].degree().saturating_add(times);
        if target > HIGHEST_DEGREE {
            return Err(check::degree(axis, target, HIGHEST_DEGREE));
        }
        while surface.bases()[axis].degree() < target {
            let basis = &surface.bases()[axis];
            let mut knots = [basis.knots(), &basis.distinct_knots()].concat();
            knots.sort_by(f64::total_cmp);
            let raised = BSplineBasis::new(basis.degree() + 1, knots).map_err(check::knots(axis))?;
            surface = surface.along(axis, raised, raise_degree)?;
        }
        Ok(surface)
    }

    fn over(&self, axis: usize, knots: Vec<f64>) -> Result<Self, Faults> {
        let basis = BSplineBasis::new(self.bases()[axis].degree(), knots);
        self.along(axis, basis.map_err(check::knots(axis))?, change_knots)
    }

    /// Every line of control points along `axis` changed from its basis to another one.
    fn along(
        &self,
        axis: usize,
        basis: BSplineBasis,
        change: fn(&BSplineBasis, &[Homogeneous], &BSplineBasis) -> Vec<Homogeneous>,
    ) -> Result<Self, Faults> {
        let [rows, columns] = self.bases().each_ref().map(BSplineBasis::size);
        let lines = if axis == 0 { columns } else { rows };
        let number = |line: usize, k: usize| if axis == 0 { k * columns + line } else { line * columns + k };
        let mut bases = self.bases().clone();
        let old = std::mem::replace(&mut bases[axis], basis);
        let [new_rows, new_columns] = bases.each_ref().map(BSplineBasis::size);
        let mut points = vec![Vector::zeros(); new_rows * new_columns];
        let mut weights = self.weights().map(|_| vec![0.0; points.len()]);
        for line in 0..lines {
            cancel::checkpoint();
            let lift = |k: usize| {
                let (p, w) =
                    (self.control_points()[number(line, k)], self.weights().map_or(1.0, |w| w[number(line, k)]));
                [Dd::product(p.x, w), Dd::product(p.y, w), Dd::product(p.z, w), Dd::from(w)]
            };
            let controls: Vec<Homogeneous> = (0..old.size()).map(lift).collect();
            for (k, [x, y, z, w]) in change(&old, &controls, &bases[axis]).into_iter().enumerate() {
                let at = if axis == 0 { k * new_columns + line } else { line * new_columns + k };
                // a point of weight 0 draws nothing and is put at the origin
                let coordinate = |x: Dd| if w.hi == 0.0 { 0.0 } else { (x / w).to_f64() };
                points[at] = Vector::new(coordinate(x), coordinate(y), coordinate(z));
                if let Some(weights) = &mut weights {
                    weights[at] = w.to_f64();
                }
            }
        }
        BSplineSurface::new(bases, self.dimension(), points, weights).map_err(|_| check::not_representable(0))
    }
}
