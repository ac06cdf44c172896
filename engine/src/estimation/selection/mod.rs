//! The parameter of a regularisation: filters on the spectrum, criteria, and the search for λ*.

pub mod choice;
mod classical;
mod filter;
mod lambda_star;
pub mod scan;

pub(crate) use filter::{Filtered, Rule, Spectral};
pub(crate) use lambda_star::{Chosen, Search, Unavailable, range};
