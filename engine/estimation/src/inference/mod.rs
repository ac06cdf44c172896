//! Confidence intervals of coefficients: Student's about least squares, and, where a limit r of
//! their norm is known beforehand, shorter ones about a filtered estimate.
//!
//! A regularised estimate ± t · standard error is no interval: its bias is of the size of its
//! standard error. Without knowledge of r an honest interval is shorter than that of least squares
//! at some coefficients at most, by 15 % (Pratt, JASA 56, 1961), and wider at others (Low, Annals
//! of Statistics 25, 1997). With it, [`bias_aware`] gives the shortest that is made of one filter
//! and holds for all coefficients within r (Armstrong and Kolesár, Econometrica 86, 2018).

mod bias_aware;
mod conformity;
mod doubts;
mod noise;
mod quantile;
mod simultaneous;

pub use bias_aware::{BiasAware, LinearForm, bias_aware};
pub use conformity::{Assumptions, CONFORMANCE_PROBABILITY, Conformity, ConformityVerdict, Inferred};
pub use doubts::Doubts;
pub use noise::Noise;
pub use quantile::{biased_quantile, half_width};
pub use simultaneous::{
    Among, SimultaneousMethod, Tube, bonferroni, path_length, scheffe, sheet, simultaneous_factor, tube_factor,
};
