//! The OpenAPI document: what the handlers declare, completed with what holds for every one of
//! them.
//!
//! Handlers declare what is theirs. Here every operation gains the refusals that the layers below
//! it give (unreadable body, API key, timeouts, a full queue, …), the header `x-request-id`, and
//! its examples; and optional properties lose the `null` that the generator writes for them, since
//! absence is never written as `null`. What holds for the schemas, whoever declares them, is
//! `api::contract`.

use std::{collections::BTreeMap, sync::OnceLock};

use utoipa::{
    Modify, OpenApi,
    openapi::{
        Content, HeaderBuilder, ObjectBuilder, OpenApi as Document, Ref, RefOr, ResponseBuilder,
        encoding::EncodingBuilder,
        example::ExampleBuilder,
        path::{Operation, Parameter, PathItem},
        schema::{Schema, SchemaType, Type},
        security::{ApiKey, ApiKeyValue, HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme},
        server::ServerBuilder,
    },
};

use super::router;
use crate::api::{
    contract,
    examples::REQUEST_EXAMPLES,
    gears::correction::include::KeptIncludeName,
    problem::{Problem, ProblemError},
};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "flankfit",
        description = "Robust parametric estimation of tooth-flank surfaces: coefficients with standard errors and \
                       bias bounds, eigen diagnostics, and every choice of λ* side by side.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(Problem, ProblemError, KeptIncludeName)),
    tags(
        (name = "fits", description = "Fits of node sets; nothing is stored."),
        (name = "studies", description = "Numerical experiments; nothing is stored."),
        (name = "curves", description = "Curves through or near points; nothing is stored."),
        (name = "surfaces", description = "Surfaces through or near nodes and between borders; nothing is stored."),
        (name = "gears", description = "Gears: tolerances, flanks, deviations and evaluation; nothing is stored."),
        (name = "simulations", description = "Simulated machines and probes, kept as jobs."),
        (name = "jobs", description = "Gear jobs."),
        (name = "iterations", description = "Iterations of a job: nodes, fits, λ* choices, decisions, and the trace of \
            them all."),
        (name = "streams", description = "Nodes that arrive block by block: an estimate after every block, an \
            iteration in the end."),
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
        let mut text = document.to_pretty_json().unwrap_or_default();
        text.push('\n');
        text
    })
}

/// The OpenAPI 3.0 copy as it is committed.
pub fn openapi_3_0_json() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| contract::v3_0::convert(openapi_json()).unwrap_or_default())
}

struct Complete;

impl Modify for Complete {
    fn modify(&self, document: &mut Document) {
        let forms = forms(document);
        for (path, item) in &mut document.paths.paths {
            for operation in operations(item) {
                refusals(path, operation);
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
                    if let RefOr::T(Parameter { schema, name, description, .. }) = parameter {
                        schema.iter_mut().for_each(not_nullable);
                        if description.is_none() {
                            *description = segment(name).map(str::to_owned);
                        }
                    }
                }
                request_id(operation);
                replayed(operation);
                shown_problems(operation);
                optional_body(operation);
                examples(operation);
                form_parts(operation, &forms);
            }
        }
        if let Some(components) = &mut document.components {
            components.schemas.values_mut().for_each(without_null);
            let bearer = HttpBuilder::new()
                .scheme(HttpAuthScheme::Bearer)
                .description(Some("An API key, where the server was started with some."))
                .build();
            components.add_security_scheme("bearer", SecurityScheme::Http(bearer));
            let header = ApiKeyValue::with_description("x-api-key", "The same in a header of its own.");
            components.add_security_scheme("api_key", SecurityScheme::ApiKey(ApiKey::Header(header)));
        }
        let here = ServerBuilder::new().url("/").description(Some("The server that the document comes from."));
        document.servers = Some(vec![here.build()]);
        contract::shape(document);
    }
}

fn operations(item: &mut PathItem) -> impl Iterator<Item = &mut Operation> {
    [&mut item.get, &mut item.put, &mut item.post, &mut item.delete, &mut item.patch].into_iter().flatten()
}

/// Documents what the layers below a handler may answer, where the handler has not said more about
/// it.
fn refusals(path: &str, operation: &mut Operation) {
    let versioned = path.starts_with("/v1/");
    let body = operation.request_body.is_some();
    let good = operation.responses.responses.iter().filter(|(status, _)| status.starts_with('2'));
    let represented = good.into_iter().any(|(_, r)| matches!(r, RefOr::T(response) if !response.content.is_empty()));
    let known = [
        (versioned && body, "400", "The body or its compression cannot be read; `detail` says where."),
        (versioned, "401", "The server asks for an API key."),
        (versioned, "403", "The API key is not known."),
        (versioned && path.contains('{'), "404", "There is no such resource."),
        (represented, "406", "The header `Accept` takes none of the media types of the answer."),
        (versioned && body, "408", "The body did not arrive in time."),
        (versioned && body, "413", "The body is too large (counted after decompression)."),
        (versioned && body, "415", "The media type or the compression is not supported."),
        (versioned && body, "422", "The request holds what cannot be accepted; `errors` points to every fault."),
        (true, "422", "The query has a parameter that this operation has not, or one twice."),
        (true, "500", "The fault is on the server's side; nothing was stored."),
        (true, "503", "Busy, or no answer in time; try again after `Retry-After` seconds."),
    ];
    for (_, status, description) in known.into_iter().filter(|(given, _, _)| *given) {
        if operation.responses.responses.contains_key(status) {
            continue;
        }
        let content = Content::new(Some(RefOr::Ref(Ref::from_schema_name("Problem"))));
        let mut response = ResponseBuilder::new().description(description).content("application/problem+json", content);
        if status == "503" {
            let seconds = ObjectBuilder::new().schema_type(Type::Integer);
            let header = HeaderBuilder::new().schema(Some(seconds)).description(Some("Seconds to wait.")).build();
            response = response.header("Retry-After", header);
        }
        operation.responses.responses.insert(status.into(), response.build().into());
    }
}

