//! Schemas of generic types, in which utoipa writes the argument in place of a reference to it.

use std::{collections::BTreeMap, mem};

use utoipa::openapi::{Ref, RefOr, Schema, schema::ArrayItems};

use flankfit_engine::numerics::contract::number;

/// Gives the arguments of generic types (`Page_Key`) their own schemas, and replaces references to
/// `f64`, which has none.
pub fn settle(schemas: &mut BTreeMap<String, RefOr<Schema>>) {
    let mut arguments = BTreeMap::new();
    for (name, schema) in schemas.iter_mut() {
        let RefOr::T(Schema::Object(object)) = schema else { continue };
        let argument = name.split_once('_').map(|(_, argument)| argument);
        for property in object.properties.values_mut() {
            if let RefOr::Ref(of) = property
                && of.ref_location.ends_with("/f64")
            {
                *property = number().description(Some(mem::take(&mut of.description))).into();
            }
            let Some(argument) = argument else { continue };
            let inlined = match property {
                RefOr::T(Schema::Array(array)) => match &mut array.items {
                    ArrayItems::RefOrSchema(items) => items.as_mut(),
                    ArrayItems::False => continue,
                },
                property => property,
            };
            if let RefOr::T(Schema::Object(object)) = inlined
                && !object.properties.is_empty()
            {
                let reference = RefOr::Ref(Ref::from_schema_name(argument));
                arguments.insert(argument.to_owned(), mem::replace(inlined, reference));
            }
        }
    }
    for (name, schema) in arguments {
        schemas.entry(name).or_insert(schema);
    }
}
