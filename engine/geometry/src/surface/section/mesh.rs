//! Two families of parallel planes at right angles make a mesh of curves: heights over the frame of
//! their normals, as the filling of meshes takes them.

use super::{
    line::{Description, SectionPoint},
    result::{Section, SectionCurve},
};
use crate::{
    curve::{Curve, CurveShape, Tangents, cubic_hermite},
    space::{Dimension, Vector},
    surface::{Surface, SurfaceJet, SurfaceShape, mesh::CurveMesh},
};
use flankfit_numerics::cancel::checkpoint;

/// Halvings of a piece at most.
const DEEPEST: u32 = 24;
/// Cosines of right angles may be as large.
const SKEW: f64 = 1e-12;
/// Steps of Newton's method at most.
const STEPS: usize = 30;

/// A mesh of curves with how far the curves are from the sections at worst.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOfSections {
    /// Unit vectors along which u, v and heights are counted.
    pub frame: [Vector; 3],
    /// The curves: `us` and `vs` are the offsets of the planes.
    pub mesh: CurveMesh,
    /// The largest difference of heights.
    pub error: f64,
}

/// Why sections are no mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoMesh {
    /// Normals that are not at right angles.
    #[error("the normals of the two families are not at right angles: the cosine of their angle is {cosine:.1e}")]
    Skew {
        /// Cosine of the angle between them.
        cosine: f64,
    },
    /// Curves of more pieces than are allowed.
    #[error("the mesh needs more than {most} points")]
    TooManyPoints {
        /// How many are allowed.
        most: usize,
    },
    /// A plane without exactly one curve over the whole range of the other family.
    #[error(
        "plane {plane} of family {family} has {curves} curves that cross all planes of the other family as heights; a \
         mesh needs one"
    )]
    Curves {
        /// 0 or 1.
        family: usize,
        /// Which of its planes, from 0.
        plane: usize,
        /// How many such curves there are.
        curves: usize,
    },
}

/// Parallel planes with their sections of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Family<'a> {
    /// Their normal, of length 1.
    pub normal: Vector,
    /// Their distances from the origin along the normal, ascending, two or more.
    pub offsets: &'a [f64],
    /// The section by each.
    pub sections: &'a [Section],
}

/// Whether planes with these normals, of length 1, can make a mesh.
pub fn at_right_angles([u, v]: [Vector; 2]) -> Result<(), NoMesh> {
    let cosine = u.dot(&v);
    if cosine.abs() > SKEW {
        return Err(NoMesh::Skew { cosine });
    }
    Ok(())
}

/// The mesh of the sections by two families of planes; its curves are as near to the surface as
/// `how` says.
pub fn mesh_of_sections(
    surface: &SurfaceShape,
    families: [Family<'_>; 2],
    how: Description,
) -> Result<MeshOfSections, NoMesh> {
    let [u, v] = families.map(|family| family.normal);
    at_right_angles([u, v])?;
    let frame = [u, v, u.cross(&v)];
    let (mut error, mut points) = (0.0_f64, 0);
    let mut curves = [Vec::new(), Vec::new()];
    for family in 0..2 {
        let Family { offsets, sections, .. } = families[family];
        for (plane, (offset, found)) in offsets.iter().zip(sections).enumerate() {
            let heights = Heights { surface, frame, family, offset: *offset };
            let (curve, off) = heights
                .only(found, families[1 - family].offsets, how)
                .map_err(|curves| NoMesh::Curves { family, plane, curves })?;
            error = error.max(off);
            points += curve.breaks().len();
            if points > how.most {
                return Err(NoMesh::TooManyPoints { most: how.most });
            }
            curves[family].push(Some(curve));
        }
    }
    let [over_v, over_u] = curves;
    let mesh = CurveMesh { us: families[0].offsets.to_vec(), vs: families[1].offsets.to_vec(), over_v, over_u };
    Ok(MeshOfSections { frame, mesh, error })
}

/// Heights along the section by one plane, over the places of the other family.
struct Heights<'a> {
    surface: &'a SurfaceShape,
    frame: [Vector; 3],
    family: usize,
    offset: f64,
}

/// A height and its derivative along the section.
#[derive(Clone, Copy)]
struct Height {
    at: f64,
    value: f64,
    slope: f64,
}

