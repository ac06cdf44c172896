//! Least rank dispersion (Jaeckel 1972) with Wilcoxon scores.
//!
//! `D = Σ a(R(rₖ)) rₖ`, `a(i) = √12 (i/(m + 1) − 1/2)`, R the rank of `rₖ = √wₖ (zₖ − xₖᵀA)` among
//! all; it has the unit of the heights. ψ is the score (bounded), ρ = a·r. D is convex and
//! piecewise linear, and as `D = √12/(2(m + 1)) Σ_{i<j} |rᵢ − rⱼ|` its least value is a vertex
//! where n pairs of residuals are equal, which [`super::vertex`] finds and certifies.
//!
//! Pairs far apart in rank keep their order near the answer: they are one linear term. Pairs within
//! a window of ranks are walked over; a round ends with a look at all pairs, and is repeated where
//! one outside the window has changed its order. So the answer is exact for any number of nodes.
//!
//! D does not change when a constant is added to all `rₖ`. Where the columns can add up to one,
//! that constant is set by the median of the residuals.
//!
//! Standard errors: `τ² (XᵀX)⁻¹`, `1/τ = √12 ∫f²`, the integral being the density at 0 of
//! differences of residuals (Koul, Sievers and McKean 1987; Hettmansperger and McKean 2011, section
//! 3.7); along the constant `τ_s = 1/(2f(0))`, as for a median.

use super::{
    exact,
    outcome::{Along, Measured, Outcome, Solved},
    rows::{Rows, dot},
    scale::median,
    vertex::{self, Lines},
};
use crate::{
    estimation::{
        error::{FitError, Unconverged},
        result::{LocalSolution, Warning},
    },
    numerics::cancel::{self, Asking},
};

/// Numbers in the rows of pairs of one round.
const PAIRS: usize = 6_000_000;
const ROUNDS: usize = 60;
/// Newton's steps that lead near the answer.
const APPROACH: usize = 20;

pub(super) fn estimate(measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let constant = constant(&rows);
    let free = Free::new(&rows, constant.as_deref());
    let mut walk = Search { x: vec![0.0; free.n], steps: 0, certificate: 0.0, optimal: true, unique: true };
    if free.n > 0 && m > 1 {
        walk.x = approach(&free);
        walk.run(&free)?;
    }
    let mut x = free.back(&walk.x);
    let mut residuals = rows.residuals(&x);
    if let Some(e) = &constant {
        let level = median(&mut residuals.clone()) * (m as f64).sqrt();
        x.iter_mut().zip(e).for_each(|(x, e)| *x += level * e);
        residuals = rows.residuals(&x);
    }
    let mut warnings = Vec::new();
    if !walk.optimal {
        warnings.push(Warning::DispersionStopped);
    }
    if !walk.unique {
        warnings.push(Warning::DispersionNotUnique);
    }
    let scores = scores(&residuals);
    let tau = tau(&residuals, n);
    let settled = exact::settled(tau, tau.filter(|_| m > n), &residuals, measured.heights.largest, &mut warnings);
    let scale = settled.scale.unwrap_or(0.0);
    let weight = |(a, r): (&f64, &f64)| if *r == 0.0 { 1.0 } else { (scale * (a / r).abs()).min(1.0) };
    let weights = settled.weights.unwrap_or_else(|| scores.iter().zip(&residuals).map(weight).collect());
    let along = constant.filter(|_| settled.dispersion.is_some()).and_then(|direction| {
        let size = sparsity_at_median(&residuals, n)?;
        Some(Along { direction, dispersion: 0.5 * size })
    });
    Ok(Outcome {
        solved: Solved::Step(x),
        converged: walk.optimal,
        iterations: walk.steps,
        scale: settled.scale,
        objective: dot(&scores, &residuals),
        weights,
        certificate: Some(walk.certificate),
        unique: Some(walk.unique),
        dispersion: settled.dispersion,
        along,
        local: LocalSolution::Global,
        warnings,
        ..Outcome::default()
    })
}

/// `Qᵀ1/√m`, of length 1, where the columns can add up to one.
fn constant(rows: &Rows) -> Option<Vec<f64>> {
    let mut e = vec![0.0; rows.n];
    for q in rows.q.chunks_exact(rows.n).asking(rows.n) {
        e.iter_mut().zip(q).for_each(|(e, q)| *e += q);
    }
    let root = (rows.count() as f64).sqrt();
    e.iter_mut().for_each(|e| *e /= root);
    ((dot(&e, &e) - 1.0).abs() < 1e-10).then_some(e)
}

/// The rows in the directions that D can see.
struct Free<'a> {
    n: usize,
    a: Vec<f64>,
    b: &'a [f64],
    /// A reflection that turns the constant into the first axis: `I − 2 vvᵀ`.
    mirror: Option<Vec<f64>>,
}

