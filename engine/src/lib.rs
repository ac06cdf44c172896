#![doc = include_str!("../README.md")]

pub use flankfit_estimation as estimation;
pub use flankfit_formats as formats;
pub use flankfit_gear as gear;
pub use flankfit_geometry as geometry;
pub use flankfit_numerics as numerics;
pub use flankfit_numerics::words;
