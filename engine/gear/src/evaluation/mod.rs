//! Evaluation of measured traces by ISO 1328-1:2013: slope, form, total deviation and crowning of
//! every trace, means and variations over the teeth, twist, pitch, run-out, and the class that each
//! value reaches; in addition the second-order surface of a whole flank.
//!
//! Deviations are µm along the base tangent of the transverse plane (asked in
//! [`crate::trace::Direction`], answered so). Surfaces are fits of [`flankfit_estimation`].
//! Conventions of sign stand in [`settings`].

mod against;
pub mod band;
mod banded;
mod classes;
mod contradiction;
mod coverage;
mod design;
pub mod flank_surface;
mod flank_traces;
mod gap;
mod limits;
mod mean_curve;
mod missing;
mod noise;
mod outliers;
pub mod pitch;
pub mod pitch_limits;
pub mod runout;
mod samples;
pub mod settings;
mod single;
mod spacing;
mod subject;
pub mod summary;
mod suspects;
pub mod tooth_shift;
mod trace_surface;
mod values;
pub mod warning;

pub use against::Against;
pub use classes::Classes;
use classes::Classified;
pub use design::design;
pub use flank_traces::{FlankTraces, flank_traces};
pub use limits::{Inference, SidedLimits, ToleranceLimits, TraceLimits, within};
pub use outliers::THRESHOLD as OUTLIER_THRESHOLD;
pub use samples::Samples;
use settings::{Outliers, Settings, Window};
use single::Outcome;
pub use spacing::{HOLE_DISTANCES, LEAST_COVERED, LONGEST_DISTANCE};
use subject::Subject;
pub use summary::{Spread, Summary, Twist};
pub use trace_surface::{Levelled, OwnZeros, TraceFigures, TraceSurface, figures_of_traces};
pub use values::{Assessable, EDGE, FEWEST_SAMPLES, Suspect, Suspects, Values, WithoutSuspects};
pub use warning::Warning;

pub use super::tooth::Position;
use super::{
    Gear, Kind, Side, Trace,
    data::MOST_LENGTH,
    tolerance::{Class, OutOfScope, Tolerances},
    trace::MOST_DEVIATION,
};
use flankfit_estimation::inference::Conformity;
use flankfit_numerics::{
    cancel,
    check::{Faults, deviation_exceeds, length_exceeds, per_position},
    words::Shown,
};

/// The most samples of all traces together.
pub const MOST_SAMPLES: usize = 20_000_000;

/// A trace and, where the flank is modified by design, its design line: µm per sample in the sign
/// and direction of the deviations.
#[derive(Clone, Copy, Debug)]
pub struct Posted<'a> {
    /// The trace as measured.
    pub trace: &'a Trace,
    /// Design line; `None` for an unmodified flank.
    pub design: Option<&'a [f64]>,
}

/// Evaluated trace.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = EvaluatedTrace)
)]
pub struct Evaluated {
    /// Name of the tooth, as posted with the trace.
    pub tooth: String,
    /// Flank of the tooth.
    pub flank: Side,
    /// Profile or helix.
    pub kind: Kind,
    /// Position of the trace on the flank.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub position: Position,
    /// Place of the section: z of a profile, diameter of a helix, mm, if known.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub section: Option<f64>,
    /// Evaluation range: roll lengths of a profile, z of a helix.
    pub range_mm: [f64; 2],
    /// Numbers of samples.
    pub samples: Samples,
    /// Results; `None` if the trace cannot be evaluated, and a warning says why.
    #[cfg_attr(feature = "contract", serde(flatten), schema(inline))]
    pub values: Option<Values>,
    /// Classes by ISO 1328-1:2013. Absent if the standard has none, or if samples do not reach both
    /// ends of the evaluation range. Over a hole, a stretch without samples of more than 1/20 of
    /// the range (and of 2.5 usual distances), form and total have none, and the slope has one if
    /// two standard errors up and down have the same.
    #[cfg_attr(feature = "contract", serde(rename = "class"))]
    pub classes: Option<Classes>,
    /// Limits that the results were compared with.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub limits: TraceLimits,
    /// Confidence interval of the true slope at `level`, `[low, high]`, for the noise that its
    /// standard error covers (docs/explanation/intervals.md).
    pub slope_interval_um: Option<[f64; 2]>,
    /// Conformity of the slope, if it has limits (`tolerance_limits`) and an interval, and the
    /// samples reach both ends of the range.
    pub slope_conformity: Option<Conformity>,
    /// True if the slope lies within its limits (`tolerance_limits`); present if it has limits and
    /// the samples reach both ends of the range.
    pub slope_within: Option<bool>,
    /// The same for the form deviation; absent over a hole.
    pub form_within: Option<bool>,
    /// The same for the total deviation; absent over a hole.
    pub total_within: Option<bool>,
    /// Confidence interval of the crowning, as that of the slope.
    pub crowning_interval_um: Option<[f64; 2]>,
    /// Conformity of the crowning, as that of the slope.
    pub crowning_conformity: Option<Conformity>,
    /// True if the crowning lies within its limits, as for the slope.
    pub crowning_within: Option<bool>,
    /// Design line of the trace: µm for each sample, in the sign and the direction of its
    /// deviations. Absent if it is 0 everywhere.
    pub design_um: Option<Vec<f64>>,
    /// Bands that apply to the trace (`k_bands`), with its position in them.
    #[cfg_attr(feature = "contract", serde(rename = "k_bands", default, skip_serializing_if = "Vec::is_empty"))]
    pub bands: Vec<band::BandPosition>,
    /// Samples that are far from their neighbours, as with dust; absent if there are none.
    #[cfg_attr(feature = "contract", serde(rename = "outliers"))]
    pub suspects: Option<Suspects>,
}

