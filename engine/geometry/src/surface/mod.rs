//! Surfaces: z(u, v) over two axes, or points of space over two parameters (sections 2.1 and 2.2 of
//! the paper).
//!
//! A surface is anything that can tell its domain and its jet: value and derivatives to order 2.
//! What follows from these alone (normal, fundamental forms, curvatures, the closest point, area)
//! is written once, for every surface.
//!
//! Parameters outside the domain are the caller's mistake and are refused beforehand; here the
//! border patch goes on.

pub mod area;
mod axis;
pub mod b_spline;
mod bends;
pub mod bezier;
pub mod boundaries;
mod check;
pub mod closest;
mod closest_cell;
pub mod construct;
pub mod continuity;
pub mod coons;
mod corner;
mod descent;
pub mod differential;
pub mod evaluate;
pub mod gregory;
pub mod gregory_fill;
pub mod grid;
pub mod interpolate;
mod jets;
pub mod least_squares;
mod least_squares_axis;
mod local;
pub mod mesh;
mod method;
pub mod patchwork;
mod refine;
pub mod section;
pub mod shape;
pub mod to_b_spline;
pub mod triangle;

pub use b_spline::BSplineSurface;
pub use bezier::BezierSurface;
pub use boundaries::{Border, Boundaries};
pub use closest::{ClosestPoint, SurfacePoint};
pub use construct::{Built, Given, Method, build};
pub use coons::CoonsPatch;
pub use differential::Differential;
pub use evaluate::Evaluator;
pub use gregory::GregoryPatch;
pub use grid::NodeGrid;
pub use local::{LocalGeometry, normal};
pub use patchwork::Patchwork;
pub use shape::SurfaceShape;

use super::space::{Dimension, Vector};

/// Value and derivatives at one pair of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceJet {
    /// The point S.
    pub value: Vector,
    /// First derivative S_u.
    pub u: Vector,
    /// First derivative S_v.
    pub v: Vector,
    /// Second derivative S_uu.
    pub uu: Vector,
    /// Mixed derivative S_uv.
    pub uv: Vector,
    /// Second derivative S_vv.
    pub vv: Vector,
}

impl SurfaceJet {
    /// The jet of the place in space of a surface of this dimension: (u, v, z(u, v)) for a graph,
    /// else the jet itself.
    pub fn placed(self, dimension: Dimension, u: f64, v: f64) -> Self {
        if dimension.is_parametric() {
            return self;
        }
        let raised = |x: f64, y: f64, z: &Vector| Vector::new(x, y, z.x);
        SurfaceJet {
            value: raised(u, v, &self.value),
            u: raised(1.0, 0.0, &self.u),
            v: raised(0.0, 1.0, &self.v),
            uu: raised(0.0, 0.0, &self.uu),
            uv: raised(0.0, 0.0, &self.uv),
            vv: raised(0.0, 0.0, &self.vv),
        }
    }
}

/// A surface over two parameters.
pub trait Surface {
    /// [`Dimension::Graph`] or [`Dimension::Space`].
    fn dimension(&self) -> Dimension;

    /// The ranges of u and of v, low < high each.
    fn domain(&self) -> [[f64; 2]; 2];

    /// Value and derivatives to order 2. At a break the piece to the right counts, at the end of
    /// the domain the last one.
    fn jet(&self, u: f64, v: f64) -> SurfaceJet;

    /// For u and for v: the places, both ends included and ascending, between which the surface is
    /// infinitely smooth.
    fn breaks(&self) -> [Vec<f64>; 2];

    /// Bounds of the sizes of ∂²/∂u², ∂²/∂u∂v and ∂²/∂v² in each rectangle between neighbouring
    /// `cuts` of u and of v (ascending, within the domain), v running fastest. `None` where the
    /// surface has none to offer.
    fn bends(&self, cuts: [&[f64]; 2]) -> Option<Vec<[f64; 3]>> {
        let _ = cuts;
        None
    }

    /// The point or number at (u, v).
    fn value(&self, u: f64, v: f64) -> Vector {
        self.jet(u, v).value
    }

    /// The jet of the surface's place in space: (u, v, z(u, v)) for a graph, else the jet itself.
    fn place(&self, u: f64, v: f64) -> SurfaceJet {
        self.jet(u, v).placed(self.dimension(), u, v)
    }
}
