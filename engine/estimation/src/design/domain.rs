//! The box of the nodes and the domain of a caller.

use crate::{
    data::{Nodes, Sample},
    spec::Domain,
};
use flankfit_numerics::{cancel::Asking, check::Faults, words::Shown};

pub(crate) fn bounding_box(sample: &Sample) -> ([f64; 2], [f64; 2]) {
    if let Some((u, v)) = sample.full_axes() {
        // axes ascend
        return ([u[0], u[u.len() - 1]], [v[0], v[v.len() - 1]]);
    }
    let (u, v) = sample.place(0);
    let (mut box_u, mut box_v) = ([u; 2], [v; 2]);
    for k in (1..sample.count()).asking(20) {
        let (u, v) = sample.place(k);
        box_u = [box_u[0].min(u), box_u[1].max(u)];
        box_v = [box_v[0].min(v), box_v[1].max(v)];
    }
    (box_u, box_v)
}

pub(crate) type Boxes = ([f64; 2], [f64; 2]);

/// The caller's domain where one is given (no node may lie outside), else the box.
pub(crate) fn checked_domain(
    nodes: &Nodes,
    sample: &Sample,
    surface: bool,
    domain: Option<Domain>,
    (box_u, box_v): Boxes,
) -> Result<Boxes, Faults> {
    let given = domain.unwrap_or_default();
    let mut faults = Faults::default();
    for (field, range) in [("domain.u", given.u), ("domain.v", given.v)] {
        if let Some([low, high]) = range
            && !(low < high && (high - low).is_finite())
        {
            faults.push(field, no_range([low, high]));
        }
    }
    if given.v.is_some() && !surface {
        faults.push("domain.v", "a curve has no v");
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let (u, v) = (given.u.unwrap_or(box_u), given.v.unwrap_or(box_v));
    if box_u[0] < u[0] || box_u[1] > u[1] || box_v[0] < v[0] || box_v[1] > v[1] {
        outside(nodes, sample, (u, v), &mut faults, "the domain");
        return Err(faults);
    }
    Ok((u, v))
}

/// Ends that do not ascend.
pub(crate) fn no_range([low, high]: [f64; 2]) -> String {
    format!("[{}, {}] is not a range from low to high", Shown(low), Shown(high))
}

/// Names every axis position or node outside the given ranges.
pub(super) fn outside(nodes: &Nodes, sample: &Sample, (u, v): Boxes, faults: &mut Faults, of: &str) {
    let out = |x: f64, range: [f64; 2]| x < range[0] || x > range[1];
    let outside = |value: f64, range: [f64; 2]| {
        format!("{} lies outside {of} [{}, {}]", Shown(value), Shown(range[0]), Shown(range[1]))
    };
    if let Nodes::Grid(grid) = nodes {
        for (list, axis, range) in [("u", &grid.u, u), ("v", &grid.v, v)] {
            for (i, &x) in axis.iter().enumerate().filter(|(_, x)| out(**x, range)) {
                faults.push(format_args!("nodes.{list}[{i}]"), outside(x, range));
            }
        }
        return;
    }
    let list_u = if matches!(nodes, Nodes::Curve(_)) { "x" } else { "u" };
    for k in 0..sample.count() {
        let (x, y) = sample.place(k);
        if out(x, u) {
            faults.push(format_args!("nodes.{list_u}[{}]", sample.posted(k)), outside(x, u));
        }
        if out(y, v) {
            faults.push(format_args!("nodes.v[{}]", sample.posted(k)), outside(y, v));
        }
    }
}
