//! Defaults that descriptions state become `default` of their schemas: a last sentence such as
//! "Default `replace`." or "Default 0.95." leaves the description.

use serde_json::Value;
use utoipa::openapi::{RefOr, Schema, schema::ArrayItems};

/// Moves the defaults of all properties from their descriptions.
pub fn move_from_descriptions(schema: &mut RefOr<Schema>) {
    let RefOr::T(schema) = schema else { return };
    match schema {
        Schema::Object(object) => {
            for property in object.properties.values_mut() {
                take(property);
                move_from_descriptions(property);
            }
        }
        Schema::Array(array) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                move_from_descriptions(items);
            }
        }
        Schema::OneOf(one) => one.items.iter_mut().for_each(move_from_descriptions),
        _ => {}
    }
}

fn take(property: &mut RefOr<Schema>) {
    let mut text = None;
    let (description, default) = match property {
        RefOr::Ref(reference) => {
            text = Some(std::mem::take(&mut reference.description));
            (&mut text, &mut reference.default)
        }
        RefOr::T(Schema::Object(object)) => (&mut object.description, &mut object.default),
        RefOr::T(Schema::Array(array)) => (&mut array.description, &mut array.default),
        RefOr::T(Schema::OneOf(one)) => (&mut one.description, &mut one.default),
        RefOr::T(_) => return,
    };
    if let Some((rest, value)) = description.as_deref().and_then(split) {
        *description = Some(rest.to_owned()).filter(|rest| !rest.is_empty());
        *default = Some(value);
    }
    if let RefOr::Ref(reference) = property {
        reference.description = text.unwrap_or_default();
    }
}

/// Splits a description that ends in a default.
fn split(text: &str) -> Option<(&str, Value)> {
    let (rest, value) = text.trim_end().strip_suffix('.')?.rsplit_once("Default ")?;
    let word = value.strip_prefix('`').and_then(|word| word.strip_suffix('`')).unwrap_or(value);
    if word.contains(['`', ' ', '\n']) {
        return None;
    }
    let plain = || (word != value).then(|| Value::from(word));
    Some((rest.trim_end(), serde_json::from_str(word).ok().or_else(plain)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_last_sentence_is_a_default() {
        let found = |text: &'static str| split(text).map(|(rest, value)| (rest, value.to_string()));
        assert_eq!(found("Default `gcv`."), Some(("", "\"gcv\"".into())));
        assert_eq!(found("Level. Default 0.95."), Some(("Level.", "0.95".into())));
        assert_eq!(found("Kinds.\nDefault `[\"mean\"]`."), Some(("Kinds.", "[\"mean\"]".into())));
        for text in ["Default 12 µm.", "Default `true` without `parameters`.", "Default right.", "Level."] {
            assert_eq!(found(text), None, "{text}");
        }
    }
}
