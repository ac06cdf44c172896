//! Gears that files describe: read for `gear`, and held against the gear of a job.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{
    content::{notices, unreadable},
    listed::{FileTraceBody, FileValueBody, of_model},
};
use crate::api::{
    faults::Faults,
    gears::gear::{GearBody, GearToolBody},
    json::writer,
    problem::Problem,
    warning::WarningBody,
};
use flankfit_engine::{
    formats::{
        Datum, Difference, GearFacts, Notes,
        gear_file::{self, GearFile},
    },
    gear::{Gear, GearData, Hand, Side},
};

/// Gears in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearsOfFile)]
pub struct GearsOfFileBody {
    pub format: FileFormatName,
    /// In the order of the file.
    pub gears: Vec<GearOfFileBody>,
    /// For curves and models: every trace, in the order of the file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub traces: Vec<FileTraceBody>,
    /// Flanks with a table of pitches that an import stores.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pitches: Vec<Side>,
    /// For values: every one that the file prints, in its order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<FileValueBody>,
    /// Warnings about the file.
    pub warnings: Vec<WarningBody>,
}

/// Format of a file, by its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = GearFileFormat)]
pub enum FileFormatName {
    /// Klingelnberg `.mka`.
    Curves,
    /// Klingelnberg `.mew`.
    Values,
    /// REXS 1.x or 2.x, as XML, JSON or ZIP archive.
    Rexs,
}

/// A gear of a file.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearOfFile)]
pub struct GearOfFileBody {
    /// For a REXS model: the id of its component, which an import calls `component`.
    pub id: Option<String>,
    /// Name in the file; absent without one.
    pub name: Option<String>,
    /// The gear in the form of a job; absent if the file has too few data or impossible ones.
    pub gear: Option<GearBody>,
    /// Data in the file, if they are incomplete.
    pub known: Option<GearFactsBody>,
    /// Names of the missing data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// Flanks with a topography that can be imported.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub topographies: Vec<Side>,
}

/// Data of a gear, as far as a file gives them.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearFacts)]
pub struct GearFactsBody {
    /// Number of teeth z.
    pub teeth: Option<u32>,
    /// Normal module m_n.
    pub normal_module_mm: Option<f64>,
    /// Normal pressure angle α_n.
    pub normal_pressure_angle_deg: Option<f64>,
    /// Helix angle β, without its sign.
    pub helix_angle_deg: Option<f64>,
    /// Hand of a helical gear.
    pub hand: Option<Hand>,
    /// Profile shift coefficient x.
    pub profile_shift_coefficient: Option<f64>,
    /// Face width b.
    pub face_width_mm: Option<f64>,
    /// Tip diameter d_a.
    pub tip_diameter_mm: Option<f64>,
    /// Root diameter d_f.
    pub root_diameter_mm: Option<f64>,
    /// True if teeth point inwards.
    pub internal: Option<bool>,
}

impl From<&GearFacts> for GearFactsBody {
    fn from(facts: &GearFacts) -> Self {
        GearFactsBody {
            teeth: facts.teeth,
            normal_module_mm: facts.normal_module,
            normal_pressure_angle_deg: facts.pressure_angle.map(degrees),
            helix_angle_deg: facts.helix_angle.map(degrees),
            hand: facts.hand,
            profile_shift_coefficient: facts.profile_shift,
            face_width_mm: facts.face_width,
            tip_diameter_mm: facts.tip_diameter,
            root_diameter_mm: facts.root_diameter,
            internal: facts.internal,
        }
    }
}

/// Answers the gears of a file. Processor work.
pub fn answer(content: &[u8], name: Option<&str>) -> Result<Vec<u8>, Problem> {
    writer::whole(&read(content, name)?).map_err(Problem::not_finite)
}

/// Reads the gears of a file.
pub fn read(content: &[u8], name: Option<&str>) -> Result<GearsOfFileBody, Problem> {
    let (mut warnings, mut traces, mut pitches, mut values) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (format, gears) = match gear_file::read(content, name, None).map_err(|error| unreadable(&error))? {
        GearFile::Curves(curves) => {
            traces = curves.curves.iter().map(FileTraceBody::from).collect();
            pitches = curves.pitch.iter().filter_map(|table| table.side).collect();
            (FileFormatName::Curves, vec![of_header(|notes| curves.gear(notes), &mut warnings)])
        }
        GearFile::Values(file) => {
            values = file.results.iter().map(FileValueBody::from).collect();
            (FileFormatName::Values, vec![of_header(|notes| file.gear(notes), &mut warnings)])
        }
        GearFile::Model(model) => {
            warnings.extend(notices(&model.notes));
            let flanks = model.gears.iter().flat_map(|found| &found.flanks);
            traces = flanks.flat_map(|flank| flank.traces.iter().map(|trace| of_model(trace, flank.side))).collect();
            let each = model.gears.iter().map(|found| GearOfFileBody {
                id: Some(found.id.clone()),
                name: found.name.clone(),
                topographies: found
                    .flanks
                    .iter()
                    .filter(|flank| flank.topography.is_some() || !flank.scattered.is_empty())
                    .map(|flank| flank.side)
                    .collect(),
                ..of_facts(&found.facts, &found.id, &mut warnings)
            });
            (FileFormatName::Rexs, each.collect())
        }
        GearFile::Table(_) => {
            let detail = "a table of nodes or points has no gear; read it with `POST /v1/nodes/read`";
            return Err(Problem::invalid(Faults::one("/file", detail)));
        }
    };
    Ok(GearsOfFileBody { format, gears, traces, pitches, values, warnings })
}

