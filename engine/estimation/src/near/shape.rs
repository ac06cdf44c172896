//! From a fit to the curve or surface that it is.
//!
//! Coefficients of a fit are reported in the caller's functions whatever the scaling was, so those
//! of B-splines are the control points of a graph y(x) or z(u, v). A polynomial has its shape from
//! the fit itself, which knows more digits than its coefficients hold.

use crate::{
    design::{Axis, Basis, product_on},
    result::{FitResult, Shape},
    spec::{FitSpec, Model},
};
use flankfit_geometry::{
    curve::{BSplineCurve, CurveShape},
    space::{Dimension, Vector},
    surface::{BSplineSurface, SurfaceShape},
};

/// Returns the graph of `result`, a fit of `spec`: always for B-splines, for polynomials if it was
/// included; `None` for measurement matrices, and for degrees above those of curves and surfaces.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     near::{Shape, shape_of},
///     spec::{Degree, Knots, Model, Regularization},
/// };
/// use flankfit_geometry::curve::Curve;
///
/// // A parabola is a quadratic spline.
/// let x: Vec<f64> = (0..=12).map(f64::from).collect();
/// let y = x.iter().map(|x| x * x).collect();
/// let model = Model::BSpline { degree: Degree::Both(2), knots: Knots::Spans(3), weights: None };
/// let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
/// let found = fit(&Nodes::curve(x, y, None)?, &spec)?;
/// let Some(Shape::Curve(curve)) = shape_of(&spec, &found) else { panic!("a curve was fitted") };
/// assert!((curve.value(2.5).x - 6.25).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shape_of(spec: &FitSpec, result: &FitResult) -> Option<Shape> {
    let Model::BSpline { weights, .. } = &spec.model else { return result.shape.clone() };
    let domain = result.domain?;
    let (u, surface) = (domain.u?, domain.v.is_some());
    let domains = (u, domain.v.unwrap_or([0.0; 2]));
    let design = product_on(surface, &spec.model, domains, domains).ok()?;
    if design.size() != result.coefficients.len() {
        return None;
    }
    let controls = result.coefficients.iter().map(|c| Vector::new(c.value, 0.0, 0.0)).collect();
    let weights = weights.clone();
    match design.basis {
        Basis::Product { u: Axis::Spline(u), v: Axis::Spline(v) } if surface => {
            let surface = BSplineSurface::new([u, v], Dimension::Graph, controls, weights).ok()?;
            Some(Shape::Surface(SurfaceShape::BSpline(surface)))
        }
        Basis::Product { u: Axis::Spline(basis), .. } if !surface => {
            let curve = BSplineCurve::new(basis, Dimension::Graph, controls, weights).ok()?;
            Some(Shape::Curve(CurveShape::BSpline(curve)))
        }
        _ => None,
    }
}
