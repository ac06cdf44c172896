//! The form of Newton: `p(x) = c₀ + c₁ (x − z₀) + c₂ (x − z₀)(x − z₁) + …` with divided differences
//! `c`.
//!
//! One node more costs O(n) and changes nothing of what is there, which is what the paper praises
//! divided differences for. A node that occurs m times carries the value and the derivatives below
//! order m (Hermite, Eqs. 3 and 4, with orders that may differ from node to node). Nodes keep the
//! order they came in. Differences are held in double-double, and so is evaluation: in an unlucky
//! order the terms are far larger than the sum.

use super::{CurveJet, check};
use crate::space::Vector;
use flankfit_numerics::{Dd, Real, cancel, check::Faults};

/// The highest order of a derivative that can be given at a node.
pub const HIGHEST_ORDER: usize = 20;

/// Products of distances above this, or below its reciprocal, have lost digits of a double-double.
const LARGEST_PRODUCT: f64 = 1e270;

/// A polynomial in Newton's form.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Newton {
    nodes: Vec<f64>,
    differences: Vec<[Dd; 3]>,
    /// How many coordinates are not 0 throughout; the others cost no work.
    coordinates: usize,
}

/// The number of coordinates up to the last that is not 0.
fn coordinates(difference: &[Dd; 3]) -> usize {
    difference.iter().rposition(|c| c.hi != 0.0).map_or(0, |k| k + 1)
}

impl Newton {
    /// The polynomial with these nodes and divided differences, as many of the one as of the other.
    pub fn of_differences(nodes: Vec<f64>, differences: Vec<[Dd; 3]>) -> Self {
        debug_assert_eq!(nodes.len(), differences.len());
        let coordinates = differences.iter().map(coordinates).max().unwrap_or(0);
        Newton { nodes, differences, coordinates }
    }

    /// The nodes in the order in which they came, each as often as it has conditions.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The divided differences over the first node, the first two, and so on; three coordinates
    /// each.
    pub fn differences(&self) -> &[[Dd; 3]] {
        &self.differences
    }

    /// How many conditions the polynomial meets: its degree + 1.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is no condition yet.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds a condition at `node` in O(n): its value where it is new, its m-th derivative where it
    /// occurs m times already.
    pub fn push(&mut self, node: f64, datum: Vector) -> Result<(), Faults> {
        cancel::checkpoint();
        let index = self.nodes.len();
        let order = self.nodes.iter().filter(|z| **z == node).count();
        if order > HIGHEST_ORDER {
            return Err(check::too_many_derivatives(index, order, HIGHEST_ORDER));
        }
        let mut product = Dd::ONE;
        let mut factorial = 1.0;
        for k in 1..=order {
            factorial *= k as f64;
        }
        for z in self.nodes.iter().filter(|z| **z != node) {
            product *= Dd::diff(node, *z);
        }
        let size = product.hi.abs();
        if !(size < LARGEST_PRODUCT && size > LARGEST_PRODUCT.recip()) {
            return Err(check::not_representable(index));
        }
        let mut taylor = [[Dd::ZERO; 3]; HIGHEST_ORDER + 1];
        self.taylor(node, &mut taylor[..=order]);
        let mut difference = [Dd::ZERO; 3];
        for k in 0..3 {
            difference[k] = (Dd::from(datum[k]) / factorial - taylor[order][k]) / product;
        }
        if !difference.iter().all(|c| c.is_finite()) {
            return Err(check::not_representable(index));
        }
        self.coordinates = self.coordinates.max(coordinates(&difference));
        self.nodes.push(node);
        self.differences.push(difference);
        Ok(())
    }

    /// Coefficients of the polynomial in powers of `x − at`, from the lowest, as many as `out` has
    /// entries.
    pub fn taylor<T: Real>(&self, at: f64, out: &mut [[T; 3]]) {
        out.fill([T::zero(); 3]);
        for (z, c) in self.nodes.iter().zip(&self.differences).rev() {
            let distance = T::of_dd(Dd::diff(at, *z));
            for j in (0..out.len()).rev() {
                for k in 0..self.coordinates {
                    let below = if j == 0 { T::of_dd(c[k]) } else { out[j - 1][k] };
                    out[j][k] = out[j][k].fma(distance, below);
                }
            }
        }
    }

    /// Value and derivatives to order 3, computed in the precision of `T`.
    pub fn jet<T: Real>(&self, t: f64) -> CurveJet {
        let mut taylor = [[T::zero(); 3]; 4];
        self.taylor(t, &mut taylor);
        let vector = |c: [T; 3], factor: f64| Vector::from(c.map(|x| x.mul_f64(factor).to_f64()));
        [vector(taylor[0], 1.0), vector(taylor[1], 1.0), vector(taylor[2], 2.0), vector(taylor[3], 6.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_added_one_by_one_in_any_order() {
        // p = x³ − 2x: p(2) = 4, p(0) = 0, p′(2) = 10, p″(2) = 12
        let mut newton = Newton::default();
        for (node, datum) in [(2.0, 4.0), (0.0, 0.0), (2.0, 10.0), (2.0, 12.0)] {
            newton.push(node, Vector::new(datum, 0.0, -datum)).unwrap();
        }
        for t in [-1.0, 0.0, 0.3, 2.0, 2.0000001] {
            let [p, d, dd, ddd] = newton.jet::<Dd>(t);
            assert!((p.x - (t * t * t - 2.0 * t)).abs() < 1e-15 * (1.0 + p.x.abs()) && p.z == -p.x);
            assert!((d.x - (3.0 * t * t - 2.0)).abs() < 1e-14 && (dd.x - 6.0 * t).abs() < 1e-14 && ddd.x == 6.0);
        }
    }

    #[test]
    fn invalid_input_is_refused() {
        let mut newton = Newton::default();
        for _ in 0..=HIGHEST_ORDER {
            newton.push(1.0, Vector::zeros()).unwrap();
        }
        assert!(newton.push(1.0, Vector::zeros()).unwrap_err().to_string().contains("derivatives are given"));
        let mut newton = Newton::default();
        newton.push(0.0, Vector::zeros()).unwrap();
        assert_eq!(newton.push(1e-280, Vector::x()), Err(check::not_representable(1)));
    }
}