/// What a segment of a path names.
fn segment(name: &str) -> Option<&'static str> {
    Some(match name {
        "job_id" => "The job, by its UUID.",
        "number" => "The iteration, by its number within the job: 1, 2, 3 …",
        "fit_id" => "The fit, by its UUID.",
        "record_id" => "The record, by its UUID.",
        "stream_id" => "The stream, by its UUID.",
        _ => return None,
    })
}

/// Shows under each status a problem of that status.
fn shown_problems(operation: &mut Operation) {
    for (status, response) in &mut operation.responses.responses {
        if let RefOr::T(response) = response
            && let Some(RefOr::T(content)) = response.content.get_mut("application/problem+json")
            && content.example.is_none()
        {
            content.example = contract::problem_example(status);
        }
    }
}

fn request_id(operation: &mut Operation) {
    for response in operation.responses.responses.values_mut() {
        if let RefOr::T(response) = response {
            let text = ObjectBuilder::new().schema_type(Type::String);
            let header = HeaderBuilder::new()
                .schema(Some(text))
                .description(Some("Id of the request: the caller's own, or a new UUIDv7."))
                .build();
            response.headers.insert("x-request-id".into(), header.into());
        }
    }
}

/// Answers that may be given again say so.
fn replayed(operation: &mut Operation) {
    let keyed = |parameter: &RefOr<Parameter>| matches!(parameter, RefOr::T(one) if one.name == "Idempotency-Key");
    if !operation.parameters.iter().flatten().any(keyed) {
        return;
    }
    for (_, response) in operation.responses.responses.iter_mut().filter(|(status, _)| status.starts_with('2')) {
        if let RefOr::T(response) = response {
            let text = ObjectBuilder::new().schema_type(Type::String);
            let header = HeaderBuilder::new()
                .schema(Some(text))
                .description(Some("`true` where this is the first answer to the same key, given again."))
                .build();
            response.headers.insert("Idempotency-Replayed".into(), header.into());
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

/// The parts of every form, by the name of its schema.
fn forms(document: &Document) -> BTreeMap<String, Vec<String>> {
    let schemas = document.components.iter().flat_map(|components| &components.schemas);
    let parts = schemas.filter_map(|(name, schema)| match schema {
        RefOr::T(Schema::Object(object)) => Some((name.clone(), object.properties.keys().cloned().collect())),
        _ => None,
    });
    parts.collect()
}

/// Which media types the parts of a form have.
fn form_parts(operation: &mut Operation, forms: &BTreeMap<String, Vec<String>>) {
    let Some(RefOr::T(body)) = &mut operation.request_body else { return };
    let Some(RefOr::T(content)) = body.content.get_mut("multipart/form-data") else { return };
    let Some(RefOr::Ref(form)) = &content.schema else { return };
    let Some(parts) = form.ref_location.rsplit('/').next().and_then(|name| forms.get(name)) else { return };
    for (part, media) in [("spec", "application/json"), ("nodes", "text/csv"), ("file", "application/octet-stream")] {
        if parts.contains(&part.to_owned()) {
            let encoding = EncodingBuilder::new().content_type(Some(media)).build();
            content.encoding.insert(part.into(), encoding);
        }
    }
}

/// Takes `null` from the properties of objects, at every depth. Entries of arrays keep it: a grid's
/// heights have it.
fn without_null(schema: &mut RefOr<Schema>) {
    let RefOr::T(schema) = schema else { return };
    match schema {
        Schema::Object(object) => {
            for property in object.properties.values_mut() {
                not_nullable(property);
                without_null(property);
            }
        }
        Schema::AllOf(all) => all.items.iter_mut().for_each(without_null),
        Schema::OneOf(one) => one.items.iter_mut().for_each(without_null),
        _ => {}
    }
}

fn not_nullable(property: &mut RefOr<Schema>) {
    let RefOr::T(schema) = property else { return };
    match schema {
        Schema::Object(object) => single_type(&mut object.schema_type),
        Schema::Array(array) => single_type(&mut array.schema_type),
        Schema::OneOf(one) => {
            one.items.retain(|item| !is_null(item));
            if let [only] = one.items.as_mut_slice() {
                let description = one.description.take();
                let mut only = std::mem::replace(only, RefOr::Ref(Ref::default()));
                if let RefOr::Ref(reference) = &mut only
                    && let Some(description) = description
                {
                    reference.description = description;
                }
                *property = only;
            }
        }
        _ => {}
    }
}

fn single_type(kind: &mut SchemaType) {
    if let SchemaType::Array(types) = kind {
        types.retain(|kind| *kind != Type::Null);
        if let [only] = types.as_slice() {
            *kind = SchemaType::Type(only.clone());
        }
    }
}

fn is_null(schema: &RefOr<Schema>) -> bool {
    matches!(schema, RefOr::T(Schema::Object(object)) if object.schema_type == SchemaType::Type(Type::Null))
}
