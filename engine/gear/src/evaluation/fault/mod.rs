//! What is wrong with traces, pitches and readings, and with what they are evaluated by; and what a
//! notice speaks of.

mod flank_surface;
mod limits;
mod pitch;
mod runout;
mod settings;
mod traces;

pub use flank_surface::{SurfaceFaults, SurfaceField, SurfaceReason, SurfaceRefused};
pub use limits::{ToleranceField, ToleranceReason};
pub use pitch::{PitchFaults, PitchField, PitchReason};
pub use runout::{RunoutFaults, RunoutField, RunoutReason};
pub use settings::{SettingFaults, SettingField, SettingReason};
pub use traces::{MOST_SAMPLES, TraceFaults, TraceField, TraceReason};