/// Evaluated traces.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Evaluation {
    /// One per trace, in the order in which they were posted.
    pub traces: Vec<Evaluated>,
    /// Settings of profiles; `None` without profiles.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub profile: Option<Window>,
    /// Settings of helices; `None` without helices.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub helix: Option<Window>,
    /// Results over the teeth, by kind and flank.
    #[cfg_attr(feature = "contract", serde(rename = "means"))]
    pub summaries: Vec<Summary>,
    /// Twists of teeth with helices near root and tip or with profiles at both ends.
    pub twists: Vec<Twist>,
    /// Second-order surfaces of the tooth flanks with two traces or more whose sections are known.
    pub surfaces: Vec<TraceSurface>,
    /// The coarsest class of all traces, 1 to 11; absent if there is none.
    pub class: Option<u8>,
    /// True if a trace exceeds even class 11.
    pub coarser_than_11: bool,
    /// Warnings.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub warnings: Vec<Warning>,
}

impl Evaluation {
    /// Removes all classes of traces.
    pub fn without_classes(&mut self) {
        (self.class, self.coarser_than_11) = (None, false);
        self.traces.iter_mut().for_each(|trace| trace.classes = None);
    }
}

/// Evaluates traces. A trace that is sound but cannot be evaluated has no values and a warning; the
/// others are evaluated.
///
/// ```
/// use flankfit_gear::{
///     Gear, GearData, Kind, Side, Trace,
///     evaluation::{Posted, evaluate, settings::{HelixSettings, Settings}},
/// };
///
/// // A helix that leans by 4 µm over its evaluation range, half of the face width: f_Hβ over the
/// // whole face is 8 µm, and nothing is left about the line.
/// let gear = Gear::new(GearData { face_width: Some(20.0), ..GearData::spur(52, 1.0) })?;
/// let at: Vec<f64> = (0..=100).map(|k| 5.0 + 0.1 * f64::from(k)).collect();
/// let deviation = at.iter().map(|z| 0.4 * (z - 10.0)).collect();
/// let (tooth, side, kind) = ("1".to_owned(), Side::Left, Kind::Helix);
/// let trace = Trace { tooth, side, kind, at, section: None, deviation };
/// let settings = Settings { helix: Some(HelixSettings::on([5.0, 15.0])), ..Settings::default() };
/// let evaluation = evaluate(&gear, &[Posted { trace: &trace, design: None }], &settings)?;
/// let values = evaluation.traces[0].values.unwrap();
/// assert!((values.slope_um.abs() - 8.0).abs() < 1e-9 && values.form_um < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn evaluate(gear: &Gear, posted: &[Posted], settings: &Settings) -> Result<Evaluation, Faults> {
    check(posted)?;
    let [profile, helix] = windows(gear, posted, settings).map_err(|found| found.within("evaluation"))?;
    let tolerances = Tolerances::new(gear);
    checked(settings, &tolerances, helix.is_some()).map_err(|found| found.within("evaluation"))?;
    let mut warnings = Vec::new();
    if let Err(out) = &tolerances {
        warnings.push(Warning::OutsideTheStandard(out.clone()));
    } else if helix.is_some() && gear.data().face_width.is_none() {
        warnings.push(Warning::NoFaceWidth);
    }
    let foreign = [(Kind::Profile, profile.as_ref()), (Kind::Helix, helix.as_ref())]
        .map(|(kind, window)| window.and_then(|window| foreign_reference(gear, kind, window)));
    warnings.extend(foreign.iter().flatten().cloned());
    warnings.extend(profile.as_ref().and_then(|window| near_base_circle(gear, window)));
    let mut subjects = Vec::with_capacity(posted.len());
    for (number, Posted { trace, design }) in posted.iter().enumerate() {
        let window = match trace.kind {
            Kind::Profile => &profile,
            Kind::Helix => &helix,
        };
        let Some(window) = window else { continue };
        subjects.push(Subject { gear, trace, design: *design, settings, window, number });
    }
    let burrs = suspects::burrs(&subjects);
    let mut traces = Vec::with_capacity(posted.len());
    for (subject, burrs) in subjects.into_iter().zip(burrs) {
        cancel::checkpoint();
        let (trace, window) = (subject.trace, subject.window);
        let Outcome { samples, values, assessable, suspects } = subject.evaluate(burrs, &mut warnings);
        let of_class = tolerances.as_ref().ok().filter(|_| foreign[usize::from(trace.kind == Kind::Helix)].is_none());
        let classes = match (of_class, &values) {
            (Some(tolerances), Some(values)) => {
                let rounding = settings.rounding;
                let found = Classified { tolerances, kind: trace.kind, rounding, values }.classes(assessable);
                warnings.extend(found.open.map(|open| subject.warning(open)));
                found.classes
            }
            _ => None,
        };
        let limits = subject.limits(assessable, of_class);
        let [slope, crowning] = values.map_or([None; 2], |values| subject.inferences(&values));
        let compared = |one: Option<Inference>, limits: Option<[f64; 2]>| Some(one?.about.conformity(limits?));
        let held = |of: fn(&Values) -> f64, limits| values.and_then(|values| within(of(&values), limits));
        traces.push(Evaluated {
            tooth: trace.tooth.clone(),
            flank: trace.side,
            kind: trace.kind,
            position: Position::of(&trace.tooth),
            section: trace.section,
            range_mm: [window.low, window.high],
            samples,
            classes,
            limits,
            slope_interval_um: slope.map(|slope| slope.interval),
            slope_conformity: compared(slope, limits.slope),
            slope_within: held(|values| values.slope_um, limits.slope),
            form_within: held(|values| values.form_um, limits.form),
            total_within: held(|values| values.total_um, limits.total),
            crowning_interval_um: crowning.map(|crowning| crowning.interval),
            crowning_conformity: compared(crowning, limits.crowning),
            crowning_within: held(|values| values.crowning_um, limits.crowning),
            design_um: None,
            values,
            bands: banded::all(&subject, suspects.as_ref()),
            suspects,
        });
    }
    let summaries = summary::summaries(&traces);
    let twists = summary::twists(&traces, settings);
    let cleaned = match settings.outliers {
        Outliers::Keep => None,
        Outliers::Exclude => Some(without_suspects(posted, &traces)),
    };
    let each: Vec<Posted> = match &cleaned {
        Some(cleaned) => posted
            .iter()
            .zip(cleaned)
            .map(|(p, trace)| Posted { trace: trace.as_ref().unwrap_or(p.trace), ..*p })
            .collect(),
        None => posted.to_vec(),
    };
    let windows = [profile.as_ref(), helix.as_ref()];
    let slopes = trace_surface::SlopeLimits::new(windows, tolerances.as_ref().ok(), &foreign, settings.rounding);
    let (surfaces, more) = trace_surface::surfaces(gear, &each, settings, &slopes);
    let new = |one: &Warning| !warnings.iter().any(|other| (other.code(), other.path()) == (one.code(), one.path()));
    let more: Vec<Warning> = more.into_iter().filter(new).collect();
    warnings.extend(more);
    let overall = super::tolerance::overall(traces.iter().filter_map(|t| t.classes.as_ref()?.coarsest()));
    let (class, coarser_than_11) = (overall.and_then(Class::number), overall == Some(Class::Beyond));
    Ok(Evaluation { traces, profile, helix, summaries, twists, surfaces, class, coarser_than_11, warnings })
}

