//! Later changes of a stored iteration: the measurand of its nodes, and the decision on the gear.

use super::prelude::*;
use super::prior;
use crate::{
    api::{
        fits::reader,
        gears::{
            correction::chosen::ChosenFigures,
            fit_figures::{FitFiguresBody, MISSING, can_have_figures},
        },
        jobs::{
            acceptance::{self, Kept},
            amendments, fits,
            iteration_requests::IterationPatchBody,
            problem::of_measured,
        },
        json::writer::text_of,
    },
    jobs::{
        AmendmentDraft, Cursor, Decision, DecisionDraft, FitSummary, Iteration, PageRequest, Precondition, RefitDraft,
    },
};

/// Applies a patch of an iteration, all of it or nothing.
pub async fn update(
    context: Context<'_>,
    iteration: Iteration,
    patch: IterationPatchBody,
    precondition: Precondition,
) -> Result<Iteration, Problem> {
    let IterationPatchBody { decision, accept_units, ref reason, .. } = patch;
    let (says_measurand, reason) = (patch.says_measurand(), reason.clone().map(String::from));
    if decision.is_none() && !says_measurand {
        let what = "send a `decision`, or `flank`, `tooth`, `axes` or `accept_units` of the nodes";
        return Err(Problem::invalid(Faults::one("", what)));
    }
    precondition.check(iteration.version)?;
    let (job_id, number) = (iteration.job_id, iteration.number);
    if let Some(decision) = decision.filter(|decision| *decision != Decision::Accepted && !says_measurand) {
        let draft = DecisionDraft { decision, concession: false, reason };
        return Ok(context.jobs.decide(job_id, number, draft, precondition).await?);
    }
    let accepts = decision == Some(Decision::Accepted);
    let job = context.jobs.job(job_id).await?;
    let standing = chosen_fit(context, &iteration).await?;
    let limits = accepts && acceptance::has_limits(&job);
    let mut measurand = iteration.measurand.clone();
    let mut computed = None;
    // the gear was not known when the figures were computed, or they were held against other limits
    let is_outdated = limits && (lacks_figures(&standing) || job.updated_at > standing.event.created_at);
    if says_measurand || is_outdated {
        let nodes = nodes::stored(context, job_id, number).await?;
        let merged = amendments::merged(patch.measurand(), &measurand).map_err(Problem::internal)?;
        measurand = merged.checked(Some(&nodes)).map_err(Problem::invalid)?;
        measurand.accept_units = accept_units.unwrap_or(iteration.measurand.accept_units);
        if let Some(on) = OfFlank::of(&job, &measurand).filter(|_| can_have_figures(&nodes)) {
            if limits {
                acceptance::refuse_unknown(&job, &measurand).map_err(Problem::invalid)?;
            }
            let fit = context.jobs.fit(job_id, number, standing.id).await?;
            let gathered = prior::gather_again(context, job_id, &fit).await?;
            let plans = context.plans.clone();
            let work = move || {
                let earlier = gathered.as_ref().map(|gathered| Arc::clone(&gathered.earlier));
                fits::again(&nodes, &fit, earlier, &plans, &on)
            };
            let again = context.pool.run(work).await??;
            computed = Some(again).filter(|again| again.flank != standing.flank);
        }
    }
    let concession =
        accepts && needs_reason(context, &iteration, &standing, computed.as_ref(), reason.as_deref()).await?;
    let decision = decision.map(|decision| DecisionDraft { decision, concession, reason: reason.clone() });
    if measurand == iteration.measurand && computed.is_none() {
        let Some(draft) = decision else { return Ok(iteration) };
        return Ok(context.jobs.decide(job_id, number, draft, precondition).await?);
    }
    let record = amendments::record(&iteration.measurand, &measurand, "changed", text_of(&patch));
    let draft = AmendmentDraft {
        measurand,
        record: record.map_err(Problem::internal)?,
        refit: computed.map(|computed| RefitDraft { computed, reason: reason.filter(|_| decision.is_none()) }),
        decision,
    };
    // the result holds for the version that was read
    let seen = Precondition::AnyOf(vec![iteration.version]);
    context.jobs.amend(job_id, number, draft, seen).await.map_err(|error| of_measured(error, "/tooth"))
}

/// Returns the nodes of an iteration without those that its chosen fit excludes, and the figures of
/// that fit.
pub async fn counted(
    context: Context<'_>,
    iteration: &Iteration,
    nodes: Nodes,
) -> Result<(Nodes, ChosenFigures), Problem> {
    let FitSummary { id, flank, .. } = chosen_fit(context, iteration).await?;
    let spec = context.jobs.fit(iteration.job_id, iteration.number, id).await?.spec;
    let work = move || {
        let spec = reader::read_stored(&spec).map_err(Problem::internal)?;
        let excluded = |_| Problem::internal("a stored fit excludes nodes that do not exist");
        let nodes = nodes.without(&spec.exclude).map_err(excluded)?;
        let figures = flank.map_or(Ok(FitFiguresBody::default()), |flank| serde_json::from_str(&flank));
        let figures = figures.map_err(Problem::internal)?;
        Ok((nodes, ChosenFigures { figures, level: spec.level, has_prior: spec.prior.is_some() }))
    };
    context.pool.run(work).await?
}

/// Returns the chosen fit of an iteration.
async fn chosen_fit(context: Context<'_>, iteration: &Iteration) -> Result<FitSummary, Problem> {
    let after = Some(Cursor::after_number(u64::from(iteration.number) - 1)).filter(|_| iteration.number > 1);
    let page = context.jobs.iterations(iteration.job_id, PageRequest { limit: 1, after }).await?;
    let found = page.items.into_iter().find(|listed| listed.number == iteration.number);
    found.map(|listed| listed.fit).ok_or_else(|| Problem::internal("an iteration has no chosen fit"))
}

/// Whether a fit has no figures of its flank because data were missing when it was made.
fn lacks_figures(fit: &FitSummary) -> bool {
    let Some(figures) = &fit.flank else { return true };
    MISSING.iter().any(|code| figures.contains(&format!("\"code\":\"{code}\"")))
}

/// Returns whether accepting is a concession; refuses it if it is one and no reason is given.
async fn needs_reason(
    context: Context<'_>,
    iteration: &Iteration,
    standing: &FitSummary,
    computed: Option<&Computed>,
    reason: Option<&str>,
) -> Result<bool, Problem> {
    let (job, number) = (iteration.job_id, iteration.number);
    let (figures, result) = match computed {
        Some(computed) => (computed.flank.clone(), computed.result.text().as_ref().into()),
        None => (standing.flank.clone(), context.jobs.fit(job, number, standing.id).await?.result),
    };
    let evaluation = context.jobs.latest_record(job, number, RecordKind::Evaluation).await?;
    let pitch = context.jobs.latest_record(job, number, RecordKind::Pitch).await?;
    let work = move || {
        let result: Arc<str> = result;
        acceptance::objections(Kept {
            figures: figures.as_deref(),
            result: &result,
            evaluation: evaluation.as_ref().map(|record| &*record.draft.result),
            pitch: pitch.as_ref().map(|record| &*record.draft.result),
        })
    };
    let objections = context.pool.run(work).await?.map_err(Problem::internal)?;
    if !objections.is_empty() && reason.is_none() {
        let detail = format!("{}; accepting it anyway is a concession, which needs a `reason`", objections.join("; "));
        return Err(Problem::invalid(Faults::one("/reason", detail)));
    }
    Ok(!objections.is_empty())
}
