//! Least rank dispersion (Jaeckel 1972) with Wilcoxon scores.
//!
//! `D = Σ a(R(rₖ)) rₖ`, `a(i) = √12 (i/(m + 1) − 1/2)`, R the rank of `rₖ = √wₖ (zₖ − xₖᵀA)` among
//! all; it has the unit of the heights. ψ is the score (bounded), ρ = a·r. D is convex and
//! piecewise linear, and as `D = √12/(2(m + 1)) Σ_{i<j} |rᵢ − rⱼ|` its least value is a vertex
//! where n pairs of residuals are equal, which [`super::vertex`] finds and certifies.
//!
//! Quasi-Newton steps lead so near to it ([`super::approach`]) that only a few hundred pairs can
//! still change their order: those whose residuals differ by less than a window. All others are one
//! linear term. A round ends with a look at all pairs, and is repeated where one outside the window
//! has changed its order. So the answer is exact for any number of nodes.
//!
//! D does not change when a constant is added to all `rₖ`. Where the columns can add up to one,
//! that constant is set by the median of the residuals.
//!
//! Standard errors: `τ² (XᵀX)⁻¹`, `1/τ = √12 ∫f²`, the integral being the density at 0 of
//! differences of residuals (Koul, Sievers and McKean 1987; Hettmansperger and McKean 2011, section
//! 3.7); along the constant `τ_s = 1/(2f(0))`, as for a median.

use nalgebra::DMatrix;

use super::{
    approach::{At, Pieces, approach, approach_from},
    exact,
    outcome::{Along, Measured, Outcome, Solved},
    rows::{Rows, dot},
    scale::{NORMAL_QUARTILE, median},
    spacing::{pairs_within, sparsity_at_median, tau},
    vertex::{self, Lines},
};
use crate::{
    error::{FitError, Unconverged},
    result::{LocalSolution, Warning},
};
use flankfit_numerics::{
    cancel::{self, Asking},
    matvec,
    order::{Ordered, ordered},
};

/// Numbers in the rows of pairs of one round, at most.
const PAIRS: usize = 6_000_000;
const ROUNDS: usize = 60;
/// Numbers in the rows of pairs that are few.
const FEW: usize = 200_000;

/// Nodes from which on a sample of them leads the way, and how many are in it at least.
const MANY: usize = 8_000;
const SAMPLE: usize = 1_500;

/// Numbers that a processor takes at once.
const LANES: usize = 4;

