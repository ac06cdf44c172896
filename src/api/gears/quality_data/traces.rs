//! The figures of evaluated traces as characteristics, with their limits.

use super::list::{List, flank};
use crate::api::gears::evaluation::answer::EvaluationBody;
use flankfit_engine::{
    estimation::inference::Conformity,
    formats::qdas,
    gear::{
        Gear, Kind,
        evaluation::{Evaluated, SidedLimits, Summary, TraceSurface, Twist},
        tolerance::{Characteristic, Rounding, Tolerances},
    },
};

/// Returns slope, form, total and crowning of each trace, their means over the teeth, twists, and
/// the figures of surfaces.
pub fn characteristics(found: &EvaluationBody, gear: Option<&Gear>) -> Vec<qdas::Characteristic> {
    let limits = Limits::new(found, gear);
    let mut list = List::default();
    found.traces.iter().for_each(|trace| of_trace(trace, &limits, &mut list));
    found.summaries.iter().for_each(|mean| of_mean(mean, &mut list));
    found.twists.iter().for_each(|twist| of_twist(twist, &mut list));
    found.surfaces.iter().for_each(|surface| of_surface(surface, &mut list));
    list.into_vec()
}

fn of_trace(trace: &Evaluated, limits: &Limits, list: &mut List) {
    let (letter, side) = flank(trace.flank);
    let (tooth, values) = (&trace.tooth, trace.values);
    let symbols = Symbols::of(trace.kind);
    let [slope, form, total, crowning] = limits.of_trace(trace);
    for (symbol, value, limits) in [
        (symbols.slope.symbol(), values.map(|values| values.slope_um), slope),
        (symbols.form.symbol(), values.map(|values| values.form_um), form),
        (symbols.total.symbol(), values.map(|values| values.total_um), total),
        (symbols.crowning, values.map(|values| values.crowning_um), crowning),
    ] {
        list.push(&format!("{tooth}{letter}-{symbol}"), format!("{symbol}, {side} of tooth {tooth}"), value, limits);
    }
    let tip_relief = values.and_then(|values| values.tip_relief_um);
    if tip_relief.is_some() {
        let name = format!("f_Ko, tip relief, {side} of tooth {tooth}");
        list.push(&format!("{tooth}{letter}-f_Ko"), name, tip_relief, [None; 2]);
    }
}

fn of_mean(mean: &Summary, list: &mut List) {
    let (letter, side) = flank(mean.flank);
    let symbols = Symbols::of(mean.kind);
    let figures = [
        (symbols.slope.symbol(), &mean.slope_um),
        (symbols.form.symbol(), &mean.form_um),
        (symbols.total.symbol(), &mean.total_um),
        (symbols.crowning, &mean.crowning_um),
    ];
    let relief = mean.tip_relief_um.as_ref().map(|figure| ("f_Ko", figure));
    for (symbol, figure) in figures.into_iter().chain(relief) {
        for (initial, words, value) in [("m", "mean", figure.mean), ("V", "variation", figure.variation)] {
            let name = format!("{words} of {symbol} over the teeth, {side}");
            list.push(&format!("{initial}{letter}-{symbol}"), name, Some(value), [None; 2]);
        }
    }
}

fn of_twist(twist: &Twist, list: &mut List) {
    let (letter, side) = flank(twist.flank);
    let tooth = &twist.tooth;
    let (between, words) = match twist.kind {
        Kind::Profile => ("P", "two profiles"),
        Kind::Helix => ("H", "two helices"),
    };
    let name = format!("twist of {words}, {side} of tooth {tooth}");
    list.push(&format!("{tooth}{letter}-twist_{between}"), name, Some(twist.twist_um), [None; 2]);
}

fn of_surface(surface: &TraceSurface, list: &mut List) {
    let (letter, side) = flank(surface.flank);
    let tooth = &surface.tooth;
    let [profile, helix] = [Kind::Profile, Kind::Helix].map(Symbols::of);
    let figures = &surface.figures;
    for (symbol, figure) in [
        (profile.slope.symbol(), figures.profile_slope),
        (helix.slope.symbol(), figures.helix_slope),
        (profile.crowning, figures.profile_crowning),
        (helix.crowning, figures.helix_crowning),
        ("twist", figures.twist),
    ] {
        let Some(figure) = figure else { continue };
        let name = format!("{symbol} of the surface, {side} of tooth {tooth}");
        let limits = bounds(figure.conformity.map(|conformity| conformity.limits));
        list.push(&format!("{tooth}{letter}-S-{symbol}"), name, Some(figure.value), limits);
    }
}

/// The standard's names of the figures of a kind of trace.
struct Symbols {
    slope: Characteristic,
    form: Characteristic,
    total: Characteristic,
    crowning: &'static str,
}

impl Symbols {
    fn of(kind: Kind) -> Self {
        use Characteristic as C;
        let (slope, form, total, crowning) = match kind {
            Kind::Profile => (C::ProfileSlope, C::ProfileForm, C::ProfileTotal, "C_alpha"),
            Kind::Helix => (C::HelixSlope, C::HelixForm, C::HelixTotal, "C_beta"),
        };
        Symbols { slope, form, total, crowning }
    }
}

/// Limits of the figures of traces, as far as they are known.
struct Limits {
    given: SidedLimits,
    /// Tolerances of the requested class.
    tolerances: Option<Tolerances>,
    rounded: bool,
}

impl Limits {
    fn new(found: &EvaluationBody, gear: Option<&Gear>) -> Self {
        Limits {
            given: found.evaluation.tolerance_limits.unwrap_or_default(),
            tolerances: gear.and_then(|gear| Tolerances::new(gear).ok()),
            rounded: found.evaluation.tolerances != Some(Rounding::Unrounded),
        }
    }

    fn of_class(&self, characteristic: Characteristic) -> Option<f64> {
        let (class, tolerances) = (self.given.class?, self.tolerances.as_ref()?);
        if self.rounded {
            tolerances.rounded(characteristic, class)
        } else {
            tolerances.unrounded(characteristic, class)
        }
    }

    /// Returns the limits of slope, form, total and crowning: those of the comparison, else of the
    /// flank, else of the class.
    fn of_trace(&self, trace: &Evaluated) -> [[Option<f64>; 2]; 4] {
        let given = self.given.of(trace.flank);
        let [slope, form, total, crowning] = match trace.kind {
            Kind::Profile => {
                [given.profile_slope_um, given.profile_form_um, given.profile_total_um, given.profile_crowning_um]
            }
            Kind::Helix => [given.helix_slope_um, given.helix_form_um, given.helix_total_um, given.helix_crowning_um],
        };
        let symbols = Symbols::of(trace.kind);
        let compared = |conformity: Option<Conformity>| conformity.map(|conformity| conformity.limits);
        let most = |given: Option<[f64; 2]>, of| given.map_or([None, self.of_class(of)], |limits| limits.map(Some));
        let of_class = || self.of_class(symbols.slope).map(|tolerance| [-tolerance, tolerance]);
        [
            bounds(compared(trace.slope_conformity).or(slope).or_else(of_class)),
            most(form, symbols.form),
            most(total, symbols.total),
            bounds(compared(trace.crowning_conformity).or(crowning)),
        ]
    }
}

fn bounds(limits: Option<[f64; 2]>) -> [Option<f64>; 2] {
    limits.map_or([None; 2], |limits| limits.map(Some))
}
