//! Least `F(x) = Σ |bₖ − aₖᵀx| + gᵀx`, solved exactly by walking over vertices.
//!
//! F is convex and piecewise linear, so that a least value lies at a vertex, where n independent
//! rows (the *basis* B) have residual 0 (Barrodale and Roberts 1973; Bartels, Conn and Sinclair
//! 1978). At a vertex the numbers `d` with `A_Bᵀ d = g − Σ_{k∉B} sign(rₖ) aₖ` are the dual solution
//! on the basis: all |dᵢ| ≤ 1 prove that the vertex is optimal. Otherwise the edge on which
//! residual i leaves 0 leads down; F is followed along it through all kinks to its least value,
//! where another residual reaches 0 and takes the place of i.
//!
//! Residuals that are 0 without being in the basis (repeated measurements, round numbers) are
//! distinguished as if every height had been moved by an infinitely small amount of its own: each
//! residual is a pair, compared in order. So no walk goes in a circle, and the signs that the moved
//! problem gives to such residuals serve in the certificate.

use nalgebra::DMatrix;

use super::{random::SplitMix, rows::dot};
use flankfit_numerics::{
    cancel::{self, Asking},
    inverse,
};

/// Residuals below this share of the largest height count as 0.
const ZERO: f64 = 1e-13;
/// A dual above 1 by less than this is rounding.
const SLACK: f64 = 1e-9;
/// Changes of the basis after which everything is computed afresh.
const FRESH: usize = 32;

/// A problem: rows one after the other, heights, and the linear part.
pub(super) struct Lines<'a> {
    pub n: usize,
    pub rows: &'a [f64],
    pub b: &'a [f64],
    pub g: &'a [f64],
}

/// Final vertex of the walk.
pub(super) struct Vertex {
    /// The rows of residual 0 that determine `x`.
    pub basis: Vec<usize>,
    pub x: Vec<f64>,
    /// Dual solution: ±1 off the basis, what balances it on the basis.
    pub dual: Vec<f64>,
    /// Changes of the basis.
    pub steps: usize,
    /// True if every dual on the basis is within [−1, 1].
    pub optimal: bool,
    /// True if no edge of the same value leaves the vertex.
    pub unique: bool,
}

impl Vertex {
    /// `max |dᵢ|` on the basis: at most 1 (but for rounding) where the vertex is optimal.
    pub(super) fn certificate(&self) -> f64 {
        self.basis.iter().map(|&k| self.dual[k].abs()).fold(0.0, f64::max)
    }
}

/// Steps that a walk over this many numbers may take, so that it ends within a minute or so; a
/// hundred times what it takes as a rule.
pub(super) fn most_steps(numbers: usize) -> usize {
    (40_000_000_000 / numbers.max(1)).clamp(1_000, 100_000)
}

/// Walks from the vertex nearest to `start`, for at most `limit` steps. `None` when the rows do not
/// span.
pub(super) fn minimise(lines: &Lines, start: &[f64], limit: usize) -> Option<Vertex> {
    let mut walk = Walk::new(lines, start)?;
    let mut steps = 0;
    let optimal = loop {
        cancel::checkpoint();
        match walk.worst() {
            None => {
                // only what was computed afresh is believed
                if walk.since_fresh == 0 {
                    break true;
                }
                walk.refresh()?;
            }
            Some(_) if steps == limit => break false,
            Some((i, side)) => {
                if !walk.descend(i, side) {
                    break false;
                }
                steps += 1;
                if walk.since_fresh >= FRESH {
                    walk.refresh()?;
                }
            }
        }
    };
    let unique = optimal && walk.is_unique();
    let mut dual = walk.sign;
    for (&k, d) in walk.basis.iter().zip(&walk.dual) {
        dual[k] = *d;
    }
    Some(Vertex { basis: walk.basis, x: walk.x, dual, steps, optimal, unique })
}

struct Walk<'a> {
    lines: &'a Lines<'a>,
    zero: f64,
    /// The infinitely small moves of the heights.
    moves: Vec<f64>,
    basis: Vec<usize>,
    inverse: DMatrix<f64>,
    x: Vec<f64>,
    /// Residuals, and their infinitely small part.
    r: Vec<f64>,
    p: Vec<f64>,
    /// Sides of the residuals; 0 on the basis.
    sign: Vec<f64>,
    /// `g − Σ sign a` and what balances it.
    pull: Vec<f64>,
    dual: Vec<f64>,
    since_fresh: usize,
}

impl<'a> Walk<'a> {
    fn new(lines: &'a Lines, start: &[f64]) -> Option<Self> {
        let count = lines.b.len();
        let r: Vec<f64> = residuals(lines, start);
        let basis = nearest_basis(lines, &r)?;
        let largest = lines.b.iter().map(|b| b.abs()).fold(0.0, f64::max);
        let mut random = SplitMix::new(0);
        let moves = (0..count)
            .map(|_| {
                let size = 0.5 + random.unit();
                if random.unit() < 0.5 { -size } else { size }
            })
            .collect();
        let mut walk = Walk {
            lines,
            zero: ZERO * largest,
            moves,
            basis,
            inverse: DMatrix::zeros(lines.n, lines.n),
            x: Vec::new(),
            r,
            p: Vec::new(),
            sign: Vec::new(),
            pull: Vec::new(),
            dual: Vec::new(),
            since_fresh: 0,
        };
        walk.refresh()?;
        Some(walk)
    }

