//! Bounds of rounding errors of the passes over the nodes, known before they run.
//!
//! Errors are counted in u², u = 2⁻⁵³. A sum of two double-doubles errs by 3u² of the result, a
//! product by 5u², a product with a double by 2u² (Joldes, Muller and Popescu, 2017).
//!
//! **Running sums** ([`flankfit_numerics::lanes::Lanes::accumulate`]) of N products aᵢbᵢ. High
//! parts are exact: `hᵢ + eᵢ = hᵢ₋₁ + aᵢbᵢ` with |eᵢ| ≤ u|hᵢ| ≤ uΣ|ab|. The low part of a step is
//! at most `u|hᵢ| + 3u|aᵢbᵢ|`; its three operations err by u of that each, the product of the low
//! parts that is left out is u²|aᵢbᵢ|, and adding it errs by u of the low part so far. In total
//! `u²(N²/2 + 7N + 10) Σ|ab|` ([`running`] is above).
//!
//! **Chebyshev polynomials** of |t| ≤ 1 + θ: the computed ones obey the recurrence up to 14u² a
//! step (moduli up to 1.01), errors are carried on by Uₖ ≤ k + 1, the error 2u² of t by |Tₙ′| ≤ n².
//! In total 16n²u². [`on_unit`] makes |Tₙ| ≤ cosh(n√(2θ)) ≤ 1.01.
//!
//! **Underflow.** Numbers are in a range ([`in_range`]) in which all that underflow can leave is
//! far below the difference between these bounds and the sharp ones.

use crate::{
    data::Sample,
    design::{Axis, Basis, Design, bounding_box, tile::TILE},
    factor::CHUNK,
};
use flankfit_geometry::Mapping;
use flankfit_numerics::{ball::ROUNDING, lanes::LANES};

/// u².
pub(super) const UNIT: f64 = ROUNDING / 8.0;
/// Most that Chebyshev polynomials may exceed 1 by, and products of two.
const LARGEST: f64 = 1.01 * 1.01;

/// Error of a running sum of products over Σ|ab|, in u².
pub(super) fn running(terms: usize) -> f64 {
    let n = terms as f64;
    n * n + 8.0 * n + 16.0
}

/// Error of the Chebyshev polynomials of an axis, in u².
pub(super) fn polynomials(size: usize) -> f64 {
    16.0 * ((size - 1) as f64).powi(2)
}

/// True if the columns are polynomials or posted ones.
pub(super) fn is_exact(design: &Design) -> bool {
    let smooth = |axis: &Axis| matches!(axis, Axis::Polynomial { .. });
    match &design.basis {
        Basis::Product { u, v } => smooth(u) && smooth(v) && design.rational.is_none(),
        Basis::Columns { .. } => true,
    }
}

/// True for 0 and for sizes whose squares and products with ε² are far from the ends of the range
/// of double.
pub(super) fn in_range(size: f64) -> bool {
    size == 0.0 || (1e-90..1e90).contains(&size)
}

/// True for sums of weights in range.
pub(super) fn weight_in_range(weight: f64) -> bool {
    (1e-60..1e60).contains(&weight)
}

/// True if Chebyshev polynomials up to `degree` do not exceed 1.01 where `mapping` puts the box.
pub(super) fn on_unit(mapping: Mapping, [low, high]: [f64; 2], degree: usize) -> bool {
    let farthest = ((low - mapping.center).abs()).max((high - mapping.center).abs()) * mapping.scale;
    // the rounding of this line is 4u
    let excess = (farthest * (1.0 + 2.0 * f64::EPSILON) - 1.0).max(0.0);
    in_range(mapping.scale) && (degree as f64).powi(2) * 2.0 * excess <= 0.01
}

/// Bounds of the passes over scattered nodes, weighted ones, and rows of a matrix.
pub(super) struct Rounding {
    /// Greatest modulus of an entry of W.
    pub largest: f64,
    /// Error of an entry of W.
    pub entry: f64,
    /// Error of a residual, over `max |z| + largest · Σ|c|`.
    pub residual: f64,
    /// Error of an entry of `WᵀΩr`, over `Σ w|r|`.
    pub projection: f64,
    /// Relative error of `Σ w r²`.
    pub squares: f64,
    /// Error of an entry of `WᵀΩW` from moments, over Σw; infinite where there are none.
    pub moments: f64,
    /// Error of a sum of products over the nodes by running sums, over the sum of moduli.
    pub sum: f64,
}

impl Rounding {
    /// `None` where nothing is proved of these columns.
    pub(super) fn new(design: &Design, sample: &Sample) -> Option<Self> {
        let m = sample.count();
        let (chunk, chunks) = (m.min(CHUNK), 4.0 * m.div_ceil(CHUNK) as f64);
        // terms of a running sum, and the sums of four lanes and of chunks
        let terms = TILE / LANES * chunk.div_ceil(TILE);
        let sum = 1.1 * running(terms) + 32.0 + chunks;
        let squares = 4.0 * chunk as f64 + 64.0 + chunks;
        match &design.basis {
            Basis::Columns { scale } => {
                let n = scale.len() as f64;
                // columns are divided by the power of 2 below their largest entry
                scale.iter().all(|&scale| in_range(scale)).then_some(Rounding {
                    largest: 2.0,
                    entry: 0.0,
                    residual: UNIT * (8.0 * n + 16.0),
                    projection: UNIT * 2.2 * (3.0 * chunk as f64 + 16.0 + chunks),
                    squares: UNIT * squares,
                    moments: f64::INFINITY,
                    sum: UNIT * sum,
                })
            }
            Basis::Product {
                u: Axis::Polynomial { mapping: on_u, size: p, .. },
                v: Axis::Polynomial { mapping: on_v, size: q, .. },
            } => {
                let (box_u, box_v) = bounding_box(sample);
                let sound = on_unit(*on_u, box_u, 2 * (p - 1)) && on_unit(*on_v, box_v, 2 * (q - 1));
                let entry = 1.1 * (polynomials(*p) + polynomials(*q)) + 8.0;
                // degrees of moments are twice those of the columns
                let moment = 1.1 * (polynomials(2 * p - 1) + polynomials(2 * q - 1)) + 16.0;
                sound.then(|| Rounding {
                    largest: LARGEST,
                    entry: UNIT * entry,
                    residual: UNIT * (1.2 * (running(*p) + running(*q)) + 1.1 * entry),
                    projection: UNIT * 1.1 * (sum + entry),
                    squares: UNIT * squares,
                    moments: UNIT * 1.1 * (sum + moment),
                    sum: UNIT * sum,
                })
            }
            Basis::Product { .. } => None,
        }
    }
}
