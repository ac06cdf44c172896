//! The blocks of nodes that cross-validation leaves out.

use std::cmp::Ordering;

use super::{Nodes, Sample};
use crate::spec::{Folds, FoldsBy};
use flankfit_numerics::check::Faults;

/// Message for blocks that nothing is done with.
pub(crate) const UNUSED: &str = "nothing is cross-validated here: use the criterion `blocked_cv`, or a selection";

/// Default number of blocks.
const DEFAULT_COUNT: usize = 10;

/// The block of every counted node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Partition {
    /// Numbers of blocks, from 0.
    pub block: Vec<usize>,
    /// Number of blocks.
    pub count: usize,
}

impl Partition {
    /// Neighbouring rows, columns or lines go into one block, as many into each as into any other
    /// (or one more).
    pub(crate) fn new(nodes: &Nodes, sample: &Sample, folds: &Folds) -> Result<Self, Faults> {
        let m = sample.count();
        let places = |of: &dyn Fn(usize) -> f64| {
            let value: Vec<f64> = (0..m).map(of).collect();
            ranks(m, |a, b| value[a].total_cmp(&value[b]))
        };
        let (row, rows) = match (&folds.by, nodes) {
            (FoldsBy::Rows, Nodes::Matrix(_)) => ((0..m).collect(), m),
            // −0 and 0 are one place
            (FoldsBy::Rows, _) => places(&|k| sample.place(k).0 + 0.0),
            (FoldsBy::Columns, Nodes::Grid(_) | Nodes::Scattered(_)) => places(&|k| sample.place(k).1 + 0.0),
            (FoldsBy::Columns, _) => return Err(Faults::one("folds.by", "only the nodes of a surface lie in columns")),
            (FoldsBy::Lines(line), _) => {
                if line.len() != nodes.posted() {
                    let (given, nodes) = (line.len(), nodes.posted());
                    let message = format_args!("{given} line numbers for {nodes} nodes: give one for each posted node");
                    return Err(Faults::one("folds.line", message));
                }
                let of = |k: usize| line[sample.posted(k)];
                ranks(m, |a, b| of(a).cmp(&of(b)))
            }
        };
        let count = folds.count.unwrap_or(DEFAULT_COUNT.min(rows));
        if count < 2 || count > rows {
            let of = folds.by.name();
            return Err(match folds.count {
                Some(_) => Faults::one(
                    "folds.count",
                    format_args!("{count} blocks for {rows} {of}: at least 2 and at most one for each are possible"),
                ),
                None => Faults::one(
                    "folds.by",
                    format_args!("the counted nodes lie in fewer than two {of}: cross-validation needs at least two"),
                ),
            });
        }
        Ok(Partition { block: row.into_iter().map(|row| row * count / rows).collect(), count })
    }
}

/// The number of each of `m` among the different ones in ascending order, and how many those are.
fn ranks(m: usize, compare: impl Fn(usize, usize) -> Ordering) -> (Vec<usize>, usize) {
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|&a, &b| compare(a, b));
    let mut rank = vec![0; m];
    let mut next = 0;
    for pair in 0..m {
        if pair > 0 && compare(order[pair - 1], order[pair]).is_ne() {
            next += 1;
        }
        rank[order[pair]] = next;
    }
    (rank, next + usize::from(m > 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(nodes: &Nodes, by: FoldsBy, count: Option<usize>) -> Result<Vec<usize>, String> {
        match Partition::new(nodes, &Sample::new(nodes), &Folds { by, count }) {
            Ok(partition) => Ok(partition.block),
            Err(faults) => Err(faults.list()[0].path.clone()),
        }
    }

    #[test]
    fn rows_and_columns_of_a_grid_with_a_gap() {
        let z = vec![1.0, f64::NAN, 3.0, 4.0, 5.0, 6.0];
        let grid = Nodes::grid(vec![0.0, 2.0], vec![0.0, 1.0, 5.0], z, None, None).unwrap();
        assert_eq!(blocks(&grid, FoldsBy::Rows, None), Ok(vec![0, 0, 1, 1, 1]));
        assert_eq!(blocks(&grid, FoldsBy::Columns, None), Ok(vec![0, 2, 0, 1, 2]));
        assert_eq!(blocks(&grid, FoldsBy::Columns, Some(2)), Ok(vec![0, 1, 0, 0, 1]));
        assert_eq!(blocks(&grid, FoldsBy::Rows, Some(3)), Err("folds.count".to_owned()));
        assert_eq!(blocks(&grid, FoldsBy::Columns, Some(1)), Err("folds.count".to_owned()));
        assert_eq!(blocks(&grid, FoldsBy::Lines(vec![7, 7, 7, 7, 7, 7]), None), Err("folds.by".to_owned()));
        assert_eq!(blocks(&grid, FoldsBy::Lines(vec![7; 5]), None), Err("folds.line".to_owned()));
        // the second node does not count, but has a line
        assert_eq!(blocks(&grid, FoldsBy::Lines(vec![7, 7, 7, -1, 7, -1]), None), Ok(vec![1, 1, 0, 1, 0]));
    }

    #[test]
    fn abscissae_of_a_curve_ascend_and_repeat() {
        let x = vec![3.0, -0.0, 0.0, 7.0, 3.0];
        let curve = Nodes::curve(x, vec![0.0; 5], None).unwrap();
        assert_eq!(blocks(&curve, FoldsBy::Rows, None), Ok(vec![1, 0, 0, 2, 1]));
        assert_eq!(blocks(&curve, FoldsBy::Columns, None), Err("folds.by".to_owned()));
        let matrix = Nodes::matrix(vec![1.0; 25], 1, vec![0.0; 25], None, None).unwrap();
        let ten = blocks(&matrix, FoldsBy::Rows, None).unwrap();
        assert_eq!((ten[0], ten[2], ten[3], ten[24]), (0, 0, 1, 9));
    }
}
