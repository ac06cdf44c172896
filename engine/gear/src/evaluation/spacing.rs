//! Spacing of samples along the evaluation range: the length each represents, holes between them,
//! how much of the range they cover.
//!
//! Positions are mapped to [-1, 1] and ascend. A mean curve is that of the deviation as a function
//! of its place, not of the samples that happen to have been taken: each sample represents the
//! length up to half-way to its neighbours, and the outermost two outside their ends half the
//! usual distance, so that equidistant samples count alike. A sample at the edge of a hole
//! represents for half the usual distance into it; the rest of the hole is a gap ([`super::gap`]).
//! Shorter stretches with missing samples ([`super::missing`]) are bridged, but they are not
//! covered either.

use super::missing::missing;
use flankfit_numerics::{cancel::Asking, quantiles::median};

/// Share of the evaluation range that the distance of two samples may be: no form deviation is seen
/// where it is longer. ISO 1328-1:2013 filters profiles and helices with a cut-off of 1/30 of the
/// range, so that a wave of 1/20 is still there by three quarters and could hide in it.
pub const LONGEST_DISTANCE: f64 = 0.05;
/// Multiple of the usual distance that makes a hole where samples are sparse all along.
pub const HOLE_DISTANCES: f64 = 2.5;
/// Share of the evaluation range that samples must cover for any figure.
pub const LEAST_COVERED: f64 = 0.75;

/// Places nearer than this, in the mapped coordinate, are one.
const SAME: f64 = 1e-9;

/// How samples lie.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spacing {
    /// The length that each sample represents; samples at one place share it.
    pub weight: Vec<f64>,
    /// Places that differ.
    pub places: usize,
    /// Median distance of neighbouring places.
    pub usual: f64,
    /// From and to of distances that are holes.
    pub holes: Vec<[f64; 2]>,
    /// Stretches of the range that no sample represents: the inside of holes, and ends that are not
    /// reached.
    pub gaps: Vec<[f64; 2]>,
    /// Share of the range between an end that is not reached and the nearest sample, the greater of
    /// both ends; 0 where both are reached to one distance of neighbouring samples.
    pub open_end: f64,
    /// From and to of distances with missing samples that are no holes.
    pub missing: Vec<[f64; 2]>,
    /// Share of the range between samples without a hole or missing samples between them.
    pub covered: f64,
}

impl Spacing {
    /// Returns the spacing of ascending places.
    pub(crate) fn of(u: &[f64]) -> Self {
        Self::with_neighbours(u, [None; 2])
    }

    /// Returns the spacing of ascending places within the range, with the nearest samples outside
    /// it.
    pub(crate) fn with_neighbours(u: &[f64], beyond: [Option<f64>; 2]) -> Self {
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
        let is_hole = |distance: f64| distance > longest * (1.0 + SAME);
        let each = distances.iter().enumerate();
        let holes: Vec<[f64; 2]> = each.filter(|(_, d)| is_hole(**d)).map(|(g, _)| [at(g), at(g + 1)]).collect();
        let lost = missing(&distances, 2.0);
        let each = distances.iter().zip(&lost).enumerate();
        let missing: Vec<[f64; 2]> =
            each.filter(|(_, (d, lost))| **lost && !is_hole(**d)).map(|(g, _)| [at(g), at(g + 1)]).collect();
        let each = distances.iter().zip(&lost);
        let covered = 0.5 * each.filter(|(d, lost)| !**lost && !is_hole(**d)).map(|(d, _)| d).sum::<f64>();
        let [first, last] = if groups.is_empty() { [1.0, -1.0] } else { [at(0), at(groups.len() - 1)] };
        // samples are discrete: one distance to the end is none too many, nor is a way across it
        // that is no hole
        let open = |distance: f64, across: Option<f64>| match across {
            _ if distance <= usual * (1.0 + SAME) => 0.0,
            Some(across) if !is_hole(across) => 0.0,
            _ => distance,
        };
        let ends = [open(first + 1.0, beyond[0].map(|u| first - u)), open(1.0 - last, beyond[1].map(|u| u - last))];
        let lower = (ends[0] > 0.0).then_some([-1.0, first - 0.5 * usual]);
        let upper = (ends[1] > 0.0).then_some([last + 0.5 * usual, 1.0]);
        let inside = holes.iter().map(|[from, to]| [from + 0.5 * usual, to - 0.5 * usual]);
        let gaps: Vec<[f64; 2]> = lower.into_iter().chain(inside).chain(upper).collect();
        // next to a gap the whole range is to be counted, no less and no more
        let outer = |to_end: f64, is_open: bool, beyond: Option<f64>| match (gaps.is_empty() || is_open, beyond) {
            (true, _) => 0.5 * usual,
            (false, Some(_)) => to_end.max(0.0),
            (false, None) => to_end.max(0.5 * usual),
        };
        let [below, above] =
            [outer(first + 1.0, ends[0] > 0.0, beyond[0]), outer(1.0 - last, ends[1] > 0.0, beyond[1])];
        let side = |distance: f64| 0.5 * if is_hole(distance) { usual } else { distance };
        let mut weight = vec![0.0; u.len()];
        for (g, &[from, to]) in groups.iter().enumerate().asking(5) {
            let before = g.checked_sub(1).map_or(below, |before| side(distances[before]));
            let behind = distances.get(g).map_or(above, |distance| side(*distance));
            // a sample at the very end of the range still counts
            weight[from..to].fill((before + behind).max(SAME) / (to - from) as f64);
        }
        Spacing {
            weight,
            places: groups.len(),
            usual,
            gaps,
            open_end: 0.5 * ends[0].max(ends[1]),
            covered,
            holes,
            missing,
        }
    }

    /// Whether slope and crowning can be determined: from three quarters of the range, and no
    /// farther outside the samples than the longest distance that is no hole.
    pub(crate) fn determines_figures(&self) -> bool {
        self.covered >= LEAST_COVERED && self.open_end <= LONGEST_DISTANCE * (1.0 + SAME)
    }

    /// Share of the range in stretches with missing samples that are no holes.
    pub(crate) fn share_missing(&self) -> f64 {
        0.5 * self.missing.iter().map(|[from, to]| to - from).sum::<f64>()
    }

    /// Whether samples are farther from each other than form deviations can be seen by, everywhere.
    pub(crate) fn is_sparse(&self) -> bool {
        self.usual > 2.0 * LONGEST_DISTANCE * (1.0 + SAME)
    }

    /// Whether the way from one place to another crosses a hole.
    pub(crate) fn crosses(&self, from: f64, to: f64) -> bool {
        self.holes.iter().any(|hole| from <= hole[0] && hole[1] <= to)
    }
}
