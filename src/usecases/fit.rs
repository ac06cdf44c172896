//! Further fits of an iteration's nodes: stored, previewed, recomputed with more in the response,
//! replayed.

use super::prelude::*;
use super::prior::{self, Fitted, Gathered};
use crate::{
    api::{
        fits::{
            reader, service,
            spec::include::{self, IncludeName},
        },
        jobs::{
            fits::{self, ReplayBody},
            iteration_requests::Why,
            iterations::IterationFitBody,
        },
    },
    jobs::{FitRecord, Keyed, NewFit, RefitDraft, Stored},
};
use flankfit_engine::estimation::{Plans, spec::Earlier};

/// A fit of stored nodes, computed unless it needs other iterations of the job.
pub enum Refit<T> {
    Made(T, WithPermit<Nodes>),
    Waiting(WithPermit<Nodes>, Box<FitSpec>),
}

/// Reads the request for a further fit, and fits. Processor work.
pub fn refitted(
    text: &[u8],
    nodes: WithPermit<Nodes>,
    on: Option<&OfFlank>,
    plans: &Plans,
) -> Result<(Refit<Computed>, Option<String>), Problem> {
    let (spec, why) = reader::read_refit::<Why>(text)?;
    let refit = if prior::waits(&spec) {
        Refit::Waiting(nodes, Box::new(spec))
    } else {
        Refit::Made(fits::compute_on(&nodes, &spec, plans, on)?, nodes)
    };
    Ok((refit, why.reason.map(String::from)))
}

/// Stores a further fit of an iteration; it is not chosen.
pub async fn add(
    context: Context<'_>,
    (job, number): (Uuid, u32),
    (refit, reason): (Refit<Computed>, Option<String>),
    keyed: Option<Keyed<NewFit>>,
) -> Result<(Arc<NewFit>, Stored), Problem> {
    let computed = match refit {
        Refit::Made(computed, _) => computed,
        Refit::Waiting(nodes, spec) => {
            let measurand = context.jobs.measurand(job, number).await?;
            prior::compute(context, job, Fitted::Stored(number), &measurand, (nodes, *spec)).await?.0
        }
    };
    Ok(context.jobs.add_fit(job, number, RefitDraft { computed, reason }, keyed).await?)
}

/// Reads the request for a preview, and fits. Processor work.
pub fn previewed(text: &[u8], nodes: WithPermit<Nodes>, plans: &Plans) -> Result<Refit<Vec<u8>>, Problem> {
    let (spec, ()) = reader::read_refit(text)?;
    if prior::waits(&spec) {
        return Ok(Refit::Waiting(nodes, Box::new(spec)));
    }
    Ok(Refit::Made(service::fit(&nodes, &spec, plans)?, nodes))
}

/// Returns the JSON text of a preview.
pub async fn preview(
    context: Context<'_>,
    (job, number): (Uuid, u32),
    refit: Refit<Vec<u8>>,
) -> Result<WithPermit<Vec<u8>>, Problem> {
    let (text, nodes) = match refit {
        Refit::Made(text, nodes) => (text, nodes),
        Refit::Waiting(nodes, spec) => {
            let measurand = context.jobs.measurand(job, number).await?;
            let fitted = Fitted::Stored(number);
            prior::compute_by(context, job, fitted, &measurand, (nodes, *spec), service::fit).await?
        }
    };
    Ok(WithPermit::new(text, nodes.into_parts().1))
}

/// Returns the JSON text of a stored fit with additional parts, which are computed again.
pub async fn with_include(
    context: Context<'_>,
    (job, number): (Uuid, u32),
    stored: FitRecord,
    names: Vec<IncludeName>,
) -> Result<Vec<u8>, Problem> {
    let nodes = nodes::stored(context, job, number).await?;
    let gathered = prior::gather_again(context, job, &stored).await?;
    let plans = context.plans.clone();
    let work = move || {
        let result = fits::with_include(&nodes, &stored, earlier(&gathered), include::include(&names), &plans)?;
        Ok(IterationFitBody::stored(&stored, &result).text())
    };
    context.pool.run(work).await?
}

/// Computes a stored fit again and compares the results.
pub async fn replay(context: Context<'_>, (job, number): (Uuid, u32), fit: Uuid) -> Result<ReplayBody, Problem> {
    let stored = context.jobs.fit(job, number, fit).await?;
    let nodes = nodes::stored(context, job, number).await?;
    let gathered = prior::gather_again(context, job, &stored).await?;
    Ok(context.pool.run(move || fits::replay(&nodes, &stored, earlier(&gathered))).await??.into())
}

fn earlier(gathered: &Option<Gathered>) -> Option<Arc<[Earlier]>> {
    gathered.as_ref().map(|gathered| Arc::clone(&gathered.earlier))
}
