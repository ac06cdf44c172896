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
    approach::{At, Pieces, approach},
    exact, normal,
    outcome::{Measured, Outcome, Solved},
    rows::{Rows, dot},
    scale::median_abs,
    vertex::{self, Lines, Vertex},
};
use crate::{
    design::Row,
    error::{FitError, Unconverged},
    result::{LocalSolution, Warning},
};
use flankfit_numerics::{
    Dd,
    cancel::{self, Asking},
    qr_with_rhs, triangular,
};

/// Numbers in rows that are few.
const FEW: usize = 40_000;
/// Walks over ever more rows before all of them are taken.
const ROUNDS: usize = 12;

/// Least absolute deviations.
pub(super) fn estimate(measured: &Measured) -> Result<Outcome, FitError> {
    solve(0.5, 1.0, measured)
}

/// A regression quantile of rows.
pub(super) struct QuantileFit {
    pub tau: f64,
    pub vertex: Vertex,
    /// Exactly 0 on the vertex.
    pub residuals: Vec<f64>,
    /// 1/f at the quantile.
    pub sparsity: Option<f64>,
}

impl QuantileFit {
    /// `2ρ_τ`.
    fn rho(&self, r: f64) -> f64 {
        2.0 * r * if r < 0.0 { self.tau - 1.0 } else { self.tau }
    }

    /// `Σ ρ_τ`.
    pub(super) fn sum(&self) -> f64 {
        0.5 * self.residuals.iter().map(|r| self.rho(*r)).sum::<f64>()
    }

    pub(super) fn warnings(&self) -> Vec<Warning> {
        let stopped = (!self.vertex.optimal).then_some(Warning::SimplexStopped { steps: self.vertex.steps });
        let several = (!self.vertex.unique).then_some(Warning::SumNotUnique);
        stopped.into_iter().chain(several).collect()
    }
}

/// Least `Σ ρ_τ`.
pub(super) fn at(tau: f64, rows: &Rows) -> Result<QuantileFit, FitError> {
    let n = rows.n;
    let tilt = 2.0 * tau - 1.0;
    let mut g = vec![0.0; n];
    for q in rows.q.chunks_exact(n).asking(n) {
        g.iter_mut().zip(q).for_each(|(g, q)| *g -= tilt * q);
    }
    let vertex =
        walk(&Deviations::new(rows, &g, tilt)).ok_or(FitError::NotConverged(Unconverged::AbsoluteDeviations))?;
    let mut residuals = rows.residuals(&vertex.x);
    for &k in &vertex.basis {
        residuals[k] = 0.0;
    }
    let sparsity = sparsity(tau, &residuals, &vertex.basis);
    Ok(QuantileFit { tau, vertex, residuals, sparsity })
}

