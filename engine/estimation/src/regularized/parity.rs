//! A grid that is the same seen from either end, split by parity.
//!
//! Where the functions of an axis, its nodes and its penalty are their own mirror images, whatever
//! is even and whatever is odd along it have nothing to do with each other: in the basis of the
//! sums and differences of mirrored functions every matrix of the pair falls into blocks, two for
//! each axis that is symmetric. Eigenvectors of four blocks cost a sixteenth of those of the whole.

use nalgebra::DMatrix;

use flankfit_numerics::Dd;

/// Deviation from symmetry that is still rounding, relative to the largest entry.
const ROUNDING: f64 = 1e-13;

/// Combinations of the functions of one axis: of each the two functions with their shares, the
/// second one 0 where there is one only.
pub(super) struct Class(Vec<[(usize, f64); 2]>);

impl Class {
    /// The functions as they are.
    fn all(size: usize) -> Self {
        Class((0..size).map(|i| [(i, 1.0), (i, 0.0)]).collect())
    }

    /// Sums of mirrored functions, or their differences.
    fn mirrored(size: usize, sign: f64) -> Self {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut rows: Vec<_> = (0..size / 2).map(|i| [(i, half), (size - 1 - i, sign * half)]).collect();
        if size % 2 == 1 && sign > 0.0 {
            rows.push([(size / 2, 1.0), (size / 2, 0.0)]);
        }
        Class(rows)
    }

    /// Number of combinations.
    pub(super) fn size(&self) -> usize {
        self.0.len()
    }

    /// True if these are the functions themselves.
    pub(super) fn is_identity(&self) -> bool {
        self.0.iter().enumerate().all(|(r, [(i, share), _])| *i == r && *share == 1.0)
    }

    /// Combinations as columns, of `size` functions.
    pub(super) fn matrix(&self, size: usize) -> DMatrix<Dd> {
        let half = (Dd::ONE + Dd::ONE).sqrt() / 2.0;
        let mut matrix = DMatrix::from_element(size, self.size(), Dd::ZERO);
        for (r, row) in self.0.iter().enumerate() {
            for &(i, share) in row.iter().filter(|(_, share)| *share != 0.0) {
                matrix[(i, r)] = match share {
                    1.0 => Dd::ONE,
                    share if share < 0.0 => -half,
                    _ => half,
                };
            }
        }
        matrix
    }
}

/// True if a symmetric matrix is the same seen from its other end.
fn is_mirrored(matrix: &DMatrix<f64>) -> bool {
    let n = matrix.nrows();
    let most = ROUNDING * matrix.amax();
    (0..n).all(|j| (0..=j).all(|i| (matrix[(i, j)] - matrix[(n - 1 - i, n - 1 - j)]).abs() <= most))
}

/// The classes of both axes.
pub(crate) struct Parity {
    pub(super) axes: [Vec<Class>; 2],
    sizes: [usize; 2],
}

impl Parity {
    /// Splits each axis into its symmetric and antisymmetric functions if all of `forms` are
    /// symmetric.
    pub(super) fn new(forms: [&[DMatrix<f64>]; 2]) -> Self {
        let sizes = forms.map(|forms| forms[0].nrows());
        let axes = forms.map(|forms| match forms[0].nrows() {
            size if size > 1 && forms.iter().all(is_mirrored) => {
                vec![Class::mirrored(size, 1.0), Class::mirrored(size, -1.0)]
            }
            size => vec![Class::all(size)],
        });
        Parity { axes, sizes }
    }

    /// No symmetry at all.
    pub(super) fn none(sizes: [usize; 2]) -> Self {
        Parity { axes: sizes.map(|size| vec![Class::all(size)]), sizes }
    }

    /// The classes along u and v of every block, in order.
    pub(super) fn blocks(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.axes[0].len()).flat_map(|a| (0..self.axes[1].len()).map(move |c| [a, c]))
    }

    /// Every combination of a block: its place there, and the functions in it with their shares.
    fn combinations(&self, [a, c]: [usize; 2]) -> impl Iterator<Item = (usize, [(usize, f64); 4])> + '_ {
        let (u, v, q) = (&self.axes[0][a].0, &self.axes[1][c].0, self.sizes[1]);
        u.iter().enumerate().flat_map(move |(r, row_u)| {
            v.iter().enumerate().map(move |(s, row_v)| {
                let pair = |k: usize, l: usize| (row_u[k].0 * q + row_v[l].0, row_u[k].1 * row_v[l].1);
                (r * v.len() + s, [pair(0, 0), pair(0, 1), pair(1, 0), pair(1, 1)])
            })
        })
    }

    /// `x` in the combinations of a block.
    pub(super) fn gathered(&self, block: [usize; 2], x: &[f64]) -> Vec<f64> {
        self.combinations(block).map(|(_, terms)| terms.iter().map(|(j, share)| share * x[*j]).sum()).collect()
    }

    /// Adds what the combinations of a block are worth.
    pub(super) fn scatter(&self, block: [usize; 2], inner: &[f64], x: &mut [f64]) {
        for (r, terms) in self.combinations(block) {
            terms.iter().for_each(|(j, share)| x[*j] += share * inner[r]);
        }
    }

    /// Adds squared lengths of rows, which combine as variances do: directions of different blocks
    /// are different ones.
    pub(super) fn scatter_squares(&self, block: [usize; 2], inner: &[f64], x: &mut [f64]) {
        for (r, terms) in self.combinations(block) {
            terms.iter().for_each(|(j, share)| x[*j] += share * share * inner[r]);
        }
    }
}

