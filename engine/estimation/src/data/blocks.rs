//! Nodes that arrive in blocks: what blocks of one stream have in common, and all of them as one
//! node set.

use super::nodes::{Curve, Grid, Matrix, Nodes, Scattered};
use flankfit_numerics::{check::Faults, words};

/// Kind of nodes that every block of a stream has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Form {
    /// `y(x)`.
    Curve,
    /// `z(u, v)`: scattered nodes and grids.
    Surface,
    /// Rows of a measurement matrix.
    Matrix {
        /// n.
        columns: usize,
        /// Names of the columns, where they have any.
        names: Option<Vec<String>>,
    },
}

impl Form {
    /// The form of a block.
    pub fn of(nodes: &Nodes) -> Self {
        match nodes {
            Nodes::Curve(_) => Form::Curve,
            Nodes::Scattered(_) | Nodes::Grid(_) => Form::Surface,
            Nodes::Matrix(matrix) => Form::Matrix { columns: matrix.columns, names: matrix.names.clone() },
        }
    }

    /// Refuses a block of another form. Column names may be left out after the first block.
    pub fn check(&self, nodes: &Nodes) -> Result<(), Faults> {
        match (self, Form::of(nodes)) {
            (Form::Curve, Form::Curve) | (Form::Surface, Form::Surface) => Ok(()),
            (Form::Matrix { columns, names }, Form::Matrix { columns: here, names: given }) => {
                let mut faults = Faults::default();
                if here != *columns {
                    faults.push(
                        "nodes.x",
                        format_args!("{}, but the stream has {columns}", words::counted(here, "column", "columns")),
                    );
                }
                if given.is_some() && given != *names {
                    faults.push("nodes.names", "not the names of the stream's first block");
                }
                faults.into_result(())
            }
            (form, _) => Err(Faults::one(
                "nodes.type",
                match form {
                    Form::Curve => "the stream's blocks are curves",
                    Form::Surface => "the stream's blocks are nodes of a surface (scattered or grid)",
                    Form::Matrix { .. } => "the stream's blocks are rows of a measurement matrix",
                },
            )),
        }
    }
}

/// All blocks as one node set, in the order in which they came; `None` without a block. Blocks must
/// be of one form.
///
/// A single block is unchanged. Grids over the same v with ascending u become one grid; any other
/// mixture of surface blocks becomes scattered nodes, of which missing ones are left out. If some
/// blocks have weights, nodes of the others have weight 1.
///
/// ```
/// use flankfit_estimation::{Nodes, data::join};
///
/// let nodes = |x: &[f64], y: &[f64]| Nodes::curve(x.to_vec(), y.to_vec(), None);
/// let blocks = vec![nodes(&[0.0, 1.0], &[2.0, 3.0])?, nodes(&[2.0], &[5.0])?];
/// assert_eq!(join(blocks), Some(nodes(&[0.0, 1.0, 2.0], &[2.0, 3.0, 5.0])?));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn join(blocks: Vec<Nodes>) -> Option<Nodes> {
    let mut blocks = blocks;
    if blocks.len() <= 1 {
        return blocks.pop();
    }
    if let Some(grid) = one_grid(&blocks) {
        return Some(Nodes::Grid(grid));
    }
    let weighted = blocks.iter().any(|nodes| weights(nodes).is_some());
    let mut weight = weighted.then(Vec::new);
    let mut columns = Columns::default();
    let mut names = None;
    let mut width = 0;
    let form = Form::of(&blocks[0]);
    for nodes in blocks {
        if let Some(weight) = &mut weight {
            match weights(&nodes) {
                Some(own) => weight.extend(own),
                None => weight.extend(std::iter::repeat_n(1.0, counted(&nodes))),
            }
        }
        match nodes {
            Nodes::Curve(curve) => columns.extend(curve.x, Vec::new(), curve.y),
            Nodes::Scattered(nodes) => columns.extend(nodes.u, nodes.v, nodes.z),
            Nodes::Grid(grid) => {
                for i in (0..grid.z.len()).filter(|&i| present(&grid, i)) {
                    columns.u.push(grid.u[i / grid.v.len()]);
                    columns.v.push(grid.v[i % grid.v.len()]);
                    columns.z.push(grid.z[i]);
                }
            }
            Nodes::Matrix(matrix) => {
                width = matrix.columns;
                names = names.or(matrix.names);
                columns.extend(matrix.x, Vec::new(), matrix.y);
            }
        }
    }
    let Columns { u, v, z } = columns;
    Some(match form {
        Form::Curve => Nodes::Curve(Curve { x: u, y: z, weight }),
        Form::Surface => Nodes::Scattered(Scattered { u, v, z, weight }),
        Form::Matrix { .. } => Nodes::Matrix(Matrix { x: u, columns: width, y: z, names, weight }),
    })
}

