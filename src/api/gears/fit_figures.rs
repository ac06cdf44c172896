//! Figures of the flank that an iteration's fit is of: slopes, crownings and twist from the fit's
//! own coefficients, held against what the job requires.

use serde::{Deserialize, Serialize};
use serde_json::json;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    figure_limits::{self, Spanned},
    gear::of_text,
    plausibility::{IMPLAUSIBLE_UNIT, Noise, implausible},
    requirements::{RequirementsBody, class_left_aside},
};
use crate::{
    api::{json::writer, measurand::axes::AxesBody, warning::WarningBody},
    jobs::{Job, Measurand},
};
use flankfit_engine::{
    estimation::{
        FitResult, FitSpec, Nodes, fit,
        inference::Doubts,
        result::Warning,
        spec::{Degree, Include, Model, Terms, WeightedSums},
    },
    gear::{
        Gear, ProfileAxis, Side,
        evaluation::flank_surface::{Figure, FittedFlank, FlankFigures, NoRollLengths, over_roll_lengths},
        trace::Direction,
    },
};

/// Slopes, crownings and twist of the fitted surface, in µm: those of the second-order surface
/// nearest to it in the mean square, with the signs of ISO 1328-1, for slopes those of DIN. Slopes
/// are extended linearly to their reference lengths and compared with the full limits; crownings
/// and twist refer to the range of the nodes. Limits are those of the gear and the requirements
/// that the job had when the fit was made; tolerances of a class, which are transverse, are
/// converted to `direction`. For nodes over diameters, another fit over roll lengths gives them.
/// Figures that cannot be determined are absent, with the reason in `warnings`.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitFigures)]
pub struct FitFiguresBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub figures: FlankFigures<Figure>,
    /// Direction of the figures: that of the job's requirements.
    pub direction: Option<Direction>,
    /// Length that the profile slope refers to: the range of the nodes.
    pub profile_reference_length_mm: Option<f64>,
    /// Length that the helix slope refers to: by default the face width, where the gear has one.
    pub helix_reference_length_mm: Option<f64>,
    /// Range of the nodes in roll length.
    #[schema(min_items = 2, max_items = 2)]
    pub roll_length_range_mm: Option<[f64; 2]>,
    /// Range of the nodes in z.
    #[schema(min_items = 2, max_items = 2)]
    pub z_range_mm: Option<[f64; 2]>,
    /// Codes of the warnings that intervals may not hold, or why there are none; the `reasons` of
    /// each `conformity`. Absent without such warnings.
    #[serde(default, skip_serializing_if = "Doubts::is_empty")]
    pub reasons: Doubts,
    /// Warnings about the figures, and the reasons for absent ones.
    pub warnings: Vec<WarningBody>,
}

impl FitFiguresBody {
    /// Returns the message on implausible units.
    pub fn implausible(&self) -> Option<&str> {
        self.warnings.iter().find(|warning| warning.code == IMPLAUSIBLE_UNIT).map(|warning| warning.message.as_str())
    }
}

/// Everything that figures of a flank need besides its fit.
#[derive(Clone, Debug)]
pub struct OfFlank {
    axes: AxesBody,
    side: Option<Side>,
    gear: Option<Gear>,
    requirements: RequirementsBody,
    accept_units: bool,
}

/// Codes of the warnings about data of an iteration that its figures lack.
pub const MISSING: [&str; 3] = ["axes_missing", "flank_missing", "gear_missing"];

/// Returns the missing data of an iteration without which a flank has no figures and no correction
/// by a machine: each with its code and how to add it.
pub fn missing(axes: &AxesBody, side: Option<Side>, gear: bool) -> Vec<(&'static str, String)> {
    let [axes_missing, flank_missing, gear_missing] = MISSING;
    let named = [("u", &axes.u), ("v", &axes.v), ("z", &axes.z)];
    let absent: Vec<String> =
        named.iter().filter(|(_, axis)| axis.is_none()).map(|(name, _)| format!("`{name}`")).collect();
    let mut all = Vec::new();
    if !absent.is_empty() {
        let list = absent.join(", ");
        all.push((
            axes_missing,
            format!("quantity and unit of {list} are not known: send them in `axes` by `PATCH` of the iteration"),
        ));
    }
    if side.is_none() {
        let how = "the measured flank is not known: send `flank` (`left` or `right`) by `PATCH` of the iteration";
        all.push((flank_missing, how.to_owned()));
    }
    if !gear {
        let how = "the job has no gear: send `gear` by `PATCH` of the job, then `axes` by `PATCH` of the iteration, \
                   which computes its figures";
        all.push((gear_missing, how.to_owned()));
    }
    all
}