impl Heights<'_> {
    fn along(&self) -> Vector {
        self.frame[1 - self.family]
    }

    /// The only curve that covers the places as heights, else how many do.
    fn only(&self, found: &Section, places: &[f64], how: Description) -> Result<(CurveShape, f64), usize> {
        let (low, high) = (places[0], places[places.len() - 1]);
        let reach = 1e-9 * (high - low);
        let covering: Vec<&SectionCurve> = found
            .curves
            .iter()
            .filter(|curve| {
                let at = |point: &SectionPoint| self.along().dot(&point.point);
                let ends = [&curve.points[0], &curve.points[curve.points.len() - 1]].map(at);
                let within = curve.points.iter().filter(|p| at(p) >= low - reach && at(p) <= high + reach);
                let slopes: Vec<f64> = within.map(|point| self.along().dot(&point.tangent)).collect();
                let one_way = slopes.iter().all(|s| *s > 1e-6) || slopes.iter().all(|s| *s < -1e-6);
                !curve.closed && ends[0].min(ends[1]) <= low + reach && ends[0].max(ends[1]) >= high - reach && one_way
            })
            .collect();
        let [curve] = covering[..] else { return Err(covering.len()) };
        self.graph(curve, places, how).ok_or(0)
    }

    /// The heights as cubics between places that are near enough for the tolerance.
    fn graph(&self, curve: &SectionCurve, places: &[f64], how: Description) -> Option<(CurveShape, f64)> {
        let nodes: Vec<Height> = places.iter().map(|at| self.height(curve, *at)).collect::<Option<_>>()?;
        let mut all = vec![nodes[0]];
        let mut error = 0.0;
        for pair in nodes.windows(2) {
            self.piece(curve, pair[0], pair[1], (how, DEEPEST), (&mut all, &mut error))?;
        }
        let at: Vec<f64> = all.iter().map(|height| height.at).collect();
        let values: Vec<Vector> = all.iter().map(|height| Vector::new(height.value, 0.0, 0.0)).collect();
        let slopes = Tangents::Given(all.iter().map(|height| Vector::new(height.slope, 0.0, 0.0)).collect());
        let cubics = cubic_hermite(Dimension::Graph, &at, &values, &slopes).ok()?;
        let spline = CurveShape::PiecewisePolynomial(cubics).to_b_spline().ok()?;
        Some((CurveShape::BSpline(spline), error))
    }

    fn piece(
        &self,
        curve: &SectionCurve,
        a: Height,
        b: Height,
        (how, depth): (Description, u32),
        (all, worst): (&mut Vec<Height>, &mut f64),
    ) -> Option<()> {
        checkpoint();
        let width = b.at - a.at;
        let cubic = |t: f64| {
            let s = 1.0 - t;
            s * s * (1.0 + 2.0 * t) * a.value
                + t * t * (3.0 - 2.0 * t) * b.value
                + t * s * width * (s * a.slope - t * b.slope)
        };
        let off = |t: f64| Some((self.height(curve, a.at + t * width)?.value - cubic(t)).abs());
        let mut error = off(0.5)?;
        if error <= 0.5 * how.tolerance {
            error = error.max(off(0.25)?).max(off(0.75)?);
        }
        // more than a mesh may have is refused as a whole
        if error > how.tolerance && depth > 0 && all.len() <= how.most {
            let middle = self.height(curve, a.at + 0.5 * width)?;
            self.piece(curve, a, middle, (how, depth - 1), (all, worst))?;
            return self.piece(curve, middle, b, (how, depth - 1), (all, worst));
        }
        all.push(b);
        *worst = worst.max(error);
        Some(())
    }

    /// The height of the section at a place: by Newton's method for both planes from the next
    /// known place.
    fn height(&self, curve: &SectionCurve, place: f64) -> Option<Height> {
        let points = &curve.points;
        let at = |point: &SectionPoint| self.along().dot(&point.point);
        let ascends = at(&points[points.len() - 1]) > at(&points[0]);
        let k = points.partition_point(|point| (at(point) < place) == ascends).clamp(1, points.len() - 1);
        let mut near = [points[k], points[k - 1]];
        if (at(&near[1]) - place).abs() < (at(&near[0]) - place).abs() {
            near.swap(0, 1);
        }
        // a place that is known may be a pole, where Newton's method has no way
        let [known, _] = near;
        if (at(&known) - place).abs() <= 1e-13 * (known.point.norm() + place.abs()) {
            let slope = self.frame[2].dot(&known.tangent) / self.along().dot(&known.tangent);
            return slope.is_finite().then(|| Height { at: place, value: self.frame[2].dot(&known.point), slope });
        }
        near.iter().find_map(|start| self.newton(start, place))
    }

    fn newton(&self, start: &SectionPoint, place: f64) -> Option<Height> {
        let patch: &dyn Surface = match self.surface {
            SurfaceShape::Patchwork(work) => work.patches().get(start.patch)?.surface(),
            single => single.surface(),
        };
        let [own, along, up] = [self.frame[self.family], self.along(), self.frame[2]];
        let domain = patch.domain();
        let mut at = start.parameters;
        for _ in 0..STEPS {
            let SurfaceJet { value, u, v, .. } = patch.place(at[0], at[1]);
            let (f, g) = (own.dot(&value) - self.offset, along.dot(&value) - place);
            let (a, b, c, d) = (own.dot(&u), own.dot(&v), along.dot(&u), along.dot(&v));
            let whole = a * d - b * c;
            let step = [(d * f - b * g) / whole, (a * g - c * f) / whole];
            if !step.iter().all(|x| x.is_finite()) {
                return None;
            }
            let next: [f64; 2] = std::array::from_fn(|k| (at[k] - step[k]).clamp(domain[k][0], domain[k][1]));
            let width = |k: usize| domain[k][1] - domain[k][0];
            let moved = (0..2).map(|k| (next[k] - at[k]).abs() / width(k)).fold(0.0, f64::max);
            at = next;
            if moved <= 1e-15 {
                break;
            }
        }
        let SurfaceJet { value, u, v, .. } = patch.place(at[0], at[1]);
        let near = 1e-12 * (value.norm() + self.offset.abs() + place.abs());
        let met = (own.dot(&value) - self.offset).abs() <= near && (along.dot(&value) - place).abs() <= near;
        let tangent = u.cross(&v).cross(&own);
        let slope = up.dot(&tangent) / along.dot(&tangent);
        (met && slope.is_finite()).then(|| Height { at: place, value: up.dot(&value), slope })
    }
}
