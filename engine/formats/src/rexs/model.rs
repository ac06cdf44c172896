//! Gears of a document.

use std::collections::HashMap;

use super::{
    super::{
        file_error::{FileError, shown},
        gear_facts::{GearFacts, radians, teeth},
        note::{Notes, Remark},
        source::{number, place_in},
        topography::Topography,
    },
    document::{Attribute, Component, Document, GEARS, Value},
    topography::{Shape, shape},
};
use flankfit_gear::{Kind, Side};

/// A deviation somewhere on a flank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatteredDeviation {
    /// mm.
    pub diameter: f64,
    /// Place on the face width, mm.
    pub z: f64,
    /// µm with the sign stored.
    pub deviation: f64,
}

/// Places along a trace, mm.
#[derive(Clone, Debug, PartialEq)]
pub enum TracePlaces {
    /// Diameters of a profile.
    Diameters(Vec<f64>),
    /// Roll lengths of a profile.
    RollLengths(Vec<f64>),
    /// Coordinates of a helix on the face width.
    Z(Vec<f64>),
}

/// A measured trace of a flank.
#[derive(Clone, Debug, PartialEq)]
pub struct RexsTrace {
    /// Id of its component.
    pub id: String,
    /// Places of its deviations.
    pub places: TracePlaces,
    /// z of a profile, diameter of a helix, mm.
    pub section: Option<f64>,
    /// Deviations in µm, with the sign stored.
    pub deviation: Vec<f64>,
    /// Line in the file, from 1.
    pub line: usize,
}

impl RexsTrace {
    /// Returns whether it is a profile or a helix.
    pub fn kind(&self) -> Kind {
        match self.places {
            TracePlaces::Diameters(_) | TracePlaces::RollLengths(_) => Kind::Profile,
            TracePlaces::Z(_) => Kind::Helix,
        }
    }
}

/// A flank of a gear.
#[derive(Clone, Debug, PartialEq)]
pub struct RexsFlank {
    /// Id of its component.
    pub id: String,
    /// Flank of the tooth.
    pub side: Side,
    /// α_n, rad.
    pub pressure_angle: Option<f64>,
    /// Profile shift coefficient x.
    pub profile_shift: Option<f64>,
    /// Deviations on a grid; `None` where the flank has none.
    pub topography: Option<Topography>,
    /// Deviations that fill no grid.
    pub scattered: Vec<ScatteredDeviation>,
    /// Measured profiles and helices.
    pub traces: Vec<RexsTrace>,
}

/// A gear of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct RexsGear {
    /// Id of its component.
    pub id: String,
    /// Name of the gear, where the model has one.
    pub name: Option<String>,
    /// The gear's data, as far as they are given.
    pub facts: GearFacts,
    /// Left before right; those that the model has.
    pub flanks: Vec<RexsFlank>,
    /// Line in the file, from 1.
    pub line: usize,
}

/// The gears of a model, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct RexsModel {
    /// `1.4`
    pub version: String,
    /// Cylindrical gears.
    pub gears: Vec<RexsGear>,
    /// Remarks about lines that were read in spite of them.
    pub notes: Notes,
}

/// Quantity of an attribute.
#[derive(Clone, Copy)]
enum Quantity {
    Number,
    Length,
    Angle,
}

