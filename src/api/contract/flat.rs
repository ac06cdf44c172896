//! Objects of several parts (`allOf`) as one object.
//!
//! Where a part refuses unknown properties, it refuses those of the other parts too: such a schema
//! takes nothing. Generators make classes of the parts, and name them by their place.

use std::collections::BTreeMap;

use utoipa::openapi::{
    RefOr, Schema,
    schema::{AllOf, ArrayItems, Object, Type},
};

type Schemas = BTreeMap<String, RefOr<Schema>>;

/// Flattens every schema, at every depth.
pub fn flatten(schemas: &mut Schemas) {
    let parts = schemas.clone();
    schemas.values_mut().for_each(|schema| flatten_one(schema, &parts));
}

fn flatten_one(schema: &mut RefOr<Schema>, parts: &Schemas) {
    let RefOr::T(schema) = schema else { return };
    if let Schema::AllOf(all) = schema
        && let Some(object) = merged(all, parts)
    {
        *schema = Schema::Object(object);
    }
    match schema {
        Schema::Object(object) => object.properties.values_mut().for_each(|property| flatten_one(property, parts)),
        Schema::Array(array) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                flatten_one(items, parts);
            }
        }
        Schema::OneOf(one) => one.items.iter_mut().for_each(|item| flatten_one(item, parts)),
        _ => {}
    }
}

/// One object of all parts; `None` where a part is none.
fn merged(all: &AllOf, parts: &Schemas) -> Option<Object> {
    let mut whole = Object::with_type(Type::Object);
    for item in &all.items {
        let object = object_of(item, parts)?;
        whole.properties.extend(object.properties);
        whole.required.extend(object.required);
        whole.additional_properties = whole.additional_properties.or(object.additional_properties);
        whole.example = whole.example.or(object.example);
    }
    whole.title.clone_from(&all.title);
    whole.description.clone_from(&all.description);
    whole.example = all.example.clone().or(whole.example);
    whole.examples.clone_from(&all.examples);
    Some(whole)
}

fn object_of(item: &RefOr<Schema>, parts: &Schemas) -> Option<Object> {
    match item {
        RefOr::Ref(reference) => object_of(parts.get(super::reach::name_of(&reference.ref_location))?, parts),
        RefOr::T(Schema::Object(object)) => Some(object.clone()),
        RefOr::T(Schema::AllOf(all)) => merged(all, parts),
        // an optional part, or one of several: no property is required
        RefOr::T(Schema::OneOf(one)) => {
            let mut whole = Object::with_type(Type::Object);
            for item in &one.items {
                whole.properties.extend(object_of(item, parts)?.properties);
            }
            Some(whole)
        }
        RefOr::T(_) => None,
    }
}
