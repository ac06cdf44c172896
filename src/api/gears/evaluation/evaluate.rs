//! Evaluates the traces of a request.

use super::{answer::EvaluationBody, design_lines, request::EvaluateBody};
use crate::{
    api::{
        built::Built,
        faults::Faults,
        gears::{
            gear::GearBody,
            of_iteration::{ToothOf, refuse_others},
            plausibility::implausible_traces,
            requirements::RequirementsBody,
        },
        json::{value::read_json, writer},
        problem::Problem,
        warning::WarningBody,
    },
    jobs::Measurand,
};
use flankfit_engine::{
    gear::{
        Gear,
        evaluation::{self, Against, Evaluation, Posted, settings::Settings},
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
        return Err(Problem::invalid(Faults::one("/gear", "required")));
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
) -> Result<(Evaluation, Option<WarningBody>), check::Faults> {
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
        evaluation.without_classes();
    }
    Ok((evaluation, implausible))
}
