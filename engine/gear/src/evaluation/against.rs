//! The line that deviations of traces are about.

/// Line that deviations are about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Against {
    /// The involute and the unmodified helix.
    Involute,
    /// The design line of the trace, where it has one.
    #[default]
    Design,
}

impl Against {
    /// Returns the design line to subtract from the deviations of a trace.
    pub(super) fn line(self, design: Option<&[f64]>) -> Option<&[f64]> {
        design.filter(|_| self == Against::Design)
    }
}