/// A square matrix of blocks, in the combinations of a [`Parity`].
pub(crate) struct Blockwise {
    pub(super) parity: std::rc::Rc<Parity>,
    pub(super) blocks: Vec<DMatrix<f64>>,
}

impl Blockwise {
    /// Lengths of the rows in the functions themselves.
    pub(super) fn row_lengths(&self) -> Vec<f64> {
        let mut squares = vec![0.0; self.parity.sizes.iter().product()];
        for (block, matrix) in self.parity.blocks().zip(&self.blocks) {
            let mut own = vec![0.0; matrix.nrows()];
            for column in matrix.column_iter() {
                own.iter_mut().zip(column.iter()).for_each(|(sum, x)| *sum += x * x);
            }
            self.parity.scatter_squares(block, &own, &mut squares);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// `Mᵀ x`.
    pub(crate) fn transposed_times(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        for (block, matrix) in self.parity.blocks().zip(&self.blocks) {
            let inner = self.parity.gathered(block, x);
            let image: Vec<f64> =
                matrix.column_iter().map(|column| column.iter().zip(&inner).map(|(m, x)| m * x).sum()).collect();
            self.parity.scatter(block, &image, &mut out);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mirrored(n: usize) -> DMatrix<f64> {
        let entry = |i: usize, j: usize| ((3 * i + 5 * j) as f64).cos() + ((3 * j + 5 * i) as f64).cos();
        DMatrix::from_fn(n, n, |i, j| entry(i, j) + entry(n - 1 - i, n - 1 - j))
    }

    #[test]
    fn combinations_are_an_orthonormal_basis() {
        for sizes in [[5, 4], [1, 6], [3, 1]] {
            let forms = sizes.map(|size| [mirrored(size)]);
            let parity = Parity::new([&forms[0], &forms[1]]);
            let n = sizes[0] * sizes[1];
            let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let (mut back, mut count) = (vec![0.0; n], 0);
            for block in parity.blocks() {
                let inner = parity.gathered(block, &x);
                count += inner.len();
                parity.scatter(block, &inner, &mut back);
            }
            assert_eq!(count, n);
            assert!(x.iter().zip(&back).all(|(x, y)| (x - y).abs() < 1e-15));
        }
    }

    #[test]
    fn a_mirrored_matrix_falls_into_blocks_and_another_does_not() {
        let form = mirrored(7);
        let parity = Parity::new([std::slice::from_ref(&form), &[DMatrix::identity(1, 1)]]);
        let [even, odd] = [0, 1].map(|k| parity.axes[0][k].matrix(7).map(|x| x.to_f64()));
        assert_eq!((even.ncols(), odd.ncols()), (4, 3));
        assert!((even.transpose() * &form * odd).amax() < 1e-14);
        let mut other = form;
        other[(0, 1)] += 1e-9;
        other[(1, 0)] += 1e-9;
        assert_eq!(Parity::new([&[other], &[DMatrix::identity(1, 1)]]).axes[0].len(), 1);
    }

    #[test]
    fn blocks_represent_the_whole_matrix() {
        let forms = [[mirrored(4)], [mirrored(3)]];
        let parity = std::rc::Rc::new(Parity::new([&forms[0], &forms[1]]));
        let blocks = parity.blocks().map(|[a, c]| {
            let size = parity.axes[0][a].size() * parity.axes[1][c].size();
            DMatrix::from_fn(size, size, |i, j| ((2 * i + 7 * j + a) as f64).sin())
        });
        let blocks: Vec<_> = blocks.collect();
        let whole = parity.blocks().zip(&blocks).fold(DMatrix::zeros(12, 12), |sum, ([a, c], block)| {
            let e = parity.axes[0][a].matrix(4).kronecker(&parity.axes[1][c].matrix(3)).map(|x| x.to_f64());
            sum + &e * block * e.transpose()
        });
        let found = Blockwise { parity: std::rc::Rc::clone(&parity), blocks };
        let x: Vec<f64> = (0..12).map(|i| (i as f64).cos()).collect();
        let image = whole.tr_mul(&nalgebra::DVector::from_vec(x.clone()));
        assert!(found.transposed_times(&x).iter().zip(image.iter()).all(|(a, b)| (a - b).abs() < 1e-14));
        let lengths = found.row_lengths();
        assert!(whole.row_iter().zip(lengths).all(|(row, length)| (row.norm() - length).abs() < 1e-14));
    }
}
