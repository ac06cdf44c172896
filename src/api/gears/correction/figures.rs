//! Figures of the flanks before a correction, wanted and predicted, against their limits.

use serde::{Deserialize, Serialize};
use serde_json::json;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::warning::WarningBody;
use flankfit_engine::{
    estimation::inference::Conformity,
    gear::{
        Side,
        correction::{
            HeldFigure, Solution,
            figures::{MEAN, moved_by},
        },
        evaluation::flank_surface::FlankFigures,
    },
    words::listed,
};

/// Values of each flank that was measured.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Sided)]
pub struct SidedBody<T> {
    pub left: Option<T>,
    pub right: Option<T>,
}

impl<T> SidedBody<T> {
    pub fn new(of: impl Fn(Side) -> Option<T>) -> Self {
        SidedBody { left: of(Side::Left), right: of(Side::Right) }
    }
}

/// Figures of the second-order surface over the ranges of the machine, slopes over their reference
/// lengths: those of the iteration's chosen fit, for a gear the means over the fits of the teeth.
/// Figures that a fit does not have are computed by least squares over the nodes with a weight
/// above 0; figures that the nodes do not determine are absent.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CorrectionTargetFigures)]
pub struct TargetFiguresBody {
    /// f_Hα: positive where material grows from root to tip.
    pub profile_slope_um: Option<TargetFigureBody>,
    /// f_Hβ, by DIN: positive towards the right hand.
    pub helix_slope_um: Option<TargetFigureBody>,
    /// C_α.
    pub profile_crowning_um: Option<TargetFigureBody>,
    /// C_β.
    pub helix_crowning_um: Option<TargetFigureBody>,
    /// 4 c_uv of the surface, with the sign of f_Hβ.
    pub twist_um: Option<TargetFigureBody>,
}

/// A figure before the correction, its target and its prediction, in µm.
#[skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CorrectionTargetFigure)]
pub struct TargetFigureBody {
    /// As measured.
    pub before: f64,
    /// Figure of the target.
    pub target: f64,
    /// Predicted figure, if the machine responds as the sensitivity says: `before` plus the change
    /// that the settings make, by least squares over the nodes.
    pub predicted: f64,
    /// Standard error of `before` and `predicted`: that of the fit, for a gear from noise and
    /// scatter of the teeth; absent without degrees of freedom.
    pub std_error: Option<f64>,
    /// Limits of the job, `[low, high]`, in the direction of the figures; for slopes also those of
    /// the class. Absent without limits.
    #[schema(min_items = 2, max_items = 2)]
    pub limits: Option<[f64; 2]>,
    /// Conformity with a guard band by the standard error.
    pub conformity_before: Option<Conformity>,
    /// Likewise for the predicted figure.
    pub conformity_predicted: Option<Conformity>,
}

impl TargetFigureBody {
    fn new(figure: &HeldFigure, change: &[f64]) -> Self {
        let (before, predicted) = (figure.measured.value, figure.after(change));
        TargetFigureBody {
            before,
            target: figure.target,
            predicted,
            std_error: figure.measured.std_error,
            limits: figure.limits,
            conformity_before: figure.conformity(before),
            conformity_predicted: figure.conformity(predicted),
        }
    }

    /// Whether the predicted figure lies outside its limits.
    pub fn is_outside(&self) -> bool {
        self.limits.is_some_and(|[low, high]| !(low <= self.predicted && self.predicted <= high))
    }
}

impl SidedBody<TargetFiguresBody> {
    pub fn of(figures: &[HeldFigure], change: &[f64]) -> Self {
        SidedBody::new(|side| {
            let own: Vec<&HeldFigure> = figures.iter().filter(|figure| figure.side == side).collect();
            let named = |name: &str| {
                own.iter().find(|figure| figure.name == name).map(|figure| TargetFigureBody::new(figure, change))
            };
            (!own.is_empty()).then(|| TargetFiguresBody {
                profile_slope_um: named("profile_slope"),
                helix_slope_um: named("helix_slope"),
                profile_crowning_um: named("profile_crowning"),
                helix_crowning_um: named("helix_crowning"),
                twist_um: named("twist"),
            })
        })
    }

    /// Returns the names and predicted figures outside their limits.
    pub fn outside(&self) -> Vec<(&'static str, TargetFigureBody)> {
        let of = |figures: TargetFiguresBody| {
            let named = FlankFigures {
                profile_slope: figures.profile_slope_um,
                helix_slope: figures.helix_slope_um,
                profile_crowning: figures.profile_crowning_um,
                helix_crowning: figures.helix_crowning_um,
                twist: figures.twist_um,
            };
            named.named()
        };
        let all = [self.left, self.right].into_iter().flatten().flat_map(of);
        all.filter_map(|(name, figure)| Some((name, figure.filter(TargetFigureBody::is_outside)?))).collect()
    }
}

