//! The B-spline form of a fitted polynomial over its domain.
//!
//! Pieces in Bernstein's basis are made from the estimate in the working Chebyshev polynomials, to
//! twice the digits of double: the coefficients of raw powers, once rounded to doubles, no longer
//! hold the heights to the last digits. Bernstein coefficients outgrow the polynomial by up to
//! about 2ⁿ, and as much of the digits is lost when they are rounded; where they do, the domain is
//! cut into more pieces.

use nalgebra::DMatrix;

use super::conclude::Solved;
use crate::{
    design::{Axis, Basis, Design},
    regularized::Applied,
    result::{Shape, Warning},
};
use flankfit_geometry::{
    BSplineBasis, Mapping, bernstein,
    curve::{BSplineCurve, CurveShape},
    polynomial::chebyshev_values,
    space::{Dimension, HIGHEST_DEGREE, Vector},
    surface::{BSplineSurface, SurfaceShape},
};
use flankfit_numerics::{Dd, cancel::Asking, triangular};

/// Most that a control point may outgrow the largest height: 64 · 2⁻⁵³ is 7e-15 of it.
const MOST_GROWTH: f64 = 64.0;

impl Solved<'_> {
    /// Returns the fitted polynomial as a curve or surface, if it was included. Models of B-splines
    /// have their shape from the coefficients as they are.
    pub(super) fn shape(&self, applied: &Applied, warnings: &mut Vec<Warning>) -> Option<Shape> {
        if !self.spec.include.shape {
            return None;
        }
        let design = self.linear.design;
        let (u, v) = match &design.basis {
            Basis::Columns { .. } => {
                warnings.push(Warning::NoShapeOfMatrix);
                return None;
            }
            Basis::Product { u: Axis::Spline(_), .. } | Basis::Product { v: Axis::Spline(_), .. } => return None,
            Basis::Product {
                u: Axis::Polynomial { mapping: u, size: along_u, .. },
                v: Axis::Polynomial { mapping: v, size: along_v, .. },
            } => ((*u, *along_u), (*v, *along_v)),
        };
        let domain = design.domain?;
        let degree = u.1.max(v.1) - 1;
        if degree > HIGHEST_DEGREE {
            warnings.push(Warning::NoShapeOfDegree { degree, most: HIGHEST_DEGREE });
            return None;
        }
        let net = net(design, self.working(applied), u.1, v.1);
        let shape = match (domain.u?, domain.v) {
            (u_range, None) => curve(u.0, u_range, &net),
            (u_range, Some(v_range)) => surface([u.0, v.0], [u_range, v_range], &net),
        };
        if shape.is_none() {
            warnings.push(Warning::NoShapeOfPoint);
        }
        shape
    }

    /// The regularised estimate in the working polynomials.
    fn working(&self, applied: &Applied) -> Vec<Dd> {
        if self.spectrum.full_rank() {
            let mut working = applied.map.fitted(self.linear, &self.spectrum);
            triangular::solve_upper(&self.linear.factor.r, &mut working);
            return working;
        }
        let change = &self.linear.factor.change;
        let value = &applied.estimate.coefficients;
        let row = |i: usize| (i..value.len()).fold(Dd::ZERO, |sum, j| sum + change[(i, j)] * value[j]);
        (0..value.len()).map(row).collect()
    }
}

/// The coefficients of the products of Chebyshev polynomials; terms that take no part are 0.
fn net(design: &Design, working: Vec<Dd>, along_u: usize, along_v: usize) -> DMatrix<Dd> {
    let mut net = DMatrix::from_element(along_u, along_v, Dd::ZERO);
    for (&(i, j), value) in design.terms.iter().zip(working) {
        net[(i, j)] = value;
    }
    net
}

/// `None` for a domain that is one place.
fn curve(mapping: Mapping, range: [f64; 2], net: &DMatrix<Dd>) -> Option<Shape> {
    let axis = |count| Pieces::new(mapping, range, net.nrows() - 1, count);
    let largest = largest([&axis(1)?, &Pieces::single()], net);
    let mut count = 1;
    loop {
        let pieces = axis(count)?;
        let controls = pieces.controls(net);
        if grown(&controls, largest) && count < MOST_PIECES {
            count += 1;
            continue;
        }
        let points = controls.iter().map(|c| Vector::new(c.to_f64(), 0.0, 0.0)).collect();
        let curve = BSplineCurve::new(pieces.basis?, Dimension::Graph, points, None).ok()?;
        return Some(Shape::Curve(CurveShape::BSpline(curve)));
    }
}

/// More pieces on an axis than are ever needed: on each of them every polynomial is monotone or
/// nearly so.
const MOST_PIECES: usize = HIGHEST_DEGREE;

