//! Local geometry at a place of a surface, singular places by a limit
//! ([`super::triangle`]) included.

use super::{
    Differential, Surface, SurfaceJet,
    differential::{BLUNT, is_singular, sharpness},
    triangle::{limit, normal_limit},
};
use crate::space::Vector;

impl Differential {
    /// Returns the quantities at (u, v); as a limit if the parameters are singular or nearly so,
    /// `None` if there is no limit either (a cusp, a fold).
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     space::{Dimension, Vector},
    ///     surface::{BezierSurface, Differential},
    /// };
    ///
    /// // The saddle z = uv bends by +1 along one diagonal and by −1 along the other.
    /// let heights = [1.0, -1.0, -1.0, 1.0].map(|z| Vector::new(z, 0.0, 0.0)).to_vec();
    /// let around = [[-1.0, 1.0]; 2];
    /// let saddle = BezierSurface::new([2, 2], around, Dimension::Graph, heights, None)?;
    /// let at = Differential::at(&saddle, 0.0, 0.0).unwrap();
    /// assert!((at.gaussian + 1.0).abs() < 1e-14 && at.mean.abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn at(surface: &dyn Surface, u: f64, v: f64) -> Option<Self> {
        Self::at_jet(surface, &surface.place(u, v), u, v)
    }

    /// The same where the jet of the place in space is known already.
    pub fn at_jet(surface: &dyn Surface, jet: &SurfaceJet, u: f64, v: f64) -> Option<Self> {
        let sharpness = sharpness(jet, surface.domain());
        if sharpness > BLUNT {
            return Self::of(jet);
        }
        // near a singular place, the more accurate of both
        let error = f64::EPSILON / (sharpness * sharpness);
        match limit(surface, u, v, error) {
            None if !is_singular(jet, surface.domain()) => Self::of(jet),
            limit => limit,
        }
    }
}

/// A place of a surface with whatever the derivatives tell there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalGeometry {
    /// The point S(u, v).
    pub point: Vector,
    /// Unit normal along S_u × S_v; where the parameters are singular its limit from inside, which
    /// may exist where curvatures have none (at the tip of a three-sided patch that ends as a cone
    /// does).
    pub normal: Option<Vector>,
    /// `None` where there is no tangent plane, or no limit of the curvatures.
    pub differential: Option<Differential>,
}

impl LocalGeometry {
    /// At (u, v).
    pub fn at(surface: &dyn Surface, u: f64, v: f64) -> Self {
        Self::of(surface, &surface.place(u, v), u, v)
    }

    /// The same where the jet of the place in space is known already.
    pub fn of(surface: &dyn Surface, jet: &SurfaceJet, u: f64, v: f64) -> Self {
        let finite = |normal: &Vector| normal.iter().all(|x| x.is_finite());
        let differential = Differential::at_jet(surface, jet, u, v);
        let normal = differential.map(|found| found.normal).or_else(|| normal_at(surface, jet, u, v));
        LocalGeometry { point: jet.value, normal: normal.filter(finite), differential }
    }
}

/// The unit normal at (u, v), along S_u × S_v; by a limit where the parameters are singular. A tip
/// without curvature may have one.
pub fn normal(surface: &dyn Surface, u: f64, v: f64) -> Option<Vector> {
    normal_at(surface, &surface.place(u, v), u, v)
}

fn normal_at(surface: &dyn Surface, jet: &SurfaceJet, u: f64, v: f64) -> Option<Vector> {
    if is_singular(jet, surface.domain()) {
        return normal_limit(surface, u, v);
    }
    jet.u.cross(&jet.v).try_normalize(0.0)
}