/// Returns the field of a gear for a datum.
fn name(datum: Datum) -> &'static str {
    match datum {
        Datum::Teeth => "teeth",
        Datum::NormalModule => "normal_module_mm",
        Datum::PressureAngle => "normal_pressure_angle_deg",
        Datum::HelixAngle => "helix_angle_deg",
        Datum::Hand => "hand",
        Datum::ProfileShift => "profile_shift_coefficient",
        Datum::FaceWidth => "face_width_mm",
        Datum::TipDiameter => "tip_diameter_mm",
        Datum::RootDiameter => "root_diameter_mm",
        Datum::Internal => "internal",
    }
}

fn of_header(gear: impl FnOnce(&mut Notes) -> GearFacts, warnings: &mut Vec<WarningBody>) -> GearOfFileBody {
    let mut notes = Notes::default();
    let facts = gear(&mut notes);
    warnings.extend(notices(&notes));
    of_facts(&facts, "the file", warnings)
}

fn of_facts(facts: &GearFacts, called: &str, warnings: &mut Vec<WarningBody>) -> GearOfFileBody {
    let (mut gear, mut missing) = (None, Vec::new());
    match facts.gear_data() {
        Err(lacks) => missing = lacks.iter().map(|datum| name(*datum).to_owned()).collect(),
        Ok(data) => match Gear::new(data.clone()) {
            Ok(_) => gear = Some(GearBody::from(&data)),
            Err(faults) => {
                for fault in Faults::from(faults).list() {
                    let message = format!("gear of {called}: {}: {}", fault.pointer, fault.detail);
                    warnings.push(WarningBody::new("impossible_gear", &message));
                }
            }
        },
    }
    let known = gear.is_none().then(|| GearFactsBody::from(facts)).filter(|known| *known != GearFactsBody::default());
    GearOfFileBody { id: None, name: None, gear, known, missing, topographies: Vec::new() }
}

impl From<&GearData> for GearBody {
    fn from(data: &GearData) -> Self {
        GearBody {
            teeth: data.teeth,
            normal_module_mm: data.normal_module,
            normal_pressure_angle_deg: Some(degrees(data.pressure_angle)),
            helix_angle_deg: Some(degrees(data.helix_angle)),
            hand: (data.helix_angle > 0.0).then_some(data.hand),
            profile_shift_coefficient: Some(data.profile_shift + 0.0),
            face_width_mm: data.face_width,
            tip_diameter_mm: data.tip_diameter,
            root_diameter_mm: data.root_diameter,
            internal: data.internal.then_some(true),
            tool: data.tool.as_ref().map(|tool| GearToolBody {
                tip_radius_mm: Some(tool.tip_radius),
                addendum_factor: Some(tool.addendum_factor),
                protuberance_mm: Some(tool.protuberance),
            }),
        }
    }
}

/// Degrees whose radians are these, in as few digits as that takes: 20, not 20.000000000000004.
fn degrees(angle: f64) -> f64 {
    let exact = angle.to_degrees();
    let shorter = (0..15).map(|digits| format!("{exact:.digits$}").parse::<f64>().unwrap_or(exact));
    shorter.into_iter().find(|short| short.to_radians() == angle).unwrap_or(exact)
}

/// The gear of a file's traces: `own` (asked for with the file, or that of the job), else the one
/// that the file describes. A file of another gear than the job's is refused; one that differs in
/// details, or from a gear asked for, is a warning.
pub(in crate::api) fn chosen(
    facts: &GearFacts,
    own: Option<&Gear>,
    asked: bool,
    warnings: &mut Vec<WarningBody>,
) -> Result<Gear, Problem> {
    let Some(gear) = own else {
        let data = facts.gear_data().map_err(|missing| {
            let names: Vec<_> = missing.iter().map(|datum| name(*datum)).collect();
            let detail = format!("the file does not give {}; send `gear`, or add it to the job", names.join(", "));
            Problem::invalid(Faults::one("/spec/gear", detail))
        })?;
        return Gear::new(data).map_err(|faults| Problem::invalid(Faults::of_engine("/file", &faults)));
    };
    let mut faults = Faults::default();
    for Difference { datum, file, gear, another } in facts.differences(gear.data()) {
        let name = name(datum);
        let whose = if asked { "the gear given" } else { "the job's gear" };
        if another && !asked {
            let detail = format!(
                "another gear: `{name}` is {file} in the file and {gear} in the job; send `gear` in `spec` to import \
                 it anyway"
            );
            faults.push("/file", detail);
        } else {
            let message = format!("`{name}` is {file} in the file and {gear} in {whose}, which is used");
            warnings.push(WarningBody::new("gear_differs", &message));
        }
    }
    faults.into_result(gear.clone()).map_err(Problem::invalid)
}
