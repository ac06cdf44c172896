//! What is wrong with limits of figures.

use crate::tolerance::{COARSEST, FINEST, OutOfScope};
use flankfit_numerics::fault::words::Shown;

/// One of the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToleranceField {
    /// The class that gives those of slopes.
    Class,
    /// Of f_Hα.
    ProfileSlope,
    /// Of f_Hβ.
    HelixSlope,
    /// Of C_α.
    ProfileCrowning,
    /// Of C_β.
    HelixCrowning,
    /// Of the twist.
    Twist,
    /// Of f_fα.
    ProfileForm,
    /// Of f_fβ.
    HelixForm,
    /// Of F_α.
    ProfileTotal,
    /// Of F_β.
    HelixTotal,
}

/// Why limits are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToleranceReason {
    /// Limits that do not ascend.
    #[error("{} to {} µm leave nothing between them; write the lower limit first", Shown(.0[0]), Shown(.0[1]))]
    NotAscending([f64; 2]),
    /// A class that there is not.
    #[error("{0} is not one of {FINEST} to {COARSEST}")]
    NoClass(u8),
    /// A gear that the standard does not cover.
    #[error("the class gives no limits: {0}")]
    OutOfScope(OutOfScope),
    /// Tolerances of the helix need a face width.
    #[error("the class gives no limits of helix slopes without the face width of the gear; give it, or the limits")]
    NoFaceWidth,
}
