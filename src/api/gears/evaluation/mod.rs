//! Evaluation by ISO 1328-1: traces, pitch and the surface of a flank.

pub mod against;
pub mod answer;
pub mod band;
pub mod design_lines;
pub mod evaluate;
pub mod flank_surface;
pub mod pitch;
pub mod request;
pub mod tooth_shift;

pub use self::evaluate::build;
