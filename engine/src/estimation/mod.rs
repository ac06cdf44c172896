//! The paper: measurement matrix, spectrum, regularisation by B, λ*, bias bounds, collinearity.
//!
//! Knows no HTTP, no SQL and no serialisation.

mod accumulate;
mod admission;
mod banded;
mod bias;
pub mod blocks;
mod choice;
mod collinearity;
mod cost;
mod design;
mod digits;
pub mod error;
mod estimate;
pub mod estimator;
mod evidence;
mod factor;
mod filter;
pub mod filtering;
pub mod fit;
mod frame;
mod lambda_star;
pub mod near;
pub mod nodes;
mod normal;
mod perturbation;
pub mod plan;
pub mod randomization;
pub mod recursive;
mod regularized;
mod residuals;
pub mod result;
pub mod robust;
mod sample;
mod scaled;
mod seen;
mod separable;
pub mod smoothing;
pub mod sound;
pub mod spec;
mod spectrum;
pub mod state;
mod tile;

pub use crate::fault::words;
pub use banded::weight::Trace;
pub use cost::is_short;
pub use error::{Fault, Faults, FitError};
pub use filtering::{fit, fit_remembering};
pub use nodes::Nodes;
pub use plan::Plans;
pub use recursive::Recursive;
pub use result::FitResult;
pub use spec::FitSpec;
