//! Specification of a correction, checked once.

use std::collections::BTreeSet;

use super::{
    damping::{DEFAULT_RESPONSE_UNCERTAINTY, Damping},
    figures::HeldFigure,
    needed::DEFAULT_KEEP_WITHIN,
    scatter::Scatter,
};
use flankfit_estimation::spec::{Include, Scaling};
use flankfit_numerics::{
    check::{Faults, not_positive, per_node},
    words::{Shown, counted, entries},
};

/// Most settings of a machine.
pub const MOST_SETTINGS: usize = 64;
/// Most entries of a sensitivity matrix.
pub const MOST_ENTRIES: usize = 2_000_000;

/// One setting of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Name of the setting, unique in its list.
    pub name: String,
    /// The unit that changes are counted in, as text.
    pub unit: String,
    /// Least change allowed (usually negative), in that unit.
    pub min: Option<f64>,
    /// Greatest change allowed.
    pub max: Option<f64>,
    /// True if it stays as it is.
    pub fixed: bool,
    /// Step of the control: changes are multiples of it.
    pub increment: Option<f64>,
    /// Whether its effect is a twist, which only nodes off a cross show.
    pub twists: bool,
    /// Whether the nodes do not show its effect, so that it is undetermined.
    pub hidden: bool,
}

impl Setting {
    /// A setting that may go anywhere.
    pub fn free(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Setting {
            name: name.into(),
            unit: unit.into(),
            min: None,
            max: None,
            fixed: false,
            increment: None,
            twists: false,
            hidden: false,
        }
    }
}

impl Setting {
    /// Least and greatest multiple of the increment within the limits; `None` without an increment.
    pub(super) fn steps(&self) -> Option<[f64; 2]> {
        // a limit that is a multiple but for rounding is one
        const ROUNDING: f64 = 1e-9;
        let increment = self.increment?;
        let least = self.min.map_or(f64::NEG_INFINITY, |min| (min / increment - ROUNDING).ceil());
        let most = self.max.map_or(f64::INFINITY, |max| (max / increment + ROUNDING).floor());
        Some([least, most])
    }

    /// `count` increments, with the digits that the increment has where it is a simple fraction.
    pub(super) fn multiple(count: f64, increment: f64) -> f64 {
        let parts = (1.0 / increment).round();
        // + 0.0: no negative zero
        if (increment * parts - 1.0).abs() < 1e-12 { count / parts + 0.0 } else { count * increment + 0.0 }
    }
}

/// How errors of a sensitivity matrix hang together, for the standard errors of the changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum ResponseErrors {
    /// Each entry has one of its own: they average out over many nodes.
    #[default]
    Independent,
    /// Each setting has one, as a scale that is wrong: its whole column is too large or too small
    /// by the same share.
    PerSetting,
}

/// Choice among the settings that may be changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum SettingsUsed {
    /// From plain least squares of all settings on, they are left alone one after the other, the
    /// cheapest first, while every figure that all of them bring or leave within its limits stays
    /// there (with the guard band of a conformity), and where leaving one alone adds less than 9σ²
    /// to the weighted sum of squares, or every figure that it moves stays within `keep_within` of
    /// its limits. Those that remain are solved again.
    Needed,
    /// All of them.
    #[default]
    All,
}