#[derive(Default)]
struct Columns {
    u: Vec<f64>,
    v: Vec<f64>,
    z: Vec<f64>,
}

impl Columns {
    fn extend(&mut self, u: Vec<f64>, v: Vec<f64>, z: Vec<f64>) {
        self.u.extend(u);
        self.v.extend(v);
        self.z.extend(z);
    }
}

/// True if node `i` of a grid is there, of whatever weight.
fn present(grid: &Grid, i: usize) -> bool {
    !grid.z[i].is_nan() && grid.valid.as_ref().is_none_or(|valid| valid[i])
}

/// Nodes that [`join`] takes over.
fn counted(nodes: &Nodes) -> usize {
    match nodes {
        Nodes::Grid(grid) => (0..grid.z.len()).filter(|&i| present(grid, i)).count(),
        other => other.posted(),
    }
}

/// Weights of the nodes that [`join`] takes over.
fn weights(nodes: &Nodes) -> Option<Vec<f64>> {
    match nodes {
        Nodes::Curve(Curve { weight, .. })
        | Nodes::Scattered(Scattered { weight, .. })
        | Nodes::Matrix(Matrix { weight, .. }) => weight.clone(),
        Nodes::Grid(grid) => {
            let weight = grid.weight.as_ref()?;
            Some((0..grid.z.len()).filter(|&i| present(grid, i)).map(|i| weight[i]).collect())
        }
    }
}

/// Rows of one grid, handed over bit by bit.
fn one_grid(blocks: &[Nodes]) -> Option<Grid> {
    let mut grids = blocks.iter().map(|nodes| match nodes {
        Nodes::Grid(grid) => Some(grid),
        _ => None,
    });
    let mut whole = grids.next()??.clone();
    for grid in grids {
        let grid = grid?;
        let same = grid.v == whole.v
            && grid.u.first() > whole.u.last()
            && grid.valid.is_some() == whole.valid.is_some()
            && grid.weight.is_some() == whole.weight.is_some();
        if !same {
            return None;
        }
        whole.u.extend(&grid.u);
        whole.z.extend(&grid.z);
        for (all, here) in whole.valid.iter_mut().zip(&grid.valid) {
            all.extend(here);
        }
        for (all, here) in whole.weight.iter_mut().zip(&grid.weight) {
            all.extend(here);
        }
    }
    Some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_grid_become_the_grid() {
        let row = |u: f64, z: f64| Nodes::grid(vec![u], vec![0.0, 1.0], vec![z, f64::NAN], None, None).unwrap();
        let Some(Nodes::Grid(grid)) = join(vec![row(0.0, 5.0), row(2.0, 6.0)]) else { panic!("a grid") };
        assert_eq!((grid.u.as_slice(), grid.v.as_slice()), ([0.0, 2.0].as_slice(), [0.0, 1.0].as_slice()));
        assert_eq!(grid.z[2], 6.0);
        let Some(Nodes::Scattered(nodes)) = join(vec![row(2.0, 5.0), row(0.0, 6.0)]) else { panic!("no grid") };
        assert_eq!((nodes.u, nodes.v, nodes.z), (vec![2.0, 0.0], vec![0.0, 0.0], vec![5.0, 6.0]));
    }

    #[test]
    fn missing_weights_are_ones_and_names_come_from_the_first_block() {
        let names = Some(vec!["a".to_owned()]);
        let first = Nodes::matrix(vec![1.0], 1, vec![2.0], names.clone(), None).unwrap();
        let second = Nodes::matrix(vec![3.0], 1, vec![4.0], None, Some(vec![0.5])).unwrap();
        assert!(Form::of(&first).check(&second).is_ok());
        let all = Nodes::matrix(vec![1.0, 3.0], 1, vec![2.0, 4.0], names, Some(vec![1.0, 0.5])).unwrap();
        assert_eq!(join(vec![first.clone(), second]), Some(all));
        let curve = Nodes::curve(vec![1.0], vec![2.0], None).unwrap();
        assert!(Form::of(&first).check(&curve).is_err() && Form::of(&curve).check(&first).is_err());
        let wider = Nodes::matrix(vec![1.0, 2.0], 2, vec![2.0], None, None).unwrap();
        assert_eq!(Form::of(&first).check(&wider).unwrap_err().list()[0].path, "nodes.x");
        assert_eq!(join(Vec::new()), None);
    }
}