    fn row(&self, k: usize) -> &'a [f64] {
        &self.lines.rows[k * self.lines.n..][..self.lines.n]
    }

    /// Everything that follows from the basis (and from the sides of residuals that are 0),
    /// computed afresh.
    fn refresh(&mut self) -> Option<()> {
        let n = self.lines.n;
        let a = DMatrix::from_fn(n, n, |i, j| self.row(self.basis[i])[j]);
        self.inverse = inverse(a)?;
        let solve = |heights: &[f64]| -> Vec<f64> {
            let at = |x: &[f64]| -> Vec<f64> {
                self.basis.iter().map(|&k| heights[k] - dot(self.row(k), x)).collect::<Vec<f64>>()
            };
            let apply = |right: &[f64]| -> Vec<f64> {
                (0..n).map(|i| (0..n).map(|j| self.inverse[(i, j)] * right[j]).sum()).collect()
            };
            let mut x = apply(&at(&vec![0.0; n]));
            let correction = apply(&at(&x));
            x.iter_mut().zip(correction).for_each(|(x, d)| *x += d);
            x
        };
        let (x, moved) = (solve(self.lines.b), solve(&self.moves));
        self.r = residuals(self.lines, &x);
        self.p =
            self.moves.iter().zip(self.lines.rows.chunks_exact(n)).asking(n).map(|(b, a)| b - dot(a, &moved)).collect();
        self.x = x;
        for &k in &self.basis {
            (self.r[k], self.p[k]) = (0.0, 0.0);
        }
        let zero = self.zero;
        self.sign =
            self.r.iter().zip(&self.p).map(|(r, p)| if r.abs() > zero { r.signum() } else { p.signum() }).collect();
        for &k in &self.basis {
            self.sign[k] = 0.0;
        }
        self.pull = self.lines.g.to_vec();
        for (a, sign) in self.lines.rows.chunks_exact(n).zip(&self.sign).asking(n) {
            self.pull.iter_mut().zip(a).for_each(|(h, a)| *h -= sign * a);
        }
        self.since_fresh = 0;
        self.balance();
        Some(())
    }

    fn balance(&mut self) {
        self.dual = self.inverse.column_iter().map(|column| dot(column.as_slice(), &self.pull)).collect();
    }

    /// The edge that leads down most steeply, and to which side; `None` at an optimal vertex.
    fn worst(&self) -> Option<(usize, f64)> {
        let mut worst = None;
        let mut steepest = 0.0;
        for (i, d) in self.dual.iter().enumerate() {
            let beyond = d.abs() - 1.0;
            if beyond > SLACK {
                let slope = beyond / self.inverse.column(i).norm();
                if slope > steepest {
                    (worst, steepest) = (Some((i, d.signum())), slope);
                }
            }
        }
        worst
    }

    /// Rate at which each residual falls along the edge on which residual i of the basis leaves 0
    /// to `side`.
    fn edge(&self, i: usize, side: f64) -> Vec<f64> {
        let n = self.lines.n;
        let direction: Vec<f64> = self.inverse.column(i).iter().map(|x| -side * x).collect();
        let size = dot(&direction, &direction).sqrt();
        let still = 1e-11 * size;
        let mut rates: Vec<f64> = self
            .lines
            .rows
            .chunks_exact(n)
            .asking(n)
            .map(|a| dot(a, &direction))
            .map(|q| if q.abs() > still { q } else { 0.0 })
            .collect();
        for &k in &self.basis {
            rates[k] = 0.0;
        }
        rates
    }

    /// The kinks ahead on an edge.
    fn kinks(&self, rates: &[f64]) -> Vec<Kink> {
        (0..rates.len())
            .filter(|&k| self.sign[k] * rates[k] > 0.0)
            .map(|k| {
                let far = self.r[k].abs() > self.zero && self.r[k] * self.sign[k] > 0.0;
                let at = if far { self.r[k] / rates[k] } else { 0.0 };
                Kink { at, then: self.p[k] / rates[k], row: k, turn: 2.0 * rates[k].abs() }
            })
            .collect()
    }

    /// Follows F down the edge; false when it falls for ever.
    fn descend(&mut self, i: usize, side: f64) -> bool {
        let n = self.lines.n;
        let rates = self.edge(i, side);
        let mut kinks = self.kinks(&rates);
        let slope = 1.0 - self.dual[i].abs();
        let Some(last) = stop(&mut kinks, slope) else { return false };
        let Kink { at, then, row: entering, .. } = kinks[last];
        for kink in &kinks[..last] {
            let k = kink.row;
            let turned = 2.0 * self.sign[k];
            self.sign[k] = -self.sign[k];
            let a = &self.lines.rows[k * n..][..n];
            self.pull.iter_mut().zip(a).for_each(|(h, a)| *h += turned * a);
        }
        for ((r, p), q) in self.r.iter_mut().zip(&mut self.p).zip(&rates) {
            *r -= at * q;
            *p -= then * q;
        }
        let leaving = self.basis[i];
        // along the edge residual i grows at unit rate
        (self.r[leaving], self.p[leaving], self.sign[leaving]) = (side * at, side * then, side);
        let (out, into) = (self.row(leaving), self.row(entering));
        let was = self.sign[entering];
        for ((h, o), e) in self.pull.iter_mut().zip(out).zip(into) {
            *h += was * e - side * o;
        }
        (self.r[entering], self.p[entering], self.sign[entering]) = (0.0, 0.0, 0.0);
        for (x, d) in self.x.iter_mut().zip(self.inverse.column(i).iter()) {
            *x -= side * at * d;
        }
        self.basis[i] = entering;
        // row i of A_B is another: its inverse changes by a product of a column and a row
        let along: Vec<f64> = self.inverse.column_iter().map(|column| dot(column.as_slice(), into)).collect();
        let column: Vec<f64> = self.inverse.column(i).iter().map(|x| x / along[i]).collect();
        for (j, mut other) in self.inverse.column_iter_mut().enumerate() {
            if j == i {
                other.copy_from_slice(&column);
            } else {
                other.iter_mut().zip(&column).for_each(|(x, c)| *x -= along[j] * c);
            }
        }
        self.since_fresh += 1;
        self.balance();
        true
    }

    /// True if every edge on which F would keep its value has no length.
    fn is_unique(&self) -> bool {
        let flat = |i: usize| {
            let rates = self.edge(i, self.dual[i].signum());
            self.kinks(&rates).iter().map(|kink| kink.at).fold(f64::INFINITY, f64::min) > 0.0
        };
        !(0..self.lines.n).any(|i| self.dual[i].abs() >= 1.0 - SLACK && flat(i))
    }
}

