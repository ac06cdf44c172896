//! All faults of a value, found by the schema of its type.
//!
//! serde stops at the first value that it refuses, and does not say where in a union that is. This
//! walk over the text builds nothing.

use std::{
    any::type_name,
    collections::{BTreeSet, HashMap},
    sync::{Arc, LazyLock, PoisonError, RwLock},
};

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    cursor::{Cursor, Syntax, Token},
    location::Location,
    reader::read,
    refusal::Refusal,
    wording::{BEYOND, no_such_field, one_of, shortened, unknown_name},
};
use crate::api::{
    contract,
    faults::{Fault, Faults},
};
use flankfit_engine::{
    estimation::spec,
    words::{Shown, counted},
};

/// Characters of an id with hyphens.
const UUID_LENGTH: usize = 36;
/// The form of ids.
const UUID: &str = "a UUID such as 0190b0de-0000-7000-8000-000000000000, in quotes";

/// Reads a value as a type whose fields depend on each other.
type Reads = fn(&[u8]) -> Option<Refusal>;

/// Types whose fields depend on each other and that occur within unions and arrays, by the names of
/// their schemas: each value is read by itself, so that the fault has its place.
const DEPENDENT: [(&str, Reads); 3] =
    [("Filter", reads::<spec::Filter>), ("Model", reads::<spec::Model>), ("Parameter", reads::<spec::Parameter>)];

fn reads<T: DeserializeOwned>(text: &[u8]) -> Option<Refusal> {
    read::<T>(text).err()
}

/// The schema of a type, and those that it refers to by their names.
pub type Schemas = Arc<(Value, Map<String, Value>)>;

/// Returns the schema of a type, which is made once.
pub fn schemas_of<T: ToSchema>() -> Schemas {
    static KNOWN: LazyLock<RwLock<HashMap<&str, Schemas>>> = LazyLock::new(RwLock::default);
    let name = type_name::<T>();
    if let Some(known) = KNOWN.read().unwrap_or_else(PoisonError::into_inner).get(name) {
        return known.clone();
    }
    let made = Arc::new(contract::schema_of::<T>());
    KNOWN.write().unwrap_or_else(PoisonError::into_inner).insert(name, made.clone());
    made
}

/// Returns the faults that the schema of `T` shows in a well-formed text.
pub fn check<T: ToSchema>(text: &[u8]) -> Faults {
    let known = schemas_of::<T>();
    let (schema, schemas) = &*known;
    check_by(schema, schemas, text)
}

/// Returns the faults of a member of an object, by the object's schema.
pub fn check_member((schema, schemas): &(Value, Map<String, Value>), name: &str, text: &[u8]) -> Faults {
    check_by(&schema["properties"][name], schemas, text)
}

fn check_by(schema: &Value, schemas: &Map<String, Value>, text: &[u8]) -> Faults {
    let mut check = Check { schemas, faults: Faults::default() };
    // the syntax has been checked before
    let _checked = check.value(&mut Cursor::new(text), schema, &Location::Root);
    check.faults
}

struct Check<'a> {
    schemas: &'a Map<String, Value>,
    faults: Faults,
}

impl<'a> Check<'a> {
    fn fault(&mut self, at: &Location, detail: String) {
        self.faults.push(at.pointer(), detail);
    }

