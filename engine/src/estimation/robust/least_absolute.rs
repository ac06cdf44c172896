//! Least absolute deviations and regression quantiles, solved exactly.
//!
//! With `rₖ = √wₖ (zₖ − xₖᵀA)`:
//! * least absolute deviations: ρ = |r|, ψ = sign r, weight 1/|r|; the limit of variationally
//!   weighted least squares (Mudrov and Kushko 1976), whose iterations never quite arrive, so it is
//!   found by [`super::vertex`];
//! * quantile τ (Koenker and Bassett 1978): ρ = r(τ − [r < 0]), ψ = τ − [r < 0]; τ = 1/2 is half
//!   the former. `2 Σ ρ = Σ|r| + (2τ − 1) Σ r`, which is the same walk with a linear part.
//!
//! ρ has the unit of the heights. The answer is a vertex: n nodes (or more) have residual 0. The
//! certificate is `max |dᵢ|` over them, in the form with `Σ|r|`; at most 1 proves that no
//! coefficients do better.
//!
//! Standard errors: `τ(1 − τ) f⁻² (XᵀX)⁻¹`, the sparsity 1/f being the difference quotient of the
//! residuals' quantiles over the bandwidth of Hall and Sheather (1988; Koenker 2005, section 3.4),
//! residuals of the vertex left out.

use super::{
    exact, normal,
    outcome::{Measured, Outcome, Solved},
    rows::{Rows, weighted_solution},
    scale::median_abs,
    vertex::{self, Lines, Vertex},
};
use crate::{
    estimation::{
        design::Row,
        error::{FitError, Unconverged},
        result::{LocalSolution, Warning},
    },
    numerics::{
        Dd,
        cancel::{self, Asking},
        qr_with_rhs, triangular,
    },
};

/// Reweightings that lead near the vertex before the walk begins.
const APPROACH: usize = 8;

/// Least absolute deviations.
pub(super) fn estimate(measured: &Measured) -> Result<Outcome, FitError> {
    solve(0.5, 1.0, measured)
}

/// Least `factor · Σ ρ_τ`.
pub(super) fn solve(tau: f64, factor: f64, measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let tilt = 2.0 * tau - 1.0;
    let mut g = vec![0.0; n];
    for q in rows.q.chunks_exact(n).asking(n) {
        g.iter_mut().zip(q).for_each(|(g, q)| *g -= tilt * q);
    }
    let lines = Lines { n, rows: &rows.q, b: &rows.b, g: &g };
    let vertex = vertex::minimise(&lines, &approach(&rows, tilt), vertex::most_steps(m * n))
        .ok_or(FitError::NotConverged(Unconverged::AbsoluteDeviations))?;
    let mut warnings = Vec::new();
    if !vertex.optimal {
        warnings.push(Warning::SimplexStopped(vertex.steps));
    }
    if !vertex.unique {
        warnings.push(Warning::SumNotUnique);
    }
    let mut residuals = rows.residuals(&vertex.x);
    for &k in &vertex.basis {
        residuals[k] = 0.0;
    }
    let density = sparsity(tau, &residuals, &vertex.basis);
    let scale = density.map(|s| (tau * (1.0 - tau)).sqrt() * s);
    let rho = |r: f64| 2.0 * r * if r < 0.0 { tau - 1.0 } else { tau };
    let settled = exact::settled(scale, scale.filter(|_| m > n), &residuals, measured.heights.largest, &mut warnings);
    let capped = |r: &f64| capped(rho(*r), *r, settled.scale.unwrap_or(0.0));
    let weights = settled.weights.unwrap_or_else(|| residuals.iter().map(capped).collect());
    let mut basis = vertex.basis.clone();
    basis.sort_unstable();
    Ok(Outcome {
        converged: vertex.optimal,
        iterations: vertex.steps,
        scale: settled.scale,
        objective: factor * residuals.iter().map(|r| rho(*r)).sum::<f64>(),
        weights,
        certificate: Some(vertex.certificate()),
        unique: Some(vertex.unique),
        vertex: Some(basis),
        dispersion: settled.dispersion,
        local: LocalSolution::Global,
        warnings,
        solved: match refined(measured, &vertex) {
            Some(working) => Solved::Working(working),
            None => Solved::Step(vertex.x),
        },
        ..Outcome::default()
    })
}

/// Influence for each unit of the residual, `min(1, s ρ/r²)`: 1/|r| has no value at a residual of
/// 0.
fn capped(rho: f64, r: f64, scale: f64) -> f64 {
    if rho <= 0.0 { 1.0 } else { (scale / r.abs() * (rho / r.abs())).min(1.0) }
}

/// A few variationally weighted iterations.
fn approach(rows: &Rows, tilt: f64) -> Vec<f64> {
    let mut x = vec![0.0; rows.n];
    let mut r = rows.b.clone();
    for _ in 0..APPROACH {
        cancel::checkpoint();
        let least = 1e-3 * median_abs(&r);
        if least == 0.0 {
            break;
        }
        let weights: Vec<f64> = r.iter().map(|r| (1.0 + tilt * r.signum()) / r.abs().max(least)).collect();
        let Some(next) = weighted_solution(rows.n, &rows.q, &weights, &rows.b) else { break };
        x = next;
        r = rows.residuals(&x);
    }
    x
}

/// The coefficients of the vertex in the working basis, from its nodes alone, in double-double.
fn refined(measured: &Measured, vertex: &Vertex) -> Option<Vec<Dd>> {
    let Measured { linear, sample, .. } = *measured;
    let design = linear.design;
    let n = design.size();
    let mut a = nalgebra::DMatrix::from_element(n, n, Dd::ZERO);
    let mut z = nalgebra::DVector::from_element(n, Dd::ZERO);
    let mut row = Row::<Dd>::new(design);
    for (i, &k) in vertex.basis.iter().enumerate() {
        row.at(design, sample, k);
        for (&j, &x) in row.index.iter().zip(&row.values) {
            a[(i, j)] = x;
        }
        z[i] = Dd::from(sample.z(k));
    }
    let qr = qr_with_rhs(a, z);
    let mut working: Vec<Dd> = qr.qty.iter().take(n).copied().collect();
    triangular::solve_upper(&qr.r, &mut working);
    working.iter().all(|c| c.is_finite()).then_some(working)
}

/// 1/f at quantile τ of the residuals.
fn sparsity(tau: f64, residuals: &[f64], vertex: &[usize]) -> Option<f64> {
    let mut on = vec![false; residuals.len()];
    vertex.iter().for_each(|&k| on[k] = true);
    let mut rest: Vec<f64> = residuals.iter().zip(&on).filter(|(_, on)| !**on).map(|(r, _)| *r).collect();
    if rest.len() < 2 {
        return None;
    }
    rest.sort_by(cancel::comparing(f64::total_cmp));
    let at = |p: f64| {
        let place = p * (rest.len() - 1) as f64;
        let below = place.floor() as usize;
        let above = (below + 1).min(rest.len() - 1);
        rest[below] + (place - below as f64) * (rest[above] - rest[below])
    };
    let z = normal::quantile(tau);
    let density = normal::density(z);
    let width = (residuals.len() as f64).powf(-1.0 / 3.0)
        * normal::quantile(0.975).powf(2.0 / 3.0)
        * (1.5 * density * density / (2.0 * z * z + 1.0)).cbrt();
    let (low, high) = ((tau - width).max(0.0), (tau + width).min(1.0));
    Some((at(high) - at(low)) / (high - low))
}
