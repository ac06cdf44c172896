//! The parameter of a regularisation: filters on the spectrum, criteria, and the search for λ*.

mod blockwise;
mod classical;
mod filter;
pub(super) mod filters;
mod g_prior;
mod likelihood;
mod nodewise;
pub(super) mod scan;
mod search;
pub(super) mod selector;
mod spectral;

pub(crate) use blockwise::{Block, Blockwise, left_out, moved_by};
pub(crate) use filter::{Filtered, Rule, checked_count};
pub(crate) use g_prior::g_prior;
pub(crate) use nodewise::{LeftOut, Nodewise};
pub(crate) use search::{Chosen, Place, Search, Unavailable, range};
pub(crate) use spectral::Spectral;
