//! Scan lines: in which order nodes were measured, and how far apart.

use crate::{
    data::{Nodes, Sample},
    design::bounding_box,
    spec::Along,
};
use flankfit_numerics::words::counted;

/// Unit of a step along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    /// Nodes, missing ones included.
    Steps,
    /// The unit of the abscissae.
    Distance,
}

/// Counted nodes line after line.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lines {
    /// Numbers among the counted nodes.
    pub nodes: Vec<usize>,
    /// From the node before on the same line; infinite where a line begins.
    pub steps: Vec<f64>,
    /// Lines along u of the same nodes, where these are along v and errors are correlated along
    /// both.
    pub across: Option<Box<Lines>>,
}

impl Lines {
    /// The lines of `nodes`, whose counted ones are `sample`; `line` has the line of each posted
    /// node where scattered nodes or rows of a matrix were measured along several.
    pub(crate) fn new(nodes: &Nodes, sample: &Sample, along: Along, line: Option<&[i64]>, measure: Measure) -> Self {
        let count = sample.count();
        let counted = |k: usize| sample.posted(k);
        let mut order: Vec<usize> = (0..count).collect();
        let mut steps = vec![f64::INFINITY; count];
        match nodes {
            Nodes::Curve(curve) => {
                let rank = ranks(&curve.x);
                order.sort_by_key(|&k| rank[counted(k)]);
                for i in 1..count {
                    let (before, here) = (counted(order[i - 1]), counted(order[i]));
                    steps[i] = match measure {
                        Measure::Steps => (rank[here] - rank[before]) as f64,
                        Measure::Distance => curve.x[here] - curve.x[before],
                    };
                }
            }
            Nodes::Grid(grid) => {
                let width = grid.v.len();
                let along_u = along == Along::U;
                let place = |k: usize| (counted(k) / width, counted(k) % width);
                if along_u {
                    order.sort_by_key(|&k| (place(k).1, place(k).0));
                }
                for i in 1..count {
                    let (before, here) = (place(order[i - 1]), place(order[i]));
                    let (axis, from, to, same) = match along_u {
                        true => (&grid.u, before.0, here.0, before.1 == here.1),
                        false => (&grid.v, before.1, here.1, before.0 == here.0),
                    };
                    if same {
                        steps[i] = match measure {
                            Measure::Steps => (to - from) as f64,
                            Measure::Distance => axis[to] - axis[from],
                        };
                    }
                }
            }
            Nodes::Scattered(_) | Nodes::Matrix(_) => {
                let line_of = |posted: usize| line.map_or(0, |line| line[posted]);
                let number = numbers_within(nodes.posted(), line_of);
                order.sort_by_key(|&k| (line_of(counted(k)), counted(k)));
                for i in 1..count {
                    let (before, here) = (order[i - 1], order[i]);
                    if line_of(counted(before)) == line_of(counted(here)) {
                        let ((u0, v0), (u1, v1)) = (sample.place(before), sample.place(here));
                        steps[i] = match (measure, nodes) {
                            (Measure::Distance, Nodes::Scattered(_)) => (u1 - u0).hypot(v1 - v0),
                            _ => (number[counted(here)] - number[counted(before)]) as f64,
                        };
                    }
                }
            }
        }
        Lines { nodes: order, steps, across: None }
    }

    /// One line through nodes at any places, by strips of u up and down v.
    pub(crate) fn winding(sample: &Sample) -> Self {
        let count = sample.count();
        let ([low, high], _) = bounding_box(sample);
        let strips = (0.5 * count as f64).sqrt().ceil();
        let strip = |k: usize| ((sample.place(k).0 - low) / (high - low) * strips).min(strips - 1.0) as u32;
        let mut nodes: Vec<usize> = (0..count).collect();
        nodes.sort_by(|&a, &b| {
            let (here, there, [v, w]) = (strip(a), strip(b), [a, b].map(|k| sample.place(k).1));
            here.cmp(&there)
                .then(if here % 2 == 0 { v.total_cmp(&w) } else { w.total_cmp(&v) })
                .then(sample.place(a).0.total_cmp(&sample.place(b).0))
        });
        let steps = (0..count).map(|i| if i == 0 { f64::INFINITY } else { 1.0 }).collect();
        Lines { nodes, steps, across: None }
    }

    /// The lines along both axes of a full grid.
    pub(crate) fn both(nodes: &Nodes, sample: &Sample) -> Self {
        let [u, v] = [Along::U, Along::V].map(|along| Lines::new(nodes, sample, along, None, Measure::Steps));
        Lines { across: Some(Box::new(u)), ..v }
    }

    /// Pairs of neighbours on one line.
    pub(crate) fn pairs(&self) -> usize {
        self.steps.iter().filter(|step| step.is_finite()).count()
    }

    /// Nodes with two others before them on their line.
    pub(crate) fn thirds(&self) -> usize {
        self.steps.windows(2).filter(|steps| steps.iter().all(|step| step.is_finite())).count()
    }

