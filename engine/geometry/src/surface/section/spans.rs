//! The smooth rectangles of a surface, with what is known of the height over each.

use std::borrow::Cow;

use super::{
    fault::SectionFault,
    field::Field,
    form::Form,
    heights::{Heights, Margins},
    plane::Plane,
};
use crate::{
    BSplineBasis,
    space::Vector,
    surface::{BSplineSurface, Surface, SurfaceShape},
};
use flankfit_numerics::cancel::checkpoint;

/// Rectangles between knots that are looked at, at most.
const MOST_RECTANGLES: usize = 250_000;

/// A surface, or a patch of one, made ready to be cut.
pub(super) struct Patch<'a> {
    pub surface: &'a dyn Surface,
    /// The same surface as a spline, where it is one: what bounds of heights come of.
    spline: Option<Cow<'a, BSplineSurface>>,
}

impl<'a> Patch<'a> {
    pub(super) fn plain(surface: &'a dyn Surface) -> Self {
        Patch { surface, spline: None }
    }

    /// The patches of a patchwork, or the surface itself.
    pub(super) fn of_shape(shape: &'a SurfaceShape) -> Vec<Self> {
        let spline = match shape {
            SurfaceShape::Patchwork(work) => return work.patches().iter().flat_map(Self::of_shape).collect(),
            SurfaceShape::BSpline(spline) => Some(Cow::Borrowed(spline)),
            SurfaceShape::Bezier(patch) => Some(Cow::Borrowed(patch.as_b_spline())),
            SurfaceShape::Coons(patch) => patch.to_b_spline().map(Cow::Owned),
            SurfaceShape::Gregory(patch) => patch.to_b_spline().map(Cow::Owned),
        };
        vec![Patch { surface: shape.surface(), spline }]
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.spline.as_ref().map_or_else(|| self.surface.breaks(), |spline| spline.breaks())
    }

    /// How many smooth rectangles there are; an error where they are too many.
    pub(super) fn check(&self) -> Result<(), SectionFault> {
        let [us, vs] = self.breaks().map(|breaks| breaks.len() - 1);
        if us.saturating_mul(vs) > MOST_RECTANGLES {
            return Err(SectionFault::TooManyPieces { given: us.saturating_mul(vs), most: MOST_RECTANGLES });
        }
        Ok(())
    }

    /// The least and the greatest coordinates among some places.
    pub(super) fn bounds(&self) -> [Vector; 2] {
        let [u, v] = self.surface.domain();
        let at = |[low, high]: [f64; 2], k: u32| low + (high - low) * (f64::from(k) / 8.0);
        (0..81).fold([Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)], |[low, high], k| {
            let point = self.surface.place(at(u, k / 9), at(v, k % 9)).value;
            [low.inf(&point), high.sup(&point)]
        })
    }

    /// Hands each smooth rectangle that the plane may pass to `take`, with what is known of the
    /// height there; heights up to `contact` count as 0. Answers whether a rectangle lies so flat
    /// about the plane that rounding moves the section by more than `blur`: there is no line to be
    /// returned there.
    pub(super) fn each(
        &self,
        (index, plane, contact, blur): (usize, &Plane, f64, f64),
        take: &mut dyn FnMut(&Field<'_>, Heights) -> Result<(), SectionFault>,
    ) -> Result<bool, SectionFault> {
        let mut flat = false;
        let [us, vs] = self.breaks();
        let net = self.spline.as_deref().map(|spline| Net::of(spline, plane));
        for i in 0..us.len() - 1 {
            for j in 0..vs.len() - 1 {
                checkpoint();
                let smooth = [[us[i], us[i + 1]], [vs[j], vs[j + 1]]];
                let field =
                    Field { surface: self.surface, patch: index, normal: plane.normal, offset: plane.offset, smooth };
                let heights = match &net {
                    Some(net) if net.is_flat([i, j], smooth, (contact, blur)) => {
                        flat = true;
                        continue;
                    }
                    Some(net) if net.is_away([i, j], smooth, contact) => continue,
                    Some(net) => net.heights([i, j]),
                    None => Heights::sampled(&field, smooth),
                };
                take(&field, heights)?;
            }
        }
        Ok(flat)
    }
}

