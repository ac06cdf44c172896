//! Filters at work: checked against the nodes, applied one after the other, kept as the linear maps
//! they turned out to be.
//!
//! A filter decides on heights (peaks, robustness weights). Once it has decided, what it does to
//! the heights is linear, and the same map can be applied to the columns of X: that is what
//! [`Step`] keeps.

use super::{
    gaussian::{GaussianFilter, ROUNDS},
    hampel::{self, Peak},
    lines::Lines,
    spline::SplineFilter,
};
use crate::{
    data::{Grid, Nodes},
    result::{FilterReport, IterationReport, Warning},
    spec::{Action, Filter, FilterAxis, Gaussian, Hampel, Order, Spline},
};
use flankfit_numerics::{cancel::Asking, check::Faults, words::Shown};

/// Products of a weight and a height that a linear filter may take, and one round of a robust one.
const MOST_PRODUCTS: usize = 1_000_000_000;
const MOST_ROBUST_PRODUCTS: usize = 20_000_000;
/// Heights that the windows of a Hampel filter may hold, all together.
const MOST_WINDOWED: usize = 200_000_000;

/// A filter with its decisions taken.
pub(super) enum Step {
    /// Peaks took the heights of other nodes.
    Replaced(Vec<Peak>),
    /// Peaks are missing from here on.
    Removed,
    Gaussian {
        filter: GaussianFilter,
        lines: Lines,
        axis: FilterAxis,
        present: Vec<bool>,
        delta: Option<Vec<f64>>,
    },
    Spline {
        filter: SplineFilter,
        lines: Lines,
        axis: FilterAxis,
        present: Vec<bool>,
    },
}

impl Step {
    /// Does to columns of numbers, one for every posted node, what was done to the heights.
    pub(super) fn apply(&self, columns: &mut [Vec<f64>]) {
        match self {
            Step::Replaced(peaks) => {
                for column in columns.iter_mut().asking(10 * peaks.len()) {
                    let taken: Vec<f64> =
                        peaks.iter().map(|p| 0.5 * column[p.taken[0]] + 0.5 * column[p.taken[1]]).collect();
                    peaks.iter().zip(taken).for_each(|(peak, value)| column[peak.node] = value);
                }
            }
            Step::Removed => {}
            Step::Gaussian { filter, lines, present, delta, .. } => {
                filter.apply(lines, present, delta.as_deref(), columns);
            }
            Step::Spline { filter, lines, present, .. } => filter.apply(lines, present, columns),
        }
    }

    /// Products of a weight and a number for one column.
    pub(super) fn products(&self) -> usize {
        match self {
            Step::Replaced(_) | Step::Removed => 0,
            Step::Gaussian { filter, lines, .. } => filter.pairs(lines).saturating_mul(lines.count),
            Step::Spline { present, .. } => present.len().saturating_mul(8),
        }
    }

    /// The axis of a map that is the same on every line, and that map on one line.
    pub(super) fn along_axis(&self) -> Option<(FilterAxis, Step)> {
        let single = |lines: &Lines| (Lines::single(&lines.x), vec![true; lines.places()]);
        match self {
            Step::Gaussian { filter, lines, axis, present, delta: None } if present.iter().all(|there| *there) => {
                let (lines, present) = single(lines);
                Some((*axis, Step::Gaussian { filter: filter.clone(), lines, axis: *axis, present, delta: None }))
            }
            Step::Spline { filter, lines, axis, present } if present.iter().all(|there| *there) => {
                let (lines, present) = single(lines);
                Some((*axis, Step::Spline { filter: *filter, lines, axis: *axis, present }))
            }
            _ => None,
        }
    }
}

/// Filtered nodes and how they came about.
pub(super) struct Applied {
    pub nodes: Nodes,
    pub steps: Vec<Step>,
    pub reports: Vec<FilterReport>,
    pub warnings: Vec<Warning>,
}

