//! The earlier iterations of a job that a fit takes for its prior: found, read and handed to it;
//! and found again for a replay.

use std::sync::Arc;

use serde::Deserialize;
use uuid::Uuid;

use super::{
    budget::{Permit, WithPermit},
    caller_state::CallerState,
    representative,
    state::AppState,
    stored,
};
use crate::{
    api::{
        faults::Faults,
        fits::reader::prior::MOST_ITERATIONS,
        gears::{
            correction::predicted,
            fit_figures::{self, OfFlank},
        },
        jobs::fits,
        problem::Problem,
    },
    jobs::{Computed, FitRecord, Measurand, Predecessor, Predecessors, Record, RecordKind, RepositoryError, Resource},
};
use flankfit_engine::estimation::{
    FitSpec, Nodes, Plans,
    spec::{Chain, Corrected, Earlier, Prior, Which},
};

/// Iterations of one flank between the first of a chain and the last: of so many the corrections
/// are looked at.
const MOST_BETWEEN: usize = 1000;

/// What the fit stands on, with permits for its nodes.
pub struct Gathered {
    pub earlier: Arc<[Earlier]>,
    permits: Vec<Permit>,
}

/// A link of the chain before its nodes are read.
struct Link {
    number: u32,
    fit_id: String,
    /// The iteration that each correction is kept with, and its record.
    corrections: Vec<(u32, Record)>,
}

/// The chain that a spec asks for, where its iterations have not been looked for.
pub fn asked(spec: &FitSpec) -> Option<&Chain> {
    match &spec.prior {
        Some(Prior::Iterations(chain)) if chain.earlier.is_none() => Some(chain),
        _ => None,
    }
}

