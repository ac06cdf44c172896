//! Diagnostics of a fit: dependent columns, the effect of uncertain nodes, correct digits, numbers
//! above double precision.

pub(crate) mod collinearity;
pub(crate) mod correct_digits;
mod dependence;
pub mod finite;
mod outliers;
pub(crate) mod perturbation;
mod range;

pub(crate) use dependence::{constant_in_span, dependence, refuse_dependence};
pub(crate) use outliers::outliers;
pub(crate) use range::{columns_within_range, within_range};