/// Returns true if nodes may be on a flank, so that their figures depend on the job.
pub fn can_have_figures(nodes: &Nodes) -> bool {
    matches!(nodes, Nodes::Scattered(_) | Nodes::Grid(_))
}

/// Returns true if all axes of a flank are described.
fn are_described(axes: &AxesBody) -> bool {
    axes.u.is_some() && axes.v.is_some() && axes.z.is_some()
}

impl OfFlank {
    /// Collects it for nodes of a job; `None` if the job has no gear and no requirements and the
    /// axes do not describe a flank.
    pub fn of(job: &Job, measurand: &Measurand) -> Option<Self> {
        let axes = AxesBody::of(measurand).ok()?;
        if !are_described(&axes) && job.gear.is_none() && job.requirements.is_none() {
            return None;
        }
        let gear = job.gear.as_deref().and_then(|document| of_text(document).ok());
        let requirements = RequirementsBody::of(job).unwrap_or_default();
        let accept_units = measurand.accept_units;
        Some(OfFlank { axes, side: measurand.flank, gear, requirements, accept_units })
    }

    /// Returns the sums to request from a fit, or the warnings why there are no figures; `None` for
    /// nodes that cannot be on a flank.
    pub fn ask<'a>(&'a self, nodes: &'a Nodes, spec: &FitSpec) -> Option<Asked<'a>> {
        if !can_have_figures(nodes) {
            return None;
        }
        let missing = missing(&self.axes, self.side, self.gear.is_some());
        let mut warnings: Vec<WarningBody> = missing.iter().map(|(code, how)| notice(code, how)).collect();
        let found = match self.gear.as_ref().zip(self.side).filter(|_| warnings.is_empty()) {
            Some((gear, side)) => self.flank(nodes, spec, gear, side).map_err(|why| warnings.push(why)).ok(),
            None => None,
        };
        let (flank, over_roll_lengths) = found.unzip();
        // a class of which there is nothing bounds nothing
        let refused = flank.as_ref().zip(self.requirements.tolerance_limits);
        let refused = refused.and_then(|(flank, limits)| limits.of(flank.side).class_refused(flank.gear, true));
        warnings.extend(refused.as_deref().map(class_left_aside));
        Some(Asked { of: self, nodes, flank, over_roll_lengths: over_roll_lengths.flatten(), warnings })
    }

    fn flank<'a>(
        &self,
        nodes: &Nodes,
        spec: &FitSpec,
        gear: &'a Gear,
        side: Side,
    ) -> Result<(FittedFlank<'a>, Option<(Nodes, FitSpec)>), WarningBody> {
        let unknown = |why: String| notice("axes_unknown", &why);
        if let Some(why) = not_second_order(spec) {
            return Err(notice("not_second_order", why));
        }
        if self.axes.traces().is_some() {
            let why = "each trace has its own zero; evaluate the traces for their figures";
            return Err(notice("traces_with_own_zeros", why));
        }
        let height = self.axes.deviation_factor().map_err(unknown)?;
        let v = self.axes.along().map_err(unknown)?;
        let (axis, unit) =
            self.axes.profile().map_err(unknown)?.ok_or_else(|| unknown("the quantity of u is not known".into()))?;
        // a value of the wire in the unit that the axis is taken in
        let factor = axis.requested(unit);
        let no_span = || notice("no_extent", "the nodes do not extend over the flank");
        let [(u_low, u_high), (v_low, v_high)] = spans(nodes).ok_or_else(no_span)?;
        let no_involute = || notice("no_involute", "some nodes lie where the gear has no involute");
        let roll = |x: f64| axis.roll_length(gear, factor * x).ok_or_else(no_involute);
        let refused = |why| match why {
            NoRollLengths::NoInvolute => no_involute(),
            NoRollLengths::Coefficients => notice(
                "coefficients_over_diameters",
                "figures need a surface over roll lengths, and the given coefficients refer to diameters: send u as \
                 roll lengths, or fit without these coefficients",
            ),
        };
        let (u, over) = match axis {
            ProfileAxis::RollLength => (factor, None),
            ProfileAxis::RollAngle => (factor * gear.base_radius(), None),
            ProfileAxis::Diameter => (1.0, Some(over_roll_lengths(gear, factor, nodes, spec).map_err(refused)?)),
        };
        let flank = FittedFlank {
            gear,
            side,
            u,
            v,
            height,
            terms: self.requirements.figure_terms(),
            roll_lengths: [roll(u_low)?, roll(u_high)?],
            z: [v * v_low, v * v_high],
        };
        Ok((flank, over))
    }
}

