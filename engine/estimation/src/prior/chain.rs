//! The chain of earlier iterations: what they say of the coefficients now, for each size of the
//! moves between them.
//!
//! The likelihood of a size q is that of all rows with a flat prior on the first iteration,
//! `−½Σ‖e‖² − Σ ln|det W| − ln|det R|` with R after the last row: up to a constant the sum over
//! jumps of `−½(eᵀS⁻¹e + ln det S)`, S = P + Q + Cov.

use nalgebra::DVector;

use super::information::{Information, Spread};

/// An iteration: what its nodes say, and the move to the next one that is known.
pub(super) struct Link {
    pub rows: Information,
    pub shift: DVector<f64>,
}

/// Result of the chain for one size of its moves.
pub(super) struct Branch {
    /// Logarithm of the likelihood of the jumps before the last.
    pub ln_earlier: f64,
    /// Logarithm of the likelihood of all jumps.
    pub ln_all: f64,
    /// Before the nodes of now.
    pub prior: Information,
    /// With them.
    pub posterior: Information,
    /// `eᵀS⁻¹e` of the nodes of now.
    pub distance: f64,
}

impl Branch {
    /// Follows the links up to the rows of now. `None` without links, and where they leave
    /// coefficients free.
    pub(super) fn follow(links: &[Link], now: &Information, spread: &Spread) -> Option<Self> {
        let before = Before::of(links, spread)?;
        let ln_earlier = before.ln_earlier();
        Some(before.moved(now, spread, ln_earlier)).filter(|branch| branch.prior.is_whole())
    }

    /// Branches of size `q` whose last move was a step: of some size more, which of these nobody
    /// knows. `ln_earlier` is that of the earlier iterations on the whole.
    pub(super) fn steps(links: &[Link], now: &Information, q: f64, ln_earlier: f64) -> Vec<Self> {
        let Some(before) = Before::of(links, &Spread::Even(q)) else { return Vec::new() };
        steps().map(|step| before.moved(now, &Spread::Even(q.hypot(step)), ln_earlier)).collect()
    }

    /// A prior that is no chain.
    pub(super) fn of(prior: Information, now: &Information) -> Self {
        Self::last(prior, now, 0.0, 0.0)
    }

    fn last(prior: Information, now: &Information, ln_earlier: f64, ln: f64) -> Self {
        let (posterior, distance) = prior.with(now);
        Branch { ln_earlier, ln_all: ln - 0.5 * distance - posterior.ln_determinant(), prior, posterior, distance }
    }
}

/// State of knowledge before the last move.
struct Before<'a> {
    known: Information,
    shift: &'a DVector<f64>,
    ln: f64,
}

impl<'a> Before<'a> {
    fn of(links: &'a [Link], spread: &Spread) -> Option<Self> {
        let (first, rest) = links.split_first()?;
        let (mut known, mut shift, mut ln) = (first.rows.clone(), &first.shift, 0.0);
        for link in rest {
            let (moved, ln_w) = known.moved(shift, spread);
            let (with, square) = moved.with(&link.rows);
            ln -= 0.5 * square + ln_w;
            (known, shift) = (with, &link.shift);
        }
        Some(Before { known, shift, ln })
    }

    fn ln_earlier(&self) -> f64 {
        self.ln - self.known.ln_determinant()
    }

    /// After the last move; the likelihood of the nodes of now counts from `ln_earlier`.
    fn moved(&self, now: &Information, spread: &Spread, ln_earlier: f64) -> Branch {
        let (prior, ln_w) = self.known.moved(self.shift, spread);
        Branch::last(prior, now, ln_earlier, ln_earlier + self.known.ln_determinant() - ln_w)
    }
}

/// Sizes of a step in standard errors, even in the logarithm from 1 to 1,000.
pub(super) fn steps() -> impl ExactSizeIterator<Item = f64> {
    const POINTS: i32 = 7;
    (0..POINTS).map(|i| 10f64.sqrt().powi(i))
}

/// Sizes of moves in standard errors: 0 and 67 points of 0.01 … 20, even in the logarithm.
pub(super) fn ratios() -> impl Iterator<Item = f64> {
    const POINTS: u32 = 67;
    let (low, high) = (0.01f64.ln(), 20f64.ln());
    let step = (high - low) / f64::from(POINTS - 1);
    std::iter::once(0.0).chain((0..POINTS).map(move |i| (low + step * f64::from(i)).exp()))
}

/// Weights that add up to 1, from logarithms.
pub(super) fn weights(logarithms: impl Iterator<Item = f64>) -> Vec<f64> {
    let logarithms: Vec<f64> = logarithms.collect();
    let most = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let parts: Vec<f64> = logarithms.iter().map(|l| (l - most).exp()).collect();
    let sum: f64 = parts.iter().sum();
    parts.iter().map(|part| part / sum).collect()
}

/// `ln Σ exp`.
pub(super) fn ln_sum(logarithms: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = logarithms.clone().fold(f64::NEG_INFINITY, f64::max);
    most + logarithms.map(|l| (l - most).exp()).sum::<f64>().ln()
}

/// Index at which weights that add up to 1 reach one half.
pub(super) fn median(weights: impl Iterator<Item = f64>) -> usize {
    let mut sum = 0.0;
    let reached = weights.map(|weight| {
        sum += weight;
        sum
    });
    reached.enumerate().find(|(_, sum)| *sum >= 0.5).map_or(0, |(place, _)| place)
}