impl<'a> Free<'a> {
    fn new(rows: &'a Rows, constant: Option<&[f64]>) -> Self {
        let Some(e) = constant else { return Free { n: rows.n, a: rows.q.clone(), b: &rows.b, mirror: None } };
        let mut v = e.to_vec();
        v[0] += if v[0] < 0.0 { -1.0 } else { 1.0 };
        let length = dot(&v, &v).sqrt();
        v.iter_mut().for_each(|v| *v /= length);
        let n = rows.n - 1;
        let mut a = Vec::with_capacity(n * rows.count());
        for q in rows.q.chunks_exact(rows.n).asking(rows.n) {
            let twice = 2.0 * dot(q, &v);
            a.extend(q.iter().zip(&v).skip(1).map(|(q, v)| q - twice * v));
        }
        Free { n, a, b: &rows.b, mirror: Some(v) }
    }

    /// The step in all directions.
    fn back(&self, x: &[f64]) -> Vec<f64> {
        let Some(v) = &self.mirror else { return x.to_vec() };
        let mut all = vec![0.0];
        all.extend_from_slice(x);
        let twice = 2.0 * dot(&all, v);
        all.iter_mut().zip(v).for_each(|(x, v)| *x -= twice * v);
        all
    }

    fn count(&self) -> usize {
        self.b.len()
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.a[k * self.n..][..self.n]
    }

    fn residuals(&self, x: &[f64]) -> Vec<f64> {
        (0..self.count()).asking(self.n).map(|k| self.b[k] - dot(self.row(k), x)).collect()
    }

    /// `Σ_{i<j} |rᵢ − rⱼ|`.
    fn spread(&self, x: &[f64]) -> f64 {
        let mut r = self.residuals(x);
        r.sort_by(cancel::comparing(f64::total_cmp));
        let m = r.len() as f64;
        r.iter().enumerate().map(|(i, r)| (2.0 * i as f64 + 1.0 - m) * r).sum()
    }
}

/// Order of the residuals; equal ones as posted.
fn order(r: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..r.len()).collect();
    order.sort_by(cancel::comparing(|&a: &usize, &b: &usize| r[a].total_cmp(&r[b]).then(a.cmp(&b))));
    order
}

/// Wilcoxon scores, equal residuals sharing their mean.
fn scores(r: &[f64]) -> Vec<f64> {
    let m = r.len();
    let order = order(r);
    let mut scores = vec![0.0; m];
    let mut from = 0;
    while from < m {
        let mut to = from + 1;
        while to < m && r[order[to]] == r[order[from]] {
            to += 1;
        }
        let rank = 0.5 * (from + to + 1) as f64;
        for &k in &order[from..to] {
            scores[k] = 12f64.sqrt() * (rank / (m + 1) as f64 - 0.5);
        }
        from = to;
    }
    scores
}

/// Newton's steps `x += τ Aᵀa(R)`, halved while D does not fall. (A has orthonormal columns.)
fn approach(free: &Free) -> Vec<f64> {
    let mut x = vec![0.0; free.n];
    let mut here = free.spread(&x);
    for _ in 0..APPROACH {
        cancel::checkpoint();
        let r = free.residuals(&x);
        let Some(tau) = tau(&r, free.n) else { break };
        let mut step = vec![0.0; free.n];
        for (k, a) in scores(&r).into_iter().enumerate().asking(free.n) {
            step.iter_mut().zip(free.row(k)).for_each(|(s, q)| *s += tau * a * q);
        }
        let mut length = 1.0;
        let before = here;
        while length > 1e-3 {
            cancel::checkpoint();
            let next: Vec<f64> = x.iter().zip(&step).map(|(x, s)| x + length * s).collect();
            let there = free.spread(&next);
            if there < here {
                (x, here) = (next, there);
                break;
            }
            length *= 0.5;
        }
        if before - here <= 1e-7 * before {
            break;
        }
    }
    x
}

struct Search {
    x: Vec<f64>,
    steps: usize,
    certificate: f64,
    optimal: bool,
    unique: bool,
}

impl Search {
    fn run(&mut self, free: &Free) -> Result<(), FitError> {
        let (m, n) = (free.count(), free.n);
        let reach = (PAIRS / (m * (n + 5))).clamp(1, m - 1);
        let mut here = free.spread(&self.x);
        let limit = vertex::most_steps(m * reach * n);
        for _ in 0..ROUNDS {
            cancel::checkpoint();
            let r = free.residuals(&self.x);
            let order = order(&r);
            let round = Round::new(free, &order, reach);
            let lines = Lines { n, rows: &round.rows, b: &round.b, g: &round.g };
            let vertex = vertex::minimise(&lines, &self.x, limit.saturating_sub(self.steps))
                .ok_or(FitError::NotConverged(Unconverged::RankDispersion))?;
            self.steps += vertex.steps;
            self.certificate = vertex.certificate();
            self.unique = vertex.unique;
            self.optimal = vertex.optimal;
            if round.keeps_order(free, &vertex.x) {
                self.x = vertex.x;
                return Ok(());
            }
            // the window's least value lies too far away: go there only as far as D falls
            let mut length = 1.0;
            let mut moved = false;
            while length > 1e-9 && !moved {
                cancel::checkpoint();
                let next: Vec<f64> = self.x.iter().zip(&vertex.x).map(|(x, v)| x + length * (v - x)).collect();
                let there = free.spread(&next);
                if there < here {
                    (self.x, here, moved) = (next, there, true);
                }
                length *= 0.5;
            }
            if !moved {
                break;
            }
        }
        self.optimal = false;
        Ok(())
    }
}

