//! Schemas of the published document in the form in which requests are checked by them.

use std::collections::HashMap;

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::{reader::read, refusal::Refusal};
use flankfit_engine::{
    estimation::spec,
    geometry::{curve::CurveShape, surface::SurfaceShape},
};

/// Reads a value as a type whose fields depend on each other.
pub type Reads = fn(&[u8]) -> Option<Refusal>;

/// Types whose fields depend on each other and that occur within objects, unions and arrays, by the
/// names of their schemas. After an error each value is read by itself, so that all errors are
/// found, with their places.
const DEPENDENT: [(&str, Reads); 5] = [
    ("Curve", reads::<CurveShape>),
    ("Filter", reads::<spec::Filter>),
    ("Model", reads::<spec::Model>),
    ("Parameter", reads::<spec::Parameter>),
    ("Surface", reads::<SurfaceShape>),
];

fn reads<T: DeserializeOwned>(text: &[u8]) -> Option<Refusal> {
    read::<T>(text).err()
}

/// Greatest number of properties of a schema.
pub const MOST_PROPERTIES: usize = 128;

/// Place of a schema among all that one schema refers to.
pub type Id = usize;

/// A schema with those that it refers to; the schema itself is the first.
pub struct Compiled(Vec<Node>);

/// One schema.
pub struct Node {
    pub kind: Kind,
    /// True if `null` is a value.
    pub is_nullable: bool,
    /// Reads a value of a type whose fields depend on each other.
    pub reads: Option<Reads>,
}

/// The values that a schema allows.
pub enum Kind {
    Any,
    /// Several forms: objects by their `type`, and all of them.
    Union {
        tagged: Vec<(String, Id)>,
        forms: Vec<Id>,
    },
    Names(Vec<String>),
    Object(Object),
    Array {
        entries: Option<Id>,
        lengths: Lengths,
    },
    Number(Range),
    Text {
        is_uuid: bool,
        lengths: Lengths,
    },
    Boolean,
}

/// Least and greatest length.
pub type Lengths = [Option<usize>; 2];

/// Members of an object.
pub struct Object {
    pub properties: Vec<(String, Id)>,
    /// The value of every other member; without it there are no others.
    pub others: Option<Id>,
    /// Places of the required ones among the properties.
    pub required: Vec<usize>,
}

/// Range of a number.
#[derive(Default)]
pub struct Range {
    pub is_whole: bool,
    pub minimum: Option<f64>,
    pub maximum: Option<f64>,
    pub above: Option<f64>,
    pub below: Option<f64>,
    /// True for whole numbers of 32 bits.
    pub is_short: bool,
}

impl Compiled {
    /// Compiles a schema and those that it refers to by their names.
    pub fn new(schema: &Value, schemas: &Map<String, Value>) -> Self {
        let mut compiler = Compiler { schemas, nodes: Vec::new(), known: HashMap::new() };
        compiler.add(schema);
        Compiled(compiler.nodes)
    }

    /// Returns the schema of a place.
    pub fn node(&self, id: Id) -> &Node {
        &self.0[id]
    }

    /// Returns the place of a member's schema.
    pub fn member(&self, name: &str) -> Option<Id> {
        let Kind::Object(Object { properties, .. }) = &self.0[0].kind else { return None };
        properties.iter().find(|(known, _)| known == name).map(|(_, id)| *id)
    }
}

struct Compiler<'a> {
    schemas: &'a Map<String, Value>,
    nodes: Vec<Node>,
    known: HashMap<&'a str, Id>,
}

impl<'a> Compiler<'a> {
    fn add(&mut self, schema: &'a Value) -> Id {
        let name = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next());
        let Some((name, target)) = name.and_then(|name| self.schemas.get_key_value(name)) else {
            let id = self.reserve(None);
            return self.fill(id, schema);
        };
        if let Some(id) = self.known.get(&**name) {
            return *id;
        }
        let reads = DEPENDENT.iter().find(|(known, _)| known == name).map(|(_, reads)| *reads);
        let id = self.reserve(reads);
        self.known.insert(name, id);
        self.fill(id, target)
    }

    fn reserve(&mut self, reads: Option<Reads>) -> Id {
        self.nodes.push(Node { kind: Kind::Any, is_nullable: false, reads });
        self.nodes.len() - 1
    }

    fn fill(&mut self, id: Id, mut schema: &'a Value) -> Id {
        while let Some(target) = schema["$ref"].as_str().and_then(|path| self.schemas.get(path.rsplit('/').next()?)) {
            schema = target;
        }
        let has_null = |forms: &Vec<Value>| forms.iter().any(is_null);
        self.nodes[id].is_nullable = schema["type"].is_array() || schema["oneOf"].as_array().is_some_and(has_null);
        self.nodes[id].kind = self.kind(schema);
        id
    }

    fn kind(&mut self, schema: &'a Value) -> Kind {
        if let Some(forms) = schema["oneOf"].as_array() {
            let forms: Vec<Id> = forms.iter().filter(|form| !is_null(form)).map(|form| self.add(form)).collect();
            let tagged = forms.iter().filter_map(|id| Some((self.tag(*id)?, *id))).collect();
            return Kind::Union { tagged, forms };
        }
        if let Some(names) = schema["enum"].as_array() {
            return Kind::Names(names.iter().filter_map(Value::as_str).map(str::to_owned).collect());
        }
        let length = |keyword: &str| schema[keyword].as_u64().and_then(|count| count.try_into().ok());
        let bound = |keyword: &str| schema[keyword].as_f64();
        let kind = &schema["type"];
        let kind =
            kind.as_str().or_else(|| kind.as_array()?.iter().filter_map(Value::as_str).find(|one| *one != "null"));
        match kind {
            Some("object") => {
                let properties: Vec<(String, Id)> = schema["properties"]
                    .as_object()
                    .into_iter()
                    .flatten()
                    .map(|(name, value)| (name.clone(), self.add(value)))
                    .collect();
                assert!(properties.len() <= MOST_PROPERTIES, "a schema has more properties than can be checked");
                let required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
                let place = |name: &str| properties.iter().position(|(known, _)| known == name);
                let others = &schema["additionalProperties"];
                Kind::Object(Object {
                    required: required.filter_map(place).collect(),
                    others: others.is_object().then(|| self.add(others)),
                    properties,
                })
            }
            Some("array") => Kind::Array {
                entries: schema.get("items").map(|items| self.add(items)),
                lengths: [length("minItems"), length("maxItems")],
            },
            Some(kind @ ("number" | "integer")) => Kind::Number(Range {
                is_whole: kind == "integer",
                minimum: bound("minimum"),
                maximum: bound("maximum"),
                above: bound("exclusiveMinimum"),
                below: bound("exclusiveMaximum"),
                is_short: schema["format"] == "int32",
            }),
            Some("string") => {
                Kind::Text { is_uuid: schema["format"] == "uuid", lengths: [length("minLength"), length("maxLength")] }
            }
            Some("boolean") => Kind::Boolean,
            _ => Kind::Any,
        }
    }

    /// Returns the value of `type` that distinguishes an object from the others of its union.
    fn tag(&self, id: Id) -> Option<String> {
        let Kind::Object(Object { properties, .. }) = &self.nodes[id].kind else { return None };
        let (_, tag) = properties.iter().find(|(name, _)| name == "type")?;
        let Kind::Names(names) = &self.nodes[*tag].kind else { return None };
        names.first().cloned()
    }
}

/// Whether a form of a union is `null`.
fn is_null(form: &Value) -> bool {
    form["type"] == "null"
}
