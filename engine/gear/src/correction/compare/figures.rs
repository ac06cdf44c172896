//! Figures of a flank before its machine was corrected and after.
//!
//! Both measurements have the form that no figure speaks of in common, and it is in the residuals
//! of either. So the change is that of a surface through the differences of the deviations, node by
//! node, with the standard error of its own residuals: what both have in common is gone from it.
//! The same is done of what was measured less what was predicted; there the noise of the first
//! measurement has gone through the correction, which takes from it and adds nothing, so that the
//! interval is rather too wide than too narrow.

use crate::evaluation::flank_surface::{EstimatedFigure, FlankFigures};

/// A figure before the correction, predicted and measured: by the chosen fits of the iterations as
/// in `figures`, else over the nodes that are defined in all three.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct FigureChange {
    /// Figure of the deviations that the correction was made for.
    pub before: EstimatedFigure,
    /// Figure predicted by the correction, in µm.
    #[cfg_attr(feature = "contract", serde(rename = "predicted_um"))]
    pub predicted: f64,
    /// Figure of the deviations measured after it.
    pub measured: EstimatedFigure,
    /// Measured minus before. The error is that of the differences node by node: it excludes form
    /// that both measurements share.
    pub change: EstimatedFigure,
    /// Measured minus predicted, likewise. An interval that contains 0 is consistent with the
    /// prediction.
    pub difference: EstimatedFigure,
}

impl FigureChange {
    /// Returns the figures before and after as the fits of the measured teeth have them
    /// ([`EstimatedFigure::by_fits`]), and what follows from them; errors of the changes stay those
    /// of the differences.
    #[must_use]
    pub fn by_fits(self, before: &[EstimatedFigure], measured: &[EstimatedFigure]) -> Self {
        let of_nodes = self.before.value;
        let (before, measured) = (self.before.by_fits(before), self.measured.by_fits(measured));
        let predicted = before.value + (self.predicted - of_nodes);
        FigureChange {
            before,
            predicted,
            measured,
            change: self.change.at(measured.value - before.value),
            difference: self.difference.at(measured.value - predicted),
        }
    }
}

/// The measurements that deviations are from, on which the errors of their figures depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measurements {
    /// The one before the correction.
    Before,
    /// The one after it.
    After,
    /// The difference of both.
    Both,
}

/// Figures of deviations (µm, an entry for each node, NaN where undefined) over the nodes that are
/// defined in all three; `None` where the nodes tell none.
pub fn compare_figures(
    before: &[f64],
    predicted: &[f64],
    measured: &[f64],
    figures: impl Fn(&[f64], Measurements) -> Option<FlankFigures<EstimatedFigure>>,
) -> Option<FlankFigures<FigureChange>> {
    let lists = || before.iter().zip(predicted).zip(measured);
    let of = |measurements, value: fn(f64, f64, f64) -> f64| {
        let node = |((b, p), m): ((&f64, &f64), &f64)| {
            if b.is_nan() || p.is_nan() || m.is_nan() { f64::NAN } else { value(*b, *p, *m) }
        };
        figures(&lists().map(node).collect::<Vec<f64>>(), measurements)
    };
    let change = of(Measurements::Both, |before, _, measured| measured - before)?
        .zip(of(Measurements::Both, |_, predicted, measured| measured - predicted)?);
    let ends = of(Measurements::Before, |before, _, _| before)?
        .zip(of(Measurements::After, |_, _, measured| measured)?)
        .zip(of(Measurements::Before, |_, predicted, _| predicted)?);
    Some(ends.zip(change).map(|(((before, measured), predicted), (change, difference))| FigureChange {
        before,
        predicted: predicted.value,
        measured,
        change,
        difference,
    }))
}
