//! Least trimmed squares (Rousseeuw 1984): the least sum of the h smallest `rₖ²`, `rₖ = √wₖ (zₖ −
//! xₖᵀA)`.
//!
//! ρ = r² among the h smallest and 0 otherwise, ψ = r or 0, weight 1 or 0, in squares of the unit
//! of the heights. `h = ⌊coverage·m⌋`, but at least `⌊(m + n + 1)/2⌋`, where the breakdown point is
//! highest (Rousseeuw and Leroy 1987, section 3.4).
//!
//! * Few nodes: every subset is tried, so that the answer is the global one.
//! * Else FAST-LTS (Rousseeuw and Van Driessen 2006): from random elemental subsets (and from least
//!   squares) two concentration steps each (fit, keep the h smallest), then the best of them to the
//!   end, where nodes are exchanged as long as that lowers the sum ([`super::exchange`]). Of many
//!   nodes the first steps see a random sample. The same seed gives the same answer, and other
//!   seeds hardly another one.
//!
//! Scale: `s² = Σ_h r²/(h − n) · α/D` with α = h/m, q = Φ⁻¹((1 + α)/2) and `D = α − 2qφ(q)`, the
//! consistency factor at normal errors (Croux and Rousseeuw 1992); no further correction for small
//! samples. Standard errors: `s²/D (XᵀX)⁻¹`.

use super::{
    exact::{self, EXACT},
    exchange, normal,
    outcome::{Measured, Outcome, Solved, Weighting},
    random::SplitMix,
    rows::{Rows, dot, weighted_solution},
};
use crate::{
    error::FitError,
    factor::Factor,
    result::{LocalSolution, Warning},
    spec::DEFAULT_COVERAGE,
};
use flankfit_numerics::{
    cancel::{self, Asking},
    check::Faults,
};

/// Subsets up to which all of them are tried.
const ALL: usize = 20_000;
/// Elemental starts, those taken further (at least and at most), and the nodes that the first steps
/// see.
const STARTS: usize = 500;
const BEST: [usize; 2] = [10, 40];
const SEEN: usize = 1_500;
/// Products that all starts may take.
const WORK: usize = 20_000_000_000;
/// Products that one step of all those taken further may take.
const FURTHER: usize = 40_000_000;
/// `m n²` at most: some ten steps of ten starts take as many products each.
const MOST_WORK: usize = 1_000_000_000;
/// Nodes up to which they are exchanged: of more, no exchange moves anything that matters.
const EXCHANGED: usize = 2_000;
/// Concentration steps at most; each lowers the sum, so there are few.
const STEPS: usize = 200;

/// Number of nodes in the sum.
pub(super) fn subset_size(coverage: f64, m: usize, n: usize) -> usize {
    let asked = (coverage * m as f64 * (1.0 + 4.0 * f64::EPSILON)).floor() as usize;
    asked.clamp((m + n).div_ceil(2).min(m), m)
}

pub(super) fn estimate(coverage: f64, seed: u64, measured: &Measured) -> Result<Outcome, FitError> {
    let Measured { linear, sample, .. } = *measured;
    let design = linear.design;
    let rows = rows_of(measured)?;
    let (m, n) = (rows.count(), rows.n);
    if m <= n {
        return Err(Faults::one(
            "estimator.type",
            format_args!(
                "least trimmed squares needs more nodes than coefficients: there are {m} for {n} coefficients"
            ),
        )
        .into());
    }
    let h = subset_size(coverage, m, n);
    let found = search(&rows, h, seed);
    let omega: Vec<f64> = found.kept.iter().map(|kept| f64::from(u8::from(*kept))).collect();
    let weights = measured.posted_weights(&omega);
    let factor = Factor::new(design, &sample.reweighted(&weights))?;
    if factor.working.is_none() {
        return Err(Faults::one(
            "estimator.coverage",
            format_args!(
                "the {h} nodes of the least trimmed sum do not determine {n} coefficients: raise the coverage"
            ),
        )
        .into());
    }
    let alpha = h as f64 / m as f64;
    let q = normal::quantile(0.5 * (1.0 + alpha));
    let share = if q.is_finite() { alpha - 2.0 * q * normal::density(q) } else { 1.0 };
    let objective = factor.rss;
    // the search keeps more nodes than coefficients
    let scale = (objective / (h - n) as f64 * alpha / share).sqrt();
    let mut warnings: Vec<Warning> = Vec::new();
    let is_exact = scale <= EXACT * measured.heights.largest;
    if is_exact {
        warnings.push(exact::warning(h, m));
    }
    Ok(Outcome {
        solved: Solved::Weighted(Weighting { factor: Box::new(factor), omega: omega.clone() }),
        converged: true,
        iterations: found.steps,
        scale: Some(if is_exact { 0.0 } else { scale }),
        objective,
        weights: omega,
        dispersion: (!is_exact).then(|| scale / share.sqrt()),
        warnings,
        subset_size: Some(h),
        local: if found.exhaustive { LocalSolution::Global } else { LocalSolution::BestOfMany },
        ..Outcome::default()
    })
}

