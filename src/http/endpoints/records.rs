//! `…/iterations/{number}/records`: other data stored with an iteration than its fits, such as
//! curves and surfaces.

use axum::{
    RequestExt,
    extract::{FromRequest, Request},
};

use super::prelude::*;
use crate::{
    api::{
        built::Built,
        gears::{
            correction::{include::CorrectionInclude, result::CorrectionResultBody},
            quality_data::{self, Kept},
        },
        jobs::records::{self, RecordSummaryBody, Shown},
    },
    http::layers::{
        accept::{chosen, preference},
        idempotency::REPLAYED,
        include::IncludeQuery,
    },
    jobs::{Job, Measurand, Record, RecordDraft},
};
use flankfit_engine::estimation::Plans;

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(list_iteration_records)).routes(routes!(get_iteration_record))
}

/// Data that a record may use in addition to its request.
pub struct RecordContext {
    pub job: Job,
    /// Nodes of the iteration.
    pub nodes: WithPermit<Nodes>,
    pub measurand: Measurand,
    pub plans: Plans,
}

impl RecordContext {
    /// A record that refers to the gear of the job keeps it, since the job's may be changed.
    pub fn gear_record(&self, kind: RecordKind, text: &[u8], built: Built) -> Result<RecordDraft, Problem> {
        records::of_gear(&self.job, kind, text, built)
    }
}

/// A record to be kept, and the parts of it that are returned; by default all.
pub struct NewRecord {
    pub draft: RecordDraft,
    pub shown: Option<Shown>,
}

impl From<RecordDraft> for NewRecord {
    fn from(draft: RecordDraft) -> Self {
        NewRecord { draft, shown: None }
    }
}

/// A request for a record of an iteration.
pub struct RecordRequest {
    pub job: Uuid,
    pub number: u32,
    post: Post,
}

impl FromRequest<AppState> for RecordRequest {
    type Rejection = Problem;

    async fn from_request(mut request: Request, state: &AppState) -> Result<Self, Problem> {
        let PathOf((job, number)) = request.extract_parts_with_state(state).await?;
        Ok(RecordRequest { job, number, post: request.extract_with_state(state).await? })
    }
}

impl RecordRequest {
    /// Computes the record of the iteration's nodes on the pool, within the memory budget, stores
    /// it with the iteration and returns it.
    pub async fn keep(
        self,
        build: impl FnOnce(&[u8], &RecordContext, Room) -> Result<NewRecord, Problem> + Send + 'static,
    ) -> Result<Response, Problem> {
        let context = async |state: CallerState, job, number| {
            let nodes = nodes::stored(state.context(), job, number).await?;
            let measurand = state.jobs.measurand(job, number).await?;
            Ok(RecordContext { job: state.jobs.job(job).await?, nodes, measurand, plans: state.plans.clone() })
        };
        self.keep_of(context, build).await
    }

    /// The same, with the data that `context` reads.
    pub async fn keep_of<C: Send + 'static, F: Future<Output = Result<C, Problem>>>(
        self,
        context: impl FnOnce(CallerState, Uuid, u32) -> F,
        build: impl FnOnce(&[u8], &C, Room) -> Result<NewRecord, Problem> + Send + 'static,
    ) -> Result<Response, Problem> {
        let RecordRequest { job, number, post } = self;
        let context = async move |state: CallerState, job| Ok((number, context(state, job, number).await?));
        JobRecordRequest { job, post }.keep_of(context, build).await
    }
}

/// A request for a record of a job, which is kept with one of its iterations.
pub struct JobRecordRequest {
    job: Uuid,
    post: Post,
}

impl FromRequest<AppState> for JobRecordRequest {
    type Rejection = Problem;

    async fn from_request(mut request: Request, state: &AppState) -> Result<Self, Problem> {
        let PathOf(job) = request.extract_parts_with_state(state).await?;
        Ok(JobRecordRequest { job, post: request.extract_with_state(state).await? })
    }
}

impl JobRecordRequest {
    /// Makes the record of what `context` reads, with the iteration that it names, as
    /// [`RecordRequest::keep_of`] does.
    pub async fn keep_of<C: Send + 'static, F: Future<Output = Result<(u32, C), Problem>>>(
        self,
        context: impl FnOnce(CallerState, Uuid) -> F,
        build: impl FnOnce(&[u8], &C, Room) -> Result<NewRecord, Problem> + Send + 'static,
    ) -> Result<Response, Problem> {
        let JobRecordRequest { job, post } = self;
        post.once(move |state, payload, key| async move {
            let (number, context) = context(state.clone(), job).await?;
            let iteration = format!("/v1/jobs/{job}/iterations/{number}");
            let limit = state.settings.body_limit;
            let mut permit = state.budget.permit();
            let made = move || {
                let text = payload.into_json(limit)?;
                let made = build(&text, &context, &mut |bytes| permit.grow_with(text.permit(), bytes))?;
                Ok::<_, Problem>((made, permit))
            };
            let (NewRecord { draft, shown }, _held) = state.pool.run(made).await??;
            let answer =
                move |record: &Record, _: Stored| created(&iteration, record, records::record(record, shown.as_ref()));
            let keyed = key.map(|key| key.answered_by(answer.clone()));
            let (record, stored): (Arc<Record>, Stored) = state.jobs.add_record(job, number, draft, keyed).await?;
            Ok(answer(&record, stored))
        })
        .await
    }
}

