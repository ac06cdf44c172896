//! `/v1/simulations`: machines that are corrected in a loop, each run kept as a job where that is
//! asked for.

use super::prelude::*;
use crate::api::simulations::{
    closed_loop::{self, RunDraft, SimulatedRun},
    request::ClosedLoopBody,
    result::ClosedLoopResultBody,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(simulate_closed_loop))
}

/// Simulate corrections of a machine
///
/// A machine with wrong settings makes parts, which are measured; the machine is corrected and
/// makes new parts, with several correction methods. With `store` the run of each method is stored
/// as a job, all of them or none. The same seed gives the same result.
#[utoipa::path(
    post, path = "/v1/simulations/closed-loop", operation_id = "simulate_closed_loop", tag = "simulations",
    params(IdempotencyKey),
    request_body(content = ClosedLoopBody, description = "The machine, the probe and the correction methods; \
        everything has a default."),
    responses(
        (status = 200, description = "Deviations and changes of each round, and the stored jobs.",
            body = ClosedLoopResultBody)
    )
)]
async fn simulate_closed_loop(post: Post) -> Result<Response, Problem> {
    post.once(|state, payload, key| async move {
        let plans = state.plans.clone();
        let simulated = read_json(&state, payload, move |text| closed_loop::simulate(text, &plans)).await?;
        let (mut runs, mut drafts) = (Vec::new(), Vec::new());
        for SimulatedRun { run, draft } in simulated.runs {
            drafts.extend(draft.map(|RunDraft { job, rounds }| (job, rounds)));
            runs.push(run);
        }
        let body = ClosedLoopResultBody { seed: simulated.seed, condition: simulated.condition, runs };
        let answer = move |ids: &Vec<Uuid>, _: Stored| answered(&body, ids);
        if drafts.is_empty() && key.is_none() {
            return Ok(answer(&Vec::new(), Stored { number: 0, version: 1 }));
        }
        let answer = Arc::new(answer);
        let keyed = key.map(|key| {
            let answer = answer.clone();
            key.answered_by(move |ids, stored| answer(ids, stored))
        });
        let (ids, stored) = state.jobs.add_runs(drafts, keyed).await?;
        Ok(answer(&ids, stored))
    })
    .await
}

/// Returns the response: the simulation, with the stored jobs if there are any, one for each
/// method.
fn answered(body: &ClosedLoopResultBody, ids: &[Uuid]) -> Answer {
    let mut body = body.clone();
    for (run, id) in body.runs.iter_mut().zip(ids) {
        run.job_id = Some(*id);
    }
    Answer::ok(text_of(&body).into_bytes())
}
