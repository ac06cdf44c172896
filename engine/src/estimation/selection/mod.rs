//! The parameter of a regularisation: filters on the spectrum, criteria, and the search for λ*.

mod classical;
pub mod filters;
pub mod scan;
mod search;
pub mod selector;
mod spectral;

pub(crate) use search::{Chosen, Search, Unavailable, range};
pub(crate) use spectral::{Filtered, Rule, Spectral};
