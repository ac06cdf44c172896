//! `/v1/nodes/read`: what a table of nodes or points is proposed to be.

use super::prelude::*;
use crate::{
    api::{
        gears::files::proposal::{self, ProposalBody, TableIncludeName},
        json::{text::ShortText, value},
        tables::{kept, mapping::MappingBody},
    },
    http::layers::{include::TableQuery, multipart::read_any_file},
    usecases::import::FileForm,
};

pub fn group() -> OpenApiRouter<AppState> {
    OpenApiRouter::new().routes(routes!(read_nodes))
}

// Declared for the document.
/// A table, and its mapping.
#[derive(Serialize, ToSchema)]
#[schema(as = TableForm)]
struct TableFormBody {
    /// A table of nodes or points.
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
    /// `application/json`: the mapping. Omitted fields are found from the content.
    mapping: Option<MappingBody>,
}

/// Read a table of nodes
///
/// Separators, decimal sign, character set, header and units are found from the content.
/// `separator`, `decimal`, `header`, `matrix`, `columns` and `layout` of the response form the
/// `mapping` to send with the file to an import; correct it if it is wrong. If an earlier table of
/// the same form and instrument became an iteration, its mapping is proposed (`proposed_from`). A
/// table that cannot be read is refused with one sentence and the first five places. Nothing is
/// stored.
#[utoipa::path(
    post, path = "/v1/nodes/read", operation_id = "read_nodes", tag = "fits",
    params(
        ("include" = Option<Vec<TableIncludeName>>, Query, style = Form, explode = false, description = "Additional \
            parts of the response: `nodes`."),
        ("instrument" = Option<String>, Query, min_length = 1, max_length = 200, description = "Instrument of the \
            measurement, as in an iteration: its stored mapping is proposed. By default that of tables without an \
            instrument.")
    ),
    request_body(
        content(
            (TableFormBody = "multipart/form-data"), (String = "text/csv"), (String = "text/plain"),
            (String = "application/octet-stream")
        ),
        description = "A file of any name and media type, alone or as the part `file` of a form."
    ),
    responses((status = 200, description = "The proposed mapping and a preview.", body = ProposalBody))
)]
async fn read_nodes(
    state: CallerState,
    QueryOf(query): QueryOf<TableQuery>,
    payload: Payload,
) -> Result<Response, Problem> {
    let (with_nodes, instrument) = (!query.names::<TableIncludeName>()?.is_empty(), query.instrument()?);
    let limit = state.settings.body_limit;
    let read = move || {
        let form = read_any_file(payload, limit)?;
        if form.spec.is_some() {
            return Err(Problem::invalid(Faults::one("/spec", "a table uses only a mapping: omit this part")));
        }
        let instrument = instrument.as_ref().map(ShortText::as_str);
        let key = if form.mapping.is_none() { kept::key(&form.file, instrument) } else { None };
        Ok((form, key))
    };
    let (form, key) = state.pool.run(read).await??;
    let kept = match key {
        Some(key) => state.jobs.proposed_mapping(key).await,
        None => None,
    };
    let work = move || {
        let (FileForm { file, mapping, .. }, permit) = form.into_parts();
        // another version may know more words
        let kept = kept.and_then(|text| value::read_json(text.as_bytes()).ok());
        Ok::<_, Problem>(WithPermit::new(proposal::answer(&file, mapping.as_ref(), kept.as_ref(), with_nodes)?, permit))
    };
    Ok(json_held(state.pool.run(work).await??))
}