/// Refuses levels and limits that there are not.
fn checked(settings: &Settings, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if !(settings.level > 0.5 && settings.level < 1.0) {
        faults
            .push("level", format_args!("{} is not a level: it must be above 0.5 and below 1", Shown(settings.level)));
    }
    faults.append(settings.limits.check_on(tolerances, helix).within("tolerance_limits"));
    faults.into_result(())
}

/// Slopes over a length that the gear has not got are extrapolated: tolerances say nothing about
/// them.
fn foreign_reference(gear: &Gear, kind: Kind, window: &Window) -> Option<Warning> {
    let longest = match kind {
        Kind::Profile => gear.roll_length(2.0 * gear.tip_radius().max(gear.root_radius()))?,
        Kind::Helix => gear.data().face_width?.max(window.length()),
    };
    let reference = window.reference;
    let foreign = reference > longest * (1.0 + 1e-9);
    foreign.then_some(Warning::ForeignReferenceLength { kind, reference_mm: reference, longest_mm: longest })
}

/// The traces with suspects undefined; `None` for those without any.
fn without_suspects(posted: &[Posted], evaluated: &[Evaluated]) -> Vec<Option<Trace>> {
    let each = posted.iter().zip(evaluated);
    each.map(|(posted, evaluated)| {
        let places = &evaluated.suspects.as_ref()?.places;
        let mut trace = posted.trace.clone();
        for (at, deviation) in trace.at.iter().zip(&mut trace.deviation) {
            if places.iter().any(|place| (place.from_mm..=place.to_mm).contains(at)) {
                *deviation = f64::NAN;
            }
        }
        Some(trace)
    })
    .collect()
}

