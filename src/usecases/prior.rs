//! The earlier iterations of a job that a fit takes for its prior: found, read and handed to it;
//! and found again for a replay.

use serde::Deserialize;

use super::prelude::*;
use super::{budget::Permit, entered::entered_after, representative};
use crate::{
    api::{
        gears::correction::{applied, predicted},
        jobs::fits,
    },
    jobs::{FitRecord, Measurand, Predecessor, Predecessors, Record, RecordDraft, RepositoryError, Resource, Rounds},
};
use flankfit_engine::estimation::{
    Plans,
    result::{PriorReport, UsedCorrection},
    spec::{Chain, Corrected, Earlier, Prior, Which},
};

/// Iterations of one flank between the first of a chain and the last: of so many the corrections
/// are looked at.
const MOST_BETWEEN: usize = 1000;

/// Earlier data that the fit uses, with permits for its nodes.
pub struct Gathered {
    pub earlier: Arc<[Earlier]>,
    permits: Vec<Permit>,
}

/// A link of the chain before its nodes are read.
struct Link {
    number: u32,
    fit_id: String,
    corrections: Vec<Made>,
}

/// A correction before the change that it predicts is computed.
struct Made {
    /// Its iteration.
    iteration: u32,
    record: Record,
    /// The changes that were entered in place of the proposed ones.
    entered: Option<Vec<f64>>,
}

/// The iteration whose nodes are fitted.
#[derive(Clone, Copy)]
pub enum Fitted<'a> {
    Stored(u32),
    /// About to be stored, with what was entered on the machine before it.
    New(Option<&'a RecordDraft>),
}

impl Fitted<'_> {
    fn number(self) -> Option<u32> {
        match self {
            Fitted::Stored(number) => Some(number),
            Fitted::New(_) => None,
        }
    }
}

/// The chain that a spec asks for, where its iterations have not been looked for.
pub fn asked(spec: &FitSpec) -> Option<&Chain> {
    match &spec.prior {
        Some(Prior::Iterations(chain)) if chain.earlier.is_none() => Some(chain),
        _ => None,
    }
}

/// The iterations that `chain` asks for, before the one that is fitted.
async fn gather(
    context: Context<'_>,
    job: Uuid,
    fitted: Fitted<'_>,
    of: &Measurand,
    chain: &Chain,
) -> Result<Gathered, Problem> {
    let before = fitted.number();
    let (from, most) = match &chain.which {
        Which::Previous => (1, Which::MOST),
        Which::Listed(numbers) => (numbers.first().copied().unwrap_or(1), MOST_BETWEEN),
    };
    let wanted = Predecessors { of: of.clone(), from, before, most };
    let alike = context.jobs.predecessors(job, wanted).await?;
    let chosen: Vec<&Predecessor> = match &chain.which {
        Which::Previous => alike.iter().collect(),
        Which::Listed(numbers) => {
            let mut chosen = Vec::with_capacity(numbers.len());
            for (k, &number) in numbers.iter().enumerate() {
                match alike.iter().find(|one| one.number == number) {
                    Some(found) => chosen.push(found),
                    None => return Err(not_found(context, job, before, of, (k, number)).await?),
                }
            }
            chosen
        }
    };
    if let Some((k, one)) = chosen.iter().enumerate().find(|(_, one)| one.measurand.axes != of.axes) {
        let place = match chain.which {
            Which::Previous => "/prior/iterations".to_owned(),
            Which::Listed(_) => format!("/prior/iterations/{k}"),
        };
        let detail = format!("the axes of iteration {} are not those of these nodes", one.number);
        return Err(Problem::invalid(Faults::one(place, detail)));
    }
    let mut links: Vec<Link> = Vec::with_capacity(chosen.len());
    let rounds = if chain.correction { context.jobs.rounds(job).await? } else { Rounds::default() };
    for (k, one) in alike.iter().enumerate() {
        if chosen.iter().any(|chosen| chosen.number == one.number) {
            links.push(Link { number: one.number, fit_id: one.fit_id.to_string(), corrections: Vec::new() });
        }
        let Some(link) = links.last_mut().filter(|_| chain.correction) else { continue };
        let next = alike.get(k + 1).map_or(fitted, |next| Fitted::Stored(next.number));
        link.corrections.extend(made_between(context, job, &rounds, one.number, next).await?);
    }
    read(context, job, links).await
}

/// Returns the correction between an iteration and the next one of the flank, with what was entered
/// of it: the newer one of that of the iteration and that of the gear.
async fn made_between(
    context: Context<'_>,
    job: Uuid,
    rounds: &Rounds,
    number: u32,
    next: Fitted<'_>,
) -> Result<Option<Made>, Problem> {
    let Some(made) = rounds.made_between(number, next.number()) else { return Ok(None) };
    let (iteration, record) = (made.number, context.jobs.record(job, made.number, made.id).await?);
    if let Fitted::New(Some(draft)) = next
        && let Some(entered) = applied::entered_of(record.id, draft)?
    {
        return Ok(Some(Made { iteration, record, entered: Some(entered) }));
    }
    // what was entered of the gear's correction came with a measurement after it, of any flank
    let later: Vec<u32> = match made.kind {
        RecordKind::GearCorrection => rounds.after(made).iter().map(|one| one.number).collect(),
        _ => next.number().into_iter().collect(),
    };
    let entry = entered_after(context, job, &record, iteration, &later).await?;
    let entered = entry.map(|entry| entry.settings.iter().map(|setting| setting.change).collect());
    Ok(Some(Made { iteration, record, entered }))
}

