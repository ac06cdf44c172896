//! Curves and surfaces at chosen parameters: what facets and elements are made of.

use super::fault::ExportFault;
use crate::geometry::{
    curve::Curve,
    space::Vector,
    surface::{
        Surface,
        differential::{self, Differential},
    },
};

/// More nodes than this are refused for one surface.
pub const MOST_NODES: usize = 4_000_000;

/// Between two neighbouring breaks of a curve there are at most 2 to this power chords.
const MOST_HALVINGS: u32 = 12;

/// A surface at the nodes of a grid of parameters, v running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceSample {
    parameters: [Vec<f64>; 2],
    nodes: Vec<Vector>,
    normals: Vec<Option<Vector>>,
    curvatures: Vec<Option<[f64; 2]>>,
}

impl SurfaceSample {
    /// Places and unit normals at all pairs of `us` and `vs`, each ascending with at least two values.
    pub fn new(surface: &dyn Surface, us: &[f64], vs: &[f64]) -> Result<Self, ExportFault> {
        for values in [us, vs] {
            if values.len() < 2 {
                return Err(ExportFault::FewParameters { given: values.len() });
            }
            if let Some(i) = (1..values.len()).find(|i| !(values[i - 1] < values[*i])) {
                return Err(ExportFault::Descending { index: i, value: values[i], before: values[i - 1] });
            }
        }
        let wanted = us.len().saturating_mul(vs.len());
        if wanted > MOST_NODES {
            return Err(ExportFault::TooManyNodes { wanted, most: MOST_NODES });
        }
        let mut sample = SurfaceSample {
            parameters: [us.to_vec(), vs.to_vec()],
            nodes: Vec::with_capacity(wanted),
            normals: Vec::with_capacity(wanted),
            curvatures: Vec::with_capacity(wanted),
        };
        for (u, v) in us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v))) {
            let differential = Differential::at(surface, u, v);
            let place = differential.map_or_else(|| surface.place(u, v).value, |d| d.point);
            if !place.iter().all(|x| x.is_finite()) {
                return Err(ExportFault::NoPlace { at: [u, v] });
            }
            sample.nodes.push(place);
            let normal = differential.map(|d| d.normal).or_else(|| differential::normal(surface, u, v));
            sample.normals.push(normal.filter(|n| n.iter().all(|x| x.is_finite())));
            let curvature = differential.map(|d| [d.mean, d.gaussian]);
            sample.curvatures.push(curvature.filter(|c| c.iter().all(|x| x.is_finite())));
        }
        Ok(sample)
    }

    /// `intervals` along u and v for every patch between the surface's breaks.
    pub fn by_patches(surface: &dyn Surface, intervals: [usize; 2]) -> Result<Self, ExportFault> {
        let [us, vs] = surface.breaks();
        Self::new(surface, &between(&us, intervals[0]), &between(&vs, intervals[1]))
    }

    /// The values of u and of v.
    pub fn parameters(&self) -> &[Vec<f64>; 2] {
        &self.parameters
    }

    /// How many nodes there are along u and along v.
    pub fn size(&self) -> [usize; 2] {
        self.parameters.each_ref().map(Vec::len)
    }

    pub fn nodes(&self) -> &[Vector] {
        &self.nodes
    }

    /// Unit vectors along ∂S/∂u × ∂S/∂v. Where that vanishes, its limit from inside; `None` where there is none either.
    pub fn normals(&self) -> &[Option<Vector>] {
        &self.normals
    }

    /// Mean (1/mm) and Gaussian curvature (1/mm²), above 0 where the surface bends towards its normal; `None` as with normals.
    pub fn curvatures(&self) -> &[Option<[f64; 2]>] {
        &self.curvatures
    }
}

/// `intervals` equal steps (at least one) from each value to the next; the values given are met exactly.
pub fn between(values: &[f64], intervals: usize) -> Vec<f64> {
    let steps = intervals.max(1);
    let inner = |pair: &[f64], k: usize| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64);
    let mut all: Vec<f64> = values
        .windows(2)
        .flat_map(|pair| (0..steps).map(move |k| if k == 0 { pair[0] } else { inner(pair, k) }))
        .collect();
    all.extend(values.last());
    all
}

/// Parameters at which chords stay within `tolerance` (mm) of the curve, looked at in three places of each chord.
///
/// Breaks are always among them. Where 12 halvings do not suffice the chords are as short as these make them.
pub fn curve_parameters(curve: &dyn Curve, tolerance: f64) -> Result<Vec<f64>, ExportFault> {
    if !(tolerance > 0.0) {
        return Err(ExportFault::Tolerance { tolerance });
    }
    let breaks = curve.breaks();
    let mut all: Vec<f64> = breaks.first().copied().into_iter().collect();
    for pair in breaks.windows(2) {
        // the pieces still to be looked at, the leftmost on top
        let mut waiting = vec![(pair[0], pair[1], 0)];
        while let Some((a, b, depth)) = waiting.pop() {
            let middle = a + (b - a) / 2.0;
            // one halving at least, lest an S look straight
            if depth == 0 || (depth < MOST_HALVINGS && sagitta(curve, a, b) > tolerance) {
                waiting.push((middle, b, depth + 1));
                waiting.push((a, middle, depth + 1));
            } else {
                all.push(b);
            }
        }
        if all.len() > MOST_NODES {
            return Err(ExportFault::TooManyNodes { wanted: all.len(), most: MOST_NODES });
        }
    }
    Ok(all)
}