/// Figures requested from a fit.
pub struct Asked<'a> {
    of: &'a OfFlank,
    nodes: &'a Nodes,
    flank: Option<FittedFlank<'a>>,
    /// Nodes over diameters and their fit as those over roll lengths.
    over_roll_lengths: Option<(Nodes, FitSpec)>,
    warnings: Vec<WarningBody>,
}

impl Asked<'_> {
    /// Returns the sums to request from the fit; `None` without figures, and where they are those
    /// of another fit, over roll lengths.
    pub fn sums(&self) -> Option<WeightedSums> {
        self.flank.as_ref().filter(|_| self.over_roll_lengths.is_none()).map(FittedFlank::sums)
    }

    /// Returns the document that is answered and stored, from the figures of the fit and those
    /// without the nodes suspected of gross errors. CPU-bound.
    pub fn answer(self, result: &FitResult) -> String {
        let Asked { of, nodes, flank, over_roll_lengths, mut warnings } = self;
        let over = flank.as_ref().zip(over_roll_lengths).map(|(flank, (nodes, spec))| {
            fit(&nodes, &FitSpec { sums: Some(flank.sums()), include: Include::default(), ..spec })
        });
        let failed = over.as_ref().and_then(|over| over.as_ref().err().map(ToString::to_string));
        let over = over.and_then(Result::ok);
        let result = over.as_ref().unwrap_or(result);
        let sums = result.sums.as_deref();
        let without_suspected = result.without_suspected.as_ref().and_then(|without| without.sums.as_deref());
        let implausible = implausible(nodes, &of.axes, of.gear.as_ref(), noise(result));
        let implausible = implausible.filter(|_| !of.accept_units);
        // with an implausible unit no figure is compared with limits
        let held = flank.as_ref().filter(|_| implausible.is_none());
        let (limits, uncovered) =
            held.map(|flank| figure_limits::of(&spanned(flank), &of.requirements)).unwrap_or_default();
        warnings.extend(implausible);
        warnings.extend(uncovered.iter().map(WarningBody::from));
        let mut body = FitFiguresBody { warnings, ..FitFiguresBody::default() };
        match (flank, sums) {
            (Some(flank), Some(sums)) => {
                let found = flank.figures(sums, limits, result.doubts());
                let lost = not_determined(found, result.residuals.sigma.map(|sigma| sigma * flank.height.abs()));
                body.warnings.extend(lost.iter().map(|name| undetermined(name)));
                let found = found.kept(|name| !lost.contains(&name));
                let without = without_suspected.map(|sums| flank.figures(sums, limits, result.doubts()));
                body.warnings.extend(without.map(|without| outliers_suspected(found, without)));
                body.figures = found;
                body.reasons = result.doubts();
                body.direction = Some(flank.terms.direction);
                let [profile, helix] = flank.references();
                body.profile_reference_length_mm = Some(profile);
                body.helix_reference_length_mm = Some(helix);
                body.roll_length_range_mm = Some(flank.roll_lengths);
                body.z_range_mm = Some(flank.z);
                if sums.iter().any(Option::is_none) {
                    body.warnings.push(notice("exceeds_double", "figures exceed the range of double precision"));
                }
            }
            (Some(_), None) => body.warnings.push(failed.map_or_else(
                || notice("rank_deficient", "the nodes do not determine the coefficients"),
                |failed| WarningBody::new("not_over_roll_lengths", format!("no fit over roll lengths: {failed}")),
            )),
            (None, _) => {}
        }
        let whole = writer::whole(&body).ok().and_then(|bytes| String::from_utf8(bytes).ok());
        whole.unwrap_or_else(|| {
            let why = notice("exceeds_double", "figures exceed the range of double precision");
            writer::text_of(&FitFiguresBody { warnings: vec![why], ..FitFiguresBody::default() })
        })
    }
}

/// A standard error of more than so many of the noise means that the nodes do not determine a
/// figure: one of a poor grid has a few.
const UNDETERMINED: f64 = 1e4;

/// Returns the names of the figures that the nodes do not determine; `sigma` is the noise, µm.
fn not_determined(figures: FlankFigures<Figure>, sigma: Option<f64>) -> Vec<&'static str> {
    let is_lost =
        |figure: Figure| figure.std_error.zip(sigma).is_some_and(|(error, sigma)| error > UNDETERMINED * sigma);
    figures.named().into_iter().filter(|(_, figure)| figure.is_some_and(is_lost)).map(|(name, _)| name).collect()
}

fn undetermined(name: &str) -> WarningBody {
    let message = format!("`{name}_um` is omitted, because the nodes do not determine it; measure more of the flank");
    notice("figures_not_determined", &message)
}

