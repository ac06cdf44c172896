//! How traces are to be evaluated.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    against,
    band::{self, KBandBody},
};
use crate::api::{
    faults::{Faults, pointer_of},
    gears::{
        design::modification::{self, ModificationBody, ModificationRangeBody},
        gear::GearBody,
        trace::TraceBody,
    },
};
use flankfit_engine::{
    estimation::spec::DEFAULT_LEVEL,
    gear::{
        Gear, Trace,
        evaluation::{
            self, Against, Evaluation, SidedLimits,
            flank_surface::{FigureTerms, Reference},
            settings::{
                DeviationSign, HelixReference, HelixSettings, MeanCurve, Outliers, PlusMaterial, ProfileReference,
                ProfileSettings, Settings, SlopeSign,
            },
        },
        tolerance::Rounding,
        trace::Direction,
    },
    numerics::check,
};

/// Traces to evaluate.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = EvaluateGear)]
pub struct EvaluateBody {
    /// Optional if the traces belong to a job that has it.
    pub gear: Option<GearBody>,
    /// Profiles and helices, each on its own; at least one.
    pub traces: Vec<TraceBody>,
    /// Modifications of the involute, superposed: part of the design line of every trace, in
    /// addition to its own `design_um`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modifications: Vec<ModificationBody>,
    pub modification_range: Option<ModificationRangeBody>,
    pub evaluation: EvaluationSettingsBody,
}

/// Ranges, reference lengths, signs and rules. The response repeats them with every default filled
/// in.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = EvaluationSettings)]
pub struct EvaluationSettingsBody {
    /// Evaluation range of profiles, as diameters. Required with profiles.
    #[schema(min_items = 2, max_items = 2)]
    pub profile_diameter_range_mm: Option<[f64; 2]>,
    /// Diameters between which the tip relief lies. With it profiles have `tip_relief_um`.
    #[schema(min_items = 2, max_items = 2)]
    pub tip_relief_diameter_range_mm: Option<[f64; 2]>,
    /// Evaluation range of helices. Required with helices.
    #[schema(min_items = 2, max_items = 2)]
    pub helix_range_mm: Option<[f64; 2]>,
    /// The roll length that profile slopes are extended to; overrides `profile_reference`.
    pub profile_reference_length_mm: Option<f64>,
    /// The length that helix slopes are extended to; overrides `helix_reference`.
    pub helix_reference_length_mm: Option<f64>,
    /// Length that profile slopes refer to. Default `evaluation_range`.
    pub profile_reference: Option<ProfileReference>,
    /// Default `face_width`.
    pub helix_reference: Option<HelixReference>,
    /// The sign of the returned slopes. Default `din`.
    pub sign: Option<SlopeSign>,
    /// The sign of the posted deviations. By default that of `sign`: `din` for `din`, else
    /// `material`.
    pub deviation_sign: Option<DeviationSign>,
    /// Direction of the posted deviations; results are transverse. Default `transverse`.
    pub direction: Option<Direction>,
    /// Reference of the figures. Default `design` with `modifications` or `design_um`, else
    /// `involute`. With `design` the job's limits of slopes, crownings and twist, which apply to
    /// the flank, are not used.
    pub against: Option<Against>,
    /// Mean curve of the form deviation of profiles. Default `line`.
    pub profile_mean: Option<MeanCurve>,
    /// Mean curve of the form deviation of helices. Default `line`.
    pub helix_mean: Option<MeanCurve>,
    /// Use of material that protrudes outside the evaluation range. Default `ignored`.
    pub profile_plus_material: Option<PlusMaterial>,
    pub helix_plus_material: Option<PlusMaterial>,
    /// Tolerances that decide the class. Default `rounded`.
    pub tolerances: Option<Rounding>,
    /// Use of samples that protrude far from their neighbours, as dust does. Default `keep`.
    pub outliers: Option<Outliers>,
    /// True if all traces of a flank share one zero. Measuring machines zero each profile and each
    /// helix by itself; then the levels of traces mean nothing, and surfaces show only what follows
    /// from slopes and shapes. Set it if the traces are sections of one measurement of the flank.
    /// Default false.
    pub traces_share_zero: Option<bool>,
    /// Confirms that the deviations are in µm although they are far below or above those of any
    /// gear. Otherwise there is a warning `implausible_unit`, and they have no class and are not
    /// compared with limits. Default false.
    pub accept_units: Option<bool>,
    /// Level of confidence intervals, above 0.5 and below 1. Default 0.95.
    #[schema(exclusive_minimum = 0.5, exclusive_maximum = 1)]
    pub level: Option<f64>,
    pub tolerance_limits: Option<SidedLimits>,
    /// Bands that traces must lie in; at most 20, with at most 4,000 points in all.
    #[schema(max_items = 20)]
    pub k_bands: Option<Vec<KBandBody>>,
}