    fn resolved(&self, schema: &'a Value) -> &'a Value {
        name_of(schema).and_then(|name| self.schemas.get(name)).map_or(schema, |schema| self.resolved(schema))
    }

    /// Checks the value at the cursor, and passes over it.
    fn value(&mut self, cursor: &mut Cursor, schema: &'a Value, at: &Location) -> Result<(), Syntax> {
        let reads = name_of(schema).and_then(|name| DEPENDENT.iter().find(|(known, _)| *known == name));
        let Some((_, reads)) = reads else { return self.resolved_value(cursor, self.resolved(schema), at) };
        let (mut whole, before) = (cursor.clone(), self.faults.count());
        self.resolved_value(cursor, self.resolved(schema), at)?;
        if self.faults.count() == before
            && let Some(refusal) = reads(whole.skip_value()?)
        {
            let fault = refusal.into_fault();
            self.faults.add(Fault { pointer: format!("{}{}", at.pointer(), fault.pointer), ..fault });
        }
        Ok(())
    }

    fn resolved_value(&mut self, cursor: &mut Cursor, schema: &'a Value, at: &Location) -> Result<(), Syntax> {
        let token = cursor.token()?;
        if let Some(alternatives) = schema["oneOf"].as_array() {
            return self.union(cursor, alternatives, token, at);
        }
        if let Some(names) = schema["enum"].as_array() {
            return self.name(cursor, &names_of(names), token, at);
        }
        match (kind_of(schema), token) {
            (Some("object"), Token::Object) => self.object(cursor, schema, at),
            (Some("array"), Token::Array) => self.array(cursor, schema, at),
            (Some("number" | "integer"), Token::Number) => self.number(cursor, schema, at),
            (Some("string"), Token::String) => {
                let text = cursor.string()?;
                if schema["format"] == "uuid" && (text.len() != UUID_LENGTH || Uuid::try_parse(&text).is_err()) {
                    self.fault(at, format!("expected {UUID}"));
                }
                self.length(text.chars().count(), schema, ["minLength", "maxLength"], ["a string", "character"], at);
                Ok(())
            }
            (Some("boolean"), Token::True | Token::False) | (None, _) => cursor.skip_value().map(drop),
            (_, Token::Null) if schema["type"].is_array() => cursor.skip_value().map(drop),
            _ => self.mismatch(cursor, &self.expected(schema), token, at),
        }
    }

    fn mismatch(&mut self, cursor: &mut Cursor, wanted: &str, token: Token, at: &Location) -> Result<(), Syntax> {
        let text = cursor.skip_value()?;
        let text = String::from_utf8_lossy(text);
        let found = match token {
            Token::String => format!("the string {}", shortened(&text)),
            Token::Number | Token::True | Token::False => shortened(&text).into_owned(),
            other => other.name().to_owned(),
        };
        self.fault(at, format!("expected {wanted}, found {found}"));
        Ok(())
    }

    /// The words for the values that a schema allows.
    fn expected(&self, schema: &'a Value) -> String {
        let schema = self.resolved(schema);
        if let Some(names) = schema["enum"].as_array() {
            return format!("{} in quotes", one_of(&names_of(names)));
        }
        match kind_of(schema) {
            Some("object") => "an object".to_owned(),
            Some("array") => match (&schema["minItems"], &schema["maxItems"]) {
                (Value::Number(least), Value::Number(most)) if least == most => format!("an array of {most} entries"),
                _ => "an array".to_owned(),
            },
            Some("integer") => match schema["minimum"].as_f64() {
                Some(minimum) => format!("a whole number of at least {}", Shown(minimum)),
                None => "a whole number".to_owned(),
            },
            Some(kind) => format!("a {kind}"),
            None => "a value".to_owned(),
        }
    }

    fn name(&mut self, cursor: &mut Cursor, names: &[&str], token: Token, at: &Location) -> Result<(), Syntax> {
        if token != Token::String {
            cursor.skip_value()?;
            self.fault(at, format!("expected {} in quotes, found {}", one_of(names), token.name()));
            return Ok(());
        }
        let name = cursor.string()?;
        if !names.contains(&&*name) {
            self.fault(at, unknown_name(&name, &one_of(names)));
        }
        Ok(())
    }

    fn number(&mut self, cursor: &mut Cursor, schema: &'a Value, at: &Location) -> Result<(), Syntax> {
        let begin = cursor.clone();
        let (number, text) = cursor.number_and_text()?;
        if number.is_infinite() {
            self.fault(at, BEYOND.to_owned());
            return Ok(());
        }
        let whole = kind_of(schema) == Some("integer");
        if whole && !text.iter().all(|byte| byte.is_ascii_digit() || *byte == b'-') {
            let wanted = format!("{} without decimal point and exponent", self.expected(schema));
            return self.mismatch(&mut begin.clone(), &wanted, Token::Number, at);
        }
        let text = std::str::from_utf8(text).unwrap_or_default();
        let kind = if whole { "a whole number" } else { "a number" };
        let bound = |keyword: &str| schema[keyword].as_f64();
        let wanted = match (bound("minimum"), bound("maximum")) {
            (Some(low), Some(high)) if number < low || number > high => {
                Some(format!("{kind} from {} to {}", Shown(low), Shown(high)))
            }
            (Some(low), _) if number < low => Some(format!("{kind} of at least {}", Shown(low))),
            (_, Some(high)) if number > high => Some(format!("{kind} of at most {}", Shown(high))),
            _ => match (bound("exclusiveMinimum"), bound("exclusiveMaximum")) {
                (Some(low), _) if number <= low => Some(format!("{kind} above {}", Shown(low))),
                (_, Some(high)) if number >= high => Some(format!("{kind} below {}", Shown(high))),
                _ if whole => out_of_range(schema, text),
                _ => None,
            },
        };
        if let Some(wanted) = wanted {
            let found = if whole { shortened(text).into_owned() } else { Shown(number).to_string() };
            self.fault(at, format!("expected {wanted}, found {found}"));
        }
        Ok(())
    }

    fn length(
        &mut self,
        length: usize,
        schema: &Value,
        keywords: [&str; 2],
        [kind, entry]: [&'static str; 2],
        at: &Location,
    ) {
        let [least, most] = keywords.map(|keyword| schema[keyword].as_u64().and_then(|count| count.try_into().ok()));
        if least.is_none_or(|least| length >= least) && most.is_none_or(|most| length <= most) {
            return;
        }
        let plural = if entry == "entry" { "entries" } else { "characters" };
        let wanted = match (least, most) {
            (Some(least), Some(most)) if least < most => format!("{least} to {most} {plural}"),
            (Some(least), None) => format!("at least {}", counted(least, entry, plural)),
            (None, Some(most)) => format!("at most {}", counted(most, entry, plural)),
            _ => counted(least.unwrap_or_default(), entry, plural).to_string(),
        };
        self.fault(at, format!("expected {kind} of {wanted}, found {}", counted(length, entry, plural)));
    }

    fn array(&mut self, cursor: &mut Cursor, schema: &'a Value, at: &Location) -> Result<(), Syntax> {
        let mut length = 0;
        cursor.array(|cursor, index| {
            length = index + 1;
            match &schema["items"] {
                Value::Null => cursor.skip_value().map(drop),
                items => self.value(cursor, items, &Location::Entry(at, index)),
            }
        })?;
        self.length(length, schema, ["minItems", "maxItems"], ["an array", "entry"], at);
        Ok(())
    }

    fn object(&mut self, cursor: &mut Cursor, schema: &'a Value, at: &Location) -> Result<(), Syntax> {
        let known: Vec<(&'a str, &'a Value)> =
            schema["properties"].as_object().into_iter().flatten().map(|(name, value)| (&**name, value)).collect();
        let mut seen: BTreeSet<String> = BTreeSet::new();
        cursor.object(|cursor, name| {
            let at = Location::Member(at, &name);
            let property = known.iter().find(|(known, _)| *known == name).map(|(_, property)| *property);
            let is_null = cursor.token()? == Token::Null;
            match (property, &schema["additionalProperties"]) {
                // counts as absent
                (Some(_), _) | (None, Value::Object(_)) if is_null => cursor.skip_value().map(drop),
                (Some(property), _) | (None, property @ Value::Object(_)) => {
                    if seen.insert(name.clone().into_owned()) {
                        return self.value(cursor, property, &at);
                    }
                    self.fault(&at, "the field occurs twice; give it once".to_owned());
                    cursor.skip_value().map(drop)
                }
                _ => {
                    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
                    let pointer = at.pointer();
                    self.faults.push_with(pointer, || no_such_field(&name, &names));
                    cursor.skip_value().map(drop)
                }
            }
        })?;
        for name in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            if !seen.contains(name) {
                self.faults.push_missing(Location::Member(at, name).pointer(), "missing");
            }
        }
        Ok(())
    }

    /// A value of several forms: objects are distinguished by their `type`, others by their kind.
    fn union(
        &mut self,
        cursor: &mut Cursor,
        alternatives: &'a [Value],
        token: Token,
        at: &Location,
    ) -> Result<(), Syntax> {
        let alternatives: Vec<&'a Value> = alternatives.iter().map(|one| self.resolved(one)).collect();
        let tag = |one: &'a Value| self.resolved(&one["properties"]["type"])["enum"][0].as_str();
        let tagged: Vec<(&'a str, &'a Value)> = alternatives.iter().filter_map(|one| Some((tag(one)?, *one))).collect();
        if token == Token::Object && !tagged.is_empty() {
            return self.tagged(cursor, &tagged, at);
        }
        let fits = |one: &&&'a Value| match (kind_of(one), token) {
            (Some("array"), Token::Array) => {
                let nested = entry_token(cursor) == Some(Token::Array);
                (self.resolved(&one["items"])["type"] == "array") == nested
            }
            (Some("object"), Token::Object)
            | (Some("number" | "integer"), Token::Number)
            | (Some("string"), Token::String)
            | (Some("boolean"), Token::True | Token::False) => true,
            _ => false,
        };
        match alternatives.iter().find(fits) {
            Some(one) => self.value(cursor, one, at),
            None => {
                let mut wanted: Vec<String> = alternatives.iter().map(|one| self.expected(one)).collect();
                wanted.dedup();
                self.mismatch(cursor, &wanted.join(" or "), token, at)
            }
        }
    }

