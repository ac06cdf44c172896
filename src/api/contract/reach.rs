//! Which schemas a document leads to.

use std::collections::{BTreeMap, BTreeSet};

use utoipa::openapi::{
    Content, Paths, RefOr, Schema,
    path::{Operation, PathItem},
    schema::{AdditionalProperties, ArrayItems},
};

type Schemas = BTreeMap<String, RefOr<Schema>>;

/// Place of a schema in an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// In a JSON body that is sent.
    JsonRequest,
    /// In another body that is sent.
    Request,
    Response,
    Parameter,
}

/// The name at the end of a reference.
pub fn name_of(reference: &str) -> &str {
    reference.rsplit('/').next().unwrap_or(reference)
}

/// The names of the schemas that the operations lead to from the places that are wanted.
pub fn of_paths(schemas: &Schemas, paths: &Paths, wanted: impl Fn(Role) -> bool) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut take = |role: Role, schema: &RefOr<Schema>| {
        if wanted(role) {
            follow(schema, schemas, &mut found);
        }
    };
    for operation in paths.paths.values().flat_map(operations) {
        if let Some(RefOr::T(body)) = &operation.request_body {
            for (media, content) in &body.content {
                let role = if media == "application/json" { Role::JsonRequest } else { Role::Request };
                schema_of(content).into_iter().for_each(|schema| take(role, schema));
            }
        }
        for response in operation.responses.responses.values() {
            let RefOr::T(response) = response else { continue };
            for content in response.content.values() {
                let RefOr::T(content) = content else { continue };
                content.schema.iter().for_each(|schema| take(Role::Response, schema));
            }
        }
        for parameter in operation.parameters.iter().flatten() {
            if let RefOr::T(parameter) = parameter {
                parameter.schema.iter().for_each(|schema| take(Role::Parameter, schema));
            }
        }
    }
    found
}

fn schema_of(content: &RefOr<Content>) -> Option<&RefOr<Schema>> {
    match content {
        RefOr::T(content) => content.schema.as_ref(),
        RefOr::Ref(_) => None,
    }
}

fn operations(item: &PathItem) -> impl Iterator<Item = &Operation> {
    [&item.get, &item.put, &item.post, &item.delete, &item.patch].into_iter().flatten()
}

fn follow(schema: &RefOr<Schema>, schemas: &Schemas, found: &mut BTreeSet<String>) {
    let schema = match schema {
        RefOr::T(schema) => schema,
        RefOr::Ref(reference) => {
            let name = name_of(&reference.ref_location);
            if found.insert(name.to_owned())
                && let Some(schema) = schemas.get(name)
            {
                follow(schema, schemas, found);
            }
            return;
        }
    };
    match schema {
        Schema::Object(object) => {
            object.properties.values().for_each(|property| follow(property, schemas, found));
            if let Some(AdditionalProperties::RefOr(more)) = object.additional_properties.as_deref() {
                follow(more, schemas, found);
            }
        }
        Schema::Array(array) => {
            if let ArrayItems::RefOrSchema(items) = &array.items {
                follow(items, schemas, found);
            }
        }
        Schema::OneOf(one) => one.items.iter().for_each(|item| follow(item, schemas, found)),
        Schema::AllOf(all) => all.items.iter().for_each(|item| follow(item, schemas, found)),
        _ => {}
    }
}
