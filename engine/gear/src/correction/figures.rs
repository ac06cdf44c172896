//! Figures of a flank as the settings of a machine move them.
//!
//! Figures are linear in the deviations, so a change Δ of the settings takes a figure f to
//! `f(d) + Σ_j f(J_j) Δ_j`. What is known of its error stays as it was: the change is exactly
//! known, the deviations are not.

use crate::{
    Side,
    evaluation::{flank_surface::EstimatedFigure, within},
};
use flankfit_estimation::inference::{Conformity, ConformityVerdict};

/// A figure of a flank, held against its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldFigure {
    /// The flank.
    pub side: Side,
    /// Name of the figure, as [`crate::evaluation::flank_surface::FlankFigures::named`] has
    /// it, or [`MEAN`].
    pub name: &'static str,
    /// As measured, µm.
    pub measured: EstimatedFigure,
    /// Target of the figure, µm.
    pub target: f64,
    /// Change of the figure by one unit more of each setting, µm.
    pub moved: Vec<f64>,
    /// Limits of the figure, µm.
    pub limits: Option<[f64; 2]>,
}

/// Name of the level of a flank whose deviations have a datum: the constant of its second-order
/// surface. It has no limits.
pub const MEAN: &str = "mean";

impl HeldFigure {
    /// The figure after a change of the settings, µm.
    pub fn after(&self, change: &[f64]) -> f64 {
        self.measured.value + self.moved.iter().zip(change).map(|(m, c)| m * c).sum::<f64>()
    }

    /// Returns the conformity of the figure, were it `value`; `None` without limits.
    pub fn conformity(&self, value: f64) -> Option<Conformity> {
        let about = self.measured.at(value).about;
        self.limits.map(|limits| match about {
            Some(about) => about.conformity(limits),
            None => Conformity::undecidable(limits, self.measured.doubts),
        })
    }

    /// Returns the figure as the fits of the measured teeth have it ([`EstimatedFigure::by_fits`]).
    /// A target that leaves the figure as measured leaves it so.
    #[must_use]
    pub fn by_fits(self, fits: &[EstimatedFigure]) -> Self {
        let EstimatedFigure { value, .. } = self.measured;
        let measured = self.measured.by_fits(fits);
        let left = (self.target - value).abs() <= ROUNDING * value.abs();
        HeldFigure { measured, target: if left { measured.value } else { self.target }, ..self }
    }

    /// Whether the figure, were it `value`, conforms to `limits`; by its value alone without
    /// degrees of freedom.
    pub(super) fn conforms(&self, value: f64, limits: [f64; 2]) -> bool {
        match self.measured.at(value).about {
            Some(about) => about.conformity(limits).verdict == ConformityVerdict::Conforms,
            None => within(value, Some(limits)) == Some(true),
        }
    }

    /// Whether the figure, were it `value`, lies outside its limits.
    pub fn is_outside(&self, value: f64) -> bool {
        within(value, self.limits) == Some(false)
    }
}

/// Share of what a setting moves most from which on it moves a figure.
const MOVED: f64 = 0.05;

/// Share of the greatest effect of all settings, or of a figure, up to which a value is rounding.
pub(super) const ROUNDING: f64 = 1e-9;

/// The figures of `all` that a setting moves: those with more than a twentieth of its greatest
/// effect.
pub fn moved_by(all: &[HeldFigure], setting: usize) -> impl Iterator<Item = &HeldFigure> {
    let effect = move |figure: &HeldFigure| figure.moved[setting].abs();
    let greatest = all.iter().flat_map(|figure| &figure.moved).fold(0.0, |most: f64, x| most.max(x.abs()));
    let least = (MOVED * all.iter().map(effect).fold(0.0, f64::max)).max(ROUNDING * greatest);
    all.iter().filter(move |figure| effect(figure) > least)
}