    fn tagged(&mut self, cursor: &mut Cursor, tagged: &[(&'a str, &'a Value)], at: &Location) -> Result<(), Syntax> {
        let names: Vec<&str> = tagged.iter().map(|(name, _)| *name).collect();
        let (mut found, mut within) = (None, cursor.clone());
        within.object(|cursor, name| {
            if name == "type" && found.is_none() {
                found = Some((cursor.clone(), cursor.token()?));
            }
            cursor.skip_value().map(drop)
        })?;
        let place = Location::Member(at, "type");
        let Some((mut kind, token)) = found.filter(|(_, token)| *token != Token::Null) else {
            self.faults.push_missing(place.pointer(), "missing");
            return cursor.skip_value().map(drop);
        };
        let mut look = kind.clone();
        let one = match token {
            Token::String => {
                let name = look.string()?;
                tagged.iter().find(|(tag, _)| *tag == name).map(|(_, one)| *one)
            }
            _ => None,
        };
        match one {
            Some(one) => self.object(cursor, one, at),
            // the fields of no alternative are known
            None => {
                self.name(&mut kind, &names, token, &place)?;
                cursor.skip_value().map(drop)
            }
        }
    }
}

/// Returns the type of values that are not `null`.
fn kind_of(schema: &Value) -> Option<&str> {
    let kind = &schema["type"];
    kind.as_str().or_else(|| kind.as_array()?.iter().filter_map(Value::as_str).find(|kind| *kind != "null"))
}

