//! Files of gear testers: what they hold, evaluated, and as nodes of an iteration.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    evaluate::EvaluationBody,
    evaluate_request::{DeviationSignName, EvaluationSettingsBody, SignName},
    gear::GearBody,
    notice::NoticeBody,
    trace::SideName,
};
use crate::{
    api::problem::Problem,
    estimation::{Faults, Nodes},
    formats::{
        FileError, Notes,
        gear_file::{self, GearFile},
        klingelnberg::{Curves, ProfileAxis, Range, Sense, SliceOf},
        points::ListedPoint,
    },
    gear::{
        Gear, Kind, Side, Trace,
        deviation::{self, Measurement, Reference, Strays, Touch},
        evaluation::{self, Posted},
    },
};

/// What is said of a file beside it: the part `spec` of the form.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = ImportSpec)]
pub struct ImportSpecBody {
    /// In place of the job's gear, which goes before that of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gear: Option<GearBody>,
    /// The tooth whose traces become nodes. By default the one with the most of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tooth: Option<String>,
    /// The flank whose traces become nodes. Default `left`, where it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flank: Option<SideName>,
    /// How traces are evaluated. Ranges and reference lengths that are left out are those of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluation: Option<EvaluationSettingsBody>,
    /// Of points that are centres of a ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe_radius_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// A file, read.
pub struct FileRead {
    pub gear: Gear,
    /// Signs as DIN has them.
    pub traces: Vec<Trace>,
    /// Of the traces, where there are any.
    pub evaluation: Option<EvaluationBody>,
    /// Nodes with u = roll length and v = z (mm), heights in µm along the normal, positive where material stands out; with what they are of.
    pub nodes: Vec<FlankNodes>,
    pub warnings: Vec<NoticeBody>,
}

/// Nodes of one flank.
pub struct FlankNodes {
    pub tooth: String,
    pub side: Side,
    /// Traces, or 0 for points.
    pub traces: usize,
    /// (roll length, z, deviation); undefined ones are left out.
    pub places: Vec<[f64; 3]>,
}

/// Reads a file; `own` is the gear of the job that it belongs to. Processor work.
pub fn read(bytes: &[u8], name: Option<&str>, spec: &ImportSpecBody, own: Option<&Gear>) -> Result<FileRead, Problem> {
    let asked = spec.gear.as_ref().map(|gear| gear.checked("/spec/gear")).transpose().map_err(Problem::invalid)?;
    let own = asked.as_ref().or(own);
    match gear_file::read(bytes, name).map_err(|error| unreadable(&error))? {
        GearFile::Curves(curves) => of_curves(&curves, spec, own),
        GearFile::Points(points) => of_points(&points, spec, own),
        GearFile::Values(values) => Err(nothing_measured(&format!(
            "a file of {} results; import the file of curves (.mka) that they were made of",
            values.results.len()
        ))),
        GearFile::Model(model) => Err(nothing_measured(&format!(
            "a REXS model of {} gears and no curves; put its data into the `gear` of the job",
            model.gears.len()
        ))),
    }
}

/// What cannot be read, with line and column.
pub fn unreadable(error: &FileError) -> Problem {
    Problem::invalid(Faults::one("/file", error.to_string()))
}

fn nothing_measured(what: &str) -> Problem {
    Problem::invalid(Faults::one("/file", format!("nothing to make nodes of: {what}")))
}

fn of_curves(curves: &Curves, spec: &ImportSpecBody, own: Option<&Gear>) -> Result<FileRead, Problem> {
    let mut notes = curves.notes.clone();
    let facts = curves.header.gear(&mut notes);
    let gear = match own {
        Some(gear) => gear.clone(),
        None => {
            let data = facts.gear_data().map_err(|missing| {
                let names: Vec<_> = missing.iter().map(|datum| datum.as_str()).collect();
                let detail = format!("the file does not say {}; give `gear`, or give it to the job", names.join(", "));
                Problem::invalid(Faults::one("/spec/gear", detail))
            })?;
            Gear::new(data).map_err(|faults| Problem::invalid(faults.moved(|pointer| format!("/file{pointer}"))))?
        }
    };
    let mut warnings = told(&notes);
    let signs = curves.signs();
    for (kind, word) in [(Kind::Profile, "profiles"), (Kind::Helix, "helices")] {
        if !signs.is_known(kind) && curves.curves.iter().any(|curve| curve.kind == kind) {
            let message = format!("the file's settings of signs are not known; those of DIN are assumed for {word}");
            warnings.push(NoticeBody::new("sign_assumed", &message));
        }
    }
    let placed = curves.place(&gear).with_sense(signs, Sense::Din);
    for lost in &placed.unplaced {
        let message = format!("line {}: the trace of tooth {} has no positions: {}", lost.line, lost.tooth, lost.why);
        warnings.push(NoticeBody::new("trace_without_positions", &message));
    }
    let traces: Vec<Trace> = placed.traces.into_iter().map(|placed| placed.trace).collect();
    let settings = settings(curves, &gear, spec.evaluation.clone().unwrap_or_default());
    let evaluation = evaluated(&gear, &traces, &settings, &mut warnings);
    let to_normal = match curves.header.rules().section {
        Some(SliceOf::Normal) => 1.0,
        _ => gear.base_helix_angle().cos(),
    };
    let nodes = nodes_of(&gear, &traces, &settings, to_normal);
    Ok(FileRead { gear, traces, evaluation, nodes, warnings })
}

/// Ranges and lengths of the file where the caller left them out; deviations have the sign of DIN.
fn settings(curves: &Curves, gear: &Gear, mut asked: EvaluationSettingsBody) -> EvaluationSettingsBody {
    let (profile, helix) = (curves.header.profile_setup(), curves.header.helix_setup());
    let rules = curves.header.rules();
    let diameter = |x: f64| match profile.axis {
        ProfileAxis::Diameter => Some(x),
        ProfileAxis::RollLength => Some(gear.diameter(x)),
        ProfileAxis::RollAngle => Some(gear.diameter(x.to_radians() * gear.base_radius())),
        ProfileAxis::Unknown(_) => None,
    };
    let ascending = |Range { start, end }: Range| [start.min(end), start.max(end)];
    if asked.profile_diameter_range_mm.is_none() {
        asked.profile_diameter_range_mm = profile
            .evaluated
            .left
            .or(profile.evaluated.right)
            .map(ascending)
            .and_then(|[low, high]| Some([diameter(low)?, diameter(high)?]));
    }
    if asked.helix_range_mm.is_none() {
        asked.helix_range_mm = helix.evaluated.left.or(helix.evaluated.right).map(ascending);
    }
    if asked.profile_reference_length_mm.is_none() && asked.profile_reference.is_none() {
        let length = rules.profile_length.length;
        asked.profile_reference_length_mm = length.left.or(length.right).filter(|length| *length > 0.0);
    }
    if asked.helix_reference_length_mm.is_none() && asked.helix_reference.is_none() {
        let length = rules.helix_length.length;
        asked.helix_reference_length_mm = length.left.or(length.right).filter(|length| *length > 0.0);
    }
    asked.sign = asked.sign.or(Some(SignName::Din));
    asked.deviation_sign = Some(DeviationSignName::Din);
    asked
}

fn evaluated(
    gear: &Gear,
    traces: &[Trace],
    settings: &EvaluationSettingsBody,
    warnings: &mut Vec<NoticeBody>,
) -> Option<EvaluationBody> {
    if traces.is_empty() {
        return None;
    }
    let posted: Vec<Posted<'_>> = traces.iter().map(|trace| Posted { trace, design: None }).collect();
    match evaluation::evaluate(gear, &posted, &settings.settings()) {
        Ok(found) => {
            let explicit = settings.explicit(&found);
            Some(EvaluationBody::new(found, explicit))
        }
        Err(faults) => {
            let why: Vec<String> =
                faults.list().iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect();
            warnings.push(NoticeBody::new("not_evaluated", &why.join("; ")));
            None
        }
    }
}

/// Traces whose section is known, tooth by tooth (letters aside) and flank by flank, the one with most traces first: the samples of the
/// evaluation range, for what lies beyond (the rounding of the tip) is no matter of the flank. `to_normal` turns deviations into those along
/// the normal.
fn nodes_of(gear: &Gear, traces: &[Trace], settings: &EvaluationSettingsBody, to_normal: f64) -> Vec<FlankNodes> {
    let rolls = settings.profile_diameter_range_mm.and_then(|[low, high]| {
        let [low, high] = [gear.roll_length(low)?, gear.roll_length(high)?];
        Some([low.min(high), low.max(high)])
    });
    let within = |x: f64, range: Option<[f64; 2]>| {
        range.is_none_or(|[low, high]| low - evaluation::EDGE <= x && x <= high + evaluation::EDGE)
    };
    let mut flanks: BTreeMap<(String, Side), FlankNodes> = BTreeMap::new();
    for trace in traces {
        let Some(section) = trace.section else { continue };
        let tooth = evaluation::Position::split(&trace.tooth).0.to_owned();
        // DIN's helices are positive where the flank is turned counterclockwise
        let (fixed, sign) = match trace.kind {
            Kind::Profile => (Some(section), 1.0),
            Kind::Helix => (gear.roll_length(section), trace.side.sign()),
        };
        let Some(fixed) = fixed else { continue };
        let flank = flanks.entry((tooth.clone(), trace.side)).or_insert_with(|| FlankNodes {
            tooth,
            side: trace.side,
            traces: 0,
            places: Vec::new(),
        });
        flank.traces += 1;
        let range = if trace.kind == Kind::Profile { rolls } else { settings.helix_range_mm };
        let each = trace.at.iter().zip(&trace.deviation);
        let each = each.filter(|(at, deviation)| deviation.is_finite() && within(**at, range));
        let scale = sign * to_normal;
        flank.places.extend(each.map(|(at, deviation)| match trace.kind {
            Kind::Profile => [*at, fixed, scale * deviation],
            Kind::Helix => [fixed, *at, scale * deviation],
        }));
    }
    let mut flanks: Vec<FlankNodes> = flanks.into_values().filter(|flank| !flank.places.is_empty()).collect();
    flanks.sort_by_key(|flank| std::cmp::Reverse(flank.traces));
    flanks
}

fn of_points(points: &[ListedPoint], spec: &ImportSpecBody, own: Option<&Gear>) -> Result<FileRead, Problem> {
    let Some(gear) = own else {
        let detail = "missing: points say nothing of their gear; give `gear`, or give it to the job";
        return Err(Problem::invalid(Faults::one("/spec/gear", detail)));
    };
    let touch = |listed: &ListedPoint| Touch { normal: listed.direction, ..Touch::anywhere(listed.point) };
    let touches: Vec<Touch> = points.iter().map(touch).collect();
    let measurement = Measurement {
        ball_radius: spec.probe_radius_mm.unwrap_or(0.0),
        strays: Strays::Undefined,
        ..Measurement::default()
    };
    let reference = Reference::new(gear);
    let deviations = deviation::measure(&reference, &touches, &measurement).map_err(|faults| {
        Problem::invalid(faults.moved(|pointer| match pointer {
            "/probe_radius_mm" => "/spec/probe_radius_mm".to_owned(),
            other => format!("/file{other}"),
        }))
    })?;
    let mut warnings = Vec::new();
    for (index, stray) in &deviations.strays {
        let message = format!("line {}: {stray}", points[*index].line);
        warnings.push(NoticeBody::new("stray_point", &message));
    }
    let mut nodes: Vec<FlankNodes> = deviations
        .flanks()
        .into_iter()
        .map(|flank| FlankNodes {
            tooth: flank.tooth.to_string(),
            side: flank.side,
            traces: 0,
            places: (0..flank.z.len()).map(|k| [flank.roll_length[k], flank.z[k], flank.deviation[k]]).collect(),
        })
        .collect();
    nodes.sort_by_key(|flank| std::cmp::Reverse(flank.places.len()));
    if nodes.is_empty() {
        return Err(nothing_measured("no point lies on a flank of this gear"));
    }
    Ok(FileRead { gear: gear.clone(), traces: Vec::new(), evaluation: None, nodes, warnings })
}

fn told(notes: &Notes) -> Vec<NoticeBody> {
    let each = notes.list().iter();
    each.map(|note| NoticeBody::new(note.code.as_str(), &format!("line {}: {}", note.line, note.text))).collect()
}

impl FileRead {
    /// The flank that was asked for, or the one with the most nodes, the left one before the right.
    pub fn flank(&self, spec: &ImportSpecBody) -> Result<&FlankNodes, Problem> {
        let fits = |flank: &&FlankNodes| {
            spec.tooth.as_ref().is_none_or(|tooth| *tooth == flank.tooth)
                && spec.flank.is_none_or(|side| Side::from(side) == flank.side)
        };
        self.nodes.iter().find(fits).ok_or_else(|| {
            let known: Vec<String> =
                self.nodes.iter().map(|flank| format!("{} {}", flank.tooth, word(flank.side))).collect();
            let detail = if known.is_empty() {
                "no trace has a known place on a flank".to_owned()
            } else {
                format!("there are {}", known.join(", "))
            };
            let pointer = if spec.tooth.is_some() { "/spec/tooth" } else { "/spec/flank" };
            Problem::invalid(Faults::one(pointer, detail))
        })
    }
}

impl FlankNodes {
    /// As nodes of a fit; along the one coordinate that varies where all lie on one line.
    pub fn nodes(&self) -> Result<Nodes, Problem> {
        let column = |c: usize| self.places.iter().map(|place| place[c]).collect::<Vec<f64>>();
        let varies = |c: usize| self.places.iter().any(|place| place[c] != self.places[0][c]);
        let nodes = match (varies(0), varies(1)) {
            (true, false) => Nodes::curve(column(0), column(2), None),
            (false, true) => Nodes::curve(column(1), column(2), None),
            _ => Nodes::scattered(column(0), column(1), column(2), None),
        };
        nodes.map_err(|faults| Problem::invalid(faults.moved(|_| "/file".to_owned())))
    }

    /// The degrees of the surface that the traces tell, of second order at most: a plain cross of one profile and one lead has no mixed term,
    /// which a surface of total degree 2 would ask for.
    pub fn order(&self) -> usize {
        // the value that most places share
        let crowded = |c: usize| {
            let mut values: Vec<f64> = self.places.iter().map(|place| place[c]).collect();
            values.sort_by(f64::total_cmp);
            values.chunk_by(|a, b| a == b).max_by_key(|run| run.len()).map(|run| (run[0], run.len() == values.len()))
        };
        let (Some((line_u, only_u)), Some((line_v, only_v))) = (crowded(0), crowded(1)) else { return 2 };
        // a place off the cross of the lines that most places lie on
        let off = |place: &[f64; 3]| place[0] != line_u && place[1] != line_v;
        if only_u || only_v || self.places.iter().any(off) { 2 } else { 1 }
    }
}

/// As messages call it.
pub fn word(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}
