//! One polynomial over the whole domain: through points (Lagrange, Newton) and with given
//! derivatives (Hermite).
//!
//! The paper warns of its oscillation, which grows with the degree; [`super::stability`] says how
//! much. Nodes may come in any order; none is moved. The domain reaches from the least to the
//! greatest node.

use super::{
    Curve, CurveJet,
    barycentric::Barycentric,
    check,
    newton::{HIGHEST_ORDER, Newton},
};
use crate::space::{Dimension, Vector};
use flankfit_numerics::{Dd, check::Faults, words::Shown};

/// The most conditions that one polynomial has to meet.
pub const MOST_CONDITIONS: usize = 500;

/// How far, in parts of the largest value, a polynomial may miss its nodes.
const MISS: f64 = 1e-10;

/// A polynomial curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    dimension: Dimension,
    domain: [f64; 2],
    form: Form,
}

/// How a polynomial is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Nodes, weights and values.
    Barycentric(Barycentric),
    /// Nodes and divided differences.
    Newton(Newton),
}

impl Polynomial {
    /// Through `values` at `nodes`, in the barycentric form of Lagrange (Eqs. 1 and 2).
    pub fn lagrange(dimension: Dimension, nodes: Vec<f64>, values: Vec<Vector>) -> Result<Self, Faults> {
        check(&nodes, "values", values.len())?;
        distinct(&nodes)?;
        check::points("values", &values)?;
        let domain = range(&nodes);
        Ok(Polynomial { dimension, domain, form: Form::Barycentric(Barycentric::new(nodes, values)?) })
    }

    /// Through `values` at `nodes`, in the form of Newton.
    pub fn newton(dimension: Dimension, nodes: &[f64], values: &[Vector]) -> Result<Self, Faults> {
        let data: Vec<Vec<Vector>> = values.iter().map(|v| vec![*v]).collect();
        Self::hermite(dimension, nodes, &data)
    }

    /// With the value and then the derivatives `data[i]` at node i, of as many orders as are given
    /// there (Eqs. 3 and 4 for one each).
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     curve::{Curve, Polynomial},
    ///     space::{Dimension, Vector},
    /// };
    ///
    /// // From 0 to 1 with slope 0 at both ends: 3x² − 2x³.
    /// let [zero, one] = [0.0, 1.0].map(|y| Vector::new(y, 0.0, 0.0));
    /// let data = [vec![zero, zero], vec![one, zero]];
    /// let polynomial = Polynomial::hermite(Dimension::Graph, &[0.0, 1.0], &data)?;
    /// assert_eq!(polynomial.value(0.25).x, 0.15625);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn hermite(dimension: Dimension, nodes: &[f64], data: &[Vec<Vector>]) -> Result<Self, Faults> {
        check(nodes, "values", data.len())?;
        distinct(nodes)?;
        let conditions: usize = data.iter().map(Vec::len).sum();
        check::at_most("method.derivatives", conditions, MOST_CONDITIONS)?;
        for (node, data) in data.iter().enumerate() {
            if data.is_empty() {
                check::count("values", 0, 1)?;
            }
            if data.len() > HIGHEST_ORDER + 1 {
                return Err(check::too_many_derivatives(node, data.len() - 1, HIGHEST_ORDER));
            }
            if let Some(order) = data.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
                return Err(match order {
                    0 => check::not_finite("values", node),
                    _ => Faults::one(
                        format_args!("method.derivatives[{node}][{}]", order - 1),
                        format_args!("number {} at node {node} is not finite", order - 1),
                    ),
                });
            }
        }
        let mut newton = Newton::default();
        for (node, data) in nodes.iter().zip(data) {
            for datum in data {
                newton.push(*node, *datum)?;
            }
        }
        let polynomial = Polynomial { dimension, domain: range(nodes), form: Form::Newton(newton) };
        polynomial.verify(nodes, data)?;
        Ok(polynomial)
    }

    /// The polynomial with these nodes (each repeated for every condition) and divided differences.
    pub fn of_differences(dimension: Dimension, nodes: Vec<f64>, differences: Vec<[Dd; 3]>) -> Result<Self, Faults> {
        check(&nodes, "coefficients", differences.len())?;
        if let Some(index) = differences.iter().position(|c| !c.iter().all(|x| x.is_finite())) {
            return Err(check::not_finite("coefficients", index));
        }
        let domain = range(&nodes);
        if !(domain[0] < domain[1]) {
            return Err(check::repeated("nodes", 1, 0, nodes[0]));
        }
        Ok(Polynomial { dimension, domain, form: Form::Newton(Newton::of_differences(nodes, differences)) })
    }

    /// How many conditions the polynomial meets; its degree is one less, or lower where the data
    /// happen to lie so.
    pub fn conditions(&self) -> usize {
        match &self.form {
            Form::Barycentric(form) => form.nodes().len(),
            Form::Newton(form) => form.len(),
        }
    }

    /// How the polynomial is written.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// Coefficients in powers of `x − at`, from the lowest, in double-double.
    pub fn powers(&self, at: f64) -> Vec<[Dd; 3]> {
        let mut powers = vec![[Dd::ZERO; 3]; self.conditions()];
        match &self.form {
            Form::Newton(newton) => newton.taylor(at, &mut powers),
            Form::Barycentric(form) => {
                let (newton, exponent) = form.scaled_newton();
                newton.taylor(flankfit_numerics::dd::ldexp(at, exponent), &mut powers);
                for (k, c) in powers.iter_mut().enumerate() {
                    *c = c.map(|x| x.ldexp(exponent * k as i32));
                }
            }
        }
        powers
    }

    /// Whether even double-double could not hold what the order of the nodes asks for.
    fn verify(&self, nodes: &[f64], data: &[Vec<Vector>]) -> Result<(), Faults> {
        let largest = data.iter().filter_map(|d| d.first()).fold(0.0f64, |m, v| m.max(v.amax()));
        for (index, (node, data)) in nodes.iter().zip(data).enumerate() {
            let miss = data.first().map_or(0.0, |v| (self.value(*node) - v).amax());
            if !(miss <= MISS * largest) {
                return Err(Faults::one(
                    "values",
                    format_args!(
                        "in double-double precision the polynomial still misses node {index} by {}: too many nodes in \
                         this order; use the barycentric form or a spline",
                        Shown(miss)
                    ),
                ));
            }
        }
        Ok(())
    }
}