/// Returns the range of an integer type that does not hold a number.
fn out_of_range(schema: &Value, text: &str) -> Option<String> {
    let unsigned = schema["minimum"].as_f64().is_some_and(|minimum| minimum >= 0.0);
    let (low, high) = match (schema["format"].as_str(), unsigned) {
        (Some("int32"), true) => (0, i128::from(u32::MAX)),
        (Some("int32"), false) => (i128::from(i32::MIN), i128::from(i32::MAX)),
        (_, true) => (0, i128::from(u64::MAX)),
        (_, false) => (i128::from(i64::MIN), i128::from(i64::MAX)),
    };
    let holds = text.parse().is_ok_and(|number: i128| (low..=high).contains(&number));
    (!holds).then(|| format!("a whole number from {low} to {high}"))
}

/// The name of the schema that is referred to.
fn name_of(schema: &Value) -> Option<&str> {
    schema["$ref"].as_str()?.rsplit('/').next()
}

fn names_of(names: &[Value]) -> Vec<&str> {
    names.iter().filter_map(Value::as_str).collect()
}

/// The kind of an array's first entry.
fn entry_token(cursor: &Cursor) -> Option<Token> {
    let mut within = cursor.clone();
    within.takes(b'[').then(|| within.token().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;

    use super::*;
    use crate::api::{gears::design::profile::ToolMotionBody, jobs::job::NewJobBody, json::value::read_value};

    fn of<T: DeserializeOwned + ToSchema>(text: &str) -> Vec<String> {
        let mut faults = Faults::default();
        assert!(read_value::<T>(text.as_bytes(), "", &mut faults).is_none(), "{text}");
        let mut found: Vec<String> = faults.list().iter().map(|fault| fault.pointer.clone()).collect();
        found.sort_unstable();
        found
    }

    fn pointers(text: &str) -> Vec<String> {
        of::<NewJobBody>(text)
    }

    #[test]
    fn every_fault_is_found_once() {
        assert_eq!(pointers("[]"), [""]);
        assert_eq!(pointers("{}"), ["/name"]);
        assert_eq!(pointers(r#"{"name":"w","gear":[]}"#), ["/gear"]);
        let gear = r#"{"teeth":0,"helix_angle_deg":91,"tool":{"tip_radius_mm":-1},"x/y":1}"#;
        assert_eq!(
            pointers(&format!(r#"{{"name":5,"gear":{gear},"machine":1}}"#)),
            [
                "/gear/helix_angle_deg",
                "/gear/normal_module_mm",
                "/gear/teeth",
                "/gear/tool/tip_radius_mm",
                "/gear/x~1y",
                "/machine",
                "/name",
            ]
        );
        assert_eq!(
            pointers(r#"{"gear":{},"tags":{"a":1,"b":"x","c":2}}"#),
            ["/gear/normal_module_mm", "/gear/teeth", "/name", "/tags/a", "/tags/c"]
        );
        assert_eq!(pointers(r#"{"name":"w","name":"v","gear":7}"#), ["/gear", "/name"]);
        // the first of two may be wrong by itself
        assert_eq!(pointers(r#"{"name":5,"name":"v","gear":7}"#), ["/gear", "/name", "/name"]);
        assert_eq!(
            pointers(r#"{"gear":{"teeth":0,"teeth":20,"normal_module_mm":1}}"#),
            ["/gear/teeth", "/gear/teeth", "/name"]
        );
    }

    #[test]
    fn entries_of_arrays_are_named_by_the_places_that_they_have() {
        assert_eq!(of::<Vec<u8>>(r#"["a",1,2,"b",3,-1,"c"]"#), ["/0", "/3", "/5", "/6"]);
        assert_eq!(of::<Vec<Vec<bool>>>("[[true,1],[2],[true],7,[1,true,0]]"), ["/0/1", "/1/0", "/3", "/4/0", "/4/2"]);
        assert_eq!(
            pointers(r#"{"name":1,"tags":{"a":[1]},"gear":{"teeth":[]}}"#),
            ["/gear/normal_module_mm", "/gear/teeth", "/name", "/tags/a"]
        );
    }

    #[test]
    fn the_type_of_a_union_is_a_name() {
        let of = |text: &str| of::<ToolMotionBody>(text);
        for wrong in ["0", "1", "2.5", "true", "[]", r#"["rack"]"#, r#"{"rack":1}"#, r#""worm""#] {
            assert_eq!(of(&format!(r#"{{"type":{wrong},"pitch_radius_mm":26}}"#)), ["/type"], "{wrong}");
        }
        assert_eq!(of("{}"), ["/type"]);
        // fields of a union of which nobody knows which one it is are not called unknown
        assert_eq!(of(r#"{"pitch_radius_mm":26,"internal":true}"#), ["/type"]);
        for array in ["[]", "[0]", "[0,26]", r#"["rack",26]"#, r#"["rack",{"pitch_radius_mm":26}]"#, "[[]]"] {
            assert_eq!(of(array), [""], "{array}");
        }
        let two = r#"[{"type":1,"pitch_radius_mm":26},["rack",26],{"pitch_radius_mm":26},{"type":"rack"}]"#;
        assert_eq!(super::tests::of::<Vec<ToolMotionBody>>(two), ["/0/type", "/1", "/2/type", "/3/pitch_radius_mm"]);
    }

    #[test]
    fn it_ends_whatever_is_sent() {
        let many: String = (0..500).map(|i| format!(r#","k{i}":1"#)).collect();
        assert_eq!(pointers(&format!(r#"{{"name":1{many}}}"#)).len(), Faults::MOST);
        let long = "x".repeat(100_000);
        assert_eq!(pointers(&format!(r#"{{"name":1,"gear":2,"machine":"{long}"}}"#)), ["/gear", "/machine", "/name"]);
    }
}
