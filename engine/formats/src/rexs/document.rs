//! The parts of a REXS document that a gear is made of: components with their attributes, and
//! relations.

use quick_xml::{
    Reader, XmlVersion,
    events::{BytesStart, Event},
};

use super::{
    super::{
        file_error::{FileError, FilePosition, shown},
        source::{number, place_in},
    },
    base64::Code,
};
use flankfit_numerics::cancel;

/// Elements within one another; REXS has seven.
pub(super) const DEEPEST: usize = 32;

/// Gears that are read.
pub(super) const GEARS: [&str; 2] = ["cylindrical_gear", "ring_gear"];

/// Other components that are kept: flanks (`flank_geometry` up to REXS 1.2) and their measured
/// traces.
const PARTS: [&str; 4] = ["cylindrical_gear_flank", "flank_geometry", "profile_deviation", "helix_deviation"];

/// Relations that are kept: of a gear with its flanks, and of a flank with its traces.
const RELATIONS: [&str; 2] = ["flank", "reference"];

/// Attributes that are kept, with other spellings of versions and tools.
const ATTRIBUTES: [&str; 23] = [
    "number_of_teeth",
    "normal_module",
    "normal_pressure_angle",
    "helix_angle_reference_diameter",
    "helix_angle",
    "profile_shift_coefficient",
    "addendum_modification_coefficient",
    "face_width",
    "facewidth",
    "tip_diameter",
    "root_diameter",
    "topographical_deviation_amounts",
    "diameters_of_topographical_deviation",
    "diameters_of_topographical_deviations",
    "coordinates_of_topographical_deviation",
    "coordinates_of_topographical_deviations",
    "profile_deviation_amounts",
    "diameters_of_profile_deviation",
    "length_of_profile_deviation",
    "position_of_profile_deviation",
    "helix_deviation_amounts",
    "coordinates_of_helix_deviation",
    "diameter_of_helix_deviation",
];

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Array(Vec<f64>),
    Matrix { columns: usize, values: Vec<f64> },
}

#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub id: String,
    pub unit: String,
    pub value: Value,
    /// Offset at which its element begins.
    pub offset: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Component {
    pub id: String,
    pub kind: String,
    pub name: Option<String>,
    pub attributes: Vec<Attribute>,
    pub offset: usize,
}

impl Attribute {
    /// True if an attribute of this id is read.
    pub(crate) fn is_kept(id: &str) -> bool {
        ATTRIBUTES.contains(&id)
    }
}

impl Component {
    /// True if a component of this type is read.
    pub(crate) fn is_kept(kind: &str) -> bool {
        GEARS.contains(&kind) || PARTS.contains(&kind)
    }

    /// The first attribute that has one of these names.
    pub(crate) fn attribute(&self, names: &[&str]) -> Option<&Attribute> {
        names.iter().find_map(|name| self.attributes.iter().find(|attribute| attribute.id == *name))
    }
}

/// A relation: role and component of each part.
#[derive(Clone, Debug, Default)]
pub(super) struct Relation {
    pub kind: String,
    pub parts: Vec<(String, String)>,
}