/// Returns the direction and the reference lengths of figures; by default along the normal, over
/// the reference lengths.
pub fn figure_terms(direction: Option<Direction>, reference: Option<Reference>) -> FigureTerms {
    let terms = FigureTerms::default();
    FigureTerms { direction: direction.unwrap_or(terms.direction), reference: reference.unwrap_or(terms.reference) }
}

/// Returns the sign of deviations that goes with a sign of slopes.
fn deviation_sign(slopes: SlopeSign) -> DeviationSign {
    match slopes {
        SlopeSign::Din => DeviationSign::Din,
        SlopeSign::Vdi | SlopeSign::AsGiven => DeviationSign::Material,
    }
}

impl EvaluationSettingsBody {
    /// The same with every default written out, as it is answered.
    pub fn explicit(&self, evaluation: &Evaluation) -> Self {
        let (profile, helix) = (evaluation.profile.is_some(), evaluation.helix.is_some());
        let sign = self.sign.unwrap_or(SlopeSign::Din);
        EvaluationSettingsBody {
            profile_reference_length_mm: evaluation.profile.map(|window| window.reference),
            helix_reference_length_mm: evaluation.helix.map(|window| window.reference),
            sign: Some(sign),
            deviation_sign: Some(self.deviation_sign.unwrap_or(deviation_sign(sign))),
            direction: Some(self.direction.unwrap_or(Direction::Transverse)),
            profile_mean: profile.then(|| self.profile_mean.unwrap_or(MeanCurve::Line)),
            helix_mean: helix.then(|| self.helix_mean.unwrap_or(MeanCurve::Line)),
            profile_plus_material: profile.then(|| self.profile_plus_material.unwrap_or(PlusMaterial::Ignored)),
            helix_plus_material: helix.then(|| self.helix_plus_material.unwrap_or(PlusMaterial::Ignored)),
            tolerances: Some(self.tolerances.unwrap_or(Rounding::Rounded)),
            outliers: Some(self.outliers.unwrap_or(Outliers::Keep)),
            traces_share_zero: Some(self.traces_share_zero()),
            level: Some(self.level.unwrap_or(DEFAULT_LEVEL)),
            ..self.clone()
        }
    }

    /// Refuses limits and bands that are none on any gear.
    fn check(&self, faults: &mut Faults) {
        if let Some(limits) = &self.tolerance_limits {
            faults.append(Faults::of_engine("/evaluation/tolerance_limits", &limits.check()));
        }
        band::check_all(self.k_bands.as_deref().unwrap_or_default(), "/evaluation/k_bands", faults);
    }

