//! All errors of a value, found by the schema of its type.
//!
//! serde stops at the first value that it refuses, and does not say where in a union that is. This
//! walk over the text builds nothing.

use std::{
    any::type_name,
    collections::{BTreeSet, HashMap},
    sync::{Arc, LazyLock, PoisonError, RwLock},
};

use serde::Deserialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{
    compiled::{Compiled, Id, Kind, Lengths, MOST_PROPERTIES, Node, Object, Range},
    cursor::{Cursor, Syntax, Token},
    location::Location,
    reader::read,
    wording::{BEYOND, no_such_field, one_of, shortened, unknown_name},
};
use crate::api::{contract, faults::Faults};
use flankfit_engine::words::{Shown, counted};

/// Characters of an id with hyphens.
const UUID_LENGTH: usize = 36;
/// The form of ids.
const UUID: &str = "a UUID such as 0190b0de-0000-7000-8000-000000000000, in quotes";

/// Returns the schema of a type, which is compiled once.
pub fn schema_of<T: ToSchema>() -> Arc<Compiled> {
    static KNOWN: LazyLock<RwLock<HashMap<&str, Arc<Compiled>>>> = LazyLock::new(RwLock::default);
    let name = type_name::<T>();
    if let Some(known) = KNOWN.read().unwrap_or_else(PoisonError::into_inner).get(name) {
        return known.clone();
    }
    let (schema, schemas) = contract::schema_of::<T>();
    let compiled = Arc::new(Compiled::new(&schema, &schemas));
    KNOWN.write().unwrap_or_else(PoisonError::into_inner).insert(name, compiled.clone());
    compiled
}

/// Reads a well-formed value that has this schema, or adds all errors, below `pointer`.
pub fn read_by<'de, T: Deserialize<'de>>(
    schema: &Compiled,
    id: Option<Id>,
    text: &'de [u8],
    pointer: &str,
    faults: &mut Faults,
) -> Option<T> {
    let found = |parts| id.map_or_else(Faults::default, |id| found(schema, id, text, parts));
    let refusal = if found(false).is_empty() {
        match read(text) {
            Ok(value) => return Some(value),
            Err(refusal) => Some(refusal),
        }
    } else {
        None
    };
    let all = found(true);
    faults.append(match refusal.filter(|_| all.is_empty()) {
        Some(refusal) => refusal.faults(pointer),
        None => all.within(pointer),
    });
    None
}

/// Returns the errors that a schema shows in a text; with `parts` also those that only reading a
/// part by its type shows.
fn found(schema: &Compiled, id: Id, text: &[u8], parts: bool) -> Faults {
    let mut check = Check { schema, parts, faults: Faults::default() };
    // The syntax has been checked before, and the value as a whole is read by its type afterwards.
    let _checked = check.shape(&mut Cursor::new(text), schema.node(id), &Location::Root);
    check.faults
}

struct Check<'a> {
    schema: &'a Compiled,
    parts: bool,
    faults: Faults,
}

impl<'a> Check<'a> {
    fn fault(&mut self, at: &Location, detail: String) {
        self.faults.push(at.pointer(), detail);
    }

    /// Checks the value at the cursor, and passes over it.
    fn value(&mut self, cursor: &mut Cursor, id: Id, at: &Location) -> Result<(), Syntax> {
        let node = self.schema.node(id);
        let Some(reads) = node.reads.filter(|_| self.parts) else { return self.shape(cursor, node, at) };
        let (mut whole, before) = (cursor.clone(), self.faults.count());
        self.shape(cursor, node, at)?;
        if self.faults.count() == before
            && let Some(refusal) = reads(whole.skip_value()?)
        {
            self.faults.append(refusal.faults(&at.pointer()));
        }
        Ok(())
    }

