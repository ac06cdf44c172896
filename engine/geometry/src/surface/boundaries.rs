//! Four boundary curves that meet at four corners: what a Coons or Gregory patch is filled into.
//!
//! Borders are named by what is constant on them: `u0` is the curve over v on u = low, `v1` the
//! curve over u on v = high. In lists they stand in the order u0, u1, v0, v1; corner (i, j) is
//! where border uᵢ meets border vⱼ.

use super::{bezier::one_span, check};
use crate::{
    curve::{BSplineCurve, Curve, CurveShape},
    space::{Dimension, Vector},
};
use flankfit_numerics::{check::Faults, words::Shown};

/// A border: at the least or the greatest u or v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Border {
    /// The curve over v at the lowest u.
    U0,
    /// The curve over v at the highest u.
    U1,
    /// The curve over u at the lowest v.
    V0,
    /// The curve over u at the highest v.
    V1,
}

impl Border {
    /// All four, in the order in which lists have them.
    pub const ALL: [Border; 4] = [Border::U0, Border::U1, Border::V0, Border::V1];

    /// `u0`, `u1`, `v0` or `v1`.
    pub fn name(self) -> &'static str {
        ["u0", "u1", "v0", "v1"][self as usize]
    }

    /// The axis along which the border's curve runs: 1 (v) for u0 and u1.
    pub fn axis(self) -> usize {
        match self {
            Border::U0 | Border::U1 => 1,
            Border::V0 | Border::V1 => 0,
        }
    }

    /// Index of its end of the other axis: 1 for the upper one.
    pub fn end(self) -> usize {
        self as usize % 2
    }

    /// The place on it with the curve's parameter `t`, in `domain`.
    pub fn place(self, domain: [[f64; 2]; 2], t: f64) -> (f64, f64) {
        match self.axis() {
            1 => (domain[0][self.end()], t),
            _ => (t, domain[1][self.end()]),
        }
    }
}

impl std::fmt::Display for Border {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Returns the distance that ends of curves may have where they should meet, if none is given: 1e-6
/// of the largest coordinate of the ends.
pub fn default_tolerance<'a>(curves: impl Iterator<Item = &'a CurveShape>) -> f64 {
    let ends = curves.flat_map(|curve| curve.domain().map(|t| curve.value(t)));
    1e-6 * ends.fold(0.0, |size: f64, end| size.max(end.amax()))
}

/// Boundary curves that were found to meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundaries {
    curves: [CurveShape; 4],
    domain: [[f64; 2]; 2],
    corners: [[Vector; 2]; 2],
    collapsed: Option<Border>,
}

impl Boundaries {
    /// Curves in the order u0, u1, v0, v1, heights over the parameters all or points of space all,
    /// which meet to `tolerance` (in their coordinates). Heights: opposite curves have one domain.
    /// Points: the patch takes the domains of u0 and v0, onto which those of u1 and v1 are mapped.
    pub fn new(curves: [CurveShape; 4], tolerance: f64) -> Result<Self, Faults> {
        Self::checked(curves, None, tolerance)
    }

    /// As [`Boundaries::new`], but one border of points in space may be missing: there the patch
    /// has a point, and three sides.
    pub fn three_sided(curves: [Option<CurveShape>; 4], tolerance: f64) -> Result<Self, Faults> {
        let missing: Vec<Border> = Border::ALL.into_iter().filter(|b| curves[*b as usize].is_none()).collect();
        let collapsed = missing.first().copied();
        if let Some(border) = missing.get(1) {
            return Err(check::border_missing(*border));
        }
        let mut given: Vec<CurveShape> = curves.into_iter().flatten().collect();
        if let Some(border) = collapsed {
            // without one border the others are, in order, its opposite and the two that run into
            // it, or the other way round
            let (opposite, sides) = if border.axis() == 1 { (0, [1, 2]) } else { (2, [0, 1]) };
            let ends = sides.map(|k| given[k].value(given[k].domain()[border.end()]));
            if given[opposite].dimension() != Dimension::Space {
                return Err(check::border_missing(border));
            }
            let tip = (ends[0] + ends[1]) * 0.5;
            let point = one_span(1, given[opposite].domain())
                .ok()
                .and_then(|basis| BSplineCurve::new(basis, Dimension::Space, vec![tip; 2], None).ok())
                .ok_or_else(|| check::border_missing(border))?;
            given.insert(border as usize, CurveShape::BSpline(point));
        }
        match <[CurveShape; 4]>::try_from(given) {
            Ok(curves) => Self::checked(curves, collapsed, tolerance),
            Err(_) => Err(check::border_missing(Border::V1)),
        }
    }

