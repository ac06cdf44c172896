//! Scatter of coefficients with errors of positions.
//!
//! Rows of the settled problem are at estimated positions ξ̂, which scatter about the true ones:
//! `Cov ξ̂ₖ = Cₖ = σ²ρ²(I − ρ²Wₖgₖgₖᵀ)` in the notation of [`super::positions`]. The information
//! matrix `G = Σ W x xᵀ` takes that scatter for nodes that lie further apart, so that `σ²G⁻¹` is
//! too small. The true positions have the information `M = G − V`, `V = Σ W X′CX′ᵀ` with the slopes
//! X′ of a row, and the coefficients have the covariance `σ² M⁻¹ G M⁻¹`; of a line it is the one of
//! Fuller (Measurement Error Models, 1987, section 1.3).
//!
//! The expansion is of first order in the scatter. A surface that bends within it is off by half
//! its second derivative times C at each node, which shifts the coefficients by b; and weights hang
//! on slopes that are themselves uncertain. In simulation coefficients are off by once to twice b,
//! towards the side that the signs of the terms left out decide. So 2b counts as an error like
//! the others: the covariance is `σ² M⁻¹ G M⁻¹ + 4 b bᵀ`.

use nalgebra::DMatrix;

use super::positions::Settled;
use crate::{design::Design, factor::Factor};
use flankfit_numerics::{cancel::Asking, dot, symmetric, triangular};

/// Scatter above this share of the information is counted as so much.
const MOST: f64 = 0.9;
/// Greatest shift of coefficients by a bend, as a multiple of its first order.
const SHIFTED: f64 = 2.0;

/// The scatter of the positions as the coefficients feel it.
pub(crate) struct Scatter {
    /// A root of the covariance in Q's coordinates, the bend in its last column.
    pub root: DMatrix<f64>,
    /// The largest share of the information along any direction that is scatter.
    pub share: f64,
    /// Greatest shift of a sum of coefficients by the bend, in standard errors.
    pub bend: f64,
    /// Relative standard error of the weights, in the root mean square.
    pub weights: f64,
}

/// Scatter of a converged problem with this factor; `places` are by counted node.
pub(crate) fn scatter(
    design: &Design,
    factor: &Factor,
    settled: &Settled,
    ratio: f64,
    noise_sigma: Option<f64>,
) -> Option<Scatter> {
    let n = design.size();
    let free = settled.places.len().checked_sub(n).filter(|free| *free > 0);
    let sigma = noise_sigma.or_else(|| Some((factor.rss / free? as f64).sqrt())).filter(|sigma| *sigma > 0.0)?;
    let coefficients: Vec<f64> = factor.working.as_ref()?.iter().map(|x| x.to_f64()).collect();
    let r = factor.r.map(|x| x.to_f64());
    let mut scatter = DMatrix::<f64>::zeros(n, n);
    let mut shift = vec![0.0; n];
    for (&place, &weight) in settled.places.iter().zip(&settled.weights).asking(8 * n * n) {
        let [row, along_u, along_v] = design.tangent(place);
        let gradient = [dot(&along_u, &coefficients), dot(&along_v, &coefficients)];
        let mut bend = 0.0;
        for (direction, size) in axes(gradient, weight, ratio, sigma, design.domain?.v.is_some()) {
            let mut slope: Vec<f64> =
                along_u.iter().zip(&along_v).map(|(u, v)| size * (direction[0] * u + direction[1] * v)).collect();
            triangular::solve_upper_transposed(&r, &mut slope);
            add(&mut scatter, weight, &slope);
            let aside = |side: f64| [0, 1].map(|axis| place[axis] + side * size * direction[axis]);
            let value = |place: [f64; 2]| dot(&design.tangent(place)[0], &coefficients);
            // a spline ends with its domain
            if inside(design, aside(1.0)) && inside(design, aside(-1.0)) {
                bend += 0.5 * (value(aside(1.0)) + value(aside(-1.0)) - 2.0 * dot(&row, &coefficients));
            }
        }
        let mut row = row;
        triangular::solve_upper_transposed(&r, &mut row);
        shift.iter_mut().zip(&row).for_each(|(to, q)| *to += weight * q * bend);
    }
    let found = symmetric::eigen(scatter)?;
    let left: Vec<f64> = found.values.iter().map(|share| 1.0 - share.clamp(0.0, MOST)).collect();
    let mut root = DMatrix::from_fn(n, n, |i, j| found.vectors[(i, j)] * sigma / left[j]);
    let share = found.values.last().copied().unwrap_or(0.0);
    let weights = uncertain_weights(design, &r, settled, &coefficients, ratio, &root);
    let bend = dot(&shift, &shift).sqrt() / sigma;
    root = root.insert_column(n, 0.0);
    root.column_mut(n).iter_mut().zip(&shift).for_each(|(to, b)| *to = SHIFTED * b);
    Some(Scatter { root, share, bend, weights })
}

/// The weights `1/(1/w + ρ²‖g‖²)` have the relative error `2ρ²W gᵀδg`.
fn uncertain_weights(
    design: &Design,
    r: &DMatrix<f64>,
    settled: &Settled,
    coefficients: &[f64],
    ratio: f64,
    root: &DMatrix<f64>,
) -> f64 {
    let n = design.size();
    let mut sum = 0.0;
    for (&place, &weight) in settled.places.iter().zip(&settled.weights).asking(4 * n * n) {
        let [_, along_u, along_v] = design.tangent(place);
        let gradient = [dot(&along_u, coefficients), dot(&along_v, coefficients)];
        let mut steeper: Vec<f64> =
            along_u.iter().zip(&along_v).map(|(u, v)| gradient[0] * u + gradient[1] * v).collect();
        triangular::solve_upper_transposed(r, &mut steeper);
        let error = root.column_iter().map(|column| dot(column.as_slice(), &steeper).powi(2)).sum::<f64>().sqrt();
        sum += (2.0 * ratio * ratio * weight * error).powi(2);
    }
    (sum / settled.places.len() as f64).sqrt()
}

/// The principal directions of C with the roots of its eigenvalues.
fn axes([u, v]: [f64; 2], weight: f64, ratio: f64, sigma: f64, surface: bool) -> Vec<([f64; 2], f64)> {
    let steep = u.hypot(v);
    let across = sigma * ratio;
    let along = across * (1.0 - (ratio * steep).powi(2) * weight).max(0.0).sqrt();
    if !surface {
        return vec![([1.0, 0.0], along)];
    }
    let up = if steep > 0.0 { [u / steep, v / steep] } else { [1.0, 0.0] };
    vec![(up, along), ([-up[1], up[0]], across)]
}

fn inside(design: &Design, place: [f64; 2]) -> bool {
    let ends = design.domain.map(|domain| [domain.u, domain.v]).unwrap_or_default();
    place.iter().zip(ends).all(|(x, ends)| ends.is_none_or(|[low, high]| (low..=high).contains(x)))
}

/// Adds `weight · x xᵀ`.
fn add(to: &mut DMatrix<f64>, weight: f64, x: &[f64]) {
    for (j, &xj) in x.iter().enumerate() {
        to.column_mut(j).iter_mut().zip(x).for_each(|(to, xi)| *to += weight * xj * xi);
    }
}