/// The evaluation range begins where the roll length hardly depends on the diameter any more.
fn near_base_circle(gear: &Gear, window: &Window) -> Option<Warning> {
    let roll = window.low / gear.base_radius();
    (roll < NEAR_BASE_ROLL).then_some(Warning::NearBaseCircle { roll_deg: roll.to_degrees() })
}

/// Roll angle below which a range is close to the base circle, rad: 5°, where an error of diameter
/// is eleven times as large in roll length.
pub const NEAR_BASE_ROLL: f64 = 0.087_266_462_599_716_48;

/// Returns the windows of profiles and helices, where there are any.
fn windows(gear: &Gear, posted: &[Posted], settings: &Settings) -> Result<[Option<Window>; 2], Faults> {
    let first = |kind| posted.iter().position(|posted| posted.trace.kind == kind);
    let mut faults = Faults::default();
    let mut window = |kind, made: Option<Result<Window, Faults>>| match (first(kind), made) {
        (_, Some(Ok(window))) => Some(window),
        (_, Some(Err(more))) => {
            faults.append(more);
            None
        }
        (Some(i), None) => {
            let path = match kind {
                Kind::Profile => "profile_diameter_range_mm",
                Kind::Helix => "helix_range_mm",
            };
            faults.push(path, format_args!("trace {i} needs an evaluation range, and none is given"));
            None
        }
        (None, None) => None,
    };
    let asked = settings.profile.as_ref().filter(|_| first(Kind::Profile).is_some());
    let made = asked.map(|asked| Window::of_profile(gear, asked));
    let profile = window(Kind::Profile, made);
    let asked = settings.helix.as_ref().filter(|_| first(Kind::Helix).is_some());
    let made = asked.map(|asked| Window::of_helix(gear, asked));
    let helix = window(Kind::Helix, made);
    faults.into_result([profile, helix])
}

fn check(posted: &[Posted]) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if posted.is_empty() {
        faults.push("traces", "there are no traces");
    }
    let mut samples = 0;
    for (i, Posted { trace, design }) in posted.iter().enumerate() {
        cancel::checkpoint();
        let positions = trace.at.len();
        samples += positions;
        let lengths = [("deviation_um", Some(trace.deviation.len())), ("design_um", design.map(<[f64]>::len))];
        for (name, length) in lengths {
            if let Some(given) = length.filter(|&length| length != positions) {
                faults.push(format_args!("traces[{i}].{name}"), per_position(given, positions));
            }
        }
        let places = match trace.kind {
            Kind::Profile => "roll_length_mm",
            Kind::Helix => "z_mm",
        };
        for (k, at) in trace.at.iter().enumerate() {
            if !(at.abs() <= MOST_LENGTH) {
                faults.push(format_args!("traces[{i}].{places}[{k}]"), length_exceeds(*at, MOST_LENGTH));
            }
        }
        for (k, deviation) in trace.deviation.iter().enumerate() {
            if deviation.abs() > MOST_DEVIATION {
                let message = deviation_exceeds(*deviation, MOST_DEVIATION);
                faults.push(format_args!("traces[{i}].deviation_um[{k}]"), message);
            }
        }
        for (k, line) in design.iter().flat_map(|design| design.iter()).enumerate() {
            if !(line.abs() <= MOST_DEVIATION) {
                faults.push(format_args!("traces[{i}].design_um[{k}]"), deviation_exceeds(*line, MOST_DEVIATION));
            }
        }
    }
    if samples > MOST_SAMPLES {
        faults.push("traces", format_args!("{samples} samples; at most {MOST_SAMPLES} are evaluated at once"));
    }
    faults.into_result(())
}