fn residuals(lines: &Lines, x: &[f64]) -> Vec<f64> {
    lines.b.iter().zip(lines.rows.chunks_exact(lines.n)).asking(lines.n).map(|(b, a)| b - dot(a, x)).collect()
}

/// Place on an edge at which a residual reaches 0, and the change of F's slope there.
#[derive(Clone, Copy)]
struct Kink {
    at: f64,
    then: f64,
    row: usize,
    turn: f64,
}

/// Puts the kinks that are passed first and returns the index of the one at which F stops falling.
fn stop(kinks: &mut [Kink], slope: f64) -> Option<usize> {
    let order = |a: &Kink, b: &Kink| a.at.total_cmp(&b.at).then(a.then.total_cmp(&b.then)).then(a.row.cmp(&b.row));
    let (mut low, mut high, mut slope) = (0, kinks.len(), slope);
    if slope + kinks.iter().map(|kink| kink.turn).sum::<f64>() < 0.0 || kinks.is_empty() {
        return None;
    }
    while high - low > 1 {
        let middle = (high - low) / 2;
        kinks[low..high].select_nth_unstable_by(middle, cancel::comparing(order));
        let before: f64 = kinks[low..low + middle].iter().map(|kink| kink.turn).sum();
        if slope + before < 0.0 {
            slope += before;
            low += middle;
        } else {
            high = low + middle;
        }
    }
    Some(low)
}

/// Independent rows with residuals as small as they come.
fn nearest_basis(lines: &Lines, r: &[f64]) -> Option<Vec<usize>> {
    let n = lines.n;
    let mut order: Vec<usize> = (0..r.len()).collect();
    order.sort_by(cancel::comparing(|&a: &usize, &b: &usize| r[a].abs().total_cmp(&r[b].abs()).then(a.cmp(&b))));
    let mut basis: Vec<usize> = Vec::with_capacity(n);
    let mut directions: Vec<Vec<f64>> = Vec::with_capacity(n);
    // first only rows that are well separated, then whatever is independent at all
    for apart in [0.1, 1e-3, 1e-6, 1e-10] {
        for &k in &order {
            if basis.len() == n {
                return Some(basis);
            }
            let row = &lines.rows[k * n..][..n];
            let length = dot(row, row).sqrt();
            if length == 0.0 || basis.contains(&k) {
                continue;
            }
            cancel::checkpoint();
            let mut rest: Vec<f64> = row.iter().map(|x| x / length).collect();
            for _ in 0..2 {
                for direction in &directions {
                    let along = dot(direction, &rest);
                    rest.iter_mut().zip(direction).for_each(|(x, d)| *x -= along * d);
                }
            }
            let left = dot(&rest, &rest).sqrt();
            if left > apart {
                directions.push(rest.iter().map(|x| x / left).collect());
                basis.push(k);
            }
        }
    }
    (basis.len() == n).then_some(basis)
}