/// Returns the ranges of the nodes of a flank.
fn spanned<'a>(flank: &FittedFlank<'a>) -> Spanned<'a> {
    let FittedFlank { gear, side, terms, roll_lengths, z, .. } = *flank;
    Spanned { gear, side, terms, ranges: [roll_lengths, z], helix_reference: flank.references()[1] }
}

/// Returns the noise estimated from the residuals; `None` if the fit is exact.
fn noise(result: &FitResult) -> Option<Noise> {
    let exact = result.warnings.iter().any(|warning| matches!(warning, Warning::ExactFit { .. }));
    let sigma = result.residuals.sigma.filter(|_| !exact)?;
    Some(Noise { sigma, degrees_of_freedom: result.residuals.degrees_of_freedom })
}

/// A figure with and without the suspected nodes.
#[skip_serializing_none]
#[derive(Serialize)]
struct MovedFigure {
    name: String,
    value: f64,
    without: f64,
    /// Half-width of the confidence interval without them.
    half_width: Option<f64>,
    /// True if the suspected nodes change it by more than that.
    exceeds_interval: bool,
}

/// Returns the warning with the effect of the suspected nodes on the figures.
fn outliers_suspected(with: FlankFigures<Figure>, without: FlankFigures<Figure>) -> WarningBody {
    let named = with.zip(without).named().into_iter();
    let figures: Vec<MovedFigure> = named
        .filter_map(|(name, both)| {
            let (Figure { value, .. }, Figure { value: without, inference, .. }) = both?;
            let half_width = inference.map(|one| 0.5 * (one.interval[1] - one.interval[0]));
            let exceeds_interval = half_width.is_some_and(|half| (value - without).abs() > half);
            Some(MovedFigure { name: format!("{name}_um"), value, without, half_width, exceeds_interval })
        })
        .collect();
    let moved = || figures.iter().filter(|one| one.exceeds_interval);
    let said: Vec<String> =
        moved().map(|one| format!("{} {:.2} instead of {:.2}", one.name, one.without, one.value)).collect();
    let message = match said.is_empty() {
        true => "without the nodes that are suspected of gross errors every figure stays within its interval".into(),
        false => format!(
            "nodes are suspected of gross errors; without them figures change by more than their intervals: {}",
            said.join(", ")
        ),
    };
    let names: Vec<&String> = moved().map(|one| &one.name).collect();
    notice("outliers_suspected", &message)
        .with_values(&json!({"figures": figures, "moved": names, "exceeds_interval": !names.is_empty()}))
}

fn notice(code: &str, message: &str) -> WarningBody {
    WarningBody::new(code, message)
}

/// Returns the reason why a model has no figures of second order.
fn not_second_order(spec: &FitSpec) -> Option<&'static str> {
    if spec.select.is_some() {
        return Some("the model was chosen among several; fit the chosen one for its figures");
    }
    match &spec.model {
        Model::Polynomial { degree, terms: Terms::Total | Terms::Tensor, .. } => {
            let [u, v] = match *degree {
                Degree::Both(degree) => [degree; 2],
                Degree::Each(u, v) => [u, v],
            };
            (u < 2 || v < 2).then_some("figures need a polynomial of at least second order along u and v")
        }
        Model::Polynomial { .. } => Some("terms of second order may be missing"),
        Model::BSpline { .. } | Model::Linear => Some("figures need a polynomial of at least second order"),
    }
}

/// Returns the ranges of the counted nodes of a surface along u and v.
fn spans(nodes: &Nodes) -> Option<[(f64, f64); 2]> {
    let span = |places: &mut dyn Iterator<Item = f64>| {
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high > low).then_some((low, high))
    };
    match nodes {
        Nodes::Scattered(nodes) => {
            let there = |k: &usize| !nodes.z()[*k].is_nan() && nodes.weight().is_none_or(|weight| weight[*k] > 0.0);
            let kept: Vec<usize> = (0..nodes.z().len()).filter(there).collect();
            let u = span(&mut kept.iter().map(|k| nodes.u()[*k]))?;
            Some([u, span(&mut kept.iter().map(|k| nodes.v()[*k]))?])
        }
        Nodes::Grid(grid) => {
            let there = |k: &usize| {
                !grid.z()[*k].is_nan()
                    && grid.valid().as_ref().is_none_or(|valid| valid[*k])
                    && grid.weight().is_none_or(|weight| weight[*k] > 0.0)
            };
            let columns = grid.v().len();
            let kept: Vec<usize> = (0..grid.z().len()).filter(there).collect();
            let u = span(&mut kept.iter().map(|k| grid.u()[k / columns]))?;
            Some([u, span(&mut kept.iter().map(|k| grid.v()[k % columns]))?])
        }
        Nodes::Curve(_) | Nodes::Matrix(_) => None,
    }
}
