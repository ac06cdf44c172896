//! B-spline curves of any degree through points.
//!
//! As many basis functions as points; row i of the collocation matrix holds the functions at
//! parameter i, of which degree + 1 are not 0. It has an inverse exactly where every parameter lies
//! inside the support of its function (Schoenberg and Whitney), which is checked first. The band is
//! factored in double-double.

use super::{BSplineCurve, check, cubic_hermite, knots};
use crate::{
    BSplineBasis,
    space::{Dimension, HIGHEST_DEGREE, Vector},
};
use flankfit_numerics::{Banded, BandedLu, Dd, cancel::Asking, check::Faults, words::Shown};

/// Which knots an interpolating B-spline has.
#[derive(Clone, Debug, PartialEq)]
pub enum KnotChoice {
    /// All of them: as many as there are points, and degree + 1 more.
    Given(Vec<f64>),
    /// Means of neighbouring parameters ([`knots::averaging`]).
    Averaging,
    /// The parameters themselves but for those next to the ends ([`knots::not_a_knot`]).
    NotAKnot,
}

/// Why equations of interpolation have no single solution.
#[derive(Clone, Debug, PartialEq)]
pub enum NoCollocation {
    /// Nodes or knots are refused.
    Invalid(Faults),
    /// A node outside of the support of its basis function (condition of Schoenberg and Whitney).
    Unsupported {
        /// Index of the node, of its basis function and of the first knot of the support, from 0.
        node: usize,
        /// Abscissa or parameter of the node.
        value: f64,
        /// Index of the last knot of the support.
        until: usize,
        /// Lower end of the support.
        low: f64,
        /// Upper end of the support.
        high: f64,
    },
    /// The equations are singular in double-double precision.
    Singular {
        /// Index of the unknown without a pivot, from 0.
        index: usize,
    },
}

impl From<Faults> for NoCollocation {
    fn from(faults: Faults) -> Self {
        NoCollocation::Invalid(faults)
    }
}

impl From<NoCollocation> for Faults {
    fn from(none: NoCollocation) -> Self {
        match none {
            NoCollocation::Invalid(faults) => faults,
            NoCollocation::Unsupported { node, value, until, low, high } => {
                let [at, low, high] = [value, low, high].map(Shown);
                Faults::one(
                    format_args!("method.knots[{node}]"),
                    format_args!(
                        "node {node} (at {at}) does not lie inside the support of its basis function, knots {node} to \
                         {until} ({low} to {high}): the condition of Schoenberg and Whitney"
                    ),
                )
            }
            NoCollocation::Singular { index } => check::singular(index),
        }
    }
}

/// The equations of interpolation over one axis, factored: to be solved for many right sides.
#[derive(Clone, Debug)]
pub struct Collocation {
    basis: BSplineBasis,
    matrix: Banded<Dd>,
    lu: BandedLu<Dd>,
}

impl Collocation {
    /// Checks and factors the equations for a basis with as many functions as there are ascending
    /// parameters.
    pub fn new(basis: BSplineBasis, parameters: &[f64]) -> Result<Self, NoCollocation> {
        check::ascending("nodes", parameters)?;
        check::count("method.knots", basis.knots().len(), parameters.len() + basis.degree() + 1)?;
        schoenberg_whitney(&basis, parameters)?;
        let p = basis.degree();
        let reach = p.min(parameters.len() - 1);
        let mut matrix = Banded::zeros(parameters.len(), reach, reach);
        let mut values = [Dd::ZERO; HIGHEST_DEGREE + 1];
        for (i, t) in parameters.iter().enumerate().asking(200) {
            let first = basis.values(*t, &mut values[..=p]);
            for (j, value) in values[..=p].iter().enumerate() {
                // at a knot one function of the span is 0 and lies outside of the band
                if (first + j).abs_diff(i) <= reach {
                    matrix.set(i, first + j, *value);
                }
            }
        }
        let lu = matrix.clone().factor().map_err(|fault| NoCollocation::Singular { index: fault.column })?;
        Ok(Collocation { basis, matrix, lu })
    }

    /// Turns values at the parameters into coefficients, in place.
    pub fn solve(&self, values: &mut [Dd]) {
        self.lu.solve(values);
    }

    /// The basis that the coefficients belong to.
    pub fn basis(&self) -> &BSplineBasis {
        &self.basis
    }

    /// Functions (columns) at the parameters (rows).
    pub fn matrix(&self) -> &Banded<Dd> {
        &self.matrix
    }

    /// Coefficients of the points `values`, each coordinate for itself.
    pub fn control_points(&self, values: &[Vector]) -> Result<Vec<Vector>, Faults> {
        let mut points = vec![Vector::zeros(); values.len()];
        for k in 0..3 {
            let mut one: Vec<Dd> = values.iter().map(|v| Dd::from(v[k])).collect();
            self.solve(&mut one);
            for (index, (point, x)) in points.iter_mut().zip(&one).enumerate() {
                if !x.hi.is_finite() {
                    return Err(check::not_representable(index));
                }
                point[k] = x.to_f64();
            }
        }
        Ok(points)
    }
}

