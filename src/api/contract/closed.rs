//! Requests refuse properties that are not known, and so do their schemas.

use std::collections::BTreeMap;

use utoipa::openapi::{
    Paths, RefOr, Schema,
    schema::{AdditionalProperties, ArrayItems},
};

use super::reach::{Role, of_paths};

/// Closes every object that a request leads to, forms included.
pub fn close(schemas: &mut BTreeMap<String, RefOr<Schema>>, paths: &Paths) {
    let requests = of_paths(schemas, paths, |role| matches!(role, Role::JsonRequest | Role::Request));
    for name in &requests {
        if let Some(schema) = schemas.get_mut(name) {
            close_one(schema);
        }
    }
}

pub fn close_one(schema: &mut RefOr<Schema>) {
    let RefOr::T(schema) = schema else { return };
    match schema {
        Schema::Object(object) => {
            object.properties.values_mut().for_each(close_one);
            if !object.properties.is_empty() && object.additional_properties.is_none() {
                object.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
            }
        }
        Schema::Array(array) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                close_one(items);
            }
        }
        Schema::OneOf(one) => one.items.iter_mut().for_each(close_one),
        _ => {}
    }
}
