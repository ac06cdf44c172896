//! JSON Schema (2020-12) as far as the document uses it. A keyword that is not known here is a
//! panic, so that none goes unchecked.

use serde_json::{Map, Value};

/// Keywords that say nothing about what is valid.
const SILENT: [&str; 8] =
    ["description", "title", "example", "examples", "default", "format", "discriminator", "deprecated"];

/// Document with responses in place of references to them.
pub fn with_responses(text: &str) -> Value {
    let mut document: Value = serde_json::from_str(text).unwrap();
    let shared = document["components"]["responses"].clone();
    for operation in document["paths"].as_object_mut().unwrap().values_mut().flat_map(Value::as_object_mut).flatten() {
        for response in operation.1["responses"].as_object_mut().into_iter().flatten().map(|(_, response)| response) {
            if let Some(name) = response["$ref"].as_str().and_then(|reference| reference.rsplit('/').next()) {
                *response = shared[name].clone();
            }
        }
    }
    document
}

/// The schemas of a document.
pub struct Schemas<'a>(pub &'a Value);

impl Schemas<'_> {
    /// Everything about `value` that `schema` does not allow, with the place.
    pub fn faults(&self, schema: &Value, value: &Value) -> Vec<String> {
        let mut faults = Vec::new();
        self.check(schema, value, "", &mut faults);
        faults
    }

    fn check(&self, schema: &Value, value: &Value, at: &str, faults: &mut Vec<String>) {
        let schema = schema.as_object().unwrap_or_else(|| panic!("{at}: a schema is an object"));
        for (keyword, wanted) in schema {
            if let Some(error) = self.keyword(keyword, wanted, schema, value, at, faults) {
                faults.push(format!("{at}: {error}"));
            }
        }
    }

    /// Errors of a value by one keyword; parts are checked on the way.
    fn keyword(
        &self,
        keyword: &str,
        wanted: &Value,
        schema: &Map<String, Value>,
        value: &Value,
        at: &str,
        faults: &mut Vec<String>,
    ) -> Option<String> {
        let length = value.as_array().map(Vec::len);
        let letters = value.as_str().map(|text| text.chars().count());
        let number = value.as_f64();
        let count = || usize::try_from(wanted.as_u64().unwrap()).unwrap();
        let bound = || wanted.as_f64().unwrap();
        let holds = match keyword {
            "$ref" => {
                let pointer = wanted.as_str().unwrap().strip_prefix('#').unwrap();
                self.check(self.0.pointer(pointer).unwrap_or_else(|| panic!("{wanted}")), value, at, faults);
                true
            }
            "type" => match wanted {
                Value::Array(kinds) => kinds.iter().any(|kind| is_of(value, kind.as_str().unwrap())),
                kind => is_of(value, kind.as_str().unwrap()),
            },
            "enum" => wanted.as_array().unwrap().contains(value),
            "properties" => {
                for (name, property) in wanted.as_object().unwrap() {
                    if let Some(value) = value.get(name) {
                        self.check(property, value, &format!("{at}/{name}"), faults);
                    }
                }
                true
            }
            "required" => {
                let names = wanted.as_array().unwrap().iter().map(|name| name.as_str().unwrap());
                let missing: Vec<&str> = names.filter(|name| value.is_object() && value.get(name).is_none()).collect();
                return (!missing.is_empty()).then(|| format!("{missing:?} missing"));
            }
            "additionalProperties" => {
                let known = schema.get("properties").and_then(Value::as_object);
                let mut strangers = Vec::new();
                for (name, value) in value.as_object().into_iter().flatten() {
                    if known.is_some_and(|known| known.contains_key(name)) {
                        continue;
                    }
                    match wanted {
                        Value::Bool(true) => {}
                        Value::Bool(false) => strangers.push(name),
                        more => self.check(more, value, &format!("{at}/{name}"), faults),
                    }
                }
                return (!strangers.is_empty()).then(|| format!("{strangers:?} are not known"));
            }
            "propertyNames" => true,
            "items" => {
                for (i, value) in value.as_array().into_iter().flatten().enumerate() {
                    self.check(wanted, value, &format!("{at}/{i}"), faults);
                }
                true
            }
            "oneOf" => {
                let alternatives = wanted.as_array().unwrap();
                let each: Vec<Vec<String>> =
                    alternatives.iter().map(|alternative| self.faults(alternative, value)).collect();
                let fit = each.iter().filter(|faults| faults.is_empty()).count();
                return (fit != 1).then(|| format!("{fit} of {} alternatives fit: {each:?}", alternatives.len()));
            }
            "allOf" => {
                wanted.as_array().unwrap().iter().for_each(|part| self.check(part, value, at, faults));
                true
            }
            "minItems" => length.is_none_or(|length| length >= count()),
            "maxItems" => length.is_none_or(|length| length <= count()),
            "minLength" => letters.is_none_or(|letters| letters >= count()),
            "maxLength" => letters.is_none_or(|letters| letters <= count()),
            "minimum" => number.is_none_or(|number| number >= bound()),
            "maximum" => number.is_none_or(|number| number <= bound()),
            "exclusiveMinimum" => number.is_none_or(|number| number > bound()),
            "exclusiveMaximum" => number.is_none_or(|number| number < bound()),
            silent if SILENT.contains(&silent) => true,
            other => panic!("{at}: the keyword {other} is not known to this test"),
        };
        (!holds).then(|| {
            format!(
                "{keyword} {wanted} does not hold for {}",
                value.to_string().split_at_checked(80).map_or(value.to_string(), |(start, _)| start.to_owned())
            )
        })
    }
}

fn is_of(value: &Value, kind: &str) -> bool {
    match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "number" => value.is_number(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("no type is called {other}"),
    }
}

#[test]
fn violations_of_a_schema_are_found() {
    use serde_json::json;
    let document = json!({"components": {"schemas": {"A": {"type": "object", "required": ["a"],
        "additionalProperties": false,
        "properties": {"a": {"type": ["number", "null"], "minimum": 1},
            "b": {"type": "array", "maxItems": 1, "items": {"enum": ["x"]}}}}}}});
    let schemas = Schemas(&document);
    let a = json!({"$ref": "#/components/schemas/A"});
    for (value, count) in [
        (json!({"a": 1}), 0),
        (json!({"a": null, "b": ["x"]}), 0),
        (json!({"a": 0.5}), 1),
        (json!({}), 1),
        (json!({"a": 2, "c": 1}), 1),
        (json!({"a": "2", "b": ["x", "y"]}), 3),
        (json!([]), 1),
    ] {
        assert_eq!(schemas.faults(&a, &value).len(), count, "{value}: {:?}", schemas.faults(&a, &value));
    }
    let one = json!({"oneOf": [{"type": "number"}, {"type": "integer"}, {"type": "string"}]});
    assert_eq!(schemas.faults(&one, &json!("x")).len(), 0);
    assert_eq!(schemas.faults(&one, &json!(1)).len(), 1);
    assert_eq!(schemas.faults(&one, &json!(true)).len(), 1);
}