    /// True if neighbours are as far apart everywhere, but for rounding.
    pub(crate) fn is_even(&self) -> bool {
        let steps = self.steps.iter().filter(|step| step.is_finite());
        let [least, most] = steps.fold([f64::INFINITY, 0.0], |[a, b], &step| [a.min(step), b.max(step)]);
        most - least <= EVEN * most
    }
}

/// Relative difference up to which steps count as equal.
const EVEN: f64 = 1e-9;

/// The place of every abscissa in ascending order; equal ones keep theirs.
fn ranks(x: &[f64]) -> Vec<usize> {
    if x.is_sorted() {
        return (0..x.len()).collect();
    }
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|&a, &b| x[a].total_cmp(&x[b]));
    let mut rank = vec![0; x.len()];
    for (place, &k) in order.iter().enumerate() {
        rank[k] = place;
    }
    rank
}

/// The number of every posted node on its own line.
fn numbers_within(posted: usize, line_of: impl Fn(usize) -> i64) -> Vec<usize> {
    let mut last = std::collections::BTreeMap::new();
    (0..posted)
        .map(|k| {
            let next = last.entry(line_of(k)).or_insert(0);
            *next += 1;
            *next
        })
        .collect()
}

/// Message for lines with too few pairs of neighbours.
pub(crate) fn few_neighbours(pairs: usize, least: usize) -> String {
    let known = match pairs {
        0 => "every line has a single node".to_owned(),
        _ => format!(
            "{} on one line, fewer than {least}",
            counted(pairs, "pair of neighbours is", "pairs of neighbours are")
        ),
    };
    format!(
        "{known}, so the correlation of neighbours cannot be estimated: use the other axis or order, or give the \
        parameters"
    )
}

/// Message for lines too short for what two parameters differ in.
pub(crate) fn short_lines(found: usize, least: usize) -> String {
    let known = match found {
        0 => "no line has three nodes".to_owned(),
        _ => format!(
            "{} two others before on the same line, fewer than {least}",
            counted(found, "node has", "nodes have")
        ),
    };
    format!(
        "{known}, so the two parameters of these errors cannot be estimated: use `ar1`, the other axis or order, or \
         give the parameters"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: f64 = f64::INFINITY;

    #[test]
    fn a_grid_with_a_gap_has_rows_and_columns() {
        let z = vec![1.0, f64::NAN, 3.0, 4.0, 5.0, 6.0];
        let grid = Nodes::grid(vec![0.0, 2.0], vec![0.0, 1.0, 5.0], z, None, None).unwrap();
        let sample = Sample::new(&grid);
        let lines = |along, measure| Lines::new(&grid, &sample, along, None, measure);
        let rows = lines(Along::V, Measure::Steps);
        assert_eq!((rows.pairs(), rows.thirds(), rows.is_even()), (3, 1, false));
        assert_eq!((rows.nodes, rows.steps), (vec![0, 1, 2, 3, 4], vec![START, 2.0, START, 1.0, 1.0]));
        let columns = lines(Along::U, Measure::Distance);
        assert_eq!((columns.pairs(), columns.thirds(), columns.is_even()), (2, 0, true));
        assert_eq!(columns.nodes, [0, 2, 3, 1, 4]);
        assert_eq!(columns.steps, [START, 2.0, START, START, 2.0]);
        assert_eq!(lines(Along::V, Measure::Distance).steps, [START, 5.0, START, 1.0, 4.0]);
    }

    #[test]
    fn a_curve_runs_along_x_and_silent_nodes_are_steps() {
        let curve = Nodes::curve(vec![3.0, 1.0, 2.0, 7.0], vec![0.0; 4], Some(vec![1.0, 1.0, 0.0, 2.0])).unwrap();
        let sample = Sample::new(&curve);
        let lines = Lines::new(&curve, &sample, Along::Order, None, Measure::Steps);
        assert_eq!((lines.nodes, lines.steps), (vec![1, 0, 2], vec![START, 2.0, 1.0]));
        let lines = Lines::new(&curve, &sample, Along::Order, None, Measure::Distance);
        assert_eq!(lines.steps, [START, 2.0, 4.0]);
    }

    #[test]
    fn scattered_nodes_have_lines_by_name() {
        let u = vec![0.0, 0.0, 3.0, 1.0, 6.0];
        let v = vec![0.0, 9.0, 4.0, 9.0, 8.0];
        let nodes = Nodes::scattered(u, v, vec![0.0; 5], None).unwrap();
        let sample = Sample::new(&nodes);
        let line = [7, -2, 7, -2, 7];
        let lines = Lines::new(&nodes, &sample, Along::Order, Some(&line), Measure::Steps);
        assert_eq!((lines.nodes, lines.steps), (vec![1, 3, 0, 2, 4], vec![START, 1.0, START, 1.0, 1.0]));
        let lines = Lines::new(&nodes, &sample, Along::Order, Some(&line), Measure::Distance);
        assert_eq!(lines.steps, [START, 1.0, START, 5.0, 5.0]);
    }
}