/// Why an iteration that was asked for is not among the earlier ones of the flank.
async fn not_found(
    context: Context<'_>,
    job: Uuid,
    before: Option<u32>,
    of: &Measurand,
    (k, number): (usize, u32),
) -> Result<Problem, Problem> {
    let detail = match context.jobs.measurand(job, number).await {
        Err(RepositoryError::NotFound(Resource::Iteration)) => format!("the job has no iteration {number}"),
        Err(error) => return Err(error.into()),
        Ok(_) if before.is_some_and(|before| number >= before) => {
            format!("iteration {number} is not earlier than these nodes")
        }
        Ok(other) if !other.is_alike(of) => {
            format!("iteration {number} is of {}, these nodes of {}", other.words(), of.words())
        }
        Ok(_) => format!("more than {MOST_BETWEEN} iterations of the flank lie between {number} and these nodes"),
    };
    Ok(Problem::invalid(Faults::one(format!("/prior/iterations/{k}"), detail)))
}

/// The part of a stored result that names its prior.
#[derive(Deserialize)]
struct StoodOn {
    prior: Option<PriorReport>,
}

/// The iterations that a stored fit stood on; `None` for a fit that stood on none.
pub async fn gather_again(context: Context<'_>, job: Uuid, stored: &FitRecord) -> Result<Option<Gathered>, Problem> {
    if !stored.spec.contains("\"prior\":{\"iterations\":") {
        return Ok(None);
    }
    let result = stored.result.clone();
    let stood = context.pool.run(move || serde_json::from_str::<StoodOn>(&result)).await?.map_err(Problem::internal)?;
    let Some(PriorReport { iterations: Some(numbers), fit_ids: Some(ids), corrections, .. }) = stood.prior else {
        return Err(Problem::internal("the stored result does not name its prior"));
    };
    let mut links: Vec<Link> =
        numbers.into_iter().zip(ids).map(|(number, fit_id)| Link { number, fit_id, corrections: Vec::new() }).collect();
    for UsedCorrection { iteration, record_id, entered } in corrections {
        let record_id = record_id.parse().map_err(Problem::internal)?;
        let record = context.jobs.record(job, iteration, record_id).await?;
        if let Some(link) = links.iter_mut().rfind(|link| link.number <= iteration) {
            link.corrections.push(Made { iteration, record, entered });
        }
    }
    read(context, job, links).await.map(Some)
}

/// Reads the nodes, and what the corrections predicted.
async fn read(context: Context<'_>, job: Uuid, links: Vec<Link>) -> Result<Gathered, Problem> {
    let (mut earlier, mut permits) = (Vec::with_capacity(links.len()), Vec::new());
    for Link { number, fit_id, corrections } in links {
        let (nodes, permit) = nodes::stored(context, job, number).await?.into_parts();
        permits.push(permit);
        let mut corrected = Vec::with_capacity(corrections.len());
        for Made { iteration, record, entered } in corrections {
            // a correction of the gear may be kept with an iteration of another tooth
            let of = if record.draft.kind == RecordKind::GearCorrection { number } else { iteration };
            let measurand = context.jobs.measurand(job, of).await?;
            let (own, permit) = nodes::stored(context, job, of).await?.into_parts();
            permits.push(permit);
            let (record_id, changes) = (record.id.to_string(), entered.clone());
            let work = move || predicted::change(&record, changes.as_deref(), &own, &measurand);
            let change = context.pool.run(work).await??;
            corrected.extend(change.map(|change| Corrected {
                iteration,
                record_id,
                entered,
                change: Arc::new(change),
            }));
        }
        earlier.push(Earlier { number, fit_id, nodes: Arc::new(nodes), corrections: corrected });
    }
    Ok(Gathered { earlier: earlier.into(), permits })
}

/// Whether a spec asks for something of the job that has not been looked for: earlier iterations,
/// or the piece that another fit is.
pub fn waits(spec: &FitSpec) -> bool {
    asked(spec).is_some() || representative::asked(spec).is_some()
}

/// Fits nodes with what their spec asks for of the job, and the figures of the flank that they are
/// said to be on; the nodes come back with the fit.
pub async fn compute(
    context: Context<'_>,
    job: Uuid,
    iteration: Fitted<'_>,
    of: &Measurand,
    fitted: (WithPermit<Nodes>, FitSpec),
) -> Result<(Computed, WithPermit<Nodes>), Problem> {
    let own = context.jobs.known_job(job).await?;
    let on = OfFlank::of(&own, of);
    let work = move |nodes: &Nodes, spec: &FitSpec, plans: &Plans| fits::compute_on(nodes, spec, plans, on.as_ref());
    compute_by(context, job, iteration, of, fitted, work).await
}

/// The same by `work`.
pub async fn compute_by<T: Send + 'static>(
    context: Context<'_>,
    job: Uuid,
    iteration: Fitted<'_>,
    of: &Measurand,
    (nodes, spec): (WithPermit<Nodes>, FitSpec),
    work: impl FnOnce(&Nodes, &FitSpec, &Plans) -> Result<T, Problem> + Send + 'static,
) -> Result<(T, WithPermit<Nodes>), Problem> {
    let by_iteration = representative::asked(&spec).is_some();
    let spec = representative::resolved(context, job, spec).await?;
    let gathered = match asked(&spec) {
        Some(chain) => gather(context, job, iteration, of, chain).await?,
        None => Gathered { earlier: Arc::new([]), permits: Vec::new() },
    };
    let plans = context.plans.clone();
    let work = move || {
        let spec = spec.with_earlier(Arc::clone(&gathered.earlier));
        let computed = work(&nodes, &spec, &plans)?;
        // the nodes of the prior are held until now
        drop(gathered.permits);
        Ok((computed, nodes))
    };
    let made = context.pool.run(work).await?;
    if by_iteration { made.map_err(representative::refused_by_iteration) } else { made }
}