/// Least `factor · Σ ρ_τ` as an outcome.
pub(super) fn solve(tau: f64, factor: f64, measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let fit = at(tau, &rows)?;
    let mut warnings = fit.warnings();
    let residuals = &fit.residuals;
    let scale = fit.sparsity.map(|s| (tau * (1.0 - tau)).sqrt() * s);
    let settled = exact::settled(scale, scale.filter(|_| m > n), residuals, n, measured.heights.largest, &mut warnings);
    let capped = |r: &f64| capped(fit.rho(*r), *r, settled.scale.unwrap_or(0.0));
    let weights = settled.weights.unwrap_or_else(|| residuals.iter().map(capped).collect());
    let objective = factor * residuals.iter().map(|r| fit.rho(*r)).sum::<f64>();
    let vertex = fit.vertex;
    let mut basis = vertex.basis.clone();
    basis.sort_unstable();
    Ok(Outcome {
        converged: vertex.optimal,
        iterations: vertex.steps,
        scale: settled.scale,
        objective,
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

/// `Σ |rₖ| + gᵀx`, in rows that are orthonormal.
struct Deviations<'a> {
    rows: &'a Rows,
    g: &'a [f64],
    /// 2τ − 1.
    tilt: f64,
    /// Lengths of the rows.
    length: Vec<f64>,
}

struct Evaluated {
    value: f64,
    gradient: Vec<f64>,
    residuals: Vec<f64>,
}

impl At for Evaluated {
    fn value(&self) -> f64 {
        self.value
    }

    fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}

impl<'a> Deviations<'a> {
    fn new(rows: &'a Rows, g: &'a [f64], tilt: f64) -> Self {
        let length = rows.q.chunks_exact(rows.n).asking(rows.n).map(|q| dot(q, q).sqrt()).collect();
        Deviations { rows, g, tilt, length }
    }

    /// True if residual k may change its sign within this distance.
    fn may_turn(&self, k: usize, residual: f64, distance: f64) -> bool {
        residual.abs() <= self.length[k] * distance
    }
}

impl Pieces for Deviations<'_> {
    type Evaluated = Evaluated;

    fn size(&self) -> usize {
        self.rows.n
    }

    fn at(&self, x: &[f64]) -> Evaluated {
        let residuals = self.rows.residuals(x);
        let mut gradient = self.g.to_vec();
        for (r, q) in residuals.iter().zip(self.rows.q.chunks_exact(self.rows.n)).asking(self.rows.n) {
            let sign = if *r == 0.0 { 0.0 } else { r.signum() };
            gradient.iter_mut().zip(q).for_each(|(g, q)| *g -= sign * q);
        }
        let value = residuals.iter().map(|r| r.abs()).sum::<f64>() + dot(self.g, x);
        Evaluated { value, gradient, residuals }
    }

    /// `∇² ≈ 2f QᵀQ = 2f I`, f the density of a normal law at the quantile looked for.
    fn inverse_curvature(&self, start: &Evaluated) -> f64 {
        let sigma = median_abs(&start.residuals) / normal::quantile(0.75);
        let density = normal::density(normal::quantile(0.5 * (1.0 + self.tilt)));
        sigma / (2.0 * density)
    }

    fn kinks_within(&self, place: &Evaluated, distance: f64) -> usize {
        place.residuals.iter().enumerate().filter(|&(k, r)| self.may_turn(k, *r, distance)).count()
    }
}

/// Walks over the rows whose residuals may change their sign on the way from near the answer to it;
/// all others are one linear term (Portnoy and Koenker 1997). Those that did change it join in.
fn walk(deviations: &Deviations) -> Option<Vertex> {
    let Deviations { rows, g, .. } = deviations;
    let (m, n) = (rows.count(), rows.n);
    let limit = vertex::most_steps(m * n);
    let few = (FEW / n).max(20 * n);
    if m <= few {
        return vertex::minimise(&Lines { n, rows: &rows.q, b: &rows.b, g }, &vec![0.0; n], limit);
    }
    let near = approach(deviations, few);
    let mut x = near.x;
    let r = rows.residuals(&x);
    let mut among: Vec<bool> = r.iter().enumerate().map(|(k, r)| deviations.may_turn(k, *r, near.radius)).collect();
    let sides: Vec<f64> = r.iter().map(|r| r.signum()).collect();
    for round in 0..ROUNDS {
        cancel::checkpoint();
        let chosen: Vec<usize> = (0..m).filter(|&k| among[k] || round + 1 == ROUNDS).collect();
        let (mut some, mut heights) = (Vec::with_capacity(chosen.len() * n), Vec::with_capacity(chosen.len()));
        for &k in chosen.iter().asking(n) {
            some.extend_from_slice(rows.row(k));
            heights.push(rows.b[k]);
        }
        let mut pull = g.to_vec();
        for k in (0..m).filter(|&k| !among[k] && round + 1 < ROUNDS).asking(n) {
            pull.iter_mut().zip(rows.row(k)).for_each(|(g, q)| *g -= sides[k] * q);
        }
        let lines = Lines { n, rows: &some, b: &heights, g: &pull };
        let vertex = vertex::minimise(&lines, &x, limit).filter(|vertex| vertex.optimal || round + 1 == ROUNDS);
        let Some(vertex) = vertex else {
            // too few rows to hold the answer
            let wider = 4.0 * near.radius * 2f64.powi(round as i32);
            (0..m).filter(|&k| deviations.may_turn(k, r[k], wider)).for_each(|k| among[k] = true);
            continue;
        };
        let there = rows.residuals(&vertex.x);
        let turned: Vec<usize> = (0..m).filter(|&k| !among[k] && there[k] * sides[k] < 0.0).collect();
        if turned.is_empty() || round + 1 == ROUNDS {
            let mut dual = sides;
            chosen.iter().zip(&vertex.dual).for_each(|(&k, d)| dual[k] = *d);
            let basis = vertex.basis.iter().map(|&i| chosen[i]).collect();
            return Some(Vertex { basis, dual, ..vertex });
        }
        turned.into_iter().for_each(|k| among[k] = true);
        x = vertex.x;
    }
    None
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
