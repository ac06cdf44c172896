//! Corrections of machine settings from deviations of a flank.

pub mod applied;
pub mod blocks;
pub mod chosen;
pub mod csv;
pub mod figures;
pub mod include;
pub mod iteration_nodes;
pub mod other_flank;
pub mod predicted;
pub mod request;
pub mod result;
pub mod round;
pub mod same_nodes;
pub mod sensitivity;
pub mod stored;
pub mod target;
pub mod teeth;

pub use self::result::build;
