//! What a fit request asks for, as it is written: models, regularisations, and the rest of the
//! spec.
//!
//! The structs here are read (by [`super::reader`]), written (specs are stored as canonical JSON)
//! and documented (OpenAPI). Unions carry `type` inside their variants, which is what client
//! generators cope with best.

pub mod constraint;
pub mod contamination;
pub mod count;
pub mod criteria;
pub mod errors;
pub mod estimator;
pub mod exclude;
pub mod filters;
pub mod folds;
pub mod include;
pub mod json;
pub mod knots;
pub mod model;
pub mod model_json;
pub mod nodes;
pub mod predict;
pub mod prior;
pub mod regularization;
pub mod regularization_json;
pub mod representative;
pub mod request;
pub mod scheme;
pub mod select;
pub mod terms;
pub mod zeros;
