//! The line that deviations of traces are about.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::gear::{Kind, Trace, evaluation::Against};

/// Line that deviations are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = DeviationsAgainst)]
pub enum AgainstName {
    /// The involute and the unmodified helix.
    Involute,
    /// The design line: `modifications` and `design_um` of the request, else the `design` in the
    /// job's requirements.
    Design,
}

impl From<AgainstName> for Against {
    fn from(name: AgainstName) -> Self {
        match name {
            AgainstName::Involute => Against::Involute,
            AgainstName::Design => Against::Design,
        }
    }
}

/// Why a trace has no design line.
pub const NO_SECTION: &str =
    "modifications may differ from section to section: say where on the involute the trace lies";

/// Place of the section of a trace in a request.
pub fn section(i: usize, trace: &Trace) -> String {
    let name = if trace.kind == Kind::Profile { "section_z_mm" } else { "section_diameter_mm" };
    format!("/traces/{i}/{name}")
}