/// How far the curve over [a, b] strays from its chord.
fn sagitta(curve: &dyn Curve, a: f64, b: f64) -> f64 {
    let [start, end] = [a, b].map(|t| curve.place(t)[0]);
    let chord = end - start;
    let distance = |share: f64| {
        let offset = curve.place(a + (b - a) * share)[0] - start;
        let along =
            if chord.norm_squared() > 0.0 { (offset.dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
        (offset - chord * along).norm()
    };
    [0.25, 0.5, 0.75].map(distance).into_iter().fold(0.0, f64::max)
}

/// Places of a curve.
pub fn curve_nodes(curve: &dyn Curve, parameters: &[f64]) -> Result<Vec<Vector>, ExportFault> {
    let place = |t: &f64| {
        let place = curve.place(*t)[0];
        if place.iter().all(|x| x.is_finite()) { Ok(place) } else { Err(ExportFault::NoPlace { at: [*t, 0.0] }) }
    };
    parameters.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{BSplineBasis, curve::BSplineCurve, space::Dimension, surface::BSplineSurface};

    /// Rulings from the apex (0, 0, 1), at v = 0, to the points (1, 0, 0) and (0, 1, 0).
    fn wedge() -> BSplineSurface {
        let line = || BSplineBasis::new(1, vec![0., 0., 1., 1.]).unwrap();
        let points = [[0., 0., 1.], [1., 0., 0.], [0., 0., 1.], [0., 1., 0.]];
        let points = points.map(|[x, y, z]| Vector::new(x, y, z)).to_vec();
        BSplineSurface::new([line(), line()], Dimension::Space, points, None).unwrap()
    }

    #[test]
    fn normals_also_where_a_side_has_no_length() {
        let sample = SurfaceSample::by_patches(&wedge(), [2, 4]).unwrap();
        assert_eq!(sample.size(), [3, 5]);
        let expected = -Vector::new(1.0, 1.0, 1.0).normalize();
        for normal in sample.normals() {
            assert!((normal.unwrap() - expected).norm() < 1e-15 || (normal.unwrap() + expected).norm() < 1e-15);
            assert_eq!(normal.unwrap().x.signum(), sample.normals()[1].unwrap().x.signum());
        }
    }

    #[test]
    fn refusals_carry_numbers() {
        let surface = wedge();
        assert_eq!(SurfaceSample::new(&surface, &[0.0], &[0.0, 1.0]), Err(ExportFault::FewParameters { given: 1 }));
        assert_eq!(
            SurfaceSample::new(&surface, &[0.0, 1.0], &[0.0, 0.5, 0.5]),
            Err(ExportFault::Descending { index: 2, value: 0.5, before: 0.5 })
        );
        assert_eq!(
            SurfaceSample::by_patches(&surface, [MOST_NODES, 1]),
            Err(ExportFault::TooManyNodes { wanted: 2 * (MOST_NODES + 1), most: MOST_NODES })
        );
    }

    #[test]
    fn chords_of_a_circle() {
        let basis = BSplineBasis::new(2, vec![0., 0., 0., 1., 1., 1.]).unwrap();
        let points = [[10., 0.], [10., 10.], [0., 10.]].map(|[x, y]| Vector::new(x, y, 0.0)).to_vec();
        let arc = BSplineCurve::new(basis, Dimension::Plane, points, Some(vec![1.0, 0.5f64.sqrt(), 1.0])).unwrap();
        let parameters = curve_parameters(&arc, 1e-3).unwrap();
        let nodes = curve_nodes(&arc, &parameters).unwrap();
        assert!(parameters.windows(2).all(|p| p[0] < p[1]) && nodes.len() < 100);
        for pair in nodes.windows(2) {
            assert!(10.0 - ((pair[0] + pair[1]) / 2.0).norm() < 1.01e-3);
        }
        assert_eq!(curve_parameters(&arc, 0.0), Err(ExportFault::Tolerance { tolerance: 0.0 }));
        // a tolerance below rounding ends all the same
        assert_eq!(curve_parameters(&arc, 1e-30).unwrap().len(), 4097);
    }

    #[test]
    fn values_given_are_met() {
        assert_eq!(between(&[0.5, 0.75, 2.0], 2), [0.5, 0.625, 0.75, 1.375, 2.0]);
        assert_eq!(between(&[0.1, 0.3], 0), [0.1, 0.3]);
    }
}