/// Each parameter lies inside the support of the function of its number, or where an end of the
/// support is no end of the function.
fn schoenberg_whitney(basis: &BSplineBasis, parameters: &[f64]) -> Result<(), NoCollocation> {
    let (p, knots) = (basis.degree(), basis.knots());
    let (low, high) = basis.domain();
    for (node, &value) in parameters.iter().enumerate() {
        if !(low <= value && value <= high) {
            let [at, low, high] = [value, low, high].map(Shown);
            return Err(NoCollocation::Invalid(Faults::one(
                format_args!("nodes[{node}]"),
                format_args!("node {node} (at {at}) is not within the domain [{low}, {high}] of the knots"),
            )));
        }
        let (first, last) = (knots[node], knots[node + p + 1]);
        let inside = first < value && value < last;
        let starts = value == first && knots[node + p] == first && value < last;
        let ends = value == last && knots[node + 1] == last && value == high;
        if !(inside || starts || ends) {
            return Err(NoCollocation::Unsupported { node, value, until: node + p + 1, low: first, high: last });
        }
    }
    Ok(())
}

/// The knots that a choice means for these parameters.
pub fn chosen_knots(degree: usize, parameters: &[f64], choice: &KnotChoice) -> Result<BSplineBasis, Faults> {
    check::degree("method.degree", degree, 1, HIGHEST_DEGREE)?;
    check::nodes_of_degree("method.degree", degree, parameters.len(), degree + 1)?;
    let knots = match choice {
        KnotChoice::Given(knots) => {
            check::count("method.knots", knots.len(), parameters.len() + degree + 1)?;
            knots.clone()
        }
        KnotChoice::Averaging => knots::averaging(degree, parameters)?,
        KnotChoice::NotAKnot => knots::not_a_knot(degree, parameters)?,
    };
    BSplineBasis::new(degree, knots).map_err(|faults| faults.within("method.knots"))
}

/// The B-spline of this degree through `values` at the ascending `parameters`.
///
/// ```
/// use flankfit_geometry::{
///     curve::{Curve, KnotChoice, interpolate},
///     space::{Dimension, Vector},
/// };
///
/// // Degree 2 holds every parabola: x² − x at 4 nodes.
/// let nodes = [0.0, 1.0, 2.0, 4.0];
/// let values = nodes.map(|x| Vector::new(x * x - x, 0.0, 0.0));
/// let curve = interpolate(Dimension::Graph, &nodes, &values, 2, &KnotChoice::Averaging)?;
/// assert!((curve.value(3.0).x - 6.0).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn interpolate(
    dimension: Dimension,
    parameters: &[f64],
    values: &[Vector],
    degree: usize,
    choice: &KnotChoice,
) -> Result<BSplineCurve, Faults> {
    cubic_hermite::check(parameters, values)?;
    let collocation = Collocation::new(chosen_knots(degree, parameters, choice)?, parameters)?;
    let points = collocation.control_points(values)?;
    BSplineCurve::new(collocation.basis, dimension, points, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;

    #[test]
    fn every_degree_passes_through_its_points() {
        let t: Vec<f64> = (0..30).map(|i| f64::from(i) + 0.3 * f64::from(i).sin()).collect();
        let values: Vec<Vector> = t.iter().map(|t| Vector::new(t.cos(), t.sin(), *t)).collect();
        for degree in [1, 2, 3, 4, 5, 10, 25] {
            for choice in [KnotChoice::Averaging, KnotChoice::NotAKnot] {
                let curve = interpolate(Dimension::Space, &t, &values, degree, &choice).unwrap();
                for (t, value) in t.iter().zip(&values) {
                    let miss = (curve.value(*t) - value).amax();
                    assert!(miss < 1e-12, "{degree} {choice:?} {t} {miss:e}");
                }
            }
        }
    }

    #[test]
    fn invalid_input_is_refused() {
        let t = [0.0, 1.0, 2.0, 3.0];
        let values = t.map(|t| Vector::new(t * t, 0.0, 0.0));
        let new = |degree, knots: &[f64]| {
            interpolate(Dimension::Graph, &t, &values, degree, &KnotChoice::Given(knots.to_vec())).unwrap_err()
        };
        let message = |degree, knots: &[f64]| new(degree, knots).to_string();
        assert!(message(3, &[0., 0., 3., 3.]).contains("where 8 are needed"));
        assert!(message(4, &[0.0; 9]).contains("at least 5 nodes, 4 are given"));
        assert!(message(0, &[0.0; 5]).contains("degree 0 is not within"));
        assert_eq!(new(1, &[0., 0., 1., 0.5, 3., 3.]).list()[0].path, "method.knots[3]");
        // the knots 2.5 and 2.8 leave the second and third node without a function of theirs
        let fault = new(1, &[0., 0., 2.5, 2.8, 3., 3.]);
        assert_eq!(fault.list()[0].path, "method.knots[2]");
        assert!(fault.to_string().contains("node 2 (at 2) does not lie inside the support"), "{fault}");
        let fault = new(1, &[0.5, 0.5, 1., 2., 3., 3.]);
        assert_eq!(fault.list()[0].path, "nodes[0]");
        assert!(fault.to_string().contains("node 0 (at 0) is not within the domain"), "{fault}");
    }
}
