//! The paper: measurement matrix, spectrum, regularisation by B, λ*, bias bounds, collinearity.
//!
//! Knows no HTTP, no SQL and no serialisation.

#![warn(missing_docs, unnameable_types, unreachable_pub)]

mod banded;
mod checks;
mod constrained;
pub mod data;
mod design;
pub mod diagnostics;
mod enclosure;
pub mod error;
mod error_model;
mod estimate;
mod factor;
mod filtering;
mod fit;
pub mod inference;
pub mod near;
mod prior;
mod problem;
pub mod randomization;
pub mod recursive;
mod regularized;
pub mod result;
mod robust;
mod select;
mod selection;
pub mod smoothing;
pub mod spec;
mod spectrum;

pub use banded::weight::Trace;
pub use data::Nodes;
pub use error::{FitError, Unconverged};
pub use filtering::{fit, fit_remembering};
pub use fit::requested_models;
pub use fit::{Plans, is_short};
pub use recursive::Recursive;
pub use result::FitResult;
pub use spec::FitSpec;
