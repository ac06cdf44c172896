//! The answer to a fit. Each object of it is declared once (`declare`): struct, schema and writer.

mod constraints;
mod declare;
pub mod errors;
mod estimable;
pub mod filters;
mod influence;
pub mod parts;
pub mod predictions;
pub mod prior;
pub mod regularization;
pub mod representative;
pub mod result;
pub mod robust;
mod selection;
mod shared_text;
pub mod text;
