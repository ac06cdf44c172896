//! Data and method of a surface.

use super::{coons::Twists, least_squares::AxisKnots, mesh::CurveMesh};
use crate::{
    curve::{CurveShape, Parametrization},
    space::{Dimension, Vector},
};

/// Data that a surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// z(uᵢ, vⱼ) in rows, one for each u; u and v ascend.
    Grid {
        /// Places of the rows, ascending.
        u: Vec<f64>,
        /// Places of the columns, ascending.
        v: Vec<f64>,
        /// Heights, a row for each u and a column for each v.
        z: Vec<Vec<f64>>,
    },
    /// Points of space in rows.
    Points {
        /// Points of space, in rows of equal length.
        rows: Vec<Vec<Vector>>,
        /// How parameters are assigned to rows and columns.
        parametrization: Parametrization,
    },
    /// Boundary curves in the order u0, u1, v0, v1 (see [`super::boundaries`]), one of which may be
    /// missing, the derivatives across them as far as known, and how far the curves' ends may be
    /// apart.
    Boundaries {
        /// The boundary curves; `None` for a border that is a point.
        curves: Box<[Option<CurveShape>; 4]>,
        /// Derivatives across the borders, as curves over the same parameters; `None` where not
        /// known.
        cross: Box<[Option<CurveShape>; 4]>,
        /// Distance up to which two curves count as meeting, in the unit of the coordinates.
        tolerance: f64,
    },
    /// A mesh of curves and how far they may be apart where they cross.
    Mesh {
        /// The curves over u and over v.
        mesh: CurveMesh,
        /// Distance up to which two curves count as meeting, in the unit of the coordinates.
        tolerance: f64,
    },
    /// A net in rows, one for each index along u.
    ControlPoints(Net),
}

/// Control points of a Bézier, B-spline, NURBS or Gregory surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// Control points, a row for each index along u.
    pub rows: Vec<Vec<Vector>>,
    /// Whether they are heights or points of space.
    pub dimension: Dimension,
    /// As many weights in as many rows, for a rational surface.
    pub weights: Option<Vec<Vec<f64>>>,
    /// The second of each pair of inner points, for a Gregory patch.
    pub inner: Option<[[Vector; 2]; 2]>,
    /// Ranges of u and v where no knots say them: [0, 1] for none.
    pub domain: Option<[[f64; 2]; 2]>,
}

/// How the surface is made.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Coons patches: of boundary curves one, of a mesh or grid one in every mesh (C⁰).
    CoonsBilinear,
    /// The same, bicubically blended. In a mesh or on a grid the twists are common to the patches
    /// around a node (C¹).
    CoonsBicubic {
        /// Mixed derivatives S_uv at the corners.
        twists: Twists,
    },
    /// Gregory patches: of a net of 16 + 4 points, of boundary curves, or in every mesh.
    Gregory,
    /// From a net of any degrees; bicubic from boundary curves, or in every cell of a mesh.
    Bezier,
    /// Through a grid, knots averaged where not given; or of a net, with knots or with clamped
    /// uniform ones.
    BSpline {
        /// Degrees along u and v, from 1.
        degrees: [usize; 2],
        /// Full knot vectors along u and v; `None` for the method's own.
        knots: [Option<Vec<f64>>; 2],
    },
    /// Near a grid.
    BSplineLeastSquares {
        /// Degrees along u and v, from 1.
        degrees: [usize; 2],
        /// Knots along u and v, or how many spans to place.
        knots: [AxisKnots; 2],
    },
    /// From a net with weights; knots as for a B-spline.
    Nurbs {
        /// Degrees along u and v, from 1.
        degrees: [usize; 2],
        /// Full knot vectors along u and v; `None` for the method's own.
        knots: [Option<Vec<f64>>; 2],
    },
}

impl Method {
    /// Stable name.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Method::CoonsBilinear => "coons_bilinear",
            Method::CoonsBicubic { .. } => "coons_bicubic",
            Method::Gregory => "gregory",
            Method::Bezier => "bezier",
            Method::BSpline { .. } => "b_spline",
            Method::BSplineLeastSquares { .. } => "b_spline_least_squares",
            Method::Nurbs { .. } => "nurbs",
        }
    }
}
