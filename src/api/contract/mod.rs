//! The shape of the published contract: what becomes of the generated schemas before anybody reads
//! them.
//!
//! Validators and generators of clients take less than OpenAPI allows. So every object is one flat
//! list of properties, every alternative of a union has a name, what is refused in requests is
//! refused by their schemas, and nothing stands there that nothing leads to. [`v3_0`] makes the
//! copy for OpenAPI 3.0, which is the one that generators take (`docs/clients.md`).

mod closed;
mod flat;
mod generators;
mod problems;
mod reach;
pub mod v3_0;
mod variants;

use utoipa::openapi::OpenApi;

pub use self::problems::example as problem_example;

/// Brings the schemas of a document into shape.
pub fn shape(document: &mut OpenApi) {
    let Some(mut components) = document.components.take() else { return };
    let schemas = &mut components.schemas;
    flat::flatten(schemas);
    variants::name(schemas);
    closed::close(schemas, &document.paths);
    let used = reach::of_paths(schemas, &document.paths, |_| true);
    schemas.retain(|name, _| used.contains(name));
    document.components = Some(components);
}
