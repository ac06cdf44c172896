//! The operations that the service documents, and values that their schemas allow.

use serde_json::{Map, Value};

use super::{node::Node, rng::Rng};

const METHODS: [&str; 5] = ["get", "put", "post", "delete", "patch"];
/// Schemas refer to each other; generated values end here.
const DEEPEST: usize = 7;

#[derive(Clone, Debug)]
pub struct Parameter {
    pub name: String,
    /// `path`, `query` or `header`.
    pub place: String,
    pub schema: Value,
}

#[derive(Clone, Debug)]
pub struct Operation {
    pub id: String,
    pub method: String,
    pub path: String,
    pub parameters: Vec<Parameter>,
    /// Schemas of its body by media type.
    pub bodies: Vec<(String, Value)>,
}

pub struct Contract {
    document: Value,
    pub operations: Vec<Operation>,
    /// The fields of every named schema that is an object.
    objects: Vec<Map<String, Value>>,
}

impl Contract {
    pub fn new(text: &str) -> Self {
        let document: Value = serde_json::from_str(text).expect("an OpenAPI document");
        let mut operations = Vec::new();
        for (path, item) in document["paths"].as_object().expect("paths") {
            for method in METHODS {
                let Some(operation) = item.get(method) else { continue };
                let shared = item["parameters"].as_array().into_iter().flatten();
                let own = operation["parameters"].as_array().into_iter().flatten();
                let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
                let parameter = |p: &Value| Parameter {
                    name: text(&p["name"]),
                    place: text(&p["in"]),
                    schema: p["schema"].clone(),
                };
                let bodies = operation.pointer("/requestBody/content").and_then(Value::as_object);
                operations.push(Operation {
                    id: text(&operation["operationId"]),
                    method: method.to_uppercase(),
                    path: path.clone(),
                    parameters: shared.chain(own).map(parameter).collect(),
                    bodies: bodies.into_iter().flatten().map(|(m, c)| (m.clone(), c["schema"].clone())).collect(),
                });
            }
        }
        let mut contract = Contract { document, operations, objects: Vec::new() };
        let schemas = contract.document["components"]["schemas"].as_object().cloned().unwrap_or_default();
        let mut objects = Vec::new();
        schemas.values().for_each(|schema| contract.fields(schema, &mut objects));
        contract.objects = objects;
        contract
    }

    fn fields(&self, schema: &Value, found: &mut Vec<Map<String, Value>>) {
        found.extend(schema["properties"].as_object().cloned());
        for union in ["allOf", "oneOf", "anyOf"] {
            schema[union].as_array().into_iter().flatten().for_each(|part| self.fields(part, found));
        }
    }

    fn resolved<'a>(&'a self, schema: &'a Value) -> &'a Value {
        let mut schema = schema;
        while let Some(name) = schema["$ref"].as_str() {
            let Some(found) = self.document.pointer(name.trim_start_matches('#')) else { break };
            schema = found;
        }
        schema
    }

    /// The example that a schema has of its own.
    pub fn example(&self, schema: &Value) -> Option<Node> {
        self.resolved(schema).get("example").map(Node::of)
    }

    /// A field that an object with these fields may have too, with a value.
    pub fn another_field(&self, fields: &[(String, Node)], rng: &mut Rng) -> Option<(String, Node)> {
        let known = |object: &Map<String, Value>| fields.iter().filter(|(name, _)| object.contains_key(name)).count();
        let most = self.objects.iter().map(known).max().filter(|most| *most > 0)?;
        let alike: Vec<_> = self.objects.iter().filter(|object| known(object) == most).collect();
        let object = rng.pick(&alike)?;
        let names: Vec<&String> = object.keys().collect();
        let name = rng.pick(&names)?;
        Some(((*name).clone(), self.value(&object[*name], rng, 0)))
    }

    /// A field of any object of the contract.
    pub fn any_field(&self, rng: &mut Rng) -> Option<(String, Node)> {
        let object = rng.pick(&self.objects)?;
        let names: Vec<&String> = object.keys().collect();
        let name = rng.pick(&names)?;
        Some(((*name).clone(), self.value(&object[*name], rng, 0)))
    }

    /// A value of a schema; mostly what it allows.
    pub fn value(&self, schema: &Value, rng: &mut Rng, depth: usize) -> Node {
        let schema = self.resolved(schema);
        if let Some(only) = schema.get("const") {
            return Node::of(only);
        }
        if let Some(one) = schema["enum"].as_array().and_then(|all| rng.pick(all)) {
            return Node::of(one);
        }
        for union in ["oneOf", "anyOf"] {
            if let Some(one) = schema[union].as_array().and_then(|all| rng.pick(all)) {
                return self.value(one, rng, depth + 1);
            }
        }
        if schema.get("allOf").is_some() || schema.get("properties").is_some() {
            let mut fields = Vec::new();
            self.object(schema, rng, depth, &mut fields);
            return Node::Object(fields);
        }
        let kind = match &schema["type"] {
            Value::Array(kinds) => rng.pick(kinds).and_then(Value::as_str).unwrap_or("null").to_owned(),
            kind => kind.as_str().unwrap_or("object").to_owned(),
        };
        match kind.as_str() {
            "array" => self.array(schema, rng, depth),
            "integer" => Node::token(rng.one(["0", "1", "2", "3", "4", "5", "7", "12", "40"])),
            "number" => Node::token(rng.one(["0", "1", "2.5", "0.1", "-1", "10", "0.5", "20", "1e-3", "100"])),
            "boolean" => Node::token(rng.one(["true", "false"])),
            "string" => Node::text(match schema["format"].as_str() {
                Some("uuid") => "0190b0de-0000-7000-8000-000000000000".to_owned(),
                Some("date-time") => "2026-01-02T03:04:05Z".to_owned(),
                _ => rng.one(["a", "left", "1", "y", "µm", "two words"]).to_owned(),
            }),
            "null" => Node::token("null"),
            _ => Node::Object(Vec::new()),
        }
    }

    fn object(&self, schema: &Value, rng: &mut Rng, depth: usize, fields: &mut Vec<(String, Node)>) {
        let schema = self.resolved(schema);
        for part in schema["allOf"].as_array().into_iter().flatten() {
            self.object(part, rng, depth, fields);
        }
        if let Some(one) = schema["oneOf"].as_array().and_then(|all| rng.pick(all)) {
            self.object(one, rng, depth, fields);
        }
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        for (name, property) in schema["properties"].as_object().into_iter().flatten() {
            let optional = depth < DEEPEST && rng.percent(if depth < 3 { 30 } else { 10 });
            if required.contains(&name.as_str()) && depth < 2 * DEEPEST || optional {
                fields.push((name.clone(), self.value(property, rng, depth + 1)));
            }
        }
    }

    fn array(&self, schema: &Value, rng: &mut Rng, depth: usize) -> Node {
        let bound = |name: &str| schema[name].as_u64().map(|n| n as usize);
        let least = bound("minItems").unwrap_or(0);
        let most = bound("maxItems").unwrap_or(least + 6).min(least + 6);
        let count = if depth > DEEPEST { least.min(1) } else { rng.within(least, most) };
        let items = &schema["items"];
        if self.resolved(items)["type"] == "number" && rng.percent(60) {
            // most lists of numbers are places, which ascend
            return Node::Array((0..count).map(|k| Node::token(format!("{}", k as f64 * 0.5))).collect());
        }
        Node::Array((0..count).map(|_| self.value(items, rng, depth + 1)).collect())
    }
}
