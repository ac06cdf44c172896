//! The line that deviations of traces are about.

/// Line that deviations are about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = DeviationsAgainst)
)]
pub enum Against {
    /// The involute and the unmodified helix.
    Involute,
    /// The design line: `modifications` and `design_um` of the request, else the `design` in the
    /// job's requirements.
    #[default]
    Design,
}

impl Against {
    /// Returns the design line to subtract from the deviations of a trace.
    pub(super) fn line(self, design: Option<&[f64]>) -> Option<&[f64]> {
        design.filter(|_| self == Against::Design)
    }
}
