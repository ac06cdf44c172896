//! Which operations may be answered later (`Prefer: respond-async`). It stands in the document, and
//! what stands there is done (`http/operations.rs`).

use utoipa::openapi::{
    Content, HeaderBuilder, ObjectBuilder, OpenApi as Document, Ref, RefOr, ResponseBuilder,
    path::{Operation, ParameterBuilder, ParameterIn},
    schema::Type,
};

/// The header by which a client asks for it.
const PREFER: &str = "Prefer";

/// What may take long.
const LONG: [&str; 11] = [
    "create_fit",
    "create_iteration",
    "create_iteration_fit",
    "import_iteration",
    "study_randomization",
    "simulate_closed_loop",
    "create_surface",
    "create_iteration_surface",
    "sections_of_surface",
    "export_curve",
    "export_surface",
];

/// Writes the preference, and the answer 202, into the document.
pub fn declare(document: &mut Document) {
    let posts = document.paths.paths.values_mut().filter_map(|item| item.post.as_mut());
    let is_long = |operation: &&mut Operation| operation.operation_id.as_deref().is_some_and(|id| LONG.contains(&id));
    posts.filter(is_long).for_each(extend);
}

fn extend(operation: &mut Operation) {
    let description = "With `respond-async` the answer is 202 with the address of an operation; with `wait=N` only if \
        the result is not ready within N seconds. The same `Idempotency-Key` gives the same operation.";
    let prefer = ParameterBuilder::new()
        .name(PREFER)
        .parameter_in(ParameterIn::Header)
        .schema(Some(text()))
        .description(Some(description))
        .build();
    operation.parameters.get_or_insert_default().push(prefer.into());
    let header = |description: &str, schema: ObjectBuilder| {
        HeaderBuilder::new().schema(Some(schema)).description(Some(description)).build()
    };
    let content = Content::new(Some(RefOr::Ref(Ref::from_schema_name("Operation"))));
    let seconds = ObjectBuilder::new().schema_type(Type::Integer);
    let response = ResponseBuilder::new()
        .description("The request has been read and checked, and is answered later.")
        .content("application/json", content)
        .header("Location", header("Address of the operation; its result is at `…/result`.", text()))
        .header("Preference-Applied", header("`respond-async`.", text()))
        .header("Retry-After", header("Seconds after which it is worth asking.", seconds))
        .build();
    operation.responses.responses.insert("202".into(), response.into());
}

fn text() -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::String)
}

/// Whether a POST says that it may be answered later.
pub fn is_offered(operation: &Operation) -> bool {
    let mut parameters = operation.parameters.iter().flatten();
    let prefers = parameters.any(|parameter| match parameter {
        RefOr::T(parameter) => parameter.parameter_in == ParameterIn::Header && parameter.name == PREFER,
        RefOr::Ref(_) => false,
    });
    prefers && operation.responses.responses.contains_key("202")
}