/// A correction as it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrectionSpec {
    /// d, µm for each node; NaN where it is undefined: such a node takes no part and is predicted
    /// nowhere.
    pub deviation: Vec<f64>,
    /// ≥ 0 for each node; 0 leaves a node out.
    pub weight: Option<Vec<f64>>,
    /// t, µm for each node; 0 by default.
    pub target: Option<Vec<f64>>,
    /// J row by row, `sensitivity[k * settings.len() + j]`: µm at node k for one unit of setting j.
    pub sensitivity: Vec<f64>,
    /// Settings of the machine, a column of J each.
    pub settings: Vec<Setting>,
    /// How λ* is chosen.
    pub damping: Damping,
    /// Scaling of the columns of J.
    pub scaling: Scaling,
    /// Standard deviation of a measured deviation of weight 1, µm; by default that of the
    /// residuals.
    pub noise_sigma: Option<f64>,
    /// r of the bias bounds, in the scaled columns (µm of a whole column). By default, under
    /// [`Damping::Uncertainty`], the norm of the changes that the limits allow where every setting
    /// has both, else √n τ, what the deviations speak for
    /// ([`flankfit_estimation::spec::ExpectedSize`]); under [`Damping::Given`] that of any fit, the
    /// norm of the least-squares estimate.
    pub coefficient_norm_limit: Option<f64>,
    /// η, standard uncertainty of an entry of J relative to the entry.
    pub response_uncertainty: f64,
    /// How errors of J belong together.
    pub response_errors: ResponseErrors,
    /// Whether the deviations have a datum, so that their mean says something. Where they have
    /// none, as traces and flanks laid into the nominal one, what all nodes have in common is left
    /// aside, and settings that change all nodes nearly alike are undetermined.
    pub absolute: bool,
    /// Without a datum: the trace that each node belongs to, where every trace has a zero of its
    /// own. What the nodes of a trace have in common is left aside then.
    pub traces: Option<Vec<usize>>,
    /// Whether the zeros of `traces` are those of whole flanks.
    pub flank_zeros: bool,
    /// Errors of the deviations that are means over teeth.
    pub scatter: Scatter,
    /// Which settings are changed.
    pub used: SettingsUsed,
    /// With [`SettingsUsed::Needed`]: the share of the limits about their middle within which a
    /// figure needs no correction, 0 to 1.
    pub keep_within: f64,
    /// Figures of the flanks that the nodes lie on, of which [`SettingsUsed::Needed`] keeps those
    /// with limits within them.
    pub figures: Vec<HeldFigure>,
    /// Parts of the fit's result in addition to the default.
    pub include: Include,
}

impl CorrectionSpec {
    /// The defaults for deviations and a sensitivity matrix.
    pub fn new(deviation: Vec<f64>, sensitivity: Vec<f64>, settings: Vec<Setting>) -> Self {
        CorrectionSpec {
            deviation,
            weight: None,
            target: None,
            sensitivity,
            settings,
            damping: Damping::default(),
            scaling: Scaling::UnitLength,
            noise_sigma: None,
            coefficient_norm_limit: None,
            response_uncertainty: DEFAULT_RESPONSE_UNCERTAINTY,
            response_errors: ResponseErrors::default(),
            absolute: true,
            traces: None,
            flank_zeros: false,
            scatter: Scatter::default(),
            used: SettingsUsed::default(),
            keep_within: DEFAULT_KEEP_WITHIN,
            figures: Vec::new(),
            include: Include::default(),
        }
    }
}

/// A correction that can be computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    pub(super) asked: CorrectionSpec,
    /// The nodes that take part, ascending.
    pub(super) counted: Vec<usize>,
    /// J less the means of its columns (over each trace), where deviations have no datum.
    pub(super) centred: Option<Vec<f64>>,
    /// Mean of d − t (over the trace of each node), where deviations have no datum; NaN of a trace
    /// that takes no part.
    pub(super) levels: Option<Vec<f64>>,
    /// Settings that may be changed, ascending.
    pub(super) open: Vec<usize>,
    /// Settings that are not fixed, but that the deviations say nothing about.
    pub(super) undetermined: Vec<usize>,
    /// Those of them that change all nodes (of a trace) nearly alike.
    pub(super) alike: Vec<usize>,
}