impl Relation {
    /// Returns the component in a role.
    pub(crate) fn part(&self, role: &str) -> Option<&str> {
        self.parts.iter().find(|(name, _)| name == role).map(|(_, id)| id.as_str())
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Document {
    pub version: String,
    pub components: Vec<Component>,
    pub relations: Vec<Relation>,
}

impl Document {
    /// Takes the version of the model, if it is one that is read.
    pub(crate) fn set_version(&mut self, version: &str, place: FilePosition) -> Result<(), FileError> {
        if version.is_empty() {
            let (expected, found) = ("a model with its version", "nothing".into());
            return Err(FileError::Expected { place, expected, found });
        }
        if !["1", "2"].contains(&version.split('.').next().unwrap_or_default()) {
            let what = format!("REXS version {}; versions 1.x and 2.x are read", shown(version));
            return Err(FileError::Unsupported { place, what });
        }
        self.version = version.to_owned();
        Ok(())
    }

    /// Takes a relation of a kind that is read.
    pub(crate) fn push(&mut self, relation: Relation) {
        if RELATIONS.contains(&relation.kind.as_str()) {
            self.relations.push(relation);
        }
    }

    pub(crate) fn parse(text: &str) -> Result<Self, FileError> {
        let mut parser = Parser {
            text,
            document: Document::default(),
            depth: 0,
            in_components: false,
            relation: None,
            component: None,
            attribute: None,
        };
        let mut reader = Reader::from_str(text);
        loop {
            cancel::checkpoint();
            let start = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|fault| FileError::Xml {
                place: place_in(text, reader.error_position() as usize),
                detail: fault.to_string(),
            })?;
            match event {
                Event::Start(element) => {
                    parser.open(&element, start)?;
                    parser.depth += 1;
                    if parser.depth > DEEPEST {
                        return Err(FileError::TooMany {
                            place: place_in(text, start),
                            what: "elements within one another",
                            most: DEEPEST,
                        });
                    }
                }
                Event::Empty(element) => {
                    parser.open(&element, start)?;
                    parser.close(element.local_name().as_ref(), start)?;
                }
                Event::End(element) => {
                    parser.depth = parser.depth.saturating_sub(1);
                    parser.close(element.local_name().as_ref(), start)?;
                }
                Event::Text(piece) => parser.add(&piece.xml10_content()),
                Event::CData(piece) => parser.add(&piece.into_inner()),
                Event::GeneralRef(reference) => {
                    let name = reference.xml10_content();
                    let c = match name.as_ref() {
                        "lt" => Some('<'),
                        "gt" => Some('>'),
                        "amp" => Some('&'),
                        "apos" => Some('\''),
                        "quot" => Some('"'),
                        _ => reference.resolve_char_ref().ok().flatten(),
                    };
                    let c = c.ok_or_else(|| FileError::Unsupported {
                        place: place_in(text, start),
                        what: format!("the entity {}; only those of XML itself are known", shown(&name)),
                    })?;
                    parser.add(c.encode_utf8(&mut [0; 4]));
                }
                Event::DocType(_) => {
                    return Err(FileError::Unsupported {
                        place: place_in(text, start),
                        what: "a document type definition; REXS has none".into(),
                    });
                }
                Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
                Event::Eof => break,
            }
        }
        if parser.depth > 0 || parser.document.version.is_empty() {
            let (place, expected) = (place_in(text, text.len()), "the end of the element model");
            return Err(FileError::Expected { place, expected, found: "the end of the file".into() });
        }
        Ok(parser.document)
    }
}

/// State of parsing: the open elements.
struct Parser<'a> {
    text: &'a str,
    document: Document,
    depth: usize,
    in_components: bool,
    relation: Option<Relation>,
    component: Option<Component>,
    attribute: Option<Open>,
}

/// An attribute whose value is being read.
struct Open {
    id: String,
    unit: String,
    offset: usize,
    /// Text since the last element began.
    text: String,
    text_offset: usize,
    list: bool,
    code: Option<Code>,
    values: Vec<f64>,
    /// Columns of a matrix: of its rows so far, or as it says itself.
    columns: Option<usize>,
    row_start: usize,
}

