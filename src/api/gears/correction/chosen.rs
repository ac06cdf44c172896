//! Figures of the flanks of a correction by the chosen fits of their iterations.

use crate::api::gears::fit_figures::FitFiguresBody;
use flankfit_engine::{
    estimation::inference::Inferred,
    gear::{
        correction::{FigureChange, Flank, HeldFigure},
        evaluation::flank_surface::{EstimatedFigure, Figure, FlankFigures},
    },
    numerics::distribution::Student,
};

/// Lengths that are equal within this, mm, are one.
const SAME: f64 = 1e-6;

/// The figures of the chosen fit of an iteration.
#[derive(Clone, Debug, Default)]
pub struct ChosenFigures {
    pub figures: FitFiguresBody,
    /// Level of their intervals.
    pub level: f64,
    /// True if the fit has a prior.
    pub has_prior: bool,
}

/// The figures of the teeth of a flank, each that all of their fits have.
pub type OfTeeth = FlankFigures<Vec<EstimatedFigure>>;

impl ChosenFigures {
    /// Returns the figures if they are of the same ranges, direction and reference lengths as those
    /// of `flank`.
    fn over(&self, flank: &Flank) -> FlankFigures<EstimatedFigure> {
        let own = &self.figures;
        let [profile, helix] = [flank.ranges.profile, flank.ranges.helix];
        let references = flank.references();
        let pairs = [
            (own.roll_length_range_mm, [profile[0].min(profile[1]), profile[0].max(profile[1])]),
            (own.z_range_mm, helix),
            (own.profile_reference_length_mm.zip(own.helix_reference_length_mm).map(<[f64; 2]>::from), references),
        ];
        let same = |(a, b): &(Option<[f64; 2]>, [f64; 2])| {
            a.is_some_and(|a| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME))
        };
        let is_same = own.direction == Some(flank.terms.direction) && pairs.iter().all(same);
        // heights with a zero for each trace are another flank than those of the fit
        if !is_same || flank.traces.is_some() {
            return FlankFigures::default();
        }
        own.figures.map(|figure| self.estimated(figure))
    }

    /// Returns a figure with the estimate that its interval is of.
    fn estimated(&self, figure: Figure) -> EstimatedFigure {
        let Figure { value, std_error, inference, .. } = figure;
        let doubts = self.figures.reasons;
        let interval = inference.map(|one| one.interval);
        let student = inference.and_then(|one| one.degrees_of_freedom).map_or(Student::NORMAL, Student::new);
        let quantile = student.upper_quantile(0.5 * (1.0 - self.level));
        let about = |[low, high]: [f64; 2]| Inferred {
            value: 0.5 * (low + high),
            std_error: 0.5 * (high - low) / quantile,
            bias_bound: 0.0,
            student,
            doubts,
        };
        EstimatedFigure { value, std_error, interval, about: interval.map(about), doubts }
    }
}

/// Returns the figures of the teeth of a flank by their fits; a figure that a fit does not have is
/// left out.
pub fn of_teeth<'a>(flank: &Flank, chosen: impl IntoIterator<Item = &'a ChosenFigures>) -> OfTeeth {
    let teeth: Vec<FlankFigures<EstimatedFigure>> = chosen.into_iter().map(|one| one.over(flank)).collect();
    let all = |of: fn(&FlankFigures<EstimatedFigure>) -> Option<EstimatedFigure>| {
        teeth.iter().map(of).collect::<Option<Vec<_>>>()
    };
    FlankFigures {
        profile_slope: all(|tooth| tooth.profile_slope),
        helix_slope: all(|tooth| tooth.helix_slope),
        profile_crowning: all(|tooth| tooth.profile_crowning),
        helix_crowning: all(|tooth| tooth.helix_crowning),
        twist: all(|tooth| tooth.twist),
    }
}

/// Returns the figures of the teeth before and after a correction for a comparison. If a fit has a
/// prior, which may be the prediction, neither has any: both are compared by their nodes.
pub fn to_compare<'a>(
    flank: &Flank,
    before: &[ChosenFigures],
    after: impl IntoIterator<Item = &'a ChosenFigures>,
) -> [OfTeeth; 2] {
    let after: Vec<&ChosenFigures> = after.into_iter().collect();
    if before.iter().chain(after.iter().copied()).any(|one| one.has_prior) {
        return Default::default();
    }
    [of_teeth(flank, before), of_teeth(flank, after)]
}

/// Returns figures of a flank by the fits of its teeth.
pub fn held_by_fits(figures: Vec<HeldFigure>, teeth: &OfTeeth) -> Vec<HeldFigure> {
    let named = teeth.as_refs().named();
    let of = |name: &str| named.iter().find(|(own, _)| *own == name).and_then(|(_, fits)| *fits);
    figures
        .into_iter()
        .map(|figure| match of(figure.name) {
            Some(fits) => figure.by_fits(fits),
            None => figure,
        })
        .collect()
}

/// Returns figures before and after by the fits of the teeth.
pub fn changed_by_fits(
    changes: FlankFigures<FigureChange>,
    before: &OfTeeth,
    measured: &OfTeeth,
) -> FlankFigures<FigureChange> {
    fn fits(of: Option<&Vec<EstimatedFigure>>) -> &[EstimatedFigure] {
        of.map_or(&[], |fits| fits)
    }
    let by = |change: Option<FigureChange>, before: &Option<Vec<_>>, measured: &Option<Vec<_>>| {
        change.map(|change| change.by_fits(fits(before.as_ref()), fits(measured.as_ref())))
    };
    FlankFigures {
        profile_slope: by(changes.profile_slope, &before.profile_slope, &measured.profile_slope),
        helix_slope: by(changes.helix_slope, &before.helix_slope, &measured.helix_slope),
        profile_crowning: by(changes.profile_crowning, &before.profile_crowning, &measured.profile_crowning),
        helix_crowning: by(changes.helix_crowning, &before.helix_crowning, &measured.helix_crowning),
        twist: by(changes.twist, &before.twist, &measured.twist),
    }
}
