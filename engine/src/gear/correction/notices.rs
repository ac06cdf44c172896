//! What a correction has to say of its answer.

use super::{
    damping::Damping,
    problem::{Correction, Setting},
    solution::{Change, Indistinguishable},
};
use crate::estimation::{FitResult, result::RegularizationKind, spec::Regularization};
use crate::gear::warning::Warning;

impl Correction {
    pub(super) fn indistinguishable(&self, fit: &FitResult) -> Vec<Indistinguishable> {
        let place = |name: &String| self.asked.settings.iter().position(|setting| setting.name == *name);
        fit.collinearity
            .near_dependencies
            .iter()
            .map(|dependency| Indistinguishable {
                settings: dependency.terms.iter().filter_map(place).collect(),
                names: dependency.terms.clone(),
                condition_index: dependency.condition_index,
                sentence: dependency.sentence.clone(),
            })
            .collect()
    }

    pub(super) fn warn(&self, settings: &[Change], fit: &FitResult, warnings: &mut Vec<Warning>) {
        let limited: Vec<String> = settings
            .iter()
            .filter(|s| s.limited.is_some() && !s.undetermined)
            .map(|s| format!("`{}`", s.name))
            .collect();
        if !limited.is_empty() {
            warnings.push(Warning {
                code: "settings_limited",
                message: format!(
                    "{} would go further than allowed; the others make up for it as far as they can",
                    limited.join(", ")
                ),
            });
        }
        self.warn_undetermined(settings, warnings);
        let plain = matches!(self.asked.damping, Damping::Given(Regularization::None));
        if plain && let Some(worst) = fit.collinearity.near_dependencies.first() {
            warnings.push(Warning {
                code: "undamped_correction",
                message: format!(
                    "plain least squares divides by what the sensitivity hardly knows ({}): repeated, such a \
                     correction can drive the settings away",
                    worst.sentence
                ),
            });
        }
        if fit.regularization.kind == RegularizationKind::TruncatedSvd
            && matches!(self.asked.damping, Damping::Uncertainty)
        {
            warnings.push(Warning {
                code: "dependent_settings",
                message: "some settings depend on each other exactly on these nodes: the smallest changes that do the \
                    same are answered"
                    .into(),
            });
        }
    }

    /// What becomes of settings that the deviations say nothing about, and of the limits that they
    /// were given.
    fn warn_undetermined(&self, settings: &[Change], warnings: &mut Vec<Warning>) {
        let mut warn = |code, places: Vec<usize>, message: &str| {
            let names: Vec<String> = places.iter().map(|&j| format!("`{}`", settings[j].name)).collect();
            if !names.is_empty() {
                warnings.push(Warning { code, message: format!("{}: {message}", names.join(", ")) });
            }
        };
        let (moved, staying): (Vec<usize>, Vec<usize>) =
            self.undetermined.iter().partition(|&&j| settings[j].change != 0.0);
        let limited = |j: &usize| {
            let Setting { min, max, increment, .. } = &self.asked.settings[*j];
            [min, max, increment].iter().any(|limit| limit.is_some())
        };
        let unused: Vec<usize> = staying.iter().copied().filter(limited).collect();
        let all = if self.asked.traces.is_some() { "all nodes of a trace" } else { "all nodes" };
        let alike = format!(
            "it would change {all} nearly alike, and deviations without a datum do not tell what {all} have in common; \
             it stays as it is"
        );
        warn("undetermined_settings", staying, &alike);
        warn(
            "undetermined_settings_moved",
            moved,
            "the deviations say nothing about it, but its limits do not let it stay as it is; it goes no further than \
             they ask for",
        );
        warn(
            "limits_without_effect",
            unused,
            "the deviations say nothing about it, so its limits and its increment were not needed",
        );
    }
}