/// The iterations that `chain` asks for, before the one numbered `before` (or about to be stored).
async fn gather(
    state: &CallerState,
    job: Uuid,
    before: Option<u32>,
    of: &Measurand,
    chain: &Chain,
) -> Result<Gathered, Problem> {
    let (from, most) = match &chain.which {
        Which::Previous => (1, MOST_ITERATIONS),
        Which::Listed(numbers) => (numbers.first().copied().unwrap_or(1), MOST_BETWEEN),
    };
    let wanted = Predecessors { of: of.clone(), from, before, most };
    let alike = state.jobs.predecessors(job, wanted).await?;
    let chosen: Vec<&Predecessor> = match &chain.which {
        Which::Previous => alike.iter().collect(),
        Which::Listed(numbers) => {
            let mut chosen = Vec::with_capacity(numbers.len());
            for (k, &number) in numbers.iter().enumerate() {
                match alike.iter().find(|one| one.number == number) {
                    Some(found) => chosen.push(found),
                    None => return Err(not_found(state, job, before, of, (k, number)).await?),
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
    for one in &alike {
        if chosen.iter().any(|chosen| chosen.number == one.number) {
            links.push(Link { number: one.number, fit_id: one.fit_id.to_string(), corrections: Vec::new() });
        }
        let Some(link) = links.last_mut().filter(|_| chain.correction) else { continue };
        if let Some(record) = state.jobs.latest_record(job, one.number, RecordKind::Correction).await? {
            link.corrections.push((one.number, record));
        }
    }
    read(state, job, links).await
}

/// Why an iteration that was asked for is not among the earlier ones of the flank.
async fn not_found(
    state: &CallerState,
    job: Uuid,
    before: Option<u32>,
    of: &Measurand,
    (k, number): (usize, u32),
) -> Result<Problem, Problem> {
    let detail = match state.jobs.measurand(job, number).await {
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

/// What a stored answer says that it stood on.
#[derive(Deserialize)]
struct StoodOn {
    prior: Option<StoredPrior>,
}

#[derive(Deserialize)]
struct StoredPrior {
    iterations: Option<Vec<u32>>,
    fit_ids: Option<Vec<String>>,
    corrections: Vec<StoredCorrection>,
}

#[derive(Deserialize)]
struct StoredCorrection {
    iteration: u32,
    record_id: Uuid,
}

/// The iterations that a stored fit stood on; `None` for a fit that stood on none.
pub async fn gather_again(state: &CallerState, job: Uuid, stored: &FitRecord) -> Result<Option<Gathered>, Problem> {
    if !stored.spec.contains("\"prior\":{\"iterations\":") {
        return Ok(None);
    }
    let result = stored.result.clone();
    let stood = state.pool.run(move || serde_json::from_str::<StoodOn>(&result)).await?.map_err(Problem::internal)?;
    let Some(StoredPrior { iterations: Some(numbers), fit_ids: Some(ids), corrections }) = stood.prior else {
        return Err(Problem::internal("the stored answer does not say what it stood on"));
    };
    let mut links: Vec<Link> =
        numbers.into_iter().zip(ids).map(|(number, fit_id)| Link { number, fit_id, corrections: Vec::new() }).collect();
    for StoredCorrection { iteration, record_id } in corrections {
        let record = state.jobs.record(job, iteration, record_id).await?;
        if let Some(link) = links.iter_mut().rfind(|link| link.number <= iteration) {
            link.corrections.push((iteration, record));
        }
    }
    read(state, job, links).await.map(Some)
}

/// Reads the nodes, and what the corrections predicted.
async fn read(state: &CallerState, job: Uuid, links: Vec<Link>) -> Result<Gathered, Problem> {
    let (mut earlier, mut permits) = (Vec::with_capacity(links.len()), Vec::new());
    for Link { number, fit_id, corrections } in links {
        let (nodes, permit) = stored::nodes(state, job, number).await?.into_parts();
        permits.push(permit);
        let mut corrected = Vec::with_capacity(corrections.len());
        for (iteration, record) in corrections {
            let measurand = state.jobs.measurand(job, iteration).await?;
            let (own, permit) = stored::nodes(state, job, iteration).await?.into_parts();
            permits.push(permit);
            let (record_id, change) = (record.id.to_string(), predicted_change(state, record, own, measurand).await?);
            corrected.push(Corrected { iteration, record_id, change: Arc::new(change) });
        }
        earlier.push(Earlier { number, fit_id, nodes: Arc::new(nodes), corrections: corrected });
    }
    Ok(Gathered { earlier: earlier.into(), permits })
}

async fn predicted_change(
    state: &AppState,
    record: Record,
    nodes: Nodes,
    measurand: Measurand,
) -> Result<Nodes, Problem> {
    state.pool.run(move || predicted::change(&record, &nodes, &measurand)).await?
}

/// Whether a spec asks for something of the job that has not been looked for: earlier iterations,
/// or the piece that another fit is.
pub fn waits(spec: &FitSpec) -> bool {
    asked(spec).is_some() || representative::asked(spec).is_some()
}

/// Fits nodes with what their spec asks for of the job, and the figures of the flank that they are
/// told to be on; the nodes come back with the fit.
pub async fn compute(
    state: &CallerState,
    job: Uuid,
    before: Option<u32>,
    of: &Measurand,
    fitted: (WithPermit<Nodes>, FitSpec),
) -> Result<(Computed, WithPermit<Nodes>), Problem> {
    let on = match fit_figures::may_be_told(&fitted.0) {
        true => OfFlank::of(&state.jobs.job(job).await?, of),
        false => None,
    };
    let work = move |nodes: &Nodes, spec: &FitSpec, plans: &Plans| fits::compute_on(nodes, spec, plans, on.as_ref());
    compute_by(state, job, before, of, fitted, work).await
}

/// The same by `work`.
pub async fn compute_by<T: Send + 'static>(
    state: &CallerState,
    job: Uuid,
    before: Option<u32>,
    of: &Measurand,
    (nodes, spec): (WithPermit<Nodes>, FitSpec),
    work: impl FnOnce(&Nodes, &FitSpec, &Plans) -> Result<T, Problem> + Send + 'static,
) -> Result<(T, WithPermit<Nodes>), Problem> {
    let by_iteration = representative::asked(&spec).is_some();
    let spec = representative::resolved(state, job, spec).await?;
    let gathered = match asked(&spec) {
        Some(chain) => gather(state, job, before, of, chain).await?,
        None => Gathered { earlier: Arc::new([]), permits: Vec::new() },
    };
    let plans = state.plans.clone();
    let work = move || {
        let spec = spec.with_earlier(Arc::clone(&gathered.earlier));
        let computed = work(&nodes, &spec, &plans)?;
        // the nodes of the prior are held until now
        drop(gathered.permits);
        Ok((computed, nodes))
    };
    let made = state.pool.run(work).await?;
    if by_iteration { made.map_err(representative::refused_by_iteration) } else { made }
}
