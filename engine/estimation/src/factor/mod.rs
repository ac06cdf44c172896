//! From the measurement matrix and the heights to `R` and `QᵀY`.

mod chunks;
mod normal_equations;
mod orthogonal;
mod orthonormal_rows;
mod residual_pass;
mod separable;

pub(crate) use chunks::{CHUNK, over_chunks};
pub(crate) use normal_equations::gram_of_moments;
pub(crate) use orthogonal::{Factor, multiply_upper_vector, scaled_condition, squares_exceed_double};
pub(crate) use orthonormal_rows::orthonormal_rows;
pub(crate) use residual_pass::{Precision, Wanted, residual_pass};
pub(crate) use separable::{Axes, AxisFactor, Separable, kronecker};
