//! Alternatives that stand within their union get names of their own, by their `type` and the
//! union: `TipReliefFlankModification`.
//!
//! Generators name what has no name by its place (`FlankModificationOneOf3`), and anew when the
//! order changes.

use std::collections::BTreeMap;

use utoipa::openapi::{
    Ref, RefOr, Schema,
    schema::{Discriminator, Object, OneOf},
};

type Schemas = BTreeMap<String, RefOr<Schema>>;

/// Names the alternatives of every union whose alternatives carry `type`, and says of each property
/// `type` what it is.
pub fn name(schemas: &mut Schemas) {
    let mut named = Schemas::new();
    for (union, schema) in schemas.iter_mut() {
        if let RefOr::T(Schema::OneOf(one)) = schema {
            name_items(union, one, &mut named);
        }
    }
    schemas.extend(named);
    for schema in schemas.values_mut() {
        if let RefOr::T(Schema::Object(object)) = schema
            && let Some(tag) = tag_of(object)
            && let Some(RefOr::T(Schema::Object(kind))) = object.properties.get_mut("type")
        {
            kind.description.get_or_insert_with(|| format!("Name of the alternative: `{tag}`."));
        }
    }
}

fn name_items(union: &str, one: &mut OneOf, named: &mut Schemas) {
    let tags: Vec<String> = one.items.iter().filter_map(tag_within).collect();
    if tags.is_empty() || tags.len() < one.items.len() {
        return;
    }
    let mut mapping = BTreeMap::new();
    for (item, tag) in one.items.iter_mut().zip(tags) {
        let name = format!("{}{union}", pascal(&tag));
        let reference = Ref::from_schema_name(name.clone());
        mapping.insert(tag, reference.ref_location.clone());
        named.insert(name, std::mem::replace(item, RefOr::Ref(reference)));
    }
    let mut discriminator = Discriminator::new("type");
    discriminator.mapping = mapping;
    one.discriminator = Some(discriminator);
}

fn tag_within(item: &RefOr<Schema>) -> Option<String> {
    match item {
        RefOr::T(Schema::Object(object)) => tag_of(object),
        _ => None,
    }
}

/// The one value that `type` may have.
fn tag_of(object: &Object) -> Option<String> {
    let RefOr::T(Schema::Object(kind)) = object.properties.get("type")? else { return None };
    match kind.enum_values.as_deref()? {
        [only] => only.as_str().map(str::to_owned),
        _ => None,
    }
}

fn pascal(tag: &str) -> String {
    let words = tag.split('_').map(|word| {
        let mut letters = word.chars();
        letters.next().map(|first| first.to_uppercase().chain(letters).collect::<String>()).unwrap_or_default()
    });
    words.collect()
}