/// Weights from which an M-estimator may start: 1 on the half of the nodes with the least trimmed
/// sum.
pub(super) fn start_weights(measured: &Measured) -> Result<Vec<f64>, FitError> {
    let rows = rows_of(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let h = subset_size(DEFAULT_COVERAGE.min(0.5), m, n);
    Ok(search(&rows, h, 0).kept.iter().map(|kept| f64::from(u8::from(*kept))).collect())
}

/// The rows that are searched; refuses what would take minutes.
fn rows_of(measured: &Measured) -> Result<Rows, FitError> {
    let (nodes, coefficients) = (measured.sample.count(), measured.linear.design.size());
    if nodes.saturating_mul(coefficients.pow(2)) > MOST_WORK {
        return Err(Faults::one(
            "estimator.type",
            format_args!(
                "least trimmed squares of {nodes} nodes and {coefficients} coefficients takes too long: use \
                 `m_estimator`, or fewer nodes"
            ),
        )
        .into());
    }
    Rows::new(measured)
}

/// The best subset found.
struct Subset {
    kept: Vec<bool>,
    steps: usize,
    exhaustive: bool,
}

fn search(rows: &Rows, h: usize, seed: u64) -> Subset {
    let m = rows.count();
    match subsets(m, h) {
        Some(count) if count <= ALL => exhaustive(rows, h),
        _ => fast(rows, h, seed),
    }
}

/// m over h, while it is small.
fn subsets(m: usize, h: usize) -> Option<usize> {
    let few = h.min(m - h);
    let mut count: usize = 1;
    for i in 0..few {
        count = count.checked_mul(m - i)? / (i + 1);
        if count > ALL * 1000 {
            return None;
        }
    }
    Some(count)
}

/// Sum of squares that least squares leaves on the nodes `subset`, and its step; `None` where they
/// do not determine it.
fn fitted(rows: &Rows, subset: &[usize]) -> Option<(f64, Vec<f64>)> {
    let n = rows.n;
    let mut q = Vec::with_capacity(subset.len() * n);
    let mut b = Vec::with_capacity(subset.len());
    for &k in subset.iter().asking(n) {
        q.extend_from_slice(rows.row(k));
        b.push(rows.b[k]);
    }
    let x = weighted_solution(n, &q, &vec![1.0; b.len()], &b)?;
    let sum = b.iter().zip(q.chunks_exact(n)).asking(n).map(|(b, q)| (b - dot(q, &x)).powi(2)).sum();
    Some((sum, x))
}

fn exhaustive(rows: &Rows, h: usize) -> Subset {
    let m = rows.count();
    let mut subset: Vec<usize> = (0..h).collect();
    let mut best: (f64, Vec<usize>) = (f64::INFINITY, subset.clone());
    let mut steps = 0;
    loop {
        cancel::checkpoint();
        steps += 1;
        if let Some((sum, _)) = fitted(rows, &subset)
            && sum < best.0
        {
            best = (sum, subset.clone());
        }
        // the next subset in lexicographic order
        let Some(i) = (0..h).rev().find(|&i| subset[i] < m - h + i) else { break };
        subset[i] += 1;
        for j in i + 1..h {
            subset[j] = subset[j - 1] + 1;
        }
    }
    let mut kept = vec![false; m];
    best.1.iter().for_each(|&k| kept[k] = true);
    Subset { kept, steps, exhaustive: true }
}

/// Keeps the `h` of `among` with the smallest squares at `x`, in the order posted.
fn smallest(rows: &Rows, among: &[usize], h: usize, x: &[f64]) -> Vec<usize> {
    let by_size = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    let mut squares: Vec<(f64, usize)> =
        among.iter().asking(rows.n).map(|&k| ((rows.b[k] - dot(rows.row(k), x)).powi(2), k)).collect();
    if h < squares.len() {
        squares.select_nth_unstable_by(h, cancel::comparing(by_size));
        squares.truncate(h);
    }
    let mut kept: Vec<usize> = squares.into_iter().map(|(_, k)| k).collect();
    kept.sort_unstable_by(cancel::comparing(usize::cmp));
    kept
}

/// A sum that no concentration lowers, its step and the nodes in it.
type Local = (f64, Vec<f64>, Vec<usize>);

/// Concentrates from `x` until the subset is constant, at most `limit` times.
fn concentrate(
    rows: &Rows,
    among: &[usize],
    h: usize,
    mut x: Vec<f64>,
    limit: usize,
    steps: &mut usize,
) -> Option<Local> {
    let mut last: Option<Local> = None;
    for _ in 0..limit {
        cancel::checkpoint();
        let subset = smallest(rows, among, h, &x);
        if last.as_ref().is_some_and(|(_, _, kept)| *kept == subset) {
            break;
        }
        *steps += 1;
        let (sum, next) = fitted(rows, &subset)?;
        x.clone_from(&next);
        last = Some((sum, next, subset));
    }
    last
}

/// A step that fits as many random nodes as it takes to determine one.
fn elemental(rows: &Rows, among: &[usize], random: &mut SplitMix) -> Option<Vec<f64>> {
    let n = rows.n;
    let most = (8 * n + 20).min(among.len());
    let drawn: Vec<usize> = random.distinct(most, among.len()).into_iter().map(|i| among[i]).collect();
    let mut take = n;
    loop {
        if let Some((_, x)) = fitted(rows, &drawn[..take.min(most)]) {
            return Some(x);
        }
        if take >= most {
            return None;
        }
        take += (take / 4).max(1);
    }
}

/// Exchanges nodes and concentrates again, as long as the sum falls.
fn descend(rows: &Rows, all: &[usize], mut here: Local, steps: &mut usize) -> Local {
    for _ in 0..STEPS {
        cancel::checkpoint();
        let (sum, x, kept) = &here;
        let Some(subset) = exchange::better(rows, kept, x, *sum) else { break };
        let Some((_, next)) = fitted(rows, &subset) else { break };
        match concentrate(rows, all, subset.len(), next, STEPS, steps) {
            Some(found) if found.0 < *sum => here = found,
            _ => break,
        }
    }
    here
}

fn fast(rows: &Rows, h: usize, seed: u64) -> Subset {
    let (m, n) = (rows.count(), rows.n);
    let mut random = SplitMix::new(seed);
    let all: Vec<usize> = (0..m).collect();
    let seen = if m <= SEEN.max(8 * n) {
        all.clone()
    } else {
        let mut seen = random.distinct(SEEN.max(8 * n), m);
        seen.sort_unstable();
        seen
    };
    let first = (h * seen.len() / m).max(n + 1).min(seen.len());
    let mut steps = 0;
    let mut candidates: Vec<(f64, Vec<f64>)> = Vec::new();
    // a start costs two fits of the nodes seen
    let starts = (WORK / (2 * seen.len() * n * n)).clamp(BEST[0], STARTS);
    let all_parts = cancel::parts(2 * starts);
    for start in 0..starts {
        cancel::checkpoint();
        let x = if start == 0 { Some(vec![0.0; n]) } else { elemental(rows, &seen, &mut random) };
        let found = all_parts.run(1, || x.and_then(|x| concentrate(rows, &seen, first, x, 2, &mut steps)));
        let Some((sum, x, _)) = found else { continue };
        candidates.push((sum, x));
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    // many starts lead to the same place
    candidates.dedup_by(|a, b| (a.0 - b.0).abs() <= 1e-12 * b.0.abs());
    candidates.truncate((FURTHER / (m * n * n)).clamp(BEST[0], BEST[1]));
    candidates.push((f64::INFINITY, vec![0.0; n]));
    let mut best: Option<(f64, Vec<usize>)> = None;
    let share = starts / candidates.len();
    for (_, x) in candidates {
        let found = all_parts.run(share, || {
            let found = concentrate(rows, &all, h, x, STEPS, &mut steps);
            let descended = |found| if m <= EXCHANGED { descend(rows, &all, found, &mut steps) } else { found };
            found.map(descended)
        });
        let Some((sum, _, kept)) = found else { continue };
        if best.as_ref().is_none_or(|(least, _)| sum < *least) {
            best = Some((sum, kept));
        }
    }
    let subset = best.map_or_else(|| smallest(rows, &all, h, &vec![0.0; n]), |(_, kept)| kept);
    let mut kept = vec![false; m];
    subset.iter().for_each(|&k| kept[k] = true);
    Subset { kept, steps, exhaustive: false }
}
