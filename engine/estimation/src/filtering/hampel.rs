//! Peak removal by Hampel's identifier: a node is a peak when it lies further than `t · S` from the
//! median of its window.
//!
//! S = 1.4826 · MAD, MAD being the median distance of the window's nodes from their median; where
//! more than half of them agree (MAD = 0, common with coarse resolution) S = 1.2533 times their
//! mean distance instead, and where all agree nothing is a peak. Both factors make S the standard
//! deviation of normal noise. Windows hold nodes that are there: along a line the `(window − 1)/2`
//! nearest on each side, on a grid without axis those of a square of grid places; at the ends they
//! are one-sided. Every decision is taken on the heights as they come in, hence does not depend on
//! the order of nodes. Source: Hampel, JASA 69 (1974); Davies and Gather, JASA 88 (1993).

use rayon::prelude::*;

use super::lines::Lines;
use flankfit_numerics::{
    cancel::{self, Asking},
    quantiles::median,
};

/// Standard deviation of normal noise over its MAD, and over its mean absolute deviation.
const MAD: f64 = 1.482_602_218_505_602;
const MEAN: f64 = 1.253_314_137_315_500_3;

/// A peak, and the height that would replace it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    /// The posted node.
    pub node: usize,
    /// The median of its window.
    pub median: f64,
    /// The node or the two nodes (else the same twice) whose heights that median is made of.
    pub taken: [usize; 2],
}

/// Peaks along lines, in ascending order of node.
pub(super) fn along(lines: &Lines, z: &[f64], present: &[bool], window: usize, threshold: f64) -> Vec<Peak> {
    let reach = window / 2;
    let handle = cancel::current();
    let line = |line: usize| {
        let there: Vec<usize> =
            (0..lines.places()).map(|place| lines.node(line, place)).filter(|&node| present[node]).collect();
        let found: Vec<Peak> = (0..there.len())
            .asking(20 * window)
            .filter_map(|i| {
                let window = &there[i.saturating_sub(reach)..(i + reach + 1).min(there.len())];
                judge(there[i], window, z, threshold)
            })
            .collect();
        found
    };
    let mut peaks: Vec<Peak> =
        (0..lines.count).into_par_iter().flat_map_iter(|at| cancel::carry(handle.as_ref(), || line(at))).collect();
    peaks.sort_unstable_by_key(|peak| peak.node);
    peaks
}

/// Peaks of a grid of `nu × nv` places under a square window.
pub(super) fn over(shape: (usize, usize), z: &[f64], present: &[bool], window: usize, threshold: f64) -> Vec<Peak> {
    let (nu, nv) = shape;
    let reach = window / 2;
    let around = |i: usize, n: usize| i.saturating_sub(reach)..(i + reach + 1).min(n);
    let handle = cancel::current();
    let row = |i: usize| {
        // no window holds more than the grid, whatever its requested size
        let mut here = Vec::with_capacity(window.min(nu) * window.min(nv));
        let found: Vec<Peak> = (0..nv)
            .asking(20 * window.min(nu) * window.min(nv))
            .filter(|j| present[i * nv + j])
            .filter_map(|j| {
                here.clear();
                for k in around(i, nu) {
                    here.extend(around(j, nv).map(|l| k * nv + l).filter(|&node| present[node]));
                }
                judge(i * nv + j, &here, z, threshold)
            })
            .collect();
        found
    };
    (0..nu).into_par_iter().flat_map_iter(|i| cancel::carry(handle.as_ref(), || row(i))).collect()
}

fn judge(node: usize, window: &[usize], z: &[f64], threshold: f64) -> Option<Peak> {
    let mut heights: Vec<f64> = window.iter().map(|&k| z[k]).collect();
    let middle = median(&mut heights);
    let distance = (z[node] - middle).abs();
    if distance == 0.0 {
        return None;
    }
    heights.iter_mut().for_each(|h| *h = (*h - middle).abs());
    let mean = heights.iter().map(|h| h / heights.len() as f64).sum::<f64>();
    let spread = match median(&mut heights) {
        0.0 => MEAN * mean,
        mad => MAD * mad,
    };
    if distance <= threshold * spread {
        return None;
    }
    let mut order = window.to_vec();
    order.sort_unstable_by(|&i, &j| z[i].total_cmp(&z[j]).then(i.cmp(&j)));
    let n = order.len();
    Some(Peak { node, median: middle, taken: [order[(n - 1) / 2], order[n / 2]] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(z: &[f64], present: &[bool], window: usize) -> Vec<Peak> {
        let x: Vec<f64> = (0..z.len()).map(|i| i as f64).collect();
        along(&Lines::single(&x), z, present, window, 3.0)
    }

    #[test]
    fn a_peak_takes_the_median_of_its_window() {
        let z = [0.0, 0.2, 0.1, 9.0, 0.3, 0.15, 0.25, 0.1];
        let peaks = found(&z, &[true; 8], 7);
        // of 0, 0.2, 0.1, 9, 0.3, 0.15, 0.25 the middle is 0.2
        assert_eq!(peaks, [Peak { node: 3, median: 0.2, taken: [1, 1] }]);
        let mut present = [true; 8];
        present[3] = false;
        assert_eq!(found(&z, &present, 7), []);
    }

    #[test]
    fn windows_are_one_sided_at_the_ends_and_slopes_are_no_peaks() {
        let line: Vec<f64> = (0..20).map(|i| 5.0 * f64::from(i)).collect();
        assert_eq!(found(&line, &[true; 20], 7), []);
        let mut end = line.clone();
        end[19] = 300.0;
        // of the window 80, 85, 90, 300 the middle lies between 85 and 90
        assert_eq!(found(&end, &[true; 20], 7), [Peak { node: 19, median: 87.5, taken: [17, 18] }]);
    }

    #[test]
    fn where_most_nodes_agree_the_mean_distance_decides() {
        let mut z = [1.0; 9];
        assert_eq!(found(&z, &[true; 9], 7), []);
        z[4] = 2.0;
        // mean distance 1/7: 1 > 3 · 1.2533/7
        assert_eq!(found(&z, &[true; 9], 7).len(), 1);
        assert_eq!(along(&Lines::single(&[0.0, 1.0, 2.0]), &[1.0, 1.0, 2.0], &[true; 3], 3, 3.0), []);
    }

    #[test]
    fn a_square_window_sees_a_peak_that_a_line_of_peaks_hides() {
        let (nu, nv) = (9, 9);
        let mut z = vec![0.0; nu * nv];
        for (i, z) in z.iter_mut().enumerate() {
            *z = 0.01 * ((i * 37 % 17) as f64);
        }
        (0..nv).for_each(|j| z[4 * nv + j] = 5.0);
        let peaks = over((nu, nv), &z, &[true; 81], 5, 3.0);
        assert_eq!(peaks.iter().map(|p| p.node).collect::<Vec<_>>(), (36..45).collect::<Vec<_>>());
        let grid_lines = Lines::single(&(0..9).map(f64::from).collect::<Vec<_>>());
        assert!(!along(&grid_lines, &z[36..45], &[true; 9], 5, 3.0).iter().any(|p| p.median > 5.0));
    }
}
