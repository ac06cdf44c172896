//! `/v1/jobs/{job_id}/import`: an iteration out of a file of a gear tester.

use super::iterations::created;
use super::prelude::*;
use crate::{
    api::{gears::files::spec::ImportSpecBody, tables::mapping::MappingBody},
    http::layers::multipart::read_file,
    usecases::import,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(import_iteration))
}

// Declared for the document.
/// A file and its description.
#[derive(Serialize, ToSchema)]
#[schema(as = ImportForm)]
struct ImportFormBody {
    /// `.mka`, a REXS model with topographies or traces, or a table of nodes or points.
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
    /// `application/json`.
    spec: Option<ImportSpecBody>,
    /// `application/json`: the mapping of a table.
    mapping: Option<MappingBody>,
}

/// Import a measurement file
///
/// Creates an iteration from a file of a gear tester, a table of nodes or points, or a REXS model.
/// The traces of a tooth flank become its nodes (u = roll length in mm, v = z in mm, heights in µm
/// along the normal). Nodes within the evaluation range are fitted by a second-order surface, or by
/// those of its terms that they determine. All traces and pitch tables are evaluated. The
/// evaluations are stored with the iteration, with their data and the digest of the file. For
/// points, and for topographies of a model, the deviations are stored. Nodes of a table are stored
/// in the units of its columns, as a grid if they form one. A file of another gear than the job's
/// is refused.
#[utoipa::path(
    post, path = "/v1/jobs/{job_id}/import", operation_id = "import_iteration", tag = "iterations",
    params(IdempotencyKey),
    request_body(content = ImportFormBody, content_type = "multipart/form-data", description = "The file and its \
        description."),
    responses(
        (status = 201, description = "The iteration. `GET …/records` has the evaluation.", body = NewIterationBody),
        (status = 409, description = "The first request with this idempotency key is still running, or the gear of the \
            job was changed meanwhile.")
    )
)]
async fn import_iteration(PathOf(job): PathOf<Uuid>, post: Post) -> Result<Response, Problem> {
    post.once(move |state, payload, key| async move {
        let limit = state.settings.body_limit;
        let keyed = key.map(|key| key.answered_by(created));
        let (iteration, stored) = import::add(state.context(), job, move || read_file(payload, limit), keyed).await?;
        Ok(created(&iteration, stored))
    })
    .await
}
