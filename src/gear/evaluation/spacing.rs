//! How samples lie along the evaluation range: what length each stands for, holes between them, how much of the range
//! they cover.
//!
//! Positions are mapped to [-1, 1] and ascend. A mean curve is that of the deviation as a function of its place, not of
//! the samples that happen to have been taken: each sample stands for the length up to half-way to its neighbours, and
//! the outermost two beyond their ends for half the usual distance, so that equidistant samples count alike. Over a
//! hole nothing is known: a sample at its edge stands for no more than it would beside the longest distance that is not
//! a hole.

use crate::numerics::{cancel::Asking, quantiles::median};

/// Share of the evaluation range that the distance of two samples may be: no form deviation is told where it is longer.
/// ISO 1328-1:2013 filters profiles and helices with a cut-off of 1/30 of the range, so that a wave of 1/20 is still
/// there by three quarters and could hide in it.
pub const LONGEST_DISTANCE: f64 = 0.05;
/// Where samples are sparse all along, a hole is a distance of so many usual ones.
pub const HOLE_DISTANCES: f64 = 2.5;
/// Share of the evaluation range that samples must cover for any class.
pub const LEAST_COVERED: f64 = 0.75;

/// Places nearer than this, in the mapped coordinate, are one.
const SAME: f64 = 1e-9;

/// How samples lie.
#[derive(Clone, Debug, PartialEq)]
pub struct Spacing {
    /// The length that each sample stands for; samples at one place share it.
    pub weight: Vec<f64>,
    /// Places that differ.
    pub places: usize,
    /// Median distance of neighbouring places.
    pub usual: f64,
    /// From and to of distances that are holes.
    pub holes: Vec<[f64; 2]>,
    /// Share of the range that lies within the longest distance that is no hole.
    pub covered: f64,
}

impl Spacing {
    /// Of ascending places.
    pub fn of(u: &[f64]) -> Self {
        // first sample of each place, and its end
        let mut groups: Vec<[usize; 2]> = Vec::with_capacity(u.len());
        for (i, x) in u.iter().enumerate().asking(5) {
            match groups.last_mut() {
                Some(group) if x - u[group[0]] <= SAME => group[1] = i + 1,
                _ => groups.push([i, i + 1]),
            }
        }
        let at = |g: usize| u[groups[g][0]];
        let distances: Vec<f64> = (1..groups.len()).map(|g| at(g) - at(g - 1)).collect();
        let usual = if distances.is_empty() { 0.0 } else { median(&mut distances.clone()) };
        let longest = (2.0 * LONGEST_DISTANCE).max(HOLE_DISTANCES * usual);
        let side = |g: Option<&f64>| 0.5 * g.map_or(usual, |distance| distance.min(longest));
        let mut weight = vec![0.0; u.len()];
        for (g, &[from, to]) in groups.iter().enumerate().asking(5) {
            let before = g.checked_sub(1).and_then(|before| distances.get(before));
            let share = (side(before) + side(distances.get(g))) / (to - from) as f64;
            weight[from..to].fill(share);
        }
        let each = distances.iter().enumerate();
        let holes = each.filter(|(_, d)| **d > longest * (1.0 + SAME)).map(|(g, _)| [at(g), at(g + 1)]).collect();
        let covered = 0.5 * distances.iter().map(|distance| distance.min(longest)).sum::<f64>();
        Spacing { weight, places: groups.len(), usual, holes, covered: covered.min(1.0) }
    }

    /// Whether samples are farther from each other than form deviations can be told by, everywhere.
    pub fn is_sparse(&self) -> bool {
        self.usual > 2.0 * LONGEST_DISTANCE * (1.0 + SAME)
    }

    /// Whether the way from one place to another crosses a hole.
    pub fn crosses(&self, from: f64, to: f64) -> bool {
        self.holes.iter().any(|hole| from <= hole[0] && hole[1] <= to)
    }
}
