//! Nodes that are left out of a fit.

use std::collections::BTreeMap;

use super::nodes::Nodes;
use crate::spec::NodeAt;
use flankfit_numerics::check::Faults;

impl Nodes {
    /// Returns the nodes with those listed in `exclude` marked as missing, or of weight 0 where
    /// nodes cannot be missing; all keep their indices. Refuses entries as a fit does.
    pub fn without(&self, exclude: &[NodeAt]) -> Result<Nodes, Faults> {
        without(self, exclude)
    }
}

/// Returns the nodes without those listed in `exclude`; refuses entries for nodes that do not
/// exist, do not count or are already listed.
pub(crate) fn without(nodes: &Nodes, exclude: &[NodeAt]) -> Result<Nodes, Faults> {
    let mut faults = Faults::default();
    let mut first: BTreeMap<usize, usize> = BTreeMap::new();
    for (entry, at) in exclude.iter().enumerate() {
        let found = posted(nodes, *at).and_then(|k| match first.insert(k, entry) {
            Some(before) => Err(format!("this node is already excluded by entry {before}: name it once")),
            None if !counts(nodes, k) => {
                Err("this node is already missing or has weight 0: omit it from the list".to_owned())
            }
            None => Ok(()),
        });
        if let Err(message) = found {
            faults.push(format_args!("exclude[{entry}]"), message);
        }
    }
    let left_out: Vec<usize> = first.into_keys().collect();
    faults.into_result(()).map(|()| masked(nodes, &left_out))
}

/// Returns the nodes with those of indices `posted` marked as missing; all keep their indices.
pub(crate) fn masked(nodes: &Nodes, posted: &[usize]) -> Nodes {
    let mut nodes = nodes.clone();
    let count = nodes.posted();
    let weight = match &mut nodes {
        Nodes::Grid(grid) => {
            let valid = grid.valid.get_or_insert_with(|| vec![true; count]);
            posted.iter().for_each(|&k| valid[k] = false);
            return nodes;
        }
        Nodes::Curve(curve) => &mut curve.weight,
        Nodes::Scattered(scattered) => &mut scattered.weight,
        Nodes::Matrix(matrix) => &mut matrix.weight,
    };
    let weight = weight.get_or_insert_with(|| vec![1.0; count]);
    posted.iter().for_each(|&k| weight[k] = 0.0);
    nodes
}

/// Returns the index of a node among the posted ones, or why there is none.
fn posted(nodes: &Nodes, at: NodeAt) -> Result<usize, String> {
    match (at, nodes) {
        (NodeAt::Index(k), _) if k < nodes.posted() => Ok(k),
        (NodeAt::Index(_), _) => {
            Err(format!("there is no such node: {} were posted, and indices count from 0", nodes.posted()))
        }
        (NodeAt::Cell { row, column }, Nodes::Grid(grid)) => {
            let (rows, columns) = (grid.u.len(), grid.v.len());
            let inside = row < rows && column < columns;
            if inside {
                Ok(row * columns + column)
            } else {
                Err(format!("the grid has {rows} rows and {columns} columns, which count from 0"))
            }
        }
        (NodeAt::Cell { .. }, _) => {
            Err("only nodes of a grid have a row and a column: give the index of the node".to_owned())
        }
    }
}

fn counts(nodes: &Nodes, k: usize) -> bool {
    let weight = match nodes {
        Nodes::Grid(grid) => return grid.counts(k),
        Nodes::Curve(curve) => &curve.weight,
        Nodes::Scattered(scattered) => &scattered.weight,
        Nodes::Matrix(matrix) => &matrix.weight,
    };
    weight.as_ref().is_none_or(|weight| weight[k] > 0.0)
}