    fn shape(&mut self, cursor: &mut Cursor, node: &'a Node, at: &Location) -> Result<(), Syntax> {
        let token = cursor.token()?;
        match (&node.kind, token) {
            (Kind::Union { .. }, Token::Null) if node.is_nullable => cursor.skip_value().map(drop),
            (Kind::Union { tagged, forms }, _) => self.union(cursor, tagged, forms, token, at),
            (Kind::Names(names), _) => self.name(cursor, names, token, at),
            (Kind::Object(object), Token::Object) => self.object(cursor, object, at),
            (Kind::Array { entries, lengths }, Token::Array) => self.array(cursor, *entries, *lengths, at),
            (Kind::Number(range), Token::Number) => self.number(cursor, node, range, at),
            (Kind::Text { is_uuid, lengths }, Token::String) => {
                let text = cursor.string()?;
                if *is_uuid && (text.len() != UUID_LENGTH || Uuid::try_parse(&text).is_err()) {
                    self.fault(at, format!("expected {UUID}"));
                }
                self.length(text.chars().count(), *lengths, ["a string", "character"], at);
                Ok(())
            }
            (Kind::Boolean, Token::True | Token::False) | (Kind::Any, _) => cursor.skip_value().map(drop),
            (_, Token::Null) if node.is_nullable => cursor.skip_value().map(drop),
            _ => self.mismatch(cursor, &self.expected(node), token, at),
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

    /// Returns the words for the values that a schema allows.
    fn expected(&self, node: &Node) -> String {
        match &node.kind {
            Kind::Names(names) => format!("{} in quotes", one_of(&borrowed(names))),
            Kind::Object(_) => "an object".to_owned(),
            Kind::Array { lengths: [Some(least), Some(most)], .. } if least == most => {
                format!("an array of {most} entries")
            }
            Kind::Array { .. } => "an array".to_owned(),
            Kind::Number(Range { is_whole: true, minimum: Some(minimum), .. }) => {
                format!("a whole number of at least {}", Shown(*minimum))
            }
            Kind::Number(Range { is_whole: true, .. }) => "a whole number".to_owned(),
            Kind::Number(_) => "a number".to_owned(),
            Kind::Text { .. } => "a string".to_owned(),
            Kind::Boolean => "a boolean".to_owned(),
            Kind::Union { .. } | Kind::Any => "a value".to_owned(),
        }
    }

    fn name(&mut self, cursor: &mut Cursor, names: &[String], token: Token, at: &Location) -> Result<(), Syntax> {
        if token != Token::String {
            cursor.skip_value()?;
            self.fault(at, format!("expected {} in quotes, found {}", one_of(&borrowed(names)), token.name()));
            return Ok(());
        }
        let name = cursor.string()?;
        if !names.iter().any(|known| *known == name) {
            self.fault(at, unknown_name(&name, &borrowed(names)));
        }
        Ok(())
    }

    fn number(&mut self, cursor: &mut Cursor, node: &Node, range: &Range, at: &Location) -> Result<(), Syntax> {
        let begin = cursor.clone();
        let (number, text) = cursor.number_and_text()?;
        if number.is_infinite() {
            self.fault(at, BEYOND.to_owned());
            return Ok(());
        }
        let whole = range.is_whole;
        if whole && !text.iter().all(|byte| byte.is_ascii_digit() || *byte == b'-') {
            let wanted = format!("{} without decimal point and exponent", self.expected(node));
            return self.mismatch(&mut begin.clone(), &wanted, Token::Number, at);
        }
        let text = std::str::from_utf8(text).unwrap_or_default();
        let kind = if whole { "a whole number" } else { "a number" };
        let wanted = match (range.minimum, range.maximum) {
            (Some(low), Some(high)) if number < low || number > high => {
                Some(format!("{kind} from {} to {}", Shown(low), Shown(high)))
            }
            (Some(low), _) if number < low => Some(format!("{kind} of at least {}", Shown(low))),
            (_, Some(high)) if number > high => Some(format!("{kind} of at most {}", Shown(high))),
            _ => match (range.above, range.below) {
                (Some(low), _) if number <= low => Some(format!("{kind} above {}", Shown(low))),
                (_, Some(high)) if number >= high => Some(format!("{kind} below {}", Shown(high))),
                _ if whole => out_of_range(range, text),
                _ => None,
            },
        };
        if let Some(wanted) = wanted {
            let found = if whole { shortened(text).into_owned() } else { Shown(number).to_string() };
            self.fault(at, format!("expected {wanted}, found {found}"));
        }
        Ok(())
    }

    fn length(&mut self, length: usize, [least, most]: Lengths, [kind, entry]: [&'static str; 2], at: &Location) {
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

    fn array(
        &mut self,
        cursor: &mut Cursor,
        entries: Option<Id>,
        lengths: Lengths,
        at: &Location,
    ) -> Result<(), Syntax> {
        let mut length = 0;
        cursor.array(|cursor, index| {
            length = index + 1;
            match entries {
                None => cursor.skip_value().map(drop),
                Some(id) => self.value(cursor, id, &Location::Entry(at, index)),
            }
        })?;
        self.length(length, lengths, ["an array", "entry"], at);
        Ok(())
    }

    fn object(&mut self, cursor: &mut Cursor, object: &'a Object, at: &Location) -> Result<(), Syntax> {
        let Object { properties, others, required } = object;
        let mut seen = [false; MOST_PROPERTIES];
        let mut other_names = BTreeSet::new();
        cursor.object(|cursor, name| {
            let at = Location::Member(at, &name);
            let place = properties.iter().position(|(known, _)| *known == name);
            let Some(id) = place.map(|place| properties[place].1).or(*others) else {
                let pointer = at.pointer();
                let names: Vec<&str> = properties.iter().map(|(name, _)| &**name).collect();
                self.faults.push_with(pointer, || no_such_field(&name, &names));
                return cursor.skip_value().map(drop);
            };
            // `null` counts as absent
            if cursor.token()? == Token::Null {
                return cursor.skip_value().map(drop);
            }
            let is_new = match place {
                Some(place) => !std::mem::replace(&mut seen[place], true),
                None => other_names.insert(name.clone().into_owned()),
            };
            if is_new {
                return self.value(cursor, id, &at);
            }
            self.fault(&at, "the field occurs twice; give it once".to_owned());
            cursor.skip_value().map(drop)
        })?;
        for place in required.iter().filter(|place| !seen[**place]) {
            self.faults.push_missing(Location::Member(at, &properties[*place].0).pointer(), "required");
        }
        Ok(())
    }

    /// Checks a value of several forms: objects are distinguished by their `type`, others by their
    /// kind.
    fn union(
        &mut self,
        cursor: &mut Cursor,
        tagged: &'a [(String, Id)],
        forms: &'a [Id],
        token: Token,
        at: &Location,
    ) -> Result<(), Syntax> {
        if token == Token::Object && !tagged.is_empty() {
            return self.tagged(cursor, tagged, at);
        }
        if let [only] = forms {
            return self.value(cursor, *only, at);
        }
        let node = |id: &Id| self.schema.node(*id);
        let fits = |id: &&Id| match (&node(id).kind, token) {
            (Kind::Array { entries, .. }, Token::Array) => {
                let is_nested = entry_token(cursor) == Some(Token::Array);
                entries.as_ref().is_some_and(|id| matches!(node(id).kind, Kind::Array { .. })) == is_nested
            }
            (Kind::Object(_), Token::Object)
            | (Kind::Number(_), Token::Number)
            | (Kind::Text { .. } | Kind::Names(_), Token::String)
            | (Kind::Boolean, Token::True | Token::False) => true,
            _ => false,
        };
        match forms.iter().find(fits) {
            Some(id) => self.shape(cursor, node(id), at),
            None => {
                let mut wanted: Vec<String> = forms.iter().map(|id| self.expected(node(id))).collect();
                wanted.dedup();
                self.mismatch(cursor, &wanted.join(" or "), token, at)
            }
        }
    }

    fn tagged(&mut self, cursor: &mut Cursor, tagged: &'a [(String, Id)], at: &Location) -> Result<(), Syntax> {
        let place = Location::Member(at, "type");
        let found = cursor.member("type").and_then(|mut kind| Some((kind.token().ok()?, kind)));
        let Some((token, mut kind)) = found.filter(|(token, _)| *token != Token::Null) else {
            self.faults.push_missing(place.pointer(), "required");
            return cursor.skip_value().map(drop);
        };
        let mut look = kind.clone();
        let one = match token {
            Token::String => {
                let name = look.string()?;
                tagged.iter().find(|(tag, _)| *tag == name).map(|(_, id)| *id)
            }
            _ => None,
        };
        match one {
            Some(id) => self.shape(cursor, self.schema.node(id), at),
            // the fields of no form are known
            None => {
                let names: Vec<String> = tagged.iter().map(|(name, _)| name.clone()).collect();
                self.name(&mut kind, &names, token, &place)?;
                cursor.skip_value().map(drop)
            }
        }
    }
}

/// Returns the range of an integer type that does not hold a number.
fn out_of_range(range: &Range, text: &str) -> Option<String> {
    let unsigned = range.minimum.is_some_and(|minimum| minimum >= 0.0);
    let (low, high) = match (range.is_short, unsigned) {
        (true, true) => (0, i128::from(u32::MAX)),
        (true, false) => (i128::from(i32::MIN), i128::from(i32::MAX)),
        (false, true) => (0, i128::from(u64::MAX)),
        (false, false) => (i128::from(i64::MIN), i128::from(i64::MAX)),
    };
    let holds = text.parse().is_ok_and(|number: i128| (low..=high).contains(&number));
    (!holds).then(|| format!("a whole number from {low} to {high}"))
}

fn borrowed(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

/// Returns the kind of an array's first entry.
fn entry_token(cursor: &Cursor) -> Option<Token> {
    let mut within = cursor.clone();
    within.takes(b'[').then(|| within.token().ok()).flatten()
}