fn surface(mappings: [Mapping; 2], ranges: [[f64; 2]; 2], net: &DMatrix<Dd>) -> Option<Shape> {
    let degrees = [net.nrows() - 1, net.ncols() - 1];
    let axis = |k: usize, count: usize| Pieces::new(mappings[k], ranges[k], degrees[k], count);
    let largest = largest([&axis(0, 1)?, &axis(1, 1)?], net);
    let mut counts = [1, 1];
    loop {
        let [u, v] = [axis(0, counts[0])?, axis(1, counts[1])?];
        let controls = v.controls(&u.controls(net).transpose()).transpose();
        if grown(&controls, largest) && counts != [MOST_PIECES; 2] {
            // the axis whose polynomials swing most within a piece
            let swing = |k: usize| degrees[k] as f64 / counts[k] as f64;
            let k = usize::from(swing(1) > swing(0));
            counts[k] = (counts[k] + 1).min(MOST_PIECES);
            continue;
        }
        let points = controls.transpose().iter().map(|c| Vector::new(c.to_f64(), 0.0, 0.0)).collect();
        let surface = BSplineSurface::new([u.basis?, v.basis?], Dimension::Graph, points, None).ok()?;
        return Some(Shape::Surface(SurfaceShape::BSpline(surface)));
    }
}

/// The largest height at the extremes of the Chebyshev polynomials over the domain.
fn largest([u, v]: [&Pieces; 2], net: &DMatrix<Dd>) -> f64 {
    let rows = u.places.iter().asking(1000).map(|row| (row.transpose() * net).transpose());
    rows.flat_map(|line| v.places.iter().map(move |column| line.dot(column).to_f64().abs())).fold(0.0, f64::max)
}

fn grown(controls: &DMatrix<Dd>, largest: f64) -> bool {
    controls.iter().any(|c| c.to_f64().abs() > MOST_GROWTH * largest)
}

/// An axis cut into pieces of one degree, as many between the extremes of T as about its middle.
struct Pieces {
    basis: Option<BSplineBasis>,
    /// From coefficients of Chebyshev polynomials to control points, piece by piece.
    change: DMatrix<Dd>,
    /// The Chebyshev polynomials at their extremes over the range.
    places: Vec<nalgebra::DVector<Dd>>,
}

impl Pieces {
    /// The axis that a curve has not got.
    fn single() -> Self {
        Pieces {
            basis: None,
            change: DMatrix::from_element(1, 1, Dd::ONE),
            places: vec![nalgebra::DVector::from_element(1, Dd::ONE)],
        }
    }

    fn new(mapping: Mapping, [low, high]: [f64; 2], degree: usize, count: usize) -> Option<Self> {
        let place = |k: usize, of: usize| match k {
            0 => low,
            _ if k == of => high,
            _ => {
                let share = 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / of as f64).cos();
                low * (1.0 - share) + high * share
            }
        };
        // a constant becomes linear: nothing draws surfaces of degree 0
        let raised = degree.max(1);
        let breaks: Vec<f64> = (0..=count).map(|k| place(k, count)).collect();
        let mut knots = vec![low; raised + 1];
        breaks[1..count].iter().for_each(|at| knots.extend(std::iter::repeat_n(*at, raised)));
        knots.extend(std::iter::repeat_n(high, raised + 1));
        let mut change = DMatrix::from_element(count * raised + 1, degree + 1, Dd::ZERO);
        for (k, ends) in breaks.windows(2).enumerate() {
            let piece = bernstein::of_chebyshev(mapping, [ends[0], ends[1]], raised);
            change.view_mut((k * raised, 0), (raised + 1, degree + 1)).copy_from(&piece.columns(0, degree + 1));
        }
        let values = |k: usize| {
            let mut row = vec![Dd::ZERO; degree + 1];
            chebyshev_values(mapping.map::<Dd>(place(k, raised + 1)), &mut row);
            nalgebra::DVector::from_vec(row)
        };
        Some(Pieces {
            basis: Some(BSplineBasis::new(raised, knots).ok()?),
            change,
            places: (0..=raised + 1).map(values).collect(),
        })
    }

    fn controls(&self, coefficients: &DMatrix<Dd>) -> DMatrix<Dd> {
        &self.change * coefficients
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flankfit_geometry::curve::Curve;

    /// T₂₅ alone has Bernstein coefficients of 2e7 over the whole interval: it comes in pieces,
    /// which hold it to the digits of double.
    #[test]
    fn swings_of_a_high_degree_are_cut_into_pieces() {
        let mut net = DMatrix::from_element(26, 1, Dd::ZERO);
        net[(25, 0)] = Dd::ONE;
        let found = curve(Mapping::over(-1.0, 1.0), [-1.0, 1.0], &net);
        let Some(Shape::Curve(CurveShape::BSpline(curve))) = found else { panic!("a curve") };
        let pieces = curve.breaks().len() - 1;
        assert!((2..=12).contains(&pieces), "{pieces}");
        for k in 0..=400 {
            let t = -1.0 + f64::from(k) / 200.0;
            let expected = (25.0 * t.acos()).cos();
            assert!((curve.value(t).x - expected).abs() < 4e-14, "{t}: {} {expected}", curve.value(t).x);
        }
    }

    #[test]
    fn a_smooth_polynomial_is_one_piece_and_a_place_has_none() {
        let smooth = DMatrix::from_fn(13, 1, |j, _| Dd::from(0.3_f64.powi(j as i32)));
        let Some(Shape::Curve(found)) = curve(Mapping::over(30.0, 34.0), [30.0, 34.0], &smooth) else { panic!() };
        assert_eq!(found.breaks(), [30.0, 34.0]);
        assert_eq!(curve(Mapping::over(5.0, 5.0), [5.0, 5.0], &smooth), None);
    }
}
