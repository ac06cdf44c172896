//! Number kernels that know nothing but numbers.
//!
//! The small eigenvalues of a measurement are what this crate is about, so everything here is made
//! to keep them: an orthogonal triangularisation ([`qr`]) instead of the normal equations,
//! one-sided Jacobi ([`jacobi`]) for singular values with high relative accuracy, and the same
//! algorithms once more in double-double ([`dd`]) for data whose digits a double cannot hold.
//! [`Real`] is the number type the algorithms are generic over, [`lanes`] four of them side by
//! side; [`columns`] holds its inner loops over columns.
//!
//! Conventions: matrices are column-major `nalgebra::DMatrix`; triangular factors are upper;
//! singular values ascend. Every result is a fixed sequence of operations: equal input gives equal
//! bits.

#![warn(missing_docs, unnameable_types, unreachable_pub)]

pub mod ball;
pub mod band_cholesky;
pub mod banded;
pub mod cancel;
pub mod check;
pub mod columns;
pub mod condition;
#[cfg(feature = "contract")]
pub mod contract;
pub mod dd;
pub mod dispatch;
pub mod distribution;
pub mod givens;
mod inverse;
pub mod jacobi;
mod jacobi_dd;
pub mod lanczos;
pub mod lanes;
mod lanes_dd;
pub mod matvec;
pub mod minimize;
pub mod order;
pub mod polyhedron;
pub mod qr;
pub mod quadrature;
pub mod quantiles;
pub mod real;
pub mod root;
mod rows;
mod scalar_product;
mod shared;
pub mod sums;
pub mod symmetric;
pub mod triangular;
mod tridiagonal;
mod vector;
mod warning;
pub mod words;

pub use dispatch::fma;
pub use scalar_product::{dot, length};
pub use shared::Shared;

pub use ball::Ball;
pub use banded::{Banded, BandedLu, Singular};
pub use dd::Dd;
pub use givens::Triangle;
pub use inverse::inverse;
pub use jacobi::{Svd, svd};
pub use jacobi_dd::svd_dd;
pub use qr::{Qr, qr_with_rhs};
pub use real::Real;
pub use rows::Rows;
pub use sums::sum2;
