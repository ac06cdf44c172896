//! The OpenAPI document: what the handlers declare, completed with what holds for every one of
//! them.
//!
//! Handlers declare what is theirs. Here every operation gains the refusals that the layers below
//! it give (unreadable body, API key, timeouts, a full queue, …), the header `x-request-id`, and
//! its examples; and optional properties lose the `null` that the generator writes for them, since
//! absence is never written as `null`. What holds for the schemas, whoever declares them, is
//! `api::contract`.

mod forms;
pub mod progress;
mod refusals;
pub mod scopes;

use std::sync::OnceLock;

use serde::Serialize;
use serde_json::ser::{PrettyFormatter, Serializer};

use utoipa::{
    Modify, OpenApi,
    openapi::{
        Header, HeaderBuilder, ObjectBuilder, OpenApi as Document, RefOr, Required,
        example::ExampleBuilder,
        path::{Operation, Parameter, ParameterBuilder, ParameterIn, PathItem},
        schema::Type,
        security::{ApiKey, ApiKeyValue, HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme},
        server::ServerBuilder,
    },
    schema,
};

use super::router;
use crate::api::{
    contract::{
        self,
        nullable::{not_nullable, without_null},
    },
    examples::REQUEST_EXAMPLES,
    gears::{
        correction::{csv::OutsideLimitsName, include::StoredIncludeName},
        files::proposal::TableIncludeName,
    },
    problem::{Problem, ProblemError},
    progress::ProgressBody,
};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "flankfit",
        description = "Robust parametric estimation of tooth-flank surfaces: coefficients with standard errors and \
                       bias bounds, eigen diagnostics, and the choices of λ* by all criteria.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(Problem, ProblemError, ProgressBody, StoredIncludeName, OutsideLimitsName, TableIncludeName)),
    tags(
        (name = "jobs", description = "Gear jobs, their corrections, events, archives and purges."),
        (name = "iterations", description = "Iterations of a job: nodes, fits, λ* choices, decisions, records, and \
            the trace of all of these."),
        (name = "streams", description = "Nodes that arrive block by block: an estimate after every block, finally an \
            iteration."),
        (name = "gears", description = "Gear calculators: geometry, tolerances, flanks, deviations and evaluation; \
            nothing is stored."),
        (name = "simulations", description = "Simulated machines and probes, stored as jobs on request."),
        (name = "fits", description = "Fits of nodes; nothing is stored."),
        (name = "studies", description = "Numerical experiments; nothing is stored."),
        (name = "curves", description = "Curves through or near points; nothing is stored."),
        (name = "surfaces", description = "Surfaces through or near nodes and between borders; nothing is stored."),
        (name = "keys", description = "Keys of the caller's tenant, and the caller."),
        (name = "tenants", description = "Tenants, each a plant with its jobs and keys."),
        (name = "audit", description = "Changes with their callers, and the verification of these entries."),
        (name = "operation", description = "Health and metrics.")
    )
)]
pub struct Contract;

/// The OpenAPI 3.1 document as it is committed.
pub fn openapi_json() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let mut document = router::groups().into_openapi();
        Complete.modify(&mut document);
        let mut text = Vec::new();
        let indented = PrettyFormatter::with_indent(b" ");
        let written = document.serialize(&mut Serializer::with_formatter(&mut text, indented));
        text.push(b'\n');
        written.ok().and_then(|()| String::from_utf8(text).ok()).unwrap_or_default()
    })
}

/// The OpenAPI 3.0 copy for generators of clients.
pub fn openapi_3_0_json() -> String {
    contract::v3_0::convert(openapi_json()).unwrap_or_default()
}

struct Complete;