    fn checked(curves: [CurveShape; 4], collapsed: Option<Border>, tolerance: f64) -> Result<Self, Faults> {
        check::tolerance(tolerance)?;
        let dimension = curves[0].dimension();
        for border in Border::ALL {
            let given = curves[border as usize].dimension();
            if given == Dimension::Plane || given != dimension {
                return Err(check::border_dimension(border, given));
            }
        }
        let domain = [curves[2].domain(), curves[0].domain()];
        if dimension == Dimension::Graph {
            for border in [Border::U1, Border::V1] {
                let ([low, high], wanted) = (curves[border as usize].domain(), domain[border.axis()]);
                if [low, high] != wanted {
                    let [low, high, wanted_low, wanted_high] = [low, high, wanted[0], wanted[1]].map(Shown);
                    return Err(Faults::one(
                        format_args!("boundaries.{border}"),
                        format_args!(
                            "border {border} runs over [{low}, {high}], the one opposite over [{wanted_low}, \
                             {wanted_high}]"
                        ),
                    ));
                }
            }
        }
        let mut found = Boundaries { curves, domain, corners: Default::default(), collapsed };
        for (i, j) in CORNERS {
            let (on_u, on_v) = (found.end(i, j), found.end(2 + j, i));
            let gap = (on_u - on_v).norm();
            if !(gap <= tolerance) {
                let [gap, tolerance] = [gap, tolerance].map(Shown);
                return Err(Faults::one(
                    format_args!("boundaries.u{i}"),
                    format_args!("borders u{i} and v{j} are {gap} apart at their corner, more than {tolerance}"),
                ));
            }
            // what is equal stays the same to the bit
            found.corners[i][j] = if on_u == on_v { on_u } else { (on_u + on_v) * 0.5 };
        }
        Ok(found)
    }

    /// The curves, in the order u0, u1, v0, v1.
    pub fn curves(&self) -> &[CurveShape; 4] {
        &self.curves
    }

    /// The border that is a point, if the patch has three sides.
    pub fn collapsed(&self) -> Option<Border> {
        self.collapsed
    }

    /// Heights or points of space.
    pub fn dimension(&self) -> Dimension {
        self.curves[0].dimension()
    }

    /// The ranges of u and v.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        self.domain
    }

    /// Corner (i, j): the point that the two curves share, half-way between where they leave a gap.
    pub fn corner(&self, i: usize, j: usize) -> Vector {
        self.corners[i][j]
    }

    /// Value, first and second derivative of curve number `border` at the patch's own parameter.
    pub(super) fn jet(&self, border: usize, t: f64) -> [Vector; 3] {
        jet_over(&self.curves[border], self.domain[Border::ALL[border].axis()], t)
    }

    /// The value at the lower (0) or upper (1) end of curve number `border`.
    fn end(&self, border: usize, end: usize) -> Vector {
        self.curves[border].value(self.curves[border].domain()[end])
    }

    /// The derivative of curve number `border` at its lower (0) or upper (1) end.
    pub(super) fn tangent(&self, border: usize, end: usize) -> Vector {
        self.jet(border, self.domain[Border::ALL[border].axis()][end])[1]
    }

    /// The places of u and of v between which all curves are infinitely smooth.
    pub(super) fn breaks(&self) -> [Vec<f64>; 2] {
        [[2, 3], [0, 1]]
            .map(|pair| merged(pair.map(|k| breaks_over(&self.curves[k], self.domain[Border::ALL[k].axis()]))))
    }
}

pub(super) const CORNERS: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

/// The jet of `curve` as one over `domain`, onto which its own domain is mapped.
pub(super) fn jet_over(curve: &CurveShape, domain: [f64; 2], t: f64) -> [Vector; 3] {
    let [a, b] = curve.domain();
    let [low, high] = domain;
    if [a, b] == domain {
        let [value, first, second, _] = curve.jet(t);
        return [value, first, second];
    }
    let share = (t - low) / (high - low);
    let rate = (b - a) / (high - low);
    let [value, first, second, _] = curve.jet((a * (1.0 - share) + b * share).clamp(a, b));
    [value, first * rate, second * (rate * rate)]
}

/// The breaks of `curve` as places of `domain`.
pub(super) fn breaks_over(curve: &CurveShape, domain: [f64; 2]) -> Vec<f64> {
    let [a, b] = curve.domain();
    let mut breaks = curve.breaks();
    if [a, b] != domain {
        breaks.iter_mut().for_each(|t| {
            let share = (*t - a) / (b - a);
            *t = domain[0] * (1.0 - share) + domain[1] * share;
        });
    }
    breaks
}

/// The places of several ascending lists in one.
pub(super) fn merged<const N: usize>(lists: [Vec<f64>; N]) -> Vec<f64> {
    let mut all = lists.concat();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}
