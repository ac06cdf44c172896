//! Evaluates the traces of a request, and makes the answer of what was found.

use super::{
    answer::*,
    band::KBandFindingBody,
    design_lines,
    request::{EvaluateBody, EvaluationSettingsBody},
};
use crate::{
    api::{
        built::Built,
        faults::Faults,
        gears::{
            gear::GearBody,
            notice::NoticeBody,
            of_iteration::{ToothOf, refuse_others},
            plausibility::implausible_traces,
            requirements::RequirementsBody,
        },
        json::{value::read_json, writer},
        problem::Problem,
    },
    jobs::Measurand,
};
use flankfit_engine::{
    gear::{
        Gear,
        evaluation::{
            self, Against, Classes, Evaluated, Evaluation, Posted, Spread, Summary, Suspect, Suspects, TraceSurface,
            Twist, Values, settings::Settings, within,
        },
        tolerance::Class,
    },
    numerics::check,
};

/// Evaluates the traces of a request; `own` is the gear of the job and `of` what the iteration that
/// they belong to measured. Where the request has no limits or bands, those that the job requires
/// are taken. Processor work.
pub fn build(
    text: &[u8],
    own: Option<&Gear>,
    of: Option<&Measurand>,
    required: Option<RequirementsBody>,
) -> Result<Built, Problem> {
    let mut body: EvaluateBody = read_json(text)?;
    let posted = body.gear.as_ref().map(|gear| gear.checked("/gear")).transpose().map_err(Problem::invalid)?;
    let Some(gear) = posted.as_ref().or(own) else {
        return Err(Problem::invalid(Faults::one("/gear", "missing")));
    };
    let mut read = body.traces(gear).map_err(Problem::invalid)?;
    if let Some(of) = of {
        let flanks = read.traces.iter().map(|trace| (ToothOf::Named(&trace.tooth), trace.side));
        refuse_others(of, flanks, ["/traces"; 2]).map_err(Problem::invalid)?;
    }
    let notices =
        design_lines::complete(&mut body.evaluation, required.as_ref(), gear, &read.traces, &mut read.designs)
            .map_err(Problem::invalid)?;
    let posted: Vec<Posted<'_>> = read
        .traces
        .iter()
        .zip(&read.designs)
        .map(|(trace, design)| Posted { trace, design: design.as_deref() })
        .collect();
    let settings = body.evaluation.settings_on(gear).map_err(Problem::invalid)?;
    let accept_units = body.evaluation.accept_units == Some(true);
    let (evaluation, implausible) =
        evaluated(gear, &posted, settings, accept_units).map_err(|faults| Problem::invalid(body.placed(&faults)))?;
    let explicit = body.evaluation.explicit(&evaluation);
    let mut answer = EvaluationBody::new(evaluation, explicit).with_designs(read.designs);
    answer.warnings.extend(implausible);
    answer.warnings.extend(notices);
    answer.warnings.extend(body.gear.as_ref().and_then(GearBody::hand_assumed));
    let result = writer::whole(&answer).map_err(Problem::not_finite)?;
    Ok(Built { method: "iso_1328_1".to_owned(), result })
}

