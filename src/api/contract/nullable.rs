//! Optional properties lose the `null` that the generator writes for them.

use utoipa::openapi::{
    Ref, RefOr,
    schema::{Schema, SchemaType, Type},
};

/// Takes `null` from the properties of objects, at every depth. Entries of arrays keep it: a grid's
/// heights have it.
pub fn without_null(schema: &mut RefOr<Schema>) {
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

pub fn not_nullable(property: &mut RefOr<Schema>) {
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