impl Correction {
    /// Checks everything. The limits of setting j are at `limits[j]`.
    pub fn new(asked: CorrectionSpec) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        check_settings(&asked.settings, &mut faults);
        let (rows, columns) = (asked.deviation.len(), asked.settings.len());
        if columns == 0 || columns > MOST_SETTINGS || rows == 0 {
            if rows == 0 {
                faults.push("deviation_um", "there are no nodes");
            }
            return Err(faults);
        }
        if asked.sensitivity.len() != rows * columns || asked.sensitivity.len() > MOST_ENTRIES {
            let (given, wanted) = (entries(asked.sensitivity.len()), rows * columns);
            let (nodes, settings) = (counted(rows, "node", "nodes"), counted(columns, "setting", "settings"));
            faults.push(
                "sensitivity.matrix",
                format_args!("{given}; {nodes} and {settings} need {wanted} (at most {MOST_ENTRIES})"),
            );
        }
        for (at, value) in asked.sensitivity.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
            let path = format_args!("sensitivity.matrix[{}][{}]", at / columns, at % columns);
            faults.push(path, format_args!("{value} is not a finite number"));
        }
        for (index, _) in asked.deviation.iter().enumerate().filter(|(_, d)| d.is_infinite()) {
            let message = "the deviation is infinite; an undefined one is null";
            faults.push(format_args!("deviation_um[{index}]"), message);
        }
        check_lists(&asked, rows, &mut faults);
        if asked.traces.is_some() && asked.absolute {
            let message = "traces with their own zeros have no common one: omit it, or `trace`";
            faults.push("absolute", message);
        }
        for (path, value) in
            [("noise_sigma_um", asked.noise_sigma), ("coefficient_norm_limit", asked.coefficient_norm_limit)]
        {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                faults.push(path, not_positive(value));
            }
        }
        for (path, share) in [("response_uncertainty", asked.response_uncertainty), ("keep_within", asked.keep_within)]
        {
            if !(0.0..=1.0).contains(&share) {
                faults.push(path, format_args!("{} is not a share between 0 and 1", Shown(share)));
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let defined: Vec<usize> = (0..rows).filter(|&k| !asked.deviation[k].is_nan()).collect();
        let weighs = |k: &usize| asked.weight.as_ref().is_none_or(|w| w[*k] > 0.0);
        let counted_nodes: Vec<usize> = defined.iter().copied().filter(weighs).collect();
        let open: Vec<usize> = (0..columns).filter(|&j| !asked.settings[j].fixed).collect();
        if open.is_empty() {
            return Err(Faults::one("limits", "every setting is fixed: there is nothing to correct"));
        }
        let mut plain = Correction {
            asked,
            counted: counted_nodes,
            centred: None,
            levels: None,
            open,
            undetermined: Vec::new(),
            alike: Vec::new(),
        };
        if !plain.counted.is_empty() {
            (plain.open, plain.undetermined) = plain.open.iter().copied().partition(|&j| plain.has_effect(j));
        }
        if plain.open.is_empty() {
            let message = "no setting that may be changed has an effect at the defined nodes";
            return Err(Faults::one("sensitivity.settings", message));
        }
        if plain.counted.len() < plain.open.len() + lost(&plain.asked, &plain.counted) {
            return Err(plain.too_few(defined.len()));
        }
        if plain.asked.absolute { Ok(plain) } else { plain.without_datum() }
    }

    /// Says that so many defined nodes do not determine the settings, at the place that can be
    /// changed: what leaves too few nodes, or asks too much of those that there are.
    fn too_few(&self, defined: usize) -> Faults {
        let lost = lost(&self.asked, &self.counted);
        let (path, left) = match defined {
            0 => ("deviation_um", "defined"),
            there if there >= self.open.len() + lost => ("weight", "with a weight above 0"),
            _ => ("sensitivity.settings", "defined"),
        };
        let traces = match &self.asked.traces {
            Some(_) => format!(" of {} with a zero each", counted(lost, "trace", "traces")),
            None => String::new(),
        };
        let settings = counted(self.open.len(), "setting", "settings");
        let nodes = counted(self.counted.len(), "node", "nodes");
        Faults::one(path, format_args!("{settings} cannot be determined from {nodes} {left}{traces}"))
    }

    /// Returns the specification.
    pub fn spec(&self) -> &CorrectionSpec {
        &self.asked
    }

    /// The nodes that take part, ascending.
    pub fn counted(&self) -> &[usize] {
        &self.counted
    }

    /// Whether setting j has an effect of its own at any node that takes part.
    pub(super) fn has_effect(&self, j: usize) -> bool {
        let columns = self.asked.settings.len();
        !self.asked.settings[j].hidden && self.counted.iter().any(|&k| self.asked.sensitivity[k * columns + j] != 0.0)
    }

    pub(super) fn target(&self, k: usize) -> f64 {
        self.asked.target.as_ref().map_or(0.0, |target| target[k])
    }

    pub(super) fn weight(&self, k: usize) -> f64 {
        self.asked.weight.as_ref().map_or(1.0, |weight| weight[k])
    }

    /// d + JΔ − t at a node, less what all have in common where they have no datum.
    pub(super) fn left_at(&self, k: usize, change: &[f64]) -> f64 {
        let moved: f64 = self.row(k).iter().zip(change).map(|(j, c)| j * c).sum();
        self.asked.deviation[k] + moved - self.target(k) - self.level(k)
    }

    /// Row k of J as given, of which errors are shares.
    pub(super) fn given_row(&self, k: usize) -> &[f64] {
        let columns = self.asked.settings.len();
        &self.asked.sensitivity[k * columns..(k + 1) * columns]
    }

    /// Row k of J, less the means of the columns where deviations have no datum.
    pub(super) fn row(&self, k: usize) -> &[f64] {
        let columns = self.asked.settings.len();
        &self.centred.as_ref().unwrap_or(&self.asked.sensitivity)[k * columns..(k + 1) * columns]
    }
}

