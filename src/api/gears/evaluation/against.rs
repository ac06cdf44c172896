//! The line that deviations of traces are about.

use flankfit_engine::gear::{Kind, Trace};

/// Why a trace has no design line.
pub const NO_SECTION: &str = "modifications may differ between sections: give the section of the trace";

/// Place of the section of a trace in a request.
pub fn section(i: usize, trace: &Trace) -> String {
    let name = if trace.kind == Kind::Profile { "section_z_mm" } else { "section_diameter_mm" };
    format!("/traces/{i}/{name}")
}
