//! Warnings about a correction.

use super::{
    damping::Damping,
    problem::{Correction, Setting},
    solution::{Change, Indistinguishable},
};
use crate::warning::{Common, Warning};
use flankfit_estimation::{FitResult, result::RegularizationKind, spec::Regularization};

impl Correction {
    pub(super) fn indistinguishable(fit: &FitResult) -> Vec<Indistinguishable> {
        fit.collinearity
            .near_dependencies
            .iter()
            .map(|dependency| Indistinguishable {
                names: dependency.terms.clone(),
                condition_index: dependency.condition_index,
                sentence: dependency.sentence.clone(),
            })
            .collect()
    }

    pub(super) fn warn(&self, settings: &[Change], fit: &FitResult, warnings: &mut Vec<Warning>) {
        let limited: Vec<String> =
            settings.iter().filter(|s| s.limited && !s.undetermined).map(|s| s.name.clone()).collect();
        if !limited.is_empty() {
            warnings.push(Warning::SettingsLimited { settings: limited });
        }
        self.warn_undetermined(settings, warnings);
        let plain = matches!(self.asked.damping, Damping::Given(Regularization::None));
        if plain && let Some(worst) = fit.collinearity.near_dependencies.first() {
            warnings.push(Warning::UndampedCorrection(worst.sentence.clone()));
        }
        if fit.regularization.kind == RegularizationKind::TruncatedSvd
            && matches!(self.asked.damping, Damping::Uncertainty)
        {
            warnings.push(Warning::DependentSettings);
        }
    }

    /// Returns warnings about settings that the deviations say nothing about, and about the limits
    /// that they were given.
    fn warn_undetermined(&self, settings: &[Change], warnings: &mut Vec<Warning>) {
        let mut warn = |places: Vec<usize>, warning: &dyn Fn(Vec<String>) -> Warning| {
            if !places.is_empty() {
                warnings.push(warning(places.iter().map(|&j| settings[j].name.clone()).collect()));
            }
        };
        let (moved, staying): (Vec<usize>, Vec<usize>) =
            self.undetermined.iter().partition(|&&j| settings[j].change != 0.0);
        let limited = |j: &usize| {
            let Setting { min, max, increment, .. } = &self.asked.settings[*j];
            [min, max, increment].iter().any(|limit| limit.is_some())
        };
        let unused: Vec<usize> = staying.iter().copied().filter(limited).collect();
        let common = match self.asked.traces {
            Some(_) if self.asked.flank_zeros => Common::NodesOfFlank,
            Some(_) => Common::NodesOfTrace,
            None => Common::Nodes,
        };
        let (alike, hidden): (Vec<usize>, Vec<usize>) = staying.into_iter().partition(|j| self.alike.contains(j));
        warn(alike, &|settings| Warning::UndeterminedSettings { settings, common: Some(common) });
        warn(hidden, &|settings| Warning::UndeterminedSettings { settings, common: None });
        warn(moved, &|settings| Warning::UndeterminedSettingsMoved { settings });
        warn(unused, &|settings| Warning::LimitsWithoutEffect { settings });
    }
}
