//! Curves of a gear tester: evaluated, and as nodes of a flank.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    evaluate::EvaluationBody,
    evaluate_request::{DeviationSignName, EvaluationSettingsBody, SignName},
    file::{FileRead, FlankNodes, ImportSpecBody, told},
    file_gears,
    notice::NoticeBody,
};
use crate::{
    api::problem::Problem,
    formats::klingelnberg::{Curves, ProfileAxis, Range, Sense, SliceOf},
    gear::{
        Gear, Kind, Side, Trace,
        evaluation::{self, Position, Posted},
    },
};

/// Reads the traces of a file of curves.
pub(super) fn read(curves: &Curves, spec: &ImportSpecBody, own: Option<&Gear>) -> Result<FileRead, Problem> {
    let mut notes = curves.notes.clone();
    let facts = curves.header.gear(&mut notes);
    let mut warnings = Vec::new();
    let gear = file_gears::chosen(&facts, own, spec.gear.is_some(), &mut warnings)?;
    warnings.extend(told(&notes));
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
    let teeth = gear.data().teeth;
    let strange = |tooth: &str| Position::number(tooth).is_some_and(|number| !(1..=u64::from(teeth)).contains(&number));
    let strange: BTreeSet<&str> =
        curves.curves.iter().map(|curve| curve.tooth.as_str()).filter(|t| strange(t)).collect();
    if !strange.is_empty() {
        let named: Vec<&str> = strange.into_iter().take(10).collect();
        let message = format!("the gear has {teeth} teeth; none has the number of {}", named.join(", "));
        warnings.push(NoticeBody::new("unknown_tooth", &message));
    }
    let traces: Vec<Trace> = placed.traces.into_iter().map(|placed| placed.trace).collect();
    let settings = settings(curves, &gear, spec.evaluation.clone().unwrap_or_default());
    let evaluation = evaluated(&gear, &traces, &settings, &mut warnings);
    let to_normal = match curves.header.rules().section {
        Some(SliceOf::Normal) => 1.0,
        _ => gear.base_helix_angle().cos(),
    };
    let nodes = nodes_of(&gear, &traces, &settings, to_normal);
    let evaluation = evaluation.map(|mut found| {
        found.warnings.splice(0..0, warnings.iter().cloned());
        found
    });
    Ok(FileRead { gear, traces, evaluation, deviations: None, nodes, warnings })
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
        let tooth = Position::split(&trace.tooth).0.to_owned();
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