    /// The settings, without bands, whose places need the gear.
    pub fn settings(&self) -> Settings {
        let sign = self.sign.unwrap_or(SlopeSign::Din);
        let given = self.deviation_sign.unwrap_or(deviation_sign(sign));
        let profile = self.profile_diameter_range_mm.map(|range| ProfileSettings {
            reference: self.profile_reference.unwrap_or_default(),
            reference_length: self.profile_reference_length_mm,
            mean: self.profile_mean.unwrap_or_default(),
            plus_material: self.profile_plus_material.unwrap_or_default(),
            tip_relief: self.tip_relief_diameter_range_mm,
            ..ProfileSettings::on(range)
        });
        let helix = self.helix_range_mm.map(|range| HelixSettings {
            reference: self.helix_reference.unwrap_or_default(),
            reference_length: self.helix_reference_length_mm,
            mean: self.helix_mean.unwrap_or_default(),
            plus_material: self.helix_plus_material.unwrap_or_default(),
            ..HelixSettings::on(range)
        });
        Settings {
            profile,
            helix,
            given,
            direction: self.direction.unwrap_or(Direction::Transverse),
            against: self.against.unwrap_or(Against::Design),
            sign,
            rounding: self.tolerances.unwrap_or_default(),
            outliers: self.outliers.unwrap_or_default(),
            traces_share_zero: self.traces_share_zero(),
            level: self.level.unwrap_or(DEFAULT_LEVEL),
            limits: self.tolerance_limits.unwrap_or_default(),
            bands: Vec::new(),
        }
    }

    /// The same with the bands on a gear.
    pub fn settings_on(&self, gear: &Gear) -> Result<Settings, Faults> {
        let bands = band::on_all(self.k_bands.as_deref().unwrap_or_default(), gear, "/evaluation/k_bands")?;
        Ok(Settings { bands, ..self.settings() })
    }

    /// Whether all traces count from one zero.
    pub fn traces_share_zero(&self) -> bool {
        self.traces_share_zero.unwrap_or(false)
    }
}

/// Traces read, each with its design line.
pub struct Traces {
    pub traces: Vec<Trace>,
    pub designs: Vec<Option<Vec<f64>>>,
}

impl EvaluateBody {
    /// Faults of the traces by their places in the request, where a profile may be given by
    /// diameters.
    pub fn placed(&self, faults: &check::Faults) -> Faults {
        let by_diameter = |trace: &str| {
            let trace = trace.parse().ok().and_then(|trace: usize| self.traces.get(trace));
            trace.is_some_and(|trace| trace.diameter_mm.is_some())
        };
        Faults::placed(faults, |path| {
            let position = path.strip_prefix("traces[").and_then(|rest| rest.split_once("].roll_length_mm"));
            match position.filter(|(trace, _)| by_diameter(trace)) {
                Some((trace, index)) => format!("/traces/{trace}/diameter_mm{}", pointer_of(index)),
                None => pointer_of(path),
            }
        })
    }

    /// The traces, once their gear is known.
    pub fn traces(&self, gear: &Gear) -> Result<Traces, Faults> {
        let mut faults = Faults::default();
        let read = |(i, trace): (usize, &TraceBody)| trace.read(gear, &format!("/traces/{i}"), &mut faults);
        let traces: Vec<Trace> = self.traces.iter().enumerate().filter_map(read).collect();
        let modifications = modification::read(gear, &self.modifications, self.modification_range)
            .map_err(|more| faults.append(more))
            .unwrap_or_default();
        self.evaluation.check(&mut faults);
        let mut designs: Vec<Option<Vec<f64>>> = self.traces.iter().map(|trace| trace.design_um.clone()).collect();
        faults.into_result(())?;
        let mut faults = Faults::default();
        if let Some(modifications) = &modifications {
            let settings = self.evaluation.settings();
            for (i, (trace, given)) in traces.iter().zip(&mut designs).enumerate() {
                let Some(line) = evaluation::design(gear, modifications, trace, &settings) else {
                    faults.push(against::section(i, trace), against::NO_SECTION);
                    continue;
                };
                match given {
                    // of another length than the trace is a fault of its own
                    Some(given) => given.iter_mut().zip(line).for_each(|(given, more)| *given += more),
                    None => *given = Some(line),
                }
            }
        }
        faults.into_result(Traces { traces, designs })
    }
}