fn check_settings(settings: &[Setting], faults: &mut Faults) {
    if settings.is_empty() || settings.len() > MOST_SETTINGS {
        let given = counted(settings.len(), "setting", "settings");
        faults.push("sensitivity.settings", format_args!("{given}; a correction has 1 to {MOST_SETTINGS}"));
    }
    for (index, setting) in settings.iter().enumerate().take(MOST_SETTINGS) {
        let path = format_args!("sensitivity.settings[{index}]");
        if setting.name.trim().is_empty() {
            faults.push(path, "a setting needs a name");
        } else if settings[..index].iter().any(|other| other.name == setting.name) {
            faults.push(path, format_args!("`{}` occurs twice", setting.name));
        }
        faults.append(limit_faults(setting).within(&format!("limits[{index}]")));
    }
}

/// Checks the limits of a setting.
fn limit_faults(setting: &Setting) -> Faults {
    let mut faults = Faults::default();
    let Setting { min, max, fixed, increment, .. } = setting;
    let ends = [("min", min), ("max", max), ("increment", increment)];
    for (end, _) in ends.iter().filter(|(_, limit)| limit.is_some_and(|limit| !limit.is_finite())) {
        faults.push(end, "the number is not finite; omit it for no limit");
    }
    if *fixed {
        for (end, _) in ends.iter().filter(|(_, limit)| limit.is_some()) {
            faults.push(end, "a fixed setting has no limits and no increment");
        }
        return faults;
    }
    if let (Some(min), Some(max)) = (*min, *max)
        && min > max
    {
        let [min, max] = [min, max].map(Shown);
        faults.push("min", format_args!("the least change {min} is above the greatest, {max}"));
        return faults;
    }
    let Some(increment) = increment.filter(|increment| increment.is_finite()) else { return faults };
    if !(increment > 0.0) {
        faults.push("increment", format_args!("{} is not a step above 0", Shown(increment)));
    } else if let Some([least, most]) = setting.steps()
        && least > most
    {
        faults.push("increment", format_args!("no multiple of {} lies within the limits", Shown(increment)));
    }
    faults
}

/// Lists with an entry for each of so many nodes.
fn check_lists(asked: &CorrectionSpec, nodes: usize, faults: &mut Faults) {
    let count = |given: Option<usize>, path: &str, faults: &mut Faults| {
        if let Some(given) = given.filter(|given| *given != nodes) {
            faults.push(path, per_node(given, nodes));
        }
    };
    count(asked.target.as_ref().map(Vec::len), "target.deviation_um", faults);
    for (index, target) in asked.target.iter().flatten().enumerate().filter(|(_, x)| !x.is_finite()) {
        let path = format_args!("target.deviation_um[{index}]");
        faults.push(path, format_args!("{target} is not a finite number"));
    }
    count(asked.weight.as_ref().map(Vec::len), "weight", faults);
    let usable = |weight: f64| weight.is_finite() && weight >= 0.0;
    for (index, weight) in asked.weight.iter().flatten().enumerate().filter(|(_, w)| !usable(**w)) {
        let message = format_args!("{weight} is not a finite weight of at least 0");
        faults.push(format_args!("weight[{index}]"), message);
    }
    count(asked.traces.as_ref().map(Vec::len), "trace", faults);
    for column in &asked.scatter.columns {
        count(Some(column.len()), "deviation_um", faults);
    }
}

/// Means that are taken off the nodes `counted`.
pub(super) fn lost(asked: &CorrectionSpec, counted: &[usize]) -> usize {
    match &asked.traces {
        _ if asked.absolute => 0,
        Some(traces) => counted.iter().map(|&k| traces[k]).collect::<BTreeSet<usize>>().len(),
        None => 1,
    }
}