/// Applies filters in order.
pub(super) fn apply(nodes: &Nodes, filters: &[Filter]) -> Result<Applied, Faults> {
    check(nodes, filters)?;
    let (mut z, mut present) = heights(nodes);
    let posted_present = present.clone();
    let (mut steps, mut reports, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for (at, filter) in filters.iter().enumerate() {
        let before = z.clone();
        let counted = present.iter().filter(|there| **there).count();
        let (mut peaks, mut iteration) = (None, None);
        let mut distances = Vec::new();
        let step = match filter {
            Filter::Hampel(filter) => {
                let found = find_peaks(nodes, filter, &z, &present);
                peaks = Some(found.iter().map(|peak| peak.node).collect());
                match filter.action {
                    Action::Replace => {
                        found.iter().for_each(|peak| z[peak.node] = peak.median);
                        Step::Replaced(found)
                    }
                    Action::Remove => {
                        for peak in &found {
                            present[peak.node] = false;
                            distances.push((z[peak.node] - peak.median).abs());
                        }
                        Step::Removed
                    }
                }
            }
            Filter::Gaussian(filter) => {
                let Some((lines, axis)) = lines_of(nodes, filter.axis) else { continue };
                let kernel = GaussianFilter::new(filter.cutoff, filter.robust.unwrap_or(Order::Zero));
                let mut delta = None;
                if filter.robust.is_some() {
                    let (smooth, robust) = kernel.robust(&lines, &present, &z);
                    (0..z.len()).filter(|&i| present[i]).for_each(|i| z[i] = smooth[i]);
                    iteration = Some(IterationReport { iterations: robust.rounds, converged: robust.unfinished == 0 });
                    if robust.unfinished > 0 {
                        warnings.push(Warning::FilterNotConverged {
                            filter: at,
                            rounds: ROUNDS,
                            lines: robust.unfinished,
                        });
                    }
                    delta = Some(robust.delta);
                } else {
                    kernel.apply(&lines, &present, None, std::slice::from_mut(&mut z));
                }
                Step::Gaussian { filter: kernel, lines, axis, present: present.clone(), delta }
            }
            Filter::Spline(filter) => {
                let Some((lines, axis)) = lines_of(nodes, filter.axis) else { continue };
                let spline = SplineFilter { cutoff: filter.cutoff };
                spline.apply(&lines, &present, std::slice::from_mut(&mut z));
                Step::Spline { filter: spline, lines, axis, present: present.clone() }
            }
        };
        steps.push(step);
        if (0..z.len()).any(|i| present[i] && !z[i].is_finite()) {
            return Err(Faults::one(
                format_args!("filters[{at}]"),
                "the filtered heights exceed the range of double precision: choose another unit",
            ));
        }
        let moved = (0..z.len()).filter(|&i| present[i] && z[i] != before[i]).map(|i| (z[i] - before[i]).abs());
        distances.extend(moved);
        let largest = distances.iter().copied().fold(0.0, f64::max);
        let scale = if largest > 0.0 { largest } else { 1.0 };
        // from 0: the sum of nothing is −0
        let squares = distances.iter().fold(0.0, |sum, d| sum + (d / scale).powi(2));
        let mean_square = squares / counted.max(1) as f64;
        reports.push(FilterReport {
            kind: filter.into(),
            changed: distances.len(),
            removed: if matches!(steps.last(), Some(Step::Removed)) { distances.len() } else { 0 },
            max_change: largest,
            rms_change: scale * mean_square.sqrt(),
            node_indices: peaks,
            iteration,
        });
    }
    let nodes = rebuilt(nodes, z, &posted_present, &present);
    Ok(Applied { nodes, steps, reports, warnings })
}

fn find_peaks(nodes: &Nodes, filter: &Hampel, z: &[f64], present: &[bool]) -> Vec<Peak> {
    match (nodes, filter.axis) {
        (Nodes::Grid(grid), None) => {
            hampel::over((grid.u.len(), grid.v.len()), z, present, filter.window, filter.threshold)
        }
        _ => Lines::of(nodes, filter.axis.unwrap_or(FilterAxis::U))
            .map_or_else(Vec::new, |lines| hampel::along(&lines, z, present, filter.window, filter.threshold)),
    }
}

fn lines_of(nodes: &Nodes, axis: Option<FilterAxis>) -> Option<(Lines, FilterAxis)> {
    let axis = axis.unwrap_or(FilterAxis::U);
    Lines::of(nodes, axis).map(|lines| (lines, axis))
}

/// Heights (0 where a node does not count, so that a weight of 0 times it is 0), and which nodes
/// count.
fn heights(nodes: &Nodes) -> (Vec<f64>, Vec<bool>) {
    let (mut z, present) = posted(nodes);
    z.iter_mut().zip(&present).filter(|(_, there)| !**there).for_each(|(z, _)| *z = 0.0);
    (z, present)
}

fn posted(nodes: &Nodes) -> (Vec<f64>, Vec<bool>) {
    let weighted = |weight: &Option<Vec<f64>>, n: usize| {
        weight.as_ref().map_or_else(|| vec![true; n], |weight| weight.iter().map(|w| *w > 0.0).collect())
    };
    match nodes {
        Nodes::Curve(c) => (c.y.clone(), weighted(&c.weight, c.y.len())),
        Nodes::Scattered(s) => (s.z.clone(), weighted(&s.weight, s.z.len())),
        Nodes::Grid(g) => (g.z.clone(), (0..g.z.len()).map(|i| g.counts(i)).collect()),
        Nodes::Matrix(m) => (m.y.clone(), weighted(&m.weight, m.y.len())),
    }
}

/// The nodes with other heights; those that were removed get weight 0, on a grid NaN.
fn rebuilt(nodes: &Nodes, z: Vec<f64>, before: &[bool], present: &[bool]) -> Nodes {
    let weight = |weight: &Option<Vec<f64>>| {
        if before == present {
            return weight.clone();
        }
        let own = |i: usize| weight.as_ref().map_or(1.0, |weight| weight[i]);
        Some((0..present.len()).map(|i| if present[i] { own(i) } else { 0.0 }).collect())
    };
    let mut z = z;
    let (original, _) = posted(nodes);
    (0..z.len()).filter(|&i| !before[i]).for_each(|i| z[i] = original[i]);
    let mut nodes = nodes.clone();
    match &mut nodes {
        Nodes::Curve(c) => (c.weight, c.y) = (weight(&c.weight), z),
        Nodes::Scattered(s) => (s.weight, s.z) = (weight(&s.weight), z),
        Nodes::Matrix(m) => (m.weight, m.y) = (weight(&m.weight), z),
        Nodes::Grid(Grid { z: heights, .. }) => {
            *heights = z;
            (0..present.len()).filter(|&i| before[i] && !present[i]).for_each(|i| heights[i] = f64::NAN);
        }
    }
    nodes
}

/// Checks of the filters that need the nodes.
fn check(nodes: &Nodes, filters: &[Filter]) -> Result<(), Faults> {
    let mut faults = Faults::default();
    for (k, filter) in filters.iter().enumerate() {
        match (nodes, filter) {
            (Nodes::Scattered(_), _) => faults.push(
                format_args!("filters[{k}].type"),
                format_args!(
                    "scattered nodes have no lines for the filter `{}`; send a grid or a curve",
                    filter.name()
                ),
            ),
            (Nodes::Matrix(_), Filter::Gaussian(_) | Filter::Spline(_)) => faults.push(
                format_args!("filters[{k}].type"),
                format_args!("a measurement matrix has no axis for the filter `{}`", filter.name()),
            ),
            (Nodes::Matrix(_), Filter::Hampel(Hampel { axis: Some(_), .. })) => {
                faults.push(
                    format_args!("filters[{k}].axis"),
                    "a measurement matrix has no axis: windows lie along its rows",
                );
            }
            (
                Nodes::Curve(_),
                Filter::Hampel(Hampel { axis: Some(FilterAxis::V), .. })
                | Filter::Gaussian(Gaussian { axis: Some(FilterAxis::V), .. })
                | Filter::Spline(Spline { axis: Some(FilterAxis::V), .. }),
            ) => faults.push(format_args!("filters[{k}].axis"), "a curve has no v; its x is `u`"),
            (
                Nodes::Grid(_),
                Filter::Gaussian(Gaussian { axis: None, .. }) | Filter::Spline(Spline { axis: None, .. }),
            ) => faults.push(format_args!("filters[{k}].axis"), "missing; a grid needs `u` or `v`"),
            (_, Filter::Hampel(hampel)) => check_window(nodes, hampel, &format!("filters[{k}].window"), &mut faults),
            (_, Filter::Gaussian(gaussian)) => {
                check_gaussian(nodes, gaussian, &format!("filters[{k}].cutoff"), &mut faults);
            }
            (_, Filter::Spline(spline)) => {
                if let Some((lines, _)) = lines_of(nodes, spline.axis) {
                    check_cutoff(&lines, spline.cutoff, &format!("filters[{k}].cutoff"), &mut faults);
                }
            }
        }
    }
    faults.into_result(())
}

fn check_window(nodes: &Nodes, hampel: &Hampel, path: &str, faults: &mut Faults) {
    let square = matches!(nodes, Nodes::Grid(_)) && hampel.axis.is_none();
    let window = if square { hampel.window.saturating_mul(hampel.window) } else { hampel.window };
    if nodes.posted().saturating_mul(window.min(nodes.posted())) > MOST_WINDOWED {
        faults.push(path, format_args!("windows of {window} nodes around {} nodes take too long", nodes.posted()));
    }
}

fn check_gaussian(nodes: &Nodes, gaussian: &Gaussian, path: &str, faults: &mut Faults) {
    let Some((lines, _)) = lines_of(nodes, gaussian.axis) else { return };
    if !check_cutoff(&lines, gaussian.cutoff, path, faults) {
        return;
    }
    let kernel = GaussianFilter::new(gaussian.cutoff, gaussian.robust.unwrap_or(Order::Zero));
    let products = kernel.pairs(&lines).saturating_mul(lines.count);
    let most = if gaussian.robust.is_some() { MOST_ROBUST_PRODUCTS } else { MOST_PRODUCTS };
    if products > most {
        faults.push(
            path,
            format_args!(
                "the windows have {products} nodes in all, and this filter allows {most}; use a shorter cut-off, \
                 fewer nodes, or `spline`, whose work does not grow with the cut-off"
            ),
        );
    }
}

fn check_cutoff(lines: &Lines, cutoff: f64, path: &str, faults: &mut Faults) -> bool {
    let closest = lines.closest();
    let fine = closest.is_infinite() || cutoff > 2.0 * closest;
    if !fine {
        faults.push(
            path,
            format_args!(
                "{} is not longer than twice the closest spacing {}: shorter waves cannot be resolved",
                Shown(cutoff),
                Shown(closest)
            ),
        );
    }
    fine
}
