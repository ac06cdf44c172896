//! The shape of the published contract: what becomes of the generated schemas before anybody reads
//! them.
//!
//! Validators and generators of clients take less than OpenAPI allows. So every object is one flat
//! list of properties, every alternative of a union has a name, what is refused in requests is
//! refused by their schemas, and nothing is there that is not used. [`v3_0`] makes the copy for
//! OpenAPI 3.0, which is the one that generators take (`docs/how-to/clients.md`).

mod closed;
mod defaults;
mod flat;
mod generators;
mod generics;
pub mod nullable;
mod problems;
mod reach;
pub mod v3_0;
mod variants;

use std::{borrow::Cow, collections::BTreeMap};

use serde_json::{Map, Value};
use utoipa::{
    PartialSchema, ToSchema,
    openapi::{OpenApi, RefOr, Schema},
};

pub use self::problems::example as problem_example;
use flankfit_engine::numerics::contract::{list, number};

/// Brings the schemas of a document into shape.
pub fn shape(document: &mut OpenApi) {
    let Some(mut components) = document.components.take() else { return };
    let schemas = &mut components.schemas;
    flat::flatten(schemas);
    generics::settle(schemas);
    variants::name(schemas);
    closed::close(schemas, &document.paths);
    schemas.values_mut().for_each(without_code);
    schemas.values_mut().for_each(defaults::move_from_descriptions);
    let used = reach::of_paths(schemas, &document.paths, |_| true);
    schemas.retain(|name, _| used.contains(name));
    document.components = Some(components);
}

/// Takes code blocks out of a description: examples of documentation are Rust.
fn without_code(schema: &mut RefOr<Schema>) {
    let description = match schema {
        RefOr::T(Schema::Object(object)) => &mut object.description,
        RefOr::T(Schema::Array(array)) => &mut array.description,
        RefOr::T(Schema::OneOf(one)) => &mut one.description,
        _ => return,
    };
    if let Some(text) = description.as_mut().filter(|text| text.contains("```")) {
        let prose: Vec<&str> = text.split("```").step_by(2).map(str::trim).filter(|part| !part.is_empty()).collect();
        *text = prose.join("\n\n");
    }
}

/// Numbers in schemas of arrays, which have no length otherwise.
pub enum Numbers<const LEAST: usize, const MOST: usize> {}

/// Two numbers.
pub type Pair = Numbers<2, 2>;
/// A point of space.
pub type Triple = Numbers<3, 3>;
/// A point of plane or space.
pub type Coordinates = Numbers<2, 3>;

impl<const LEAST: usize, const MOST: usize> PartialSchema for Numbers<LEAST, MOST> {
    fn schema() -> RefOr<Schema> {
        let description = match (LEAST, MOST) {
            (2, 2) => "Two numbers.",
            (3, _) => "Three numbers.",
            _ => "`[x, y]` or `[x, y, z]`.",
        };
        list(number(), Some((LEAST, MOST))).description(Some(description)).into()
    }
}

impl<const LEAST: usize, const MOST: usize> ToSchema for Numbers<LEAST, MOST> {
    fn name() -> Cow<'static, str> {
        match (LEAST, MOST) {
            (2, 2) => "Pair".into(),
            (3, _) => "Triple".into(),
            _ => "Coordinates".into(),
        }
    }
}

/// Returns the schema of a request, and those that it refers to by their names.
pub fn schema_of<T: ToSchema>() -> (Value, Map<String, Value>) {
    const ROOT: &str = "$root";
    let mut list = vec![(ROOT.to_owned(), <T as PartialSchema>::schema())];
    T::schemas(&mut list);
    let mut schemas: BTreeMap<_, _> = list.into_iter().collect();
    flat::flatten(&mut schemas);
    generics::settle(&mut schemas);
    variants::name(&mut schemas);
    for schema in schemas.values_mut() {
        closed::close_one(schema);
        nullable::without_null(schema);
    }
    let value = serde_json::to_value(&schemas).unwrap_or_default();
    let Value::Object(mut schemas) = value else { return (Value::Null, Map::new()) };
    (schemas.remove(ROOT).unwrap_or_default(), schemas)
}