impl Parser<'_> {
    fn place(&self, offset: usize) -> FilePosition {
        place_in(self.text, offset)
    }

    fn expected(&self, offset: usize, expected: &'static str, found: &str) -> FileError {
        FileError::Expected { place: self.place(offset), expected, found: shown(found) }
    }

    fn open(&mut self, element: &BytesStart, offset: usize) -> Result<(), FileError> {
        let name = element.local_name();
        let get = |key: &str| -> Result<Option<String>, FileError> {
            let fault = |detail: String| FileError::Xml { place: self.place(offset), detail };
            let attribute = element.try_get_attribute(key).map_err(|e| fault(e.to_string()))?;
            let value = attribute.map(|a| a.normalized_value(XmlVersion::Implicit1_0).map(String::from));
            value.transpose().map_err(|e| fault(e.to_string()))
        };
        match (self.depth, name.as_ref()) {
            (0, "model") if self.document.version.is_empty() => {
                let (version, place) = (get("version")?.unwrap_or_default(), self.place(offset));
                self.document.set_version(&version, place)?;
            }
            (0, "model") => return Err(self.expected(offset, "one element model", "another one")),
            (0, other) => {
                let small = other.to_lowercase();
                let what = match () {
                    () if small.starts_with("qif") => "a QIF document, which is not read".into(),
                    () if small.starts_with("gde") || small.contains("geardataexchange") => {
                        "a GDE document (VDI/VDE 2610), which is not read".into()
                    }
                    () => format!("a document of {}; of XML files only REXS (`model`) is read", shown(other)),
                };
                return Err(FileError::Unsupported { place: self.place(offset), what });
            }
            (1, "components") => self.in_components = true,
            (2, "relation") => {
                self.relation = Some(Relation { kind: get("type")?.unwrap_or_default(), parts: Vec::new() });
            }
            (3, "ref") if self.relation.is_some() => {
                let part = (get("role")?.unwrap_or_default(), get("id")?.unwrap_or_default());
                self.relation.iter_mut().for_each(|relation| relation.parts.push(part.clone()));
            }
            (2, "component") if self.in_components => {
                let kind = get("type")?.unwrap_or_default();
                if Component::is_kept(&kind) {
                    let id = get("id")?.ok_or_else(|| self.expected(offset, "a component with an id", &kind))?;
                    let name = get("name")?;
                    self.component = Some(Component { id, kind, name, attributes: Vec::new(), offset });
                }
            }
            (3, "attribute") if self.component.is_some() => {
                let id = get("id")?.unwrap_or_default();
                if Attribute::is_kept(&id) {
                    let unit = get("unit")?.unwrap_or_default();
                    self.attribute = Some(Open {
                        id,
                        unit,
                        offset,
                        text: String::new(),
                        text_offset: offset,
                        list: false,
                        code: None,
                        values: Vec::new(),
                        columns: None,
                        row_start: 0,
                    });
                }
            }
            (_, list @ ("array" | "matrix")) if self.attribute.is_some() => {
                let code = get("code")?;
                let coded = code.as_deref().map(|code| {
                    Code::named(code).ok_or_else(|| self.expected(offset, "the code int32, float32 or float64", code))
                });
                let coded = coded.transpose()?;
                let columns =
                    get("columns")?.and_then(|columns| columns.trim().parse().ok()).filter(|columns| *columns > 0);
                if let Some(open) = &mut self.attribute {
                    (open.list, open.code, open.text_offset) = (true, coded, offset);
                    open.text.clear();
                    if list == "matrix" {
                        open.columns = columns;
                    }
                }
            }
            (_, "c") => {
                if let Some(open) = &mut self.attribute {
                    open.text.clear();
                    open.text_offset = offset;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn add(&mut self, text: &str) {
        if let Some(open) = &mut self.attribute {
            open.text.push_str(text);
        }
    }

    /// The element that ends; `depth` is already that of its parent.
    fn close(&mut self, name: &str, offset: usize) -> Result<(), FileError> {
        match (self.depth, name) {
            (1, "components") => self.in_components = false,
            (2, "relation") => self.relation.take().into_iter().for_each(|relation| self.document.push(relation)),
            (2, "component") => self.document.components.extend(self.component.take()),
            (3, "attribute") => {
                if let (Some(open), Some(component)) = (self.attribute.take(), &mut self.component) {
                    component.attributes.push(open.finish());
                }
            }
            (_, "c" | "r" | "array" | "matrix") => {
                let Some(open) = &mut self.attribute else { return Ok(()) };
                let fault = match name {
                    "c" => open.take_number(),
                    "r" => open.take_row(),
                    _ => open.take_coded(),
                };
                let (at, found) = (open.text_offset, open.text.clone());
                fault.map_err(|expected| {
                    self.expected(if expected.contains("columns") { offset } else { at }, expected, &found)
                })?;
            }
            _ => {}
        }
        Ok(())
    }
}

impl Open {
    fn take_number(&mut self) -> Result<(), &'static str> {
        let text = self.text.trim();
        let value = if text.eq_ignore_ascii_case("nan") { Some(f64::NAN) } else { number(text) };
        self.values.push(value.ok_or("a number")?);
        self.text.clear();
        Ok(())
    }

    fn take_row(&mut self) -> Result<(), &'static str> {
        let columns = self.values.len() - self.row_start;
        self.row_start = self.values.len();
        if *self.columns.get_or_insert(columns) != columns { Err("rows of the same number of columns") } else { Ok(()) }
    }

    fn take_coded(&mut self) -> Result<(), &'static str> {
        if let Some(code) = self.code.take() {
            self.values = code.numbers(&self.text).ok_or("numbers of that code in base64")?;
            if self.columns.is_some_and(|columns| !self.values.len().is_multiple_of(columns)) {
                return Err("whole rows of as many columns as the matrix says");
            }
        }
        self.text.clear();
        Ok(())
    }

    fn finish(self) -> Attribute {
        let value = match (self.list, self.columns) {
            (false, _) => Value::Text(self.text.trim().to_owned()),
            (true, None) => Value::Array(self.values),
            (true, Some(columns)) => Value::Matrix { columns, values: self.values },
        };
        Attribute { id: self.id, unit: self.unit, value, offset: self.offset }
    }
}