impl RecordRequest {
    /// The same, answered in a form that was asked for. Under the key the record is kept as it is.
    pub async fn keep_as(
        self,
        format: Format,
        build: impl FnOnce(&[u8], &RecordContext, Room) -> Result<NewRecord, Problem> + Send + 'static,
    ) -> Result<Response, Problem> {
        let (state, job, number) = (self.post.state.clone(), self.job, self.number);
        let mut kept = self.keep(build).await?;
        chosen(kept.headers_mut());
        if format != Format::Dfq {
            return Ok(kept);
        }
        let place = kept.headers().get(header::LOCATION).and_then(|place| place.to_str().ok());
        let id = place.and_then(|place| place.rsplit('/').next()?.parse().ok());
        let id = id.ok_or_else(|| Problem::internal("a stored record has no location"))?;
        let record = state.jobs.record(job, number, id).await?;
        let mut response = as_quality_data(&state, job, number, record).await?;
        *response.status_mut() = kept.status();
        for name in [header::LOCATION, REPLAYED.clone()] {
            if let Some(value) = kept.headers_mut().remove(&name) {
                response.headers_mut().insert(name, value);
            }
        }
        Ok(response)
    }
}

/// A record as quality data.
async fn as_quality_data(state: &CallerState, job: Uuid, number: u32, record: Record) -> Result<Response, Problem> {
    let details = state.jobs.iteration(job, number).await?.details;
    let kept = Kept { record, job: state.jobs.job(job).await?, number, details };
    Ok(Format::Dfq.response(state.pool.run(move || quality_data::of_record(&kept)).await??))
}

fn created(iteration: &str, record: &Record, body: Vec<u8>) -> Answer {
    Answer::created(format!("{iteration}/records/{}", record.id), etag(1), body)
}

/// List the records of an iteration
///
/// Records are everything stored with an iteration except its fits. They come oldest first in
/// pages, without requests and results.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/records", operation_id = "list_iteration_records",
    tag = "iterations",
    params(PageQuery),
    responses((status = 200, description = "A page of records.", body = PageBody<RecordSummaryBody>))
)]
async fn list_iteration_records(
    state: CallerState,
    PathOf((job, number)): PathOf<(Uuid, u32)>,
    QueryOf(query): QueryOf<PageQuery>,
) -> Result<axum::Json<PageBody<RecordSummaryBody>>, Problem> {
    let page = state.jobs.records(job, number, query.check(List::Records)?).await?;
    Ok(axum::Json(PageBody::new(page, List::Records)))
}

/// Get a record of an iteration
///
/// Returns request and result. The result is the text of the original response. For an evaluation
/// or for pitches, `Accept: application/x-q-das-dfq` returns a file for statistical process
/// control, with the job's current part number and machine.
#[utoipa::path(
    get, path = "/v1/jobs/{job_id}/iterations/{number}/records/{record_id}", operation_id = "get_iteration_record",
    tag = "iterations",
    params(
        ("include" = Option<Vec<StoredIncludeName>>, Query, style = Form, explode = false, description = "For a \
            correction, additional parts of the response: names separated by commas.")
    ),
    responses(
        (status = 200, description = "The record. Quality data, available for evaluations and pitches, have a \
            characteristic for each figure, in µm.",
                content((RecordBody = "application/json"), (String = "application/x-q-das-dfq"))),
        (status = 422, description = "`include` has an unknown name.")
    )
)]
async fn get_iteration_record(
    state: CallerState,
    PathOf((job, number, id)): PathOf<(Uuid, u32, Uuid)>,
    QueryOf(query): QueryOf<IncludeQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = Format::negotiated(&headers, Format::Dfq, "Records")?;
    let names: Vec<StoredIncludeName> = query.names()?;
    let mut record = state.jobs.record(job, number, id).await?;
    let kind = record.draft.kind;
    match format {
        Format::Dfq if quality_data::is_quality_data(kind) => {
            return as_quality_data(&state, job, number, record).await;
        }
        // what has no such form is given in another that is taken too
        Format::Dfq if preference(&headers, "application/json").quality <= 0.0 => {
            return Err(quality_data::not_written(kind));
        }
        _ => {}
    }
    if matches!(record.draft.kind, RecordKind::Correction | RecordKind::GearCorrection) {
        let reduced = CorrectionInclude::of_stored(&names).of_result(CorrectionResultBody::of(&record)?);
        record.draft.result = String::from_utf8_lossy(&reduced.text()?).into();
    }
    let mut response = Format::Json.response(records::record(&record, None));
    // it is kept as it is
    set_etag(response.headers_mut(), 1);
    Ok(response)
}