fn range(nodes: &[f64]) -> [f64; 2] {
    nodes.iter().fold([f64::MAX, f64::MIN], |[l, h], x| [l.min(*x), h.max(*x)])
}

fn check(nodes: &[f64], list: &str, values: usize) -> Result<(), Faults> {
    check::at_least("nodes", nodes.len(), 2)?;
    check::at_most("nodes", nodes.len(), MOST_CONDITIONS)?;
    check::count(list, values, nodes.len())?;
    check::finite("nodes", nodes)
}

/// Refuses a node that occurs twice, in whatever order the nodes come.
fn distinct(nodes: &[f64]) -> Result<(), Faults> {
    for (index, value) in nodes.iter().enumerate() {
        if let Some(first) = nodes[..index].iter().position(|x| x == value) {
            return Err(check::repeated("nodes", index, first, *value));
        }
    }
    Ok(())
}

impl Curve for Polynomial {
    fn dimension(&self) -> Dimension {
        self.dimension
    }

    fn domain(&self) -> [f64; 2] {
        self.domain
    }

    fn jet(&self, t: f64) -> CurveJet {
        match &self.form {
            Form::Barycentric(form) => form.jet(t),
            Form::Newton(form) => form.jet::<Dd>(t),
        }
    }

    fn breaks(&self) -> Vec<f64> {
        self.domain.to_vec()
    }

    fn value(&self, t: f64) -> Vector {
        match &self.form {
            Form::Barycentric(form) => form.value(t),
            Form::Newton(form) => {
                let mut value = [[Dd::ZERO; 3]];
                form.taylor(t, &mut value);
                Vector::from(value[0].map(Dd::to_f64))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(y: &[f64]) -> Vec<Vector> {
        y.iter().map(|y| Vector::new(*y, 0.0, 0.0)).collect()
    }

    #[test]
    fn both_forms_are_one_polynomial_in_any_order() {
        let (x, y) = ([3.0, -1.0, 0.5, 2.0], graph(&[1.0, 2.0, -1.0, 0.25]));
        let lagrange = Polynomial::lagrange(Dimension::Graph, x.to_vec(), y.clone()).unwrap();
        let newton = Polynomial::newton(Dimension::Graph, &x, &y).unwrap();
        assert_eq!((lagrange.domain(), newton.domain()), ([-1.0, 3.0], [-1.0, 3.0]));
        for t in [-1.0, -0.9, 0.5, 0.5 + 1e-13, 1.7, 3.0] {
            for (a, b) in lagrange.jet(t).iter().zip(newton.jet(t)) {
                assert!((a - b).amax() < 2e-14 * b.amax().max(1.0), "{t} {a} {b}");
            }
            let powers = lagrange.powers(t);
            assert!((powers[1][0].to_f64() - newton.jet(t)[1].x).abs() < 1e-13);
        }
    }

    #[test]
    fn invalid_input_is_refused() {
        let new = |x: &[f64], y: &[f64]| Polynomial::lagrange(Dimension::Graph, x.to_vec(), graph(y)).unwrap_err();
        let message = |x: &[f64], y: &[f64]| new(x, y).to_string();
        assert_eq!(message(&[1.0], &[1.0]), "nodes: 1 is too few: at least 2 are needed");
        assert_eq!(message(&[1.0, 2.0], &[1.0]), "values: 1 is given where 2 are needed");
        assert_eq!(message(&[1.0, 2.0, 1.0], &[1.0; 3]), "nodes[2]: number 2 (1) repeats number 0");
        assert_eq!(message(&[1.0, 2.0, 3.0], &[1.0, f64::NAN, 1.0]), "values[1]: number 1 is not finite");
        assert_eq!(message(&[1.0, f64::INFINITY], &[1.0, 1.0]), "nodes[1]: number 1 is not finite");
        assert_eq!(message(&[0.0; 501], &[0.0; 501]), "nodes: 501 are too many: at most 500 are possible");
        let hermite =
            |data: &[Vec<Vector>]| Polynomial::hermite(Dimension::Graph, &[0.0, 1.0], data).unwrap_err().to_string();
        let fault = hermite(&[graph(&[1.0, 2.0]), graph(&[1.0, f64::NAN])]);
        assert_eq!(fault, "method.derivatives[1][0]: number 0 at node 1 is not finite");
        let fault = hermite(&[graph(&[0.0; 22]), graph(&[1.0])]);
        assert_eq!(fault, "method.derivatives[0]: 21 derivatives are given at node 0, more than 20");
    }

    /// A hundred and fifty nodes in ascending order exceed double-double, and are said to.
    #[test]
    fn an_order_that_cannot_be_held_is_refused() {
        let x: Vec<f64> = (0..150).map(|i| f64::from(i) / 10.0).collect();
        let y = graph(&x.iter().map(|x| (3.0 * x).sin()).collect::<Vec<_>>());
        assert!(Polynomial::newton(Dimension::Graph, &x[..40], &y[..40]).is_ok());
        let fault = Polynomial::newton(Dimension::Graph, &x, &y).unwrap_err();
        assert!(fault.to_string().contains("the polynomial still misses node"), "{fault}");
    }
}
