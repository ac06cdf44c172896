//! Curves through and near points: requests, readers, responses, evaluation and closest points.

pub mod closest;
pub mod evaluate;
pub mod methods;
pub mod near;
pub mod near_result;
pub mod points;
pub mod request;
pub mod result;

pub use self::request::build;