pub(super) fn estimate(measured: &Measured) -> Result<Outcome, FitError> {
    let rows = Rows::new(measured)?;
    let (m, n) = (rows.count(), rows.n);
    let constant = constant(&rows);
    let free = Free::new(&rows, constant.as_deref());
    let mut walk = Search { x: vec![0.0; free.n], steps: 0, certificate: 0.0, optimal: true, unique: true };
    if free.n > 0 && m > 1 {
        let few = (FEW / (free.n + 5)).max(12 * free.n);
        let near = match m {
            ..MANY => approach(&free, few),
            _ => approach_from(free.by_sample(few), &free, few),
        };
        walk.x = near.x;
        walk.run(&free, near.radius)?;
    }
    let (x, residuals) = free.levelled(&walk.x, &rows, constant.as_deref());
    let mut warnings = Vec::new();
    if !walk.optimal {
        warnings.push(Warning::DispersionStopped);
    }
    if !walk.unique {
        warnings.push(Warning::DispersionNotUnique);
    }
    let order = ordered(&residuals);
    let mut scores = vec![0.0; m];
    order.from.iter().zip(scores_in_order(&order.sorted)).for_each(|(&k, a)| scores[k as usize] = a);
    let tau = tau(&order.sorted, n);
    let settled = exact::settled(tau, tau.filter(|_| m > n), &residuals, n, measured.heights.largest, &mut warnings);
    let scale = settled.scale.unwrap_or(0.0);
    let weight = |(a, r): (&f64, &f64)| if *r == 0.0 { 1.0 } else { (scale * (a / r).abs()).min(1.0) };
    let weights = settled.weights.unwrap_or_else(|| scores.iter().zip(&residuals).map(weight).collect());
    let along = constant.filter(|_| settled.dispersion.is_some()).and_then(|direction| {
        let size = sparsity_at_median(&order.sorted, n)?;
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
pub(super) fn constant(rows: &Rows) -> Option<Vec<f64>> {
    let mut e = vec![0.0; rows.n];
    for q in rows.q.chunks_exact(rows.n).asking(rows.n) {
        e.iter_mut().zip(q).for_each(|(e, q)| *e += q);
    }
    let root = (rows.count() as f64).sqrt();
    e.iter_mut().for_each(|e| *e /= root);
    ((dot(&e, &e) - 1.0).abs() < 1e-10).then_some(e)
}

/// The rows in the directions that D can see.
pub(super) struct Free<'a> {
    pub n: usize,
    /// A row in each column, filled up with zeros to a multiple of [`LANES`].
    a: DMatrix<f64>,
    /// Length of the longest row.
    longest: f64,
    b: &'a [f64],
    /// A reflection that turns the constant into the first axis: `I − 2 vvᵀ`.
    mirror: Option<Vec<f64>>,
}

impl<'a> Free<'a> {
    pub(super) fn new(rows: &'a Rows, constant: Option<&[f64]>) -> Self {
        let Some(e) = constant else {
            let seen = rows.q.chunks_exact(rows.n).asking(rows.n).map(|q| q.iter().copied());
            return Free::of(rows.n, in_columns(rows.n, rows.count(), seen), &rows.b, None);
        };
        let mut v = e.to_vec();
        v[0] += if v[0] < 0.0 { -1.0 } else { 1.0 };
        let length = dot(&v, &v).sqrt();
        v.iter_mut().for_each(|v| *v /= length);
        let n = rows.n - 1;
        let seen = rows.q.chunks_exact(rows.n).asking(rows.n).map(|q| {
            let twice = 2.0 * dot(q, &v);
            q.iter().zip(&v).skip(1).map(move |(q, v)| q - twice * v)
        });
        let a = in_columns(n, rows.count(), seen);
        Free::of(n, a, &rows.b, Some(v))
    }

    fn of(n: usize, a: DMatrix<f64>, b: &'a [f64], mirror: Option<Vec<f64>>) -> Self {
        let squares = a.as_slice().chunks_exact(a.nrows().max(1)).asking(n).map(|a| dot(a, a));
        Free { n, longest: squares.fold(0.0, f64::max).sqrt(), a, b, mirror }
    }

    /// Place of least dispersion of some of the rows.
    fn by_sample(&self, few: usize) -> Vec<f64> {
        let (m, size) = (self.count(), SAMPLE.max(40 * self.n).min(self.count()));
        // places that no period of the nodes can share; columns of about length 1 again
        let place = |j: usize| ((j as f64 * 0.618_033_988_749_894_9).fract() * m as f64) as usize;
        let root = (m as f64 / size as f64).sqrt();
        let b: Vec<f64> = (0..size).map(|j| self.b[place(j)]).collect();
        let some = (0..size).asking(self.n).map(|j| self.row(place(j)).iter().map(|a| a * root));
        let a = in_columns(self.n, size, some);
        let mut x = approach(&Free::of(self.n, a, &b, None), few).x;
        x.iter_mut().for_each(|x| *x *= root);
        x
    }

    /// The step `x` in all directions, and its residuals; those of a basis with the `constant` have
    /// their median at 0, which D does not see.
    pub(super) fn levelled(&self, x: &[f64], rows: &Rows, constant: Option<&[f64]>) -> (Vec<f64>, Vec<f64>) {
        let mut x = self.back(x);
        let residuals = rows.residuals(&x);
        let Some(e) = constant else { return (x, residuals) };
        let level = median(&mut residuals.clone()) * (rows.count() as f64).sqrt();
        x.iter_mut().zip(e).for_each(|(x, e)| *x += level * e);
        let residuals = rows.residuals(&x);
        (x, residuals)
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

    pub(super) fn count(&self) -> usize {
        self.b.len()
    }

    pub(super) fn row(&self, k: usize) -> &[f64] {
        &self.a.as_slice()[k * self.a.nrows()..][..self.n]
    }

    pub(super) fn residuals(&self, x: &[f64]) -> Vec<f64> {
        cancel::checkpoint();
        let mut filled = x.to_vec();
        filled.resize(self.a.nrows(), 0.0);
        let mut r = vec![0.0; self.count()];
        matvec::transposed_times(&self.a, &filled, &mut r);
        r.iter_mut().zip(self.b).for_each(|(r, b)| *r = b - *r);
        r
    }

    /// `Aᵀy`.
    fn sum(&self, y: &[f64]) -> Vec<f64> {
        cancel::checkpoint();
        let mut sum = vec![0.0; self.a.nrows()];
        matvec::times(&self.a, y, &mut sum);
        sum.truncate(self.n);
        sum
    }

    /// `Σ_{i<j} |rᵢ − rⱼ|`.
    fn spread(&self, x: &[f64]) -> f64 {
        let r = ordered(&self.residuals(x)).sorted;
        let m = r.len() as f64;
        r.iter().enumerate().map(|(i, r)| (2.0 * i as f64 + 1.0 - m) * r).sum()
    }
}

/// Rows of n numbers as columns that are filled up.
fn in_columns<R: Iterator<Item = f64>>(n: usize, count: usize, rows: impl Iterator<Item = R>) -> DMatrix<f64> {
    let mut a = DMatrix::zeros(n.next_multiple_of(LANES), count);
    let height = a.nrows().max(1);
    for (column, row) in a.as_mut_slice().chunks_exact_mut(height).zip(rows) {
        column.iter_mut().zip(row).for_each(|(to, x)| *to = x);
    }
    a
}

/// Wilcoxon scores of an ascending list, equal numbers sharing their mean.
fn scores_in_order(sorted: &[f64]) -> Vec<f64> {
    let m = sorted.len();
    let score = |rank: f64| 12f64.sqrt() * (rank / (m + 1) as f64 - 0.5);
    let mut scores: Vec<f64> = (1..=m).map(|rank| score(rank as f64)).collect();
    let mut from = 0;
    for equal in sorted.chunk_by(|a, b| a == b) {
        let to = from + equal.len();
        if equal.len() > 1 {
            scores[from..to].fill(score(0.5 * (from + to + 1) as f64));
        }
        from = to;
    }
    scores
}

/// D at a place.
pub(super) struct Evaluated {
    spread: f64,
    gradient: Vec<f64>,
    sorted: Vec<f64>,
}

impl At for Evaluated {
    fn value(&self) -> f64 {
        self.spread
    }

    fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}

/// A has orthonormal columns, so that `∇²D ≈ AᵀA/τ = I/τ`.
impl Pieces for Free<'_> {
    type Evaluated = Evaluated;

    fn size(&self) -> usize {
        self.n
    }

    fn at(&self, x: &[f64]) -> Evaluated {
        let Ordered { sorted, from } = ordered(&self.residuals(x));
        let ascending = scores_in_order(&sorted);
        let spread = ascending.iter().zip(&sorted).map(|(a, r)| a * r).sum();
        let mut scores = vec![0.0; sorted.len()];
        from.iter().zip(ascending).for_each(|(&k, a)| scores[k as usize] = a);
        let gradient = self.sum(&scores).into_iter().map(|g| -g).collect();
        Evaluated { spread, gradient, sorted }
    }

    /// τ of a normal law whose quartiles are as far apart as those of the residuals, wherever their
    /// level is; of the whole range if more than half of them are equal.
    fn inverse_curvature(&self, start: &Evaluated) -> f64 {
        let last = start.sorted.len() - 1;
        let between = |from: usize, to: usize| 0.5 * (start.sorted[to] - start.sorted[from]);
        let half = match between(last / 4, last - last / 4) {
            quartiles if quartiles > 0.0 => quartiles,
            _ => between(0, last),
        };
        (std::f64::consts::PI / 3.0).sqrt() * half / NORMAL_QUARTILE
    }

    fn kinks_within(&self, place: &Evaluated, distance: f64) -> usize {
        pairs_within(&place.sorted, 2.0 * self.longest * distance)
    }
}

struct Search {
    x: Vec<f64>,
    steps: usize,
    certificate: f64,
    optimal: bool,
    unique: bool,
}

impl Search {
    /// Walks from `self.x`, which is about `radius` away from the answer.
    fn run(&mut self, free: &Free, radius: f64) -> Result<(), FitError> {
        let (m, n) = (free.count(), free.n);
        let most = (PAIRS / (n + 5)).max(m);
        let limit = vertex::most_steps(most.min(m * m) * n);
        let mut here = free.spread(&self.x);
        let mut radius = radius;
        for _ in 0..ROUNDS {
            cancel::checkpoint();
            let order = ordered(&free.residuals(&self.x));
            let window = Window::new(&order.sorted, 2.0 * free.longest * radius, 8 * n, most);
            let round = Round::new(free, &order.from, window);
            let lines = Lines { n, rows: &round.rows, b: &round.b, g: &round.g };
            let Some(vertex) = vertex::minimise(&lines, &self.x, limit.saturating_sub(self.steps)) else {
                // the pairs do not span all directions: more of them do, or none
                if round.window.is_whole(m) || round.b.len() >= most {
                    return Err(FitError::NotConverged(Unconverged::RankDispersion));
                }
                radius = 4.0 * round.window.width / (2.0 * free.longest);
                continue;
            };
            self.steps += vertex.steps;
            self.certificate = vertex.certificate();
            self.unique = vertex.unique;
            self.optimal = vertex.optimal;
            if round.keeps_order(free, &order.from, &vertex.x) {
                self.x = vertex.x;
                return Ok(());
            }
            // the window's least value lies too far away: go there only as far as D falls
            let step: Vec<f64> = vertex.x.iter().zip(&self.x).map(|(v, x)| v - x).collect();
            radius = dot(&step, &step).sqrt();
            let mut length = 1.0;
            let mut moved = false;
            while length > 1e-9 && !moved {
                cancel::checkpoint();
                let next: Vec<f64> = self.x.iter().zip(&step).map(|(x, d)| x + length * d).collect();
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

/// Pairs of an order that may change it: each place with those up to `last`.
struct Window {
    last: Vec<usize>,
    /// Largest difference of residuals that was looked for.
    width: f64,
}

impl Window {
    /// Pairs whose residuals differ by no more than `width`, but at least `least` and at most
    /// `most` of them.
    fn new(sorted: &[f64], width: f64, least: usize, most: usize) -> Self {
        let m = sorted.len();
        let range = sorted[m - 1] - sorted[0];
        let least = least.min(m * (m - 1) / 2);
        let mut width = width.min(range).max(range * f64::EPSILON);
        while pairs_within(sorted, width) < least {
            width = (2.0 * width).min(range);
        }
        let mut low = 0.0;
        if pairs_within(sorted, width) > most {
            for _ in 0..50 {
                let middle = 0.5 * (low + width);
                if pairs_within(sorted, middle) > most { width = middle } else { low = middle }
            }
            width = low;
        }
        let mut last = ends(sorted, width);
        if last.iter().enumerate().map(|(place, last)| last - place).sum::<usize>() > most {
            // ties alone are too many: so many neighbours of each as may be
            let reach = (most / m).max(1);
            last = (0..m).map(|place| (place + reach).min(m - 1)).collect();
        }
        Window { last, width }
    }

    fn is_whole(&self, m: usize) -> bool {
        self.last[0] == m - 1
    }
}

/// For each place of an ascending list the last one that is no more than `width` above it.
fn ends(sorted: &[f64], width: f64) -> Vec<usize> {
    let mut end = 0;
    sorted
        .iter()
        .asking(2)
        .map(|low| {
            while end + 1 < sorted.len() && sorted[end + 1] - low <= width {
                end += 1;
            }
            end
        })
        .collect()
}

/// Pairs within a window of an order, and the linear rest.
struct Round {
    rows: Vec<f64>,
    b: Vec<f64>,
    g: Vec<f64>,
    window: Window,
}

impl Round {
    fn new(free: &Free, order: &[u32], window: Window) -> Self {
        let (m, n) = (free.count(), free.n);
        let pairs = window.last.iter().enumerate().map(|(place, last)| last - place).sum();
        let (mut rows, mut b) = (Vec::with_capacity(pairs * n), Vec::with_capacity(pairs));
        let mut g = vec![0.0; n];
        // the first place whose window reaches this one
        let mut first = 0;
        for (place, (&low, &last)) in order.iter().zip(&window.last).enumerate().asking(2 * n * (1 + pairs / m)) {
            let low = low as usize;
            for &high in &order[place + 1..=last] {
                let high = high as usize;
                rows.extend(free.row(high).iter().zip(free.row(low)).map(|(h, l)| h - l));
                b.push(free.b[high] - free.b[low]);
            }
            while window.last[first] < place {
                first += 1;
            }
            // pairs outside: r_high − r_low falls by (a_high − a_low)ᵀx
            let (below, above) = (first as f64, (m - 1 - last) as f64);
            g.iter_mut().zip(free.row(low)).for_each(|(g, a)| *g -= (below - above) * a);
        }
        Round { rows, b, g, window }
    }

    /// True if pairs outside the window are in the same order at `x`.
    fn keeps_order(&self, free: &Free, order: &[u32], x: &[f64]) -> bool {
        let r = free.residuals(x);
        // every one after the window must be above the largest up to its beginning
        let (mut largest, mut first) = (f64::NEG_INFINITY, 0);
        order.iter().enumerate().all(|(place, &k)| {
            while self.window.last[first] < place {
                largest = largest.max(r[order[first] as usize]);
                first += 1;
            }
            r[k as usize] >= largest
        })
    }
}
