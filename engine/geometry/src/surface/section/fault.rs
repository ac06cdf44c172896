//! Why a section is refused.

/// Widths of the surface and of its parameters, and coordinates, so that products stay in double.
pub(super) const SMALLEST: f64 = 1e-60;
pub(super) const LARGEST: f64 = 1e60;

/// A section that asks for too much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SectionFault {
    /// More places than are allowed.
    #[error("the section needs more than {most} points")]
    TooManyPoints {
        /// How many are allowed.
        most: usize,
    },
    /// A surface so small or so large that products of its derivatives leave the range of double.
    #[error("the surface is a point, or its coordinates or parameters are not within {SMALLEST:e} to {LARGEST:e}")]
    OutOfRange,
    /// More pieces of the surface than are looked at.
    #[error("the surface has {given} pieces between its knots; sections allow up to {most}")]
    TooManyPieces {
        /// How many there are.
        given: usize,
        /// How many are allowed.
        most: usize,
    },
}
