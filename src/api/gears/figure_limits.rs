//! Limits that a job sets for the figures of a flank, as far as the nodes cover the ranges that the
//! limits are given for.

use crate::api::{
    gears::{plausibility::digits, requirements::RequirementsBody},
    warning::WarningBody,
};
use serde_json::{Value, json};

use flankfit_engine::{
    gear::{
        Gear, Side,
        evaluation::flank_surface::{FigureTerms, FlankFigures, covers, figure_limits},
    },
    words::listed,
};

/// Code of the warning.
const RANGE_NOT_COVERED: &str = "range_not_covered";

/// The flank that nodes lie on, and the ranges of roll length and z that they span, ascending.
#[derive(Clone, Copy, Debug)]
pub struct Spanned<'a> {
    pub gear: &'a Gear,
    pub side: Side,
    pub terms: FigureTerms,
    pub ranges: [[f64; 2]; 2],
    /// Length that the helix slope refers to.
    pub helix_reference: f64,
}

/// Figures whose range the nodes cover too little of.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncovered {
    figures: Vec<&'static str>,
    reached: [f64; 2],
    range: [f64; 2],
    message: String,
}

/// Returns the limits of the figures of a flank, and the figures that the nodes cover too little
/// for. The latter have no limits, but for a helix slope, whose interval is extended with it.
pub fn of(spanned: &Spanned<'_>, requirements: &RequirementsBody) -> (FlankFigures<[f64; 2]>, Vec<Uncovered>) {
    let Spanned { gear, side, terms, ranges, .. } = *spanned;
    let Some(limits) = requirements.tolerance_limits else { return (FlankFigures::default(), Vec::new()) };
    let limits = figure_limits(gear, terms, ranges, &limits.of(side));
    let [profile, helix] = required_ranges(gear, requirements);
    let held: Vec<&'static str> =
        limits.named().into_iter().filter(|(_, limits)| limits.is_some()).map(|(name, _)| name).collect();
    let named = |names: &[&'static str]| held.iter().copied().filter(|name| names.contains(name)).collect::<Vec<_>>();
    let of_range = |what: &str, figures: Vec<&'static str>, nodes: [f64; 2], range: Option<[f64; 2]>| {
        let range = range.filter(|_| !figures.is_empty())?;
        let reached = [nodes[0].max(range[0]), nodes[1].min(range[1])];
        (!covers(reached, range)).then(|| {
            let [[from, to], [low, high]] = [reached, range].map(|ends| ends.map(digits));
            let message = format!(
                "{}: the nodes cover {what} from {from} to {to} mm of {low} to {high} mm, too little to compare with \
                 limits; measure at least three quarters of the range",
                listed(figures.iter().map(|name| format!("{name}_um")))
            );
            Uncovered { figures, reached, range, message }
        })
    };
    let profiles = named(&["profile_slope", "profile_crowning", "twist"]);
    let helices = named(&["helix_crowning", "twist"]);
    let missing: Vec<Uncovered> =
        [of_range("roll lengths", profiles, ranges[0], profile), of_range("z", helices, ranges[1], helix)]
            .into_iter()
            .flatten()
            .collect();
    let limits = limits.kept(|name| !missing.iter().any(|one| one.figures.contains(&name)));
    let extended = extended(spanned).filter(|_| limits.helix_slope.is_some());
    (limits, missing.into_iter().chain(extended).collect())
}

/// Ranges of roll length and z that the job's design is given for, ascending.
fn required_ranges(gear: &Gear, requirements: &RequirementsBody) -> [Option<[f64; 2]>; 2] {
    let ascending = |[a, b]: [f64; 2]| [a.min(b), a.max(b)];
    let Some(design) = &requirements.design else { return [None; 2] };
    let profile =
        design.profile_diameter_range_mm.and_then(|[a, b]| Some([gear.roll_length(a)?, gear.roll_length(b)?]));
    [profile.map(ascending), design.helix_range_mm.map(ascending)]
}

/// A helix slope that is extended far outside the nodes.
fn extended(spanned: &Spanned<'_>) -> Option<Uncovered> {
    let (reached, reference) = (spanned.ranges[1], spanned.helix_reference);
    let span = reached[1] - reached[0];
    (!covers([0.0, span], [0.0, reference])).then(|| {
        let [low, high] = reached.map(digits);
        let message = format!(
            "helix_slope_um: the nodes cover z from {low} to {high} mm, {} of {} mm of face width; slope and interval \
             are extended linearly: measure at least three quarters of the face width",
            digits(span),
            digits(reference)
        );
        Uncovered { figures: vec!["helix_slope"], reached, range: [0.0, reference], message }
    })
}

impl Uncovered {
    fn values(&self) -> Value {
        let figures: Vec<String> = self.figures.iter().map(|name| format!("{name}_um")).collect();
        json!({"figures": figures, "reached_mm": self.reached, "range_mm": self.range})
    }
}

impl From<&Uncovered> for WarningBody {
    fn from(found: &Uncovered) -> Self {
        WarningBody::new(RANGE_NOT_COVERED, &found.message).with_values(&found.values())
    }
}