/// A spline over a plane.
struct Net<'a> {
    spline: &'a BSplineSurface,
    plane: &'a Plane,
    /// Knot spans with a width, along u and v.
    spans: [Vec<usize>; 2],
    /// Heights of control points; of a graph without the part of the ground.
    heights: Vec<f64>,
    rounding: f64,
    /// No rectangle is wider.
    extent: f64,
}

impl<'a> Net<'a> {
    fn of(spline: &'a BSplineSurface, plane: &'a Plane) -> Self {
        let wide = |basis: &BSplineBasis| -> Vec<usize> {
            (basis.degree()..basis.size()).filter(|span| basis.knots()[*span] < basis.knots()[span + 1]).collect()
        };
        let parametric = spline.dimension().is_parametric();
        let height = |point: &Vector| {
            if parametric { plane.normal.dot(point) - plane.offset } else { plane.normal.z * point.x - plane.offset }
        };
        let ground =
            if parametric { 0.0 } else { spline.domain().iter().flatten().fold(0.0, |a, x| f64::max(a, x.abs())) };
        let largest = spline.control_points().iter().map(Vector::norm).fold(ground, f64::max);
        Net {
            spline,
            plane,
            spans: spline.bases().each_ref().map(wide),
            heights: spline.control_points().iter().map(height).collect(),
            rounding: 64.0 * f64::EPSILON * (largest + plane.offset.abs()),
            extent: 4.0 * largest,
        }
    }

    /// Indices of the control points that act on a rectangle.
    fn acting(&self, at: [usize; 2]) -> impl Iterator<Item = usize> + use<'_> {
        let bases = self.spline.bases();
        let [p, q] = bases.each_ref().map(BSplineBasis::degree);
        let (i, j) = (self.spans[0][at[0]] - p, self.spans[1][at[1]] - q);
        let columns = bases[1].size();
        (i..=i + p).flat_map(move |row| (j..=j + q).map(move |column| row * columns + column))
    }

    /// Contribution of the ground under a rectangle to the heights of a graph: the least and the
    /// most.
    fn ground(&self, [u, v]: [[f64; 2]; 2]) -> [f64; 2] {
        if self.spline.dimension().is_parametric() {
            return [0.0; 2];
        }
        let [a, b] = [(self.plane.normal.x, u), (self.plane.normal.y, v)].map(|(n, [low, high])| [n * low, n * high]);
        [a[0].min(a[1]) + b[0].min(b[1]), a[0].max(a[1]) + b[0].max(b[1])]
    }

    /// Whether all control points lie on one side of the plane.
    fn is_away(&self, at: [usize; 2], smooth: [[f64; 2]; 2], contact: f64) -> bool {
        let [low, high] = self.ground(smooth);
        self.acting(at).all(|k| self.heights[k] + low > contact)
            || self.acting(at).all(|k| self.heights[k] + high < -contact)
    }

    /// Whether the rectangle leaves the plane, but nowhere by so much that the section were known
    /// to `blur` in spite of rounding.
    fn is_flat(&self, at: [usize; 2], smooth: [[f64; 2]; 2], (contact, blur): (f64, f64)) -> bool {
        let [low, high] = self.ground(smooth);
        let height = |k: usize| (self.heights[k] + low).abs().max((self.heights[k] + high).abs());
        let most = self.acting(at).map(height).fold(0.0, f64::max);
        // seldom, so that places are asked for last
        if most <= contact || most * blur > 0.25 * self.rounding * self.extent {
            return false;
        }
        let [[a, b], [c, d]] = smooth;
        let place = |u: f64, v: f64| self.spline.place(u, v).value;
        let width = (place(a, c) - place(b, d)).norm().max((place(a, d) - place(b, c)).norm());
        most * blur <= self.rounding * width / 16.0
    }

    fn heights(&self, at: [usize; 2]) -> Heights {
        let weights = self.spline.weights().map_or([1.0; 2], |weights| {
            self.acting(at).fold([f64::INFINITY, 0.0], |[low, high], k| [low.min(weights[k]), high.max(weights[k])])
        });
        let spans = [self.spans[0][at[0]], self.spans[1][at[1]]];
        let form = Form::of_spans(self.spline, self.plane, spans);
        Heights::Exact(form, Margins { weights, rounding: self.rounding * weights[1] })
    }
}
