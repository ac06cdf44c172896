//! Measured nodes, fitted and stored as an iteration of their job.

use super::prelude::*;
use super::{
    entered,
    prior::{self, Fitted},
};
use crate::{
    api::{
        gears::correction::applied::AppliedRequestBody,
        jobs::{
            amendments, fits,
            iteration_requests::{Measurement, MeasurementDetailsBody},
            problem::of_measured,
        },
        json::text::ShortText,
        tables::kept::SentMapping,
    },
    jobs::{IterationDraft, Job, KeptMapping, Keyed, Measurand, NewIteration, Stored},
};
use flankfit_engine::estimation::Plans;

/// A measurement that has been read, and fitted unless the fit needs other iterations.
pub struct Measured {
    fit: Fit,
    /// Changes that were entered on the machine before the measurement.
    applied: Option<AppliedRequestBody>,
    mapping: Option<KeptMapping>,
}

enum Fit {
    Made(Box<IterationDraft>),
    /// The fit needs earlier iterations or another fit of the job.
    Waiting(Box<Waiting>),
}

struct Waiting {
    nodes: Nodes,
    spec: FitSpec,
    measurand: Measurand,
    details: MeasurementDetailsBody,
}

/// Checks a measurement of a job and fits its nodes, unless the fit needs other iterations.
/// CPU-bound.
pub fn measured(
    nodes: Nodes,
    spec: FitSpec,
    mut measurement: Measurement,
    mapping: Option<SentMapping>,
    job: &Job,
    plans: &Plans,
) -> Result<Measured, Problem> {
    let applied = measurement.applied.take();
    let mapping = mapping.map(|sent| sent.kept(measurement.details.instrument.as_ref().map(ShortText::as_str)));
    let Measurement { measurand, accept_units, details, applied: _ } = measurement;
    let mut measurand = measurand.checked(Some(&nodes)).map_err(Problem::invalid)?;
    measurand.accept_units = accept_units.unwrap_or(false);
    let fit = if prior::waits(&spec) {
        Fit::Waiting(Box::new(Waiting { nodes, spec, measurand, details }))
    } else {
        let computed = fits::compute_on(&nodes, &spec, plans, OfFlank::of(job, &measurand).as_ref())?;
        Fit::Made(Box::new(draft(nodes, measurand, details, computed)?))
    };
    Ok(Measured { fit, applied, mapping })
}

/// Stores a measurement as the next iteration of its job.
pub async fn add(
    context: Context<'_>,
    job: Uuid,
    measured: WithPermit<Measured>,
    keyed: Option<Keyed<NewIteration>>,
) -> Result<(Arc<NewIteration>, Stored), Problem> {
    // the permit for the nodes is held until they are stored
    let (Measured { fit, applied, mapping }, permit) = measured.into_parts();
    let measurand = match &fit {
        Fit::Made(draft) => &draft.measurand,
        Fit::Waiting(waiting) => &waiting.measurand,
    };
    let entered = match applied {
        Some(applied) => Some(entered::before_next(context, job, measurand, &applied).await?),
        None => None,
    };
    let (mut draft, _permit) = match fit {
        Fit::Made(draft) => (*draft, permit),
        Fit::Waiting(waiting) => {
            let Waiting { nodes, spec, measurand, details } = *waiting;
            let nodes = WithPermit::new(nodes, permit);
            let (computed, nodes) =
                prior::compute(context, job, Fitted::New(entered.as_ref()), &measurand, (nodes, spec)).await?;
            let (nodes, permit) = nodes.into_parts();
            (draft(nodes, measurand, details, computed)?, permit)
        }
    };
    draft.records.extend(entered);
    store(context, job, draft, mapping, keyed, "/tooth").await
}

/// Stores an iteration, and the mapping of the table that it came from; `place` is the pointer of
/// what says the tooth.
pub(super) async fn store(
    context: Context<'_>,
    job: Uuid,
    draft: IterationDraft,
    mapping: Option<KeptMapping>,
    keyed: Option<Keyed<NewIteration>>,
    place: &'static str,
) -> Result<(Arc<NewIteration>, Stored), Problem> {
    let added = context.jobs.add_iteration(job, draft, keyed).await.map_err(|error| of_measured(error, place))?;
    if let Some(mapping) = mapping {
        context.jobs.keep_mapping(mapping).await;
    }
    Ok(added)
}

fn draft(
    nodes: Nodes,
    measurand: Measurand,
    details: MeasurementDetailsBody,
    computed: Computed,
) -> Result<IterationDraft, Problem> {
    let mut records = Vec::new();
    if measurand.accept_units {
        let before = Measurand { accept_units: false, ..measurand.clone() };
        let request = r#"{"accept_units":true}"#.to_owned();
        records.push(amendments::record(&before, &measurand, "posted", request).map_err(Problem::internal)?);
    }
    Ok(IterationDraft {
        measurand,
        nodes: Arc::new(nodes),
        computed,
        details: details.into(),
        records,
        expected_gear: None,
    })
}
