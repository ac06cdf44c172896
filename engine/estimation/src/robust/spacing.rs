//! Density of residuals: the density of their differences at 0, and their own at the median.

use flankfit_numerics::cancel::{self, Asking};

/// Pairs of an ascending list that are no further apart than `width`.
pub(super) fn pairs_within(sorted: &[f64], width: f64) -> usize {
    let (mut low, mut count) = (0, 0);
    for high in (0..sorted.len()).asking(2) {
        while sorted[high] - sorted[low] > width {
            low += 1;
        }
        count += high - low;
    }
    count
}

/// τ of the standard errors, from ascending residuals; `None` where residuals are all equal or too
/// few.
pub(super) fn tau(r: &[f64], n: usize) -> Option<f64> {
    let m = r.len();
    if m <= n + 1 || m < 3 {
        return None;
    }
    let pairs = m as f64 * (m - 1) as f64 / 2.0;
    // share of pairs no further apart than y
    let share = |y: f64| pairs_within(r, y) as f64 / pairs;
    let range = r[m - 1] - r[0];
    if range <= 0.0 {
        return None;
    }
    let high = distance_of(r, (0.8 * pairs).ceil() as usize).max(range * 0.5f64.powi(60));
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

/// The least distance that so many pairs of an ascending list do not exceed.
fn distance_of(sorted: &[f64], wanted: usize) -> f64 {
    let m = sorted.len();
    let range = sorted[m - 1] - sorted[0];
    let mut bracket = Bracket { sorted, wanted, low: (0.0, pairs_within(sorted, 0.0)), high: (range, m * (m - 1) / 2) };
    if bracket.low.1 >= wanted {
        return 0.0;
    }
    while bracket.high.1 - bracket.low.1 > 4 * m {
        let width = bracket.width();
        if width <= range * 0.5f64.powi(60) {
            return bracket.high.0;
        }
        let chord = bracket.chord();
        bracket.look(chord - 0.05 * width);
        bracket.look(chord + 0.05 * width);
        if bracket.width() > 0.5 * width {
            bracket.look(0.5 * (bracket.low.0 + bracket.high.0));
        }
    }
    bracket.select()
}

/// Two distances, each with the number of pairs that do not exceed it, and fewer than `wanted` only
/// at the lower one.
struct Bracket<'a> {
    sorted: &'a [f64],
    wanted: usize,
    low: (f64, usize),
    high: (f64, usize),
}

impl Bracket<'_> {
    fn width(&self) -> f64 {
        self.high.0 - self.low.0
    }

    /// Place at which the chord of the counts reaches the wanted one.
    fn chord(&self) -> f64 {
        let share = (self.wanted - self.low.1) as f64 / (self.high.1 - self.low.1) as f64;
        self.low.0 + share * self.width()
    }

    fn look(&mut self, at: f64) {
        if at > self.low.0 && at < self.high.0 {
            let count = pairs_within(self.sorted, at);
            *(if count >= self.wanted { &mut self.high } else { &mut self.low }) = (at, count);
        }
    }

    /// The distance itself, from all pairs in between.
    fn select(&self) -> f64 {
        let (mut first, mut last) = (0, 0);
        let mut between = Vec::with_capacity(self.high.1 - self.low.1);
        for &x in self.sorted.iter().asking(8) {
            while x - self.sorted[first] > self.high.0 {
                first += 1;
            }
            while x - self.sorted[last] > self.low.0 {
                last += 1;
            }
            between.extend(self.sorted[first..last].iter().map(|y| x - y));
        }
        *between.select_nth_unstable_by(self.wanted - self.low.1 - 1, cancel::comparing(f64::total_cmp)).1
    }
}

/// 1/f(0) of ascending residuals about their median, over the middle of them that a normal law
/// would put within ±1/√m of its σ.
pub(super) fn sparsity_at_median(r: &[f64], n: usize) -> Option<f64> {
    let m = r.len();
    if m <= n + 1 {
        return None;
    }
    let half = ((m as f64).sqrt().ceil() as usize).max(1);
    let (low, high) = (((m - 1) / 2).saturating_sub(half), (m / 2 + half).min(m - 1));
    let size = (r[high] - r[low]) * m as f64 / (high - low) as f64 * (m as f64 / (m - n) as f64).sqrt();
    (size > 0.0 && size.is_finite()).then_some(size)
}
