//! The paper: measurement matrix, spectrum, regularisation by B, λ*, bias bounds, collinearity.
//!
//! Knows no HTTP, no SQL and no serialisation.

pub mod error;
pub mod fit;
pub mod nodes;
pub mod result;
pub mod spec;

pub use error::{Fault, Faults, FitError};
pub use fit::fit;
pub use nodes::Nodes;
pub use result::FitResult;
pub use spec::FitSpec;