/// Evaluates traces; without classes, limits and bands where their unit is implausible and not
/// accepted.
pub fn evaluated(
    gear: &Gear,
    posted: &[Posted<'_>],
    mut settings: Settings,
    accept_units: bool,
) -> Result<(Evaluation, Option<NoticeBody>), check::Faults> {
    let mut evaluation = evaluation::evaluate(gear, posted, &settings)?;
    // a distance from the design says nothing about units
    let about_involute = match settings.against == Against::Design && posted.iter().any(|one| one.design.is_some()) {
        true => Some(evaluation::evaluate(gear, posted, &Settings { against: Against::Involute, ..settings.clone() })?),
        false => None,
    };
    let measured = about_involute.as_ref().unwrap_or(&evaluation);
    let implausible = (!accept_units).then(|| implausible_traces(measured, gear)).flatten();
    if implausible.is_some() {
        (settings.limits, settings.bands) = Default::default();
        evaluation = evaluation::evaluate(gear, posted, &settings)?;
        evaluation.overall = None;
        evaluation.traces.iter_mut().for_each(|trace| trace.classes = None);
    }
    Ok((evaluation, implausible))
}

impl EvaluationBody {
    /// The answer.
    pub fn new(evaluation: Evaluation, settings: EvaluationSettingsBody) -> Self {
        let (class, beyond_classes) = match evaluation.overall {
            Some(Class::Within(class)) => (Some(class), false),
            Some(Class::Beyond) => (None, true),
            None => (None, false),
        };
        EvaluationBody {
            traces: evaluation.traces.into_iter().map(EvaluatedTraceBody::from).collect(),
            means: evaluation.summaries.into_iter().map(MeanBody::from).collect(),
            twists: evaluation.twists.into_iter().map(TwistBody::from).collect(),
            surfaces: evaluation.surfaces.into_iter().map(TraceSurfaceBody::from).collect(),
            class,
            beyond_classes,
            evaluation: settings,
            warnings: evaluation.warnings.iter().map(NoticeBody::from).collect(),
        }
    }

    /// Adds the design lines of the traces; lines of zeros are left out.
    pub fn with_designs(mut self, lines: impl IntoIterator<Item = Option<Vec<f64>>>) -> Self {
        for (trace, line) in self.traces.iter_mut().zip(lines) {
            trace.design_um = line.filter(|line| line.iter().any(|x| *x != 0.0));
        }
        self
    }
}

impl From<Evaluated> for EvaluatedTraceBody {
    fn from(trace: Evaluated) -> Self {
        let (values, limits) = (trace.values, trace.limits);
        let held = |of: fn(&Values) -> f64, limits| values.and_then(|values| within(of(&values), limits));
        EvaluatedTraceBody {
            tooth: trace.tooth,
            flank: trace.side,
            kind: trace.kind,
            // −0 is 0
            slope_um: values.map(|v| v.slope + 0.0),
            slope_std_error_um: values.and_then(|v| v.slope_std_error),
            slope_interval_um: trace.slope.map(|slope| slope.interval),
            slope_conformity: trace.slope.and_then(|slope| slope.conformity).map(Into::into),
            slope_within: held(|values| values.slope, limits.slope),
            form_um: values.map(|v| v.form),
            form_within: held(|values| values.form, limits.form),
            total_um: values.map(|v| v.total),
            total_within: held(|values| values.total, limits.total),
            crowning_um: values.map(|v| v.crowning + 0.0),
            crowning_std_error_um: values.and_then(|v| v.crowning_std_error),
            crowning_interval_um: trace.crowning.map(|crowning| crowning.interval),
            crowning_conformity: trace.crowning.and_then(|crowning| crowning.conformity).map(Into::into),
            tip_relief_um: values.and_then(|v| v.tip_relief),
            range_mm: Some(trace.range),
            mean_line_um: values.map(|v| v.line.map(|height| height + 0.0)),
            mean_parabola_um: values.map(|v| v.parabola.map(|height| height + 0.0)),
            crowning_within: held(|values| values.crowning, limits.crowning),
            design_um: None,
            k_bands: trace.bands.into_iter().map(KBandFindingBody::from).collect(),
            form_plus_material_um: values.map(|v| v.form_plus_material).filter(|raised| *raised > 0.0),
            total_plus_material_um: values.map(|v| v.total_plus_material).filter(|raised| *raised > 0.0),
            class: trace.classes.map(ClassesBody::from),
            samples: SamplesBody {
                posted: trace.samples.posted,
                undefined: trace.samples.undefined,
                used: trace.samples.used,
                undefined_in_range: trace.samples.undefined_in_range,
                excluded: trace.samples.excluded,
            },
            outliers: trace.suspects.map(OutliersBody::from),
        }
    }
}

impl From<Suspects> for OutliersBody {
    fn from(suspects: Suspects) -> Self {
        let place = |place: &Suspect| OutlierPlaceBody {
            from_mm: place.from,
            to_mm: place.to,
            samples: place.samples,
            height_um: place.height,
            burr: place.burr,
        };
        OutliersBody {
            places: suspects.places.iter().map(place).collect(),
            without: suspects.without.map(|values| WithoutOutliersBody {
                slope_um: values.slope + 0.0,
                form_um: values.form,
                total_um: values.total,
                crowning_um: values.crowning + 0.0,
            }),
        }
    }
}

impl From<Classes> for ClassesBody {
    fn from(classes: Classes) -> Self {
        let mut body = ClassesBody::default();
        let each = [
            ("slope", classes.slope, &mut body.slope),
            ("form", classes.form, &mut body.form),
            ("total", classes.total, &mut body.total),
        ];
        for (name, class, place) in each {
            match class {
                Some(Class::Within(class)) => *place = Some(class),
                Some(Class::Beyond) => body.beyond.push(name.to_owned()),
                None => {}
            }
        }
        body
    }
}

impl From<Summary> for MeanBody {
    fn from(summary: Summary) -> Self {
        MeanBody {
            flank: summary.side,
            kind: summary.kind,
            count: summary.count,
            slope_um: summary.slope.into(),
            form_um: summary.form.into(),
            total_um: summary.total.into(),
            crowning_um: summary.crowning.into(),
            tip_relief_um: summary.tip_relief.map(Into::into),
        }
    }
}

impl From<Spread> for SpreadBody {
    fn from(spread: Spread) -> Self {
        let Spread { mean, variation, worst_tooth, worst } = spread;
        SpreadBody { mean, variation, worst, worst_tooth }
    }
}

impl From<TraceSurface> for TraceSurfaceBody {
    fn from(of: TraceSurface) -> Self {
        TraceSurfaceBody {
            tooth: of.tooth,
            flank: of.side,
            traces: of.traces,
            samples: of.samples,
            figures: of.figures.into(),
            roll_length_range_mm: of.roll_lengths,
            z_range_mm: of.z,
            rms_um: of.remainder.rms,
            peak_to_valley_um: of.remainder.peak_to_valley,
        }
    }
}

impl From<Twist> for TwistBody {
    fn from(twist: Twist) -> Self {
        TwistBody {
            tooth: twist.tooth,
            flank: twist.side,
            kind: twist.kind,
            twist_um: twist.twist,
            std_error_um: twist.std_error,
            interval_um: twist.interval,
            sections_mm: twist.sections,
        }
    }
}