impl RexsModel {
    pub(super) fn of(text: &str, document: Document) -> Result<Self, FileError> {
        let mut reader = Reader { text, notes: Notes::default() };
        let by_id = document.components.iter().rev().map(|component| (component.id.as_str(), component)).collect();
        let mut sides: HashMap<&str, [Option<&Component>; 2]> = HashMap::new();
        let by_id: HashMap<&str, &Component> = by_id;
        let mut measured: HashMap<&str, Vec<&Component>> = HashMap::new();
        for relation in &document.relations {
            let part = |role: &str| relation.part(role).and_then(|id| by_id.get(id)).copied();
            match (relation.kind.as_str(), part("gear"), part("origin"), part("referenced")) {
                ("flank", Some(gear), ..) if GEARS.contains(&gear.kind.as_str()) => {
                    for side in ["left", "right"] {
                        if let Some(id) = relation.part(side).filter(|id| !by_id.contains_key(id)) {
                            let line = place_in(text, gear.offset).line;
                            let (gear, flank) = (shown(&gear.id), shown(id));
                            reader.notes.push(line, Remark::FlankNotRead { side, gear, flank });
                        }
                    }
                    sides.insert(&gear.id, [part("left"), part("right")]);
                }
                ("reference", _, Some(flank), Some(trace)) => measured.entry(&flank.id).or_default().push(trace),
                _ => {}
            }
        }
        let mut gears = Vec::new();
        for component in document.components.iter().filter(|component| GEARS.contains(&component.kind.as_str())) {
            let flanks = sides.get(component.id.as_str()).copied().unwrap_or_default();
            gears.push(reader.gear(component, flanks, &measured)?);
        }
        if gears.is_empty() {
            reader.notes.push(1, Remark::NoCylindricalGear);
        }
        Ok(RexsModel { version: document.version, gears, notes: reader.notes })
    }

    /// The gear with an id, or the only one. The errors list the ids there are.
    pub fn gear(&self, id: Option<&str>) -> Result<&RexsGear, FileError> {
        let ids = || self.gears.iter().map(|gear| gear.id.clone()).collect();
        match (id, self.gears.as_slice()) {
            (_, []) => Err(FileError::NoGear),
            (None, [gear]) => Ok(gear),
            (None, _) => Err(FileError::SeveralGears { ids: ids() }),
            (Some(id), gears) => gears
                .iter()
                .find(|gear| gear.id == id)
                .ok_or_else(|| FileError::NoSuchGear { id: id.into(), ids: ids() }),
        }
    }
}

struct Reader<'a> {
    text: &'a str,
    notes: Notes,
}

