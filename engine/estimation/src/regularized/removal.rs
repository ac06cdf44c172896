//! Bias of the scaled coefficients by a penalty: `M A`, `M = Z diag(1−f) Z⁻¹`.

use nalgebra::{DMatrix, DVector};

use super::{
    extreme::{largest, largest_of_blocks},
    parity::Blockwise,
};

/// The removal M, as it was found.
pub(crate) enum Removal {
    Whole(DMatrix<f64>),
    Blocks(Blockwise),
}

impl Removal {
    /// `Mᵀ x`.
    pub(super) fn transposed_times(&self, x: DVector<f64>) -> DVector<f64> {
        match self {
            Removal::Whole(matrix) => matrix.tr_mul(&x),
            Removal::Blocks(blocks) => DVector::from_vec(blocks.transposed_times(x.as_slice())),
        }
    }

    /// `‖M‖₂`.
    pub(super) fn norm(&self) -> f64 {
        match self {
            Removal::Whole(matrix) => {
                let ones = DVector::from_element(matrix.ncols(), 1.0);
                largest(matrix, &ones).0.sqrt()
            }
            Removal::Blocks(Blockwise { blocks, .. }) => {
                let mut first = 0;
                let members: Vec<Vec<usize>> = blocks
                    .iter()
                    .map(|matrix| {
                        first += matrix.ncols();
                        (first - matrix.ncols()..first).collect()
                    })
                    .collect();
                let blocks = members.iter().zip(blocks).map(|(members, matrix)| (&members[..], matrix)).collect();
                largest_of_blocks(&blocks, &vec![1.0; first]).0.sqrt()
            }
        }
    }
}