/// Returns a figure to the first decimal, without a negative zero.
pub fn tenth(figure: f64) -> String {
    format!("{:.1}", (10.0 * figure).round() / 10.0 + 0.0)
}

/// Returns the symbol of a figure.
pub fn symbol(name: &str) -> &'static str {
    match name {
        "profile_slope" => "f_Hα",
        "helix_slope" => "f_Hβ",
        "profile_crowning" => "C_α",
        "helix_crowning" => "C_β",
        _ => "S",
    }
}

/// Warns of crownings or a twist that are removed although nobody said that the unmodified flank is
/// the target: the drawing may require them.
pub fn removes_crowning(figures: &[HeldFigure]) -> Option<WarningBody> {
    let shaped = |figure: &&HeldFigure| {
        let is_shape = !matches!(figure.name, "profile_slope" | "helix_slope" | MEAN);
        is_shape && figure.measured.interval.is_some_and(|[low, high]| low > 0.0 || high < 0.0)
    };
    let found: Vec<&HeldFigure> = figures.iter().filter(shaped).collect();
    if found.is_empty() {
        return None;
    }
    let values =
        listed(found.iter().map(|figure| format!("{} {} µm", symbol(figure.name), tenth(figure.measured.value))));
    let message = format!(
        "{values}: the target of the correction is the unmodified flank, without these figures. If the drawing \
         requires them, add a `design` or limits of these figures to the job's requirements; if not, send `target`: \
         \"nominal\""
    );
    Some(WarningBody::new("target_removes_crowning", message).with_values(&json!({"figures": names_of(&found)})))
}

/// Warns of figures that remain outside their limits, with the reason of each.
pub fn outside_limits(figures: &[HeldFigure], solution: &Solution) -> Option<WarningBody> {
    let change: Vec<f64> = solution.settings.iter().map(|setting| setting.change).collect();
    let found: Vec<&HeldFigure> = figures.iter().filter(|figure| figure.is_outside(figure.after(&change))).collect();
    if found.is_empty() {
        return None;
    }
    let each = found.iter().map(|figure| {
        let [low, high] = figure.limits.unwrap_or_default();
        let after = figure.after(&change);
        format!(
            "{} {} µm of {low} to {high} µm: {}",
            symbol(figure.name),
            tenth(after),
            stopped_by(figure, figures, solution)
        )
    });
    let message = format!("still outside the limits after the correction: {}", each.collect::<Vec<_>>().join("; "));
    Some(WarningBody::new("predicted_outside_limits", message).with_values(&json!({"figures": names_of(&found)})))
}

/// Returns the names of figures in the interface.
fn names_of(figures: &[&HeldFigure]) -> Vec<String> {
    figures.iter().map(|figure| format!("{}_um", figure.name)).collect()
}

fn stopped_by(figure: &HeldFigure, all: &[HeldFigure], solution: &Solution) -> String {
    if figure.is_outside(figure.target) {
        return format!("the target has {} µm", tenth(figure.target));
    }
    let moving: Vec<usize> =
        (0..solution.settings.len()).filter(|&j| moved_by(all, j).any(|moved| moved == figure)).collect();
    let quoted = |which: &dyn Fn(usize) -> bool| {
        let names: Vec<String> =
            moving.iter().filter(|j| which(**j)).map(|&j| format!("`{}`", solution.settings[j].name)).collect();
        (!names.is_empty()).then(|| listed(names).to_string())
    };
    let settings = &solution.settings;
    let unrounded: Vec<f64> = settings.iter().map(|setting| setting.unrounded.unwrap_or(setting.change)).collect();
    if let Some(names) = quoted(&|j| settings[j].unrounded.is_some())
        && !figure.is_outside(figure.after(&unrounded))
    {
        return format!("{names} rounded to its increment");
    }
    let at_limit = quoted(&|j| settings[j].limited);
    match (at_limit, quoted(&|j| settings[j].fixed), quoted(&|j| settings[j].undetermined)) {
        (Some(names), ..) => format!("{names} at its limit"),
        (None, Some(names), _) => format!("{names} fixed"),
        (None, None, Some(names)) => format!("{names} not determined by this measurement"),
        (None, None, None) if moving.is_empty() => "no setting affects it".to_owned(),
        (None, None, None) => "the settings that affect it are damped or have other effects as well".to_owned(),
    }
}