/// Pairs within `reach` of each other in an order, and the linear rest.
struct Round {
    rows: Vec<f64>,
    b: Vec<f64>,
    g: Vec<f64>,
    order: Vec<usize>,
    reach: usize,
}

impl Round {
    fn new(free: &Free, order: &[usize], reach: usize) -> Self {
        let (m, n) = (free.count(), free.n);
        let pairs = m * reach - reach * (reach + 1) / 2;
        let (mut rows, mut b) = (Vec::with_capacity(pairs * n), Vec::with_capacity(pairs));
        let mut g = vec![0.0; n];
        for (place, &low) in order.iter().enumerate().asking(2 * reach * n) {
            let last = (place + reach).min(m - 1);
            for &high in &order[place + 1..=last] {
                rows.extend(free.row(high).iter().zip(free.row(low)).map(|(h, l)| h - l));
                b.push(free.b[high] - free.b[low]);
            }
            // pairs outside: r_high − r_low falls by (a_high − a_low)ᵀx
            let below = place.saturating_sub(reach) as f64;
            let above = (m - 1 - last) as f64;
            g.iter_mut().zip(free.row(low)).for_each(|(g, a)| *g -= (below - above) * a);
        }
        Round { rows, b, g, order: order.to_vec(), reach }
    }

    /// Whether pairs outside the window are in the same order at `x`.
    fn keeps_order(&self, free: &Free, x: &[f64]) -> bool {
        let m = self.order.len();
        if self.reach >= m - 1 {
            return true;
        }
        let r = free.residuals(x);
        // every one beyond the window must be above the largest up to its beginning
        let mut largest = f64::NEG_INFINITY;
        (self.reach + 1..m).all(|place| {
            largest = largest.max(r[self.order[place - self.reach - 1]]);
            r[self.order[place]] >= largest
        })
    }
}

/// τ of the standard errors; `None` where residuals are all equal or too few.
fn tau(residuals: &[f64], n: usize) -> Option<f64> {
    let m = residuals.len();
    if m <= n + 1 || m < 3 {
        return None;
    }
    let mut r = residuals.to_vec();
    r.sort_by(cancel::comparing(f64::total_cmp));
    let pairs = m as f64 * (m - 1) as f64 / 2.0;
    // share of pairs no further apart than y
    let share = |y: f64| {
        let mut low = 0;
        let mut count = 0usize;
        for high in (0..m).asking(2) {
            while r[high] - r[low] > y {
                low += 1;
            }
            count += high - low;
        }
        count as f64 / pairs
    };
    let range = r[m - 1] - r[0];
    if range <= 0.0 {
        return None;
    }
    let (mut low, mut high) = (0.0, range);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if share(middle) >= 0.8 { high = middle } else { low = middle }
    }
    // a window that shrinks with the number of nodes, and holds at least as many pairs as a vertex
    // ties
    let mut width = high / (m as f64).sqrt();
    let least = (2 * n + 1) as f64 / pairs;
    while share(width) < least && width < range {
        width *= 1.5;
    }
    let density = share(width) / (2.0 * width);
    let correction = (m as f64 / (m - n) as f64).sqrt();
    let tau = correction / (12f64.sqrt() * density);
    (tau.is_finite() && tau > 0.0).then_some(tau)
}

/// 1/f(0) of the residuals about their median, over the middle of them that a normal law would put
/// within ±1/√m of its σ.
fn sparsity_at_median(residuals: &[f64], n: usize) -> Option<f64> {
    let m = residuals.len();
    if m <= n + 1 {
        return None;
    }
    let mut r = residuals.to_vec();
    r.sort_by(cancel::comparing(f64::total_cmp));
    let half = ((m as f64).sqrt().ceil() as usize).max(1);
    let middle = (m - 1) / 2;
    let (low, high) = (middle.saturating_sub(half), (middle + half).min(m - 1));
    let size = (r[high] - r[low]) * m as f64 / (high - low) as f64 * (m as f64 / (m - n) as f64).sqrt();
    (size > 0.0 && size.is_finite()).then_some(size)
}
