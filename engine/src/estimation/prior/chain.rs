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

/// What the chain says if its moves spread in one way.
pub(super) struct Branch {
    /// Of the jumps before the last.
    pub ln_earlier: f64,
    /// Of all.
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
        let (first, rest) = links.split_first()?;
        let (mut known, mut shift, mut ln) = (first.rows.clone(), &first.shift, 0.0);
        for link in rest {
            let (moved, ln_w) = known.moved(shift, spread);
            let (with, square) = moved.with(&link.rows);
            ln -= 0.5 * square + ln_w;
            (known, shift) = (with, &link.shift);
        }
        let ln_earlier = ln - known.ln_determinant();
        let (prior, ln_w) = known.moved(shift, spread);
        Some(Self::last(prior, now, ln_earlier, ln - ln_w)).filter(|branch| branch.prior.is_whole())
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
