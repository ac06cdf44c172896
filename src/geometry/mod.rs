//! Bases on an axis: polynomials and B-splines, their values, derivatives and changes of basis.
//!
//! Everything is generic over [`crate::numerics::Real`], so that the same code answers in double and in
//! double-double precision.

pub mod b_spline;
pub mod mapping;
pub mod polynomial;

pub use b_spline::{BSplineBasis, KnotFault};
pub use mapping::Mapping;
