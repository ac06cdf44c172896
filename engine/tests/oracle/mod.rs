//! An oracle for the tests: everything the service computes in doubles, computed again the plain
//! way in 640-bit floating point, so that conditions of 1e40 still leave a hundred digits. It
//! shares no code with the crate: it forms XᵀX, solves by elimination and finds eigenvalues by
//! two-sided Jacobi, exactly what the crate must not do. [`rational`] solves least squares without
//! any rounding.

pub mod big;
pub mod checked;
pub mod coverage;
pub mod design;
pub mod errors;
pub mod matrix;
pub mod positions;
pub mod random;
pub mod rational;
pub mod spectral;
