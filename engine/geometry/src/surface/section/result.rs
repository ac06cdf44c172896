//! Section of a surface by a plane.

use super::line::SectionPoint;
use crate::{
    curve::{CurveShape, PiecewisePolynomial, Tangents, cubic_hermite},
    space::{Dimension, Vector},
};
use flankfit_numerics::check::Faults;

/// The section of a surface by a plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its curves, each smooth.
    pub curves: Vec<SectionCurve>,
    /// Places at which branches cross: curves end there.
    pub branch_points: Vec<Vector>,
    /// Places at which the plane touches the surface in a point.
    pub contacts: Vec<Vector>,
    /// Whether a part of the surface lies in the plane; it is no part of the curves.
    pub coincident: bool,
    /// Places about which branches are too near to each other to distinguish, or the surface too
    /// flat.
    pub unresolved: Vec<Vector>,
}

/// A curve of a section.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionCurve {
    /// Places on surface and plane; of a closed curve the first one again at the end.
    pub points: Vec<SectionPoint>,
    /// True if it ends where it begins, smoothly.
    pub closed: bool,
    /// Whether the plane touches the surface along it.
    pub tangential: bool,
    /// How far the curve, or its chords, was found from the section at worst, with rounding.
    pub error: f64,
}

impl SectionCurve {
    /// The curve of cubics over the length, in space.
    pub fn shape(&self) -> Result<CurveShape, Faults> {
        let lengths: Vec<f64> = self.points.iter().map(|point| point.length).collect();
        let points: Vec<Vector> = self.points.iter().map(|point| point.point).collect();
        let tangents = Tangents::Given(self.points.iter().map(|point| point.tangent).collect());
        let cubics: PiecewisePolynomial = cubic_hermite(Dimension::Space, &lengths, &points, &tangents)?;
        CurveShape::PiecewisePolynomial(cubics).to_b_spline().map(CurveShape::BSpline)
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.length)
    }
}
