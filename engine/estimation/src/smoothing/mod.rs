//! Smoothing by a roughness penalty whose equations are banded: the smoothing spline of a curve,
//! and the choice of λ that it shares with big surfaces (`banded`).

pub mod choice;
mod reinsch;
pub mod spline;

pub use choice::{Figures, Smoothing};
pub use spline::{SmoothingSpline, smoothing_spline};
