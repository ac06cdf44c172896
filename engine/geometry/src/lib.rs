//! Bases on an axis (polynomials and B-splines: values, derivatives, changes of basis), and the
//! curves and surfaces of the paper's section 2 that are made of them.
//!
//! Bases are generic over [`flankfit_numerics::Real`], so that the same code computes in double and
//! in double-double precision.

#![warn(missing_docs, unnameable_types, unreachable_pub)]

pub mod axes;
pub mod b_spline;
pub mod bernstein;
#[cfg(feature = "contract")]
pub mod contract;
pub mod curve;
pub mod mapping;
pub mod polar;
pub mod polynomial;
pub mod rational;
pub mod space;
pub mod surface;

pub use b_spline::BSplineBasis;
pub use mapping::Mapping;
pub use rational::WeightNet;
