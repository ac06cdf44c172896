//! The paper: measurement matrix, spectrum, regularisation by B, λ*, bias bounds, collinearity.
//!
//! Knows no HTTP, no SQL and no serialisation.

mod accumulate;
mod bias;
mod choice;
mod collinearity;
mod design;
mod digits;
pub mod error;
mod factor;
mod filter;
mod lambda_star;
mod perturbation;
mod residuals;
mod sample;
mod scaled;
mod separable;
mod spectrum;
pub mod fit;
pub mod nodes;
pub mod result;
pub mod spec;

pub use error::{Fault, Faults, FitError};
pub use fit::fit;
pub use nodes::Nodes;
pub use result::FitResult;
pub use spec::FitSpec;
