//! Deviations of measured points from a flank, with registration.

pub mod answer;
pub mod borders;
pub mod registration;
pub mod request;

pub use self::answer::{build, imported};
