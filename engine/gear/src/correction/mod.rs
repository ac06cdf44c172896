//! Correction: from measured deviations to changes of machine settings, and whether the machine
//! answered as predicted.
//!
//! With deviations d (µm, + = material out), the wanted deviation t and the sensitivity matrix J
//! (nodes × settings, µm per unit of the setting) the flank after a change Δ of the settings is
//! predicted to be `d + J Δ`. Δ is what makes `‖d + J Δ − t‖` small, that is a fit of
//! [`flankfit_estimation`] with J as measurement matrix and the heights **y = t − d**. A positive
//! entry of J means that more of the setting leaves material standing at the node; a positive
//! change means more of the setting.
//!
//! * [`problem`]: what is asked, checked;
//! * [`damping`]: how far J is trusted, which is how λ* is chosen unless the caller says otherwise;
//! * `gain`: how noise and errors of J come back in the changes;
//! * [`flank`]: the flank that the nodes lie on, the targets that it can be given;
//! * [`figures`]: its figures, as the settings move them;
//! * [`needed`]: which settings are left alone;
//! * `limits`: settings that may not go as far as they should;
//! * `rounding`: settings that the control sets in steps;
//! * [`solution`]: the answer, `notices`: what is to be said of it;
//! * [`teeth`]: the mean of a flank over several teeth;
//! * [`mod@compare`]: predicted and measured side by side;
//! * [`machine`]: J of cylindrical gear grinding.

pub mod compare;
pub mod damping;
mod datum;
pub mod figures;
pub mod flank;
mod gain;
mod hidden;
mod limits;
pub mod machine;
pub mod needed;
mod notices;
pub mod problem;
mod rounding;
mod scatter;
pub mod solution;
pub mod teeth;

pub use compare::{Answer, Comparison, FigureChange, Measurements, NotEntered, Verdict, compare, compare_figures};
pub use damping::{DEFAULT_RESPONSE_UNCERTAINTY, Damping, Trust};
pub use figures::HeldFigure;
pub use flank::Flank;
pub use needed::{DEFAULT_KEEP_WITHIN, Unchanged};
pub use problem::{Correction, CorrectionSpec, MOST_ENTRIES, MOST_SETTINGS, ResponseErrors, Setting, SettingsUsed};
pub use scatter::Scatter;
pub use solution::{Change, Indistinguishable, Noise, Predicted, Solution};
pub use teeth::TeethMean;