impl Modify for Complete {
    fn modify(&self, document: &mut Document) {
        let forms = forms::parts(document);
        for (path, item) in &mut document.paths.paths {
            let is_versioned = operations(item).any(|operation| refusals::has_parameter(operation, "If-Match"));
            for operation in operations(item) {
                name_segments(path, operation);
                name_version(operation, is_versioned);
                refusals::declare(path, operation);
                if path.starts_with("/v1/") {
                    operation.security = Some(vec![
                        SecurityRequirement::default(),
                        SecurityRequirement::new("bearer", [""; 0]),
                        SecurityRequirement::new("api_key", [""; 0]),
                    ]);
                } else {
                    operation.security = Some(Vec::new());
                }
                // A parameter that is not given is left out, too.
                for parameter in operation.parameters.iter_mut().flatten() {
                    if let RefOr::T(Parameter { schema, .. }) = parameter {
                        schema.iter_mut().for_each(not_nullable);
                    }
                }
                for response in operation.responses.responses.values_mut() {
                    if let RefOr::T(response) = response {
                        refusals::request_id(response);
                    }
                }
                replayed(operation);
                refusals::have_problems(operation);
                optional_body(operation);
                examples(operation);
                forms::declare_media_types(operation, &forms);
            }
        }
        if let Some(components) = &mut document.components {
            components.schemas.values_mut().for_each(without_null);
            components.responses.extend(refusals::shared());
            let bearer = HttpBuilder::new()
                .scheme(HttpAuthScheme::Bearer)
                .description(Some("An API key, or a token (JWT) of the server's identity provider."))
                .build();
            components.add_security_scheme("bearer", SecurityScheme::Http(bearer));
            let header = ApiKeyValue::with_description("x-api-key", "The same in a header of its own.");
            components.add_security_scheme("api_key", SecurityScheme::ApiKey(ApiKey::Header(header)));
        }
        let here = ServerBuilder::new().url("/").description(Some("The server that serves this document."));
        document.servers = Some(vec![here.build()]);
        contract::shape(document);
    }
}

fn operations(item: &mut PathItem) -> impl Iterator<Item = &mut Operation> {
    [&mut item.get, &mut item.put, &mut item.post, &mut item.delete, &mut item.patch].into_iter().flatten()
}

/// Adds the parameters that a path holds, before the others.
fn name_segments(path: &str, operation: &mut Operation) {
    let segments = path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}'));
    for (place, name) in segments.enumerate() {
        let schema = match name {
            "number" => schema!(u32),
            "key_id" | "tenant" => schema!(String),
            _ => schema!(Uuid),
        };
        let segment = ParameterBuilder::new()
            .name(name)
            .parameter_in(ParameterIn::Path)
            .description(segment(name))
            .required(Required::True)
            .schema(Some(schema));
        operation.parameters.get_or_insert_default().insert(place, segment.build().into());
    }
}

/// Returns the description of a segment of a path.
fn segment(name: &str) -> Option<&'static str> {
    Some(match name {
        "job_id" => "The job, by its UUID.",
        "number" => "The iteration, by its number within the job: 1, 2, 3 …",
        "fit_id" => "The fit, by its UUID.",
        "record_id" => "The record, by its UUID.",
        "key_id" => "The key, by its 16 hexadecimal digits.",
        "tenant" => "The tenant, by its name.",
        "stream_id" => "The stream, by its UUID.",
        _ => return None,
    })
}

/// Adds the headers of something new, and of something whose version is known.
fn name_version(operation: &mut Operation, is_versioned: bool) {
    for (status, response) in &mut operation.responses.responses {
        let RefOr::T(response) = response else { continue };
        let mut add = |name: &str, description: &str| {
            response.headers.entry(name.into()).or_insert_with(|| text_header(description));
        };
        match status.as_str() {
            "201" => {
                add("Location", "Address of the new resource.");
                add("ETag", "Version of the resource.");
            }
            "200" if is_versioned => add("ETag", "Version of the resource."),
            _ => {}
        }
    }
}

/// A header of a response with a text.
fn text_header(description: &str) -> RefOr<Header> {
    let text = ObjectBuilder::new().schema_type(Type::String);
    HeaderBuilder::new().schema(Some(text)).description(Some(description)).build().into()
}

/// Answers that may be given again say so.
fn replayed(operation: &mut Operation) {
    if !refusals::has_parameter(operation, "Idempotency-Key") {
        return;
    }
    for (_, response) in operation.responses.responses.iter_mut().filter(|(status, _)| status.starts_with('2')) {
        if let RefOr::T(response) = response {
            let header = text_header("`true` if this is the repeated first response to the same key.");
            response.headers.insert("Idempotency-Replayed".into(), header);
        }
    }
}

/// A body that may be left out is not `null` instead.
fn optional_body(operation: &mut Operation) {
    let Some(RefOr::T(body)) = &mut operation.request_body else { return };
    for content in body.content.values_mut() {
        if let RefOr::T(content) = content {
            content.schema.iter_mut().for_each(not_nullable);
        }
    }
}

fn examples(operation: &mut Operation) {
    let Some(RefOr::T(body)) = &mut operation.request_body else { return };
    let Some(RefOr::T(content)) = body.content.get_mut("application/json") else { return };
    for example in REQUEST_EXAMPLES.iter().filter(|e| Some(e.operation_id) == operation.operation_id.as_deref()) {
        let value = serde_json::from_str(example.text).ok();
        let shown = ExampleBuilder::new().summary(example.summary).value(value).build();
        content.examples.insert(example.name.into(), shown.into());
    }
}