impl Reader<'_> {
    fn gear(
        &mut self,
        component: &Component,
        flanks: [Option<&Component>; 2],
        measured: &HashMap<&str, Vec<&Component>>,
    ) -> Result<RexsGear, FileError> {
        let line = place_in(self.text, component.offset).line;
        let mut read = Vec::new();
        for (flank, side) in flanks.into_iter().zip([Side::Left, Side::Right]) {
            if let Some(flank) = flank {
                let traces = measured.get(flank.id.as_str()).map(Vec::as_slice).unwrap_or_default();
                read.push(self.flank(flank, side, traces)?);
            }
        }
        let number = |names: &[&str], quantity| self.value(component, names, quantity);
        const ANGLES: [&str; 2] = ["helix_angle_reference_diameter", "helix_angle"];
        let mut facts = GearFacts {
            normal_module: number(&["normal_module"], Quantity::Length)?,
            face_width: number(&["face_width", "facewidth"], Quantity::Length)?,
            tip_diameter: number(&["tip_diameter"], Quantity::Length)?,
            root_diameter: number(&["root_diameter"], Quantity::Length)?,
            pressure_angle: number(&["normal_pressure_angle"], Quantity::Angle)?,
            profile_shift: number(
                &["profile_shift_coefficient", "addendum_modification_coefficient"],
                Quantity::Number,
            )?,
            internal: Some(component.kind == "ring_gear"),
            ..GearFacts::default()
        };
        if let Some(angle) = number(&ANGLES, Quantity::Angle)? {
            facts.set_helix_angle(angle);
            facts.hand = facts.hand.or((angle > 0.0).then_some(flankfit_gear::Hand::Right));
        }
        if let Some(value) = number(&["number_of_teeth"], Quantity::Number)? {
            let offset = component.attribute(&["number_of_teeth"]).map_or(component.offset, |a| a.offset);
            let found = value.to_string();
            let fault = || self.fault(offset, "a whole number of teeth other than 0", &found);
            facts.teeth = Some(teeth(value).ok_or_else(fault)?);
            if value < 0.0 {
                facts.internal = Some(true);
            }
        }
        // a gear in one value, where the file has it for each flank
        let both = |of: fn(&RexsFlank) -> Option<f64>| {
            let mut values = read.iter().filter_map(of);
            let first = values.next();
            (first, values.next().is_some_and(|other| Some(other) != first))
        };
        for (fact, (value, differs), name) in [
            (&mut facts.pressure_angle, both(|flank| flank.pressure_angle), "pressure angles"),
            (&mut facts.profile_shift, both(|flank| flank.profile_shift), "profile shifts"),
        ] {
            if fact.is_none() && differs {
                self.notes.push(line, Remark::FlanksDiffer { gear: shown(&component.id), figures: name });
            } else if fact.is_none() {
                *fact = value;
            }
        }
        Ok(RexsGear { id: component.id.clone(), name: component.name.clone(), facts, flanks: read, line })
    }

    fn flank(&mut self, component: &Component, side: Side, traces: &[&Component]) -> Result<RexsFlank, FileError> {
        let (topography, scattered) = self.topography(component, side)?;
        let each = traces.iter().map(|trace| self.trace(trace)).collect::<Result<Vec<_>, _>>()?;
        const SHIFTS: [&str; 2] = ["profile_shift_coefficient", "addendum_modification_coefficient"];
        Ok(RexsFlank {
            id: component.id.clone(),
            side,
            pressure_angle: self.value(component, &["normal_pressure_angle"], Quantity::Angle)?,
            profile_shift: self.value(component, &SHIFTS, Quantity::Number)?,
            topography,
            scattered,
            traces: each.into_iter().flatten().collect(),
        })
    }

    /// Reads a measured profile or helix; `None` for a component without amounts.
    fn trace(&self, component: &Component) -> Result<Option<RexsTrace>, FileError> {
        let profile = component.kind == "profile_deviation";
        let name = if profile { "profile_deviation_amounts" } else { "helix_deviation_amounts" };
        let Some(amounts) = component.attribute(&[name]) else { return Ok(None) };
        let (diameters, lengths) = (["diameters_of_profile_deviation"], ["length_of_profile_deviation"]);
        let places = if !profile {
            TracePlaces::Z(self.list(component, &["coordinates_of_helix_deviation"], amounts)?)
        } else if component.attribute(&lengths).is_some() {
            TracePlaces::RollLengths(self.list(component, &lengths, amounts)?)
        } else {
            TracePlaces::Diameters(self.list(component, &diameters, amounts)?)
        };
        let section = if profile { "position_of_profile_deviation" } else { "diameter_of_helix_deviation" };
        let scale = 1000.0 * self.scale(amounts, Quantity::Length)?;
        let (TracePlaces::Z(at) | TracePlaces::RollLengths(at) | TracePlaces::Diameters(at)) = &places;
        let deviation: Vec<f64> = match &amounts.value {
            Value::Array(values) if values.len() == at.len() => values.iter().map(|amount| scale * amount).collect(),
            _ => return Err(self.fault(amounts.offset, "one amount for each place of the trace", &amounts.id)),
        };
        Ok(Some(RexsTrace {
            id: component.id.clone(),
            places,
            section: self.value(component, &[section], Quantity::Length)?,
            deviation,
            line: place_in(self.text, component.offset).line,
        }))
    }

    fn topography(
        &mut self,
        component: &Component,
        side: Side,
    ) -> Result<(Option<Topography>, Vec<ScatteredDeviation>), FileError> {
        const DIAMETERS: [&str; 2] = ["diameters_of_topographical_deviation", "diameters_of_topographical_deviations"];
        const COORDINATES: [&str; 2] =
            ["coordinates_of_topographical_deviation", "coordinates_of_topographical_deviations"];
        let Some(amounts) = component.attribute(&["topographical_deviation_amounts"]) else {
            return Ok((None, Vec::new()));
        };
        let diameters = self.list(component, &DIAMETERS, amounts)?;
        let coordinates = self.list(component, &COORDINATES, amounts)?;
        let scale = 1000.0 * self.scale(amounts, Quantity::Length)?;
        let shape = shape(&amounts.value, &diameters, &coordinates)
            .map_err(|expected| self.fault(amounts.offset, expected, "other lists"))?;
        let line = place_in(self.text, amounts.offset).line;
        match shape {
            Shape::Grid { diameter, z, amounts, assumed } => {
                if assumed {
                    self.notes.push(line, Remark::OrderAssumed);
                }
                let deviation = amounts.iter().map(|amount| scale * amount).collect();
                Ok((Some(Topography { tooth: None, side, diameter, z, deviation }), Vec::new()))
            }
            Shape::Scattered(points) => {
                self.notes.push(line, Remark::NotAGrid);
                let scattered =
                    |[diameter, z, amount]: [f64; 3]| ScatteredDeviation { diameter, z, deviation: scale * amount };
                Ok((None, points.into_iter().map(scattered).collect()))
            }
        }
    }

    /// A list of lengths that a topography cannot be without, mm.
    fn list(&self, component: &Component, names: &[&str], amounts: &Attribute) -> Result<Vec<f64>, FileError> {
        let attribute = component
            .attribute(names)
            .ok_or_else(|| self.fault(amounts.offset, "the places of these amounts", "amounts alone"))?;
        let scale = self.scale(attribute, Quantity::Length)?;
        match &attribute.value {
            Value::Array(values) | Value::Matrix { values, .. } if values.iter().all(|x| x.is_finite()) => {
                Ok(values.iter().map(|x| scale * x).collect())
            }
            _ => Err(self.fault(attribute.offset, "a list of numbers", &attribute.id)),
        }
    }

    /// The number of an attribute: mm, rad, or without unit. `None` if the component has no such
    /// attribute.
    fn value(&self, component: &Component, names: &[&str], quantity: Quantity) -> Result<Option<f64>, FileError> {
        let Some(attribute) = component.attribute(names) else { return Ok(None) };
        let found = match &attribute.value {
            Value::Text(text) => text.as_str(),
            _ => "a list",
        };
        let value = number(found).ok_or_else(|| self.fault(attribute.offset, "a number", found))?;
        if let (Quantity::Angle, true) = (quantity, in_degrees(&attribute.unit)) {
            return Ok(Some(radians(value)));
        }
        Ok(Some(value * self.scale(attribute, quantity)?))
    }

    /// Factor from the attribute's unit to mm or rad. Attributes without unit are in those of the
    /// specification, mm and degrees.
    fn scale(&self, attribute: &Attribute, quantity: Quantity) -> Result<f64, FileError> {
        let unit = attribute.unit.trim();
        let scale = match (quantity, unit) {
            (Quantity::Number, "" | "none" | "-" | "1") | (Quantity::Length, "" | "mm") | (Quantity::Angle, "rad") => {
                Some(1.0)
            }
            (Quantity::Length, "mum" | "um" | "µm" | "μm") => Some(1e-3),
            (Quantity::Length, "cm") => Some(10.0),
            (Quantity::Length, "m") => Some(1000.0),
            (Quantity::Length, "in" | "inch") => Some(25.4),
            (Quantity::Angle, unit) if in_degrees(unit) => Some(radians(1.0)),
            _ => None,
        };
        scale.ok_or_else(|| FileError::Unsupported {
            place: place_in(self.text, attribute.offset),
            what: format!("the unit {} of {}", shown(unit), attribute.id),
        })
    }

    fn fault(&self, offset: usize, expected: &'static str, found: &str) -> FileError {
        FileError::Expected { place: place_in(self.text, offset), expected, found: shown(found) }
    }
}

fn in_degrees(unit: &str) -> bool {
    matches!(unit.trim(), "" | "deg" | "°" | "none")
}
